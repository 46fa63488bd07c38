//! The order of the activities, from the first motion to the trial.

use super::super::conservative_pid::ConservativePid;
use super::super::frequency_response::{ResponseProgress, ResponseWindows};
use super::super::gains::Loop;
use super::super::holding::Holding;
use super::super::message::EventKind;
use super::super::state::{Activity, CommissionState, Next};
use super::super::{Phase, ProbingState, RoughModel};
use super::CommissionIsr;
use identifier_core::control::ControlSample;
use identifier_core::number::Number;
use identifier_core::reason::Reason;

impl<N: Number> CommissionIsr<N> {
    /// Continues the activity after its command, or begins the next one.
    pub(super) fn proceed(&self, state: &mut CommissionState<N>) -> Result<(), Reason> {
        let Some(increment) = state.observation.increment else {
            return Ok(());
        };
        state.passed = state.passed.saturating_add(1);
        match self.rest(state) {
            None => return Ok(()),
            Some(rest) => rest?,
        }
        // What it is led through waits meanwhile.
        if !self.moves(state)? {
            return Ok(());
        }
        let position = state.position;
        match &mut state.activity {
            Activity::Free => {
                if state.phase == Phase::Rest
                    && let Some(probing) = self.probing.start_released(position, state.passed)
                {
                    self.begin_probing(state, probing);
                }
                Ok(())
            }
            Activity::Probing(probing) => {
                let progress = self.probing.learn(probing, increment);
                let (servo, broke_away) = (*probing.servo(), probing.broke_away());
                match progress {
                    // It is at rest, and known well enough to be led through frequency-response motions.
                    Some(Err(reason @ (Reason::TooLittleEvidence | Reason::Oscillating)))
                        if servo.is_known() && !self.hysteresis.is_coarse() =>
                    {
                        if reason == Reason::Oscillating {
                            state.bandwidth = N::from_f64(ConservativePid::<N>::REDUCED_BANDWIDTH)
                                * self.conservative.max_bandwidth();
                        }
                        state.end_record(EventKind::Ended {
                            moved: servo,
                            is_cut: true,
                            broke_away,
                        });
                        self.hold(state, &servo, self.delay)
                    }
                    None => Ok(()),
                    Some(Ok(())) => {
                        state.end_record(EventKind::Ended {
                            moved: servo,
                            is_cut: false,
                            broke_away,
                        });
                        self.hold(state, &servo, self.delay)
                    }
                    Some(Err(reason)) => Err(reason),
                }
            }
            Activity::Holding(_) if state.phase.is_end() => Ok(()),
            Activity::Holding(_) if state.passed > self.patience => Err(Reason::NeverAtRest),
            Activity::Holding(holding) => {
                let is_at_rest = holding.is_at_rest();
                self.proceed_from_rest(state, is_at_rest)
            }
            Activity::ResponseWindows(holding) => {
                let sample = ResponseWindows {
                    position,
                    increment,
                    velocity: state.governed.speed(),
                    command: state.command,
                    is_cut: self.governor.cuts(&state.governed, state.command),
                };
                match state.response_motion.process(holding, &sample) {
                    ResponseProgress::Going => Ok(()),
                    ResponseProgress::Balance(balance) => {
                        state.event = Some(EventKind::Balance(balance));
                        Ok(())
                    }
                    ResponseProgress::Line(sums) => {
                        state.event = Some(EventKind::Line(sums));
                        Ok(())
                    }
                    ResponseProgress::Over => {
                        let (&servo, delay, _) = state.response_motion.loop_plan();
                        state.end_record(EventKind::Ended {
                            moved: servo,
                            is_cut: false,
                            broke_away: None,
                        });
                        self.hold(state, &servo, delay)
                    }
                }
            }
            Activity::OnTrial(holding, trial) => {
                if trial.process(holding, position, state.command)? {
                    let held = Activity::Holding(*holding);
                    state.measured = Some(*trial);
                    state.phase = Phase::Applied;
                    state.activity = held;
                }
                Ok(())
            }
        }
    }

    /// The next step of a servo that is held: a motion once the solver has decided, or the trial.
    fn proceed_from_rest(
        &self,
        state: &mut CommissionState<N>,
        is_at_rest: bool,
    ) -> Result<(), Reason> {
        if state.suspected_fault().is_some() {
            return self.prove(state, is_at_rest);
        }
        if state.phase == Phase::Rest {
            if is_at_rest {
                let held = Some(state.command);
                self.begin_probing(state, self.probing.start(held));
            }
            return Ok(());
        }
        match state.next {
            Next::Decision => {
                let position = state.position;
                let hunts = state.bandwidth < self.conservative.max_bandwidth();
                if is_at_rest
                    && hunts
                    && let Activity::Holding(holding) = &mut state.activity
                {
                    holding.wait(position);
                }
            }
            Next::Prove { .. } => {}
            Next::End(reason) => return Err(reason),
            // A fast background may have the gains before the servo is at rest.
            Next::Tune | Next::Trial if !is_at_rest => {}
            Next::Tune => {
                self.begin_gains(state);
                state.next = Next::Decision;
            }
            Next::Trial if state.phase != Phase::Gains => self.begin_gains(state),
            Next::Trial => {
                state.next = Next::Decision;
                self.begin_trial(state)?;
            }
            Next::ResponseMotion => {
                if is_at_rest {
                    self.know(state);
                    state.next = Next::Decision;
                    self.begin_response_motion(state)?;
                }
            }
        }
        Ok(())
    }

    fn begin_probing(&self, state: &mut CommissionState<N>, probing: ProbingState<N>) {
        state.phase = Phase::Probe;
        // A fall is recorded from the rest before it.
        if !probing.is_away() {
            state.begin_record();
        }
        state.begin(Activity::Probing(probing));
    }

    /// Begins the frequency-response motions of a servo at rest, under the loop that they plan.
    fn begin_response_motion(&self, state: &mut CommissionState<N>) -> Result<(), Reason> {
        let (servo, delay, bandwidth) = state.response_motion.loop_plan();
        let bandwidth = bandwidth.limited(N::ZERO, state.bandwidth);
        let controller = self.conservative.around(servo, delay, bandwidth);
        let controller = controller.ok_or(Reason::TooLittleEvidence)?;
        state.phase = Phase::FrequencyResponse;
        let mut holding = self.held_by(controller, state.position, N::ZERO, state.command);
        state.response_motion.begin(&mut holding);
        state.begin(Activity::ResponseWindows(holding));
        Ok(())
    }

    /// Watches the servo by the model that the solver identified, from now on, with the load under which it rests.
    fn know(&self, state: &mut CommissionState<N>) {
        let Some(identified) = &mut state.identified else {
            return;
        };
        if let Activity::Holding(holding) = &state.activity
            && holding.is_at_rest()
        {
            identified.set_load_from_standstill(holding.resting().command, self.spare);
        }
        if let Some(known) = &identified.known {
            self.watch.know(&mut state.watch, known);
        }
    }

    /// Holds the servo with conservative gains, and brings it back to where it began.
    fn hold(
        &self,
        state: &mut CommissionState<N>,
        servo: &RoughModel<N>,
        delay: N,
    ) -> Result<(), Reason> {
        if state.phase == Phase::Probe {
            state.phase = Phase::Fit;
        }
        let controller = self.conservative.around(servo, delay, state.bandwidth);
        let controller = controller.ok_or(Reason::TooLittleEvidence)?;
        let velocity = state.governed.speed();
        let command = match &state.activity {
            // Its integral balances the load, and its derivative brakes.
            Activity::ResponseWindows(_) => servo.holding() + controller.linear(N::ZERO, velocity),
            _ => state.command,
        };
        state.rough = *servo;
        let mut holding = self.held_by(controller, state.position, velocity, command);
        holding.send(N::ZERO);
        state.begin(Activity::Holding(holding));
        Ok(())
    }

    fn begin_gains(&self, state: &mut CommissionState<N>) {
        self.know(state);
        state.phase = Phase::Gains;
        state.passed = 0;
    }

    fn begin_trial(&self, state: &mut CommissionState<N>) -> Result<(), Reason> {
        let (Some(candidate), Activity::Holding(held)) = (&state.candidate, &state.activity) else {
            return Err(Reason::NoGains);
        };
        let last = held.resting();
        let mut holding = self.held_after(candidate.controller, state.position, &last);
        holding.rest_for(candidate.rest);
        if candidate.trial.is_away(state.position) {
            holding.send(candidate.trial.start());
        }
        let trial = Activity::OnTrial(holding, candidate.trial);
        state.phase = Phase::Trial;
        state.begin(trial);
        Ok(())
    }

    pub(super) fn held_by(
        &self,
        controller: Loop<N>,
        position: N,
        velocity: N,
        command: N,
    ) -> Holding<N> {
        let last = ControlSample {
            error: N::ZERO,
            increment: N::ZERO,
            velocity,
            command,
        };
        self.held_after(controller, position, &last)
    }

    /// Held from after the last sample of another controller.
    pub(super) fn held_after(
        &self,
        controller: Loop<N>,
        position: N,
        last: &ControlSample<N>,
    ) -> Holding<N> {
        Holding::take_over(controller, self.limit, position, last, self.pace, self.rest)
    }
}
