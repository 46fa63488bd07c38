//! The servo of a whole record in SI, by the fit that takes all of it at once.

use identifier_core::identification::{Effect, Values};
use identifier_core::parameters::{Quantity, ServoParameters, Terms, Unknown};
use identifier_core::settings::TermSettings;

use super::batch::Scales;
use super::stretch::Kept;
use crate::experiment::TermEstimate;
use crate::identify::{Identified, Logged, ModelDemand, Recording, identify};
use crate::result::{EnteredEffect, FitNotes};
use crate::scenario::Scenario;
use crate::verdict::{Cause, FitEvidence};

/// The servo of a record.
#[derive(Debug, Clone)]
pub(super) struct WholeRecord {
    pub(super) servo: ServoParameters,
    /// Standard errors of the four parameters.
    pub(super) std_errors: ServoParameters,
    /// Sizes of the effects that are terms of the model.
    pub(super) terms: Vec<TermEstimate>,
    /// Their declared and identified settings.
    pub(super) settings: TermSettings,
    pub(super) evidence: FitEvidence,
    /// Deviation of the sensor's noise, counts.
    pub(super) noise: f64,
    pub(super) notes: FitNotes,
    pub(super) scales: Scales,
}

impl WholeRecord {
    /// The standard error of an unknown, infinite for one that was not estimated.
    pub(super) fn std_error(&self, unknown: Unknown) -> f64 {
        let terms = || self.terms.iter().find(|term| term.unknown == unknown);
        match unknown.parameter() {
            Some(parameter) => parameter.value_in(&self.std_errors),
            None => terms().map_or(f64::INFINITY, |term| term.std_error),
        }
    }

    /// Identifies the servo; none where there is no motion, or no servo explains it.
    pub(super) fn identify(
        scenario: &Scenario,
        samples: impl ExactSizeIterator<Item = Kept>,
    ) -> Option<Self> {
        /// Effects that may enter.
        const MAX_EFFECTS: usize = 4;
        let units = scenario.units();
        let terms = &scenario.stated.identifier.terms;
        let logged = samples.map(|sample| Logged {
            position: sample.position,
            command: sample.command,
            begins: sample.begins,
        });
        let fitted = logged.len() as u64;
        let recording = Recording::new(logged, units.position(), terms.revolution);
        let scale = Scale {
            time: units.sample_time() * recording.block,
            position: units.position_unit(),
        };
        let mut known = Values::NONE;
        for (effect, value) in [
            (Effect::DeadBand, terms.dead_band),
            (Effect::CurrentLoop, terms.current_loop),
            (
                Effect::LowSpeedVelocity,
                terms.low_speed_velocity.unwrap_or(0.0),
            ),
        ] {
            known.set(effect, value / scale.of(effect));
        }
        known.order = terms.ripple_order.unwrap_or(known.order);
        let found = identify(
            &recording,
            &ModelDemand {
                known,
                required: required(terms.demanded),
                max_effects: MAX_EFFECTS,
            },
        )?;
        Some(scale.in_si(&found, terms, fitted))
    }
}

/// The effects of the terms that are required.
fn required(terms: Terms) -> Vec<Effect> {
    let unknowns = Unknown::ALL.into_iter().filter(|unknown| {
        // A delay is part of every fit.
        *unknown != Unknown::Delay && unknown.term().is_some_and(|own| terms.has(own))
    });
    let effects = unknowns.filter_map(|unknown| {
        let mut all = Effect::ALL.into_iter();
        all.find(|&effect| term(effect) == Some(unknown))
    });
    let mut required: Vec<Effect> = effects.collect();
    if required.contains(&Effect::LowSpeed) {
        required.push(Effect::LowSpeedVelocity);
    }
    required
}

/// Units of a record.
struct Scale {
    /// Seconds to a sample.
    time: f64,
    /// Radians to a count.
    position: f64,
}

impl Scale {
    fn in_si(&self, found: &Identified, declared: &TermSettings, samples: u64) -> WholeRecord {
        let value = |effect: Effect| found.values.get(effect) * self.of(effect);
        let std_error = |effect: Effect| {
            let own = found.estimated.iter().find(|(one, _)| *one == effect);
            own.map_or(f64::INFINITY, |(_, error)| error * self.of(effect))
        };
        let four = |of: &dyn Fn(Effect) -> f64| ServoParameters {
            a: of(Effect::A),
            b: of(Effect::B),
            coulomb: of(Effect::Coulomb),
            load: of(Effect::Load),
        };
        let servo = four(&value);
        let estimated = || found.estimated.iter().map(|(effect, _)| *effect);
        let sizes_of_terms = Unknown::ALL
            .into_iter()
            .filter(|one| one.parameter().is_none());
        let terms = sizes_of_terms.filter_map(|unknown| {
            let effect = estimated().find(|&effect| term(effect) == Some(unknown))?;
            let std_error = Some(std_error(effect)).filter(|error| error.is_finite())?;
            Some(TermEstimate {
                unknown,
                value: value(effect),
                std_error,
                since: 0,
            })
        });
        let velocity = found.velocity * self.position / self.time;
        let scales = Scales {
            velocity: 0.5 * velocity,
            command: found.command,
            position: 0.0,
        };
        let sizes = |cause: Cause| {
            let own_size = match cause {
                Cause::Ripple => Some(("order", found.values.order)),
                Cause::TorqueRipple => Some(("order", found.values.gain_order)),
                Cause::VaryingInertia => Some(("order", found.values.inertia_order)),
                Cause::LoadSteps => found.last_load.map(|last| ("last_at_s", last * self.time)),
                _ => None,
            };
            let own = crate::identify::effects(cause).iter();
            let no_terms = own.filter(|effect| term(**effect).is_none());
            let sizes = no_terms.map(|&effect| (name(effect), value(effect)));
            own_size.into_iter().chain(sizes).collect()
        };
        let effects = found.entered.iter().map(|entered| EnteredEffect {
            name: entered.cause.name(),
            meaning: entered.cause.meaning(),
            gain: entered.gain,
            or: entered.rival().map(Cause::name),
            sizes: sizes(entered.cause),
        });
        WholeRecord {
            servo,
            std_errors: four(&std_error),
            terms: terms.collect(),
            settings: TermSettings {
                current_loop: value(Effect::CurrentLoop),
                low_speed_velocity: Some(value(Effect::LowSpeedVelocity)).filter(|of| *of > 0.0),
                ripple_order: Some(found.values.order),
                ..*declared
            },
            evidence: FitEvidence {
                profile: found.profile,
                condition: found.condition,
                reverses: found.reverses,
                delay_at_bound: found.delay_at_bound,
            },
            noise: found.noise,
            notes: FitNotes {
                samples,
                command_recorded_late: found.lateness,
                effects: effects.collect(),
            },
            scales,
        }
    }

    /// SI units to one of the record.
    fn of(&self, effect: Effect) -> f64 {
        let acceleration = self.position / (self.time * self.time);
        match term(effect).map(Unknown::quantity) {
            Some(Quantity::Rate) => 1.0 / self.time,
            Some(Quantity::Gain | Quantity::Acceleration) => acceleration,
            Some(Quantity::Time) => self.time,
            Some(Quantity::Command) => 1.0,
            None => match effect {
                Effect::CurrentLoop => self.time,
                Effect::Quadratic => 1.0 / self.position,
                Effect::LowSpeedVelocity => self.position / self.time,
                Effect::Compliance => self.time * self.time,
                _ => 1.0,
            },
        }
    }
}

/// The unknown of the recursion's model that an effect is.
const fn term(effect: Effect) -> Option<Unknown> {
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

/// The name of an effect's size in results, with its unit where it has one.
const fn name(effect: Effect) -> &'static str {
    match effect {
        Effect::CurrentLoop => "time_constant_s",
        Effect::Quadratic => "per_rad",
        Effect::LowSpeedVelocity => "velocity_rad_per_s",
        Effect::HiddenLimit => "limit",
        Effect::Compliance => "twist_s2",
        Effect::TorqueRippleSine | Effect::InertiaSine => "sine",
        Effect::TorqueRippleCosine | Effect::InertiaCosine => "cosine",
        _ => "size",
    }
}
