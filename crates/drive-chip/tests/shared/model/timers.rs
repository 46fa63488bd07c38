//! TIM1, TIM3, TIM4 and TIM5 (RM0090, 17 and 18).

use std::cell::Cell;

use super::block::Block;
use super::clocks::{Clocks, Peripheral};
use crate::facts::{TIM5_TRIGGER, synchronisation, tim5};
use crate::pac::{TIM1, TIM3, TIM4, TIM5, tim1, tim3};

/// The signal on the PWM's pin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Output {
    Low,
    High,
    /// High for a part of every period from its beginning, ticks.
    Pwm {
        high: u32,
        period: u32,
    },
    /// Not driven.
    Floating,
}

pub(crate) struct Timers {
    pub(crate) tim1: Block<tim1::RegisterBlock>,
    tim3: Block<tim3::RegisterBlock>,
    tim4: Block<tim3::RegisterBlock>,
    pub(crate) tim5: Block<tim5::RegisterBlock>,
    /// Values in force; those in the registers take effect with the next update.
    top_1: Cell<u32>,
    compare_1: Cell<u32>,
    compare_2: Cell<u32>,
    top_5: Cell<u32>,
    breaks: Cell<(bool, bool)>,
    /// Interrupts that TIM5 requested.
    pub(crate) asked: Cell<u32>,
}

impl Timers {
    pub(crate) fn new() -> Self {
        let timers = Self {
            tim1: Block::at(TIM1::ptr()),
            tim3: Block::at(TIM3::ptr()),
            tim4: Block::at(TIM4::ptr()),
            tim5: Block::at(TIM5::ptr()),
            top_1: Cell::new(0),
            compare_1: Cell::new(0),
            compare_2: Cell::new(0),
            top_5: Cell::new(0),
            breaks: Cell::default(),
            asked: Cell::new(0),
        };
        timers.reset(Peripheral::Tim5);
        timers
    }

    pub(crate) fn reset(&self, peripheral: Peripheral) {
        match peripheral {
            Peripheral::Tim1 => {
                self.tim1.clear();
                self.compare_1.set(0);
                self.compare_2.set(0);
                self.top_1.set(0);
            }
            Peripheral::Tim3 => self.tim3.clear(),
            Peripheral::Tim4 => self.tim4.clear(),
            _ => {
                self.tim5.clear();
                self.tim5.set(self.tim5.arr(), u32::MAX);
                self.top_5.set(u32::MAX);
            }
        }
    }

    /// True for each of TIM1 and TIM5 that counts.
    pub(crate) fn counting(&self) -> [bool; 2] {
        [
            self.tim1.cr1().read().cen().is_enabled(),
            self.tim5.cr1().read().cen().is_enabled(),
        ]
    }

    /// Counts of TIM1 and TIM5, ticks.
    pub(crate) fn stand(&self) -> [u32; 2] {
        [
            self.tim1.get(self.tim1.cnt()),
            self.tim5.get(self.tim5.cnt()),
        ]
    }

    /// From now to the next update of TIM1 and of TIM5, s.
    pub(crate) fn until_update(&self, clocks: &Clocks) -> [f64; 2] {
        let frequencies = clocks.frequencies();
        let [at_1, at_5] = self.stand();
        [
            f64::from(self.top_1.get() + 1 - at_1) / frequencies.high_timers,
            (f64::from(self.top_5.get()) + 1.0 - f64::from(at_5)) / frequencies.low_timers,
        ]
    }

    /// True if an update interrupt of TIM5 is pending.
    pub(crate) fn interrupts(&self) -> bool {
        self.tim5.dier().read().uie().is_enabled()
            && self.tim5.sr().read().uif().is_update_pending()
    }

    /// True if inactive outputs are driven: with the main output enabled, and without.
    pub(crate) fn drive_what_is_off(&self) -> [bool; 2] {
        let control = self.tim1.bdtr().read();
        [
            control.ossr().is_idle_level(),
            control.ossi().is_idle_level(),
        ]
    }

    /// True if the break flag is set.
    pub(crate) fn broke(&self) -> bool {
        self.tim1.sr().read().bif().is_trigger()
    }

    /// Advances both counters, s.
    pub(crate) fn elapse(&self, seconds: f64, clocks: &Clocks) {
        let frequencies = clocks.frequencies();
        let counted = |count: u32, top: u32, frequency: f64| {
            let all = u64::from(count) + (seconds * frequency).round() as u64;
            let period = u64::from(top) + 1;
            ((all % period) as u32, all >= period)
        };
        let [at_1, at_5] = self.stand();
        let [on_1, on_5] = self.counting();
        if on_1 {
            let (count, updated) = counted(at_1, self.top_1.get(), frequencies.high_timers);
            self.tim1.set(self.tim1.cnt(), count);
            if updated {
                self.update_1();
            }
        }
        if on_5 {
            let (count, updated) = counted(at_5, self.top_5.get(), frequencies.low_timers);
            self.tim5.set(self.tim5.cnt(), count);
            if updated {
                self.raise_5();
                self.top_5.set(self.tim5.get(self.tim5.arr()));
            }
        }
    }

    fn update_1(&self) {
        if self.tim1.cr1().read().udis().bit() {
            // The counter begins anew with the values in force.
            return;
        }
        self.top_1.set(self.tim1.get(self.tim1.arr()));
        self.compare_1.set(self.tim1.get(self.tim1.ccr1()));
        self.compare_2.set(self.tim1.get(self.tim1.ccr2()));
        if self.tim1.bdtr().read().aoe().bit() {
            self.tim1
                .set(self.tim1.bdtr(), self.tim1.get(self.tim1.bdtr()) | 1 << 15);
        }
    }

    fn raise_5(&self) {
        self.tim5
            .set(self.tim5.sr(), self.tim5.get(self.tim5.sr()) | 1);
        assert!(self.tim5.sr().read().uif().is_update_pending());
        if self.interrupts() {
            self.asked.set(self.asked.get() + 1);
        }
    }

    /// Sets the level of the break input (17.3.12), and whether the chip itself breaks the output (RM0440, TIM1).
    pub(crate) fn break_inputs(&self, high: bool, by_chip: bool) {
        self.breaks.set((high, by_chip));
        let tim1 = &self.tim1;
        let control = tim1.bdtr().read();
        if !control.bke().is_enabled() {
            return;
        }
        let by_pin = high == control.bkp().is_active_high();
        let flags = u32::from(by_pin) << 7 | u32::from(by_chip) << 13;
        tim1.set(tim1.sr(), tim1.get(tim1.sr()) | flags);
        assert!(!by_pin || self.broke());
        // No output as long as the chip's own flag is set.
        if flags != 0 || tim1.get(tim1.sr()) & 1 << 13 != 0 {
            tim1.set(tim1.bdtr(), tim1.get(tim1.bdtr()) & !(1 << 15));
            assert!(tim1.bdtr().read().moe().is_disabled_idle());
        }
    }

    /// Bits of a word of TIM1 that its lock keeps as they are (17.4.18; RM0440, TIM1: level 1).
    fn locked(&self, address: u32) -> u32 {
        let tim1 = &self.tim1;
        if tim1.bdtr().read().lock().bits() == 0 {
            return 0;
        }
        match address.wrapping_sub(tim1.address(tim1.cr1())) {
            // Idle states.
            0x04 => 0x7f00,
            // Dead time, the lock itself, the break's enable and polarity, automatic enable.
            0x44 => 0x73ff,
            // Sources of the break, of an STM32G4.
            0x60 => u32::MAX,
            _ => 0,
        }
    }

    /// The output of TIM1's channel 1 (table 98).
    pub(crate) fn output(&self) -> Output {
        let mode = self.tim1.ccmr1_output().read();
        let channel = self.tim1.ccer().read();
        let idle = self.tim1.cr2().read().ois1().bit();
        let high = self.reference(
            mode.oc1m().is_pwm_mode1(),
            mode.oc1m().is_pwm_mode2(),
            &self.compare_1,
        );
        self.signal(
            !channel.cc1e().is_disabled(),
            channel.cc1p().bit(),
            idle,
            high,
        )
    }

    /// The complementary output of its channel 2, whose own output must be off.
    pub(crate) fn complementary(&self) -> Output {
        let mode = self.tim1.ccmr1_output().read();
        let channel = self.tim1.ccer().read();
        let idle = self.tim1.cr2().read().ois2n().bit();
        let high = self.reference(
            mode.oc2m().is_pwm_mode1(),
            mode.oc2m().is_pwm_mode2(),
            &self.compare_2,
        );
        assert!(
            channel.cc2e().is_disabled(),
            "with both outputs on, this one is the inverse"
        );
        self.signal(channel.cc2ne().bit(), channel.cc2np().bit(), idle, high)
    }

    /// Ticks of a period for which the reference signal of a channel is high (17.3.9).
    fn reference(&self, mode_1: bool, mode_2: bool, compare: &Cell<u32>) -> u32 {
        let period = self.top_1.get() + 1;
        let below = compare.get().min(period);
        if mode_1 {
            below
        } else if mode_2 {
            period - below
        } else {
            0
        }
    }

    /// The signal on a pin of TIM1.
    fn signal(&self, enabled: bool, inverted: bool, idle: bool, high: u32) -> Output {
        let control = self.tim1.bdtr().read();
        if !enabled {
            return Output::Floating;
        }
        if control.moe().is_disabled_idle() {
            return if control.ossi().is_hi_z() {
                Output::Floating
            } else if idle {
                Output::High
            } else {
                Output::Low
            };
        }
        let period = self.top_1.get() + 1;
        let high = if inverted { period - high } else { high };
        if high == 0 {
            Output::Low
        } else if high == period {
            Output::High
        } else if self.counting()[0] {
            Output::Pwm { high, period }
        } else {
            Output::Floating
        }
    }

    /// True if TIM1 counts up, so that a period begins with its update.
    pub(crate) fn is_edge_aligned(&self) -> bool {
        let control = self.tim1.cr1().read();
        control.cms().is_edge_aligned() && control.dir().is_up()
    }

    /// Turns the encoder by a number of edges.
    pub(crate) fn turn(&self, edges: i32) {
        let tim3 = &self.tim3;
        let lines = tim3.ccmr1_input().read();
        let counts = tim3.cr1().read().cen().is_enabled()
            && tim3.smcr().read().sms().bits() == 0b011
            && lines.cc1s().is_ti1()
            && lines.cc2s().is_ti2()
            // For the encoder's channels.
            && tim3.get(tim3.ccer()) & 0xff == 0;
        if counts {
            let top = i64::from(tim3.get(tim3.arr()));
            let count = (i64::from(tim3.get(tim3.cnt())) + i64::from(edges)).rem_euclid(top + 1);
            tim3.set(tim3.cnt(), count as u32);
        }
    }

    /// A rising edge of the encoder's index: channel 3 captures the count.
    pub(crate) fn index(&self) {
        let tim3 = &self.tim3;
        let captures =
            tim3.ccmr2_input().read().cc3s().is_ti3() && tim3.get(tim3.ccer()) & 0xb00 == 1 << 8;
        if captures {
            tim3.set(tim3.ccr3(), tim3.get(tim3.cnt()));
            tim3.set(tim3.sr(), tim3.get(tim3.sr()) | 1 << 3);
        }
    }

    /// Rising edges of the step line (18.3.3).
    pub(crate) fn step(&self, edges: u32) {
        let tim4 = &self.tim4;
        let slave = tim4.smcr().read();
        let counts = tim4.cr1().read().cen().is_enabled()
            && slave.sms().bits() == 0b111
            // TI1FP1.
            && slave.ts().bits() == 0b101
            && tim4.ccmr1_input().read().cc1s().is_ti1()
            // Rising edges.
            && tim4.get(tim4.ccer()) & 0xa == 0;
        if counts {
            let top = tim4.get(tim4.arr());
            tim4.set(tim4.cnt(), (tim4.get(tim4.cnt()) + edges) % (top + 1));
        }
    }

    /// An edge of the direction line: channel 2 captures the count at both (18.3.5).
    pub(crate) fn direct(&self) {
        let tim4 = &self.tim4;
        let captures =
            tim4.ccmr1_input().read().cc2s().is_ti2() && tim4.get(tim4.ccer()) & 0xb0 == 0xb0;
        if captures {
            let flags = tim4.get(tim4.sr());
            let over = if flags & 1 << 2 == 0 { 0 } else { 1 << 10 };
            tim4.set(tim4.ccr2(), tim4.get(tim4.cnt()));
            tim4.set(tim4.sr(), flags | 1 << 2 | over);
        }
    }

    /// The time for which a level of the step and the direction line must stand, s.
    pub(crate) fn step_filters(&self, clocks: &Clocks) -> [f64; 2] {
        let [step, direction, _] = Self::filters(&self.tim4, clocks);
        [step, direction]
    }

    /// Reads a word: that of a capture clears its flag.
    pub(crate) fn read(&self, address: u32, word: &Cell<u32>) -> u32 {
        let (tim3, tim4) = (&self.tim3, &self.tim4);
        if address == tim3.address(tim3.ccr3()) {
            tim3.set(tim3.sr(), tim3.get(tim3.sr()) & !(1 << 3));
        } else if address == tim4.address(tim4.ccr2()) {
            tim4.set(tim4.sr(), tim4.get(tim4.sr()) & !(1 << 2));
        }
        word.get()
    }

    /// The time for which a level of the encoder's lines and its index must stand to be counted, s (18.4.7).
    pub(crate) fn encoder_filters(&self, clocks: &Clocks) -> [f64; 3] {
        Self::filters(&self.tim3, clocks)
    }

    fn filters(timer: &Block<tim3::RegisterBlock>, clocks: &Clocks) -> [f64; 3] {
        let lines = timer.ccmr1_input().read();
        let index = timer.ccmr2_input().read();
        [
            lines.ic1f().bits(),
            lines.ic2f().bits(),
            index.ic3f().bits(),
        ]
        .map(|filter| {
            const SAMPLES: [u32; 16] = [1, 2, 4, 8, 6, 8, 6, 8, 6, 8, 5, 6, 8, 5, 6, 8];
            const DIVIDER: [u32; 16] = [1, 1, 1, 1, 2, 2, 4, 4, 8, 8, 16, 16, 16, 32, 32, 32];
            let filter = usize::from(filter);
            f64::from(SAMPLES[filter] * DIVIDER[filter]) / clocks.frequencies().low_timers
        })
    }

    pub(crate) fn find(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        let word = |peripheral| move |word| (peripheral, word);
        let first = self.tim1.word(address).map(word(Peripheral::Tim1));
        first
            .or_else(|| self.tim3.word(address).map(word(Peripheral::Tim3)))
            .or_else(|| self.tim4.word(address).map(word(Peripheral::Tim4)))
            .or_else(|| self.tim5.word(address).map(word(Peripheral::Tim5)))
    }

    /// Writes a word of theirs.
    pub(crate) fn write(&self, address: u32, word: &Cell<u32>, new: u32) {
        let (tim1, tim5) = (&self.tim1, &self.tim5);
        let flags = [
            tim1.address(tim1.sr()),
            self.tim3.address(self.tim3.sr()),
            self.tim4.address(self.tim4.sr()),
            tim5.address(tim5.sr()),
        ];
        if flags.contains(&address) {
            // Zeros clear.
            word.set(word.get() & new);
            return;
        }
        let was_counting = tim5.cr1().read().cen().is_enabled();
        let locked = self.locked(address);
        word.set(word.get() & locked | new & !locked);
        if address == tim1.address(tim1.egr()) && new & 1 != 0 {
            tim1.set(tim1.cnt(), 0);
            self.update_1();
        } else if address == tim5.address(tim5.egr()) && new & 1 != 0 {
            tim5.set(tim5.cnt(), 0);
            self.top_5.set(tim5.get(tim5.arr()));
            if !tim5.cr1().read().urs().bit() {
                self.raise_5();
            }
        } else if address == tim1.address(tim1.arr()) && !tim1.cr1().read().arpe().bit() {
            self.top_1.set(new);
        } else if address == tim1.address(tim1.ccr1()) && !tim1.ccmr1_output().read().oc1pe().bit()
        {
            self.compare_1.set(new);
        } else if address == tim1.address(tim1.ccr2()) && !tim1.ccmr1_output().read().oc2pe().bit()
        {
            self.compare_2.set(new);
        } else if address == tim5.address(tim5.arr()) && !tim5.cr1().read().arpe().bit() {
            self.top_5.set(new);
        } else if address == tim5.address(tim5.cr1()) {
            let starts = !was_counting && tim5.cr1().read().cen().is_enabled();
            let master = tim5.cr2().read().mms().bits() == 0b001;
            let (mode, trigger) = synchronisation(&tim1.smcr().read());
            if starts && master && mode == 0b110 && trigger == TIM5_TRIGGER {
                tim1.set(tim1.cr1(), tim1.get(tim1.cr1()) | 1);
            }
        }
        let (high, by_chip) = self.breaks.get();
        self.break_inputs(high, by_chip);
    }
}
