//! The keys of `[inner]`: the position loop of a servo that takes goals.

use identifier_core::error::Allowed;

use super::Options;
use super::error::Fault;
use super::names::named;

/// The loop that a servo closes about its position goal, u = kp (goal − q) − kd q̇ within a limit. Hobby servos and
/// simulators have it. The goal is the log's reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnerLoop {
    /// Command units per rad.
    pub kp: f64,
    /// Command units per rad/s.
    pub kd: f64,
    /// Lowest and highest command.
    pub limit: [f64; 2],
    /// The loop's own sample time, s, a whole part of the log's; none for that of the log.
    pub sample_time: Option<f64>,
    /// Cut-off of the low-pass derivative that is its velocity, rad/s; none for the difference of two samples.
    pub cutoff: Option<f64>,
    /// How its command becomes motion.
    pub integrator: Integrator,
}

named! {
    /// How the command of an inner loop becomes motion.
    pub enum Integrator {
        /// A drive, which holds each command for a sample of its loop.
        None = "none" takes &["cutoff"],
        /// A simulator's semi-implicit Euler method: q̇⁺ = q̇ + h q̈(q, q̇), q⁺ = q + h q̇⁺.
        Euler = "euler",
        /// The same, with the loop's damping taken at the end of the step, q̈(q, q̇⁺).
        Implicit = "implicit",
    }
}

impl InnerLoop {
    /// The most samples of the loop to one of the log.
    pub const MAX_RATIO: f64 = 1000.0;

    /// A proportional loop at the log's sample time.
    #[must_use]
    pub fn proportional(kp: f64) -> Self {
        Self {
            kp,
            kd: 0.0,
            limit: [f64::NEG_INFINITY, f64::INFINITY],
            sample_time: None,
            cutoff: None,
            integrator: Integrator::None,
        }
    }

    /// Samples of the loop to one of a log, whose sample time is in s.
    ///
    /// # Errors
    /// The sample times do not go together.
    pub fn samples_per_row(&self, sample_time: f64) -> Result<u32, String> {
        /// Relative difference of sample times that are the same.
        const TOLERANCE: f64 = 0.02;
        let own = self.sample_time.unwrap_or(sample_time);
        let ratio = sample_time / own;
        let whole = ratio.round();
        if (1.0..=Self::MAX_RATIO).contains(&whole) && (ratio / whole - 1.0).abs() < TOLERANCE {
            return Ok(whole as u32);
        }
        Err(format!(
            "the log's sample time of {sample_time} s is {ratio:.4} times inner.sample_time = {own} s: it must be a \
             whole multiple, 1 to {}",
            Self::MAX_RATIO
        ))
    }
}

/// Checks that the loop and the log's columns go together.
pub(super) fn check(scenario: &Options) -> Result<(), Fault> {
    let log = scenario.log_columns();
    let Some(inner) = &log.inner else {
        let needless = Fault::new(
            "log.velocity",
            "a velocity column is used only by [inner], the servo's own position loop: leave it out, or state the \
             gains of [inner]",
        );
        return log.velocity.map_or(Ok(()), |_| Err(needless));
    };
    let [_, highest] = inner.limit;
    if highest != f64::INFINITY {
        (Allowed::Above(0.0).check("limit", highest))
            .map_err(|error| Fault::new("inner.limit", error))?;
    }
    let refusals = [
        (
            log.command.is_some(),
            "inner",
            "[inner] computes the command of a log that has none, but log.command is stated: leave out one of them",
        ),
        (
            log.reference.is_none(),
            "log.reference",
            "the goal of [inner] is missing: state its column",
        ),
        (
            scenario.stated.controller.is_some(),
            "inner",
            "[inner] and [controller] both compute the command: leave out one of them",
        ),
        (
            log.velocity.is_some() && inner.cutoff.is_some(),
            "inner.cutoff",
            "it filters the velocity computed from the position, but log.velocity gives the velocity: leave out one \
             of them",
        ),
    ];
    let refusal = refusals.into_iter().find(|(is_refused, ..)| *is_refused);
    refusal.map_or(Ok(()), |(_, key, fault)| Err(Fault::new(key, fault)))
}
