//! Steps along a reference model of servos with gravity, ripple and a dead band, with and without their compensation.

use std::f64::consts::TAU;

use identifier_core::control::{
    CommandLimit, CompensatedFeedForward, CompensationSettings, Controller, Gains,
};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::{Goal, Tuning, TuningSettings};
use identifier_core::units::Units;
use virtual_servo::{Effects, Encoder, Servo, SplitMix64};

use crate::support::{identified, quantile, tuned};

/// The largest command.
const LIMIT: f64 = 10.0;

/// A servo with known forces, and its gains.
struct Axis {
    servo: ServoParameters,
    effects: Effects,
    known: CompensationSettings,
    settings: TuningSettings,
    tuning: Tuning,
    /// The way of a move, rad.
    distance: f64,
}

/// Which of its forces a servo has.
#[derive(Clone, Copy, PartialEq)]
enum Forces {
    Gravity,
    Ripple,
    DeadBand,
    All,
}

fn log_uniform(random: &mut SplitMix64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.next_uniform())
}

/// A servo of b 20 to 2000 and a 0.01 to 20, with friction of up to 0.01 of the limit, gravity of 0.05 to 0.3, ripple of 0.01 to
/// 0.05 of 4 to 60 periods and a dead band of 0.01 to 0.05, at 1 to 10 kHz, with 4096 to 131 072 counts and delays of up to two
/// samples; steps of 0.05 to 0.5 rad. None where its gains have no feed-forward.
fn axis(seed: u64, forces: Forces) -> Option<Axis> {
    let mut random = SplitMix64::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x51ed_270b);
    let random = &mut random;
    let b = log_uniform(random, 20.0, 2000.0);
    let authority = b * LIMIT;
    let servo = ServoParameters {
        a: log_uniform(random, 0.01, 20.0),
        b,
        coulomb: authority * random.uniform(0.0, 0.01),
        load: 0.0,
    };
    let sample_time = random.one_of(&[1e-3, 2.5e-4, 1e-4]);
    let counts = log_uniform(random, 4096.0, 131_072.0).round();
    let delay = sample_time * random.uniform(0.0, 2.0);
    let mut wave = |low, high, is_there: bool| {
        let (sine, cosine) = random.uniform(0.0, TAU).sin_cos();
        let size = authority * log_uniform(random, low, high);
        if is_there {
            [size * sine, size * cosine]
        } else {
            [0.0; 2]
        }
    };
    let has = |force| forces == force || forces == Forces::All;
    let gravity = wave(0.05, 0.3, has(Forces::Gravity));
    let ripple = wave(0.01, 0.05, has(Forces::Ripple));
    let ripple_order = log_uniform(random, 4.0, 60.0).round() as u32;
    let dead_band = LIMIT * log_uniform(random, 0.01, 0.05);
    let effects = Effects {
        delay,
        gravity,
        ripple,
        ripple_order: if has(Forces::Ripple) { ripple_order } else { 0 },
        dead_band: if has(Forces::DeadBand) {
            dead_band
        } else {
            0.0
        },
        ..Effects::NONE
    };
    let known = CompensationSettings {
        gravity: gravity.map(|force| -force / b),
        ripple: ripple.map(|force| -force / b),
        ripple_order: f64::from(effects.ripple_order),
        dead_band: effects.dead_band,
        delay,
        ..CompensationSettings::NONE
    };
    let distance = random.uniform(1.0, 3.0);
    let settings = TuningSettings {
        feed_forward: true,
        ..TuningSettings::new(
            sample_time,
            TAU / counts,
            LIMIT - known.largest(),
            log_uniform(random, 0.05, 0.5),
        )
    };
    let errors = [0.003 * (servo.a + 1.0), 0.003 * b, 0.01 * sample_time];
    let tuning = tuned(&settings, &identified(servo, delay, errors)).0.ok()?;
    tuning.feed_forward.map(|_| Axis {
        servo,
        effects,
        known,
        settings,
        tuning,
        distance,
    })
}

/// A move along the reference model.
struct Followed {
    /// Position, and distance of the model from it, from the beginning of the move, rad.
    samples: Vec<[f64; 2]>,
    /// The time from the reference's arrival on which the servo stays within 2 % of the promised step, or two counts, s.
    settled: f64,
}

impl Axis {
    /// The same without its forces.
    fn free(&self) -> Self {
        Self {
            effects: Effects {
                delay: self.effects.delay,
                ..Effects::NONE
            },
            known: CompensationSettings {
                delay: self.known.delay,
                ..CompensationSettings::NONE
            },
            ..*self
        }
    }

    /// A move at the speed of the promised step by a servo that rests, with this part of the known coefficients. Until then the
    /// integral has come to hold what they do not.
    fn follow(&self, part: f64) -> Followed {
        let TuningSettings {
            sample_time,
            resolution,
            step,
            ..
        } = self.settings;
        let led = self.tuning.feed_forward.expect("it is led");
        let known = CompensationSettings {
            gravity: self.known.gravity.map(|force| part * force),
            ripple: self.known.ripple.map(|force| part * force),
            dead_band: part * self.known.dead_band,
            ..self.known
        };
        let tuning = &self.tuning;
        let units = Units::new(sample_time, resolution).expect("valid");
        let gains = Gains::new(tuning.kp, tuning.kd, tuning.ki).expect("valid");
        let limit = CommandLimit::symmetric(LIMIT).expect("valid");
        let velocity = LowPass::<f64>::new(&units, tuning.cutoff).expect("valid");
        let lead = CompensatedFeedForward::new(&units, &led, &known, &gains, &velocity.transfer());
        let lead = lead.expect("valid");
        let controller = Controller::new(&units, &gains, &limit, velocity).with_feed_forward(lead);
        let mut state = controller.start();
        let mut servo = Servo::at_rest(&self.servo, &self.effects, sample_time, 1).expect("valid");
        let encoder = Encoder::new(TAU / resolution);
        let origin = encoder.read(0.5 * resolution);
        let samples = |time: f64| (time / sample_time).ceil() as usize;
        // Of a step of the model, and the way of the move.
        let pace = 0.27 * led.bandwidth * step * sample_time;
        let (standing, moving) = (
            samples(40.0 / tuning.bandwidth),
            (self.distance / pace).ceil() as usize,
        );
        let band = (0.02 * step).max(2.0 * resolution);
        let mut followed = Followed {
            samples: Vec::new(),
            settled: sample_time,
        };
        let mut measured = 0.0;
        for k in 0..2 * standing + moving {
            let exact = servo.position();
            let position = (encoder.read(exact + 0.5 * resolution) - origin) as f64;
            let increment = position - measured;
            measured = position;
            let passed = k.saturating_sub(standing);
            let reference = (pace * passed as f64).min(self.distance);
            let sample = controller
                .process(&mut state, reference / resolution - position, increment)
                .expect("in range");
            servo.advance(sample.command);
            if k >= standing {
                let model = (position + sample.error) * resolution;
                followed.samples.push([exact, model - exact]);
            }
            if passed > moving && (exact - self.distance).abs() > band {
                followed.settled = (passed - moving) as f64 * sample_time;
            }
        }
        followed
    }
}

impl Followed {
    /// The distance from the model, root of the mean square, rad.
    fn error(&self) -> f64 {
        rms(self.samples.iter().map(|[_, error]| *error))
    }

    /// The distance from where another servo is, root of the mean square, rad.
    fn away_from(&self, other: &Self) -> f64 {
        let both = self.samples.iter().zip(&other.samples);
        rms(both.map(|([here, _], [there, _])| here - there))
    }
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

fn environment(variable: &str) -> Option<f64> {
    std::env::var(variable).ok()?.parse().ok()
}

/// Where no delay makes the servo late, and all is known exactly, it is within two counts of the model.
#[test]
fn the_model_is_followed_to_the_encoders_resolution() {
    const COUNTS: f64 = 20_000.0;
    let servo = ServoParameters {
        a: 3.0,
        b: 250.0,
        coulomb: 0.0,
        load: 0.0,
    };
    let effects = Effects {
        gravity: [-600.0, 300.0],
        ripple: [60.0, 20.0],
        ripple_order: 7,
        ..Effects::NONE
    };
    let known = CompensationSettings {
        gravity: effects.gravity.map(|force| -force / servo.b),
        ripple: effects.ripple.map(|force| -force / servo.b),
        ripple_order: 7.0,
        ..CompensationSettings::NONE
    };
    let settings = TuningSettings {
        goal: Goal::Bandwidth(40.0),
        feed_forward: true,
        ..TuningSettings::new(2.5e-4, TAU / COUNTS, LIMIT - known.largest(), 0.1)
    };
    let errors = [0.01, 0.5, 1e-6];
    let tuning = tuned(&settings, &identified(servo, 0.0, errors)).0;
    let axis = Axis {
        servo,
        effects,
        known,
        settings,
        tuning: tuning.expect("gains"),
        distance: 2.0,
    };
    let farthest = |part| {
        let samples = axis.follow(part).samples;
        let errors = samples.iter().map(|[_, error]| error.abs());
        errors.fold(0.0, f64::max) / settings.resolution
    };
    let (with, without) = (farthest(1.0), farthest(0.0));
    assert!(with < 2.0 && without > 20.0, "{with} {without}");
}

/// Forces with the median, and what nine of ten stay below, of what is left of the motion that they cause.
const LEFT: [(Forces, &str, [f64; 2]); 4] = [
    (Forces::Gravity, "gravity", [0.1, 0.4]),
    (Forces::Ripple, "ripple", [0.1, 0.4]),
    (Forces::DeadBand, "dead band", [0.65, 1.0]),
    (Forces::All, "all", [0.12, 0.4]),
];

/// `COMPENSATED=200 SEED=7 cargo test -p identifier-core --test tuning compensation:: -- --nocapture` prints the figures of
/// docs/tuning.md.
#[test]
fn forces_move_a_servo_less_where_they_are_known() {
    let servos = environment("COMPENSATED").unwrap_or(60.0) as u64;
    let first = 100_000 * environment("SEED").unwrap_or(1.0) as u64;
    for (forces, name, allowed) in LEFT {
        let seeds = first..first + servos;
        let axes: Vec<Axis> = seeds.filter_map(|seed| axis(seed, forces)).collect();
        println!("{name}: {} of {servos} with feed-forward", axes.len());
        let free: Vec<Followed> = axes.iter().map(|axis| axis.free().follow(1.0)).collect();
        let without: Vec<Followed> = axes.iter().map(|axis| axis.follow(0.0)).collect();
        for part in [1.0, 0.8, 1.2, 2.0] {
            println!("  {part} of the coefficients, over those without");
            let with: Vec<Followed> = axes.iter().map(|axis| axis.follow(part)).collect();
            let show = |of: &str, ratio: &dyn Fn(&Followed, &Followed) -> f64| {
                let all = with.iter().zip(&without).zip(&free);
                let ratios =
                    all.map(|((with, without), free)| ratio(with, free) / ratio(without, free));
                let mut ratios: Vec<f64> = ratios.collect();
                let [low, median, high] = [0.1, 0.5, 0.9].map(|part| quantile(&mut ratios, part));
                println!("    {of}: median {median:.2}, {low:.2} to {high:.2} in eight of ten");
                [median, high]
            };
            show("distance from the model", &|seen, _| seen.error());
            let left = show("motion by the forces", &|seen, free| seen.away_from(free));
            show("time until it has settled", &|seen, _| seen.settled);
            // What is wrong by a part leaves that part.
            let wrong = (part - 1.0_f64).abs();
            let most = allowed.map(|allowed| allowed + wrong);
            assert!(
                left[0] < most[0] && left[1] < most[1],
                "{name} {part}: {left:?} {most:?}"
            );
        }
    }
}
