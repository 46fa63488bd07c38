use super::{Cap, Goal};
use crate::error::{Allowed, OutOfRange};
use crate::units::Units;

/// The mass whose position the encoder shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum EncoderSide {
    /// The motor.
    Motor,
    /// The load behind the shaft.
    Load,
    /// Either.
    #[default]
    Unknown,
}

/// Settings of a tuning, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TuningSettings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of a count, rad; zero for an ideal sensor.
    pub resolution: f64,
    /// Standard deviation of the encoder's noise besides the rounding of a count, white, rad.
    pub noise: f64,
    /// Cut-off of the low-pass velocity estimate, rad/s; none: chosen with the gains.
    pub cutoff: Option<f64>,
    /// The largest command, command units, beyond the command that holds the load; infinite for none.
    pub command: f64,
    /// From the reading of the encoder to the change of the output, s, beyond the identified delay.
    pub command_delay: f64,
    /// The goal.
    pub goal: Goal,
    /// The largest sensitivity Mₛ.
    pub max_sensitivity: f64,
    /// The largest part of the command that the encoder's rounding and noise may make up, standard deviation.
    pub max_noise: f64,
    /// The step of the reference for the prediction, rad.
    pub step: f64,
    /// The lowest frequency at which a resonance may lie that nothing has shown, rad/s. The gains bear every
    /// [mode](super::Mode) from there on up to the sampling frequency, of [`TuningSettings::HIDDEN_RATIO`] or, with the
    /// encoder on the load, −1, and of [`TuningSettings::HIDDEN_DAMPING`]. None or infinite for no such resonance.
    pub resonance: Option<f64>,
    /// The mass whose position the encoder shows, for such a resonance.
    pub encoder: EncoderSide,
    /// True if gains for two masses may have a notch filter at their resonance.
    pub notch: bool,
    /// True to use a reference model with feed-forward if the predicted step then rises faster than with the
    /// reference filter. Not for [`Goal::ResponseTime`], which a bandwidth meets: with a model a slower loop would
    /// meet it.
    pub feed_forward: bool,
}

impl TuningSettings {
    /// The usual largest sensitivity. The loop then tolerates at least a gain of 0.62 or 2.7 times its own, and 36° of
    /// phase. Source: Åström and Hägglund, Advanced PID Control, 2006, chapter 4.
    pub const MAX_SENSITIVITY: f64 = 1.6;

    /// The usual largest part of the command that is noise. Three standard deviations stay below a tenth, and the power
    /// of the noise below a thousandth.
    pub const MAX_NOISE: f64 = 0.03;

    /// β of a resonance that nothing has shown, at most: a load with two thirds of the inertia.
    pub const HIDDEN_RATIO: f64 = 2.0;

    /// ζ of a resonance that nothing has shown, at least.
    pub const HIDDEN_DAMPING: f64 = 0.02;

    /// The largest sensitivity Mₛ with such a resonance.
    pub const HIDDEN_SENSITIVITY: f64 = 2.4;

    /// The fewest counts that a step may have for its rise to be timed.
    pub const MIN_STEP_COUNTS: f64 = 10.0;

    /// The stiffest loop with the usual margins, without feed-forward. `sample_time` is in s, `resolution` in rad per
    /// count, `command` the largest command, `step` a step of the reference in rad.
    #[must_use]
    pub fn new(sample_time: f64, resolution: f64, command: f64, step: f64) -> Self {
        Self {
            sample_time,
            resolution,
            noise: 0.0,
            cutoff: None,
            command,
            command_delay: 0.0,
            goal: Goal::Stiffest,
            max_sensitivity: Self::MAX_SENSITIVITY,
            max_noise: Self::MAX_NOISE,
            step,
            resonance: None,
            encoder: EncoderSide::Unknown,
            notch: true,
            feed_forward: false,
        }
    }

    /// The range of the largest sensitivity. No PID reaches less than the first; above the second a loop is barely stable.
    pub const SENSITIVITIES: (f64, f64) = (1.05, 3.0);

    /// # Errors
    /// The setting that is out of its range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        let (least, most) = Self::SENSITIVITIES;
        let (shortest, longest) = Units::SAMPLE_TIMES;
        Allowed::Within(shortest, longest).check("sample_time", self.sample_time)?;
        Allowed::AtLeast(0.0).check("resolution", self.resolution)?;
        Allowed::AtLeast(0.0).check("noise", self.noise)?;
        if let Some(cutoff) = self.cutoff {
            let nyquist = core::f64::consts::PI / self.sample_time;
            Allowed::Between(0.0, nyquist).check("cutoff", cutoff)?;
        }
        if self.command != f64::INFINITY {
            Allowed::Above(0.0).check("command", self.command)?;
        }
        Allowed::AtLeast(0.0).check("command_delay", self.command_delay)?;
        match self.goal {
            Goal::ResponseTime(time) => Allowed::Above(0.0).check("response_time", time)?,
            Goal::Bandwidth(bandwidth) => Allowed::Above(0.0).check("bandwidth", bandwidth)?,
            Goal::Stiffest => 0.0,
        };
        Allowed::Within(least, most).check("max_sensitivity", self.max_sensitivity)?;
        Allowed::PositiveUpTo(1.0).check("max_noise", self.max_noise)?;
        let least = Self::MIN_STEP_COUNTS * self.resolution;
        if least > 0.0 {
            Allowed::AtLeast(least).check("step", self.step)?;
        } else {
            Allowed::Above(0.0).check("step", self.step)?;
        }
        if let Some(resonance) = self.lowest_hidden() {
            Allowed::Above(0.0).check("resonance", resonance)?;
        }
        Ok(())
    }

    /// The lowest frequency of a resonance that nothing has shown, if there may be one, rad/s.
    pub(super) fn lowest_hidden(&self) -> Option<f64> {
        self.resonance.filter(|lowest| *lowest != f64::INFINITY)
    }

    /// True if a servo may be led along a reference model.
    pub(super) fn has_reference_model(&self) -> bool {
        self.feed_forward && !matches!(self.goal, Goal::ResponseTime(_))
    }

    /// The largest standard deviation of the command from the encoder's rounding and noise, command units.
    pub(super) fn allowed_noise(&self) -> f64 {
        self.max_noise * self.command
    }
}

/// Why there are no gains.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TuningError<Name = &'static str> {
    /// A setting out of its range, by name.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange<Name>),
    /// The goal is beyond the margins of the servo.
    #[error(
        "a bandwidth of {bandwidth:.1} rad/s is too high for the servo: {cap} allows {most:.1} rad/s"
    )]
    TooFast {
        /// The bandwidth asked for, rad/s.
        bandwidth: f64,
        /// The largest that would do, rad/s.
        most: f64,
        /// The cap that keeps it there.
        cap: Cap,
    },
    /// The identification is too uncertain for tuning: b may be zero, or no loop keeps the margins for all possible
    /// servos.
    #[error(
        "the estimates are too uncertain, so no gains keep the margins: identify the servo with more motion"
    )]
    NotKnown,
    /// The step does not reach 90 % within 25/ω, or goes on for more than its own size. Friction holds the servo, and the
    /// integral is too slow to move it, or the loop is slower than what changes with the angle.
    #[error(
        "the step does not arrive, because friction holds the servo or gravity is faster: ask for a larger step or a faster \
         response"
    )]
    DoesNotArrive,
}

impl<Name> TuningError<Name> {
    /// The same with the name of a setting in another form.
    #[must_use]
    pub fn renamed<To>(self, rename: impl FnOnce(Name) -> To) -> TuningError<To> {
        match self {
            Self::OutOfRange(error) => TuningError::OutOfRange(error.renamed(rename)),
            Self::TooFast {
                bandwidth,
                most,
                cap,
            } => TuningError::TooFast {
                bandwidth,
                most,
                cap,
            },
            Self::NotKnown => TuningError::NotKnown,
            Self::DoesNotArrive => TuningError::DoesNotArrive,
        }
    }
}
