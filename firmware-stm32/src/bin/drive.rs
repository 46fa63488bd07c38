//! The drive: controls and identifies a real servo.
//!
//! TIM5 interrupts at every sample, above everything else, runs the sampler and feeds the watchdog as long as the
//! background completes its turns. USART2 interrupts at every byte. In between, the background obeys, answers,
//! reports and keeps records.
#![no_std]
#![no_main]

use cortex_m_rt::{ExceptionFrame, entry, exception};
use drive_chip::inputs::Inputs;
use drive_chip::sample_timer::SampleTimer;
use drive_chip::serial::Port;
use drive_chip::watchdog::Watchdog;
use drive_chip::{Mmio, interrupts, sample_timer};
use drive_link::State;
use drive_logic::{Channel, Chip, Conversation, Lines, Memory, Sampler, Supervisor, self_test};
use firmware_stm32::board::{self, Encoder, Output, Wired};
use firmware_stm32::hand_off::HandOff;
use firmware_stm32::settings;
use stm32f4xx_hal::pac::interrupt;

/// State of the sample interrupt.
struct Control {
    sampler: Sampler<'static>,
    chip: Wiring,
}

/// The pins that a sample uses.
struct Wiring {
    encoder: Encoder,
    output: Output,
    inputs: Inputs<Mmio>,
    watchdog: Watchdog<Mmio>,
}

impl Chip for Wiring {
    type Sensor = Encoder;
    type Output = Output;

    #[inline]
    fn lines(&self) -> Lines {
        let [low_switch, high_switch] = self.inputs.closed_switches();
        Lines {
            amplifier: self.inputs.amplifier_is_healthy(),
            low_switch,
            high_switch,
        }
    }

    #[inline]
    fn servo(&mut self) -> (&mut Encoder, &mut Output) {
        (&mut self.encoder, &mut self.output)
    }

    #[inline]
    fn next_is_due(&self) -> bool {
        sample_timer::is_due(Mmio)
    }

    #[inline]
    fn feed_watchdog(&mut self) {
        self.watchdog.feed();
    }
}

static CONTROL: HandOff<Control> = HandOff::new();
static PORT: HandOff<Port<'static, Mmio>> = HandOff::new();

#[interrupt]
fn TIM5() {
    static mut OWN: Option<Control> = None;
    sample_timer::acknowledge(Mmio);
    if OWN.is_none() {
        *OWN = CONTROL.take();
    }
    if let Some(Control { sampler, chip }) = OWN {
        sampler.interrupt(chip);
    }
    #[cfg(feature = "emulator")]
    firmware_stm32::emulated_servo::advance();
}

#[interrupt]
fn USART2() {
    static mut OWN: Option<Port<'static, Mmio>> = None;
    if OWN.is_none() {
        *OWN = PORT.take();
    }
    if let Some(port) = OWN {
        port.serve();
    }
}

/// Disables the servo after a fault of the program; the watchdog then resets the chip.
fn give_up() -> ! {
    board::disable_outputs();
    loop {
        cortex_m::asm::nop();
    }
}

#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    give_up()
}

#[exception]
unsafe fn DefaultHandler(_: i16) {
    give_up()
}

/// The oscillator failed.
#[exception]
unsafe fn NonMaskableInt() {
    give_up()
}

#[entry]
fn main() -> ! {
    if let Some((wired, output, channel, memory)) = parts() {
        background(wired, output, channel, memory);
    }
    // Only a second start without a reset ends here.
    loop {
        cortex_m::asm::wfi();
    }
}

fn parts() -> Option<(Wired, Output, &'static mut Channel, &'static mut Memory)> {
    let (wired, output) = board::wire()?;
    Some((
        wired,
        output,
        cortex_m::singleton!(: Channel = Channel::new())?,
        cortex_m::singleton!(: Memory = Memory::new())?,
    ))
}

fn background(
    wired: Wired,
    output: Output,
    channel: &'static mut Channel,
    memory: &'static mut Memory,
) {
    let Wired {
        encoder,
        inputs,
        timer,
        mut line,
        port,
        flash,
        watchdog,
        found,
        ..
    } = wired;
    let found = self_test().and(found);
    let (back, interrupt) = channel.split();
    let built_in = settings::built_in();
    let mut supervisor = Supervisor::new(back, memory, (flash, 0), &built_in, board::STAGE, found);
    watchdog.start();
    CONTROL.give(Control {
        sampler: Sampler::new(interrupt, found),
        chip: Wiring {
            encoder,
            output,
            inputs,
            watchdog,
        },
    });
    PORT.give(port);
    let mut sample_time = supervisor.sample_time();
    start(&timer, sample_time);
    interrupts::begin(Mmio);

    let mut conversation = Conversation::new();
    let mut state = supervisor.state();
    log(state);
    loop {
        let more = conversation.turn(&mut line, &mut supervisor);
        if supervisor.state() != state {
            state = supervisor.state();
            log(state);
        }
        let wanted = supervisor.sample_time();
        if wanted.to_bits() != sample_time.to_bits() {
            sample_time = wanted;
            start(&timer, sample_time);
        }
        if !more {
            // A byte that is received between the check and the sleep would wait for the next sample. Without
            // interrupts in between, its interrupt wakes the processor at once.
            cortex_m::interrupt::free(|_| {
                if line.is_silent() {
                    cortex_m::asm::wfi();
                }
            });
        }
    }
}

/// Starts the samples, and an emulated servo with them.
fn start(timer: &SampleTimer<Mmio>, sample_time: f64) {
    timer.start(sample_time);
    #[cfg(feature = "emulator")]
    firmware_stm32::emulated_servo::set_sample_time(sample_time);
}

#[cfg(feature = "defmt")]
fn log(state: State) {
    match state {
        State::Faulted(fault) => defmt::error!(
            "fault {}: {}; {}",
            fault.number(),
            fault.cause(),
            fault.remedy()
        ),
        other => defmt::info!("{}", other),
    }
}

#[cfg(not(feature = "defmt"))]
fn log(_: State) {}
