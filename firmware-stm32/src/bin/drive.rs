//! The drive: controls and identifies a real servo.
//!
//! Three things happen, each at its own pace. TIM5 interrupts at every sample, above everything else,
//! and runs the sampler. USART2 interrupts at every byte. In between, the background reads requests,
//! reports, keeps records and feeds the watchdog, as long as the samples are seen to run.
#![no_std]
#![no_main]

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::NVIC;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use drive_link::{LONGEST_FRAME, Receiver, Report, Request, State, frame};
use drive_logic::{Events, Orders, Sampler, Supervisor, self_test};
use firmware_stm32::board::{self, Encoder, Inputs, Output, Wired};
use firmware_stm32::handed::Handed;
use firmware_stm32::internal_flash::InternalFlash;
use firmware_stm32::serial::{Line, Port};
use firmware_stm32::settings;
use firmware_stm32::timer::SampleTimer;
use stm32f4xx_hal::pac::{Interrupt, interrupt};
use stm32f4xx_hal::prelude::*;

/// What belongs to the sample interrupt.
struct Control {
    sampler: Sampler<'static>,
    encoder: Encoder,
    output: Output,
    inputs: Inputs,
}

static CONTROL: Handed<Control> = Handed::new();
static PORT: Handed<Port<'static>> = Handed::new();

/// Set at every sample, cleared when the watchdog is fed.
static ALIVE: AtomicBool = AtomicBool::new(false);

#[interrupt]
fn TIM5() {
    static mut OWN: Option<Control> = None;
    SampleTimer::acknowledge();
    if OWN.is_none() {
        *OWN = CONTROL.take();
    }
    let Some(Control {
        sampler,
        encoder,
        output,
        inputs,
    }) = OWN
    else {
        return;
    };
    sampler.sample(inputs.read(), encoder, output);
    sampler.ended(SampleTimer::is_due(), output);
    ALIVE.store(true, Ordering::Relaxed);
}

#[interrupt]
fn USART2() {
    static mut OWN: Option<Port<'static>> = None;
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
        mut timer,
        mut line,
        port,
        flash,
        mut watchdog,
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
    });
    PORT.give(port);
    let mut sample_time = supervisor.sample_time();
    timer.start(sample_time);
    begin_interrupts();

    let mut receiver = Receiver::new();
    let mut state = supervisor.state();
    log(state);
    watchdog.start(patience(state).millis());
    loop {
        let more = converse(&mut line, &mut receiver, &mut supervisor);
        if supervisor.state() != state {
            state = supervisor.state();
            log(state);
            watchdog.start(patience(state).millis());
        }
        let wanted = supervisor.sample_time();
        if wanted.to_bits() != sample_time.to_bits() {
            sample_time = wanted;
            timer.start(sample_time);
        }
        if ALIVE.swap(false, Ordering::Relaxed) {
            watchdog.feed();
        }
        if !more {
            cortex_m::asm::wfi();
        }
    }
}

/// How long samples may be missed, ms. A servo that is let go can wait while the flash erases, which
/// stops the processor for two seconds at most; one that moves cannot.
fn patience(state: State) -> u32 {
    match state {
        State::Running => 10,
        State::Released | State::Faulted(_) => 10_000,
    }
}

/// Reports what is new and answers one request, as far as the line has room; true if there may be
/// more.
fn converse(
    line: &mut Line<'_>,
    receiver: &mut Receiver,
    supervisor: &mut Supervisor<'_, InternalFlash>,
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

fn say(line: &mut Line<'_>, report: &Report) {
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

fn begin_interrupts() {
    /// Below every sample.
    const LATER: u8 = 0x80;
    if let Some(mut core) = cortex_m::Peripherals::take() {
        // SAFETY: no critical section depends on priorities.
        unsafe { core.NVIC.set_priority(Interrupt::USART2, LATER) };
    }
    // SAFETY: what they need was handed over.
    unsafe {
        NVIC::unmask(Interrupt::USART2);
        NVIC::unmask(Interrupt::TIM5);
    }
}
