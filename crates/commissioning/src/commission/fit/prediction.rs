use super::PARAMETERS;
use super::motion::MotionRecord;
use super::motion_model::{MotionFit, MotionFitter};
use identifier_core::fit::{Blocks, Predicted, ROUNDING};
use identifier_core::number::Number;

/// The errors of an identified servo's prediction of a motion, rad. Only position and velocity at its beginning are
/// estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PredictionErrors {
    /// Root mean square and largest magnitude of the prediction's errors.
    pub rms: f64,
    /// See above.
    pub worst: f64,
    /// The standard deviation of the encoder's rounding.
    pub rounding: f64,
    /// Root mean square and largest standard error of the prediction that follow from those of the
    /// servo's parameters.
    pub uncertain: f64,
    /// See above.
    pub most_uncertain: f64,
    /// From the lowest to the highest position of the motion.
    pub range: f64,
}

impl PredictionErrors {
    /// The part of the motion's range that a model may lack. The loop that is tuned for it tolerates more.
    pub(super) const SHARE: f64 = 0.005;

    /// Largest root mean square of the errors, and largest error. Both are in standard deviations of rounding and of
    /// the parameters.
    pub(super) const ERRORS: f64 = 3.0;
    const WORST: f64 = 6.0;

    /// True if the servo that was identified is not the one that moved.
    pub(crate) fn refutes(&self) -> bool {
        let band = |times: f64, uncertain: f64| {
            let (rounding, unknown) = (times * self.rounding, times * uncertain);
            let share = Self::SHARE * times * self.range;
            libm::sqrt(rounding * rounding + unknown * unknown + share * share)
        };
        let within = self.rms <= band(Self::ERRORS, self.uncertain)
            && self.worst <= band(Self::WORST, self.most_uncertain);
        !within
    }
}

/// A prediction under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PredictionRun<N> {
    fitter: MotionFitter<N>,
    fit: MotionFit<N>,
    /// Covariance of the servo's parameters, machine units.
    covariance: [[N; PARAMETERS]; PARAMETERS],
    /// Sums of the squares of the errors and of their standard errors, and the largest of each.
    cost: N,
    uncertain: N,
    worst: N,
    most_uncertain: N,
}

impl<N: Number> PredictionRun<N> {
    /// Begins the prediction of a motion, by unknowns with a covariance, machine units of a sample.
    pub(super) fn begin(
        fitter: &MotionFitter<N>,
        mut fit: MotionFit<N>,
        unknowns: &[N; PARAMETERS],
        covariance: [[N; PARAMETERS]; PARAMETERS],
    ) -> Self {
        fitter.begin_prediction(&mut fit, unknowns);
        Self {
            fitter: *fitter,
            fit,
            covariance,
            cost: N::ZERO,
            uncertain: N::ZERO,
            worst: N::ZERO,
            most_uncertain: N::ZERO,
        }
    }

    /// Continues by a block; true if there is none left.
    pub(super) fn advance(&mut self, motion: &impl Blocks<N>) -> bool {
        match self.fitter.predict(&mut self.fit, motion) {
            Some(predicted) => self.measure(&predicted),
            None => return true,
        }
        false
    }

    fn measure(&mut self, predicted: &Predicted<N, PARAMETERS>) {
        let Predicted { error, row } = predicted;
        self.cost += *error * *error;
        if error.magnitude() > self.worst {
            self.worst = error.magnitude();
        }
        let mut variance = N::ZERO;
        for (covariances, &own) in self.covariance.iter().zip(row) {
            for (&covariance, &other) in covariances.iter().zip(row) {
                variance += covariance * own * other;
            }
        }
        if variance > N::ZERO {
            self.uncertain += variance;
            if variance > self.most_uncertain {
                self.most_uncertain = variance;
            }
        }
    }

    /// The errors after the pass through a motion. A count has this size, rad.
    pub(super) fn errors<const W: usize>(
        &self,
        motion: &MotionRecord<N, W>,
        resolution: f64,
    ) -> PredictionErrors {
        let blocks = motion.len().max(1) as f64;
        let mean_root = |sum: N| libm::sqrt(sum.to_f64() / blocks) * resolution;
        PredictionErrors {
            rms: mean_root(self.cost),
            worst: self.worst.to_f64() * resolution,
            rounding: libm::sqrt(ROUNDING) * resolution,
            uncertain: mean_root(self.uncertain),
            most_uncertain: libm::sqrt(self.most_uncertain.to_f64()) * resolution,
            range: motion.range().to_f64() * resolution,
        }
    }
}
