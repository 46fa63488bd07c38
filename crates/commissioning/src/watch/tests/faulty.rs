//! Every fault, on three servos and at five rates.

use std::string::{String, ToString};
use std::vec::Vec;

use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use virtual_servo::faults::{FaultKind, InjectedFault};

use super::support::{Axis, Drive, Found, Knowledge, Run};
use Drive::{Probing, Shake, Steps};
use FaultKind::{
    ActuatorDead as Dead, ActuatorReversed, ActuatorWeak as Weak, EncoderJump, EncoderReversed,
    EncoderStuck as Stuck,
};
use Reason::{
    ActuatorDead, ActuatorWeak, EncoderJumped, EncoderStuck, Reversed, SpeedExceeded, TravelLeft,
};

const RATES: [f64; 5] = [250.0, 1e3, 4e3, 10e3, 20e3];

/// A light servo, a geared axis with friction, and a vertical one with a coarse encoder.
fn axes(rate: f64, drive: Drive) -> [Axis; 3] {
    let axis = |servo, counts_per_rev, limit, bandwidth: f64| Axis {
        servo,
        counts_per_rev,
        sample_time: 1.0 / rate,
        limit,
        // Until the first command acts a load moves the servo, and no ramp has.
        delay: if drive == Probing { 0.0 } else { 1.0 },
        bandwidth: bandwidth.min(0.06 * rate),
    };
    [
        axis(
            ServoParameters::new(0.2174, 257.7, 0.0, 0.0),
            10_000.0,
            10.0,
            40.0,
        ),
        axis(
            ServoParameters::new(2.0, 900.0, 150.0, 20.0),
            65_536.0,
            1.0,
            50.0,
        ),
        axis(
            ServoParameters::new(5.0, 60.0, 40.0, -90.0),
            4096.0,
            5.0,
            20.0,
        ),
    ]
}

/// When the faults begin, s: between two steps of the setpoint.
const BEGINS: f64 = 0.4137;

/// The page that states these figures.
const PAGE: &str = include_str!("../../../../../docs/faults.md");

/// Longest wait for a detection, s.
const MAX_WAIT: f64 = 2.5;

/// A known servo: each parameter to within 10 %.
const KNOWN: Knowledge = Knowledge::Model([0.95, 1.08, 0.9]);
const NOTHING: Knowledge = Knowledge::Nothing;

/// A fault, the knowledge of the servo, its motion; the reasons by which it may be found, in how many of
/// the fifteen runs it may be hidden, and within which time it is found in the others, ms.
type Case = (FaultKind, Knowledge, Drive, &'static [Reason], usize, u32);

#[rustfmt::skip]
const CASES: [Case; 36] = [
    (Stuck, NOTHING, Probing, &[ActuatorDead], 0, 99),
    (Stuck, NOTHING, Steps, &[ActuatorDead], 13, 219),
    (Stuck, NOTHING, Shake, &[], 15, 0),
    (Stuck, KNOWN, Probing, &[EncoderStuck, ActuatorDead], 0, 36),
    (Stuck, KNOWN, Steps, &[EncoderStuck, ActuatorDead], 1, 138),
    (Stuck, KNOWN, Shake, &[EncoderStuck, ActuatorDead], 5, 139),
    (EncoderJump, NOTHING, Probing, &[EncoderJumped], 0, 0),
    (EncoderJump, NOTHING, Steps, &[EncoderJumped], 0, 0),
    (EncoderJump, NOTHING, Shake, &[EncoderJumped], 0, 0),
    (EncoderJump, KNOWN, Probing, &[EncoderJumped, Reversed], 0, 0),
    (EncoderJump, KNOWN, Steps, &[EncoderJumped, Reversed], 0, 0),
    (EncoderJump, KNOWN, Shake, &[EncoderJumped], 0, 0),
    (EncoderReversed, NOTHING, Probing, &[Reversed, TravelLeft], 0, 212),
    (EncoderReversed, NOTHING, Steps, &[Reversed, SpeedExceeded], 0, 76),
    (EncoderReversed, NOTHING, Shake, &[Reversed, SpeedExceeded], 0, 184),
    (EncoderReversed, KNOWN, Probing, &[Reversed, TravelLeft], 0, 199),
    (EncoderReversed, KNOWN, Steps, &[Reversed, SpeedExceeded], 0, 76),
    (EncoderReversed, KNOWN, Shake, &[Reversed, SpeedExceeded], 0, 184),
    (Dead, NOTHING, Probing, &[Reversed, ActuatorDead, TravelLeft], 0, 866),
    (Dead, NOTHING, Steps, &[Reversed, TravelLeft], 9, 232),
    (Dead, NOTHING, Shake, &[Reversed, TravelLeft], 5, 200),
    (Dead, KNOWN, Probing, &[ActuatorDead, TravelLeft], 0, 866),
    (Dead, KNOWN, Steps, &[Reversed, ActuatorDead], 1, 970),
    (Dead, KNOWN, Shake, &[ActuatorDead], 5, 184),
    (Weak, NOTHING, Probing, &[ActuatorDead, TravelLeft], 9, 244),
    (Weak, NOTHING, Steps, &[], 15, 0),
    (Weak, NOTHING, Shake, &[], 15, 0),
    (Weak, KNOWN, Probing, &[ActuatorDead, ActuatorWeak, TravelLeft], 1, 1332),
    (Weak, KNOWN, Steps, &[ActuatorDead, ActuatorWeak], 1, 444),
    (Weak, KNOWN, Shake, &[ActuatorDead, ActuatorWeak], 5, 712),
    (ActuatorReversed, NOTHING, Probing, &[Reversed, ActuatorDead, TravelLeft], 0, 174),
    (ActuatorReversed, NOTHING, Steps, &[Reversed, SpeedExceeded], 0, 116),
    (ActuatorReversed, NOTHING, Shake, &[Reversed, SpeedExceeded], 0, 196),
    (ActuatorReversed, KNOWN, Probing, &[Reversed, ActuatorDead, TravelLeft], 0, 128),
    (ActuatorReversed, KNOWN, Steps, &[Reversed, SpeedExceeded], 0, 116),
    (ActuatorReversed, KNOWN, Shake, &[Reversed, SpeedExceeded], 0, 196),
];

fn size_of(kind: FaultKind, run: &Run<'_>) -> f64 {
    match kind {
        EncoderJump => run.detection().smallest_jump,
        Weak => 0.5,
        _ => 0.0,
    }
}

/// A run with a fault, within the travel and the speed that its motion needs.
fn found(axis: Axis, drive: Drive, knowledge: Knowledge, kind: FaultKind) -> Found {
    let mut run = Run {
        duration: MAX_WAIT,
        ..Run::new(axis, drive, knowledge, &[])
    };
    let reach = axis.reach(drive);
    run.settings.travel = [-reach, reach];
    run.settings.speed = axis.speed(drive);
    let faults = [InjectedFault::lasting(kind, BEGINS, size_of(kind, &run))];
    run.faults = &faults;
    run.run()
}

/// The page's row of a case.
fn row_of(
    kind: FaultKind,
    knowledge: Knowledge,
    drive: Drive,
    reasons: &[Reason],
    may_hide: usize,
    longest: u32,
) -> String {
    let servo = match knowledge {
        Knowledge::Nothing => "unknown",
        Knowledge::Model(_) => "known",
    };
    let motion = format!("{drive:?}").to_lowercase();
    let case = format!("| {} | {servo} | {motion} |", kind.name());
    let mut numbers: Vec<_> = reasons.iter().map(|reason| reason.number()).collect();
    numbers.sort_unstable();
    let numbers: Vec<_> = numbers.iter().map(u8::to_string).collect();
    if numbers.is_empty() {
        return format!("{case} – | 0 | – |");
    }
    let found = 15 - may_hide;
    format!("{case} {} | {found} | {longest} |", numbers.join(", "))
}

#[test]
fn every_fault_is_found_by_its_number_in_its_time() {
    for (kind, knowledge, drive, reasons, may_hide, longest) in CASES {
        let (mut hidden, mut worst) = (0, 0.0_f64);
        for rate in RATES {
            for axis in axes(rate, drive) {
                let case = format!("{kind:?} {drive:?} {knowledge:?} {axis:?}");
                let Some((reason, sample)) = found(axis, drive, knowledge, kind) else {
                    hidden += 1;
                    continue;
                };
                let late = (sample as f64 - (BEGINS * rate).ceil()) / rate;
                assert!(late >= 0.0, "{reason:?} too early: {case}");
                assert!(reasons.contains(&reason), "{reason:?}: {case}");
                worst = worst.max(1e3 * late);
            }
        }
        let row = row_of(kind, knowledge, drive, reasons, may_hide, longest);
        assert!(PAGE.contains(&row), "the page lacks: {row}");
        let case = format!("{kind:?} {drive:?} {knowledge:?}");
        assert!(hidden <= may_hide, "{hidden}: {case}");
        assert!(worst <= f64::from(longest + 1), "{worst} ms: {case}");
    }
}
