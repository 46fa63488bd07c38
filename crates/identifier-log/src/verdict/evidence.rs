use identifier_core::parameters::{Parameter, ServoParameters, Term, Unknown};
use identifier_core::reason::Reason;
use serde::Serialize;

use super::Cause;

/// The evidence for an identification besides its estimates, SI. Evidence that was not gathered is none, and
/// is not held against it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Evidence {
    /// The motion behind it.
    pub motion: Motion,
    /// The run ended early.
    pub aborted: bool,
    /// The output error of the model with the estimates.
    pub residual: Option<Residual>,
    /// The effect that the model lacks, if any.
    pub lack: Option<MissingEffect>,
    /// Error of the predicted position over data that the estimates have not seen, relative to the
    /// position's deviation.
    pub prediction: Option<f64>,
    /// Why an estimator that begins by a fit had none after a second of motion.
    pub rejection_reason: Option<Reason>,
    /// A required term that did not enter the model.
    pub missing_term: Option<Term>,
    /// True if a fit to the whole record found no servo that explains it.
    pub not_a_servo: bool,
    /// The evidence of a fit to the whole record, whose standard errors hold model errors too.
    pub fit: Option<FitEvidence>,
    /// The evidence of the fit by which the estimates of another estimator are judged.
    pub judged_by: Option<FitEvidence>,
    /// What that fit leaves of the log from one sample to the next, beside the noise of the sensor.
    pub innovation: Option<Residual>,
    /// b by the time scales of the record, of the command that acted by the fit, and its standard error.
    pub gain_of_scales: Option<[f64; 2]>,
    /// True if the command was computed by the servo's own loop as somebody stated it.
    pub command_was_computed: bool,
    /// True if the log was read by what nothing in it shows.
    pub is_assumed: bool,
    unknowns: [Option<UnknownEvidence>; Unknown::ALL.len()],
}

/// The evidence of a fit to a whole record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitEvidence {
    /// Increase of −2 ln L, in independent samples, at 0.8 and 1.25 times b with all else fitted again.
    pub profile: [f64; 2],
    /// True if the servo moved in both directions.
    pub reverses: bool,
    /// True if the delay is the longest that was looked for.
    pub delay_at_bound: bool,
    /// True if it was stopped before its end.
    pub was_stopped: bool,
    /// True if it explains the record down to the noise of its sensor.
    pub is_explained: bool,
}

/// The servo's motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Samples that were learnt from.
    pub samples: u64,
    /// The distance travelled, forth and back, encoder counts.
    pub counts_travelled: f64,
}

/// The evidence for one unknown, in its unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnknownEvidence {
    /// The estimate; not finite if there is none.
    pub estimate: f64,
    /// The size against which its error is small or large. For friction and load it is the acceleration by the command,
    /// for a the rate at which the servo's velocity changes.
    pub scale: f64,
    /// Standard error with the residual's autocorrelation and the encoder's resolution; infinite if the motion contains
    /// no information on it.
    pub std_error: Option<f64>,
    /// True if most of it comes from effects of the command's size. A command of other sizes would determine them.
    pub needs_more_amplitudes: bool,
    /// The distance that it still moved, or still had to go, at the end.
    pub movement: f64,
    /// The refit difference: the distance from the final estimate to a refit of the data with the effect that the model
    /// lacks.
    pub refit_difference: Option<f64>,
    /// True if it is at a bound.
    pub at_bound: bool,
}

impl UnknownEvidence {
    /// An estimate without a rejection reason; `scale` as in [`UnknownEvidence::scale`].
    #[must_use]
    pub fn at(scale: f64) -> Self {
        Self {
            scale,
            ..Self::default()
        }
    }

    /// The standard error of the estimate: chance, and the refit difference. None if nothing is known of it.
    #[must_use]
    pub fn uncertainty(&self) -> Option<f64> {
        let known = self.std_error.filter(|error| error.is_finite())?;
        Some(libm::hypot(known, self.refit_difference.unwrap_or(0.0)))
    }
}

/// An effect that a model lacks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MissingEffect {
    /// The effect, if one is distinct; none if several are possible.
    pub cause: Option<Cause>,
    /// The part of the output error that it explains.
    pub share: f64,
}

impl Evidence {
    /// Nothing known but the motion.
    #[must_use]
    pub fn from_motion(motion: Motion) -> Self {
        Self {
            motion,
            ..Self::default()
        }
    }

    /// Adds what is known of an unknown that is estimated.
    pub fn add(&mut self, unknown: Unknown, evidence: UnknownEvidence) {
        self.unknowns[unknown as usize] = Some(evidence);
    }

    /// Replaces an estimate by another with its standard error, where one was asked for.
    pub fn replace(
        &mut self,
        parameter: Parameter,
        servo: &ServoParameters,
        std_errors: &ServoParameters,
    ) {
        if let Some(of) = &mut self.unknowns[Unknown::from(parameter) as usize] {
            *of = UnknownEvidence {
                estimate: servo.get(parameter),
                std_error: Some(std_errors.get(parameter)),
                ..UnknownEvidence::at(of.scale)
            };
        }
    }

    /// The unknowns that are estimated, b first: without it there is no servo.
    pub fn unknowns(&self) -> impl Iterator<Item = (Unknown, &UnknownEvidence)> {
        let rest = Unknown::ALL
            .into_iter()
            .filter(|&other| other != Unknown::B);
        std::iter::once(Unknown::B)
            .chain(rest)
            .filter_map(|unknown| Some((unknown, self.unknowns[unknown as usize].as_ref()?)))
    }
}

/// The output error of the model over the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residual {
    /// Root mean square, rad.
    pub rms: f64,
    /// Root mean square of rounding to the encoder's resolution alone, rad.
    pub resolution_rms: f64,
    /// Correlation from sample to sample.
    pub correlation: f64,
}

impl Residual {
    /// Output error beyond this many times the encoder's is not the encoder's.
    const MAX_ENCODER_RATIO: f64 = 1.5;
    /// Correlation beyond this is not that of rounding.
    const MAX_CORRELATION: f64 = 0.3;

    /// True if the encoder's resolution accounts for the output error.
    #[must_use]
    pub fn is_the_encoders(&self) -> bool {
        !self.is_large() && !self.is_autocorrelated()
    }

    /// True if it is more than the encoder's resolution leaves.
    #[must_use]
    pub fn is_large(&self) -> bool {
        self.rms > Self::MAX_ENCODER_RATIO * self.resolution_rms
    }

    /// True if it is correlated from sample to sample.
    #[must_use]
    pub fn is_autocorrelated(&self) -> bool {
        self.correlation > Self::MAX_CORRELATION
    }
}
