//! Changes of a commissioned servo, as Gauss–Newton's recursion finds them in motion.

use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use virtual_servo::SplitMix64;

use crate::moving_axis::{Axis, LIMIT};

/// The paper's servo with friction.
fn ordinary(sample_time: f64) -> Axis {
    let truth = ServoParameters::new(0.5, 257.7, 60.0, 30.0);
    Axis::new(truth, sample_time, 10_000.0, 0.0, 0.5, 1).expect("it has gains")
}

#[test]
fn another_inertia_and_another_friction_are_reported_within_seconds_of_motion() {
    for sample_time in [2e-3, 1e-3, 1e-4] {
        for (inertia, friction, reason) in [
            (0.5, 1.0, Reason::InertiaChanged),
            (2.0, 1.0, Reason::InertiaChanged),
            (1.0, 2.0, Reason::CoulombFrictionChanged),
        ] {
            let mut axis = ordinary(sample_time);
            assert_eq!(axis.runs(5.0), None);
            axis.change(inertia, friction);
            let change = axis
                .runs(15.0)
                .unwrap_or_else(|| panic!("{sample_time} {inertia} {friction}"));
            assert_eq!(change.reason, reason);
            let ratio = change.found / change.predicted;
            assert!(
                (ratio / (inertia * friction) - 1.0).abs() < 0.1,
                "{change:?}"
            );
        }
    }
}

#[test]
fn a_change_that_is_gone_is_no_longer_reported() {
    let mut axis = ordinary(1e-3);
    axis.change(0.5, 1.0);
    assert!(axis.runs(15.0).is_some());
    axis.change(1.0, 1.0);
    for _ in 0..20_000 {
        axis.sample();
    }
    assert_eq!(axis.changes.reported(), None);
}

/// A change of the campaign: factors of inertia and friction, and the reason that is to be reported.
struct Case {
    inertia: f64,
    friction: f64,
    reason: Option<Reason>,
    servos: u32,
    /// Times from the change to its report, s.
    times: Vec<f64>,
    mistaken: u32,
}

impl Case {
    fn new(inertia: f64, friction: f64, reason: Option<Reason>) -> Self {
        Self {
            inertia,
            friction,
            reason,
            servos: 0,
            times: Vec::new(),
            mistaken: 0,
        }
    }

    fn quantile(&self, part: f64) -> f64 {
        let place = (part * self.times.len() as f64) as usize;
        self.times.get(place).copied().unwrap_or(f64::NAN)
    }
}

/// An axis drawn from rates of 250 Hz to 20 kHz, encoders of 500 to 131 000 counts, b over 100:1, and noise of up to a count;
/// none where it has no gains.
fn drawn(seed: u64) -> Option<Axis> {
    let mut random = SplitMix64::new(seed);
    let b = 30.0 * 100.0_f64.powf(random.uniform(0.0, 1.0));
    let truth = ServoParameters::new(
        random.uniform(0.0, 10.0),
        b,
        random.uniform(0.01, 0.15) * b * LIMIT,
        random.uniform(-0.2, 0.2) * b * LIMIT,
    );
    let sample_time = random.one_of(&[4e-3, 2e-3, 1e-3, 2.5e-4, 1e-4, 5e-5]);
    let counts = 500.0 * 262.0_f64.powf(random.uniform(0.0, 1.0)).round();
    let noise = random.one_of(&[0.0, 0.0, 0.5, 1.0]);
    let share = random.uniform(0.2, 0.8);
    Axis::new(truth, sample_time, counts, noise, share, seed)
}

/// `SERVOS` servos drawn with `SEED`: each `TIME` seconds without a change, and 30 seconds with each change.
#[test]
#[ignore = "minutes: run it by name"]
fn a_servo_that_does_not_change_is_never_reported() {
    let given = |name: &str, usual: u64| {
        std::env::var(name).map_or(usual, |text| text.parse().expect("a number"))
    };
    let [servos, seed, time] =
        [("SERVOS", 60), ("SEED", 1), ("TIME", 120)].map(|(name, usual)| given(name, usual));
    let mut cases = [
        Case::new(1.0, 1.0, None),
        Case::new(0.2, 1.0, Some(Reason::InertiaChanged)),
        Case::new(0.5, 1.0, Some(Reason::InertiaChanged)),
        Case::new(2.0, 1.0, Some(Reason::InertiaChanged)),
        Case::new(5.0, 1.0, Some(Reason::InertiaChanged)),
        Case::new(1.0, 2.0, Some(Reason::CoulombFrictionChanged)),
    ];
    for k in 0..servos {
        for case in &mut cases {
            let Some(mut axis) = drawn(1_000_003 * seed + k) else {
                continue;
            };
            case.servos += 1;
            let change = if case.reason.is_some() {
                let early = axis.runs(5.0);
                axis.change(case.inertia, case.friction);
                early.or_else(|| axis.runs(30.0))
            } else {
                axis.runs(time as f64)
            };
            match change {
                Some(change) if Some(change.reason) == case.reason => {
                    case.times.push(axis.time - 5.0);
                }
                Some(change) => {
                    case.mistaken += 1;
                    println!(
                        "servo {k}: {:?} at {} s: {change}",
                        axis.truth, axis.sample_time
                    );
                }
                None => {}
            }
        }
    }
    println!("inertia, friction: servos, reported, as another change, after (median, 90 %)");
    for case in &mut cases {
        case.times.sort_by(f64::total_cmp);
        println!(
            "{}, {}: {}, {}, {}, {:.1} s, {:.1} s",
            case.inertia,
            case.friction,
            case.servos,
            case.times.len(),
            case.mistaken,
            case.quantile(0.5),
            case.quantile(0.9)
        );
    }
    let [unchanged, ..] = &cases;
    assert_eq!(unchanged.mistaken, 0, "servos as they were");
}
