//! Settings and orders that are refused by the name of the number, with a figure that would do, before anything moves.

use core::f64::consts::TAU;

use crate::support::commission::{ORDER, SERVO};
use crate::support::drive::Drive;
use crate::support::{COUNTS, HOMING, SAMPLE_TIME, STAGE, first_contact, numbers, settings, still};
use commissioning::{CommissionSettings, Limits};
use drive_link::{
    Command, Estimator, HoldingBrake, NotAllowed, ServoChanges, Settings, TargetSource, Why,
};
use drive_logic::{MIN_SAMPLE_TIME, MIN_SAMPLE_TIME_WITH_TERMS};
use identifier_core::error::Allowed;
use identifier_core::parameters::{Term, Terms};
use identifier_core::tuning::Goal;

/// Settings in which all is stated that may be.
fn all_stated() -> Settings {
    let mut all = settings();
    all.protection.travel = [-8.0, 8.0];
    all.homing = Some(HOMING);
    all.source = TargetSource::Steps { step: 1e-3 };
    all.brake = Some(HoldingBrake {
        opens: 0.05,
        closes: 0.1,
    });
    all
}

/// Asserts that a number is refused under its name, with a range that has the value before and not the one that is refused.
fn assert_named(refused: &NotAllowed, name: &str, before: f64) {
    assert!(name.starts_with(refused.name.as_str()), "{name}: {refused}");
    if let Why::OutOfRange { given, allowed } = refused.why {
        // The low limit is refused by its size.
        let was_allowed = allowed.holds(before) || allowed.holds(-before);
        assert!(was_allowed && !allowed.holds(given), "{name}: {refused}");
    }
}

/// Numbers of settings, and values that each may not have.
const SETTINGS: [(&str, &[f64]); 25] = [
    ("kp", &[0.0, 1.0]),
    ("kd", &[f64::NAN]),
    ("ki", &[-1.0]),
    ("limit_high", &[0.0, 10.1]),
    ("limit_low", &[f64::NAN, -10.1, f64::NEG_INFINITY]),
    ("resolution", &[0.0]),
    ("sample_time", &[-1e-3, 0.0, 4.99e-5, 1.05e-3, f64::NAN]),
    ("sample_time", &[1.1e-4, 9.99e-4, 7.5e-5]),
    ("cutoff", &[0.0]),
    ("delay", &[0.0061]),
    ("initial.b", &[1e9]),
    ("gamma.a", &[-1.0]),
    ("hold", &[1e-4]),
    ("following_error", &[0.0, 0.89]),
    ("stall_time", &[f64::NAN]),
    ("travel.low", &[0.5, -0.59, f64::NAN]),
    ("travel.high", &[-0.5, 0.59, 1e6]),
    ("speed", &[4.9]),
    ("brake.closes", &[1.5]),
    ("brake.opens", &[1.001, -0.1]),
    ("homing.seek", &[0.0, f64::NAN, -101.0]),
    ("homing.approach", &[0.0, 3.1]),
    ("homing.clearance", &[7.5, 0.0]),
    ("homing.offset", &[-7.5]),
    ("source.step", &[0.0, f64::NAN, 8.1]),
];

#[test]
fn a_setting_out_of_range_is_refused_by_name_and_those_in_force_stay() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    for (name, values) in SETTINGS {
        for &given in values {
            let mut wanted = all_stated();
            let before = numbers::set(numbers::of_settings(&mut wanted), name, given);
            let refused = drive.not_allowed(Command::Configure(wanted));
            assert_named(&refused, name, before);
            assert_eq!(drive.shown(), settings());
        }
    }
    // Without gains too.
    let mut wanted = all_stated();
    wanted.closed_loop.core.controller = None;
    numbers::set(
        numbers::of_settings(&mut wanted),
        "homing.offset",
        f64::INFINITY,
    );
    let refused = drive.not_allowed(Command::Configure(wanted));
    assert_eq!(refused.name, "homing.offset");
    // The ends of the ranges.
    let mut slowest = all_stated();
    for (name, most) in [
        ("brake.opens", 1.0),
        ("brake.closes", 1.0),
        ("source.step", -7.4),
    ] {
        numbers::set(numbers::of_settings(&mut slowest), name, most);
    }
    drive.done(Command::Configure(slowest));
}

#[test]
fn a_setting_too_small_for_another_is_refused_with_both() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    for (name, given, wanted_least, beside) in [
        ("following_error", 0.89, 0.9, "dither's amplitude"),
        ("travel.high", 0.59, 0.6, "dither's amplitude"),
        ("speed", 4.9, 5.0, "pace"),
    ] {
        let mut wanted = settings();
        numbers::set(numbers::of_settings(&mut wanted), name, given);
        let refused = drive.not_allowed(Command::Configure(wanted));
        let Why::TooSmallFor { least, other, .. } = &refused.why else {
            panic!("{refused}");
        };
        assert!((least - wanted_least).abs() < 1e-9, "{refused}");
        assert_eq!(other, beside);
    }
}

#[test]
fn a_limit_that_no_sample_can_keep_is_refused_with_a_figure_that_would_do() {
    let longest = f64::from(u32::MAX) * SAMPLE_TIME;
    let (mut drive, _) = Drive::on_bench(&SERVO);
    for (name, most) in [
        // Beyond the whole travel it would end nothing.
        ("following_error", 102.0),
        ("speed", 32_767.0 * TAU / COUNTS / SAMPLE_TIME),
        ("breakaway", 1.0),
        ("stall_time", longest),
        ("stop_time", longest),
        ("duration", longest),
        ("link_timeout", 60.0),
    ] {
        let stated = |value: f64| {
            let mut wanted = still();
            numbers::set(numbers::of_settings(&mut wanted), name, value);
            Command::Configure(wanted)
        };
        let is_none_at_zero = ["duration", "link_timeout"].contains(&name);
        for given in [1.8e40, f64::MAX, f64::INFINITY, f64::NAN, -1.0, 0.0] {
            if given == 0.0 && is_none_at_zero {
                drive.done(stated(given));
                continue;
            }
            let refused = drive.not_allowed(stated(given));
            assert_eq!(refused.name, name);
            let Why::OutOfRange {
                allowed: Allowed::PositiveUpTo(named),
                ..
            } = refused.why
            else {
                panic!("{refused}");
            };
            assert!((named / most - 1.0).abs() < 1e-9, "{refused}");
            drive.done(stated(named));
        }
    }
}

#[test]
fn what_an_estimator_lacks_is_refused() {
    let terms = |mut wanted: Settings| {
        wanted.closed_loop.core.identifier.terms.demanded = Terms::NONE.with(Term::Delay);
        wanted
    };
    let (mut drive, _) = Drive::on_bench(&SERVO);
    // The gradient has neither terms nor standard errors.
    let mut reported = settings();
    reported.servo_changes = ServoChanges::Reported;
    let mut without_gains = terms(settings());
    without_gains.closed_loop.core.controller = None;
    for (name, wanted) in [
        ("required_terms", terms(settings())),
        ("required_terms", without_gains),
        ("servo_changes", reported),
    ] {
        let refused = drive.not_allowed(Command::Configure(wanted));
        assert_eq!(refused, NotAllowed::new(name, Why::NotHere));
    }
    // At the highest rate terms leave less than half of a sample.
    let mut fast = terms(first_contact());
    fast.closed_loop.core.sample_time = MIN_SAMPLE_TIME;
    let refusal = drive.refusal(Command::Configure(fast)).to_string();
    assert!(refusal.contains("at least 0.00015"), "{refusal}");
    fast.closed_loop.core.sample_time = MIN_SAMPLE_TIME_WITH_TERMS;
    fast.dither.hold = 300.0 * MIN_SAMPLE_TIME_WITH_TERMS;
    drive.done(Command::Configure(fast));
    for law in [Estimator::GaussNewton, settings().closed_loop.law] {
        for sample_time in [STAGE.period, 1e-3] {
            let mut wanted = settings();
            wanted.closed_loop.law = law;
            wanted.closed_loop.core.sample_time = sample_time;
            drive.done(Command::Configure(wanted));
        }
    }
}

#[test]
fn a_travel_without_the_start_is_refused_with_both_ends() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    for ends in [[0.5, 1.5], [-1.5, -0.5], [1.0, -1.0], [0.0, 0.0]] {
        let mut wanted = still();
        wanted.protection.travel = ends;
        let refused = drive.not_allowed(Command::Configure(wanted));
        assert_eq!(refused.why, Why::WithoutStart { given: ends });
    }
    let mut wanted = still();
    wanted.protection.travel = [0.0, 150.0];
    drive.done(Command::Configure(wanted));
}

/// Numbers of an order, and values that each may not have.
const ORDERS: [(&str, &[f64]); 8] = [
    ("sample_time", &[2e-3]),
    ("resolution", &[2.0 * TAU / COUNTS]),
    ("limit_high", &[10.1]),
    ("limit_low", &[-10.1]),
    ("travel.low", &[1.0, -1.8e40]),
    ("duration", &[1.8e40]),
    ("speed", &[1.8e40, f64::NAN]),
    ("max_sensitivity", &[0.5, 50.0]),
];

#[test]
fn an_order_to_commission_out_of_range_is_refused_by_name_before_anything_is_kept_or_moves() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    for (name, values) in ORDERS {
        for &given in values {
            let mut order = ORDER;
            let before = numbers::set(numbers::of_order(&mut order), name, given);
            let refused = drive.not_allowed(Command::Commission(order));
            assert_named(&refused, name, before);
        }
    }
    drive.pass(10);
    assert_eq!(bench.held.get(), None);
    assert_eq!(drive.flash.steps.get(), 0, "nothing was kept");
}

#[test]
fn the_delay_of_the_stage_adds_to_the_one_that_is_given() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    // The largest possible bandwidth is proportional to the inverse of half a sample plus the delay.
    let mut most = |command_delay: f64| {
        let order = CommissionSettings {
            command_delay,
            goal: Goal::Bandwidth(1e6),
            ..ORDER
        };
        match drive.not_allowed(Command::Commission(order)).why {
            Why::OutOfRange {
                allowed: Allowed::PositiveUpTo(most),
                ..
            } => most,
            other => panic!("{other:?}"),
        }
    };
    let ratio = most(0.0) / most(SAMPLE_TIME);
    let late = 0.5 * SAMPLE_TIME + STAGE.command_delay;
    let expected = (late + SAMPLE_TIME) / late;
    assert!((ratio - expected).abs() < 1e-9, "{ratio}");
}

/// A drive of a travel from −2 to `high`, a speed of 60 rad/s and a command of 5, and an order within all of them.
fn limited(high: f64) -> (Drive, CommissionSettings) {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let mut wanted = still();
    wanted.protection.travel = [-2.0, high];
    wanted.protection.following_error = 2.0;
    wanted.protection.speed = 60.0;
    let controller = wanted.closed_loop.core.controller.as_mut();
    controller.expect("given").limit = [-5.0, 5.0];
    drive.done(Command::Configure(wanted));
    let limits = Limits {
        duration: 2.0,
        ..Limits::new([-2.0, 2.0], 60.0, [-5.0, 5.0])
    };
    (drive, CommissionSettings { limits, ..ORDER })
}

/// States a limit of an order by name.
fn state(limits: &mut Limits, name: &str, ends: [f64; 2]) {
    match name {
        "travel" => limits.travel = ends,
        "speed" => limits.speed = ends[1],
        _ => limits.command = ends,
    }
}

#[test]
fn an_order_beyond_the_drives_limits_is_refused_with_both_and_no_limit_becomes_wider() {
    for (name, given, allowed) in [
        ("travel", [-2.001, 2.0], [-2.0, 2.5]),
        ("travel", [-0.5, 2.501], [-2.0, 2.5]),
        ("speed", [60.1, 60.1], [-60.0, 60.0]),
        ("command", [-5.1, 5.0], [-5.0, 5.0]),
        ("command", [-5.0, 5.1], [-5.0, 5.0]),
    ] {
        let (mut drive, mut order) = limited(2.5);
        state(&mut order.limits, name, given);
        let refused = drive.not_allowed(Command::Commission(order));
        let beyond = NotAllowed::new(name, Why::BeyondDrive { given, allowed });
        assert_eq!(refused, beyond);
        drive.pass(100);
        assert_eq!(drive.bench.held.get(), None);
    }
    for (name, ends) in [
        ("speed", [60.0, 60.0]),
        ("speed", [20.0, 20.0]),
        ("command", [-5.0, 2.0]),
        ("travel", [-1.0, 2.5]),
    ] {
        let (mut drive, mut order) = limited(2.5);
        state(&mut order.limits, name, ends);
        drive.done(Command::Commission(order));
    }
}

#[test]
fn an_order_from_within_the_travel_is_refused_if_it_leaves_it_from_there() {
    let (mut drive, mut order) = limited(2.0);
    drive.order(Command::Start, 10);
    drive.order(Command::Target(1.5), 3000);
    order.limits.travel = [-1.0, 1.0];
    let refused = drive.not_allowed(Command::Commission(order));
    let Why::BeyondDrive {
        allowed: [low, high],
        ..
    } = refused.why
    else {
        panic!("{refused}");
    };
    let are_from_there = (low + 3.5).abs() < 0.02 && (high - 0.5).abs() < 0.02;
    assert!(are_from_there, "{low} {high}");
    order.limits.travel = [-1.0, 0.45];
    drive.done(Command::Commission(order));
}
