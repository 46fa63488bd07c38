//! A firmware that was there before the identifier: its own main loop, its own ways to measure and
//! to act. The identifier is linked in and asked once the loop has run.
//!
//! ```sh
//! cargo build --release --target thumbv7em-none-eabihf
//! ```
//!
//! (or `thumbv6m-none-eabi`, or `thumbv8m.main-none-eabihf`). Here the servo is a few lines of
//! arithmetic, so that it runs in an emulator too; it ends well if the gain is found within 2 %.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use cortex_m_semihosting::debug;
use identifier_core::adaptation::PositiveDefinite;
use identifier_core::control::{CommandLimit, ControlState, Gains};
use identifier_core::excitation::{Excitation, Prbs};
use identifier_core::identifier::{
    Bounds, GradientIdentifier, GradientLaw, IdentifierConfig, IdentifierError,
};
use identifier_core::interval::Interval;
use identifier_core::measurement::velocity::LowPass;
use identifier_core::model::ServoParameters;
use identifier_core::parameters::Ab;
use identifier_core::units::Units;

/// What the servo is, which the firmware does not know: a (1/s) and b (rad/s² per command unit).
const TRUE: (f32, f32) = (2.0, 257.7);

const SAMPLE_TIME: f32 = 1e-3;
const RAD_PER_COUNT: f32 = core::f32::consts::TAU / 10_000.0;

#[entry]
fn main() -> ! {
    let well = run().is_ok_and(|found| (found.b / f64::from(TRUE.1) - 1.0).abs() < 0.02);
    debug::exit(if well {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    loop {
        cortex_m::asm::wfi();
    }
}

fn run() -> Result<ServoParameters, IdentifierError> {
    let units = Units::new(f64::from(SAMPLE_TIME), f64::from(RAD_PER_COUNT))?;
    let config = IdentifierConfig {
        units,
        gains: Gains::new(9.0, 0.19, 4.0)?,
        limit: CommandLimit::symmetric(10.0)?,
        plant_box: None,
        initial: ServoParameters {
            a: 0.0,
            b: 150.0,
            coulomb: 0.0,
            load: 0.0,
        },
        bounds: Bounds {
            a: Interval::new("bounds.a", 0.0, 50.0)?,
            b: Interval::new("bounds.b", 110.0, 1000.0)?,
            coulomb: Interval::new("bounds.coulomb", 0.0, 100.0)?,
            load: Interval::new("bounds.load", -100.0, 100.0)?,
        },
    };
    let velocity = LowPass::<f32>::new(&units, 500.0)?;
    let controller = config.controller(velocity);
    let law = GradientLaw {
        gamma: PositiveDefinite::diagonal([20.0, 3000.0])?,
        mu: None,
        frozen: [false; 2],
    };
    let identifier = GradientIdentifier::<f32, _, Ab, 2>::new(&config, &law, velocity)?;
    let reference = Prbs::new(&units, 0.3, 0.05, 9)?;

    let mut control = ControlState::at_rest(0.0);
    let mut learnt = identifier.start();
    let mut wanted = Excitation::<f32>::start(&reference);
    let mut servo = Servo {
        position: 0.0,
        velocity: 0.0,
    };
    for _ in 0..8000 {
        let target: f32 = reference.process(&mut wanted);
        if let Ok(sample) = controller.process(&mut control, target, servo.count()) {
            servo.advance(sample.command);
            identifier.process(&mut learnt, &sample);
        }
    }
    Ok(identifier.estimates(&learnt))
}

/// The servo, rad.
struct Servo {
    position: f32,
    velocity: f32,
}

impl Servo {
    /// The encoder's count.
    fn count(&self) -> f32 {
        const PER_RAD: f32 = 1.0 / RAD_PER_COUNT;
        // Towards zero: an encoder's edges lie anywhere.
        ((self.position * PER_RAD) as i32) as f32
    }

    fn advance(&mut self, command: f32) {
        let acceleration = TRUE.1 * command - TRUE.0 * self.velocity;
        self.position += SAMPLE_TIME * (self.velocity + 0.5 * SAMPLE_TIME * acceleration);
        self.velocity += SAMPLE_TIME * acceleration;
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
