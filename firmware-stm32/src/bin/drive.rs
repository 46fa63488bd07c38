//! The drive: controls and identifies a real servo.
//!
//! TIM5 interrupts at every sample, above everything else. It runs the sampler and feeds the watchdog as long as the
//! background completes its turns. USART2 interrupts for every byte that is sent. Together with SysTick it also listens
//! for stops among the bytes that DMA has received. In between, the background obeys, answers, reports and keeps
//! records.
#![no_std]
#![no_main]

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::DWT;
use cortex_m_rt::{entry, exception};
use drive_chip::inputs::Inputs;
use drive_chip::sample_timer::SampleTimer;
use drive_chip::serial::{Port, Reception};
use drive_chip::step_input::StepInput;
use drive_chip::watchdog::Watchdog;
use drive_chip::{interrupts, sample_timer};
use drive_link::{BootChecks, State};
use drive_logic::{Channel, Chip, Conversation, LineListener, Lines, Memory, Sampler, self_test};
use firmware_stm32::board::{self, BUS, Mmio, Output as BoardOutput, Wired, interrupt};
#[cfg(not(feature = "no-motor"))]
use firmware_stm32::board::{Encoder, Output};
use firmware_stm32::hand_off::HandOff;
use firmware_stm32::{image, settings};

#[cfg(feature = "no-motor")]
use firmware_stm32::no_motor::{Encoder, Output};

/// State of the sample interrupt.
struct Control {
    sampler: Sampler<'static>,
    chip: Wiring,
}

/// State of the serial line's interrupt.
struct Ear {
    port: Port<'static, Mmio>,
    listener: LineListener<'static>,
}

/// The pins that a sample uses.
struct Wiring {
    encoder: Encoder,
    output: Output,
    inputs: Inputs<Mmio>,
    steps: StepInput<Mmio>,
    watchdog: Watchdog<Mmio>,
}

impl Chip for Wiring {
    type Sensor = Encoder;
    type Output = Output;

    #[inline]
    fn lines(&self) -> Lines {
        // Nothing is connected to a board without a motor.
        let connected = cfg!(not(feature = "no-motor"));
        let [low_switch, high_switch] = self.inputs.closed_switches();
        Lines {
            supply: self.inputs.supply_is_healthy(),
            amplifier: !connected || self.inputs.amplifier_is_healthy(),
            low_switch: !connected || low_switch,
            high_switch: !connected || high_switch,
        }
    }

    #[inline]
    fn servo(&mut self) -> (&mut Encoder, &mut Output) {
        (&mut self.encoder, &mut self.output)
    }

    #[inline]
    fn home_switch_is_closed(&self) -> bool {
        self.inputs.home_switch_is_closed()
    }

    #[inline]
    fn index(&mut self) -> Option<i32> {
        self.encoder.index()
    }

    #[inline]
    fn steps(&mut self) -> Option<i16> {
        self.steps.steps()
    }

    fn set_brake(&mut self, open: bool) {
        // A pin of the chip has no way to fail.
        let _ = self.output.set_brake(open);
    }

    #[inline]
    fn next_is_due(&self) -> bool {
        sample_timer::is_due(BUS)
    }

    #[inline]
    fn feed_watchdog(&mut self) {
        self.watchdog.feed();
    }

    #[inline]
    fn cycles(&self) -> u32 {
        DWT::cycle_count()
    }
}

static CONTROL: HandOff<Control> = HandOff::new();
static EAR: HandOff<Ear> = HandOff::new();

/// Samples so far.
static SAMPLES: AtomicU32 = AtomicU32::new(0);

#[interrupt]
fn TIM5() {
    static mut OWN: Option<Control> = None;
    sample_timer::acknowledge(BUS);
    if OWN.is_none() {
        *OWN = CONTROL.take();
    }
    if let Some(Control { sampler, chip }) = OWN {
        sampler.interrupt(chip);
        #[cfg(feature = "no-motor")]
        chip.encoder.advance(&chip.output);
    }
    let samples = SAMPLES.load(Ordering::Relaxed);
    SAMPLES.store(samples.wrapping_add(1), Ordering::Relaxed);
    #[cfg(feature = "emulator")]
    firmware_stm32::emulated_servo::advance();
}

#[interrupt]
fn USART2() {
    static mut OWN: Option<Ear> = None;
    if OWN.is_none() {
        *OWN = EAR.take();
    }
    #[cfg(feature = "emulator")]
    drive_chip::emulated_dma::receive();
    if let Some(Ear { port, listener }) = OWN {
        port.serve(|reception| match reception {
            Reception::Byte(byte) => listener.take(byte),
            Reception::Disturbed => listener.disturbed(),
        });
    }
}

#[exception]
fn SysTick() {
    interrupts::pend_serial(BUS);
}

firmware_stm32::disable_at_a_sag!();
firmware_stm32::give_up_at_every_end!();
firmware_stm32::test_memory_after_reset!();

#[entry]
fn main() -> ! {
    if let Some(parts) = parts() {
        background(parts);
    }
    // Only a second start without a reset ends here.
    loop {
        cortex_m::asm::wfi();
    }
}

/// The wired board, and the large parts of the program in static memory. The stack is for temporary values.
struct Parts {
    wired: Wired,
    output: BoardOutput,
    channel: &'static mut Channel,
    memory: &'static mut Memory,
    conversation: &'static mut Conversation,
}

/// Not inlined, for its stack to be free again.
#[inline(never)]
fn parts() -> Option<Parts> {
    let mut core = cortex_m::Peripherals::take()?;
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    let (wired, output) = board::wire()?;
    Some(Parts {
        wired,
        output,
        channel: cortex_m::singleton!(: Channel = Channel::new())?,
        memory: cortex_m::singleton!(: Memory = Memory::new())?,
        conversation: cortex_m::singleton!(: Conversation = Conversation::new())?,
    })
}

fn background(parts: Parts) {
    let (output, memory) = (parts.output, parts.memory);
    let Wired {
        encoder,
        inputs,
        steps,
        timer,
        mut line,
        port,
        line_timer,
        flash,
        watchdog,
        resets_in_time,
        found,
        ..
    } = parts.wired;
    let image = image::check();
    let (board_test, computed) = self_test(board::NAME, DWT::cycle_count);
    let found = computed.and(image.map(drop)).and(found);
    let (back, interrupt, line_end) = parts.channel.split();
    let built_in = settings::built_in();
    let begun = board::background::supervisor(back, memory, flash, &built_in, board::STAGE, found);
    let Some(supervisor) = begun else {
        return;
    };
    supervisor.set_boot_checks(BootChecks {
        resets_in_time,
        image_checked: image == Ok(true),
    });
    supervisor.set_board_test(board_test);
    watchdog.start();
    #[cfg(feature = "no-motor")]
    let (encoder, output) = firmware_stm32::no_motor::in_place_of(encoder, output);
    CONTROL.give(Control {
        sampler: Sampler::new(interrupt, found),
        chip: Wiring {
            encoder,
            output,
            inputs,
            steps,
            watchdog,
        },
    });
    EAR.give(Ear {
        port,
        listener: LineListener::new(line_end),
    });
    let mut sample_time = supervisor.sample_time();
    start(&timer, sample_time);
    interrupts::begin(BUS);
    line_timer.start();

    let mut state = supervisor.state();
    log(state);
    #[cfg(feature = "defmt")]
    let mut servo = None;
    loop {
        let samples = SAMPLES.load(Ordering::Relaxed);
        let more = board::background::turn(parts.conversation, &mut line, supervisor);
        if supervisor.state() != state {
            state = supervisor.state();
            log(state);
        }
        #[cfg(feature = "defmt")]
        if supervisor.changed() != servo {
            servo = supervisor.changed();
            defmt::info!("servo changed: {}", servo);
        }
        let wanted = supervisor.sample_time();
        if wanted.to_bits() != sample_time.to_bits() {
            sample_time = wanted;
            start(&timer, sample_time);
        }
        if !more {
            sleep_while(|| line.is_silent() && samples == SAMPLES.load(Ordering::Relaxed));
        }
    }
}

/// Sleeps until an interrupt has ended a state.
fn sleep_while(stays: impl Fn() -> bool) {
    // An interrupt between the check and the sleep would wait for the next one. Without interrupts in between, it
    // wakes the processor at once, and is served after that.
    while cortex_m::interrupt::free(|_| {
        let stays = stays();
        if stays {
            cortex_m::asm::wfi();
        }
        stays
    }) {}
}

/// Starts the samples, and a servo on the chip with them.
fn start(timer: &SampleTimer<Mmio>, sample_time: f64) {
    timer.start(sample_time);
    #[cfg(any(feature = "emulator", feature = "no-motor"))]
    firmware_stm32::servo_on_chip::set_sample_time(sample_time);
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
