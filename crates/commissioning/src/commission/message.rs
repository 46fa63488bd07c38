use super::frequency_response::{FrictionBalance, LineSums, ResponsePlan};
use super::gains::{HoldingGains, Loop};
use super::rough_model::Breakaway;
use super::trial::Trial;
use super::{CommissionSettings, Limits, RoughModel};
use crate::watch::{KnownServo, LOW_SPEED};
use identifier_core::error::OutOfRange;
use identifier_core::identifier::NumberedBlock;
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::{Tuning, TuningError};
use identifier_core::units::Units;

/// An event of the record, from the interrupt to the solver. It is a plain value that a caller transfers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordEvent<N>(pub(super) EventKind<N>);

impl<N> RecordEvent<N> {
    /// The number of blocks of the record with this event, from that before it.
    #[inline]
    #[must_use]
    pub fn recorded(&self, blocks: u16) -> u16 {
        match self.0 {
            EventKind::Begins => 0,
            EventKind::Block(_) => blocks.saturating_add(1),
            EventKind::Balance(_) | EventKind::Line(_) | EventKind::Ended { .. } => blocks,
        }
    }
}

/// The events of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum EventKind<N> {
    /// The motion that is recorded begins, or the rest before it.
    Begins,
    /// A piece of its record.
    Block(NumberedBlock<N>),
    /// The mean motion of a frequency-response motion that is over, after the sums of its lines.
    Balance(FrictionBalance<N>),
    /// The sums of a line over a frequency-response motion that is over: line after line, motion after motion.
    Line(LineSums<N>),
    /// The recorded motion has ended, or all frequency-response motions: study them. The servo as it moved by then, and
    /// whether the motion was over before there was enough evidence. And where a probing motion broke away.
    Ended {
        moved: RoughModel<N>,
        is_cut: bool,
        broke_away: Option<Breakaway<N>>,
    },
}

/// A decision of the solver. There is one for each motion that has ended, and one more after tuning.
///
/// All that the interrupt's half needs is prepared in it: no sample converts from SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision<N: Number>(pub(super) DecisionKind<N>);

/// The decisions of the solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum DecisionKind<N: Number> {
    /// The servo as one mass explains its motion. Another decision follows.
    Identified(Identified<N>),
    /// The response is to be measured as planned. [`Verified`] follows, or another plan.
    ///
    /// [`Verified`]: Self::Verified
    ResponseMotion(ResponsePlan<N>),
    /// The servo as the motions and its response show it; gains are looked for next.
    Verified(Identified<N>),
    /// Gains and their predicted performance.
    Tuned(Candidate<N>),
    /// The commissioning cannot continue, for this reason. If no gains meet the goal, the error names one that some would.
    Failed(Reason, Option<TuningError>),
}

impl<N: Number> Decision<N> {
    /// The servo, where the decision carries one.
    #[must_use]
    pub fn servo(&self) -> Option<&IdentifiedServo> {
        match &self.0 {
            DecisionKind::Identified(known) | DecisionKind::Verified(known) => Some(&known.servo),
            _ => None,
        }
    }

    /// The gains and their predicted response, if the decision has them.
    #[must_use]
    pub fn tuning(&self) -> Option<&Tuning> {
        match &self.0 {
            DecisionKind::Tuned(candidate) => Some(&candidate.tuning),
            _ => None,
        }
    }
}

/// An identified servo, SI, and its model in machine units for the interrupt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Identified<N> {
    /// The servo, SI.
    pub(super) servo: IdentifiedServo,
    pub(super) rough: RoughModel<N>,
    /// Samples from a command to its acceleration.
    pub(super) delay: N,
    /// For the watch over it.
    pub(super) known: Option<KnownServo<N>>,
}

impl<N: Number> Identified<N> {
    pub(super) fn new(servo: &IdentifiedServo, settings: &CommissionSettings) -> Self {
        let CommissionSettings {
            sample_time,
            resolution,
            ..
        } = *settings;
        Self {
            servo: *servo,
            rough: RoughModel::from_si(&servo.parameters, sample_time, resolution),
            delay: N::from_f64(servo.delay / sample_time),
            known: KnownServo::from_identified(&settings.watch(), servo),
        }
    }

    /// Takes in the command at which the servo is at rest. If friction does not explain its distance from the command
    /// that balances the load, the load has changed.
    pub(super) fn set_load_from_standstill(&mut self, command: N, spare: N) {
        let friction = N::from_f64(LOW_SPEED);
        let reach = friction * self.rough.coulomb() * self.rough.per_gain + spare;
        let holding = self.rough.holding();
        let met = holding.limited(command - reach, command + reach);
        if met != holding {
            self.rough.set_holding_command(met);
            self.known = self.known.map(|known| known.with_holding_of(met));
        }
    }
}

/// Gains that are to be tried, and their trial in machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate<N: Number> {
    /// The gains and their predicted response, SI.
    pub(super) tuning: Tuning,
    pub(super) controller: Loop<N>,
    pub(super) trial: Trial<N>,
    /// Samples for which the servo must be still to have come to rest under them.
    pub(super) rest: u32,
}

impl<N: Number> Candidate<N> {
    /// The largest part of the travel in its direction at which the trial's step ends. A longer one begins on the other
    /// side.
    pub(super) const MAX_END: f64 = 0.45;

    /// The part of the travel beyond its ends that it may overshoot into.
    const USED: f64 = 0.7;

    /// Where a step of this size (rad) begins, from where the commissioning began, and the same with its sign.
    pub(super) fn start_and_step(step: f64, limits: &Limits) -> [f64; 2] {
        let [low, high] = limits.travel;
        let direction = if high < -low { -1.0 } else { 1.0 };
        let end = step.min(Self::MAX_END * high.max(-low));
        [direction * (end - step), direction * step]
    }

    /// # Errors
    /// A gain that no controller has.
    pub(super) fn new(
        tuning: &Tuning,
        servo: &IdentifiedServo,
        settings: &CommissionSettings,
    ) -> Result<Self, OutOfRange> {
        let units = Units::new(settings.sample_time, settings.resolution)?;
        let limits = &settings.limits;
        let predicted_response = &tuning.predicted_response;
        let [start, step] = Self::start_and_step(predicted_response.step, limits);
        // It ends before it leaves the travel, either way.
        let [low, high] = limits.travel;
        let room = (high - start.max(start + step)).min(start.min(start + step) - low);
        let mut within = *tuning;
        let overshoot = &mut within.predicted_response.overshoot;
        *overshoot = overshoot.min(Self::USED * room / libm::fabs(step));
        let beside = room - *overshoot * libm::fabs(step);
        // Under noise a servo rests too rarely to be waited for once more.
        let returns = settings.noise == 0.0;
        // A servo that hunts about its friction is still for a while too.
        let settling = Trial::<N>::settling(tuning);
        Ok(Self {
            tuning: *tuning,
            controller: HoldingGains::tuned(tuning, limits).build(&units)?,
            trial: Trial::new(&within, &units, [start, beside, step], servo, returns),
            rest: (0.5 * settling / settings.sample_time) as u32,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commission::trial::tests::predicted;
    use identifier_core::parameters::ServoParameters;

    const RESOLUTION: f64 = 1e-4;

    fn trial(tuning: &Tuning, travel: [f64; 2]) -> Trial<f64> {
        candidate(tuning, travel).trial
    }

    /// Where the trial's step of this size begins, rad.
    fn start(step: f64, travel: [f64; 2]) -> f64 {
        let mut tuning = predicted();
        tuning.predicted_response.step = step;
        trial(&tuning, travel).start() * RESOLUTION
    }

    fn candidate(tuning: &Tuning, travel: [f64; 2]) -> Candidate<f64> {
        let servo = IdentifiedServo::known(ServoParameters::new(0.0, 200.0, 0.0, 0.0), 0.0);
        let limits = Limits::new(travel, 15.0, [-10.0, 10.0]);
        let settings = CommissionSettings::new(1e-3, RESOLUTION, limits);
        Candidate::new(tuning, &servo, &settings).expect("gains")
    }

    /// From 0 to 0.2 rad of ±0.5: 0.7 of the 0.3 rad beyond it are 1.05 of the step.
    #[test]
    fn a_trial_ends_before_its_overshoot_leaves_the_travel() {
        let [most, expected, less] = [5.0, 1.05, 1.0].map(|overshoot| {
            let mut tuning = predicted();
            tuning.predicted_response.step = 0.2;
            tuning.predicted_response.overshoot = overshoot;
            trial(&tuning, [-0.5, 0.5])
        });
        assert_eq!(most, expected);
        assert_ne!(most, less);
    }

    #[test]
    fn a_step_that_is_too_long_for_one_side_of_the_travel_begins_on_the_other() {
        // Up to 0.45 of the travel from its position; a longer one ends there.
        for (step, travel, expected) in [
            (0.2, [-0.5, 0.5], 0.0),
            (0.4, [-0.5, 0.5], -0.175),
            (0.45, [-0.5, 0.5], -0.225),
            (0.45, [-0.2, 0.8], -0.09),
            (0.45, [-0.8, 0.2], 0.09),
            (0.2, [0.0, 0.5], 0.0),
        ] {
            let begun = start(step, travel);
            assert!(
                (begun - expected).abs() < 1e-9,
                "{step} {travel:?}: {begun}"
            );
        }
    }
}
