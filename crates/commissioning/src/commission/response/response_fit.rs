use super::super::corrected::{scale, scale_errors, set_one_known};
use super::model::{DAMPING, DELAY, FREQUENCY, FRICTION, GAIN, LAG, UNKNOWNS, Unknowns, mode};
use super::pass::ResponsePass;
use super::scan::{Scan, Starts, delay_and_lag};
use identifier_core::fit::{Descent, DescentSettings, DescentStep, Explanation};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::tuning::{MeasuredLine, Resonance};

/// A fit of one mass and of two to measured lines, in slices of one response of one model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::commission) struct ResponseFit {
    sample_time: f64,
    /// Viscous friction with its deviation, 1/s, zero if it is declared. Also the delay (samples) from the earlier
    /// motions.
    friction: [f64; 2],
    delay: f64,
    stage: Stage,
    one_mass: Option<Best>,
    two_masses: Option<Best>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    OneMass(ResponseDescent),
    Scan(Scan),
    TwoMasses(ResponseDescent, Starts),
}

/// A descent from a start.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ResponseDescent {
    pass: ResponsePass,
    descent: Descent<f64, UNKNOWNS>,
    /// The step to the next pass, while it is found.
    step: Option<DescentStep<f64, UNKNOWNS>>,
}

/// The unknowns that explain the lines best.
type Best = Explanation<f64, UNKNOWNS>;

/// The masses that a measured response shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::commission) struct ResponseEstimate {
    /// Gain b, rad/s² per command unit, with the standard error of ln b.
    pub(in crate::commission) gain: f64,
    pub(in crate::commission) gain_error: f64,
    /// Viscous friction a with its standard error, 1/s, zero if it was known before.
    pub(in crate::commission) friction: [f64; 2],
    /// Delay and lag together with their standard error, s.
    pub(in crate::commission) delay: [f64; 2],
    /// The resonance, if two masses explain the response and one does not.
    pub(in crate::commission) resonance: Option<Resonance>,
    /// Mean of the squared errors in deviations: about one where the model is right.
    pub(in crate::commission) misfit: f64,
    /// The part of the squared errors of one mass that it leaves.
    pub(in crate::commission) left: f64,
}

impl ResponseEstimate {
    /// The largest standard error of ln b of a response. If it is larger, the lines do not reach below the
    /// antiresonance, where both masses move together.
    pub(in crate::commission) const KNOWN_GAIN: f64 = 0.05;

    /// The least gain of a motor alone over that of both masses.
    const MOTOR_ALONE: f64 = 1.6;

    /// True if the lines show the gain of both masses together, and with it the share of each.
    pub(in crate::commission) fn is_known(&self) -> bool {
        self.gain_error <= Self::KNOWN_GAIN
    }

    /// True if the masses explain the response: all of it, or nearly all that one mass leaves. Lines close to a
    /// resonance of little damping are not explained in full. The slightest change of speed shifts them.
    pub(in crate::commission) fn is_explained(&self) -> bool {
        self.misfit < ResponseFit::EXPLAINED || self.left < ResponseFit::NEARLY_ALL
    }

    /// Updates a servo that was identified as one mass from its response. This is gain, delay and, if it was uncertain,
    /// viscous friction. The commands that balance friction and load are kept.
    pub(in crate::commission) fn improve(&self, servo: &mut IdentifiedServo) {
        scale(servo, self.gain / servo.parameters.b);
        set_one_known(servo, IdentifiedServo::B, self.gain_error * self.gain);
        let [a, of_a] = self.friction;
        if of_a > 0.0 {
            servo.parameters.a = a;
            set_one_known(servo, IdentifiedServo::A, of_a);
        }
        let [delay, of_delay] = self.delay;
        servo.delay = delay;
        set_one_known(servo, IdentifiedServo::DELAY, of_delay);
    }

    /// Takes the gain into a servo that was identified as one mass: the mean of both by their variances.
    pub(in crate::commission) fn combine(&self, servo: &mut IdentifiedServo) {
        let b = servo.parameters.b;
        let error = servo.standard_error(IdentifiedServo::B) / b;
        let [of_motions, of_lines] = [error, self.gain_error].map(|error| error * error);
        let all = of_motions + of_lines;
        if all > 0.0 {
            scale(servo, libm::pow(self.gain / b, of_motions / all));
            let left = libm::sqrt(of_lines / all);
            scale_errors(servo, IdentifiedServo::B, left);
        }
    }

    /// True if a second mass explains a part of the errors of one mass alone, as it may of noise.
    pub(in crate::commission) fn may_be_noise(&self) -> bool {
        self.resonance.is_some() && self.left >= ResponseFit::NEARLY_ALL
    }

    /// True if a second mass explains nearly all that one leaves.
    pub(in crate::commission) fn is_two_masses(&self) -> bool {
        self.resonance.is_some() && self.left < ResponseFit::NEARLY_ALL
    }

    /// True if one mass leaves so much of the lines that a narrow resonance may lie between them.
    pub(in crate::commission) fn may_hide_a_resonance(&self) -> bool {
        self.resonance.is_none() && self.misfit > ResponseFit::CLEAR
    }

    /// True if it shows two masses, and their gain better than another estimate: one of less error, or one mass of so much
    /// more gain that it is the motor alone, as lines above the antiresonance show it.
    pub(in crate::commission) fn shows_more_than(&self, other: &Self) -> bool {
        let shows = self.resonance.is_some() && self.is_explained();
        let is_motor = other.resonance.is_none() && other.gain > Self::MOTOR_ALONE * self.gain;
        shows && (self.gain_error < other.gain_error || is_motor)
    }

    /// True if one mass explains the response as well as two do, and friction blurs what is left.
    pub(in crate::commission) fn is_one_mass(&self) -> bool {
        self.resonance.is_none() && self.misfit < ResponseFit::BLURRED
    }
}

impl ResponseFit {
    /// Two masses exist if one does not explain the response and two leave less than this part of its errors. Among 90
    /// rigid servos one mass left 0.56 or less per line and part. For as many of two masses it left 2 or more.
    const TWO_MASSES: f64 = 0.75;

    /// The mean of the squared errors above which a single mass may hide a narrow resonance.
    const CLEAR: f64 = 0.6;

    /// The mean of the squared errors of a fit that explains the response. No other fit would be much better.
    const EXPLAINED: f64 = 1.0;

    /// The same of a fit that leaves what friction blurs, more than the motions of a line differ.
    const BLURRED: f64 = 2.0;
    /// The part of the errors of one mass that two may leave if they are the cause. A load that changes with the angle,
    /// which partly looks like a second mass, leaves more.
    const NEARLY_ALL: f64 = 0.1;

    /// The expected deviation of viscous friction from zero, 1/s, if motions that one mass does not explain show none.
    /// A motor that oscillates against its load looks slowed.
    const USUAL_FRICTION: f64 = 10.0;

    /// The least standard errors of ln ω and ln ζ if two masses do not explain the response either. An example is a
    /// resonance between two lines that nearly stopped the servo. A blur of its lines looks like damping.
    const UNEXPLAINED: [f64; 2] = [0.02, 0.7];

    /// The least standard error of ln ω of a resonance that no line shows. Only the antiresonance is evidence of it.
    const UNSEEN: f64 = 0.1;

    /// Begins for a servo that was identified as one mass, which may not explain its motions. None without enough
    /// lines.
    pub(in crate::commission) fn begin(
        lines: &[MeasuredLine],
        servo: &IdentifiedServo,
        is_uncertain: bool,
        sample_time: f64,
    ) -> Option<Self> {
        /// The fewest lines that distinguish two masses from one.
        const FEWEST: usize = 12;
        let delay = servo.delay / sample_time;
        let friction = if is_uncertain {
            [0.0, Self::USUAL_FRICTION]
        } else {
            [servo.parameters.a, 0.0]
        };
        let [a, _] = friction;
        if lines.len() < FEWEST {
            return None;
        }
        let [late, lag] = delay_and_lag(delay);
        let start = [libm::log(servo.parameters.b), late, lag, a, 0.0, 0.0, 0.0];
        Some(Self {
            sample_time,
            friction,
            delay,
            stage: Stage::OneMass(ResponseDescent::from(&start, friction, false, sample_time)),
            one_mass: None,
            two_masses: None,
        })
    }

    /// A slice; at the end the masses that the response shows.
    pub(in crate::commission) fn work(
        &mut self,
        lines: &[MeasuredLine],
    ) -> Option<ResponseEstimate> {
        match &mut self.stage {
            Stage::OneMass(descent) => {
                if descent.work(lines, self.friction, self.sample_time) {
                    self.one_mass = descent.best();
                    if Self::is_explained(&self.one_mass, lines, Self::CLEAR) {
                        return self.estimate(lines);
                    }
                    let [a, _] = self.friction;
                    self.stage = Stage::Scan(Scan::begin(lines, a, self.delay));
                }
                None
            }
            Stage::Scan(scan) => {
                if let Some(starts) = scan.work(lines, self.sample_time) {
                    return self.next_start(lines, starts);
                }
                None
            }
            Stage::TwoMasses(descent, starts) => {
                if !descent.work(lines, self.friction, self.sample_time) {
                    return None;
                }
                let (found, starts) = (descent.best(), *starts);
                if let Some(found) = found
                    && found.is_better_than(self.two_masses.as_ref())
                {
                    self.two_masses = Some(found);
                }
                if Self::is_explained(&self.two_masses, lines, Self::EXPLAINED) {
                    return self.estimate(lines);
                }
                self.next_start(lines, starts)
            }
        }
    }

    fn is_explained(fit: &Option<Best>, lines: &[MeasuredLine], most: f64) -> bool {
        let most = most * 2.0 * lines.len() as f64;
        fit.is_some_and(|best| best.equations.cost() < most)
    }

    /// True if a line near a resonance exceeds its own error clearly.
    fn is_seen(frequency: f64, lines: &[MeasuredLine]) -> bool {
        /// The distance of such a line, a part of the frequency, and its standard errors.
        const NEAR: f64 = 0.2;
        const CLEAR: f64 = 5.0;
        lines.iter().any(|line| {
            let is_near = (line.frequency - frequency).abs() < NEAR * frequency;
            is_near && line.gain.power() > CLEAR * CLEAR * line.deviation * line.deviation
        })
    }

    fn next_start(
        &mut self,
        lines: &[MeasuredLine],
        mut starts: Starts,
    ) -> Option<ResponseEstimate> {
        let [a, _] = self.friction;
        let Some(start) = starts.next(a, self.delay) else {
            return self.estimate(lines);
        };
        let descent = ResponseDescent::from(&start, self.friction, true, self.sample_time);
        self.stage = Stage::TwoMasses(descent, starts);
        None
    }

    fn estimate(&self, lines: &[MeasuredLine]) -> Option<ResponseEstimate> {
        let one = self.one_mass?;
        let better = self
            .two_masses
            .filter(|two| two.equations.cost() < Self::TWO_MASSES * one.equations.cost());
        let best = better.unwrap_or(one);
        let misfit = best.equations.cost() / (2.0 * lines.len() as f64);
        let covariance = best.equations.covariance();
        let error_of_sum = |places: &[usize]| {
            let entry = |i: &usize, j: &usize| covariance.get(*i).and_then(|row| row.get(*j));
            let row = |i| places.iter().filter_map(move |j| entry(i, j));
            let variance: f64 = places.iter().flat_map(row).sum();
            libm::sqrt((variance * misfit.max(1.0)).max(0.0))
        };
        let error = |place: usize| error_of_sum(&[place]);
        let [least, least_of_damping] = if misfit < Self::EXPLAINED {
            [0.0; 2]
        } else {
            Self::UNEXPLAINED
        };
        let unknowns = &best.unknowns;
        let is_seen = Self::is_seen(mode(unknowns).frequency, lines);
        let least = if is_seen { least } else { Self::UNSEEN };
        Some(ResponseEstimate {
            gain: libm::exp(unknowns[GAIN]),
            gain_error: error(GAIN),
            friction: [unknowns[FRICTION], error(FRICTION)],
            delay: [unknowns[DELAY] + unknowns[LAG], error_of_sum(&[DELAY, LAG])]
                .map(|samples| samples * self.sample_time),
            resonance: better.map(|_| Resonance {
                mode: mode(unknowns),
                errors: [
                    error(FREQUENCY).max(least),
                    error(DAMPING).max(least_of_damping),
                ],
                friction_on_motor: false,
            }),
            misfit,
            left: best.equations.cost() / one.equations.cost(),
        })
    }
}

impl ResponseDescent {
    const SETTINGS: DescentSettings = DescentSettings {
        damping: 1e-2,
        max_passes: 20,
        min_change: 1e-4,
    };

    /// Lowest and highest values: logarithms of b, ω, ζ and β, delay and lag in samples, friction in 1/s.
    const LOW: Unknowns = [-Self::HIGH[GAIN], 0.0, 0.0, 0.0, 0.0, -6.9, -4.0];
    const HIGH: Unknowns = [30.0, 60.0, 30.0, 1e3, 13.0, -0.7, 3.4];

    fn from(start: &Unknowns, friction: [f64; 2], two_masses: bool, sample_time: f64) -> Self {
        Self {
            pass: ResponsePass::at(start, friction, two_masses, sample_time),
            descent: Descent::begin(&Self::SETTINGS),
            step: None,
        }
    }

    fn best(&self) -> Option<Best> {
        self.descent.best().copied()
    }

    /// A slice; true at the end.
    fn work(&mut self, lines: &[MeasuredLine], friction: [f64; 2], sample_time: f64) -> bool {
        if let Some(step) = &mut self.step {
            match self.descent.step_on(step, [&Self::LOW, &Self::HIGH]) {
                Some(None) => return false,
                Some(Some(next)) => self.pass.begin(&next, friction),
                None => return true,
            }
            self.step = None;
            return false;
        }
        if !self.pass.work(lines, sample_time) {
            return false;
        }
        let pass = Best {
            unknowns: self.pass.unknowns,
            equations: self.pass.equations,
            sums: (),
        };
        self.step = self.descent.take(&Self::SETTINGS, pass, self.pass.free);
        self.step.is_none()
    }
}
