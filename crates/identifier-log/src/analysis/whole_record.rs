//! The servo of a whole record in SI, by the fit that takes all of it at once.

use identifier_core::parameters::{PerQuantity, ServoParameters, Terms, Unknown};
use log_fit::fit::Effect;
use log_fit::{Between, GoesOn, Identified, Logged, ModelDemand, identify};

use super::rough::RoughAnswer;
use crate::experiment::TermEstimate;
use crate::found_servo::FoundServo;
use crate::result::{BrakingForce, EnteredEffect, FitNotes, SecondMode};
use crate::scaled_recording::{Scale, ScaledRecording, effect, servo_of, term};
use crate::scenario::Options;
use crate::verdict::{Cause, FitEvidence};

/// The servo of a record.
#[derive(Debug, Clone)]
pub struct WholeRecord {
    pub(super) servo: ServoParameters,
    /// Standard errors of the four parameters.
    pub(super) std_errors: ServoParameters,
    /// Sizes of the effects that are terms of the model.
    pub(super) terms: Vec<TermEstimate>,
    /// The speed at which its low-speed friction fades, rad/s, if there is any.
    pub(super) low_speed_velocity: Option<f64>,
    /// The servo with all of its effects.
    pub(super) all: FoundServo,
    pub(super) evidence: FitEvidence,
    /// The effects that a command of other sizes would determine better.
    pub(super) needs_more_amplitudes: Vec<Effect>,
    /// Deviation of the sensor's noise, counts.
    pub(super) noise: f64,
    pub(super) notes: FitNotes,
    pub(super) scales: UsualSizes,
    /// In the units of its recording.
    pub(super) found: Identified,
    /// Those units.
    pub(super) scale: Scale,
}

impl WholeRecord {
    /// Its parameters, SI.
    #[must_use]
    pub fn servo(&self) -> &ServoParameters {
        &self.servo
    }

    /// The servo with all of its effects.
    #[must_use]
    pub fn found(&self) -> FoundServo {
        self.all
    }

    /// What acted between the rows.
    pub(crate) fn between(&self) -> Between {
        self.found.between
    }

    /// The standard error of an unknown, infinite for one that was not estimated.
    pub(super) fn std_error(&self, unknown: Unknown) -> f64 {
        let terms = || self.terms.iter().find(|term| term.unknown == unknown);
        match unknown.parameter() {
            Some(parameter) => self.std_errors.get(parameter),
            None => terms().map_or(f64::INFINITY, |term| term.std_error),
        }
    }

    /// Identifies the servo as far as it may go on, beside what its time scales say; none where there is no motion, or no
    /// servo explains it.
    #[must_use]
    pub fn identify(
        scenario: &Options,
        samples: &[Logged],
        goes_on: GoesOn<'_>,
    ) -> (RoughAnswer, Option<Self>) {
        /// Effects that may enter.
        const MAX_EFFECTS: usize = 4;
        let terms = &scenario.stated.identifier.terms;
        let fitted = samples.len() as u64;
        let ScaledRecording { recording, scale } = ScaledRecording::new(scenario, samples);
        let scales = recording.scales();
        let found = identify(
            &recording,
            &scales,
            &ModelDemand {
                known: scale.declared(terms),
                required: required(terms.demanded),
                max_effects: MAX_EFFECTS,
            },
            goes_on,
        );
        let acting = found.as_ref().and_then(|found| found.acting.as_ref());
        let rough = RoughAnswer::new(&scales, acting, &scale, scenario.inner.is_none());
        (rough, found.map(|found| scale.in_si(found, fitted)))
    }
}

/// The effects of the terms that are required.
fn required(terms: Terms) -> Vec<Effect> {
    let unknowns = Unknown::ALL.into_iter().filter(|unknown| {
        // A delay is part of every fit.
        *unknown != Unknown::Delay && unknown.term().is_some_and(|own| terms.has(own))
    });
    let mut required: Vec<Effect> = unknowns.filter_map(effect).collect();
    if required.contains(&Effect::LowSpeed) {
        required.push(Effect::LowSpeedVelocity);
    }
    required
}

impl Scale {
    fn in_si(&self, found: Identified, samples: u64) -> WholeRecord {
        let value = |effect: Effect| found.values.get(effect) * self.of(effect);
        let std_error = |effect: Effect| {
            let own = found.estimated.iter().find(|(one, _)| *one == effect);
            own.map_or(f64::INFINITY, |(_, error)| error * self.of(effect))
        };
        let servo = servo_of(value);
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
        let sizes = |cause: Cause| {
            let own_size = match cause {
                Cause::Ripple => Some(("order", found.values.orders[1])),
                Cause::TorqueRipple => Some(("order", found.values.gain_order)),
                Cause::VaryingInertia => Some(("order", found.values.inertia_order)),
                Cause::LoadSteps => found.last_load.map(|last| ("last_at_s", last * self.time)),
                Cause::Jitter => found
                    .jitter
                    .map(|jitter| ("deviation_s", jitter * self.time)),
                _ => None,
            };
            let own = log_fit::effects(cause).iter();
            // For a shaft its twist, or the second mass.
            let is_there = |effect: &Effect| {
                !matches!(cause, Cause::Resonance | Cause::Ripple) || value(*effect) != 0.0
            };
            // An encoder on the load does not show its share.
            let is_shown = |effect: &Effect| {
                *effect != Effect::LoadShare || value(Effect::EncoderOnLoad) == 0.0
            };
            let no_terms = own.filter(|effect| term(**effect).is_none());
            let shown = no_terms.filter(|effect| is_there(effect) && is_shown(effect));
            let (sizes, std_errors): (Vec<_>, Vec<_>) = shown
                .map(|&effect| {
                    (
                        (name(effect), value(effect)),
                        (name(effect), std_error(effect)),
                    )
                })
                .unzip();
            let known = std_errors
                .into_iter()
                .filter(|(_, error)| error.is_finite());
            let names = ["order_2", "order_3", "order_4"];
            let further = names
                .into_iter()
                .zip(found.values.orders[2..].iter().copied());
            let is_wave = |(place, _): &(usize, _)| {
                cause == Cause::Ripple
                    && Effect::FORCES[2 + place]
                        .iter()
                        .any(|effect| value(*effect) != 0.0)
            };
            let further = further.enumerate().filter(is_wave).map(|(_, order)| order);
            let own_sizes = own_size.into_iter().chain(further);
            (own_sizes.chain(sizes).collect(), known.collect())
        };
        let effects = found.entered.iter().map(|entered| {
            let (sizes, std_errors) = sizes(entered.cause);
            EnteredEffect {
                name: entered.cause.name(),
                meaning: entered.cause.meaning(),
                gain: entered.gain,
                or: entered.rival().map(Cause::name),
                sizes,
                std_errors,
            }
        });
        let second_modes = found.second_modes.iter().map(|mode| SecondMode {
            rad_per_s: mode.frequency / self.time,
            ratio: mode.ratio,
            std_error: mode.std_error,
        });
        WholeRecord {
            servo,
            std_errors: servo_of(std_error),
            terms: terms.collect(),
            low_speed_velocity: Some(value(Effect::LowSpeedVelocity)).filter(|of| *of > 0.0),
            all: FoundServo::of_fit(&found.values, self),
            evidence: FitEvidence {
                profile: found.profile,
                reverses: found.reverses,
                delay_at_bound: found.delay_at_bound,
                was_stopped: found.was_stopped,
                is_explained: found.is_explained,
            },
            needs_more_amplitudes: found.needs_more_amplitudes.clone(),
            noise: found.noise,
            notes: FitNotes {
                samples,
                command_recorded_late: found.lateness,
                command_between_rows: found.between.name(),
                braking: found.braking.map(|[value, std_error]| BrakingForce {
                    value: value * self.of(Effect::Load),
                    std_error: std_error * self.of(Effect::Load),
                }),
                effects: effects.collect(),
                second_modes: second_modes.collect(),
            },
            scales: self.scales(&found.statistics, found.statistics.command),
            found,
            scale: *self,
        }
    }
}

/// The name of an effect's size in results, with its unit where it has one.
const fn name(effect: Effect) -> &'static str {
    match effect {
        Effect::CurrentLoop => "time_constant_s",
        Effect::Quadratic => "per_rad",
        Effect::LowSpeedVelocity => "velocity_rad_per_s",
        Effect::HiddenLimit => "limit",
        Effect::Compliance => "twist_s2",
        Effect::ResonanceFrequency => "resonance_rad_per_s",
        Effect::ResonanceDamping => "damping",
        Effect::LoadShare => "load_share",
        Effect::EncoderOnLoad => "encoder_on_load",
        Effect::Backlash => "play_rad",
        Effect::EccentricitySine => "sine_rad",
        Effect::EccentricityCosine => "cosine_rad",
        Effect::RippleSine2 => "sine_2",
        Effect::RippleCosine2 => "cosine_2",
        Effect::RippleSine3 => "sine_3",
        Effect::RippleCosine3 => "cosine_3",
        Effect::RippleSine4 => "sine_4",
        Effect::RippleCosine4 => "cosine_4",
        Effect::TorqueRippleSine | Effect::InertiaSine => "sine",
        Effect::TorqueRippleCosine | Effect::InertiaCosine => "cosine",
        _ => "size",
    }
}

/// Usual sizes of the motion, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UsualSizes {
    /// Deviation of the velocity, rad/s.
    pub(super) velocity: f64,
    /// Deviation of the command; of a fit the largest.
    pub(super) command: f64,
}

impl UsualSizes {
    /// The size beside which an error of an unknown is small or large, in its unit.
    pub(super) fn scale_of(&self, unknown: Unknown, b: f64) -> f64 {
        let acceleration = b.abs() * self.command;
        let rate = acceleration / self.velocity.max(f64::MIN_POSITIVE);
        let scales = PerQuantity {
            rate,
            gain: b.abs(),
            acceleration,
            time: 1.0 / rate.max(f64::MIN_POSITIVE),
            command: self.command,
        };
        scales.get(unknown)
    }
}
