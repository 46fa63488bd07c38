//! An existing firmware with its own main loop, measurement and output. The PID of this project closes the
//! loop, and the identifier estimates the servo while it runs.
//!
//! ```sh
//! cargo build --release --target thumbv7em-none-eabihf
//! ```
//!
//! (or `thumbv6m-none-eabi`, or `thumbv8m.main-none-eabihf`). Here the servo is a few lines of
//! arithmetic, so that it runs in an emulator too; it ends well if the gain is found within 2 %.
#![no_std]
#![no_main]

mod count;

use cortex_m_rt::entry;
use cortex_m_semihosting::debug;
use count::Count;
use identifier_core::identifier::Identify;
use identifier_core::measurement::Counter;
use identifier_core::parameters::Ab;
use identifier_core::settings::{BoxSettings, diagonal};
use identifier_core::{ControllerSettings, GradientLoop, Settings};

/// The true servo, which the firmware does not know: a (1/s) and b (rad/s² per command unit).
const TRUE: (f32, f32) = (2.0, 257.7);

const SAMPLE_TIME: f32 = 1e-3;
const COUNTS_PER_REV: f32 = 10_000.0;

#[entry]
fn main() -> ! {
    let well = run().is_some_and(|gain| (gain / f64::from(TRUE.1) - 1.0).abs() < 0.02);
    debug::exit(if well {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    loop {
        cortex_m::asm::wfi();
    }
}

fn run() -> Option<f64> {
    let mut settings = Settings {
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(SAMPLE_TIME.into(), COUNTS_PER_REV.into())
    };
    settings.identifier.plant_box = Some(BoxSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    settings.identifier.gamma = Some(diagonal([20.0, 3000.0, 0.0, 0.0]));
    let servo_loop: GradientLoop<f32, Ab, 2> = settings.build().ok()?;

    let mut servo = Servo::default();
    let mut encoder = Counter::new(servo.register());
    let mut state = servo_loop.start(0);
    let mut instructions = Count::start();
    for sample in 0..8000 {
        // To and fro by 1000 counts, three times in two seconds.
        let way = sample % 680;
        let setpoint = 3 * if way < 340 { way } else { 680 - way };
        let register = servo.register();
        let command = instructions.count(|| {
            let count = encoder.read(register);
            let step = servo_loop.process(&mut state, setpoint, 0.0, count);
            step.map(|step| step.control.command)
        });
        servo.advance(command.ok()?);
    }
    instructions.print();
    Some(servo_loop.identifier().estimates(state.identification()).b)
}

/// The servo, rad.
#[derive(Default)]
struct Servo {
    position: f32,
    velocity: f32,
}

impl Servo {
    /// The encoder's counter, of 16 bits.
    fn register(&self) -> u16 {
        const PER_RAD: f32 = COUNTS_PER_REV / core::f32::consts::TAU;
        // Towards zero: an encoder's edges lie anywhere.
        ((self.position * PER_RAD) as i32) as u16
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
