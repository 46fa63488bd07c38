//! A chip of either family: its peripherals, and the bus to them.
//!
//! Words are accessed by address; their bits are read through the vendor's description (`stm32f4`, `stm32g4`), never
//! through the constants of the drivers. An access that would damage or hang a chip panics, with the section of the
//! reference manual: RM0090 where both families are alike.

use std::cell::{Cell, RefCell};

use drive_chip::Bus;
use drive_chip::bus::{Damage, Register};

use super::clocks::{Peripheral, Source};
use super::pins::{Level, Line, Mode};
use super::timers::Output;
use super::{clocks, memory, pins, supply, timers, usart, watchdog};
use crate::Family;
use crate::facts::TIM1_FUNCTION;
use crate::pac::Interrupt;

/// Duration of an access, ns.
const ACCESS: u64 = 1_000;

/// A chip after reset.
pub(crate) struct Chip {
    pub(crate) clocks: clocks::Clocks,
    pub(crate) pins: pins::Pins,
    pub(crate) timers: timers::Timers,
    pub(crate) usart: usart::Usart,
    pub(crate) watchdog: watchdog::Watchdog,
    pub(crate) memory: memory::Memory,
    pub(crate) supply: supply::Supply,
    nvic: Nvic,
    /// Every word written in order, but for the watchdog's food.
    written: RefCell<Vec<(u32, u32)>>,
    /// The signal on the PWM's pin after every write.
    outputs: RefCell<Vec<Output>>,
    alone: Cell<bool>,
    /// Barriers at which pending interrupts are taken.
    pub(crate) barriers: Cell<u32>,
    now: Cell<u64>,
    /// Happens once, after the next read of a timer.
    while_reading: Cell<Option<fn(&Chip)>>,
    /// Happens once, in the next step of the flash.
    in_a_step: Cell<Option<fn(&Chip)>>,
    damage: &'static Damage,
    /// It is in the interrupt that nothing masks.
    is_in_nmi: Cell<bool>,
}

struct Nvic {
    priorities: RefCell<[u8; 96]>,
    /// Interrupts with the priorities that they had when they were unmasked.
    unmasked: RefCell<Vec<(u16, u8)>>,
    pending: RefCell<Vec<u16>>,
    /// SysTick's control, reload value and current value, and the word of its priority.
    systick: [Cell<u32>; 3],
    system_priorities: Cell<u32>,
}

impl Chip {
    /// With a source at its oscillator pins.
    pub(crate) fn new(source: Source) -> Self {
        Self {
            clocks: clocks::Clocks::new(source),
            pins: pins::Pins::new(),
            timers: timers::Timers::new(),
            usart: usart::Usart::new(),
            watchdog: watchdog::Watchdog::new(),
            memory: memory::Memory::new(),
            supply: supply::Supply::new(),
            nvic: Nvic {
                priorities: RefCell::new([0; 96]),
                unmasked: RefCell::default(),
                pending: RefCell::default(),
                systick: Default::default(),
                system_priorities: Cell::new(0),
            },
            written: RefCell::default(),
            outputs: RefCell::default(),
            alone: Cell::new(false),
            barriers: Cell::new(0),
            now: Cell::new(0),
            while_reading: Cell::new(None),
            in_a_step: Cell::new(None),
            damage: Box::leak(Box::default()),
            is_in_nmi: Cell::new(false),
        }
    }

    /// A peripheral with a clock of its own, and its word at an address.
    fn peripheral(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        let found = self.pins.find(address);
        found
            .or_else(|| self.timers.find(address))
            .or_else(|| self.usart.find(address))
    }

    /// Writes to such a peripheral, without effect while its clock is off; false if it is none.
    fn write_peripheral(&self, address: u32, new: u32) -> bool {
        let Some((peripheral, word)) = self.peripheral(address) else {
            return false;
        };
        match peripheral {
            _ if !self.clocks.reaches(peripheral) => {}
            Peripheral::Port(number) => self.pins.write(number, address, word, new),
            Peripheral::Usart2 | Peripheral::Dma1 => self.usart.write(address, word, new),
            _ => self.timers.write(address, word, new),
        }
        true
    }

    /// Steps at the step input.
    pub(crate) fn step(&self, steps: u32) {
        self.timers.step(steps);
    }

    /// The direction line of the step input changes to a level.
    pub(crate) fn direct(&self, high: bool) {
        self.level_of_direction(high);
        self.timers.direct();
    }

    /// The same, before its edge is through the filter.
    pub(crate) fn level_of_direction(&self, high: bool) {
        self.drive(1, 7, if high { Line::Supply } else { Line::Ground });
    }

    /// Has something happen after the next read of a timer.
    pub(crate) fn while_reading(&self, event: fn(&Chip)) {
        self.while_reading.set(Some(event));
    }

    /// Has something happen in the next step of the flash.
    pub(crate) fn in_a_step(&self, event: fn(&Chip)) {
        self.in_a_step.set(Some(event));
    }

    /// Advances the time, s.
    pub(crate) fn elapse(&self, seconds: f64) {
        self.pass((seconds * 1e9).round() as u64);
        self.timers.elapse(seconds, &self.clocks);
    }

    /// The interrupt that nothing masks; true if the program may continue.
    pub(crate) fn non_maskable_interrupt(&self) -> bool {
        self.is_in_nmi.set(true);
        let outlives = drive_chip::outlives_nmi(self);
        self.is_in_nmi.set(false);
        outlives
    }

    /// That interrupt, if the flash has found damage.
    fn interrupt_for_damage(&self) {
        if self.memory.has_found_damage() && !self.is_in_nmi.get() {
            assert!(self.non_maskable_interrupt(), "the program has ended");
        }
    }

    fn pass(&self, nanoseconds: u64) {
        self.now.set(self.now.get() + nanoseconds);
        self.watchdog.look(self.now.get());
    }

    /// Every word written to an address, in order.
    pub(crate) fn written_to(&self, address: u32) -> Vec<u32> {
        let written = self.written.borrow();
        let there = written.iter().filter(|(place, _)| *place == address);
        there.map(|(_, word)| *word).collect()
    }

    /// The place, in the order of all writes, of the first one to an address that meets a condition.
    pub(crate) fn first_write(&self, address: u32, holds: impl Fn(u32) -> bool) -> Option<usize> {
        let written = self.written.borrow();
        written
            .iter()
            .position(|&(place, word)| place == address && holds(word))
    }

    /// The signal on the PWM's pin, by the timer and the pin's mode (RM0090, 8.3).
    pub(crate) fn output(&self) -> Output {
        match self.pins.mode(0, 8) {
            Mode::Output => match self.pins.driven(0, 8) {
                Level::Low => Output::Low,
                Level::High => Output::High,
            },
            Mode::Alternate(TIM1_FUNCTION) => self.timers.output(),
            _ => Output::Floating,
        }
    }

    /// The signal on the direction's pin.
    pub(crate) fn direction(&self) -> Output {
        match self.pins.mode(1, 14) {
            Mode::Output => match self.pins.driven(1, 14) {
                Level::Low => Output::Low,
                Level::High => Output::High,
            },
            Mode::Alternate(TIM1_FUNCTION) => self.timers.complementary(),
            _ => Output::Floating,
        }
    }

    /// Sets the line at a pin.
    pub(crate) fn drive(&self, port: usize, number: usize, line: Line) {
        self.pins.outside(port, number, line);
        self.look_at_breaks();
    }

    /// The break input is pin B12 where that is the timer's (function 1).
    pub(crate) fn look_at_breaks(&self) {
        let wired = self.pins.mode(1, 12) == Mode::Alternate(TIM1_FUNCTION);
        let level = if wired {
            self.pins.level(1, 12)
        } else {
            Level::Low
        };
        let current = self.supply.current_breaks(&self.pins, &self.timers);
        self.timers.break_inputs(
            level == Level::High || current,
            self.supply.breaks_by_itself(),
        );
    }

    /// The signal on the PWM's pin after every write.
    pub(crate) fn outputs(&self) -> Vec<Output> {
        self.outputs.borrow().clone()
    }

    /// Gives every interrupt a priority.
    pub(crate) fn set_priorities(&self, priority: u8) {
        self.nvic.priorities.borrow_mut().fill(priority);
    }

    /// An interrupt's priority by the vector table; 0 is the highest.
    pub(crate) fn priority(&self, interrupt: Interrupt) -> u8 {
        self.nvic.priorities.borrow()[interrupt as usize]
    }

    /// The priority that an interrupt had when it was unmasked.
    pub(crate) fn unmasked(&self, interrupt: Interrupt) -> Option<u8> {
        let unmasked = self.nvic.unmasked.borrow();
        let found = unmasked
            .iter()
            .find(|(number, _)| *number == interrupt as u16);
        found.map(|(_, priority)| *priority)
    }

    /// Number of unmasked interrupts.
    pub(crate) fn unmasked_count(&self) -> usize {
        self.nvic.unmasked.borrow().len()
    }

    /// Ticks of the processor from one interrupt of SysTick to the next, if it runs (PM0214, 4.5), and its priority.
    pub(crate) fn systick(&self) -> Option<(u32, u8)> {
        let [control, reload, _] = self.nvic.systick.each_ref().map(Cell::get);
        // Enabled, interrupting, by the processor's clock.
        let runs = control & 0b111 == 0b111;
        let priority = (self.nvic.system_priorities.get() >> 24) as u8;
        runs.then_some((reload + 1, priority))
    }

    /// True if the program has set an interrupt pending.
    pub(crate) fn pending(&self, interrupt: Interrupt) -> bool {
        self.nvic.pending.borrow().contains(&(interrupt as u16))
    }
}

impl Nvic {
    /// The interrupts whose bits are set in a word of a bit each.
    fn interrupts(address: u32, base: u32, word: u32) -> impl Iterator<Item = u16> {
        let first = (address - base) * 8;
        (0..32_u32)
            .filter(move |bit| word >> bit & 1 != 0)
            .map(move |bit| (first + bit) as u16)
    }

    /// Writes a word (PM0214, 4.3); false if it is none of these.
    fn write(&self, address: u32, word: u32) -> bool {
        match address {
            0xe000_e010..0xe000_e01c => {
                // 24 bits; a write of the current value clears it (PM0214, 4.5.3).
                let place = (address - 0xe000_e010) / 4;
                let kept = if place == 2 { 0 } else { word & 0xff_ffff };
                self.systick[place as usize].set(kept);
            }
            0xe000_ed20 => self.system_priorities.set(word & 0xf0f0_f0f0),
            0xe000_e100..0xe000_e120 => {
                for number in Self::interrupts(address, 0xe000_e100, word) {
                    let priority = self.priorities.borrow()[usize::from(number)];
                    self.unmasked.borrow_mut().push((number, priority));
                }
            }
            0xe000_e200..0xe000_e220 => {
                let called = Self::interrupts(address, 0xe000_e200, word);
                self.pending.borrow_mut().extend(called);
            }
            0xe000_e400..0xe000_e460 => {
                let first = (address - 0xe000_e400) as usize;
                // Four bits of each are there (PM0214, 4.3.7).
                let bytes = (word & 0xf0f0_f0f0).to_le_bytes();
                self.priorities.borrow_mut()[first..first + 4].copy_from_slice(&bytes);
            }
            _ => return false,
        }
        true
    }

    fn read(&self, address: u32) -> Option<u32> {
        if address == 0xe000_ed20 {
            return Some(self.system_priorities.get());
        }
        let first = address.checked_sub(0xe000_e400)? as usize;
        let priorities = self.priorities.borrow();
        let bytes = priorities.get(first..first + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    }
}

impl Bus for &Chip {
    type Family = Family;

    fn read(self, register: Register) -> u32 {
        let address = register.address();
        assert_eq!(address % 4, 0, "no word is at {address:#x}");
        self.pass(ACCESS);
        if let Some(word) = self.memory.read(address, self.now.get()) {
            self.interrupt_for_damage();
            return word;
        }
        if let Some(word) = self.clocks.read(address) {
            self.memory.check_wait_states(self.clocks.frequencies());
            return word;
        }
        if let Some((peripheral, word)) = self.peripheral(address) {
            return match peripheral {
                _ if !self.clocks.is_on(peripheral) => 0,
                Peripheral::Port(number) => self.pins.read(number, address, word),
                Peripheral::Usart2 | Peripheral::Dma1 => self.usart.read(address, word),
                _ => {
                    let read = self.timers.read(address, word);
                    if let Some(event) = self.while_reading.take() {
                        event(self);
                    }
                    read
                }
            };
        }
        self.watchdog
            .read(address, self.now.get())
            .or_else(|| self.supply.read(address, &self.clocks))
            .or_else(|| self.nvic.read(address))
            .unwrap_or_else(|| panic!("nothing is at {address:#x}"))
    }

    fn write(self, register: Register, word: u32) {
        let address = register.address();
        assert_eq!(address % 4, 0, "no word is at {address:#x}");
        self.pass(ACCESS);
        if self.watchdog.feed(address, word, self.now.get()) {
            return;
        }
        self.written.borrow_mut().push((address, word));
        let taken = self
            .memory
            .write(address, word, self.now.get(), self.alone.get())
            || self.clocks.write(address, word)
            || self.watchdog.write(address, word, self.now.get())
            || self.write_peripheral(address, word)
            || self.supply.write(address, word, &self.clocks)
            || self.nvic.write(address, word);
        assert!(taken, "nothing is at {address:#x}");
        if self.memory.is_in_a_step(self.now.get())
            && let Some(event) = self.in_a_step.take()
        {
            event(self);
        }
        self.clocks.reset_peripherals(self);
        self.memory.check_wait_states(self.clocks.frequencies());
        self.look_at_breaks();
        let output = self.output();
        self.outputs.borrow_mut().push(output);
    }

    fn damage(self) -> &'static Damage {
        self.damage
    }

    fn take_interrupts(self) {
        self.barriers.set(self.barriers.get() + 1);
    }

    fn without_interrupts<R>(self, work: impl FnOnce() -> R) -> R {
        assert!(!self.alone.replace(true), "alone already");
        let result = work();
        self.alone.set(false);
        result
    }
}
