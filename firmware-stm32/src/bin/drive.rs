//! The drive: controls and identifies a real servo.
//!
//! Three things happen, each at its own pace. TIM5 interrupts at every sample, above everything else,
//! runs the sampler and feeds the watchdog, as long as the background is seen to run. USART2 interrupts
//! at every byte. In between, the background reads requests, reports and keeps records.
#![no_std]
#![no_main]

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::{ExceptionFrame, entry, exception};
use drive_chip::{Mmio, interrupts, sample_timer};
use drive_link::{LONGEST_FRAME, Receiver, Report, Request, State, frame};
use drive_logic::{Events, Orders, Sampler, Supervisor, self_test};
use firmware_stm32::board::{
    self, Encoder, Inputs, Line, Output, Port, RecordFlash, Watchdog, Wired,
};
use firmware_stm32::handed::Handed;
use firmware_stm32::settings;
use stm32f4xx_hal::pac::interrupt;

/// What belongs to the sample interrupt.
struct Control {
    sampler: Sampler<'static>,
    encoder: Encoder,
    output: Output,
    inputs: Inputs,
    watchdog: Watchdog,
}

static CONTROL: Handed<Control> = Handed::new();
static PORT: Handed<Port> = Handed::new();

/// Samples until the background is missed.
static SEEN_FOR: AtomicU32 = AtomicU32::new(0);

#[interrupt]
fn TIM5() {
    static mut OWN: Option<Control> = None;
    sample_timer::acknowledge(Mmio);
    if OWN.is_none() {
        *OWN = CONTROL.take();
    }
    let Some(Control {
        sampler,
        encoder,
        output,
        inputs,
        watchdog,
    }) = OWN
    else {
        return;
    };
    sampler.sample(inputs.read(), encoder, output);
    sampler.ended(sample_timer::is_due(Mmio), output);
    if let Some(left) = SEEN_FOR.load(Ordering::Relaxed).checked_sub(1) {
        SEEN_FOR.store(left, Ordering::Relaxed);
        watchdog.feed();
    }
}

#[interrupt]
fn USART2() {
    static mut OWN: Option<Port> = None;
    if OWN.is_none() {
        *OWN = PORT.take();
    }
    if let Some(port) = OWN {
        port.serve();
    }
}

/// Whatever the program cannot go on from lets the servo go, and the watchdog resets the chip.
fn give_up() -> ! {
    board::let_go();
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

/// The crystal failed.
#[exception]
unsafe fn NonMaskableInt() {
    give_up()
}

#[entry]
fn main() -> ! {
    if let Some((wired, orders, events)) = parts() {
        run(wired, orders, events);
    }
    // Only a second start without a reset ends here.
    loop {
        cortex_m::asm::wfi();
    }
}

fn parts() -> Option<(Wired, &'static mut Orders, &'static mut Events)> {
    Some((
        board::wire()?,
        cortex_m::singleton!(: Orders = Orders::new())?,
        cortex_m::singleton!(: Events = Events::new())?,
    ))
}

fn run(wired: Wired, orders: &'static mut Orders, events: &'static mut Events) {
    let Wired {
        encoder,
        output,
        inputs,
        timer,
        mut line,
        port,
        flash,
        watchdog,
        found,
    } = wired;
    let (give_orders, take_orders) = orders.split();
    let (tell, hear) = events.split();
    let mut supervisor = Supervisor::new(
        give_orders,
        hear,
        (flash, 0),
        &settings::built_in(),
        board::FULL_SCALE,
    );
    CONTROL.give(Control {
        sampler: Sampler::new(take_orders, tell, self_test().and(found)),
        encoder,
        output,
        inputs,
        watchdog,
    });
    PORT.give(port);
    let mut sample_time = supervisor.sample_time();
    timer.start(sample_time);
    interrupts::begin(Mmio);

    let mut receiver = Receiver::new();
    let mut state = supervisor.state();
    log(state);
    be_seen(state, sample_time);
    watchdog.start();
    loop {
        let more = converse(&mut line, &mut receiver, &mut supervisor);
        if supervisor.state() != state {
            state = supervisor.state();
            log(state);
        }
        let wanted = supervisor.sample_time();
        if wanted.to_bits() != sample_time.to_bits() {
            sample_time = wanted;
            timer.start(sample_time);
        }
        be_seen(state, sample_time);
        if !more {
            cortex_m::asm::wfi();
        }
    }
}

/// Lets the samples feed the watchdog for a while. A servo that is let go can wait, for the check of a
/// configuration (46 million instructions) or for the flash; one that moves must be stopped in time.
fn be_seen(state: State, sample_time: f64) {
    let patience = match state {
        State::Running => 10e-3,
        State::Released | State::Faulted(_) => 10.0,
    };
    // A cast saturates.
    SEEN_FOR.store((patience / sample_time) as u32, Ordering::Relaxed);
}

/// Reports what is new and answers one request, as far as the line has room; true if there may be
/// more.
fn converse(
    line: &mut Line,
    receiver: &mut Receiver,
    supervisor: &mut Supervisor<'_, RecordFlash>,
) -> bool {
    while line.has_room(LONGEST_FRAME)
        && let Some(report) = supervisor.news()
    {
        say(line, &report);
    }
    while line.has_room(LONGEST_FRAME)
        && let Some(byte) = line.hear()
    {
        match receiver.take::<Request>(byte) {
            Some(Ok(request)) => {
                say(line, &supervisor.answer(&request));
                return true;
            }
            Some(Err(_)) => supervisor.garbled(),
            None => {}
        }
    }
    false
}

fn say(line: &mut Line, report: &Report) {
    if let Ok(framed) = frame(report) {
        line.say(&framed);
    }
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
