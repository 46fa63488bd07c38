//! The stability certificate (14) for a whole parameter range, and the automatic μ.
//!
//! The storage function is (10), and α = a + b k_d. Then Ḣ₁ ≤ y v − (α/2) y² holds exactly when μ ≤ α/2 and k_p ≥
//! k_i/μ + α μ/(2b). The paper's other inequalities follow from these two. As α/b = k_d + a/b, both are monotonic in a
//! and in b. So the worst corner of the parameter range decides:
//!
//! 1. 0 < μ < (a_min + b_min k_d)/2
//! 2. k_p > k_i/μ + μ (k_d + a_max/b_min)/2
//!
//! It concerns only the error between servo and model, which does not depend on the controller (`ModelLoop`). The gains
//! k_p, k_d and k_i are those of the *correction*. The certificate holds with any controller that keeps the servo
//! bounded, saturated or not.
//!
//! It is a statement about continuous time. The loss by sampling is checked by
//! [`SampledLoop`](super::SampledLoop), and of the guard in
//! `Gradient`.

use core::fmt;

use super::parameter_range::ParameterRange;
use crate::constants::encode;
use crate::control::Gains;
use crate::error::{Allowed, OutOfRange};

/// Proof that (14) holds for every servo of a parameter range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    mu: f64,
    parameter_range: ParameterRange,
}

encode! {
    [] Certificate as "Certificate" { mu, parameter_range }
}

/// The inequality that fails, and values that would satisfy it.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CertificateError {
    /// μ is not a positive finite number.
    #[error("mu = {mu} is not allowed: it must be a number above 0")]
    MuNotPositive {
        /// The value given.
        mu: f64,
    },
    /// 1. fails: μ < (a_min + b_min k_d)/2.
    #[error(
        "mu < (a_min + b_min kd)/2 fails: mu = {mu} must be below {mu_below:.6}, or kd above {kd_above:.6}, or b_min \
         above {b_min_above:.6}"
    )]
    DampingTooSmall {
        /// The μ given, 1/s.
        mu: f64,
        /// μ must be below this, 1/s.
        mu_below: f64,
        /// Or k_d above this.
        kd_above: f64,
        /// Or b_min above this.
        b_min_above: f64,
    },
    /// 2. fails: k_p > k_i/μ + μ (k_d + a_max/b_min)/2.
    #[error(fmt = write_gain_too_small)]
    ProportionalGainTooSmall {
        /// The k_p given.
        kp: f64,
        /// k_p must be above this.
        kp_above: f64,
        /// The μ at which this was asked, 1/s.
        mu: f64,
        /// The μ that asks the least of k_p, 1/s.
        best_mu: f64,
        /// k_p must be above this at that μ.
        kp_above_at_best_mu: f64,
    },
}

impl CertificateError {
    /// The setting that would satisfy it, with its range.
    #[must_use]
    pub const fn out_of_range(&self) -> OutOfRange {
        match *self {
            Self::MuNotPositive { mu } => OutOfRange::new("mu", mu, Allowed::Above(0.0)),
            Self::DampingTooSmall { mu, mu_below, .. } => {
                OutOfRange::new("mu", mu, Allowed::Below(mu_below))
            }
            Self::ProportionalGainTooSmall { kp, kp_above, .. } => {
                OutOfRange::new("kp", kp, Allowed::Above(kp_above))
            }
        }
    }
}

/// The second inequality, which another μ may satisfy.
fn write_gain_too_small(
    kp: &f64,
    kp_above: &f64,
    mu: &f64,
    best_mu: &f64,
    kp_above_at_best_mu: &f64,
    f: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    write!(
        f,
        "kp > ki/mu + mu (kd + a_max/b_min)/2 fails: kp = {kp} must be above {kp_above:.6} for mu = {mu}"
    )?;
    if kp > kp_above_at_best_mu {
        write!(f, ", or mu = {best_mu:.6}")
    } else {
        write!(
            f,
            " (at the best mu = {best_mu:.6} still above {kp_above_at_best_mu:.6}), or ki or a_max lower, or b_min \
             higher"
        )
    }
}

impl Certificate {
    /// Certifies a parameter range for SI gains and μ (1/s).
    ///
    /// # Errors
    /// The inequality that fails, with the values that would satisfy it.
    pub fn new(
        gains: &Gains,
        parameter_range: &ParameterRange,
        mu: f64,
    ) -> Result<Self, CertificateError> {
        if !(mu > 0.0 && mu.is_finite()) {
            return Err(CertificateError::MuNotPositive { mu });
        }
        let mu_below = parameter_range.slowest_decay(gains.kd()) / 2.0;
        if mu >= mu_below {
            let missing = 2.0 * mu - parameter_range.a().min();
            return Err(CertificateError::DampingTooSmall {
                mu,
                mu_below,
                kd_above: missing / parameter_range.b().min(),
                b_min_above: missing / gains.kd(),
            });
        }
        let kp_above = proportional_gain_floor(gains, parameter_range, mu);
        if gains.kp() <= kp_above {
            let best_mu = automatic_mu(gains, parameter_range);
            return Err(CertificateError::ProportionalGainTooSmall {
                kp: gains.kp(),
                kp_above,
                mu,
                best_mu,
                kp_above_at_best_mu: proportional_gain_floor(gains, parameter_range, best_mu),
            });
        }
        Ok(Self {
            mu,
            parameter_range: *parameter_range,
        })
    }

    /// Certifies a parameter range with the automatic μ.
    ///
    /// # Errors
    /// As [`Certificate::new`]: if this fails, no μ would do, since 2. is then least.
    pub fn with_automatic_mu(
        gains: &Gains,
        parameter_range: &ParameterRange,
    ) -> Result<Self, CertificateError> {
        Self::new(gains, parameter_range, automatic_mu(gains, parameter_range))
    }

    /// The certified μ, 1/s.
    #[must_use]
    pub fn mu(&self) -> f64 {
        self.mu
    }

    /// The certified parameter range.
    #[must_use]
    pub fn parameter_range(&self) -> ParameterRange {
        self.parameter_range
    }
}

/// The right side of 2.
fn proportional_gain_floor(gains: &Gains, parameter_range: &ParameterRange, mu: f64) -> f64 {
    gains.ki() / mu
        + mu * (gains.kd() + parameter_range.a().max() / parameter_range.b().min()) / 2.0
}

/// The μ that needs the least k_p: √(2 k_i/(k_d + a_max/b_min)), kept below the limit of 1.
///
/// Without integral action a small μ has no cost and no benefit. It is then half of what 2. allows, and below the limit
/// of 1. A larger μ gives more weight to the position and less to its derivative with the encoder's noise.
pub(crate) fn automatic_mu(gains: &Gains, parameter_range: &ParameterRange) -> f64 {
    /// Distance kept from the limit of 1.
    const MARGIN: f64 = 0.9;
    let slope = gains.kd() + parameter_range.a().max() / parameter_range.b().min();
    let damping_limit = parameter_range.slowest_decay(gains.kd()) / 2.0;
    let wanted = if gains.ki() > 0.0 {
        libm::sqrt(2.0 * gains.ki() / slope)
    } else {
        gains.kp() / slope
    };
    wanted.min(MARGIN * damping_limit)
}
