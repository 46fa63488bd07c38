use commissioning::{CommissionError, CommissionIsr, HoldingGains, Phase};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::Goal;
use virtual_servo::SplitMix64;

use crate::faults::PHASES;
use crate::rig::{Background, Bench, ordinary};

/// Gains that have held the servo so far: slow, and safe.
pub(crate) fn before() -> HoldingGains {
    HoldingGains {
        controller: ControllerSettings::pid(4.0, 0.15, 4.0).limited(10.0),
        cutoff: 300.0,
    }
}

fn beside_a_controller() -> Bench {
    Bench {
        before: Some(before()),
        ..ordinary()
    }
}

#[test]
fn an_ordinary_servo_ends_with_new_gains_that_keep_their_prediction() {
    for bench in [ordinary(), beside_a_controller()] {
        let course = bench.commission(&mut |_| None);
        println!("{:?}", course.phases);
        println!("{:?} {:?}", course.state.reason(), course.state.trial());
        println!("{:?}", course.state.servo());
        println!("{:?}", course.state.tuning());
        println!("{:?} {} {:?}", course.travel, course.speed, course.command);
        let limits = &bench.settings.limits;
        let within = |[low, high]: [f64; 2], [least, most]: [f64; 2]| low >= least && high <= most;
        assert!(within(course.travel, limits.travel) && within(course.command, limits.command));
        assert!(course.travel[1] > 0.02 && course.speed > 0.2 && course.speed <= limits.speed);
        assert_eq!(course.state.phase(), Phase::Applied);
        let mut seen: Vec<_> = course.phases.iter().map(|(phase, _)| *phase).collect();
        let expected = [&[Phase::Idle], &PHASES[..], &[Phase::Applied]].concat();
        // Gains may ask for further lines, once.
        let further = [Phase::FrequencyResponse, Phase::Gains];
        if seen.len() > expected.len() && seen[6..8] == further {
            seen.drain(6..8);
        }
        assert_eq!(seen, expected);
    }
}

#[test]
fn a_sound_servo_is_predicted_from_any_rest_between_two_counts() {
    for k in 0..60 {
        let mut bench = ordinary();
        bench.set_counts(65_536.0);
        bench.settings.goal = Goal::Bandwidth(100.0);
        bench.offset = f64::from(k) / 60.0;
        bench.servo.coulomb = f64::from(k % 7) * 8.0;
        bench.servo.load = f64::from(k % 11) * 8.0;
        let course = bench.commission(&mut |_| None);
        let state = &course.state;
        assert_eq!(state.phase(), Phase::Applied, "{k} {:?}", state.reason());
    }
}

#[test]
fn a_servo_held_by_friction_is_commissioned_whenever_the_solver_decides() {
    let mut random = SplitMix64::new(26);
    for seed in 0..60 {
        let mut bench = ordinary();
        bench.servo.load = random.uniform(-2.0, 2.0) * bench.servo.coulomb;
        bench.offset = random.next_uniform();
        bench.settings.goal = Goal::Bandwidth(40.0);
        bench.settings.limits.travel = [-1.0, 1.0];
        bench.background = Background::Busy(seed);
        let course = bench.commission(&mut |_| None);
        assert_eq!(course.state.reason(), None, "{seed}");
    }
}

/// Servos that full command takes to half of their speed in a sample, with a delay of two samples and a load that friction
/// does not hold: one with a fine encoder, one with a coarse one.
#[test]
fn a_strong_servo_that_falls_when_it_is_released_is_caught_within_its_speed() {
    let fine = (16.7, 4260.0, 372.5, 5694.7, 1.747e-3, 131_072.0);
    let coarse = (8.25, 4350.6, 2669.8, 12_607.5, 2e-3, 4096.0);
    for (a, b, coulomb, load, delay, counts) in [fine, coarse] {
        let mut bench = ordinary();
        bench.servo = ServoParameters::new(a, b, coulomb, load);
        bench.effects.delay = delay;
        bench.set_counts(counts);
        bench.settings.limits.travel = [-0.9, 0.9];
        bench.settings.limits.speed = 84.35;
        for place in 0..8 {
            bench.offset = f64::from(place) / 8.0;
            let course = bench.commission(&mut |_| None);
            let speed = course.speed / bench.settings.limits.speed;
            assert_eq!(course.state.reason(), None, "{counts} {place}");
            assert!(speed < 1.0, "{counts} {place} {speed}");
        }
    }
}

/// Stops a commissioning in each phase, some samples after it began.
fn stopped_in_each_phase(bench: &Bench, reason: Reason) {
    for phase in &PHASES {
        let mut left = 5;
        let course = bench.commission(&mut |now| {
            left -= i32::from(now == *phase);
            (left == 0).then_some(reason)
        });
        let expected = if *phase == Phase::Trial {
            Phase::RolledBack
        } else {
            Phase::Aborted
        };
        assert_eq!(course.state.phase(), expected, "in {phase:?}");
        assert_eq!(course.state.reason(), Some(reason));
        let held = course.after.iter().all(Option::is_some);
        let released = course.after.iter().all(Option::is_none);
        if bench.before.is_some() && !reason.disables_stage() {
            assert!(held, "the gains before hold again, in {phase:?}");
            assert!(course.last.abs() < 0.02, "{phase:?} {}", course.last);
        } else {
            assert!(released, "it is released, in {phase:?}");
        }
    }
}

#[test]
fn a_stop_restores_the_gains_before_in_the_same_sample() {
    for reason in [Reason::ModeChanged, Reason::Stopped] {
        stopped_in_each_phase(&beside_a_controller(), reason);
        stopped_in_each_phase(&ordinary(), reason);
    }
}

#[test]
fn a_stop_after_the_end_disables_whatever_holds_the_servo() {
    for stopped_in in [None, Some(Phase::Fit)] {
        for (reason, disables) in [(Reason::Stopped, true), (Reason::ModeChanged, false)] {
            let mut ended = 0;
            let course = beside_a_controller().commission(&mut |phase| {
                ended += u32::from(phase.is_end());
                let stops = Some(phase) == stopped_in;
                match ended {
                    0 => stops.then_some(Reason::ModeChanged),
                    50 => Some(reason),
                    _ => None,
                }
            });
            let (held, later) = course.after.split_at(49);
            assert!(held.iter().all(Option::is_some), "{stopped_in:?}");
            let is_held = |command: &Option<f64>| command.is_some() != disables;
            let is_right = later[1..].iter().all(is_held);
            assert!(is_right, "{stopped_in:?} {reason:?}");
        }
    }
}

#[test]
fn the_gains_before_resume_with_the_command_that_held_the_load() {
    let mut bench = beside_a_controller();
    bench.servo.load = 200.0;
    let mut left = 5;
    let course = bench.commission(&mut |now| {
        left -= i32::from(now == Phase::Gains);
        (left == 0).then_some(Reason::ModeChanged)
    });
    assert_eq!(course.state.phase(), Phase::Aborted);
    let [Some(first), ..] = course.after[..] else {
        panic!("it is held");
    };
    let held = -bench.servo.load / bench.servo.b;
    assert!((first / held - 1.0).abs() < 0.1, "{first} {held}");
}

/// They are tried as they stay in force, and their step rises faster.
#[test]
fn gains_with_a_feed_forward_are_looked_for_where_that_is_asked_for() {
    let rises = [false, true].map(|feed_forward| {
        let mut bench = ordinary();
        bench.settings.feed_forward = feed_forward;
        let state = bench.commission(&mut |_| None).state;
        assert_eq!(state.phase(), Phase::Applied, "{:?}", state.reason());
        let led = state.tuning().expect("gains").feed_forward;
        assert_eq!(led.is_some(), feed_forward);
        let measured = state.trial().expect("they were tried").rise_time;
        measured.expect("it rose")
    });
    assert!(rises[1] < 0.7 * rises[0], "{rises:?}");
}

/// Wherever in a motion it is stopped: their integral does not take the motion for a load.
#[test]
fn the_gains_before_brake_a_servo_that_moves() {
    let bench = beside_a_controller();
    let motion = bench.commission(&mut |_| None);
    let [began, ended] = [Phase::Probe, Phase::Fit].map(|phase| motion.began(phase));
    let lasting = ended.expect("it moved") - began.expect("it moved");
    for place in 1..16 {
        let stop = f64::from(place) / 16.0 * lasting / bench.settings.sample_time;
        let mut left = stop as i32;
        let course = bench.commission(&mut |now| {
            left -= i32::from(now == Phase::Probe);
            (left == 0).then_some(Reason::ModeChanged)
        });
        assert_eq!(course.state.phase(), Phase::Aborted);
        let [low, high] = bench.settings.limits.travel;
        let [lowest, highest] = course.travel;
        assert!(
            lowest > low && highest < high,
            "{place}: {lowest} {highest}"
        );
    }
}

#[test]
fn a_late_decision_changes_nothing() {
    let mut stopped = false;
    let course = ordinary().commission(&mut |phase| {
        let now = phase == Phase::Gains && !stopped;
        stopped |= now;
        now.then_some(Reason::LinkLost)
    });
    assert_eq!(course.state.phase(), Phase::Aborted);
    assert_eq!(course.state.reason(), Some(Reason::LinkLost));
    assert_eq!(course.state.trial(), None);
}

#[test]
fn a_bandwidth_beyond_the_sample_rate_is_refused_with_one_that_would_do() {
    for goal in [Goal::Bandwidth(2000.0), Goal::ResponseTime(2e-4)] {
        let mut bench = ordinary();
        bench.settings.goal = goal;
        let refused = CommissionIsr::<f32>::new(&bench.settings, None).expect_err("too fast");
        let CommissionError::TooFast { bandwidth, most } = refused else {
            panic!("{refused:?}");
        };
        assert!(bandwidth > 1900.0);
        bench.set_counts(131_072.0);
        bench.settings.goal = Goal::Bandwidth(most);
        for place in 0..16 {
            bench.offset = f64::from(place) / 16.0;
            let course = bench.commission(&mut |_| None);
            assert_eq!(course.state.phase(), Phase::Applied, "{most} {place}");
        }
    }
}

#[test]
fn a_sensitivity_that_the_tuner_refuses_is_refused_before_any_motion() {
    let allowed = [1.05, 1.1, 1.6, 3.0, 3.5, 4.0].map(|most| {
        let mut bench = ordinary();
        bench.settings.max_sensitivity = most;
        CommissionIsr::<f32>::new(&bench.settings, None).is_ok()
    });
    assert_eq!(allowed, [false, true, true, true, false, false]);
    let mut bench = ordinary();
    bench.settings.max_sensitivity = 3.0;
    assert_eq!(
        bench.commission(&mut |_| None).state.phase(),
        Phase::Applied
    );
}

/// It may have the gains before the servo is at rest after its last motion.
#[test]
fn a_background_of_any_speed_leaves_no_phase_out() {
    for slices in [1, 10, 2000] {
        let mut bench = ordinary();
        bench.background = Background::Steady(slices);
        let course = bench.commission(&mut |_| None);
        let seen: Vec<_> = course.phases.iter().map(|(phase, _)| *phase).collect();
        println!("{slices} {seen:?}");
        assert!(
            seen.ends_with(&[Phase::Gains, Phase::Trial, Phase::Applied]),
            "{slices} {seen:?}"
        );
    }
}
