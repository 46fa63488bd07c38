//! The paper's experiment on the chip, the servo simulated beside the loop: for a bare board or the
//! emulator. It prints the bits of the final estimates, which are those of the simulator on a PC.
#![no_std]
#![no_main]

use core::cell::RefCell;
use core::convert::Infallible;

use cortex_m_rt::entry;
use firmware_stm32::host::{Text, exit, say};
use firmware_stm32::paper;
use identifier_core::drive::{Actuator, PositionSensor, Tick, TickState};
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::{
    FixedGradientIdentifier, FixedLowPass, Ranges, reference_of_counts,
};
use identifier_core::identifier::{GradientIdentifier, IdentifierError};
use identifier_core::measurement::velocity::LowPass;
use identifier_core::model::ServoParameters;
use identifier_core::parameters::Ab;
use virtual_servo::{Encoder, Plant};

#[entry]
fn main() -> ! {
    let done = single_precision()
        .map(|found| report("f32", &found))
        .and_then(|()| fixed_point())
        .map(|found| report("fixed", &found));
    if done.is_err() {
        say(&["the experiment could not be built"]);
    }
    exit(done.is_ok())
}

fn report(format: &str, found: &ServoParameters) {
    let [a, b, load] = [found.a, found.b, found.load].map(Text::bits);
    say(&[format, a.as_str(), b.as_str(), load.as_str()]);
}

/// A servo that both ends of the loop hold on to.
struct Virtual {
    plant: RefCell<Plant>,
    encoder: Encoder,
}

impl PositionSensor for &Virtual {
    type Error = Infallible;

    fn count(&mut self) -> Result<i64, Infallible> {
        Ok(self
            .plant
            .try_borrow()
            .map_or(0, |plant| self.encoder.read(plant.position)))
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

fn single_precision() -> Result<ServoParameters, IdentifierError> {
    let config = paper::config()?;
    let velocity = paper::velocity::<f32>(&config.units)?;
    let identifier =
        GradientIdentifier::<f32, LowPass<f32>, Ab, 2>::new(&config, &paper::law()?, velocity)?;
    let reference = paper::reference(&config.units)?;
    let (plant, encoder) = paper::servo();
    let servo = Virtual {
        plant: RefCell::new(plant),
        encoder,
    };
    let (mut sensor, mut actuator) = (&servo, &servo);
    let tick = Tick::new(identifier.controller());
    let mut state = TickState::at_rest(0);
    let mut learnt = identifier.start();
    let mut wanted = Excitation::<f32>::start(&reference);
    for _ in 0..paper::samples() {
        let next = reference.process(&mut wanted);
        if let Ok(ticked) = tick.step(&mut state, next, &mut sensor, &mut actuator) {
            identifier.process(&mut learnt, &ticked.sample);
        }
    }
    Ok(identifier.estimates(&learnt))
}

fn fixed_point() -> Result<ServoParameters, IdentifierError> {
    let config = paper::config()?;
    let ranges = Ranges::of(&config);
    let velocity = paper::velocity::<f64>(&config.units)?;
    let identifier = FixedGradientIdentifier::<FixedLowPass, Ab, 2>::new(
        &config,
        &paper::law()?,
        &ranges,
        velocity,
    )?;
    let reference = paper::reference(&config.units)?;
    let (mut plant, encoder) = paper::servo();
    let controller = identifier.controller();
    let mut control = controller.start(0);
    let mut learnt = identifier.start();
    let mut wanted = Excitation::<f64>::start(&reference);
    for _ in 0..paper::samples() {
        let next: f64 = reference.process(&mut wanted);
        let count = encoder.read(plant.position);
        let sample = controller.process(&mut control, reference_of_counts(next), count);
        identifier.process(&mut learnt, &sample);
        plant.advance(controller.command(&sample));
    }
    Ok(identifier.estimates(&learnt))
}
