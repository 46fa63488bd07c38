//! The paper's experiment on the chip, the servo simulated beside the loop: for a bare board or the
//! emulator. It prints the bits of the final estimates, which are those of the simulator on a PC.
#![no_std]
#![no_main]

use core::cell::RefCell;
use core::convert::Infallible;

use cortex_m_rt::entry;
use firmware_stm32::host::{Text, exit, print};
use firmware_stm32::paper;
use identifier_core::GradientLoop;
use identifier_core::control::Setpoint;
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::{FixedServoLoop, Word};
use identifier_core::identifier::Identify;
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{Ab, ServoParameters};
use identifier_core::settings::SettingsError;
use virtual_servo::{Encoder, Plant};

#[entry]
fn main() -> ! {
    let done = single_precision()
        .map(|found| report("f32", &found))
        .and_then(|()| fixed_point())
        .map(|found| report("fixed", &found));
    if done.is_err() {
        print(&["the experiment could not be built"]);
    }
    exit(done.is_ok())
}

fn report(format: &str, found: &ServoParameters) {
    let [a, b, load] = [found.a, found.b, found.load].map(Text::bits);
    print(&[format, a.as_str(), b.as_str(), load.as_str()]);
}

/// A servo that both ends of the loop hold on to.
struct Virtual {
    plant: RefCell<Plant>,
    encoder: Encoder,
}

impl PositionSensor for &Virtual {
    type Error = Infallible;

    fn count(&mut self) -> Result<i32, Infallible> {
        Ok(self
            .plant
            .try_borrow()
            .map_or(0, |plant| self.encoder.read(plant.position) as i32))
    }
}

impl Actuator<f32> for &Virtual {
    type Error = Infallible;

    /// The command is held over the sample, at whose end this servo then is.
    fn hold(&mut self, command: f32) -> Result<(), Infallible> {
        if let Ok(mut plant) = self.plant.try_borrow_mut() {
            plant.advance(f64::from(command));
        }
        Ok(())
    }

    fn release(&mut self) -> Result<(), Infallible> {
        self.hold(0.0)
    }
}

fn single_precision() -> Result<ServoParameters, SettingsError> {
    let servo_loop: GradientLoop<f32, Ab, 2> = paper::settings().build()?;
    let reference = paper::reference()?;
    let (plant, encoder) = paper::servo();
    let servo = Virtual {
        plant: RefCell::new(plant),
        encoder,
    };
    let (mut sensor, mut actuator) = (&servo, &servo);
    let mut state = servo_loop.start(0);
    let mut wanted = Excitation::<f32>::start(&reference);
    for _ in 0..paper::samples() {
        let setpoint = Setpoint {
            count: 0,
            offset: reference.process(&mut wanted),
        };
        let taken = servo_loop.control_step(&mut state, setpoint, &mut sensor, &mut actuator);
        if let Ok(sample) = taken {
            servo_loop.learn(&mut state, &sample);
        }
    }
    Ok(servo_loop.identifier().estimates(state.identification()))
}

fn fixed_point() -> Result<ServoParameters, SettingsError> {
    let servo_loop: FixedServoLoop<LowPass<Word>, Ab, 2> = paper::settings().build()?;
    let reference = paper::reference()?;
    let (mut plant, encoder) = paper::servo();
    let mut state = servo_loop.start(0);
    let mut wanted = Excitation::<f64>::start(&reference);
    for _ in 0..paper::samples() {
        let next: f64 = reference.process(&mut wanted);
        let Setpoint {
            count: setpoint,
            offset,
        } = Setpoint::from_counts(next);
        let count = encoder.read(plant.position) as i32;
        if let Ok(step) = servo_loop.process(&mut state, setpoint, offset, count) {
            let command = servo_loop.controller().command(step.control.command);
            plant.advance(command);
        }
    }
    Ok(servo_loop.identifier().estimates(state.identification()))
}
