use super::super::IdentifiedServo;
use super::follower::Follower;
use super::motion::MotionRecord;
use super::placing::Placing;
use super::prediction::{Pass, Prediction, PredictionPass};
use super::prior::at_first;
use super::servo_fitter::ServoFitter;
use super::{POSITION, ROUNDING, UNKNOWNS, VELOCITY};
use crate::linalg::NormalEquations;
use crate::number::Number;

impl<N: Number> ServoFitter<N> {
    /// Begins the prediction of a motion by a servo that is known.
    #[must_use]
    pub fn begin_prediction(&self, servo: &IdentifiedServo) -> PredictionPass<N> {
        let scale = self.scale();
        PredictionPass {
            unknowns: self.unknowns(servo),
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| N::from_f64(servo.covariance[i][j] * scale[i] * scale[j]))
            }),
            next: 0,
            pass: None,
            placing: None,
        }
    }

    /// Continues by a piece of the record. Returns once it has ended.
    pub fn predict<const W: usize>(
        &self,
        predicting: &mut PredictionPass<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<Prediction> {
        let pass = match &mut predicting.pass {
            Some(pass) => pass,
            empty => empty.insert(self.begin_pass(&predicting.unknowns, motion)),
        };
        if let Some(piece) = motion.get(predicting.next) {
            pass.follower.advance(&self.step, motion, predicting.next);
            pass.measure(&predicting.covariance, piece.travel);
            predicting.next += 1;
            return None;
        }
        let deviation = self.speed_at_first(motion, true);
        let fastest = Self::FASTEST_AT_FIRST * deviation;
        let placing = predicting
            .placing
            .get_or_insert_with(|| Placing::new(N::from_f64(deviation), N::from_f64(fastest)));
        if placing.is_done() {
            return Some(self.prediction(pass, motion.len()));
        }
        let unknowns = &mut predicting.unknowns;
        [unknowns[POSITION], unknowns[VELOCITY]] =
            placing.next(pass, motion.len(), [unknowns[POSITION], unknowns[VELOCITY]]);
        predicting.pass = None;
        predicting.next = 0;
        None
    }

    fn begin_pass<const W: usize>(
        &self,
        unknowns: &[N; UNKNOWNS],
        motion: &MotionRecord<N, W>,
    ) -> Pass<N> {
        // A model that friction holds at first tells nothing of the velocity with which it began.
        let mut equations = NormalEquations::EMPTY;
        for (place, weight) in at_first(self.speed_at_first(motion, true)) {
            let weight = N::from_f64(weight);
            let mut row = [N::ZERO; UNKNOWNS];
            row[place] = weight;
            equations.add(&row, -(weight * unknowns[place]));
        }
        Pass {
            follower: Follower::new(unknowns, motion),
            equations,
            worst: N::ZERO,
            uncertain: N::ZERO,
            most_uncertain: N::ZERO,
            position: N::ZERO,
            range: [N::ZERO; 2],
        }
    }

    fn prediction(&self, pass: &Pass<N>, pieces: usize) -> Prediction {
        let resolution = self.resolution();
        let mean_root = |sum: N| libm::sqrt(sum.to_f64() / pieces.max(1) as f64);
        let [low, high] = pass.range;
        Prediction {
            rms: mean_root(pass.equations.cost()) * resolution,
            worst: pass.worst.to_f64() * resolution,
            rounding: libm::sqrt(ROUNDING) * resolution,
            uncertain: mean_root(pass.uncertain) * resolution,
            most_uncertain: libm::sqrt(pass.most_uncertain.to_f64()) * resolution,
            range: (high - low).to_f64() * resolution,
        }
    }
}
