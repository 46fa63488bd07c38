//! An [embassy](https://embassy.dev) firmware that identifies its servo while the core's PID drives it.
//!
//! Samples are a task of an executor in an interrupt, which preempts everything else; the SysTick wakes it. It sends the
//! pieces of the motion to a task of the thread executor, which has the memory of the estimator and sends corrections back.
//! It regularly sends a snapshot of the estimates to another task, which converts them to SI and reports.
//! The configuration is built once and shared by both. The crate `lm3s6965` gives only the number of an interrupt: use
//! that of your chip instead.
//!
//! ```sh
//! cargo build --release -p embassy --target thumbv7em-none-eabihf
//! ```
#![no_std]
#![no_main]

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;
use cortex_m_semihosting::hprintln;
use embassy_executor::{InterruptExecutor, Spawner};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use identifier_core::identifier::{
    GradientCorrection, GradientRecursion, Identify, MachineEstimates, MeasuredPiece, ServoLoop,
};
use identifier_core::measurement::{Counter, LowPass};
use identifier_core::parameters::{PerParameter, Unknowns};
use identifier_core::settings::SettingsError;
use identifier_core::{AB, Settings};
use lm3s6965::{Interrupt, interrupt};
use servo::{COUNTS_PER_REV, SAMPLE_TIME, Servo, setpoint};

type Estimator = GradientRecursion<f32, LowPass<f32>, Unknowns<AB>, AB>;
type Loop = ServoLoop<f32, LowPass<f32>, Estimator>;
type Snapshot = <Estimator as Identify<f32>>::Snapshot;
type Piece = (MeasuredPiece<f32>, PerParameter<f32>);

/// Samples between two reports.
const REPORT: u32 = 1000;

/// SysTick's clock cycles of a sample: an emulator need not wait for the servo's time.
const TICKS: u32 = 2000;

static SAMPLES: InterruptExecutor = InterruptExecutor::new();
static TICK: Signal<CriticalSectionRawMutex, ()> = Signal::new();
static PIECES: Channel<CriticalSectionRawMutex, Piece, 4> = Channel::new();
static CORRECTIONS: Signal<CriticalSectionRawMutex, GradientCorrection<f32>> = Signal::new();
static REPORTS: Channel<CriticalSectionRawMutex, Snapshot, 2> = Channel::new();

#[exception]
fn SysTick() {
    TICK.signal(());
}

/// An interrupt that nothing else uses: the executor triggers it.
#[interrupt]
fn SSI0() {
    // SAFETY: this is the interrupt that the executor was started with.
    unsafe { SAMPLES.on_interrupt() }
}

/// PID and gradient estimator, certified for a parameter range.
fn build() -> Result<Loop, SettingsError> {
    Settings::new(SAMPLE_TIME.into(), COUNTS_PER_REV.into())
        .with_pid(9.0, 0.19, 4.0, 2.0)
        .with_servo_range([0.0, 50.0], [110.0, 1000.0])
        .build()
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let (Ok(servo_loop), Some(mut core)) = (build(), cortex_m::Peripherals::take()) else {
        servo::end(false);
    };
    let Some(servo_loop) = cortex_m::singleton!(LOOP: Loop = servo_loop) else {
        servo::end(false);
    };
    let servo_loop: &'static Loop = servo_loop;
    // SAFETY: nothing relies on a priority that is masked.
    unsafe { core.NVIC.set_priority(Interrupt::SSI0, 1 << 5) };
    let samples = SAMPLES.start(Interrupt::SSI0);
    let tasks = (sample(servo_loop), remember(servo_loop), report(servo_loop));
    if let (Ok(sample), Ok(remember), Ok(report)) = tasks {
        samples.spawn(sample);
        spawner.spawn(remember);
        spawner.spawn(report);
    }
    core.SYST.set_clock_source(SystClkSource::Core);
    core.SYST.set_reload(TICKS - 1);
    core.SYST.clear_current();
    core.SYST.enable_counter();
    core.SYST.enable_interrupt();
}

/// Reads the encoder, controls, identifies.
#[embassy_executor::task]
async fn sample(servo_loop: &'static Loop) {
    let mut servo = Servo::default();
    let mut encoder = Counter::new(servo.register());
    let mut state = servo_loop.start(0);
    for sample in 0_u32.. {
        TICK.wait().await;
        let count = encoder.read(servo.register());
        let command = match servo_loop.process(&mut state, setpoint(sample), 0.0, count) {
            Ok(step) => step.control.command,
            Err(_) => 0.0,
        };
        servo.output(command);
        let (identifier, learnt) = (servo_loop.identifier(), state.identification_mut());
        if let Some(correction) = CORRECTIONS.try_take() {
            identifier.take_over(learnt, &correction);
        }
        if let Some(piece) = identifier.take_piece(learnt) {
            // The memory notices one that finds no room.
            let _ = PIECES.try_send((piece, identifier.machine_estimates(learnt)));
        }
        if sample % REPORT == REPORT - 1 {
            let snapshot = servo_loop.identifier().snapshot(state.identification());
            // A report that nothing has taken yet is enough.
            let _ = REPORTS.try_send(snapshot);
        }
    }
}

/// Remembers the motion, and corrects the estimates by it.
#[embassy_executor::task]
async fn remember(servo_loop: &'static Loop) {
    let memory = servo_loop.identifier().memory();
    let mut state = memory.start();
    loop {
        let (piece, estimates) = PIECES.receive().await;
        if let Some(correction) = memory.process(&mut state, &piece, &estimates) {
            CORRECTIONS.signal(correction);
        }
    }
}

/// Reports the estimates; it ends well if the gain is found within 2 %.
#[embassy_executor::task]
async fn report(servo_loop: &'static Loop) {
    for _ in 0..8 {
        let snapshot = REPORTS.receive().await;
        let found = servo_loop.identifier().estimates_in(&snapshot);
        hprintln!("a = {:.2} 1/s, b = {:.1} rad/s2", found.a, found.b);
        if servo::is_found(found.b) {
            servo::end(true);
        }
    }
    servo::end(false);
}
