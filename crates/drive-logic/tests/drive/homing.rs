//! Homing on a switch and on the encoder's index, and its bad inputs.

use core::f64::consts::{FRAC_PI_2, TAU};
use core::ops::Range;

use crate::support::commission::{ORDER, commission, commission_until, ended};
use crate::support::drive::{Drive, snapshots};
use crate::support::harms::Harm;
use crate::support::{Bench, COUNTS, Flash, HOMING, harms, settings};
use commissioning::Phase;
use drive_link::{
    Command, Ended, Fault, HoldingBrake, Home, Homing, Refusal, Report, Settings, State, Status,
};
use identifier_core::parameters::ServoParameters;

const SERVO: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 10.0,
    load: 0.0,
};

/// The same with the first index pulse behind the switch as home.
const BY_INDEX: Homing = Homing {
    index: true,
    ..HOMING
};

/// Angle of a count, rad.
const A_COUNT: f64 = TAU / COUNTS;

fn homed_by(homing: Homing) -> Settings {
    let mut wanted = settings();
    wanted.protection.travel = [-8.0, 8.0];
    wanted.homing = Some(homing);
    wanted
}

/// The same without a dither.
fn still_homed_by(homing: Homing) -> Settings {
    let mut wanted = homed_by(homing);
    wanted.dither.amplitude = 0.0;
    wanted
}

/// A run with these settings; the switch is closed in a range, rad.
fn running(settings: Settings, switch: Range<f64>) -> (Drive, &'static Bench) {
    let bench = Bench::new(&SERVO);
    *bench.home_switch.borrow_mut() = switch;
    let mut drive = Drive::boot(bench, &Flash::blank());
    drive.run_for(settings, 10);
    (drive, bench)
}

fn home(drive: &mut Drive) {
    home_while(drive, |_| {});
}

/// Goes home, with something before every sample.
fn home_while(drive: &mut Drive, mut before: impl FnMut(&Drive)) {
    drive.done(Command::Home);
    for _ in 0..60_000 {
        before(drive);
        drive.pass(1);
        drive.ask(Command::KeepAlive);
        if drive.status().home != Home::Sought {
            return;
        }
    }
    panic!("it never gets home");
}

impl Drive {
    /// From now on a servo of another gain.
    fn change(&self, b: f64) {
        self.bench.change(&ServoParameters { b, ..SERVO });
    }
}

/// The axis stands at a place, rad, to this.
fn assert_at(drive: &Drive, place: f64, within: f64) {
    let at = drive.position();
    assert!((at - place).abs() < within, "{at}");
}

/// The position by the drive's own count, with the place of its origin.
fn origin(drive: &mut Drive) -> f64 {
    drive.done(Command::Watch(1));
    let at = drive.position();
    let shown = snapshots(&drive.pass(2));
    drive.order(Command::Watch(0), 1);
    at - f64::from(shown[0].position)
}

#[test]
fn the_edge_of_the_switch_is_the_same_from_everywhere_to_a_count() {
    // Before the switch and on it, its edge is at −3.
    for begin in [0.0, 2.0, -2.9, -3.0, -3.2] {
        let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
        *bench.home_switch.borrow_mut() = -6.0..-3.0;
        bench.hold_at(begin);
        let mut drive = Drive::boot(bench, &flash);
        drive.run_for(homed_by(HOMING), 10);
        assert_eq!(drive.status().home, Home::Unknown);
        home(&mut drive);
        assert_eq!(drive.status().home, Home::Known, "from {begin}");
        let origin = origin(&mut drive);
        assert!(
            (origin + 1.0).abs() < 3.0 * A_COUNT,
            "from {begin}: {origin}"
        );
        // It stands where the switch closed.
        drive.pass(2000);
        assert_at(&drive, -3.0, 0.4);
        // Targets count from the origin.
        drive.order(Command::Target(1.5), 6000);
        assert_at(&drive, 0.5, 0.4);
    }
}

#[test]
fn the_index_pulse_behind_the_switch_is_home_to_a_count() {
    for (switch, index_at, wanted) in [
        // Both sides of the edge: the pulse on the switch does not count.
        (-6.0..-3.0, -2.0, -2.0),
        (-6.0..-3.0, -4.0, -4.0 + TAU),
        (-6.0..-3.0, FRAC_PI_2, FRAC_PI_2 - TAU + TAU),
    ] {
        let (mut drive, bench) = running(homed_by(BY_INDEX), switch);
        bench.index_at.set(Some(index_at));
        home(&mut drive);
        let (home, index_from_edge) = (drive.status().home, drive.status().index_from_edge);
        assert_eq!(home, Home::Known, "{index_at}");
        let from_edge = f64::from(index_from_edge.expect("both were found"));
        assert!((from_edge - wanted - 3.0).abs() < 0.01, "{from_edge}");
        let origin = origin(&mut drive);
        assert!(
            (origin - wanted - 2.0).abs() < 2.0 * A_COUNT,
            "{index_at}: {origin}"
        );
    }
}

#[test]
fn the_switch_is_left_and_approached_slowly_and_without_dither() {
    let mut wanted = homed_by(HOMING);
    wanted.dither.amplitude = 0.05;
    let (mut drive, bench) = running(wanted, -6.0..-3.0);
    let (mut fastest, mut nearest, mut has_left) = ([0.0_f64; 2], f64::INFINITY, false);
    home_while(&mut drive, |drive| {
        let now = drive.position();
        nearest = nearest.min(now);
        let fastest = &mut fastest[usize::from(has_left)];
        *fastest = fastest.max(bench.plant.borrow().velocity.abs());
        // Once it goes slowly off the switch.
        has_left |= nearest < -3.0 && now > -3.0;
    });
    assert_eq!(drive.status().home, Home::Known);
    assert!(has_left && fastest[1] < 0.3, "{fastest:?}");
    let sought = fastest[0] / HOMING.seek.abs();
    assert!((0.9..1.5).contains(&sought), "{fastest:?}");
    // The dither is back.
    drive.pass(100);
    let mut moved = 0.0_f64;
    let at = drive.position();
    for _ in 0..1000 {
        drive.pass(1);
        moved = moved.max((drive.position() - at).abs());
    }
    assert!(moved > 0.03, "{moved}");
}

#[test]
fn contacts_that_bounce_move_home_by_what_a_bounce_moves_the_axis() {
    let (mut drive, bench) = running(homed_by(HOMING), -6.0..-3.0);
    let mut k = 0;
    home_while(&mut drive, |drive| {
        // Every other sample, within 0.002 rad of the edge.
        let bounces = k % 2 == 0 && (drive.position() + 3.0).abs() < 0.002;
        let end = if bounces { -4.0 } else { -3.0 };
        *bench.home_switch.borrow_mut() = -6.0..end;
        k += 1;
    });
    let origin = origin(&mut drive);
    assert!((origin + 1.0).abs() < 0.01, "{origin}");
}

#[test]
fn a_disturbance_of_one_sample_is_no_switch() {
    let (mut drive, bench) = running(homed_by(HOMING), -6.0..-3.0);
    drive.order(Command::Home, 300);
    assert!(drive.position() > -2.0);
    *bench.home_switch.borrow_mut() = -6.0..6.0;
    drive.pass(1);
    *bench.home_switch.borrow_mut() = -6.0..-3.0;
    while drive.status().home == Home::Sought {
        drive.pass(1);
    }
    assert_eq!(drive.state(), State::Running);
    let origin = origin(&mut drive);
    assert!((origin + 1.0).abs() < 3.0 * A_COUNT, "{origin}");
}

#[test]
fn a_switch_that_is_stuck_is_a_fault_and_the_axis_stays_within_its_clearance_and_its_travel() {
    for (offset, high, farthest) in [(HOMING.offset, 8.0, 0.45..0.6), (0.0, 0.3, 0.29..0.301)] {
        let mut wanted = still_homed_by(Homing { offset, ..HOMING });
        wanted.protection.travel[1] = high;
        // Closed everywhere, as by a short circuit.
        let (mut drive, bench) = running(wanted, -100.0..100.0);
        drive.done(Command::Home);
        let mut gone = 0.0_f64;
        for _ in 0..10_000 {
            drive.pass(1);
            gone = gone.max(drive.position().abs());
        }
        let stuck = Fault::HomeSwitchStuck;
        assert_eq!(drive.state(), State::Faulted(stuck));
        assert_eq!(bench.held.get(), None);
        assert!(farthest.contains(&gone), "{gone}");
        assert_eq!(drive.status().home, Home::Unknown);
        assert!(stuck.to_string().contains("free the switch"));
        assert_eq!(drive.refusal(Command::Home), Refusal::NotRunning);
    }
}

#[test]
fn a_switch_that_never_closes_and_an_index_that_never_comes_are_faults() {
    for (homing, switch, fault) in [
        (HOMING, 0.0..0.0, Fault::HomeNotFound),
        (BY_INDEX, -6.0..-3.0, Fault::IndexNotFound),
        // At the other end, out of reach.
        (HOMING, 3.0..6.0, Fault::HomeNotFound),
    ] {
        let (mut drive, bench) = running(homed_by(homing), switch);
        home(&mut drive);
        assert_eq!(drive.state(), State::Faulted(fault));
        assert_eq!(bench.held.get(), None);
    }
    // It closes once and never again.
    let (mut drive, bench) = running(homed_by(HOMING), -6.0..-3.0);
    drive.done(Command::Home);
    while drive.position() > -3.0 {
        drive.pass(1);
    }
    drive.pass(5);
    *bench.home_switch.borrow_mut() = 0.0..0.0;
    drive.pass(20_000);
    assert_eq!(drive.state(), State::Faulted(Fault::HomeNotFound));
}

#[test]
fn limits_faults_and_a_stop_hold_on_the_way_home() {
    let harms: [(Harm, State); 5] = [
        (harms::stop, State::Disabled),
        // The host falls silent.
        (
            |drive| drop(drive.pass(700)),
            State::Faulted(Fault::LinkLost),
        ),
        (harms::low_switch_opens, State::Faulted(Fault::LimitSwitch)),
        (harms::encoder_fails, State::Faulted(Fault::EncoderLost)),
        (
            |drive| drive.bench.plant.borrow_mut().position += 6.3,
            State::Faulted(Fault::FollowingError),
        ),
    ];
    for (harm, state) in harms {
        let mut wanted = homed_by(HOMING);
        wanted.protection.link_timeout = 0.5;
        let (mut drive, bench) = running(wanted, -6.0..-3.0);
        drive.order(Command::Home, 300);
        assert_eq!(drive.status().home, Home::Sought);
        harm(&mut drive);
        drive.pass(5);
        assert_eq!(bench.held.get(), None, "{state:?}");
        assert_eq!(drive.state(), state);
        assert_eq!(drive.status().home, Home::Unknown);
    }
}

#[test]
fn orders_in_the_wrong_state_are_refused_with_the_reason() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    assert_eq!(drive.refusal(Command::Home), Refusal::NotRunning);
    drive.order(Command::Start, 10);
    assert_eq!(drive.refusal(Command::Home), Refusal::NoHoming);
    drive.order(Command::Stop, 2);
    *bench.home_switch.borrow_mut() = -6.0..-3.0;
    drive.run_for(homed_by(HOMING), 10);
    drive.done(Command::Home);
    // Repeated, it is done already.
    drive.done(Command::Home);
    assert_eq!(drive.refusal(Command::Target(1.0)), Refusal::Homing);
    let refused = drive.refusal(Command::Commission(ORDER));
    assert_eq!(refused, Refusal::Homing);
    drive.pass(50);
    assert_eq!(drive.refusal(Command::Target(1.0)), Refusal::Homing);
}

#[test]
fn the_origin_holds_for_later_runs_until_the_count_is_uncertain() {
    let (mut drive, bench) = running(homed_by(HOMING), -6.0..-3.0);
    home(&mut drive);
    drive.order(Command::Stop, 2);
    assert_eq!(drive.status().home, Home::Known);
    // Turned by hand meanwhile.
    bench.hold_at(0.7);
    drive.pass(2);
    drive.order(Command::Start, 10);
    let place = origin(&mut drive);
    assert!((place + 1.0).abs() < 3.0 * A_COUNT, "{place}");
    // The travel counts from there too.
    drive.order(Command::Stop, 2);
    bench.hold_at(7.5);
    drive.order(Command::Start, 5);
    assert_eq!(drive.state(), State::Faulted(Fault::TravelLeft));
    assert_eq!(drive.status().home, Home::Unknown);
}

/// A homed axis at rest in a run; the origin is at −1.
fn homed(settings: Settings) -> (Drive, &'static Bench) {
    let (mut drive, bench) = running(settings, -6.0..-3.0);
    home(&mut drive);
    drive.done(Command::Target(0.0));
    for _ in 0..3000 {
        assert_eq!(drive.status().home, Home::Known);
        drive.ask(Command::KeepAlive);
        drive.pass(1);
    }
    (drive, bench)
}

#[test]
fn home_stays_known_after_each_end_that_has_earned_it_and_after_no_other() {
    let (known, lost) = (Home::Known, Home::Unknown);
    let harms: [(Option<Fault>, Home, Harm); 15] = [
        (None, known, harms::stop),
        (Some(Fault::LimitSwitch), known, harms::low_switch_opens),
        (Some(Fault::SupplyLow), lost, harms::supply_sags),
        (Some(Fault::AmplifierFault), known, harms::amplifier_fails),
        (Some(Fault::Overrun), known, harms::samples_are_late),
        (Some(Fault::LinkLost), known, |drive| {
            drive.pass(1500);
        }),
        (Some(Fault::LimitSwitchesStuck), known, |drive| {
            drive.order(Command::Stop, 2);
            drive.lines(|lines| lines.high_switch = false);
            drive.done(Command::Start);
        }),
        (Some(Fault::FollowingError), lost, |drive| {
            drive.bench.hold_at(2.5)
        }),
        (Some(Fault::TravelLeft), lost, |drive| {
            drive.bench.hold_at(7.5)
        }),
        (Some(Fault::SpeedExceeded), lost, |drive| {
            drive.bench.hold_at(0.5)
        }),
        (Some(Fault::ActuatorFailed), lost, harms::stage_fails),
        (Some(Fault::EncoderLost), lost, harms::encoder_fails),
        // At rest.
        (Some(Fault::ActuatorFailed), lost, |drive| {
            drive.order(Command::Stop, 50);
            drive.bench.releases.set(false);
        }),
        // And for a sample.
        (None, lost, |drive| {
            drive.order(Command::Stop, 50);
            harms::encoder_fails(drive);
            drive.pass(1);
            harms::repaired(drive);
        }),
        (None, lost, |drive| {
            drive.order(Command::Stop, 50);
            harms::supply_sags(drive);
            drive.pass(1);
            harms::repaired(drive);
        }),
    ];
    for (fault, after, harm) in harms {
        let mut wanted = still_homed_by(HOMING);
        wanted.protection.link_timeout = 1.0;
        (wanted.protection.following_error, wanted.protection.speed) = match fault {
            Some(Fault::FollowingError) => (3.0, 1e4),
            Some(Fault::SpeedExceeded) => (16.0, 100.0),
            _ => (16.0, 1e4),
        };
        let (mut drive, _) = homed(wanted);
        harm(&mut drive);
        drive.pass(20);
        let wanted = fault.map_or(State::Disabled, State::Faulted);
        assert_eq!(drive.state(), wanted);
        assert_eq!(drive.status().home, after, "{fault:?}");
    }
    // The end of its time, and another order.
    let mut wanted = homed_by(HOMING);
    wanted.protection.duration = 20.0;
    let (mut drive, _) = running(wanted, -6.0..-3.0);
    home(&mut drive);
    assert_eq!(drive.status().home, Home::Known);
    drive.pass(20_000);
    let Status { home, ended, .. } = drive.status();
    assert_eq!((home, ended), (Home::Known, Some(Ended::Over)));
}

#[test]
fn a_run_that_was_ordered_when_home_was_lost_has_none() {
    let (mut drive, _) = homed(still_homed_by(HOMING));
    drive.order(Command::Stop, 50);
    harms::encoder_fails(&mut drive);
    // Its report is not heard yet.
    drive.sample();
    harms::repaired(&mut drive);
    drive.order(Command::Start, 5);
    drive.order(Command::Stop, 5);
    assert_eq!(drive.status().home, Home::Unknown);
}

#[test]
fn an_axis_whose_brake_opens_goes_home_afterwards() {
    let mut wanted = homed_by(HOMING);
    wanted.brake = Some(HoldingBrake {
        opens: 0.05,
        closes: 0.1,
    });
    let (mut drive, _) = running(wanted, -6.0..-3.0);
    home(&mut drive);
    assert_eq!(drive.status().home, Home::Known);
}

#[test]
fn a_target_from_home_is_refused_until_home_is_known_and_a_relative_one_is_not() {
    let (mut drive, _) = running(still_homed_by(HOMING), -6.0..-3.0);
    for radians in [1.0, 0.0, f64::NAN] {
        assert_eq!(drive.refusal(Command::Target(radians)), Refusal::NotHomed);
    }
    drive.order(Command::RelativeTarget(1.0), 2000);
    assert_at(&drive, 1.0, 0.01);
    // Repeated, it has no further effect.
    drive.order(Command::RelativeTarget(1.0), 500);
    assert_at(&drive, 1.0, 0.01);
    let too_far = Refusal::TooFar {
        within: [-8.0, 8.0],
    };
    assert_eq!(drive.refusal(Command::RelativeTarget(8.1)), too_far);
    home(&mut drive);
    // The origin is at −1.
    drive.order(Command::Target(0.5), 3000);
    assert_at(&drive, -0.5, 0.01);
    drive.order(Command::RelativeTarget(0.5), 3000);
    assert_at(&drive, 0.5, 0.01);
    let Refusal::TooFar {
        within: [low, high],
    } = drive.refusal(Command::RelativeTarget(7.1))
    else {
        panic!("beyond the travel from home");
    };
    assert!(
        (low + 9.0).abs() < 0.01 && (high - 7.0).abs() < 0.01,
        "{low} {high}"
    );
    // An axis without homing counts from its start, as ever.
    let mut without = still_homed_by(HOMING);
    without.homing = None;
    drive.order(Command::Stop, 100);
    drive.run_for(without, 10);
    drive.done(Command::Target(0.5));
}

#[test]
fn an_index_pulse_near_the_switch_is_refused_as_home_and_its_distance_reported() {
    for (index_at, is_fault) in [
        (-2.99, true),
        (-3.0 + 0.77, true),
        (-3.0 + 0.80, false),
        (-3.0 - 0.80, false),
        (-3.0 - 0.77, true),
        (-3.01, true),
    ] {
        let (mut drive, bench) = running(homed_by(BY_INDEX), -6.0..-3.0);
        bench.index_at.set(Some(index_at));
        home(&mut drive);
        let (home, index_from_edge) = (drive.status().home, drive.status().index_from_edge);
        let turn = if index_at < -3.0 { TAU } else { 0.0 };
        let wanted = index_at + turn + 3.0;
        let from_edge = f64::from(index_from_edge.expect("both were found"));
        assert!((from_edge - wanted).abs() < 0.01, "{index_at}: {from_edge}");
        if is_fault {
            let fault = State::Faulted(Fault::IndexAtSwitch);
            assert_eq!((drive.state(), home), (fault, Home::Unknown), "{index_at}");
        } else {
            assert_eq!(home, Home::Known, "{index_at}");
        }
    }
}

#[test]
fn lost_counts_show_at_the_next_index_pulse_in_this_run_and_in_a_later_one() {
    let wanted = still_homed_by(BY_INDEX);
    for lost in [0, 4, -4, 5, -5, 120] {
        for later in [false, true] {
            let (mut drive, bench) = running(wanted, -6.0..-3.0);
            bench.index_at.set(Some(-1.0));
            home(&mut drive);
            assert_eq!(drive.status().home, Home::Known);
            if later {
                drive.order(Command::Stop, 20);
            }
            // One from before, on another turn of a counter of 16 bits, is no evidence.
            bench.first.set(bench.first.get() - lost);
            if later {
                bench.index.set(Some(65_536 + 77));
                drive.order(Command::Start, 10);
            }
            // A revolution up and down again passes a pulse twice; the origin is at 1.
            for target in [6.5, -6.5] {
                if drive.state() == State::Running {
                    drive.order(Command::Target(target), 6000);
                }
            }
            let is_fault = lost.abs() > 4;
            let state = if is_fault {
                State::Faulted(Fault::IndexShifted)
            } else {
                State::Running
            };
            assert_eq!(drive.state(), state, "{lost} {later}");
            let home = if is_fault { Home::Unknown } else { Home::Known };
            assert_eq!(drive.status().home, home);
        }
    }
}

#[test]
fn another_offset_or_resolution_is_another_origin() {
    type Change = fn(&mut Settings);
    let changes: [(Change, Home); 3] = [
        (|_| {}, Home::Known),
        (
            |wanted| wanted.closed_loop.core.resolution *= 0.5,
            Home::Unknown,
        ),
        (
            |wanted| wanted.homing.as_mut().expect("it has one").offset = 1.0,
            Home::Unknown,
        ),
    ];
    for (change, after) in changes {
        let (mut drive, _) = homed(homed_by(HOMING));
        drive.order(Command::Stop, 100);
        let mut wanted = homed_by(HOMING);
        change(&mut wanted);
        drive.done(Command::Configure(wanted));
        assert_eq!(drive.status().home, after);
        drive.order(Command::Start, 10);
        let refusal = match drive.ask(Command::Target(0.0)) {
            Report::Refused { refusal, .. } => Some(refusal),
            _ => None,
        };
        let is_unknown = after == Home::Unknown;
        assert_eq!(refusal, is_unknown.then_some(Refusal::NotHomed));
    }
}

#[test]
fn a_homed_axis_outside_the_travel_does_not_start_and_both_are_said() {
    let (mut drive, bench) = homed(homed_by(HOMING));
    drive.order(Command::Stop, 2);
    bench.hold_at(7.5);
    drive.pass(2);
    let Refusal::OutsideTravel { position, travel } = drive.refusal(Command::Start) else {
        panic!("it is outside");
    };
    assert!((position - 8.5).abs() < 0.1, "{position}");
    assert_eq!(travel.map(f64::to_bits), [-8.0_f64, 8.0].map(f64::to_bits));
    bench.hold_at(6.0);
    drive.pass(2);
    drive.done(Command::Start);
}

#[test]
fn the_travel_counts_from_the_origin_in_the_run_that_has_found_it_too() {
    // The origin is at −1, and the travel 8.
    for (place, state) in [
        (6.9, State::Running),
        (7.1, State::Faulted(Fault::TravelLeft)),
        (-8.9, State::Running),
        (-9.1, State::Faulted(Fault::TravelLeft)),
    ] {
        let mut wanted = still_homed_by(HOMING);
        wanted.protection.following_error = 16.0;
        wanted.protection.speed = 1e4;
        let (mut drive, bench) = running(wanted, -6.0..-3.0);
        home(&mut drive);
        // By hand, slowly.
        let mut at = drive.position();
        while (at - place).abs() > 0.02 && drive.state() == State::Running {
            at += 0.02 * (place - at).signum();
            bench.hold_at(at);
            drive.pass(1);
        }
        assert_eq!(drive.state(), state, "{place} rad");
    }
}

#[test]
fn home_is_unknown_after_every_end_that_loses_the_position() {
    let stop: Harm = |_| {};
    let harms: [(Harm, &[u8]); 6] = [
        (harms::encoder_fails, &[20]),
        (|drive| drive.bench.stick(), &[101, 150, 154]),
        (
            |drive| drive.bench.plant.borrow_mut().position += 3.0,
            &[152],
        ),
        (|drive| drive.change(-SERVO.b), &[153]),
        (|drive| drive.change(1e-3), &[154]),
        (stop, &[171]),
    ];
    for beside in [false, true] {
        for (harm, numbers) in harms {
            let (mut drive, bench) = running(still_homed_by(HOMING), -6.0..-3.0);
            home(&mut drive);
            drive.order(Command::Target(0.0), 3000);
            if !beside {
                drive.order(Command::Stop, 100);
            }
            assert_eq!(drive.status().home, Home::Known);
            commission_until(&mut drive, ORDER, Phase::Probe);
            drive.pass(20);
            if numbers == [171] {
                drive.refusal(Command::Start);
            }
            harm(&mut drive);
            let reason = ended(&mut drive).commissioning.reason;
            let reason = reason.expect("it has not succeeded");
            assert!(numbers.contains(&reason.number()), "{numbers:?}: {reason}");
            let home = if numbers == [171] {
                Home::Known
            } else {
                Home::Unknown
            };
            assert_eq!(drive.status().home, home, "{reason}");
            if home == Home::Unknown && drive.state() != State::Running {
                // The next run does not count from there either.
                drive.done(Command::Clear);
                bench.sensor_works.set(true);
                drive.pass(2);
                drive.order(Command::Start, 1);
                assert_eq!(drive.status().home, Home::Unknown, "{reason}");
            }
        }
    }
}

#[test]
fn home_is_unknown_after_a_run_in_which_the_actuator_dies() {
    let (mut drive, _) = running(still_homed_by(HOMING), -6.0..-3.0);
    drive.order(Command::Stop, 100);
    commission(&mut drive, ORDER);
    drive.order(Command::Start, 10);
    home(&mut drive);
    assert_eq!(drive.status().home, Home::Known);
    drive.order(Command::Target(6.0), 300);
    drive.change(1e-3);
    drive.pass(1000);
    assert_eq!(drive.state(), State::Faulted(Fault::ActuatorDead));
    assert_eq!(drive.status().home, Home::Unknown);
}

/// Saves: home by the answer.
fn saved(drive: &mut Drive) -> Home {
    match drive.ask(Command::Save) {
        Report::Status { status, .. } => status.home,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_flash_is_erased_at_rest_alone_and_home_is_unknown_afterwards() {
    let (mut drive, bench) = running(homed_by(HOMING), -6.0..-3.0);
    let flash = drive.flash.clone();
    home(&mut drive);
    drive.order(Command::Stop, 2);
    // The axis coasts. Writing leaves the samples to follow it.
    bench.plant.borrow_mut().velocity = 40.0;
    drive.pass(30);
    let mut wanted = drive.shown();
    let mut change = |drive: &mut Drive| {
        wanted.protection.stop_time *= 1.01;
        drive.done(Command::Configure(wanted));
    };
    // What is kept already needs no flash, however often.
    for saves in 0..40 {
        if saves < 3 {
            change(&mut drive);
        }
        assert_eq!(saved(&mut drive), Home::Known);
        assert_eq!(flash.erased.get(), 0);
    }
    change(&mut drive);
    for order in [Command::Save, Command::Commission(ORDER)] {
        assert_eq!(drive.refusal(order), Refusal::NotAtRest);
        assert_eq!((flash.erased.get(), drive.status().home), (0, Home::Known));
    }
    while bench.plant.borrow().velocity > 0.5 {
        drive.pass(1);
    }
    assert_eq!(drive.refusal(Command::Save), Refusal::NotAtRest);
    drive.pass(200);
    // The answer itself says that home is lost.
    assert_eq!((saved(&mut drive), flash.erased.get()), (Home::Unknown, 1));
    // Meanwhile it was turned by 40 000 counts, of which a counter of 16 bits has lost a round.
    bench.hold_at(drive.position() + 40_000.0 * A_COUNT);
    bench.first.set(-65_536);
    let begin = drive.position();
    drive.order(Command::Start, 10);
    assert_eq!(drive.state(), State::Running);
    assert_eq!(drive.status().home, Home::Unknown);
    let place = origin(&mut drive);
    assert!((place - begin).abs() < 3.0 * A_COUNT, "{place} {begin}");
}

#[test]
fn a_run_between_two_saves_is_no_standstill() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    let mut wanted = settings();
    for _ in 0..3 {
        wanted.protection.stop_time *= 1.01;
        drive.done(Command::Configure(wanted));
        drive.done(Command::Save);
    }
    drive.pass(1000);
    drive.order(Command::Start, 10);
    drive.order(Command::Target(3.0), 300);
    // It is released in motion, where it has stood before.
    bench.hold_at(0.0);
    bench.plant.borrow_mut().velocity = 5.0;
    drive.order(Command::Stop, 1);
    assert_eq!(drive.state(), State::Disabled);
    assert_eq!(drive.refusal(Command::Save), Refusal::NotAtRest);
    // An encoder that gives nothing shows no standstill either.
    drive.pass(3000);
    bench.sensor_works.set(false);
    drive.pass(100);
    assert_eq!(drive.refusal(Command::Save), Refusal::NotAtRest);
    bench.sensor_works.set(true);
    drive.pass(30);
    drive.done(Command::Save);
}

#[test]
fn a_commissioning_beside_the_run_keeps_the_origin() {
    let (mut drive, _) = running(still_homed_by(HOMING), -6.0..-3.0);
    home(&mut drive);
    drive.order(Command::Target(0.0), 3000);
    assert_eq!(commission(&mut drive, ORDER).commissioning.reason, None);
    assert_eq!(drive.state(), State::Running);
    assert_eq!(drive.status().home, Home::Known);
    let place = origin(&mut drive);
    assert!((place + 1.0).abs() < 3.0 * A_COUNT, "{place}");
    drive.order(Command::Target(1.0), 3000);
    assert_at(&drive, 0.0, 0.05);
}

#[test]
fn home_is_where_the_switch_closed_and_not_where_its_bounces_were_over() {
    let wanted = still_homed_by(Homing {
        approach: 2.0,
        ..HOMING
    });
    let (mut drive, _) = running(wanted, -6.0..-3.0);
    home(&mut drive);
    assert_eq!(drive.status().home, Home::Known);
    let origin = origin(&mut drive);
    // A sample is 3.2 counts, and the switch must be closed for two more.
    assert!(
        (origin + 1.0).abs() < 4.2 * A_COUNT,
        "{}",
        (origin + 1.0) / A_COUNT
    );
}
