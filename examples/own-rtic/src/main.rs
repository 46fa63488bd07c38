//! An [RTIC](https://rtic.rs) firmware that identifies its servo while the core's PID drives it.
//!
//! Samples are a hardware task of high priority, bound to the SysTick. Every so often it starts a software task of low
//! priority with a snapshot of the estimates, a few words, which converts them to SI and reports. The configuration is
//! built once and shared by both, without a lock. Of the crate `lm3s6965` only the numbers of interrupts are used, which every
//! Cortex-M has: put that of your chip in its place.
//!
//! ```sh
//! cargo build --release --target thumbv7em-none-eabihf
//! ```
#![no_std]
#![no_main]

mod servo;

use cortex_m_semihosting::debug;

#[rtic::app(device = lm3s6965, peripherals = false, dispatchers = [SSI0])]
mod app {
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m_semihosting::{debug, hprintln};
    use identifier_core::identifier::{DiagonalGradientIdentifier, Identify, ServoLoopState};
    use identifier_core::measurement::{Counter, LowPass, VelocityEstimate};
    use identifier_core::parameters::Ab;
    use identifier_core::settings::{BoxSettings, SettingsError, diagonal};
    use identifier_core::{ControllerSettings, GradientLoop, Settings};

    use crate::servo::{COUNTS_PER_REV, SAMPLE_TIME, Servo, TRUE};

    type Identifier = DiagonalGradientIdentifier<f32, LowPass<f32>, Ab, 2>;
    type Loop = GradientLoop<f32, Ab, 2>;
    type State = ServoLoopState<
        f32,
        <LowPass<f32> as VelocityEstimate<f32>>::State,
        <Identifier as Identify<f32>>::State,
    >;
    type Snapshot = <Identifier as Identify<f32>>::Snapshot;

    /// Samples between two reports.
    const REPORT: u32 = 1000;

    /// SysTick's clock cycles of a sample: an emulator need not wait for the servo's time.
    const TICKS: u32 = 2000;

    #[shared]
    struct Shared {
        servo_loop: &'static Loop,
    }

    #[local]
    struct Local {
        servo: Servo,
        encoder: Counter<u16>,
        state: State,
        sample: u32,
    }

    /// PID and gradient law, certified for a box of servos.
    fn build() -> Result<Loop, SettingsError> {
        let mut settings = Settings {
            controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
            ..Settings::new(SAMPLE_TIME.into(), COUNTS_PER_REV.into())
        };
        settings.identifier.plant_box = Some(BoxSettings {
            a: [0.0, 50.0],
            b: [110.0, 1000.0],
        });
        settings.identifier.gamma = Some(diagonal([20.0, 3000.0, 0.0, 0.0]));
        settings.build()
    }

    #[init(local = [own: Option<Loop> = None])]
    fn init(mut context: init::Context) -> (Shared, Local) {
        let Ok(servo_loop) = build() else {
            debug::exit(debug::EXIT_FAILURE);
            loop {}
        };
        let servo_loop: &'static Loop = context.local.own.insert(servo_loop);
        let clock = &mut context.core.SYST;
        clock.set_clock_source(SystClkSource::Core);
        clock.set_reload(TICKS - 1);
        clock.clear_current();
        clock.enable_counter();
        clock.enable_interrupt();
        let servo = Servo::default();
        let shared = Shared { servo_loop };
        let local = Local {
            encoder: Counter::new(servo.register()),
            servo,
            state: servo_loop.start(0),
            sample: 0,
        };
        (shared, local)
    }

    /// Reads the encoder, controls, identifies.
    #[task(binds = SysTick, priority = 2, local = [servo, encoder, state, sample], shared = [&servo_loop])]
    fn sample(context: sample::Context) {
        let sample::LocalResources {
            servo,
            encoder,
            state,
            sample,
            ..
        } = context.local;
        let servo_loop = *context.shared.servo_loop;
        let count = encoder.read(servo.register());
        // To and fro by 1000 counts, three times in two seconds.
        let way = (*sample % 680) as i32;
        let setpoint = 3 * if way < 340 { way } else { 680 - way };
        let command = match servo_loop.process(state, setpoint, 0.0, count) {
            Ok(step) => step.control.command,
            Err(_) => 0.0,
        };
        servo.output(command);
        *sample = sample.wrapping_add(1);
        if sample.is_multiple_of(REPORT) {
            let snapshot = servo_loop.identifier().snapshot(state.identification());
            // A report that has not ended yet is enough.
            let _ = report::spawn(snapshot);
        }
    }

    /// Reports the estimates; it ends well if the gain is found within 2 %.
    #[task(priority = 1, local = [reports: u32 = 0], shared = [&servo_loop])]
    async fn report(context: report::Context, snapshot: Snapshot) {
        let found = context
            .shared
            .servo_loop
            .identifier()
            .estimates_in(&snapshot);
        hprintln!("a = {:.2} 1/s, b = {:.1} rad/s2", found.a, found.b);
        *context.local.reports += 1;
        if (found.b / f64::from(TRUE.1) - 1.0).abs() < 0.02 {
            debug::exit(debug::EXIT_SUCCESS);
        } else if *context.local.reports == 8 {
            debug::exit(debug::EXIT_FAILURE);
        }
    }
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}
