use super::RoughModel;
use super::acting_share::ActingShare;
use super::holding::Holding;
use super::least_motion::LeastMotion;
use super::noise::EDGE_COUNTS;
use crate::watch::LOW_SPEED;
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::{StepMeasure, Tuning};
use identifier_core::units::Units;

/// A step and the step back under new gains, measured against their prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trial<N> {
    servo: RoughModel<N>,
    /// Twice its friction, or as much as it may have, counts per sample².
    twice_friction: N,
    /// Samples from a command to its effect.
    delay: u32,
    /// Where the step begins, counts from where the commissioning began, and how far beside it may. The step, with its
    /// sign.
    start: N,
    beside: N,
    step: N,
    /// True if the axis may go back.
    returns: bool,
    /// The command that balances the load. The others are the distances from it at which friction, and the higher
    /// friction at rest, may hold the servo.
    balance: N,
    friction: [N; 2],
    predicted: Predicted<N>,
    stage: TrialStage,
    /// Samples since the stage began, and those that were left for all stages then.
    passed: u32,
    left: u32,
    /// Where the step began, and its direction.
    from: N,
    direction: N,
    /// The step, and the one back.
    steps: [TriedStep<N>; 2],
}

/// A step under way or over.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TriedStep<N> {
    measure: StepMeasure<N>,
    share: ActingShare<N>,
    /// None once it moves.
    least: Option<LeastMotion<N>>,
}

/// The predicted response, in samples and counts, tolerances included.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Predicted<N> {
    rise: [N; 2],
    /// The farthest from where the step began, counts.
    highest: N,
    /// Samples after which a transient is over, and the same for a servo that was held by friction. The last is the
    /// limit by which it must be at rest.
    over: u32,
    departed: u32,
    most: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TrialStage {
    Settling,
    Stepping,
    /// The step back. An axis at rest shows no fault. This step shows those that came since the first.
    Returning,
    /// All was as predicted. It must stay at rest for as long as a transient takes: backlash may oscillate later.
    Kept,
}

/// Measurements of a trial, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TrialResult {
    /// The step of the reference, rad.
    pub step: f64,
    /// From 10 to 90 % of the step, s; none if it did not get there.
    pub rise_time: Option<f64>,
    /// Beyond the step or the one back, the larger, a part of it.
    pub overshoot: f64,
}

impl<N: Number> Trial<N> {
    /// The part by which the rise time may differ from the prediction. A loop that is slower alone keeps its margins: friction,
    /// or a load on a spring, delays its rise.
    pub(super) const RISE: f64 = 0.15;
    const SLOWER: f64 = 3.0;

    /// Tolerance of the overshoot, as a part of the step.
    pub(super) const OVERSHOOT: f64 = 0.03;

    /// Friction at rest over Coulomb friction that no axis has. A larger command moves it, or nothing does.
    const STICTION: f64 = 5.0;

    /// Settling times after which a transient is over, and by which the servo must be at rest.
    const TRANSIENT_SETTLING_TIMES: f64 = 1.5;
    const MAX_SETTLING_TIMES: f64 = 6.0;

    /// The longest time in which a transient decays, 1/ω. It is that of the filter of the reference, to a fiftieth.
    const DIES_DOWN: f64 = 12.0;

    /// Additional time to wait for the slowest predictions, and the longest that all may take, s.
    const BESIDES: f64 = 0.5;
    const PATIENCE: f64 = 30.0;

    /// The trial of a step under gains for a servo: where it begins, rad from where the commissioning began, how far beside
    /// it may, and its size with its sign. On an axis that `returns` it includes the step back.
    pub(super) fn new(
        tuning: &Tuning,
        units: &Units,
        [start, beside, step]: [f64; 3],
        servo: &IdentifiedServo,
        returns: bool,
    ) -> Self {
        // As large as it may be: it is not the actuator that holds the servo then.
        let (coulomb, delay) = (servo.most_coulomb(), servo.delay);
        let servo = &servo.parameters;
        let b = servo.b;
        let predicted_response = &tuning.predicted_response;
        let counts = step * units.position();
        let samples = |time: f64| time / units.sample_time();
        let rise = samples(predicted_response.rise_time);
        let quickest = samples(predicted_response.quickest_rise_time);
        // Each of the two crossings is uncertain by a count at the speed of the rise, and by a sample's
        // part.
        let per_count = 2.0 * rise / (0.8 * libm::fabs(counts)) + 1.0;
        // A floor is half a count low on the average, at both ends.
        let rounding = 0.5 / libm::fabs(counts).max(1.0);
        let highest = 1.0 + predicted_response.overshoot + Self::OVERSHOOT + rounding;
        let settling = samples(Self::settling(tuning));
        let most = Self::MAX_SETTLING_TIMES * settling + samples(Self::BESIDES);
        Self {
            servo: RoughModel::from_si(servo, units.sample_time(), units.position_unit()),
            twice_friction: N::from_f64(
                coulomb.max(servo.coulomb + servo.coulomb)
                    * units.sample_time()
                    * units.sample_time()
                    * units.position(),
            ),
            delay: libm::ceil(samples(delay)) as u32,
            start: N::from_f64(start * units.position()),
            beside: N::from_f64(beside * units.position()),
            step: N::from_f64(counts),
            returns,
            balance: N::from_f64(-servo.load / b),
            friction: [LOW_SPEED, Self::STICTION].map(|of| N::from_f64(of * coulomb / b)),
            predicted: Predicted {
                rise: [
                    (1.0 - Self::RISE) * quickest - per_count,
                    (1.0 + Self::RISE) * rise + per_count,
                ]
                .map(N::from_f64),
                highest: N::from_f64(highest * libm::fabs(counts)),
                // Casts saturate.
                over: (Self::TRANSIENT_SETTLING_TIMES * settling) as u32,
                departed: (Self::TRANSIENT_SETTLING_TIMES
                    * samples(predicted_response.settling_time)) as u32,
                most: most as u32,
            },
            stage: TrialStage::Settling,
            passed: 0,
            // Casts saturate.
            left: samples(Self::PATIENCE) as u32,
            from: N::ZERO,
            direction: if counts < 0.0 { -N::ONE } else { N::ONE },
            steps: [TriedStep {
                measure: StepMeasure::new(libm::fabs(counts), 1.0),
                share: ActingShare::new(N::from_f64(libm::fabs(counts))),
                least: Some(LeastMotion::default()),
            }; 2],
        }
    }

    /// Where the step begins, counts from where the commissioning began.
    pub(super) fn start(&self) -> N {
        self.start
    }

    /// True if friction holds the servo so far from there that the overshoot may leave the travel.
    pub(super) fn is_away(&self, position: N) -> bool {
        (position - self.start).magnitude() > self.beside
    }

    /// The time after which a transient of the servo is over, s.
    pub(super) fn settling(tuning: &Tuning) -> f64 {
        // Friction may hold a servo outside of the band for long.
        let dies_down = Self::DIES_DOWN / tuning.bandwidth;
        tuning.predicted_response.settling_time.min(dies_down)
    }

    /// Takes in the position of a sample (counts) and the command that acts from then on. It starts the next part when
    /// one is over. True once all was done and kept.
    ///
    /// # Errors
    /// The figure that does not match the prediction, or the fault that the mismatch shows.
    pub(super) fn process(
        &mut self,
        holding: &mut Holding<N>,
        position: N,
        command: N,
    ) -> Result<bool, Reason> {
        self.proceed(holding, position, command).map_err(|missed| {
            if self.is_weak() {
                Reason::ActuatorWeak
            } else {
                missed
            }
        })
    }

    fn is_weak(&self) -> bool {
        let is_weak = |step: &TriedStep<N>| step.share.is_weak(&self.servo);
        self.steps.iter().any(is_weak)
    }

    fn proceed(
        &mut self,
        holding: &mut Holding<N>,
        position: N,
        command: N,
    ) -> Result<bool, Reason> {
        self.passed = self.passed.saturating_add(1);
        let settled = self.passed >= self.predicted.over && holding.is_at_rest();
        if !settled && self.passed > self.predicted.most.min(self.left) {
            return Err(Reason::NeverAtRest);
        }
        match self.stage {
            TrialStage::Kept => return Ok(settled),
            TrialStage::Settling => {
                if settled {
                    self.begin_step(TrialStage::Stepping, holding, position);
                }
            }
            TrialStage::Stepping | TrialStage::Returning => {
                let (motion_direction, highest) = (self.motion_direction(), self.predicted.highest);
                let gone = motion_direction * (position - self.from);
                let beyond_load = motion_direction * (command - self.balance);
                let acceleration = self.servo.gain * beyond_load;
                let (friction, delay) = (self.twice_friction, self.delay);
                let step = self.step_under_way();
                step.measure.take(gone);
                step.share.take(gone, beyond_load);
                if gone.magnitude() > N::from_f64(EDGE_COUNTS) {
                    step.least = None;
                }
                if let Some(least) = &mut step.least {
                    least.take(acceleration, friction);
                    if least.is_due(delay) {
                        return Err(Reason::ActuatorDead);
                    }
                }
                if step.measure.is_beyond(highest) {
                    return Err(Reason::PredictionMissed);
                }
                // At standstill its integral grows to the command at which the servo breaks away.
                let [departed, _] = step.measure.since();
                let waits = departed.is_none() && self.passed < self.predicted.departed;
                if settled && !waits {
                    self.judge_rise(holding.resting().command)?;
                    if self.returns && self.stage == TrialStage::Stepping {
                        self.begin_step(TrialStage::Returning, holding, position);
                    } else {
                        self.begin(TrialStage::Kept);
                    }
                }
            }
        }
        Ok(false)
    }

    fn begin(&mut self, stage: TrialStage) {
        self.left = self.left.saturating_sub(self.passed);
        self.stage = stage;
        self.passed = 0;
    }

    /// Begins a stage with a step. Its prediction is for a servo at standstill. The error and the integral that
    /// friction has left are chance.
    fn begin_step(&mut self, stage: TrialStage, holding: &mut Holding<N>, position: N) {
        self.from = position;
        self.begin(stage);
        self.step_under_way().measure.take(N::ZERO);
        // A load that came since the servo was studied.
        let ([friction, _], resting) = (self.friction, holding.resting().command);
        self.balance = (self.balance).limited(resting - friction, resting + friction);
        holding.stay(position, self.balance);
        holding.step_to(position + self.motion_direction() * self.step.magnitude());
    }

    fn step_under_way(&mut self) -> &mut TriedStep<N> {
        let [out, back] = &mut self.steps;
        match self.stage {
            TrialStage::Returning => back,
            _ => out,
        }
    }

    /// The direction of the step under way.
    fn motion_direction(&self) -> N {
        if self.stage == TrialStage::Returning {
            -self.direction
        } else {
            self.direction
        }
    }

    /// True if a servo that is identified must have moved, and did not.
    pub(super) fn is_motion_missed(&self) -> bool {
        let missed = |step: &TriedStep<N>| step.least.is_some_and(|least| least.is_due(self.delay));
        self.steps.iter().any(missed)
    }

    /// True if friction that is higher at rest may hold the servo under this command.
    pub(super) fn may_hold_still_under(&self, command: N) -> bool {
        let [_, friction] = self.friction;
        (command - self.balance).magnitude() <= friction
    }

    /// Judges the rise of a servo that is at rest under this command, on the average.
    fn judge_rise(&mut self, command: N) -> Result<(), Reason> {
        let [least, most] = self.predicted.rise;
        let measure = self.step_under_way().measure;
        let [departed, _] = measure.since();
        match measure.rise() {
            Some(rise) if rise >= least && rise <= most => Ok(()),
            // A weak actuator is slower as well.
            Some(rise)
                if rise > most && rise <= N::from_f64(Self::SLOWER) * most && !self.is_weak() =>
            {
                Ok(())
            }
            None if departed.is_none() && self.may_hold_still_under(command) => {
                Err(Reason::DoesNotMove)
            }
            None if departed.is_none() => Err(Reason::ActuatorDead),
            _ => Err(Reason::PredictionMissed),
        }
    }

    /// The measurements so far.
    pub(super) fn result(&self, units: &Units) -> TrialResult {
        let [out, back] = self.steps.map(|step| step.measure);
        TrialResult {
            step: self.step.to_f64() * units.position_unit(),
            rise_time: out.rise().map(|rise| rise.to_f64() * units.sample_time()),
            overshoot: out.overshoot().max(back.overshoot()),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::commission::HoldingGains;
    use identifier_core::control::ControlSample;
    use identifier_core::parameters::ServoParameters;
    use identifier_core::settings::ControllerSettings;
    use identifier_core::tuning::PredictedResponse;

    const STEP: f64 = 0.05;
    const TIME_CONSTANT: f64 = 0.02;
    const B: f64 = 200.0;
    /// Rad per rad/s².
    const COMPLIANCE: f64 = 1e-4;

    /// The predicted response of a first-order system: a rise of τ ln 9, no overshoot.
    pub(in crate::commission) fn predicted() -> Tuning {
        Tuning {
            kp: 1.0,
            kd: 0.01,
            ki: 1.0,
            cutoff: 500.0,
            reference_filter: 0.0,
            notch: 0.0,
            feed_forward: None,
            bandwidth: 1.0 / TIME_CONSTANT,
            cap: None,
            predicted_response: PredictedResponse {
                step: STEP,
                rise_time: TIME_CONSTANT * libm::log(9.0),
                quickest_rise_time: TIME_CONSTANT * libm::log(9.0),
                slowest_rise_time: TIME_CONSTANT * libm::log(9.0),
                overshoot: 0.0,
                settling_time: TIME_CONSTANT * libm::log(50.0),
                sensitivity: 1.2,
                gain_margins: [0.1, 8.0],
                command_share: 0.3,
                noise: 0.0,
                compliance: COMPLIANCE,
            },
        }
    }

    /// A moment of a trial.
    #[derive(Clone, Copy)]
    struct Moment {
        stage: TrialStage,
        /// Since the stage began, s.
        time: f64,
        /// Where the last step began and ends, rad.
        from: f64,
        to: f64,
    }

    impl Moment {
        /// A step of first order.
        fn step(&self, time_constant: f64) -> f64 {
            let time = match self.stage {
                TrialStage::Settling => return 0.0,
                TrialStage::Stepping | TrialStage::Returning => self.time,
                TrialStage::Kept => 1.0,
            };
            self.from - (self.to - self.from) * libm::expm1(-time / time_constant)
        }
    }

    /// A trial of a servo that is where `position` says, rad.
    fn tried(step: f64, position: impl Fn(Moment) -> f64) -> (Result<bool, Reason>, TrialResult) {
        tried_with(step, [0.0; 2], position)
    }

    /// The same of one with friction and its standard error, rad/s².
    fn tried_with(
        step: f64,
        coulomb: [f64; 2],
        position: impl Fn(Moment) -> f64,
    ) -> (Result<bool, Reason>, TrialResult) {
        tried_by(&predicted(), step, coulomb, position)
    }

    /// The same by another prediction.
    fn tried_by(
        tuning: &Tuning,
        step: f64,
        [coulomb, error]: [f64; 2],
        position: impl Fn(Moment) -> f64,
    ) -> (Result<bool, Reason>, TrialResult) {
        let units = Units::new(1e-3, core::f64::consts::TAU / 20_000.0).expect("valid");
        let gains = HoldingGains {
            controller: ControllerSettings::pid(1.0, 0.01, 1.0).limited(10.0),
            cutoff: 500.0,
        };
        let controller = gains.build::<f64>(&units).expect("valid");
        let limit = [-10.0, 10.0];
        let at_rest = ControlSample {
            error: 0.0,
            increment: 0.0,
            velocity: 0.0,
            command: 0.0,
        };
        let mut holding = Holding::take_over(controller, limit, 0.0, &at_rest, 1.0, 60);
        let mut servo = IdentifiedServo::known(ServoParameters::new(0.0, B, coulomb, 0.0), 1e-3);
        super::super::corrected::set_one_known(&mut servo, IdentifiedServo::COULOMB, error);
        let mut trial = Trial::<f64>::new(tuning, &units, [0.0, 0.0, step], &servo, true);
        let [mut from, mut to] = [0.0; 2];
        for _ in 0..100_000 {
            let reference = holding.reference() * units.position_unit();
            if (reference - to).abs() > 0.5 * STEP {
                (from, to) = (to, reference);
            }
            let at = position(Moment {
                stage: trial.stage,
                time: f64::from(trial.passed) * 1e-3,
                from,
                to,
            });
            let count = libm::floor(at * units.position());
            let command = holding.process(count, 0.0).expect("no reach");
            let done = trial.process(&mut holding, count, command);
            if done != Ok(false) {
                return (done, trial.result(&units));
            }
        }
        panic!("it neither ends nor fails");
    }

    /// A step of first order.
    fn first_order(time_constant: f64) -> impl Fn(Moment) -> f64 {
        move |at| at.step(time_constant)
    }

    #[test]
    fn a_step_of_first_order_rises_in_ln_nine_time_constants_either_way() {
        for step in [STEP, -STEP] {
            let (done, measured) = tried(step, first_order(TIME_CONSTANT));
            assert_eq!(done, Ok(true));
            let rise = measured.rise_time.expect("it got there");
            let exact = TIME_CONSTANT * libm::log(9.0);
            // A count at the speed at which nine tenths are passed.
            let uncertain = core::f64::consts::TAU / 20_000.0 / (0.1 * STEP / TIME_CONSTANT);
            assert!((rise - exact).abs() < uncertain, "{rise} {exact}");
            assert!(measured.overshoot < 0.01);
        }
    }

    #[test]
    fn a_faster_rise_than_predicted_is_refused_out_and_back_and_a_slower_one_up_to_three_times() {
        for (factor, expected) in [
            (0.75, Err(Reason::PredictionMissed)),
            (1.3, Ok(true)),
            (3.0, Ok(true)),
            (3.7, Err(Reason::PredictionMissed)),
        ] {
            for only in [TrialStage::Stepping, TrialStage::Returning] {
                let (done, _) = tried(STEP, |at| {
                    let factor = if at.stage == only { factor } else { 1.0 };
                    at.step(factor * TIME_CONSTANT)
                });
                assert_eq!(done, expected, "{factor} {only:?}");
            }
        }
    }

    #[test]
    fn overshoot_and_unrest_are_refused() {
        let plain = first_order(TIME_CONSTANT);
        let (overshoots, _) = tried(STEP, |at| {
            plain(at) * (1.0 + 6.0 * at.time * libm::exp(-at.time / 0.05))
        });
        assert_eq!(overshoots, Err(Reason::PredictionMissed));
        let (never_rests, _) = tried(STEP, |at| plain(at) + 0.001 * libm::sin(at.time / 0.01));
        assert_eq!(never_rests, Err(Reason::NeverAtRest));
    }

    #[test]
    fn a_step_that_friction_holds_for_as_long_as_predicted_is_waited_for() {
        let mut tuning = predicted();
        tuning.predicted_response.settling_time = 0.5;
        for (departs, expected) in [(0.7, Ok(true)), (1.0, Err(Reason::DoesNotMove))] {
            let (done, _) = tried_by(&tuning, STEP, [90.0, 0.0], |at| match at.stage {
                TrialStage::Stepping | TrialStage::Returning => {
                    let time = (at.time - departs).max(0.0);
                    Moment { time, ..at }.step(TIME_CONSTANT)
                }
                _ => at.step(TIME_CONSTANT),
            });
            assert_eq!(done, expected, "{departs}");
        }
    }

    #[test]
    fn an_encoder_that_sticks_after_the_step_is_found_by_the_step_back() {
        // The command of the step is 0.25 of the gain and more, which a third of friction at rest may hold.
        for (coulomb, expected) in [
            ([0.0, 0.0], Reason::ActuatorDead),
            ([90.0, 0.0], Reason::DoesNotMove),
            // Friction that is not known.
            ([0.0, 30.0], Reason::DoesNotMove),
        ] {
            let (done, _) = tried_with(STEP, coulomb, |at| match at.stage {
                TrialStage::Returning => at.from,
                _ => at.step(TIME_CONSTANT),
            });
            assert_eq!(done, Err(expected), "{coulomb:?}");
        }
    }
}
