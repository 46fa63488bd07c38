//! The servo by its motions.

use super::super::corrected::set_one_known;
use super::super::message::{DecisionKind, Identified};
use super::super::{CommissionSettings, FittedServo, RoughModel, ServoFitter};
use super::{CommissionSolver, Work};
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::Resonance;

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// A servo that moved by a rough model. Every parameter is uncertain by itself. None of an encoder's noise.
    pub(super) fn roughly(&self, servo: &RoughModel<N>) -> Option<IdentifiedServo> {
        let CommissionSettings {
            sample_time,
            resolution,
            noise,
            ..
        } = self.settings;
        let mut rough = IdentifiedServo::known(
            servo.to_si(sample_time, resolution)?,
            self.settings.command_delay + sample_time,
        );
        for (place, value) in rough.values().into_iter().enumerate() {
            set_one_known(&mut rough, place, value);
        }
        Some(rough).filter(|_| noise == 0.0)
    }

    /// Begins to fit the servo to the record of a motion.
    #[inline(never)]
    pub(super) fn fit(&mut self) {
        self.evidence.is_recorded = false;
        let fitter = ServoFitter::new(&self.settings);
        self.work = Work::Fit(fitter.begin(&self.record));
    }

    /// Begins to fit it to the first motion, with a wave of the angle.
    #[inline(never)]
    pub(super) fn fit_waves(&mut self) {
        self.evidence.has_waves = true;
        let unexplained = (self.evidence.fitted)
            .map(|servo| servo.unexplained)
            .filter(|unexplained| *unexplained > 0.0);
        let fitter = ServoFitter::new(&self.settings);
        self.work = match fitter.begin_waves(&self.record, unexplained) {
            Some(fit) => Work::Fit(fit),
            None => Work::Decide,
        };
    }

    /// Takes a servo that was fitted, or why none was.
    #[inline(never)]
    pub(super) fn take_servo(
        &mut self,
        fitted: Result<FittedServo, Reason>,
    ) -> Option<DecisionKind<N>> {
        self.work = Work::Decide;
        let evidence = &mut self.evidence;
        if evidence.has_waves {
            if !fitted.is_ok_and(|fitted| {
                fitted.explains
                    && fitted.forces.has_cogging()
                    && evidence.bears_out(fitted.servo.parameters.b)
            }) {
                return None;
            }
            // Its lines are measured anew, and faster.
            (evidence.masses, evidence.rounds, evidence.measured) = (None, 0, 0);
        }
        evidence.unexplained_reason = match fitted {
            Ok(fitted) => {
                let FittedServo {
                    servo,
                    forces,
                    explains,
                } = fitted;
                (evidence.fitted, evidence.forces) = (Some(servo), forces);
                (!explains).then_some(Reason::PartlyExplained)
            }
            Err(reason) => Some(reason),
        };
        match evidence.unexplained_reason {
            None => self.publish(DecisionKind::Identified),
            Some(_) => None,
        }
    }

    /// A decision with the present estimate of the servo.
    pub(super) fn publish(
        &self,
        decision: impl Fn(Identified<N>) -> DecisionKind<N>,
    ) -> Option<DecisionKind<N>> {
        let servo = self.evidence.servo()?;
        let mut at_rest = servo;
        let forces = &self.evidence.forces;
        at_rest.parameters.coulomb += forces.low_speed;
        if forces.has_cogging() {
            at_rest.parameters.coulomb += forces.wave_amplitude();
        }
        let mut identified = Identified {
            servo,
            ..Identified::new(&at_rest, &self.settings)
        };
        if forces.has_cogging() {
            // The force of the place looks like a command that acts less.
            identified.known = None;
        }
        if let Some(Resonance { mode, .. }) = self.designed_resonance() {
            let known = identified.known;
            identified.known = known.map(|known| known.with_load_on_a_spring(mode.ratio));
        }
        Some(decision(identified))
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::Limits;
    use super::super::order::tests::unexplained;
    use super::*;
    use identifier_core::parameters::ServoParameters;
    use identifier_core::tuning::AxisForces;

    #[test]
    fn a_wave_that_explained_lines_contradict_is_not_taken() {
        let limits = Limits::new([-0.5, 0.5], 15.0, [-10.0, 10.0]);
        let settings = CommissionSettings::new(1e-3, 1e-3, limits);
        let has_cogging = |b: f64| {
            let mut solver = CommissionSolver::<f32, 16>::new(&settings).expect("allowed");
            solver.evidence = unexplained();
            let servo = IdentifiedServo::known(ServoParameters::new(0.0, b, 5.0, 0.0), 1e-3);
            let forces = AxisForces {
                wave: [20.0, 0.0],
                order: 12.0,
                ..AxisForces::default()
            };
            let explains = true;
            solver.take_servo(Ok(FittedServo {
                servo,
                forces,
                explains,
            }));
            solver.evidence.forces.has_cogging()
        };
        assert!(has_cogging(110.0) && !has_cogging(200.0));
    }
}
