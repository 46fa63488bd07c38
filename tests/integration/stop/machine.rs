//! A chip with time: a processor with two levels of interrupts, USART2 with its DMA stream, and a flash that stalls
//! it. References are to RM0090.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU8, Ordering};

use drive_chip::bus::Register;
use drive_chip::serial::{self, Port, Ring};
use drive_chip::{Bus, F4, line_timer};
use drive_logic::{LineListener, Sampler};

use super::durations::Durations;
use super::support::Bench;
use super::support::commission::SERVO;
use super::support::line::Random;

/// Time of a byte at 1 Mbaud, ns.
pub(super) const BYTE: u64 = 10_000;

/// Between two interrupts of the line's timer, ns.
const TICK: u64 = (1e9 * line_timer::PERIOD) as u64;

/// Duration of the line's interrupt, ns: its own, and for each byte, both above the time of its instructions.
const LINE_INTERRUPT: u64 = 500;
const LINE_BYTE: u64 = 250;

/// Durations of the flash's steps by the data sheet, ns: a word from the typical to the longest, a sector of 16 KiB alike.
const WORD: [u64; 2] = [16_000, 100_000];
const ERASURE: [u64; 2] = [250_000_000, 500_000_000];

/// The mode whose samples drive the servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mode {
    Run,
    Commissioning,
}

/// A byte on the wire.
#[derive(Debug, Clone, Copy)]
struct Arriving {
    /// The time at which it is complete, ns.
    time: u64,
    byte: u8,
    /// Without it, it is a break.
    has_stop_bit: bool,
}

/// The running code, by its priority.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
enum Level {
    Background,
    Line,
    /// A sample, or the background without any interrupt.
    Sample,
}

/// The drive's interrupts.
pub(super) struct Handlers {
    pub(super) sampler: RefCell<Sampler<'static>>,
    pub(super) port: RefCell<Port<'static, &'static Machine>>,
    pub(super) listener: RefCell<LineListener<'static>>,
}

pub(super) struct Machine {
    bench: &'static Bench,
    durations: Durations,
    mode: Cell<Mode>,
    handlers: RefCell<Option<&'static Handlers>>,
    random: RefCell<Random>,
    level: Cell<Level>,
    /// ns.
    now: Cell<u64>,
    period: u64,
    next_sample: Cell<u64>,
    next_tick: Cell<u64>,
    samples: Cell<u64>,
    line_is_pending: Cell<bool>,
    /// The last time at which the servo was driven.
    last_driven: Cell<u64>,
    note_at: Cell<u64>,
    noted: Cell<Option<bool>>,
    wire_free_at: Cell<u64>,
    arriving: RefCell<VecDeque<Arriving>>,
    received: Cell<Option<u8>>,
    overrun: Cell<bool>,
    framing_error: Cell<bool>,
    ring: Cell<Option<&'static Ring>>,
    /// NDTR, and the flags of the stream.
    left: Cell<u32>,
    flags: Cell<u32>,
    control: Cell<u32>,
    sent_until: Cell<u64>,
    flash_control: Cell<u32>,
    flash_until: Cell<u64>,
    words: RefCell<Vec<u32>>,
}

/// Registers (RM0090, 2.3, 3.9, 10.5, 30.6; PM0214, 4.3).
const USART_SR: u32 = 0x4000_4400;
const USART_DR: u32 = 0x4000_4404;
const USART_CR1: u32 = 0x4000_440c;
const USART: std::ops::Range<u32> = 0x4000_4400..0x4000_4420;
const DMA_HISR: u32 = 0x4002_6004;
const DMA_HIFCR: u32 = 0x4002_600c;
const DMA_S5NDTR: u32 = 0x4002_608c;
const DMA: std::ops::Range<u32> = 0x4002_6000..0x4002_60a0;
const FLASH_ACR: u32 = 0x4002_3c00;
const FLASH_KEYR: u32 = 0x4002_3c04;
const FLASH_SR: u32 = 0x4002_3c0c;
const FLASH_CR: u32 = 0x4002_3c10;
const PWR_CSR: u32 = 0x4000_7004;
const EXTI_PR: u32 = 0x4001_3c14;
const WATCHDOG: u32 = 0x4000_3000;
const PEND_USART2: u32 = 0xe000_e204;
const RECORDS: std::ops::Range<u32> = 0x0800_4000..0x0800_c000;
const SECTOR: u32 = 0x4000;

/// Bytes of the ring.
const RING: u32 = 4096;

impl Machine {
    pub(super) fn new(rate: u32) -> Self {
        let period = 1_000_000_000 / u64::from(rate);
        Self {
            bench: Bench::sampled(&SERVO, 1.0 / f64::from(rate)),
            durations: Durations::at(rate),
            mode: Cell::new(Mode::Run),
            handlers: RefCell::new(None),
            random: RefCell::new(Random(0x2545_f491 ^ rate)),
            level: Cell::new(Level::Background),
            now: Cell::new(0),
            period,
            next_sample: Cell::new(period),
            next_tick: Cell::new(TICK),
            samples: Cell::new(0),
            line_is_pending: Cell::new(false),
            last_driven: Cell::new(0),
            note_at: Cell::new(0),
            noted: Cell::new(None),
            wire_free_at: Cell::new(0),
            arriving: RefCell::default(),
            received: Cell::new(None),
            overrun: Cell::new(false),
            framing_error: Cell::new(false),
            ring: Cell::new(None),
            left: Cell::new(0),
            flags: Cell::new(0),
            control: Cell::new(0),
            sent_until: Cell::new(0),
            flash_control: Cell::new(1 << 31),
            flash_until: Cell::new(0),
            words: RefCell::new(vec![u32::MAX; (RECORDS.end - RECORDS.start) as usize / 4]),
        }
    }

    /// Enables the interrupts.
    pub(super) fn begin(&self, handlers: &'static Handlers, ring: &'static Ring) {
        self.ring.set(Some(ring));
        *self.handlers.borrow_mut() = Some(handlers);
    }

    pub(super) fn now(&self) -> u64 {
        self.now.get()
    }

    pub(super) fn is_driven(&self) -> bool {
        self.bench.held.get().is_some()
    }

    pub(super) fn samples(&self) -> u64 {
        self.samples.get()
    }

    pub(super) fn last_driven(&self) -> u64 {
        self.last_driven.get()
    }

    pub(super) fn set_mode(&self, mode: Mode) {
        self.mode.set(mode);
    }

    /// A number that looks random, the same in every run.
    pub(super) fn below(&self, most: u32) -> u32 {
        self.random.borrow_mut().below(most)
    }

    /// Puts a byte on the wire after those that are on it, and returns the time at which it begins.
    pub(super) fn put_on_the_wire(&self, byte: u8) -> u64 {
        self.put(byte, true, BYTE)
    }

    /// Breaks the wire for a time after the bytes that are on it, ns: it is low, which the receiver takes for a byte of
    /// zeros without a stop bit (30.3.3).
    pub(super) fn break_wire(&self, time: u64) {
        self.put(0, false, time.max(BYTE));
    }

    fn put(&self, byte: u8, has_stop_bit: bool, length: u64) -> u64 {
        let begins = self.wire_free_at.get().max(self.now.get());
        self.wire_free_at.set(begins + length);
        self.arriving.borrow_mut().push_back(Arriving {
            time: begins + BYTE,
            byte,
            has_stop_bit,
        });
        begins
    }

    /// Leaves the wire idle for a time after the bytes that are on it, ns, and returns the end of that.
    pub(super) fn leave_idle(&self, time: u64) -> u64 {
        let free_at = self.wire_free_at.get().max(self.now.get()) + time;
        self.wire_free_at.set(free_at);
        free_at
    }

    /// Notes at a time whether the servo is driven.
    pub(super) fn note_at(&self, time: u64) {
        self.noted.set(None);
        self.note_at.set(time);
    }

    /// True if it was driven at the time that was to be noted.
    pub(super) fn was_driven(&self) -> bool {
        self.noted.get().unwrap_or(false)
    }

    /// Takes processor time at the background's level, ns.
    pub(super) fn compute(&self, time: u64) {
        self.spend(time, Level::Background);
    }

    /// Sleeps until an event, at most until a time.
    pub(super) fn sleep(&self, until: u64) {
        let next = self.next_event(Level::Background).min(until);
        self.spend(next.saturating_sub(self.now.get()), Level::Background);
    }

    /// Takes processor time at a level. Interrupts above it take theirs in between.
    fn spend(&self, mut time: u64, level: Level) {
        let before = self.level.replace(level);
        loop {
            self.hardware();
            if level < Level::Sample && self.now.get() >= self.next_sample.get() {
                self.sample();
            } else if level < Level::Line && self.line_interrupts() {
                self.serve_line();
            } else if time == 0 {
                break;
            } else {
                let until = self.next_event(level).saturating_sub(self.now.get()).max(1);
                let step = time.min(until);
                self.now.set(self.now.get() + step);
                time -= step;
            }
        }
        self.level.set(before);
    }

    /// The next time at which something happens that matters at a level.
    fn next_event(&self, level: Level) -> u64 {
        let mut next = self.next_tick.get();
        if let Some(arriving) = self.arriving.borrow().front() {
            next = next.min(arriving.time);
        }
        if level < Level::Sample {
            next = next.min(self.next_sample.get());
        }
        if level < Level::Line && self.sends() {
            next = next.min(self.sent_until.get());
        }
        next
    }

    /// Has the hardware act up to now, without the processor.
    fn hardware(&self) {
        let now = self.now.get();
        loop {
            let Some(arriving) = self.arriving.borrow().front().copied() else {
                break;
            };
            if arriving.time > now {
                break;
            }
            self.arriving.borrow_mut().pop_front();
            if !arriving.has_stop_bit {
                self.framing_error.set(true);
            }
            if self.received.get().is_some() {
                // The data register is not read yet (30.3.3).
                self.overrun.set(true);
                continue;
            }
            self.received.set(Some(arriving.byte));
            self.transfer();
        }
        while self.next_tick.get() <= now {
            self.next_tick.set(self.next_tick.get() + TICK);
            self.line_is_pending.set(true);
        }
    }

    /// The byte in the data register goes to the ring.
    fn transfer(&self) {
        let (Some(ring), Some(byte)) = (self.ring.get(), self.received.take()) else {
            return;
        };
        let left = self.left.get();
        let first = std::ptr::from_ref(ring).cast::<AtomicU8>();
        // SAFETY: the ring begins with as many atomic bytes as its length is.
        let place = unsafe { &*first.add((RING - left) as usize) };
        place.store(byte, Ordering::Relaxed);
        let next = left - 1;
        let mark = match next {
            0 => 1 << 11,
            half if half == RING / 2 => 1 << 10,
            _ => 0,
        };
        self.flags.set(self.flags.get() | mark);
        self.left.set(if next == 0 { RING } else { next });
    }

    fn sends(&self) -> bool {
        self.control.get() & 1 << 7 != 0
    }

    fn line_interrupts(&self) -> bool {
        let can_send = self.sends() && self.now.get() >= self.sent_until.get();
        self.line_is_pending.get() || can_send
    }

    fn serve_line(&self) {
        let Some(handlers) = *self.handlers.borrow() else {
            self.line_is_pending.set(false);
            return;
        };
        self.line_is_pending.set(false);
        let mut bytes = 0;
        let mut listener = handlers.listener.borrow_mut();
        handlers
            .port
            .borrow_mut()
            .serve(|reception| match reception {
                serial::Reception::Byte(byte) => {
                    bytes += 1;
                    listener.take(byte);
                }
                serial::Reception::Disturbed => listener.disturbed(),
            });
        drop(listener);
        self.spend(LINE_INTERRUPT + LINE_BYTE * bytes, Level::Line);
    }

    fn sample(&self) {
        let now = self.now.get();
        while self.next_sample.get() <= now {
            self.next_sample.set(self.next_sample.get() + self.period);
        }
        self.samples.set(self.samples.get() + 1);
        let Some(handlers) = *self.handlers.borrow() else {
            return;
        };
        let was_driven = self.is_driven();
        if now >= self.note_at.get() && self.noted.get().is_none() {
            self.noted.set(Some(was_driven));
        }
        let mut sampler = handlers.sampler.borrow_mut();
        sampler.interrupt(&mut self.bench.pins());
        drop(sampler);
        self.bench.pass();
        let length = self.length();
        self.spend(length, Level::Sample);
        if was_driven || self.is_driven() {
            self.last_driven.set(self.now.get());
        }
    }

    /// Duration of a sample, ns.
    fn length(&self) -> u64 {
        let shares = match self.mode.get() {
            _ if !self.is_driven() => &self.durations.at_rest,
            Mode::Run => &self.durations.run,
            Mode::Commissioning => &self.durations.commissioning,
        };
        let drawn = self.below(100);
        let found = shares.iter().find(|(share, _)| drawn < *share);
        found.map_or(0, |&(_, length)| length)
    }

    fn word(&self, address: u32) -> usize {
        (address - RECORDS.start) as usize / 4
    }

    fn between(&self, [least, most]: [u64; 2]) -> u64 {
        least + u64::from(self.below((most - least) as u32))
    }

    fn write_flash_control(&self, word: u32) {
        if self.flash_control.get() & 1 << 31 != 0 {
            return;
        }
        self.flash_control.set(word);
        if word & 1 << 16 != 0 {
            let sector = word >> 3 & 0xf;
            let first = ((sector - 1) * SECTOR / 4) as usize;
            self.words.borrow_mut()[first..first + SECTOR as usize / 4].fill(u32::MAX);
            self.flash_until.set(self.now.get() + self.between(ERASURE));
        }
    }
}

impl Bus for &'static Machine {
    type Family = F4;

    fn read(self, register: Register) -> u32 {
        match register.address() {
            USART_SR => {
                let can_send = self.now.get() >= self.sent_until.get();
                u32::from(can_send) << 7
                    | u32::from(self.received.get().is_some()) << 5
                    | u32::from(self.overrun.get()) << 3
                    | u32::from(self.framing_error.get()) << 1
            }
            USART_DR => {
                self.overrun.set(false);
                self.framing_error.set(false);
                self.received.take().unwrap_or(0).into()
            }
            USART_CR1 => self.control.get(),
            DMA_HISR => self.flags.get(),
            DMA_S5NDTR => self.left.get(),
            FLASH_SR => {
                // The wait for the end of a step, in which only hardware runs.
                let wait = self.flash_until.get().saturating_sub(self.now.get());
                self.spend(wait, Level::Sample);
                0
            }
            FLASH_CR => self.flash_control.get(),
            FLASH_ACR | PWR_CSR | EXTI_PR => 0,
            address if RECORDS.contains(&address) => self.words.borrow()[self.word(address)],
            address => panic!("nothing is read at {address:#x}"),
        }
    }

    fn write(self, register: Register, word: u32) {
        match register.address() {
            USART_DR => self.sent_until.set(self.now.get() + BYTE),
            USART_CR1 => self.control.set(word),
            DMA_HIFCR => self.flags.set(self.flags.get() & !word),
            DMA_S5NDTR => self.left.set(word),
            FLASH_KEYR => self
                .flash_control
                .set(self.flash_control.get() & !(1 << 31)),
            FLASH_CR => self.write_flash_control(word),
            PEND_USART2 => self.line_is_pending.set(true),
            FLASH_ACR | FLASH_SR | WATCHDOG => {}
            address if RECORDS.contains(&address) => {
                let place = self.word(address);
                self.words.borrow_mut()[place] &= word;
                self.flash_until.set(self.now.get() + self.between(WORD));
            }
            address if USART.contains(&address) || DMA.contains(&address) => {}
            address => panic!("nothing is written at {address:#x}"),
        }
    }

    fn take_interrupts(self) {
        self.spend(0, Level::Background);
    }

    fn without_interrupts<R>(self, work: impl FnOnce() -> R) -> R {
        let before = self.level.replace(Level::Sample);
        let result = work();
        self.level.set(before);
        self.spend(0, before);
        result
    }
}
