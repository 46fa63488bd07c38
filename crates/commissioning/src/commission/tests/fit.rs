use std::vec::Vec;

use super::unknown_servos::{Unknown, unknown_servos};
use crate::commission::{
    CommissionSettings, FittedServo, Limits, MotionRecord, ServoFit, ServoFitter,
};
use identifier_core::fit::Recorder;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use virtual_servo::{Effects, Plant};

fn recorded<const W: usize>(unknown: &Unknown, samples: &[[f32; 2]]) -> MotionRecord<f32, W> {
    let (blocking, mut recorder) = (unknown.settings().blocking(), Recorder::default());
    let mut motion = MotionRecord::EMPTY;
    for &[increment, command] in samples {
        recorder.push(&blocking, increment, command);
        if let Some(block) = recorder.take() {
            assert!(motion.take(&block));
        }
    }
    motion
}

fn fitted<const W: usize>(
    unknown: &Unknown,
    motion: &MotionRecord<f32, W>,
) -> Result<IdentifiedServo, Reason> {
    found(&unknown.settings(), motion).map(|fitted| fitted.servo)
}

fn found<const W: usize>(
    settings: &CommissionSettings,
    motion: &MotionRecord<f32, W>,
) -> Result<FittedServo, Reason> {
    let fitter = ServoFitter::new(settings);
    let mut fit = fitter.begin(motion);
    worked(&fitter, &mut fit, motion)
}

fn worked<const W: usize>(
    fitter: &ServoFitter<'_, f32>,
    fit: &mut ServoFit<f32>,
    motion: &MotionRecord<f32, W>,
) -> Result<FittedServo, Reason> {
    loop {
        if let Some(result) = fitter.work(fit, motion) {
            return result;
        }
    }
}

/// The largest difference in an open-loop move of 0.2 s, over its length: to two thirds of the speed that
/// is allowed and back to rest, with the command that does so to the true servo.
fn response_error(unknown: &Unknown, found: &ServoParameters) -> f64 {
    let truth = unknown.parameters;
    let accelerate = unknown.limits.speed / 1.5 / 0.1;
    let [mut one, mut other] = [&truth, found].map(|servo| Plant::at_rest(servo, 1e-3));
    let (mut most, mut off) = (0.0_f64, 0.0_f64);
    for k in 0..200 {
        let push = if k < 100 { accelerate } else { -accelerate };
        let command = (push - truth.load + truth.coulomb) / truth.b;
        one.advance(command);
        other.advance(command);
        most = most.max(one.position.abs());
        off = off.max((one.position - other.position).abs());
    }
    off / most
}

/// Of how many servos gain or response were missed by more than 2 %.
#[derive(Debug, Default)]
struct Missed {
    servos: u32,
    gain: u32,
    response: u32,
}

impl Missed {
    /// A fit to a time of the first motion; none: until there was evidence.
    fn by(servos: impl Iterator<Item = Unknown>, time: Option<f64>) -> Self {
        let mut missed = Self::default();
        for unknown in servos {
            let moved = unknown.probe();
            let time = time.or(moved.evidence).unwrap_or(f64::INFINITY);
            let end = ((time / unknown.sample_time) as usize).min(moved.samples.len());
            let motion = recorded::<512>(&unknown, &moved.samples[..end]);
            let servo = fitted(&unknown, &motion);
            let is_off = |by: &dyn Fn(&ServoParameters) -> f64| {
                let off = servo.as_ref().map_or(1.0, |servo| by(&servo.parameters));
                u32::from(off > 0.02)
            };
            missed.servos += 1;
            missed.gain += is_off(&|found| (found.b / unknown.parameters.b - 1.0).abs());
            missed.response += is_off(&|found| response_error(&unknown, found));
        }
        println!("{missed:?}");
        missed
    }

    /// In at most these shares of the servos, plus one.
    fn at_most(&self, gain: f64, response: f64) -> bool {
        let allowed = |share: f64| (share * f64::from(self.servos)).ceil() as u32;
        self.gain <= allowed(gain) && self.response <= allowed(response)
    }
}

const FINE: f64 = 4096.0;

#[test]
fn a_tenth_of_a_second_identifies_the_gain_and_most_responses() {
    for (sample_time, time) in [(1e-3, 0.15), (2.5e-4, 0.1), (1e-4, 0.1)] {
        let servos =
            unknown_servos().filter(|u| u.counts >= FINE && u.is_sampled_every(sample_time));
        let missed = Missed::by(servos, Some(time));
        assert!(missed.at_most(0.01, 0.07), "{sample_time} s: {missed:?}");
    }
}

#[test]
fn with_enough_evidence_gain_and_response_are_accurate() {
    let fine = Missed::by(unknown_servos().filter(|u| u.counts >= FINE), None);
    assert!(fine.at_most(0.01, 0.03), "{fine:?}");
    let coarse = Missed::by(unknown_servos().filter(|u| u.counts < FINE), None);
    assert!(coarse.at_most(0.03, 0.4), "{coarse:?}");
}

/// A servo with a fine encoder and its first motion.
fn ordinary(effects: Effects) -> Unknown {
    let mut unknown = Unknown::from_seed(40);
    unknown.counts = 20_000.0;
    unknown.sample_time = 1e-4;
    unknown.delay = 1.3;
    unknown.held = None;
    unknown.parameters = ServoParameters::new(1.5, 100.0, 60.0, 20.0);
    unknown.effects = effects;
    unknown
}

#[test]
fn errors_agree_with_the_standard_errors() {
    let mut off = Vec::new();
    for unknown in unknown_servos().filter(|u| u.counts >= FINE && u.counts <= 20_000.0) {
        let moved = unknown.probe();
        let motion = recorded::<256>(&unknown, &moved.samples);
        let servo = fitted(&unknown, &motion).expect("a servo");
        let error = servo.parameters.b - unknown.parameters.b;
        off.push((error / servo.standard_error(IdentifiedServo::B)).abs());
    }
    off.sort_by(f64::total_cmp);
    let [median, most] = [0.5, 0.9].map(|part| off[(part * off.len() as f64) as usize]);
    println!("errors over standard errors: median {median:.2}, 90 % {most:.2}");
    assert!(
        (0.3..1.2).contains(&median) && most < 3.5,
        "{median} {most}"
    );
}

/// Encoder readings of a servo under a command that alternates, and the command.
fn shaken(unknown: &Unknown, late: usize) -> Vec<[f32; 2]> {
    let mut plant = Plant::at_rest(&unknown.parameters, unknown.sample_time);
    let command = |k: usize| if k % 160 < 80 { 6.0 } else { -6.0 };
    let mut last = 0.0;
    (0..480_usize)
        .map(|k| {
            let count = (plant.position / unknown.resolution()).floor();
            let increment = count - last;
            last = count;
            plant.advance(k.checked_sub(late).map_or(0.0, command));
            [increment as f32, command(k) as f32]
        })
        .collect()
}

#[test]
fn an_estimate_at_its_bound_is_refused() {
    let mut unknown = ordinary(Effects::NONE);
    unknown.sample_time = 1e-3;
    unknown.parameters = ServoParameters::new(5.0, 100.0, 30.0, 0.0);
    fn fit<const W: usize>(unknown: &Unknown, late: usize) -> Result<(), Reason> {
        let motion = recorded::<W>(unknown, &shaken(unknown, late));
        fitted(unknown, &motion).map(|_| ())
    }
    assert_eq!(fit::<256>(&unknown, 1), Ok(()));
    assert_eq!(fit::<256>(&unknown, 26), Err(Reason::EstimateAtBound));
    // Blocks of the record in which more than half of a velocity dies down.
    unknown.parameters.a = 80.0;
    assert_eq!(fit::<256>(&unknown, 1), Ok(()));
    assert_eq!(fit::<24>(&unknown, 1), Err(Reason::EstimateAtBound));
    // The command is a speed.
    unknown.parameters.a = 800.0;
    unknown.parameters.b = 2e4;
    assert_eq!(fit::<256>(&unknown, 1), Err(Reason::EstimateAtBound));
}

#[test]
fn a_long_motion_fits_into_a_short_record() {
    let unknown = ordinary(Effects::NONE);
    let moved = unknown.probe();
    let motion = recorded::<64>(&unknown, &moved.samples);
    let servo = fitted(&unknown, &motion).expect("a servo");
    let off = servo.parameters.b / unknown.parameters.b - 1.0;
    assert!(off.abs() < 0.01, "{off}");
}

#[test]
fn a_missing_block_is_noticed() {
    let unknown = ordinary(Effects::NONE);
    let (blocking, mut recorder) = (unknown.settings().blocking(), Recorder::default());
    let mut motion = MotionRecord::<f32, 64>::EMPTY;
    let mut blocks = unknown
        .probe()
        .samples
        .into_iter()
        .filter_map(|[increment, command]| {
            recorder.push(&blocking, increment, command);
            recorder.take()
        })
        .collect::<Vec<_>>();
    blocks.remove(7);
    let taken = blocks.iter().filter(|block| motion.take(block)).count();
    assert_eq!((taken, motion.is_complete()), (7, false));
}

/// What the fit to its own motion leaves unexplained, counts, and the relative error of its gain with its standard error;
/// none where there is no servo. Each motion is another, from another place between two edges.
fn unexplained(effects: Effects) -> Vec<Option<[f64; 3]>> {
    let places = (0..9).map(|place| Unknown {
        between_edges: f64::from(place) / 9.0,
        ..ordinary(effects)
    });
    let left = places.map(|unknown| {
        let motion = recorded::<256>(&unknown, &unknown.probe().samples);
        let servo = fitted(&unknown, &motion).ok()?;
        let off = servo.parameters.b / unknown.parameters.b - 1.0;
        let error = servo.standard_error(IdentifiedServo::B) / servo.parameters.b;
        Some([servo.unexplained / unknown.resolution(), off.abs(), error])
    });
    left.collect()
}

#[test]
fn a_complete_model_leaves_no_more_than_the_rounding() {
    for left in unexplained(Effects::NONE) {
        assert!(left.is_some_and(|[left, ..]| left < 0.45), "{left:?}");
    }
}

#[test]
fn an_effect_that_the_model_lacks_leaves_more_than_a_count_or_the_gain_as_certain_as_it_is() {
    let none = Effects::NONE;
    for effects in [
        Effects {
            dead_band: 0.5,
            ..none
        },
        Effects {
            low_speed_friction: 40.0,
            low_speed_velocity: 0.5,
            ..none
        },
        Effects {
            gravity: [200.0, 0.0],
            ..none
        },
        Effects {
            resonance: 400.0,
            inertia_ratio: 0.5,
            ..none
        },
        Effects {
            ripple: [100.0, 0.0],
            ripple_order: 12,
            ..none
        },
    ] {
        let left = unexplained(effects);
        println!("{left:?}");
        let is_right = |[left, off, error]: [f64; 3]| left > 1.0 || off < 0.02 || off < 2.0 * error;
        assert!(left.into_iter().all(|found| found.is_none_or(is_right)));
    }
}

#[test]
fn gravity_and_falling_friction_are_explained_with_the_gain() {
    let none = Effects::NONE;
    for effects in [
        Effects {
            gravity: [200.0, 0.0],
            ..none
        },
        Effects {
            gravity: [-120.0, 150.0],
            ..none
        },
        Effects {
            low_speed_friction: 60.0,
            low_speed_velocity: 0.3,
            ..none
        },
    ] {
        let unknown = ordinary(effects);
        let motion = recorded::<256>(&unknown, &unknown.probe().samples);
        let settings = unknown.settings();
        let found = found(&settings, &motion).expect("a servo");
        let off = found.servo.parameters.b / unknown.parameters.b - 1.0;
        println!("{off:.4} {found:?}");
        assert!(found.explains && off.abs() < 0.02, "{off}");
        let ([found_slope, _], [slope, _]) = (found.forces.wave, effects.gravity);
        assert!((found_slope - slope).abs() <= 0.05 * slope.abs());
        let is_falling = effects.low_speed_friction > 0.0;
        assert_eq!(found.forces.low_speed > 0.0, is_falling);
    }
}

/// When it breaks away differs from time to time, which leaves more than a count of the motion.
#[test]
fn friction_that_doubles_at_rest_is_explained_within_its_standard_error() {
    for (low_speed_friction, low_speed_velocity) in [(770.0, 0.136), (900.0, 0.2), (800.0, 0.05)] {
        let unknown = Unknown {
            parameters: ServoParameters::new(2.9, 407.0, 700.0, -318.0),
            counts: 4096.0,
            sample_time: 2.5e-4,
            limits: Limits::new([-0.28, 0.28], 26.0, [-10.0, 10.0]),
            ..ordinary(Effects {
                low_speed_friction,
                low_speed_velocity,
                ..Effects::NONE
            })
        };
        let motion = recorded::<256>(&unknown, &unknown.probe().samples);
        let found = found(&unknown.settings(), &motion).expect("a servo");
        let off = found.servo.parameters.b - unknown.parameters.b;
        println!("{off:.2} {found:?}");
        assert!(found.explains);
        assert!(off.abs() < 2.0 * found.servo.standard_error(IdentifiedServo::B));
    }
}

/// Cogging of a quarter of Coulomb friction and more, and a load on a spring, which no wave explains.
#[test]
fn a_wave_of_the_angle_is_explained_with_the_gain_and_a_resonance_is_not() {
    let none = Effects::NONE;
    let cogging = |ripple, ripple_order| Effects {
        ripple,
        ripple_order,
        ..none
    };
    let resonance = Effects {
        resonance: 150.0,
        inertia_ratio: 0.6,
        ..none
    };
    for (effects, order) in [
        (cogging([120.0, 0.0], 24), Some(24.0)),
        (cogging([-60.0, 80.0], 40), Some(40.0)),
        (cogging([0.0, -150.0], 71), Some(71.0)),
        (resonance, None),
    ] {
        let unknown = ordinary(effects);
        let settings = unknown.settings();
        let motion = recorded::<256>(&unknown, &unknown.probe().samples);
        let fitter = ServoFitter::new(&settings);
        let mut fit = fitter.begin_waves(&motion, None).expect("long enough");
        let noisy = CommissionSettings {
            noise: 2.0,
            ..settings
        };
        assert_eq!(ServoFitter::new(&noisy).begin_waves(&motion, None), None);
        let found = worked(&fitter, &mut fit, &motion);
        println!("{found:?}");
        let explained = found.ok().filter(|found| found.explains);
        assert_eq!(explained.is_some(), order.is_some(), "{order:?}");
        let (Some(found), Some(order)) = (explained, order) else {
            continue;
        };
        let off = found.servo.parameters.b / unknown.parameters.b - 1.0;
        assert!(off.abs() < 0.02, "{off}");
        assert!((found.forces.order - order).abs() < 1.0, "{order}");
        let [sine, cosine] = effects.ripple;
        let size = found.forces.wave_amplitude() / f64::hypot(sine, cosine);
        assert!((size - 1.0).abs() < 0.1, "{size}");
    }
}
