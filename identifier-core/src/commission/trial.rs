use super::Reason;
use super::holding::Holding;
use crate::number::Number;
use crate::parameters::ServoParameters;
use crate::tuning::{StepMeasure, Tuning};
use crate::units::Units;

/// A step and a disturbance under new gains, measured against their prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trial<N> {
    /// The step, counts, with its sign.
    step: N,
    disturbance: N,
    /// The command that balances the load, and the largest that friction may hold on top.
    balance: N,
    friction: N,
    promised: Promised<N>,
    stage: TrialStage,
    /// Samples since the stage began.
    passed: u32,
    /// Where the step or the change of the disturbance began, and the step's direction.
    from: N,
    direction: N,
    measure: StepMeasure<N>,
    /// The farthest that the disturbance moved the servo, and its change alone since that, counts.
    excursion: N,
    moved: N,
}

/// The promise, in samples and counts, tolerances included.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Promised<N> {
    rise: [f64; 2],
    /// The farthest from where the step began, counts.
    highest: N,
    excursion: N,
    /// The least that a disturbance must move it, whatever friction is; zero where friction may hold it.
    least_excursion: N,
    /// Samples after which a transient is over, and by which the servo must be at rest.
    over: u32,
    most: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TrialStage {
    Settling,
    Stepping,
    Disturbed,
    Recovering,
}

/// Measurements of a trial, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TrialResult {
    /// The step of the reference, rad.
    pub step: f64,
    /// From 10 to 90 % of the step, s; none if it did not get there.
    pub rise_time: Option<f64>,
    /// Beyond the step, a part of it.
    pub overshoot: f64,
    /// The command that disturbed the servo, command units.
    pub disturbance: f64,
    /// The farthest that it moved the servo, rad.
    pub excursion: f64,
}

impl<N: Number> Trial<N> {
    /// The part by which the rise time may differ from the promise.
    pub(super) const RISE: f64 = 0.15;

    /// Tolerance of the overshoot, as a part of the step.
    pub(super) const OVERSHOOT: f64 = 0.03;

    /// The factor by which a disturbance may move the servo further than promised.
    const EXCURSION: f64 = 1.5;

    /// The part of the promise, of what friction leaves of the disturbance, by which it must move the servo at least. A stuck
    /// encoder shows none.
    const LEAST_EXCURSION: f64 = 0.25;

    /// Friction at low speed over Coulomb friction, which may act to either side at first.
    const LOW_SPEED: f64 = 1.5;

    /// Friction at rest over Coulomb friction that no axis has: a command that is larger moves it, or nothing does.
    const STICTION: f64 = 5.0;

    /// Counts by which a measured position is uncertain.
    const ROUNDING: f64 = 1.5;

    /// Settling times after which a transient is over, and by which the servo must be at rest.
    const TRANSIENT_SETTLING_TIMES: f64 = 1.5;
    const MAX_SETTLING_TIMES: f64 = 6.0;

    /// The time after which a transient has died down at the latest, 1/ω: that of the filter of the reference, to a
    /// fiftieth.
    const DIES_DOWN: f64 = 12.0;

    /// Time for which the slowest of promises is waited for besides, s.
    const BESIDES: f64 = 0.5;

    /// Of a step (rad, signed) and a disturbance (command units) under gains for a servo.
    pub(super) fn new(
        tuning: &Tuning,
        units: &Units,
        step: f64,
        disturbance: f64,
        servo: &ServoParameters,
    ) -> Self {
        let b = servo.b;
        let promise = &tuning.promise;
        let counts = step * units.position();
        let samples = |time: f64| time / units.sample_time();
        let rise = samples(promise.rise_time);
        let quickest = samples(promise.quickest_rise_time);
        // Each of the two crossings is uncertain by a count at the speed of the rise, and by a sample's
        // part.
        let per_count = 2.0 * rise / (0.8 * libm::fabs(counts)) + 1.0;
        // A floor is half a count low on the average, at both ends.
        let rounding = 0.5 / libm::fabs(counts).max(1.0);
        let highest = 1.0 + promise.overshoot + Self::OVERSHOOT + rounding;
        let moved = promise.compliance * b * libm::fabs(disturbance) * units.position();
        let left = b * libm::fabs(disturbance) - 2.0 * Self::LOW_SPEED * servo.coulomb;
        let least = Self::LEAST_EXCURSION * promise.compliance * left * units.position();
        let settling = samples(Self::settling(tuning));
        let most = Self::MAX_SETTLING_TIMES * settling + samples(Self::BESIDES);
        Self {
            step: N::from_f64(counts),
            disturbance: N::from_f64(disturbance),
            balance: N::from_f64(-servo.load / b),
            friction: N::from_f64(Self::STICTION * servo.coulomb / b),
            promised: Promised {
                rise: [
                    (1.0 - Self::RISE) * quickest - per_count,
                    (1.0 + Self::RISE) * rise + per_count,
                ],
                highest: N::from_f64(highest * libm::fabs(counts)),
                excursion: N::from_f64(Self::EXCURSION * moved + 2.0 * Self::ROUNDING),
                least_excursion: N::from_f64((least - 2.0 * Self::ROUNDING).max(0.0)),
                // Casts saturate.
                over: (Self::TRANSIENT_SETTLING_TIMES * settling) as u32,
                most: most as u32,
            },
            stage: TrialStage::Settling,
            passed: 0,
            from: N::ZERO,
            direction: if counts < 0.0 { -N::ONE } else { N::ONE },
            measure: StepMeasure::new(libm::fabs(counts), 1.0),
            excursion: N::ZERO,
            moved: N::ZERO,
        }
    }

    /// The time after which a transient of the servo is over, s.
    pub(super) fn settling(tuning: &Tuning) -> f64 {
        // Friction may hold a servo outside of the band for long.
        let dies_down = Self::DIES_DOWN / tuning.bandwidth;
        tuning.promise.settling_time.min(dies_down)
    }

    /// Takes in the position of a sample (counts), and starts the next part when one is over. True once all
    /// was done and kept.
    ///
    /// # Errors
    /// The promise that was not kept.
    pub(super) fn process(
        &mut self,
        holding: &mut Holding<N>,
        position: N,
    ) -> Result<bool, Reason> {
        self.passed = self.passed.saturating_add(1);
        let settled = self.passed >= self.promised.over && holding.is_at_rest();
        if !settled && self.passed > self.promised.most {
            return Err(Reason::NeverAtRest);
        }
        match self.stage {
            TrialStage::Settling => {
                if settled {
                    self.from = position;
                    // The promise is for a step from where the servo stands: the error and the integral that friction
                    // has left are chance.
                    holding.stay(position, self.balance);
                    self.measure.take(N::ZERO);
                    holding.step_to(self.from + self.step);
                    self.begin(TrialStage::Stepping);
                }
            }
            TrialStage::Stepping => {
                self.measure.take(self.direction * (position - self.from));
                if self.measure.is_beyond(self.promised.highest) {
                    return Err(Reason::OvershootExceeded);
                }
                if settled {
                    let pushed = holding.resting().command - self.balance;
                    self.judge_rise(self.direction * pushed)?;
                    holding.disturb(self.disturbance);
                    self.begin_change(TrialStage::Disturbed, position);
                }
            }
            TrialStage::Disturbed | TrialStage::Recovering => {
                let away = (position - holding.reference()).magnitude();
                if away > self.excursion {
                    self.excursion = away;
                }
                if self.excursion > self.promised.excursion {
                    return Err(Reason::DisturbanceExceeded);
                }
                let moved = (position - self.from).magnitude();
                if moved > self.moved {
                    self.moved = moved;
                }
                if settled {
                    if self.moved < self.promised.least_excursion {
                        return Err(Reason::ActuatorDead);
                    }
                    if self.stage == TrialStage::Recovering {
                        return Ok(true);
                    }
                    holding.disturb(N::ZERO);
                    self.begin_change(TrialStage::Recovering, position);
                }
            }
        }
        Ok(false)
    }

    fn begin(&mut self, stage: TrialStage) {
        self.stage = stage;
        self.passed = 0;
    }

    /// Begins a stage with a change of the disturbance, of a servo that stands here.
    fn begin_change(&mut self, stage: TrialStage, position: N) {
        (self.from, self.moved) = (position, N::ZERO);
        self.begin(stage);
    }

    /// Judges the rise of a servo that was pushed by this command beyond its load, on the average.
    fn judge_rise(&self, pushed: N) -> Result<(), Reason> {
        let [least, most] = self.promised.rise;
        let [departed, _] = self.measure.since();
        match self.measure.rise() {
            Some(rise) if rise >= least && rise <= most => Ok(()),
            None if departed.is_none() && pushed > self.friction => Err(Reason::ActuatorDead),
            _ => Err(Reason::ResponseTimeMissed),
        }
    }

    /// The measurements so far.
    pub(super) fn result(&self, units: &Units) -> TrialResult {
        TrialResult {
            step: self.step.to_f64() * units.position_unit(),
            rise_time: self.measure.rise().map(|rise| rise * units.sample_time()),
            overshoot: self.measure.overshoot(),
            disturbance: self.disturbance.to_f64(),
            excursion: self.excursion.to_f64() * units.position_unit(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commission::HoldingGains;
    use crate::control::ControlSample;
    use crate::settings::ControllerSettings;
    use crate::tuning::Promise;

    const STEP: f64 = 0.05;
    const TIME_CONSTANT: f64 = 0.02;
    const B: f64 = 200.0;
    /// Rad per rad/s².
    const COMPLIANCE: f64 = 1e-4;

    /// The promise of a first-order system: a rise of τ ln 9, no overshoot.
    fn promised() -> Tuning {
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
            promise: Promise {
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

    /// A trial of a servo that is where `position` says (rad): at a time since the step, in the stages
    /// after it a second later; for a reference; and for a disturbance that comes (1) or goes (−1).
    fn tried(
        step: f64,
        position: impl Fn(f64, f64, f64) -> f64,
    ) -> (Result<bool, Reason>, TrialResult) {
        tried_with(step, 0.0, position)
    }

    /// The same of one with friction, rad/s².
    fn tried_with(
        step: f64,
        coulomb: f64,
        position: impl Fn(f64, f64, f64) -> f64,
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
        let servo = ServoParameters {
            a: 0.0,
            b: B,
            coulomb,
            load: 0.0,
        };
        let mut trial = Trial::<f64>::new(&promised(), &units, step, 0.5, &servo);
        for _ in 0..100_000 {
            let passed = f64::from(trial.passed) * 1e-3;
            let since_the_step = match trial.stage {
                TrialStage::Settling | TrialStage::Stepping => passed,
                TrialStage::Disturbed | TrialStage::Recovering => passed + 1.0,
            };
            let at = position(
                since_the_step,
                holding.reference() * units.position_unit(),
                match trial.stage {
                    TrialStage::Disturbed => 1.0,
                    TrialStage::Recovering => -1.0,
                    _ => 0.0,
                },
            );
            let count = libm::floor(at * units.position());
            let done = trial.process(&mut holding, count);
            let _ = holding.process(count, 0.0);
            if done != Ok(false) {
                return (done, trial.result(&units));
            }
        }
        panic!("it neither ends nor fails");
    }

    /// A step of first order, and an excursion as promised.
    fn first_order(time_constant: f64) -> impl Fn(f64, f64, f64) -> f64 {
        move |time, reference, change| {
            let step = reference * -libm::expm1(-time / time_constant);
            step + change * excursion(1.0, time)
        }
    }

    /// An excursion by a factor on the promise, at a time since the step.
    fn excursion(factor: f64, time: f64) -> f64 {
        let since = (time - 1.0) / 0.02;
        factor * COMPLIANCE * B * 0.5 * since * libm::exp(1.0 - since)
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
    fn a_slower_or_faster_rise_than_promised_is_refused() {
        for factor in [1.3, 0.75] {
            let (done, _) = tried(STEP, first_order(factor * TIME_CONSTANT));
            assert_eq!(done, Err(Reason::ResponseTimeMissed));
        }
    }

    #[test]
    fn overshoot_compliance_and_unrest_are_refused() {
        let plain = first_order(TIME_CONSTANT);
        let (overshoots, _) = tried(STEP, |time, reference, change| {
            plain(time, reference, change) * (1.0 + 6.0 * time * libm::exp(-time / 0.05))
        });
        assert_eq!(overshoots, Err(Reason::OvershootExceeded));
        let (gives_way, _) = tried(STEP, |time, reference, change| {
            plain(time, reference, change) + change * excursion(1.5, time)
        });
        assert_eq!(gives_way, Err(Reason::DisturbanceExceeded));
        let (never_rests, _) = tried(STEP, |time, reference, change| {
            plain(time, reference, change) + 0.001 * libm::sin(time / 0.01)
        });
        assert_eq!(never_rests, Err(Reason::NeverAtRest));
    }

    #[test]
    fn an_encoder_that_sticks_after_the_step_is_found_where_friction_cannot_hold_the_servo() {
        let plain = first_order(TIME_CONSTANT);
        for sticks_at_once in [true, false] {
            let stuck = |time: f64, reference: f64, change: f64| {
                let sticks = sticks_at_once || change < 0.0;
                plain(time, reference, if sticks { 0.0 } else { change })
            };
            // The disturbance gives 100 rad/s².
            for (coulomb, expected) in [
                (0.0, Err(Reason::ActuatorDead)),
                (10.0, Err(Reason::ActuatorDead)),
                (34.0, Ok(true)),
            ] {
                let (done, _) = tried_with(STEP, coulomb, stuck);
                assert_eq!(done, expected, "{sticks_at_once} {coulomb}");
            }
        }
    }
}
