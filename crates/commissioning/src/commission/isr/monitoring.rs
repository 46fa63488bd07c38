//! Every sample: its command, its checks, and the end where they fail.

use super::super::Phase;
use super::super::conservative_pid::ConservativePid;
use super::super::holding::Holding;
use super::super::standing::Standing;
use super::super::state::{Activity, CommissionState, Next};
use super::CommissionIsr;
use identifier_core::number::Number;
use identifier_core::reason::Reason;

impl<N: Number> CommissionIsr<N> {
    /// Half-cycles running after which the bandwidth is reduced, fewer than make an oscillation.
    const HALF_CYCLES: u32 = 3;

    /// The part of the largest bandwidth below which it is not reduced further.
    const LEAST: f64 = 0.08;

    /// Half-cycles faster than the reference and than the loop's own after which its bandwidth is reduced.
    const DRIVEN: u32 = 4;

    /// The command of the activity; it ends the commissioning where there is none any more.
    pub(super) fn command(&self, state: &mut CommissionState<N>, increment: N) -> Option<N> {
        let position = state.position;
        match &mut state.activity {
            Activity::Free => return None,
            Activity::Probing(probing) => return Some(self.probing.control(probing, increment)),
            Activity::Holding(holding)
            | Activity::ResponseWindows(holding)
            | Activity::OnTrial(holding, _) => {
                if let Some(command) = holding.process(position, increment) {
                    let command = state.standing.push().unwrap_or(command);
                    return Some(state.governed.confined(command));
                }
            }
        }
        // The error is beyond the loop's counter.
        self.end(state, Reason::TravelLeft);
        match &mut state.activity {
            Activity::Holding(before) => before.process(position, N::ZERO),
            _ => None,
        }
    }

    /// Checks the sample.
    pub(super) fn monitored(&self, state: &mut CommissionState<N>) -> Result<(), Reason> {
        if !state.is_watched {
            return Ok(());
        }
        let checked = self.watch.process(&mut state.watch, &state.observation);
        self.reduce_bandwidth(state);
        let by_samples = [
            Reason::EncoderJumped,
            Reason::SpeedExceeded,
            Reason::Reversed,
        ];
        if by_samples.map(Err).contains(&checked) && self.may_be_noise(state) {
            return Ok(());
        }
        // The gains before bring it back from beyond the limits of the commissioning.
        checked.or_else(|reason| match reason {
            _ if state.suspected_fault().is_some() => self.confirmed(state, reason),
            Reason::ActuatorDead => Err(match &state.activity {
                Activity::OnTrial(_, trial) if trial.may_hold_still_under(state.command) => {
                    Reason::DoesNotMove
                }
                _ => reason,
            }),
            limit if self.is_back(state) && !limit.disables_stage() => Ok(()),
            fault => Err(fault),
        })
    }

    /// Tests whether a servo at standstill can move: while it follows a reference, moves to a position or is held
    /// there. False during the test command, and until the servo is braked again.
    pub(super) fn moves(&self, state: &mut CommissionState<N>) -> Result<bool, Reason> {
        let (position, command) = (state.position, state.command);
        let (servo, led) = match &state.activity {
            Activity::ResponseWindows(holding) => {
                let error = holding.reference() - position;
                let error = if state.response_motion.learns() {
                    N::ZERO
                } else {
                    error
                };
                (state.response_motion.loop_plan().0, Some(error))
            }
            Activity::Holding(_) if state.phase.is_end() || state.suspected_fault().is_some() => {
                return Ok(true);
            }
            Activity::Holding(holding) if holding.is_led() => (&state.rough, Some(N::ZERO)),
            Activity::Holding(_) => (&state.rough, None),
            _ => return Ok(true),
        };
        if servo.is_known() {
            (self.standing).take(&mut state.standing, servo, position, command, led)?;
        }
        Ok(!state.standing.is_at_work())
    }

    /// Reduces the bandwidth if a servo that is being identified oscillates under the holding loop. A second mass,
    /// not measured yet, multiplies the gain at high frequency.
    fn reduce_bandwidth(&self, state: &mut CommissionState<N>) {
        let is_studied =
            !matches!(state.phase, Phase::Rest | Phase::Trial) && state.suspected_fault().is_none();
        let holding = match &mut state.activity {
            Activity::Holding(holding) if is_studied && !state.phase.is_end() => holding,
            Activity::ResponseWindows(holding)
                if is_studied && !state.response_motion.injects() =>
            {
                holding
            }
            _ => return,
        };
        if let Some(half_cycle) = state.half_cycles.take(state.position)
            && half_cycle.is_faster(self.pace, ConservativePid::bandwidth(holding.controller()))
        {
            state.driven += 1;
        }
        if state.driven < Self::DRIVEN && state.watch.half_cycles() < Self::HALF_CYCLES {
            return;
        }
        let part = N::from_f64(ConservativePid::<N>::REDUCED_BANDWIDTH);
        let bandwidth = part * ConservativePid::bandwidth(holding.controller());
        if bandwidth > N::from_f64(Self::LEAST) * self.conservative.max_bandwidth() {
            state.bandwidth = bandwidth;
            holding.reduce_bandwidth(part);
            state.driven = 0;
            state.watch.forget_half_cycles();
        }
    }

    /// True once the old gains hold the servo again.
    pub(super) fn is_back(&self, state: &CommissionState<N>) -> bool {
        state.was_end && state.phase != Phase::Applied
    }

    /// True if noise may look like a motion in single samples: until the noise at rest is measured, and after an end
    /// by noise.
    fn may_be_noise(&self, state: &CommissionState<N>) -> bool {
        let was_noisy = state.reason == Some(Reason::EncoderNoise) && !self.hysteresis.is_coarse();
        was_noisy || self.rest(state) != Some(Ok(()))
    }

    /// The rest before the first motion, as the encoder shows it; none after it, and before that is clear.
    pub(super) fn rest(&self, state: &CommissionState<N>) -> Option<Result<(), Reason>> {
        if state.phase != Phase::Rest {
            return Some(Ok(()));
        }
        let is_declared = self.hysteresis.is_coarse();
        let noise = &state.rest_noise;
        noise.judge(state.position, self.tolerated_noise, is_declared)
    }

    /// Ends it: the old gains hold the servo again if they can, or the stage is disabled.
    pub(super) fn end(&self, state: &mut CommissionState<N>, reason: Reason) {
        state.phase = match state.phase {
            Phase::Trial | Phase::Applied | Phase::RolledBack => Phase::RolledBack,
            _ => Phase::Aborted,
        };
        let is_noisy = self.hysteresis.is_coarse() && may_be_noise(reason);
        state.reason = Some(if is_noisy {
            Reason::EncoderNoise
        } else {
            reason
        });
        state.drop_record();
        state.standing = Standing::at(state.position);
        state.activity = match self.held_as_before(state) {
            Some(mut holding) if !reason.disables_stage() => {
                holding.send(N::ZERO);
                Activity::Holding(holding)
            }
            _ => Activity::Free,
        };
    }

    /// Held at its position by the old gains, if there are any.
    fn held_as_before(&self, state: &mut CommissionState<N>) -> Option<Holding<N>> {
        if let Activity::OnTrial(_, trial) = &state.activity {
            state.measured = Some(*trial);
        }
        // Its integral balances the load, and its derivative brakes.
        let (before, velocity) = (self.before?, state.governed.speed());
        let command = state.held + before.linear(N::ZERO, velocity);
        Some(self.held_by(before, state.position, velocity, command))
    }

    /// A load or friction can look like this fault: the old gains hold the servo until a test command shows which it
    /// is. False for any other reason.
    pub(super) fn suspected_reason(&self, state: &mut CommissionState<N>, fault: Reason) -> bool {
        let is_proven = match &state.activity {
            Activity::OnTrial(_, trial) => trial.is_motion_missed(),
            _ => self.standing.is_final(&state.standing),
        };
        let is_doubtful = may_be_feigned(fault) && state.suspected_fault().is_none() && !is_proven;
        if !is_doubtful || state.phase.is_end() {
            return false;
        }
        let Some(holding) = self.held_as_before(state) else {
            return false;
        };
        let (speed, pushed) = (state.governed.speed().magnitude(), 0);
        // The other way than the command that had no effect.
        let up = state.command < state.held;
        state.drop_record();
        self.watch.forget(&mut state.watch, state.command);
        state.begin(Activity::Holding(holding));
        state.next = Next::Prove {
            fault,
            speed,
            up,
            pushed,
        };
        true
    }

    /// The suspected fault, if this reason confirms it. The servo then moves against the old gains, leaves its
    /// travel, or is not braked by them.
    fn confirmed(&self, state: &CommissionState<N>, reason: Reason) -> Result<(), Reason> {
        /// Rests in which a servo is braked.
        const BRAKED: u32 = 5;
        let is_braking = state.passed <= BRAKED * self.rest;
        match (reason, state.suspected_fault()) {
            (Reason::EncoderStuck | Reason::ActuatorDead, _) => Ok(()),
            (Reason::SpeedExceeded, _) if is_braking => Ok(()),
            (Reason::SpeedExceeded | Reason::TravelLeft | Reason::Reversed, Some(fault)) => {
                Err(fault)
            }
            _ => Err(reason),
        }
    }

    /// Brakes a servo with a suspected fault, and tests it with a growing command. If the servo follows, there is no
    /// fault.
    pub(super) fn prove(
        &self,
        state: &mut CommissionState<N>,
        is_at_rest: bool,
    ) -> Result<(), Reason> {
        /// Counts of a motion.
        const MOVED: f64 = 4.0;
        /// Rests of a push that grows by twice the command's limit in each: from one limit to the other, and then one more.
        const PUSH: u32 = 2;
        let Next::Prove {
            fault,
            speed,
            up,
            pushed,
        } = &mut state.next
        else {
            return Ok(());
        };
        let Activity::Holding(holding) = &mut state.activity else {
            return Ok(());
        };
        let [passed, rest] = [state.passed, self.rest].map(|samples| N::from_count(samples as i32));
        // A servo at standstill need not be braked.
        if *pushed == 0 && *speed * rest > N::from_f64(MOVED) {
            let moved = state.position - holding.reference();
            if moved.magnitude() > *speed * passed + self.pace * rest {
                return Err(*fault);
            }
            if !is_at_rest {
                return Ok(());
            }
            holding.stay(state.position, holding.resting().command);
        }
        *pushed += 1;
        let [low, high] = self.limit;
        let limit = if *up { high } else { low };
        let moved = state.position - holding.reference();
        let moved = if *up { moved } else { -moved };
        if moved > N::from_f64(MOVED) {
            Err(Reason::TooLittleEvidence)
        } else if moved < N::from_f64(-MOVED) || *pushed >= PUSH * self.rest {
            Err(*fault)
        } else {
            let rests = N::from_count(*pushed as i32) * rest.reciprocal();
            holding.disturb(N::from_f64(2.0) * rests * limit);
            Ok(())
        }
    }
}

/// True for a fault that a sound axis may seem to have, which a load or friction holds.
const fn may_be_feigned(fault: Reason) -> bool {
    matches!(
        fault,
        Reason::EncoderStuck | Reason::ActuatorDead | Reason::Reversed
    )
}

/// True for an outcome that an encoder's noise may cause.
const fn may_be_noise(outcome: Reason) -> bool {
    matches!(
        outcome,
        Reason::TooLittleEvidence
            | Reason::EstimateAtBound
            | Reason::PartlyExplained
            | Reason::ResonanceOrBacklash
            | Reason::PredictionMissed
            | Reason::DoesNotMove
            | Reason::NeverAtRest
            | Reason::ActuatorWeak
            | Reason::Oscillating
            | Reason::TravelLeft
            | Reason::SpeedExceeded
    )
}
