//! One experiment in every number format, side by side on the same measurements: what a format
//! makes of them.
//!
//! The loop around the servo is closed in double precision. Every format has a controller and a
//! Γ-gradient identifier of its own that are given the same setpoints and counts; they act on
//! nothing.

mod format;
mod statistics;

pub use format::{Format, Signals};
pub use statistics::{Difference, Differences};

use format::{fixed, floating};
use identifier_core::control::{ControlState, Controller};
use identifier_core::identifier::IdentifierError;
use identifier_core::measurement::velocity::VelocityEstimate;

use crate::scenario::{Scenario, WithVelocity};
use virtual_servo::{Encoder, Plant};

/// What one sample showed in every format, in the order of [`Format::ALL`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compared {
    /// Time, s.
    pub time: f64,
    /// Of each format.
    pub signals: [Signals; 3],
}

/// Runs `samples` samples of a scenario in every format, the servo so many turns from where its
/// encoder counted zero, and shows each to `observe`. `reference` gives the reference of a sample,
/// rad from where the servo is.
///
/// # Errors
/// What does not fit a format.
pub fn run(
    scenario: &Scenario,
    turns: u32,
    samples: u64,
    reference: &mut dyn FnMut(u64) -> f64,
    observe: &mut dyn FnMut(&Compared),
) -> Result<(), IdentifierError> {
    let work = Loop {
        scenario,
        turns,
        samples,
        reference,
        observe,
    };
    scenario.velocity.with::<f64, _>(work)
}

struct Loop<'a> {
    scenario: &'a Scenario,
    turns: u32,
    samples: u64,
    reference: &'a mut dyn FnMut(u64) -> f64,
    observe: &'a mut dyn FnMut(&Compared),
}

impl WithVelocity<f64> for Loop<'_> {
    type Output = Result<(), IdentifierError>;

    fn with<V: VelocityEstimate<f64> + 'static>(self) -> Self::Output {
        let Self {
            scenario,
            turns,
            samples,
            reference,
            observe,
        } = self;
        let settings = scenario.settings()?;
        let units = settings.units()?;
        let unit = units.position_unit();
        let encoder = Encoder::new(std::f64::consts::TAU / unit);
        // The counter of the encoder wraps at 32 bits.
        let start = (f64::from(turns) * std::f64::consts::TAU / unit).round() as i64 as i32;
        let mut formats = [
            floating::<f64>(scenario, &settings, start)?,
            floating::<f32>(scenario, &settings, start)?,
            fixed(scenario, &settings, start)?,
        ];
        let controller: Controller<f64, V> = settings.build()?;
        let mut control = ControlState::default();
        let mut before = 0;
        let servo = scenario
            .plant
            .unwrap_or(identifier_core::model::ServoParameters {
                a: 0.0,
                b: 1.0,
                coulomb: 0.0,
                load: 0.0,
            });
        let mut plant = Plant::at_rest(&servo, units.sample_time());
        for k in 0..samples {
            let wanted = reference(k) / unit;
            let count = encoder.read(plant.position);
            let (error, increment) = (wanted - count as f64, (count - before) as f64);
            before = count;
            let Ok(real) = controller.process(&mut control, error, increment) else {
                break;
            };
            // The servo is where it is; its count is as far away as its user has turned it.
            let register = start.wrapping_add(count as i32);
            let signals = formats
                .each_mut()
                .map(|format| format.process(start, wanted, register));
            observe(&Compared {
                time: k as f64 * units.sample_time(),
                signals,
            });
            plant.advance(real.command);
        }
        Ok(())
    }
}
