//! From an identification to gains, and from these to the predicted step: each servo is identified by a run, tuned for
//! from its JSON result, and steps on the simulated servo as was promised.

use std::fmt::Write;

use host_sim::scenario::Scenario;
use host_sim::simulate;
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::{Goal, StepMeasure, TuningSettings};
use identifier_log::experiment::Sample;
use identifier_log::result::KeptResult;
use identifier_log::tune::{Conditions, IdentifiedResult, KnownConditions, NoGains, Tuned};
use integration_tests::{Random, environment, in_parallel, parse, run};
use servo_id::present;

/// Servos, times `CAMPAIGN`.
const SERVOS: usize = 20;

/// The limit of the command, command units.
const LIMIT: f64 = 10.0;

/// A servo, its encoder and its sampling.
#[derive(Debug, Clone, Copy)]
struct Axis {
    servo: ServoParameters,
    delay: f64,
    counts: f64,
    sample_time: f64,
    seed: u32,
    goal: Goal,
}

/// Servos of b 50 to 1000, a up to 20, friction of 0.1 to 5 % and load up to 30 % of the limit, delays of up
/// to two samples, 2000 to 131 072 counts, at 1 to 4 kHz.
fn axes() -> Vec<Axis> {
    let mut random = Random::new(15);
    let mut axes: Vec<Axis> = (0..SERVOS * environment("CAMPAIGN").unwrap_or(1))
        .map(|i| {
            let b = random.log_uniform(50.0, 1000.0);
            let sample_time = if i % 2 == 0 { 1e-3 } else { 2.5e-4 };
            Axis {
                servo: ServoParameters {
                    a: random.log_uniform(0.1, 20.0),
                    b,
                    coulomb: random.log_uniform(0.001, 0.05) * LIMIT * b,
                    load: random.uniform(-0.3, 0.3) * LIMIT * b,
                },
                delay: random.uniform(0.0, 2.0) * sample_time,
                counts: random.log_uniform(2000.0, 131_072.0).round(),
                sample_time,
                seed: random.seed(),
                goal: Goal::Stiffest,
            }
        })
        .collect();
    for axis in axes.iter_mut().skip(2).step_by(3) {
        axis.goal = Goal::ResponseTime(random.log_uniform(0.04, 0.2));
    }
    axes
}

impl Axis {
    /// A scenario of this servo.
    fn scenario(&self, controller: &str, excitation: &str, duration: f64) -> Scenario {
        let ServoParameters {
            a,
            b,
            coulomb,
            load,
        } = self.servo;
        parse(&format!(
            "[plant]\na = {a}\nb = {b}\ncoulomb = {coulomb}\nload = {load}\ndelay = {}\n\
             [encoder]\ncounts_per_rev = {}\n\
             [amplifier]\nlimit = {LIMIT:?}\n\
             {controller}\n\
             [excitation]\n{excitation}\n\
             [identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n\
             required_terms = [\"delay\"]\narithmetic = \"f64\"\n\
             [run]\nduration = {duration:?}\n",
            self.delay, self.counts
        ))
    }

    /// As identified behind gains that are far from the best: a bandwidth of 15 rad/s.
    fn identified(&self) -> IdentifiedResult {
        let (omega, b) = (15.0_f64, self.servo.b);
        let controller = format!(
            "[controller]\nkp = {}\nkd = {}\nki = {}\nsample_time = {:?}\n\
             velocity_filter = {{ kind = \"low-pass\", cutoff = 300.0 }}",
            2.0 * omega * omega / b,
            2.0 * omega / b,
            omega.powi(3) / b / 2.0,
            self.sample_time
        );
        let excitation = format!(
            "kind = \"band-limited-white-noise\"\npower = 0.05\nsample_time = 0.1\nseed = {}",
            self.seed
        );
        let summary = run(&self.scenario(&controller, &excitation, 20.0));
        IdentifiedResult::new(&KeptResult::from(&summary)).expect("a result")
    }

    /// Gains for the identified servo; a fifth below its limit where the demand exceeds it.
    fn tuned(&self, result: &IdentifiedResult) -> Tuned {
        let conditions = Conditions {
            counts: Some(self.counts),
            limit: Some(LIMIT),
            step: Some(0.1),
            ..Conditions::default()
        };
        let settings = conditions.settings(self.goal, result, &KnownConditions::default());
        let settings = settings.expect("all is known");
        Tuned::new(result, None, &settings).unwrap_or_else(|refused| match refused {
            NoGains::TooFast { most, .. } => {
                let goal = Goal::Bandwidth(0.8 * most);
                Tuned::new(result, None, &TuningSettings { goal, ..settings })
                    .expect("within reach")
            }
            NoGains::Error(error) => panic!("{self:?}: {error}"),
            NoGains::Form(error) => panic!("{self:?}: {error}"),
        })
    }

    /// Steps there and back with the gains as they are printed, on the servo itself: rise time, s, and
    /// overshoot of each.
    fn steps(&self, tuned: &Tuned) -> Vec<(f64, f64)> {
        let controller = present::tuned_controller(tuned);
        let hold = (30.0 / tuned.tuning.bandwidth / self.sample_time).ceil() * self.sample_time;
        let step = tuned.settings.step;
        let excitation = format!("kind = \"steps\"\nlevels = [0.0, {step:?}]\nhold = {hold:.6}");
        let scenario = self.scenario(&controller, &excitation, 6.0 * hold);
        let mut samples: Vec<Sample> = Vec::new();
        simulate::run(&scenario, &mut |sample| samples.push(*sample)).expect("a valid scenario");
        let changes: Vec<usize> = (1..samples.len())
            .filter(|&k| (samples[k].reference - samples[k - 1].reference).abs() > step / 2.0)
            .collect();
        changes
            .iter()
            .map(|&begin| {
                let direction = (samples[begin].reference - samples[begin - 1].reference).signum();
                let from = samples[begin - 1].reference;
                let mut measure = StepMeasure::<f64>::new(step, tuned.settings.resolution);
                let until = begin + (hold / self.sample_time) as usize - 1;
                for sample in &samples[begin..until.min(samples.len())] {
                    measure.take(direction * (sample.position - from));
                }
                let rise = measure
                    .rise()
                    .map_or(f64::INFINITY, |rise| rise * self.sample_time);
                (rise, measure.overshoot())
            })
            .collect()
    }
}

/// The trial's own criterion: each rise time within 15 % of the prediction, each overshoot within three points.
#[test]
fn the_true_servo_keeps_the_prediction_made_from_a_result() {
    let axes = axes();
    let outcomes = in_parallel(&axes, |axis| {
        let result = axis.identified();
        if result.reservation.is_some() {
            return (result.reservation, None);
        }
        let tuned = axis.tuned(&result);
        let steps = axis.steps(&tuned);
        (None, Some((tuned, steps)))
    });
    let mut broken = String::new();
    let (mut kept, mut narrow) = (0, 0);
    for (i, (axis, (reservation, outcome))) in axes.iter().zip(&outcomes).enumerate() {
        let Some((tuned, steps)) = outcome else {
            println!("{i} {axis:?} {reservation:?}");
            continue;
        };
        let predicted_response = tuned.tuning.predicted_response;
        let quick = predicted_response
            .rise_time
            .min(predicted_response.quickest_rise_time);
        let slow = predicted_response
            .rise_time
            .max(predicted_response.slowest_rise_time);
        assert!(steps.len() >= 4, "{steps:?}");
        narrow += usize::from(slow < 1.2 * quick);
        let keeps = steps.iter().all(|&(rise, overshoot)| {
            rise > 0.85 * quick
                && rise < 1.15 * slow
                && overshoot < predicted_response.overshoot + 0.03
        });
        if keeps {
            kept += 1;
        } else {
            writeln!(broken, "{i} {axis:?} {:?} {steps:?}", tuned.tuning)
                .expect("a string takes any text");
        }
    }
    assert!(broken.is_empty(), "{broken}");
    let servos = axes.len();
    assert!(narrow >= servos / 2, "{narrow} of {servos} hardly rub");
    assert!(
        kept >= servos * 9 / 10,
        "{kept} of {servos} were identified"
    );
}
