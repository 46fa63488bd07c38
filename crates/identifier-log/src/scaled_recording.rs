//! A run or a log as the fit takes it, and the units of its effects.

use identifier_core::parameters::{Parameter, ServoParameters, Unknown};
use identifier_core::settings::TermSettings;
use log_fit::fit::{Effect, Values};

use crate::experiment::TermEstimate;
use crate::motion_unit::{AxisKind, MotionUnit};
use crate::scenario::Options;
use log_fit::{Logged, Recording};

/// A recording with its units in SI.
pub(crate) struct ScaledRecording<'a> {
    pub(crate) recording: Recording<'a>,
    pub(crate) scale: Scale,
}

impl<'a> ScaledRecording<'a> {
    /// Scales the samples of a scenario's servo.
    pub(crate) fn new(scenario: &Options, samples: &'a [Logged]) -> Self {
        let units = scenario.units();
        let recording = Recording::new(samples, scenario.axis());
        let scale = Scale {
            unit: scenario.motion_unit(),
            time: units.sample_time() * recording.block,
            position: units.position_unit(),
        };
        Self { recording, scale }
    }
}

/// Units of a record.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    /// The unit of positions.
    pub(crate) unit: MotionUnit,
    /// Seconds to a sample.
    pub(crate) time: f64,
    /// Units of position to a count.
    pub(crate) position: f64,
}

/// The servo of a number for each of its four effects.
pub(crate) fn servo_of(number: impl Fn(Effect) -> f64) -> ServoParameters {
    let [a, b, coulomb, load] = [Effect::A, Effect::B, Effect::Coulomb, Effect::Load].map(number);
    ServoParameters::new(a, b, coulomb, load)
}

impl Scale {
    /// A recording in SI.
    pub(crate) const SI: Self = Self {
        unit: MotionUnit::Stated(AxisKind::Rotary),
        time: 1.0,
        position: 1.0,
    };

    /// The declared amplifier and the settings of declared terms, but for the delay.
    pub(crate) fn declared(&self, terms: &TermSettings) -> Values {
        let mut declared = Values::NONE;
        for (effect, value) in [
            (Effect::DeadBand, terms.dead_band),
            (Effect::CurrentLoop, terms.current_loop),
            (
                Effect::LowSpeedVelocity,
                terms.low_speed_velocity.unwrap_or(0.0),
            ),
        ] {
            declared.set(effect, value / self.of(effect));
        }
        declared.orders[1] = terms.ripple_order.unwrap_or(declared.orders[1]);
        declared
    }

    /// A model in the units of a record: four parameters, the terms that have entered, and what the scenario declares.
    pub(crate) fn model(
        &self,
        scenario: &Options,
        servo: &ServoParameters,
        terms: &[TermEstimate],
    ) -> Values {
        let declared = &scenario.stated.identifier.terms;
        let of_servo = Parameter::ALL.map(|one| (Unknown::from(one), servo.get(one)));
        let found = terms.iter().map(|term| (term.unknown, term.value));
        let sizes = std::iter::once((Unknown::Delay, declared.delay))
            .chain(of_servo)
            .chain(found);
        let mut values = self.declared(declared);
        for (unknown, size) in sizes {
            if let Some(effect) = effect(unknown) {
                values.set(effect, size / self.of(effect));
            }
        }
        values
    }

    /// SI units to one of the record.
    pub(crate) fn of(&self, effect: Effect) -> f64 {
        let [counts, samples] = effect.unit();
        self.position.powi(counts) * self.time.powi(samples)
    }
}

/// The unknown of the recursion's model that an effect is.
pub(crate) const fn term(effect: Effect) -> Option<Unknown> {
    Some(match effect {
        Effect::A => Unknown::A,
        Effect::B => Unknown::B,
        Effect::Coulomb => Unknown::Coulomb,
        Effect::Load => Unknown::Load,
        Effect::Delay => Unknown::Delay,
        Effect::Asymmetry => Unknown::Asymmetry,
        Effect::LowSpeed => Unknown::LowSpeed,
        Effect::GravitySine => Unknown::GravitySine,
        Effect::GravityCosine => Unknown::GravityCosine,
        Effect::RippleSine => Unknown::RippleSine,
        Effect::RippleCosine => Unknown::RippleCosine,
        Effect::DeadBand => Unknown::DeadBand,
        _ => return None,
    })
}

/// The effect that an unknown of the recursion's model is.
pub(crate) fn effect(unknown: Unknown) -> Option<Effect> {
    Effect::ALL
        .into_iter()
        .find(|&effect| term(effect) == Some(unknown))
}

/// The unit of an effect's size.
pub(crate) fn unit(effect: Effect, of: MotionUnit) -> &'static str {
    match term(effect) {
        Some(unknown) => of.of(unknown),
        None => match effect {
            Effect::CurrentLoop => "s",
            Effect::Quadratic => "1/rad",
            Effect::Compliance => "s²",
            Effect::ResonanceFrequency => "rad/s",
            Effect::ResonanceDamping => "of the critical damping",
            Effect::Backlash | Effect::EccentricitySine | Effect::EccentricityCosine => of.name(),
            Effect::HiddenLimit => Unknown::DeadBand.unit(),
            Effect::GainDrift
            | Effect::GainAsymmetry
            | Effect::TorqueRippleSine
            | Effect::TorqueRippleCosine => "of b",
            Effect::FrictionDrift => "of the friction",
            Effect::InertiaSine | Effect::InertiaCosine | Effect::LoadShare => "of the inertia",
            _ => "of the command's acceleration",
        },
    }
}
