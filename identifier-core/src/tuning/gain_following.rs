//! Gains that follow the inertia of a servo, within what their promise allows.
//!
//! A mass divides a, b, c and d by the same factor. With k_p, k_d and k_i times b_promised/b_found the loop opened,
//!
//! L = b (k_p + k_i/s + k_d s)/(s (s + a)),
//!
//! is then the promised one but for a, and so are its margins and its step; cut-off and filter of the reference stay. What differs
//! is promised anew: the command of the step and the noise in the command grow as the gains do, and friction, which stays as
//! it was, weighs less against a larger command and more against a smaller one.

use core::fmt;

use super::placement::Design;
use super::possible_servos::PossibleServos;
use super::prediction::{PromisePrediction, Scene};
use super::resonance::Resonance;
use super::search::{Case, Judge, Verdict};
use super::{Cap, Goal, Promise, PromisedServo, Tuning, TuningSettings};
use crate::control::FeedForwardSettings;
use crate::parameters::{IdentifiedServo, ServoParameters};
use crate::units::Units;

/// The gains for a servo with another inertia, before they are certified.
///
/// The certificate is that of a tuning ([`Tuner`](super::Tuner)): the noise in the command and the command of the promised step are
/// allowed, the loops of the found servo and of those three standard errors off keep the largest sensitivity, and its step arrives.
/// As for servos that differ from a measured one, the excess of the sensitivity over 1 is 1.25 times the usual one, or that of
/// the promise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainFollowing {
    judge: Judge,
    scene: Scene,
    servo: IdentifiedServo,
    tuning: Tuning,
    factor: f64,
}

/// A certificate under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainFollowingState(Stage);

#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap here, and a program holds one"
)]
enum Stage {
    Margins(Case),
    Promise(PromisePrediction),
}

/// Gains that follow, and the servo that they promise for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowedGains {
    /// The gains with their promise.
    pub tuning: Tuning,
    /// The promised servo with the found inertia: friction and load are those of the promise, command units, for their changes
    /// still to be found.
    pub servo: IdentifiedServo,
    /// The gains over those of the promise.
    pub factor: f64,
}

/// Why gains do not follow a servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NotFollowed {
    /// They would be more than [`GainFollowing::MAX_FACTOR`] times those of the promise, or less than its reciprocal.
    TooFar,
    /// The servo is not known well enough for a certificate.
    NotKnown,
    /// Friction would hold the promised step.
    DoesNotArrive,
    /// They would break this limit. Whether a resonance allows larger gains only a measurement tells.
    Limited(Cap),
}

impl fmt::Display for NotFollowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the gains do not follow: ")?;
        match self {
            Self::TooFar => write!(
                f,
                "they follow to {} times the promised ones and to a part of them as small",
                GainFollowing::MAX_FACTOR
            ),
            Self::NotKnown => f.write_str("the servo is not known well enough"),
            Self::DoesNotArrive => f.write_str("friction would hold the promised step"),
            Self::Limited(cap) => write!(f, "{cap} does not allow it"),
        }
    }
}

impl core::error::Error for NotFollowed {}

impl GainFollowing {
    /// The largest ratio of the gains to those of the promise, either way.
    pub const MAX_FACTOR: f64 = 5.0;

    /// The least time from one change of the gains to the next, s, if the promised step has settled by then: a few examinations
    /// ([`ServoChangeState::INTERVAL`](super::ServoChangeState::INTERVAL)) of the new loop.
    pub const SETTLING: f64 = 2.0;

    /// For the promised servo and its gains, the servo that was found with its standard errors, the loop's units, and the largest
    /// command either way, command units; infinite for none.
    ///
    /// # Errors
    /// [`NotFollowed`], where no certificate needs to be tried.
    pub fn new(
        promised: &IdentifiedServo,
        tuning: &Tuning,
        [found, errors]: &[ServoParameters; 2],
        units: &Units,
        limit: f64,
    ) -> Result<Self, NotFollowed> {
        /// How far the found ratio may lie beyond the largest: its error at the bound.
        const ROUNDING: f64 = 1.01;
        let factor = promised.parameters.b / found.b;
        let most = ROUNDING * Self::MAX_FACTOR;
        // NaN fails both.
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(NotFollowed::NotKnown);
        }
        if factor > most || factor < 1.0 / most {
            return Err(NotFollowed::TooFar);
        }
        // A notch fits one resonance, which another inertia moves.
        let is_fitted = tuning.notch > 0.0;
        let resonates = matches!(tuning.cap, Some(Cap::Resonance | Cap::UnseenResonance));
        if is_fitted || (factor > 1.0 && resonates) {
            return Err(NotFollowed::Limited(Cap::Resonance));
        }
        let tuning = scaled(tuning, factor);
        let command = limit - libm::fabs(found.load / found.b);
        if command <= 0.0 {
            return Err(NotFollowed::Limited(Cap::CommandLimit));
        }
        let settings = TuningSettings {
            goal: Goal::Bandwidth(tuning.bandwidth),
            max_sensitivity: max_sensitivity(&tuning.promise),
            // Less noise than the promise has is allowed whatever the load leaves of the command.
            max_noise: TuningSettings::MAX_NOISE.max(tuning.promise.noise / (factor * command)),
            ..TuningSettings::new(
                units.sample_time(),
                units.position_unit(),
                command,
                tuning.promise.step,
            )
        };
        settings.check().map_err(|_| NotFollowed::NotKnown)?;
        let servo = with_inertia(promised, found.b, errors.b);
        let coulomb = found.coulomb.max(0.0);
        PromisedServo::new(&servo, &tuning, limit).ok_or(NotFollowed::NotKnown)?;
        let certified = with_errors(found, errors, promised);
        let servos = PossibleServos::new(&certified, 0.0, units.sample_time())
            .map_err(|_| NotFollowed::NotKnown)?;
        Ok(Self {
            judge: Judge::new(&servos, [coulomb; 2], None, &settings),
            scene: Scene {
                servos,
                coulomb,
                mode: None,
                settings,
            },
            servo,
            tuning,
            factor,
        })
    }

    /// Begins the certificate.
    #[must_use]
    pub fn start(&self) -> GainFollowingState {
        let design = Design::from_tuning(&self.tuning);
        GainFollowingState(Stage::Margins(self.judge.open_design(design)))
    }

    /// A slice of work, one frequency of one servo or one sample of a predicted step; fewer than 10 000 end it.
    pub fn work(
        &self,
        state: &mut GainFollowingState,
    ) -> Option<Result<FollowedGains, NotFollowed>> {
        match &mut state.0 {
            Stage::Margins(case) => match self.judge.work(case, &[], true)? {
                Verdict::Breaks(cap) => Some(Err(NotFollowed::Limited(cap))),
                Verdict::Keeps(design, margins) => {
                    match PromisePrediction::begin(&self.scene, &design, &margins) {
                        Ok(prediction) => state.0 = Stage::Promise(prediction),
                        Err(_) => return Some(Err(NotFollowed::NotKnown)),
                    }
                    None
                }
            },
            Stage::Promise(prediction) => Some(match prediction.work(&self.scene)? {
                Ok(promise) => Ok(FollowedGains {
                    tuning: Tuning {
                        promise,
                        ..self.tuning
                    },
                    servo: self.servo,
                    factor: self.factor,
                }),
                Err(_) => Err(NotFollowed::DoesNotArrive),
            }),
        }
    }
}

/// The largest sensitivity that servos may have which differ from the promised one.
fn max_sensitivity(promise: &Promise) -> f64 {
    let promised = promise.sensitivity.max(TuningSettings::MAX_SENSITIVITY);
    1.0 + Resonance::DIFFERING * (promised - 1.0)
}

/// Gains times a factor, with their noise in the command. Of a feed-forward only that of the acceleration changes: friction stays
/// as it was.
fn scaled(tuning: &Tuning, factor: f64) -> Tuning {
    let Tuning {
        kp,
        kd,
        ki,
        feed_forward,
        promise,
        ..
    } = *tuning;
    Tuning {
        kp: factor * kp,
        kd: factor * kd,
        ki: factor * ki,
        feed_forward: feed_forward.map(|led| FeedForwardSettings {
            acceleration: factor * led.acceleration,
            ..led
        }),
        promise: Promise {
            noise: factor * promise.noise,
            ..promise
        },
        ..*tuning
    }
}

/// A servo that was found in motion, with the delay of the promised one.
fn with_errors(
    found: &ServoParameters,
    errors: &ServoParameters,
    promised: &IdentifiedServo,
) -> IdentifiedServo {
    let delay = promised.standard_error(IdentifiedServo::DELAY);
    let errors = [errors.a, errors.b, errors.coulomb, delay, errors.load];
    IdentifiedServo {
        parameters: *found,
        covariance: diagonal(errors),
        ..*promised
    }
}

/// The promised servo with another inertia, by which all of its accelerations change alike.
fn with_inertia(promised: &IdentifiedServo, b: f64, error: f64) -> IdentifiedServo {
    let ServoParameters {
        a,
        b: before,
        coulomb,
        load,
    } = promised.parameters;
    let ratio = b / before;
    let error_of = |unknown| ratio * promised.standard_error(unknown);
    IdentifiedServo {
        parameters: ServoParameters {
            a: ratio * a,
            b,
            coulomb: ratio * coulomb,
            load: ratio * load,
        },
        covariance: diagonal([
            error_of(IdentifiedServo::A),
            error,
            error_of(IdentifiedServo::COULOMB),
            promised.standard_error(IdentifiedServo::DELAY),
            error_of(IdentifiedServo::LOAD),
        ]),
        ..*promised
    }
}

/// The covariance of independent errors of a, b, c, τ and d.
fn diagonal(errors: [f64; 5]) -> [[f64; 5]; 5] {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            let error = errors.get(i).copied().unwrap_or_default();
            if i == j { error * error } else { 0.0 }
        })
    })
}
