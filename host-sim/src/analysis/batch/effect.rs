//! Effects on a servo: the model's own unknowns, and effects that it may lack. Each is an acceleration, or an
//! offset of the measured position, per unit of its size.

use crate::verdict::Cause;
use identifier_core::parameters::Unknown;
use identifier_core::replay::{ReplayModel, ReplaySample};
use identifier_core::units::Units;

/// An effect of a size to be found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Effect {
    /// One of the model's unknowns.
    Own(Unknown),
    /// The command acts some samples later than the model has it; its size is in these.
    Later(usize),
    /// The command passes a pole with a time constant in samples.
    CurrentLoop(f64),
    /// −exp(−(v/v_s)²) sign v, v_s in counts per sample.
    LowSpeed(f64),
    /// −|v| v.
    Quadratic,
    /// sin Nq.
    Sine(f64),
    /// cos Nq.
    Cosine(f64),
    /// Of the gain, relative, over the stretch.
    GainDrift,
    /// Of the Coulomb friction, over the stretch.
    FrictionDrift,
    /// The excess of the command over this does not act.
    Limit(f64),
    /// κ q̈ on the position, through a resonance, radians a sample; without one, at once.
    Compliance(Option<f64>),
    /// A play between motor and encoder, counts, in which the encoder's side stays where
    /// it is; its size is in these.
    Play(f64),
    /// sin q on the position.
    EccentricSine,
    /// cos q on the position.
    EccentricCosine,
}

/// A sample of the model's motion, machine units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instant<'a> {
    pub(super) model: &'a ReplayModel,
    pub(super) sample: &'a ReplaySample,
    /// The commands up to this sample's.
    pub(super) commands: &'a [f64],
    /// The size of a usual command.
    pub(super) usual_command: f64,
    /// The command behind the poles of [`Effect::CurrentLoop`], by its place among [`LAGS`].
    pub(super) lagged: [f64; LAGS.len()],
    /// The angle in the middle of the sample, rad.
    pub(super) angle: f64,
    /// The part of the stretch that has passed, from −1/2 to 1/2.
    pub(super) passed: f64,
    /// The model's acceleration before the sample, counts per sample².
    pub(super) acceleration: f64,
}

/// The state of an effect between samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Memory {
    position: f64,
    velocity: f64,
}

/// Time constants of the current loops that are tried, samples.
pub(super) const LAGS: [f64; 2] = [2.0, 6.0];

impl Effect {
    /// The acceleration per unit of its size over a sample.
    pub(super) fn push(self, now: &Instant<'_>) -> f64 {
        let ReplaySample {
            gain,
            command,
            direction,
            displacement: way,
            ..
        } = *now.sample;
        match self {
            Self::Own(Unknown::DeadBand) => {
                // Smooth over what a command is uncertain by, so that noise about zero is no dead band.
                const SMOOTH: f64 = 0.02;
                -gain * (command / (SMOOTH * now.usual_command)).tanh()
            }
            Self::Own(unknown) => now.model.regressor(now.sample, unknown),
            Self::Later(samples) => {
                let latest = now.commands.len() - 1;
                let at = |ago: usize| latest.checked_sub(ago).map_or(0.0, |k| now.commands[k]);
                gain * (at(samples) - at(0)) / samples as f64
            }
            Self::CurrentLoop(samples) => {
                let place = LAGS.iter().position(|lag| *lag >= samples).unwrap_or(0);
                let latest = now.commands.last().copied().unwrap_or(0.0);
                gain * (now.lagged[place] - latest) / samples
            }
            Self::LowSpeed(speed) => -direction * (-(way / speed).powi(2)).exp(),
            Self::Quadratic => -way * way.abs(),
            Self::Sine(order) => (order * now.angle).sin(),
            Self::Cosine(order) => (order * now.angle).cos(),
            Self::GainDrift => gain * command * now.passed,
            Self::FrictionDrift => -direction * now.passed,
            Self::Limit(limit) => -gain * (command.abs() - limit).max(0.0) * command.signum(),
            Self::Compliance(_) | Self::Play(_) | Self::EccentricSine | Self::EccentricCosine => {
                0.0
            }
        }
    }

    /// The offset of the measured position per unit of its size at the beginning of a sample.
    pub(super) fn offset(self, memory: &mut Memory, now: &Instant<'_>) -> f64 {
        match self {
            Self::Compliance(None) => now.acceleration,
            Self::Compliance(Some(frequency)) => {
                /// Of a steel coupling, about.
                const DAMPING: f64 = 0.03;
                let stiffness = (2.0 * (0.5 * frequency).sin()).powi(2);
                let before = memory.position;
                memory.velocity += stiffness * (now.acceleration - memory.position)
                    - 2.0 * DAMPING * frequency * memory.velocity;
                memory.position += memory.velocity;
                before
            }
            Self::Play(counts) => {
                let before = memory.position;
                memory.position =
                    (before - now.sample.displacement).clamp(-0.5 * counts, 0.5 * counts);
                before / counts
            }
            Self::EccentricSine => now.angle.sin(),
            Self::EccentricCosine => now.angle.cos(),
            _ => 0.0,
        }
    }

    /// The effect that a model without it lacks; none for a and b.
    pub(super) fn cause(self) -> Option<Cause> {
        Some(match self {
            Self::Own(unknown) => return Cause::lacking(unknown),
            Self::Later(_) | Self::CurrentLoop(_) => Cause::Delay,
            Self::LowSpeed(_) => Cause::LowSpeedFriction,
            Self::Quadratic => Cause::QuadraticFriction,
            Self::Sine(order) | Self::Cosine(order) if order <= 1.0 => Cause::Gravity,
            Self::Sine(_) | Self::Cosine(_) => Cause::Ripple,
            Self::GainDrift => Cause::GainDrift,
            Self::FrictionDrift => Cause::FrictionDrift,
            Self::Limit(_) => Cause::HiddenLimit,
            Self::Compliance(_) => Cause::Resonance,
            Self::Play(_) => Cause::Backlash,
            Self::EccentricSine | Self::EccentricCosine => Cause::Eccentricity,
        })
    }

    /// True if an effect of this kind can have such a size, machine units; `swing` is the deviation of
    /// the position, counts.
    pub(super) fn can_be(self, size: f64, swing: f64) -> bool {
        /// The largest error of an encoder, as a share of the motion.
        const MAX_SWING_SHARE: f64 = 0.1;
        match self {
            Self::Own(Unknown::Coulomb | Unknown::DeadBand)
            | Self::Later(_)
            | Self::CurrentLoop(_)
            | Self::Quadratic => size > 0.0,
            // The part above a limit is lost.
            Self::Limit(_) => size > 0.2,
            Self::Play(_) => size > 0.0 && size < MAX_SWING_SHARE * swing,
            Self::EccentricSine | Self::EccentricCosine => size.abs() < MAX_SWING_SHARE * swing,
            _ => true,
        }
    }

    /// Its size in SI per machine unit, and its unit.
    pub(super) fn si(self, units: &Units) -> (f64, &'static str) {
        match self {
            Self::Own(unknown) => (1.0 / unknown.scale(units), unknown.unit()),
            Self::Later(_) | Self::CurrentLoop(_) => (units.sample_time(), "s"),
            Self::LowSpeed(_) | Self::Sine(_) | Self::Cosine(_) | Self::FrictionDrift => {
                (1.0 / units.acceleration(), "rad/s²")
            }
            Self::Quadratic => (1.0 / units.position_unit(), "1/rad"),
            Self::GainDrift | Self::Limit(_) => (1.0, "of b"),
            Self::Compliance(_) => (units.sample_time().powi(2), "s²"),
            Self::Play(_) | Self::EccentricSine | Self::EccentricCosine => {
                (units.position_unit(), "rad")
            }
        }
    }
}
