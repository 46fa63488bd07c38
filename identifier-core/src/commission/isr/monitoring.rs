//! Every sample: its command, its checks, and the end where they fail.

use super::super::conservative_pid::ConservativePid;
use super::super::noise::Rest;
use super::super::state::{Activity, CommissionState};
use super::super::{Phase, Reason};
use super::CommissionIsr;
use crate::number::Number;

impl<N: Number> CommissionIsr<N> {
    /// Swings running after which a loop gives way, fewer than make an oscillation.
    const SWINGS: u32 = 3;

    /// The part of its bandwidth that it keeps.
    pub(super) const GIVEN_WAY: f64 = 0.4;

    /// The part of the largest bandwidth below which it gives no more way.
    const LEAST: f64 = 0.08;

    /// Swings faster than the reference and than the loop's own after which it gives way.
    const DRIVEN: u32 = 4;

    /// The command of the activity; it ends the commissioning where there is none any more.
    pub(super) fn command(&self, state: &mut CommissionState<N>, increment: N) -> Option<N> {
        let position = state.position;
        match &mut state.activity {
            Activity::Free => return None,
            Activity::Probing(probing) => return Some(self.probing.control(probing, increment)),
            Activity::Holding(holding)
            | Activity::Sliding(holding)
            | Activity::OnTrial(holding, _) => {
                let command = holding.process(position, increment);
                if command.is_some() {
                    return command;
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
        self.give_way(state);
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
            Reason::ActuatorDead => Err(match &state.activity {
                Activity::OnTrial(_, trial) if trial.may_rest_under(state.command) => {
                    Reason::DoesNotMove
                }
                _ => reason,
            }),
            limit if self.is_back(state) && !limit.disables_stage() => Ok(()),
            fault => Err(fault),
        })
    }

    /// Goes on with less bandwidth where a servo that is studied swings under the loop that holds it: a second mass that
    /// nothing has shown yet makes it many times as strong at high frequency.
    fn give_way(&self, state: &mut CommissionState<N>) {
        let is_studied = !matches!(state.phase, Phase::ReleasedCheck | Phase::Trial);
        let holding = match &mut state.activity {
            Activity::Holding(holding) if is_studied && !state.phase.is_end() => holding,
            Activity::Sliding(holding) if is_studied && !state.slide.injects() => holding,
            _ => return,
        };
        if let Some(swing) = state.swings.take(state.position)
            && swing.is_faster(self.pace, ConservativePid::bandwidth(holding.controller()))
        {
            state.driven += 1;
        }
        if state.driven < Self::DRIVEN && state.watch.swings() < Self::SWINGS {
            return;
        }
        let part = N::from_f64(Self::GIVEN_WAY);
        let bandwidth = part * ConservativePid::bandwidth(holding.controller());
        if bandwidth > N::from_f64(Self::LEAST) * self.conservative.max_bandwidth() {
            state.bandwidth = bandwidth;
            holding.give_way(part);
            state.driven = 0;
            state.watch.forget_swings();
        }
    }

    /// True once the gains before hold the servo again.
    pub(super) fn is_back(&self, state: &CommissionState<N>) -> bool {
        state.was_end && state.phase != Phase::Applied
    }

    /// True if noise may be what looks like a motion in single samples: until the rest is known to be quiet, and after an end
    /// because it was not.
    fn may_be_noise(&self, state: &CommissionState<N>) -> bool {
        let was_noisy = state.reason == Some(Reason::EncoderNoise) && !self.hysteresis.is_coarse();
        was_noisy || self.rest(state) != Some(Rest::Quiet)
    }

    /// The rest before the first motion, as the encoder shows it; none after it, and before that is clear.
    pub(super) fn rest(&self, state: &CommissionState<N>) -> Option<Rest> {
        if state.phase != Phase::ReleasedCheck {
            return Some(Rest::Quiet);
        }
        let is_declared = self.hysteresis.is_coarse();
        let noise = &state.rest_noise;
        noise.judge(state.position, self.tolerated_noise, is_declared)
    }

    /// Ends it: the gains before hold again where they can, or the stage is disabled.
    pub(super) fn end(&self, state: &mut CommissionState<N>, reason: Reason) {
        state.phase = match state.phase {
            Phase::Trial | Phase::Applied | Phase::RolledBack => Phase::RolledBack,
            _ => Phase::Aborted,
        };
        let noise = self.hysteresis.is_coarse().then_some(Reason::EncoderNoise);
        let suspect = state.suspect.or(noise);
        let effect = suspect.filter(|effect| effect.may_appear_as(reason));
        state.reason = Some(effect.unwrap_or(reason));
        state.drop_record();
        if let Activity::OnTrial(_, trial) = &state.activity {
            state.measured = Some(*trial);
        }
        state.activity = match self.before {
            Some(before) if !reason.disables_stage() => {
                // Its integral balances the load, and its derivative brakes.
                let velocity = state.velocity_now;
                let command = state.held + before.pid.linear(N::ZERO, velocity);
                let mut holding = self.held_by(before, state.position, velocity, command);
                holding.send(N::ZERO);
                Activity::Holding(holding)
            }
            _ => Activity::Free,
        };
    }
}
