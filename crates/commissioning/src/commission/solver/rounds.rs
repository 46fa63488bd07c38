//! The rounds of frequency-response motions, and the masses that they show.

use super::super::frequency_response::{LineSearch, ResponsePlanner};
use super::super::message::DecisionKind;
use super::super::response::ResponseEstimate;
use super::order::Evidence;
use super::planning::{Planning, Tuned};
use super::{CommissionSolver, Work};
use identifier_core::number::Number;
use identifier_core::tuning::{AxisForces, Resonance};

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// Motions of the first round, one in each direction. Then those of a further round: both directions, and both
    /// again with the injection inverted.
    const FIRST_ROUND: u8 = 2;
    const ROUND: u8 = 4;

    /// The part of the usual window in which an axis is faster: its force changes with the place, or sticks.
    const FASTER: f64 = 0.25;

    /// The lowest frequency of lines between the others over the bandwidth: twice its crossover.
    const ABOVE: f64 = 4.0;

    /// A resonance below this is looked for with low lines, rad/s.
    const LOW: f64 = 45.0 * core::f64::consts::TAU;

    /// The resonance that gains are looked for with.
    pub(super) fn designed_resonance(&self) -> Option<Resonance> {
        self.evidence.masses.and_then(|masses| masses.resonance)
    }

    /// The part of the usual window in which lines are measured. An axis that is known to stick or to cog moves faster.
    fn window_part(&self) -> f64 {
        if self.evidence.moves_unevenly() {
            Self::FASTER
        } else {
            1.0
        }
    }

    /// Measures the frequency response, or more lines of it. Without room the order continues with its next step.
    #[inline(never)]
    pub(super) fn measure(&mut self) {
        let Evidence { masses, rounds, .. } = self.evidence;
        let is_between = masses.is_some_and(|masses| masses.may_hide_a_resonance());
        let is_sure = self.evidence.unexplained_reason.is_none();
        // What two rounds leave open is of low speed, or of the place.
        let is_open = masses.map_or(rounds > 0, |masses| {
            (rounds > 1 || (is_sure && !masses.is_explained()))
                && !masses.is_known()
                && !masses.is_two_masses()
        });
        let mode = self.designed_resonance().map(|resonance| resonance.mode);
        let is_low = mode.is_none_or(|mode| mode.frequency < Self::LOW);
        let time = self.settings.sample_time;
        let part = self.window_part();
        let search = match masses {
            _ if is_open => LineSearch::first_pass(time, Self::FASTER),
            _ if is_between => LineSearch::between(time, part, 0.0),
            Some(masses) if is_low && (masses.is_explained() || rounds > 1) => {
                LineSearch::low(time)
            }
            _ => LineSearch::first_pass(time, part),
        };
        self.work = Work::Plan(Planning {
            search,
            planner: None,
            // For an unexplained servo, friction and gain are estimated before the lines.
            is_uncertain: (!is_sure || self.evidence.forces != AxisForces::default())
                && (masses.is_none() || is_open),
            motions: if rounds == 0 {
                Self::FIRST_ROUND
            } else {
                Self::ROUND
            },
            tuned: None,
        });
    }

    /// Measures the frequency response a last time, with lines between the others. The reason is a resonance that these
    /// show in part and that prevents gains at this bandwidth (rad/s). The result of the search counts if there is no room
    /// for it.
    #[inline(never)]
    pub(super) fn look_closer(&mut self, bandwidth: f64, tuned: Tuned) {
        let lowest = Self::ABOVE * bandwidth;
        self.work = Work::Plan(Planning {
            search: LineSearch::between(self.settings.sample_time, self.window_part(), lowest),
            planner: None,
            is_uncertain: false,
            motions: Self::ROUND,
            tuned: Some(tuned),
        });
    }

    /// Plans frequency-response motions. Without room the order continues with its next step.
    #[inline(never)]
    pub(super) fn plan(&mut self) -> Option<DecisionKind<N>> {
        let Work::Plan(planning) = &mut self.work else {
            return None;
        };
        if let Some((lines, planner)) = &mut planning.planner {
            let plan = planner.work()?.with_motions(planning.motions);
            self.response.begin(lines, planning.tuned.is_some());
            self.evidence.rounds = match planning.tuned {
                Some(_) => Evidence::MAX_ROUNDS,
                None => self.evidence.rounds + 1,
            };
            self.work = Work::Nothing;
            return Some(DecisionKind::ResponseMotion(plan));
        }
        let lines = planning.search.work()?;
        let (is_uncertain, tuned) = (planning.is_uncertain, planning.tuned);
        let mode = self.designed_resonance().map(|resonance| resonance.mode);
        let planner = self.evidence.servo().and_then(|servo| {
            let (settings, forces) = (&self.settings, &self.evidence.forces);
            ResponsePlanner::new(
                settings,
                &servo,
                forces,
                is_uncertain,
                mode.as_ref(),
                &lines,
            )
        });
        match (planner, &mut self.work) {
            (Some(planner), Work::Plan(planning)) => {
                planning.planner = Some((lines, planner));
                None
            }
            _ => self.go_on_without(tuned),
        }
    }

    fn go_on_without(&mut self, tuned: Option<Tuned>) -> Option<DecisionKind<N>> {
        if let Some((tuned, fitted)) = tuned {
            return self.settle(tuned, fitted);
        }
        if self.evidence.rounds == 0 {
            self.evidence.lacks_room = true;
        }
        self.evidence.rounds = Evidence::MAX_ROUNDS;
        self.work = Work::Decide;
        None
    }

    /// Begins to fit masses to the response. With too few lines the order continues with its next step.
    #[inline(never)]
    pub(super) fn respond(&mut self) {
        self.work = Work::Decide;
        let is_uncertain = self.evidence.unexplained_reason.is_some();
        if self.response.has_lines()
            && let Some(servo) = self.evidence.servo()
            && let Some(fit) = self.response.fit(&servo, is_uncertain)
        {
            self.work = Work::Masses(fit);
        }
    }

    /// Takes in the masses that the response shows. The last motions may have shown less than those before.
    #[inline(never)]
    pub(super) fn take_masses(&mut self, shown: ResponseEstimate) {
        self.evidence.take_masses(shown);
        let servo = self.evidence.servo();
        let balance = servo.and_then(|servo| self.response.friction(&servo.parameters));
        self.evidence.balance = balance.or(self.evidence.balance);
        self.work = Work::Decide;
    }
}
