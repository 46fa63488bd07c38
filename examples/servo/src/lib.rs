//! A simulated servo instead of a timer in encoder mode and a PWM, and the end of a program in an emulator.
#![no_std]

use cortex_m_semihosting::debug;

/// The sample time, s.
pub const SAMPLE_TIME: f32 = 1e-3;
/// The encoder's counts per revolution.
pub const COUNTS_PER_REV: f32 = 10_000.0;
/// Position of a count, rad.
pub const RAD_PER_COUNT: f32 = core::f32::consts::TAU / COUNTS_PER_REV;

/// a (1/s) and b (rad/s² per command unit), which a firmware does not know.
const A: f32 = 2.0;
const B: f32 = 257.7;

/// The servo, rad.
#[derive(Debug, Default)]
pub struct Servo {
    /// Coulomb friction and load, rad/s².
    forces: [f32; 2],
    position: f32,
    velocity: f32,
}

impl Servo {
    /// With Coulomb friction and a load, rad/s².
    pub fn with_forces(coulomb: f32, load: f32) -> Self {
        Self {
            forces: [coulomb, load],
            ..Self::default()
        }
    }

    /// The register of the encoder's counter, of 16 bits.
    pub fn register(&self) -> u16 {
        // Towards zero: an encoder's edges lie anywhere.
        ((self.position / RAD_PER_COUNT) as i32) as u16
    }

    /// Outputs a command, which acts until the next sample.
    pub fn output(&mut self, command: f32) {
        let [coulomb, load] = self.forces;
        let pushed = B * command - A * self.velocity + load;
        // Friction stops the servo before it turns it round.
        let stopped = self.velocity + SAMPLE_TIME * pushed;
        let rubbed = (SAMPLE_TIME * coulomb).min(stopped.abs()).copysign(stopped);
        let velocity = stopped - rubbed;
        self.position += 0.5 * SAMPLE_TIME * (self.velocity + velocity);
        self.velocity = velocity;
    }
}

/// A setpoint to and fro by 1000 counts, three times in two seconds.
pub fn setpoint(sample: u32) -> i32 {
    let way = (sample % 680) as i32;
    3 * if way < 340 { way } else { 680 - way }
}

/// True if b is found within 2 %.
pub fn is_found(b: f64) -> bool {
    (b / f64::from(B) - 1.0).abs() < 0.02
}

/// Ends the program in an emulator: well or not.
pub fn end(well: bool) -> ! {
    debug::exit(if well {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    loop {
        cortex_m::asm::wfi();
    }
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    end(false)
}
