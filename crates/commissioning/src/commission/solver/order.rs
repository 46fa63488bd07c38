//! The order of a commissioning: one table of steps, of which the first whose condition holds is done.

use super::super::response::ResponseEstimate;
use super::super::rough_model::Breakaway;
use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::reason::Reason;
use identifier_core::tuning::AxisForces;

/// The next step of a commissioning. The condition of each reads the [`Evidence`] alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// The five numbers are fitted to the record of a motion.
    Fit,
    /// The first frequency-response motions.
    FrequencyResponse,
    /// The five numbers are fitted once more, with a wave of the angle.
    FitWaves,
    /// Frequency-response motions with further lines.
    MoreLines,
    /// The search for gains.
    Gains,
    /// The end, for the [outcome](Evidence::outcome) of the evidence.
    End,
}

impl Step {
    /// In their order.
    const ORDER: [Self; 6] = [
        Self::Fit,
        Self::FrequencyResponse,
        Self::FitWaves,
        Self::MoreLines,
        Self::Gains,
        Self::End,
    ];

    /// The first step whose condition holds.
    pub(super) fn after(evidence: &Evidence) -> Self {
        let mut steps = Self::ORDER.into_iter();
        // It takes a chip long, and several steps ask for it.
        let error = evidence.gain_error();
        let next = steps.find(|step| step.is_due(evidence, error));
        next.unwrap_or(Self::End)
    }

    /// With the standard error of b.
    fn is_due(self, evidence: &Evidence, error: f64) -> bool {
        let has_servo = evidence.fitted.is_some();
        match self {
            Self::Fit => evidence.is_recorded && (evidence.lacks_room || !evidence.is_cut),
            Self::FrequencyResponse => has_servo && !evidence.lacks_room && evidence.rounds == 0,
            Self::FitWaves => evidence.asks_for_waves(),
            Self::MoreLines => {
                let may_measure = has_servo && !evidence.lacks_room;
                may_measure && evidence.agrees() && evidence.asks_for_lines(error)
            }
            Self::Gains => evidence.is_within_tolerance(error),
            Self::End => true,
        }
    }
}

/// The evidence about an axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Evidence {
    /// A motion was recorded and is not fitted yet. It was cut short if it was over before there was enough evidence.
    pub(super) is_recorded: bool,
    pub(super) is_cut: bool,
    /// The motion was fitted with waves.
    pub(super) has_waves: bool,
    /// The servo by its motions.
    pub(super) fitted: Option<IdentifiedServo>,
    /// The forces beside it, as the first motion shows them.
    pub(super) forces: AxisForces,
    /// Where the last motion that the ramp moved broke away.
    pub(super) broke_away: Option<Breakaway<f64>>,
    /// Why one mass does not explain these, if it does not.
    pub(super) unexplained_reason: Option<Reason>,
    /// True if travel, speed, resolution or command leave no room for frequency-response motions.
    pub(super) lacks_room: bool,
    /// Rounds of these so far.
    pub(super) rounds: u8,
    /// Rounds in succession whose lines show about the same gain.
    pub(super) measured: u8,
    /// The masses that they have shown, with Coulomb friction and load beneath the lines, rad/s².
    pub(super) masses: Option<ResponseEstimate>,
    pub(super) balance: Option<[f64; 2]>,
}

impl Evidence {
    /// The most rounds of frequency-response motions.
    pub(super) const MAX_ROUNDS: u8 = 3;

    /// The standard error of b below which no further motions are made, and the largest for which gains are computed,
    /// as parts of b.
    const WELL_KNOWN: f64 = 0.02;
    const KNOWN: f64 = ResponseEstimate::KNOWN_GAIN;

    /// The ratio of the b of two rounds up to which they show the same, and of that of the response to that of the motions
    /// up to which gravity counts. Then the largest of these for which gains are computed: beyond it one of them is that of
    /// the motor only.
    const APART: f64 = 1.25;
    const MOST_APART: f64 = 1.6;

    /// The same up to which motions that nothing explains bear out lines.
    const BORNE_OUT: f64 = 1.1;

    /// Takes in the masses that a round shows. The last may have shown less than those before.
    pub(super) fn take_masses(&mut self, shown: ResponseEstimate) {
        let is_same = |before: &ResponseEstimate| is_within(shown.gain / before.gain, Self::APART);
        self.measured = 1 + self.masses.filter(is_same).map_or(0, |_| self.measured);
        let before = self.masses.filter(|before| before.shows_more_than(&shown));
        self.masses = Some(before.unwrap_or(shown));
    }

    /// The servo by motions and response together.
    pub(super) fn servo(&self) -> Option<IdentifiedServo> {
        let mut servo = self.fitted?;
        let error = servo.standard_error(IdentifiedServo::B) / servo.parameters.b;
        let is_better = |masses: &ResponseEstimate| {
            masses.is_explained()
                || (self.unexplained_reason.is_some() && masses.gain_error < error)
        };
        let Some(masses) = &self.masses.filter(is_better) else {
            return Some(servo);
        };
        if self.unexplained_reason.is_some() || (masses.resonance.is_some() && masses.is_known()) {
            masses.improve(&mut servo);
        } else if masses.is_one_mass() {
            masses.combine(&mut servo);
        }
        if self.unexplained_reason.is_some()
            && let Some([coulomb, load]) = self.balance
        {
            (servo.parameters.coulomb, servo.parameters.load) = (coulomb, load);
        }
        Some(servo)
    }

    /// The standard error of b, a part of it; infinite without a servo.
    fn gain_error(&self) -> f64 {
        self.servo().map_or(f64::INFINITY, |servo| {
            servo.standard_error(IdentifiedServo::B) / servo.parameters.b
        })
    }

    /// The response's b over that of the motions. None if the motions are not explained, or there is no response.
    fn ratio(&self) -> Option<f64> {
        let (servo, masses) = (self.fitted.as_ref()?, self.masses.as_ref()?);
        // Lines of an axis that sticks meanwhile show no gain.
        let is_over = masses.resonance.is_some() || masses.is_one_mass() || self.rounds > 1;
        let is_sure = self.unexplained_reason.is_none() && is_over;
        is_sure.then(|| masses.gain / servo.parameters.b)
    }

    /// True if one mass explains the lines, or nearly does and the motions too.
    pub(super) fn shows_one_mass(&self) -> bool {
        let is_sure = self.unexplained_reason.is_none();
        (self.masses)
            .is_none_or(|masses| masses.is_one_mass() && (is_sure || masses.is_explained()))
    }

    /// True if a resonance may be where no line was measured, or between lines.
    pub(super) fn may_hide_a_resonance(&self) -> bool {
        let is_uncertain = self.unexplained_reason.is_some();
        (self.masses).is_none_or(|masses| is_uncertain && masses.may_hide_a_resonance())
    }

    /// True if neither the servo explains the first motion nor masses the lines.
    fn asks_for_waves(&self) -> bool {
        let is_first = self.rounds > 0 && !self.has_waves;
        let shows_masses = (self.masses).is_some_and(|masses| {
            masses.is_explained() && (masses.is_two_masses() || masses.is_known())
        });
        is_first && self.unexplained_reason.is_some() && !shows_masses
    }

    fn asks_for_lines(&self, gain_error: f64) -> bool {
        let is_uncertain = self.unexplained_reason.is_some();
        // One that sticks or cogs on its way may do so less where it is faster.
        let needs_lines = is_uncertain || self.moves_unevenly();
        let shows_too_little = self.masses.map_or(needs_lines, |masses| {
            !masses.is_explained()
                || (self.measured < 2 && is_uncertain && !self.motions_know_b(&masses))
                || (self.rounds < 2 && !is_uncertain && masses.may_be_noise())
                || gain_error > Self::WELL_KNOWN
        });
        self.rounds < Self::MAX_ROUNDS && shows_too_little
    }

    fn is_within_tolerance(&self, error: f64) -> bool {
        let is_explained = match (self.masses, self.unexplained_reason) {
            // Lines above its antiresonance show the motor alone.
            (masses, Some(_)) => masses.is_some_and(|masses| {
                let is_whole =
                    masses.resonance.is_some() || self.is_borne_out(&masses, Self::MOST_APART);
                self.motions_know_b(&masses) || (self.measured > 1 && is_whole)
            }),
            // A load that friction holds behind a spring looks like gravity.
            (None, None) => self.forces == AxisForces::default(),
            (Some(_), None) => self.agrees() && !self.may_be_a_spring(),
        };
        is_explained && error <= Self::KNOWN
    }

    /// True if the motions alone show b well enough for gains, and these lines about the same.
    fn motions_know_b(&self, masses: &ResponseEstimate) -> bool {
        let is_known = self.fitted.is_some_and(|servo| {
            servo.standard_error(IdentifiedServo::B) <= Self::KNOWN * servo.parameters.b
        });
        is_known && self.is_borne_out(masses, Self::BORNE_OUT)
    }

    /// True if the motions show about the gain of these lines. They moved the whole axis, not a motor alone.
    fn is_borne_out(&self, masses: &ResponseEstimate, most: f64) -> bool {
        let is_near = |b: f64| is_within(masses.gain / b, most);
        (self.fitted).is_some_and(|servo| is_near(servo.parameters.b))
    }

    /// True for an axis that is known to stick or to cog.
    pub(super) fn moves_unevenly(&self) -> bool {
        self.forces.low_speed > 0.0 || self.forces.has_cogging()
    }

    /// True if response and motions show about the same gain.
    fn agrees(&self) -> bool {
        (self.ratio()).is_none_or(|ratio| is_within(ratio, Self::MOST_APART))
    }

    /// True if lines that masses explain, or there are none, show about this b.
    pub(super) fn bears_out(&self, b: f64) -> bool {
        let masses = self.masses.filter(ResponseEstimate::is_explained);
        masses.is_none_or(|masses| is_within(masses.gain / b, Self::MOST_APART))
    }

    /// True if what looks like gravity may be the spring of a load that friction holds in the first motion. In those at
    /// constant speed it moves: they show another gain, or more friction.
    fn may_be_a_spring(&self) -> bool {
        let Some(servo) = self.fitted.filter(|_| self.forces.has_gravity()) else {
            return false;
        };
        let is_near = (self.ratio()).is_some_and(|ratio| is_within(ratio, Self::APART));
        let ServoParameters { coulomb, load, .. } = servo.parameters;
        let more = (self.balance).map_or(f64::INFINITY, |[rubs, bears]| {
            libm::hypot(rubs - coulomb, bears - load)
        });
        // What is known of b is known of gravity.
        let most = (Self::APART - 1.0) * coulomb + Self::WELL_KNOWN * self.forces.wave_amplitude();
        !is_near || more > most
    }

    /// Why there are no gains to look for.
    pub(super) fn outcome(&self) -> Reason {
        let has_resonance = self.masses.is_some_and(|masses| masses.resonance.is_some());
        match self.unexplained_reason {
            Some(_) if has_resonance => Reason::ResonanceOrBacklash,
            Some(_) if self.masses.is_some() => Reason::PartlyExplained,
            Some(reason) => reason,
            None if self.masses.is_none() => Reason::TooLittleEvidence,
            None if self.may_be_a_spring() => Reason::ResonanceOrBacklash,
            None if self.agrees() => Reason::TooLittleEvidence,
            None if self.ratio().is_some_and(|ratio| ratio < 1.0) && !has_resonance => {
                Reason::ActuatorWeak
            }
            None => Reason::ResonanceOrBacklash,
        }
    }
}

/// True if a ratio is at most this much, and so is its reciprocal.
fn is_within(ratio: f64, most: f64) -> bool {
    ratio <= most && ratio * most >= 1.0
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use identifier_core::tuning::{Mode, Resonance};
    use std::vec::Vec;

    /// The text of each step on the page.
    const fn does(step: Step) -> &'static str {
        match step {
            Step::Fit => "the five numbers are fitted",
            Step::FrequencyResponse => "frequency response, 2 motions",
            Step::FitWaves => "the five numbers are fitted with a wave of the angle",
            Step::MoreLines => "frequency response with further lines",
            Step::Gains => "gains, then the trial",
            Step::End => "the end, with a reason",
        }
    }

    /// An axis that the five numbers do not explain, and one mass that its lines show.
    pub(in super::super) fn unexplained() -> Evidence {
        let one_mass = ResponseEstimate {
            gain: 100.0,
            gain_error: 0.01,
            friction: [0.0; 2],
            delay: [0.0; 2],
            resonance: None,
            misfit: 0.5,
            left: 1.0,
        };
        Evidence {
            rounds: 3,
            has_waves: true,
            fitted: Some(IdentifiedServo::known(
                ServoParameters::new(0.0, 100.0, 5.0, 0.0),
                1e-3,
            )),
            unexplained_reason: Some(Reason::PartlyExplained),
            masses: Some(one_mass),
            ..Evidence::default()
        }
    }

    /// Its lines with two masses that leave this part of the errors of one.
    fn two_masses(left: f64) -> Option<ResponseEstimate> {
        let mode = Mode {
            frequency: 300.0,
            damping: 0.01,
            ratio: 0.2,
        };
        let resonance = Some(Resonance {
            mode,
            errors: [0.01, 0.1],
            friction_on_motor: false,
        });
        unexplained().masses.map(|masses| ResponseEstimate {
            resonance,
            left,
            ..masses
        })
    }

    /// The same with this b by the motions, which know it badly.
    fn with_rough(b: f64, evidence: Evidence) -> Evidence {
        let fitted = evidence.fitted.map(|mut servo| {
            servo.parameters.b = b;
            servo.covariance[IdentifiedServo::B][IdentifiedServo::B] = b * b;
            servo
        });
        Evidence { fitted, ..evidence }
    }

    /// Those above its antiresonance show the motor alone.
    #[test]
    fn lines_of_one_mass_that_show_far_more_gain_than_the_motions_are_not_whole() {
        for (b, masses, expected) in [
            (70.0, unexplained().masses, Step::Gains),
            (60.0, unexplained().masses, Step::End),
            (60.0, two_masses(0.3), Step::Gains),
        ] {
            let evidence = Evidence {
                measured: 3,
                masses,
                ..with_rough(b, unexplained())
            };
            assert_eq!(Step::after(&evidence), expected, "{b} {masses:?}");
        }
    }

    /// Those of a dead band show another b at each speed.
    #[test]
    fn rounds_that_contradict_each_other_measure_once() {
        for (gain, measured, expected) in [(90.0, 2, Step::Gains), (70.0, 1, Step::End)] {
            let mut evidence = with_rough(100.0, unexplained());
            evidence.measured = 1;
            let masses = evidence.masses.expect("one mass");
            evidence.take_masses(ResponseEstimate { gain, ..masses });
            assert_eq!(evidence.measured, measured, "{gain}");
            assert_eq!(Step::after(&evidence), expected, "{gain}");
        }
    }

    /// An axis that sticks while they are measured.
    #[test]
    fn lines_that_no_mass_explains_do_not_contradict_the_motions_until_they_are_measured_again() {
        let masses = unexplained().masses.map(|masses| ResponseEstimate {
            gain: 50.0,
            misfit: 2.5,
            ..masses
        });
        for (rounds, expected) in [(1, Step::MoreLines), (2, Step::End)] {
            let evidence = Evidence {
                unexplained_reason: None,
                masses,
                rounds,
                ..unexplained()
            };
            assert_eq!(Step::after(&evidence), expected, "{rounds}");
        }
    }

    /// A narrow resonance between lines shows the motor alone above it.
    #[test]
    fn lines_that_alone_know_b_are_measured_twice() {
        // A round without enough of them measures nothing.
        for (rounds, measured, expected) in [
            (1, 1, Step::MoreLines),
            (2, 2, Step::Gains),
            (2, 1, Step::MoreLines),
            (3, 1, Step::End),
        ] {
            let sure = Evidence {
                rounds,
                measured,
                ..unexplained()
            };
            assert_eq!(Step::after(&sure), Step::Gains);
            // Motions that show another b know it no better, whatever their errors say.
            let fitted = (sure.fitted).map(|mut servo| {
                servo.parameters.b = 130.0;
                servo
            });
            for evidence in [with_rough(70.0, sure), Evidence { fitted, ..sure }] {
                assert_eq!(Step::after(&evidence), expected, "{rounds} {measured}");
            }
        }
    }

    /// Of an axis that the five numbers explain.
    #[test]
    fn a_second_mass_that_may_be_noise_is_looked_for_again() {
        for (rounds, left, expected) in [
            (1, 0.3, Step::MoreLines),
            (2, 0.3, Step::Gains),
            (1, 0.02, Step::Gains),
        ] {
            let masses = two_masses(left);
            let evidence = Evidence {
                unexplained_reason: None,
                rounds,
                masses,
                ..unexplained()
            };
            assert_eq!(Step::after(&evidence), expected, "{rounds} {left}");
        }
    }

    /// It looks like a load that friction holds behind a spring.
    #[test]
    fn a_force_that_the_motion_alone_shows_is_not_enough_for_gains() {
        let explained = Evidence {
            unexplained_reason: None,
            masses: None,
            ..unexplained()
        };
        assert_eq!(Step::after(&explained), Step::Gains);
        assert_eq!(Step::after(&under(1.0, explained)), Step::End);
        let masses = unexplained().masses;
        let balance = Some([5.0, 0.0]);
        let measured = Evidence {
            masses,
            balance,
            ..explained
        };
        assert_eq!(Step::after(&under(1.0, measured)), Step::Gains);
    }

    /// With a wave of so many periods.
    fn under(order: f64, evidence: Evidence) -> Evidence {
        let forces = AxisForces {
            wave: [50.0, 0.0],
            order,
            ..AxisForces::default()
        };
        Evidence { forces, ..evidence }
    }

    /// Friction holds it in the first motion. At constant speed it moves, and rubs.
    #[test]
    fn a_spring_with_a_load_is_not_taken_for_gravity() {
        let measured = |gain: f64, balance| {
            let masses = unexplained()
                .masses
                .map(|masses| ResponseEstimate { gain, ..masses });
            let explained = Evidence {
                unexplained_reason: None,
                masses,
                balance: Some(balance),
                ..unexplained()
            };
            [1.0, 20.0].map(|order| Step::after(&under(order, explained)))
        };
        // A quarter of its friction and a fiftieth of its gravity.
        assert_eq!(measured(110.0, [6.5, 1.5]), [Step::Gains; 2]);
        for (gain, balance) in [
            (75.0, [5.0, 0.0]),
            (100.0, [7.5, 0.0]),
            (100.0, [5.0, -2.5]),
        ] {
            assert_eq!(measured(gain, balance), [Step::End, Step::Gains]);
        }
    }

    #[test]
    fn a_wave_counts_only_where_lines_that_masses_explain_bear_it_out() {
        let before = unexplained();
        for (b, expected) in [(100.0, true), (150.0, true), (180.0, false), (55.0, false)] {
            assert_eq!(before.bears_out(b), expected, "{b}");
        }
        let masses = before.masses.map(|masses| ResponseEstimate {
            misfit: 4.0,
            ..masses
        });
        assert!(Evidence { masses, ..before }.bears_out(180.0));
        let masses = None;
        assert!(Evidence { masses, ..before }.bears_out(180.0));
    }

    /// The first may have been too slow for its detents, or for its friction at rest.
    #[test]
    fn lines_of_an_axis_that_moves_unevenly_are_asked_for_again() {
        let explained = Evidence {
            unexplained_reason: None,
            masses: None,
            rounds: 1,
            ..unexplained()
        };
        let sticks = AxisForces {
            low_speed: 10.0,
            ..AxisForces::default()
        };
        for (axis, expected) in [
            (under(20.0, explained), Step::MoreLines),
            (under(1.0, explained), Step::End),
            (explained, Step::Gains),
            (
                Evidence {
                    forces: sticks,
                    ..explained
                },
                Step::MoreLines,
            ),
        ] {
            assert_eq!(Step::after(&axis), expected, "{axis:?}");
        }
    }

    #[test]
    fn waves_are_looked_for_once_and_only_where_nothing_explains_the_axis() {
        let misfit = |misfit| {
            let mut evidence = unexplained();
            evidence.has_waves = false;
            evidence.masses = evidence
                .masses
                .map(|masses| ResponseEstimate { misfit, ..masses });
            evidence
        };
        assert_eq!(Step::after(&misfit(4.0)), Step::FitWaves);
        for other in [
            misfit(0.5),
            Evidence {
                has_waves: true,
                ..misfit(4.0)
            },
            Evidence {
                unexplained_reason: None,
                ..misfit(4.0)
            },
        ] {
            assert_ne!(Step::after(&other), Step::FitWaves, "{other:?}");
        }
    }

    #[test]
    fn the_page_has_the_steps_in_their_order() {
        let page = include_str!("../../../../../docs/commissioning.md");
        let table = page.split("| row | if | then |").nth(1);
        let rows = table.expect("the table").lines().skip(2);
        let rows: Vec<_> = rows.take_while(|line| line.starts_with('|')).collect();
        assert_eq!(rows.len(), Step::ORDER.len());
        for (row, step) in rows.iter().zip(Step::ORDER) {
            let then = row.split('|').nth(3).expect("three columns").trim();
            assert!(then.starts_with(does(step)), "{step:?}: {then}");
        }
    }
}
