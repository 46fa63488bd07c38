//! A firmware with a controller of its own, a cascade with feed-forward and a limit, which it keeps. The identifier
//! only observes: it gets the encoder's increment and the acting command, and needs neither the cascade nor the servo.
//! It records. The main loop makes the first fit, a few blocks at a time. After it every sample improves the estimates.
//!
//! ```sh
//! cargo build --release -p cascade --target thumbv7em-none-eabihf
//! ```
//!
//! (or `thumbv6m-none-eabi`, or `thumbv8m.main-none-eabihf`). Here the servo is simulated by a few lines, so the
//! example also runs in an emulator. It succeeds if the gain is found within 2 %.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use identifier_core::identifier::Identify;
use identifier_core::{AB_COULOMB_LOAD, GaussNewton, Settings};
use servo::{COUNTS_PER_REV, RAD_PER_COUNT, SAMPLE_TIME, Servo};

/// With a start record of 64 blocks, two kilobytes of state in all.
type Identifier = GaussNewton<f32, AB_COULOMB_LOAD, 64>;

#[entry]
fn main() -> ! {
    servo::end(run().is_some_and(servo::is_found))
}

fn run() -> Option<f64> {
    let settings = Settings::new(SAMPLE_TIME.into(), COUNTS_PER_REV.into());
    let identifier: Identifier = settings.build().ok()?;

    let mut servo = Servo::with_forces(6.0, -15.0);
    let mut cascade = Cascade::default();
    let mut learnt = identifier.start();
    let mut last = servo.register();
    for sample in 0..8000 {
        let register = servo.register();
        let moved = i32::from(register.wrapping_sub(last).cast_signed());
        last = register;
        // To and fro at 4 rad/s.
        let wanted = if sample / 170 % 2 == 0 { 4.0 } else { -4.0 };
        let command = cascade.command(wanted, moved);
        servo.output(command);
        identifier.process(&mut learnt, moved, command).ok()?;
        // The rest of the time until the next sample.
        identifier.work(&mut learnt, 8);
    }
    Some(identifier.estimates(&learnt)?.b)
}

/// The firmware's controller: P of the position, PI of the velocity, the wanted velocity fed forward.
#[derive(Default)]
struct Cascade {
    /// Position error, rad.
    error: f32,
    velocity: f32,
    integral: f32,
}

impl Cascade {
    /// Gain of the position, 1/s.
    const POSITION: f32 = 12.0;
    /// Gains of the velocity, command units per rad/s and per rad.
    const PROPORTIONAL: f32 = 0.25;
    const INTEGRAL: f32 = 4.0;
    /// Command units per rad/s wanted.
    const FORWARD: f32 = 0.02;
    /// Command units: less than turning round asks for.
    const LIMIT: f32 = 1.2;
    /// Cut-off of the velocity estimate, relative to the sample rate.
    const FILTER: f32 = 0.3;

    /// Towards a velocity (rad/s), after the encoder has moved by counts.
    fn command(&mut self, wanted: f32, moved: i32) -> f32 {
        let moved = moved as f32 * RAD_PER_COUNT;
        self.error += wanted * SAMPLE_TIME - moved;
        self.velocity += Self::FILTER * (moved / SAMPLE_TIME - self.velocity);
        let lag = wanted + Self::POSITION * self.error - self.velocity;
        let asked =
            Self::FORWARD * wanted + Self::PROPORTIONAL * lag + Self::INTEGRAL * self.integral;
        let command = asked.clamp(-Self::LIMIT, Self::LIMIT);
        if command == asked {
            self.integral += SAMPLE_TIME * lag;
        }
        command
    }
}
