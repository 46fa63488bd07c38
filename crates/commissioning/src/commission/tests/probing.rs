use std::vec::Vec;

use super::unknown_servos::{Probed, Unknown, unknown_servos};
use crate::commission::{
    CommissionError, CommissionInputs, CommissionIsr, CommissionSettings, Limits, Phase, Probing,
};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use virtual_servo::{Effects, Encoder, Servo};

#[test]
fn travel_and_speed_are_kept_by_every_unknown_servo_and_nearly_all_end_with_evidence() {
    let (mut servos, mut at_rest) = (0, 0);
    let motions = unknown_servos()
        .flat_map(|unknown| [unknown.probe(), unknown.probe_released()].map(|it| (unknown, it)));
    for (unknown, moved) in motions {
        let Probed {
            progress,
            travel,
            speed,
            evidence,
            ..
        } = moved;
        assert!(travel < 1.0, "travel {travel:.3}: {unknown:?}");
        assert!(speed < 1.0, "speed {speed:.3}: {unknown:?}");
        servos += 1;
        match progress {
            Some(Ok(())) => {
                at_rest += 1;
                assert!(evidence.is_some_and(|time| time <= 1.0));
            }
            // Refused; only a coarse encoder may need more than a second.
            Some(Err(Reason::TooLittleEvidence)) => {
                assert!(unknown.counts < 4096.0, "{unknown:?}");
            }
            // It stands, and moves off.
            Some(Err(Reason::Oscillating)) => {}
            _ => panic!("{progress:?}: {unknown:?}"),
        }
    }
    println!("{at_rest} of {servos} at rest with evidence");
    assert!(100 * at_rest >= 99 * servos, "{at_rest} of {servos}");
}

#[test]
fn a_fine_encoder_gives_evidence_in_a_fifth_of_a_second() {
    for (sample_time, allowed) in [(1e-3, 0.16), (2.5e-4, 0.15), (1e-4, 0.15)] {
        let mut times: Vec<f64> = unknown_servos()
            .filter(|unknown| unknown.counts >= 4096.0 && unknown.is_sampled_every(sample_time))
            .map(|unknown| unknown.probe().evidence.unwrap_or(f64::INFINITY))
            .collect();
        times.sort_by(f64::total_cmp);
        let [median, most] = [0.5, 0.9].map(|part| times[(part * times.len() as f64) as usize]);
        println!("{sample_time} s: median {median:.3} s, 90 % {most:.3} s");
        assert!(median < 0.13 && most < allowed, "{median} {most}");
    }
}

#[test]
fn a_speed_limit_far_below_the_servo_s_own_is_kept() {
    let mut fastest = 0.0_f64;
    // In a millisecond the strongest pass half of the limit.
    let ordinary = |unknown: &Unknown| unknown.counts >= 10_000.0 && unknown.sample_time < 5e-4;
    for mut unknown in unknown_servos().filter(ordinary) {
        // A load that is held does not gain speed before it is known.
        unknown.held = Some(-unknown.parameters.load / unknown.parameters.b);
        unknown.limits.speed *= 0.4;
        let Probed {
            progress, speed, ..
        } = unknown.probe();
        assert!(speed < 1.0, "speed {speed:.3}: {unknown:?}");
        assert_eq!(progress, Some(Ok(())), "{unknown:?}");
        fastest = fastest.max(speed);
    }
    assert!(fastest > 0.5, "it is made use of: {fastest}");
}

#[test]
fn a_coarse_encoder_extends_the_experiment_until_the_evidence_suffices() {
    let longer = unknown_servos()
        .filter(|unknown| unknown.counts < 1500.0 && unknown.is_sampled_every(1e-4))
        .map(|coarse| {
            let fine = Unknown {
                counts: 65_536.0,
                ..coarse
            };
            let [coarse, fine] =
                [coarse, fine].map(|unknown| unknown.probe().evidence.unwrap_or(1.0));
            coarse / fine
        })
        .fold(0.0, f64::max);
    assert!(longer > 2.0, "{longer}");
}

/// A servo that coasts, under limits of its own.
fn coasting(parameters: ServoParameters, counts: f64, sample_time: f64, limits: Limits) -> Unknown {
    Unknown {
        parameters,
        effects: Effects::NONE,
        delay: 0.0,
        counts,
        sample_time,
        limits,
        held: None,
        between_edges: 0.0,
    }
}

/// The first count comes when the ramp has long been at the command limit.
#[test]
fn a_coarse_encoder_under_all_of_the_command_neither_leaves_the_travel_nor_is_jammed() {
    let parameters = ServoParameters::new(0.436, 2.0916, 30.63, -16.88);
    let limits = Limits {
        travel: [-0.5, 0.5],
        speed: 30.0,
        command: [-48.0, 48.0],
        duration: 1.0,
    };
    for part in 0..10 {
        let coarse = Unknown {
            between_edges: f64::from(part) / 10.0,
            ..coasting(parameters, 844.0, 1e-3, limits)
        };
        let moved = coarse.probe_released();
        assert!(moved.travel < 0.8, "{}: {coarse:?}", moved.travel);
        let reason = Some(Err(Reason::TooLittleEvidence));
        assert_eq!(moved.progress, reason, "{coarse:?}");
    }
}

#[test]
fn a_motion_ends_though_a_resonance_keeps_the_servo_from_rest() {
    let parameters = ServoParameters::new(5.5014, 283.98, 2.68, -26.25);
    let limits = Limits {
        travel: [-0.3, 0.3],
        speed: 6.46,
        command: [-1.0, 1.0],
        duration: 1.0,
    };
    let compliant = Unknown {
        effects: Effects {
            current_loop: 3.915e-4,
            resonance: 2000.58,
            resonance_damping: Some(0.0053),
            inertia_ratio: 0.813,
            ..Effects::NONE
        },
        delay: 2.0,
        ..coasting(parameters, 44_478.0, 1e-4, limits)
    };
    let moved = compliant.probe_released();
    let reason = Some(Err(Reason::NeverAtRest));
    assert_eq!(moved.progress, reason);
    assert!(moved.travel < 1.0, "{}", moved.travel);
}

/// The relay and the loop that holds it where it stops are too fast for the motor alone, four times as strong as both masses.
#[test]
fn a_relay_that_drives_a_resonance_ends_and_the_loop_after_it_gives_way() {
    let parameters = ServoParameters::new(0.16, 118.9, 250.0, 95.0);
    let limits = Limits::new([-1.47, 1.47], 29.7, [-10.0, 10.0]);
    let oscillating = Some(Err(Reason::Oscillating));
    for (hertz, progress) in [
        (80.0, oscillating),
        (95.0, oscillating),
        (112.8, oscillating),
    ] {
        let compliant = Unknown {
            effects: Effects {
                current_loop: 5.1e-5,
                resonance: core::f64::consts::TAU * hertz,
                resonance_damping: Some(0.0155),
                inertia_ratio: 0.72,
                ..Effects::NONE
            },
            delay: 1.08,
            ..coasting(parameters, 123_678.0, 1e-3, limits)
        };
        let moved = compliant.probe_released();
        assert_eq!(moved.progress, progress, "{hertz} Hz");
        assert!(moved.travel < 1.0 && moved.speed < 1.0, "{hertz} Hz");
    }
}

#[test]
fn a_servo_that_does_not_move_is_reported() {
    let mut jammed = Unknown::from_seed(1);
    jammed.held = None;
    jammed.parameters.load = 0.0;
    jammed.parameters.coulomb = 1.1 * jammed.parameters.b * Unknown::COMMAND;
    let moved = jammed.probe();
    assert_eq!(moved.progress, Some(Err(Reason::DoesNotMove)));
}

/// Outcome of the first motion of a servo with plain friction whose velocity a ratchet holds.
fn moved_with(ratchet: impl Fn(f64) -> f64) -> Option<Result<(), Reason>> {
    let unknown = Unknown {
        sample_time: 1e-3,
        held: None,
        ..Unknown::from_seed(2)
    };
    let probing = Probing::<f32>::new(&unknown.settings()).expect("allowed");
    let (b, time) = (unknown.parameters.b, unknown.sample_time);
    let coulomb = 0.1 * b * Unknown::COMMAND;
    let mut state = probing.start(None);
    let (mut position, mut velocity, mut last) = (0.0_f64, 0.0_f64, 0.0);
    (0..3000).find_map(|_| {
        let count = (position / unknown.resolution()).floor();
        let command = probing.control(&mut state, (count - last) as f32);
        let progress = probing.learn(&mut state, (count - last) as f32);
        last = count;
        let push = b * f64::from(command);
        let motion_direction = if velocity == 0.0 { push } else { velocity }.signum();
        let response_motions = velocity != 0.0 || push.abs() > coulomb;
        let pushed = velocity
            + if response_motions {
                (push - coulomb * motion_direction) * time
            } else {
                0.0
            };
        // It stops where it would turn.
        velocity = if pushed * motion_direction < 0.0 {
            0.0
        } else {
            ratchet(pushed)
        };
        position += velocity * time;
        progress
    })
}

#[test]
fn a_servo_that_moves_in_one_direction_only_is_reported() {
    let failed = |reason| Some(Err(reason));
    assert_eq!(moved_with(|velocity| velocity), Some(Ok(())));
    let forwards = moved_with(|velocity| velocity.max(0.0));
    assert_eq!(forwards, failed(Reason::DoesNotMove));
    // It sticks for good once it has come to rest.
    let moved = std::cell::Cell::new(false);
    let stuck = std::cell::Cell::new(false);
    let sticks = moved_with(|velocity| {
        stuck.set(stuck.get() || moved.get() && velocity <= 0.0);
        moved.set(moved.get() || velocity > 0.0);
        if stuck.get() { 0.0 } else { velocity }
    });
    assert_eq!(sticks, failed(Reason::DoesNotMove));
}

#[test]
fn limits_that_are_too_small_are_refused_with_the_figure_that_would_do() {
    let coarse = Unknown {
        counts: 1000.0,
        ..Unknown::from_seed(2)
    };
    let mut narrow = coarse.settings();
    narrow.limits.travel = [-0.001, 10.0];
    let Err(CommissionError::TravelTooSmall { needed, .. }) = Probing::<f32>::new(&narrow) else {
        panic!("too little travel")
    };
    narrow.limits.travel[0] = -1.001 * needed;
    assert!(Probing::<f32>::new(&narrow).is_ok());
    let mut slow = coarse.settings();
    slow.limits.speed = 1e-6;
    let Err(CommissionError::SpeedTooSmall { needed, .. }) = Probing::<f32>::new(&slow) else {
        panic!("too little speed")
    };
    slow.limits.speed = 1.001 * needed;
    assert!(Probing::<f32>::new(&slow).is_ok());
}

#[test]
fn a_servo_that_may_pass_the_speed_limit_in_few_samples_is_refused_with_what_would_do() {
    let settings = Unknown::from_seed(2).settings();
    let strong = |time_factor: f64, command_factor: f64| {
        // A sixth of the speed limit in a sample.
        let gain = settings.limits.speed / (6.0 * Unknown::COMMAND * settings.sample_time);
        let mut strong = CommissionSettings {
            sample_time: time_factor * settings.sample_time,
            max_gain: Some(gain),
            ..settings
        };
        strong.limits.command = strong.limits.command.map(|limit| command_factor * limit);
        Probing::<f32>::new(&strong).map(|_| ())
    };
    let Err(CommissionError::TooStrong { most, command, .. }) = strong(1.0, 1.0) else {
        panic!("too strong")
    };
    let [by_time, by_command] = [most / settings.sample_time, command / Unknown::COMMAND];
    assert!((by_time - 0.9).abs() < 1e-9 && (by_command - 0.9).abs() < 1e-9);
    assert_eq!(strong(0.999 * by_time, 1.0), Ok(()));
    assert_eq!(strong(1.0, 0.999 * by_command), Ok(()));
}

#[test]
fn a_stated_gain_bounds_how_far_a_stuck_encoder_lets_an_axis_go() {
    let limits = Limits::new([-3.0, 3.0], 50.0, [-2.0, 1.0]);
    let mut settings = CommissionSettings::new(1e-4, 1e-4, limits);
    assert_eq!(settings.largest_motion().unseen, None);
    settings.max_gain = Some(400.0);
    // ½ b u t², t being at most 0.15 s.
    for (duration, distance) in [(2.0, 9.0), (0.1, 4.0)] {
        settings.limits.duration = duration;
        let unseen = settings.largest_motion().unseen.expect("bounded");
        assert!((unseen - distance).abs() < 1e-9, "{duration} s: {unseen}");
    }
}

/// The break-away of an axis that rubs less in motion looks like a multiple of its gain, which would hardly brake it.
#[test]
fn an_axis_that_rubs_nearly_twice_as_much_at_rest_is_caught_within_its_travel() {
    for counts in [2000.0, 10_000.0, 65_536.0] {
        for (sample_time, low_speed_velocity) in [(1e-3, 0.4), (2.5e-4, 0.1), (1e-4, 0.2)] {
            let unknown = Unknown {
                parameters: ServoParameters::new(3.0, 4000.0, 7000.0, 4000.0),
                effects: Effects {
                    low_speed_friction: 5500.0,
                    low_speed_velocity,
                    ..Effects::NONE
                },
                delay: 0.5,
                counts,
                sample_time,
                limits: Limits::new([-0.9, 0.9], 84.0, [-10.0, 10.0]),
                held: Some(-1.0),
                between_edges: 0.3,
            };
            let moved = unknown.probe();
            println!(
                "{counts} {sample_time} {low_speed_velocity}: {:.3?}",
                moved.reached
            );
            assert!(
                moved.travel < 1.0,
                "{counts} {sample_time}: {:?}",
                moved.reached
            );
            assert!(moved.has_broken_away, "{counts} {sample_time}");
        }
    }
}

/// While nothing decides. Friction at rest has the loop that holds it slip about its place by some counts for ever, and with
/// less bandwidth by more.
#[test]
fn an_axis_that_hunts_while_it_is_held_waits_where_friction_holds_it() {
    const LONG: f64 = 12.0;
    let (time, counts) = (2.5e-4, 20_000.0);
    let limits = Limits::new([-0.9, 0.9], 84.0, [-10.0, 10.0]);
    let settings = CommissionSettings::new(time, std::f64::consts::TAU / counts, limits);
    let isr = CommissionIsr::<f32>::new(&settings, None).expect("allowed");
    let sticks = Effects {
        low_speed_friction: 3480.0,
        low_speed_velocity: 0.5,
        ..Effects::NONE
    };
    let parameters = ServoParameters::new(6.3, 1850.0, 2650.0, 940.0);
    let mut servo = Servo::at_rest(&parameters, &sticks, time, 1).expect("a servo");
    let (encoder, mut state) = (Encoder::new(counts), isr.start(0, None));
    let mut late = [i32::MAX, i32::MIN];
    for sample in 0..(LONG / time) as u32 {
        let count = encoder.read(servo.position()) as i32;
        if f64::from(sample) * time > 0.5 * LONG {
            late = [late[0].min(count), late[1].max(count)];
        }
        let inputs = CommissionInputs {
            count: Some(count),
            late: false,
            stop: None,
        };
        let step = isr.process(&mut state, &inputs);
        servo.advance(step.command.unwrap_or(0.0).into());
    }
    println!("{:?} {late:?}", state.phase());
    assert_eq!(state.phase(), Phase::Fit);
    assert!(late[1] - late[0] <= 2, "{late:?}");
}
