use super::*;
use crate::control::{
    CommandLimit, ControlState, Controller, Notch, ReferenceFilter, Setpoint, Shaped,
};
use crate::measurement::velocity::{BackwardDifference, LowPass, VelocityEstimate};
use crate::number::{Number, RunningSum};
use proptest::prelude::*;

/// Sample times of 250 Hz, 1, 4 and 20 kHz.
const SAMPLE_TIMES: [f64; 4] = [4e-3, 1e-3, 250e-6, 50e-6];

/// ω_m, rad/s.
const OWN: f64 = 40.0;

const A: f64 = 3.0;
const B: f64 = 250.0;

const SETTINGS: FeedForwardSettings = FeedForwardSettings {
    bandwidth: OWN,
    acceleration: 1.0 / B,
    velocity: A / B,
    coulomb: 0.0,
    coulomb_speed: 0.1,
};

fn gains() -> Gains {
    Gains::new(9.0, 0.19, 60.0).expect("valid")
}

fn lead<N: Number>(units: &Units, settings: &FeedForwardSettings) -> FeedForward<N> {
    let velocity = VelocityEstimate::<f64>::transfer(&BackwardDifference);
    FeedForward::new(units, settings, &gains(), &velocity).expect("valid")
}

fn shaped<N: Number>(lead: FeedForward<N>) -> Shaped<N> {
    Shaped::new(ReferenceFilter::NONE, lead, Notch::NONE)
}

/// The step of one of the model.
fn shape(time: f64) -> f64 {
    let x = OWN * time;
    1.0 - (-x).exp() * (1.0 + x + 0.5 * x * x)
}

#[test]
fn the_model_steps_as_in_continuous_time_at_any_sample_rate() {
    const STEP: f64 = 5000.0;
    for sample_time in SAMPLE_TIMES {
        let units = Units::new(sample_time, 1e-3).expect("valid");
        let exact = lead::<f64>(&units, &SETTINGS);
        let single = lead::<f32>(&units, &SETTINGS);
        let mut state = FeedForward::at_rest(0.0);
        let mut single_state = FeedForward::at_rest(0.0);
        for k in 0..(1.0 / sample_time) as u32 {
            let expected = STEP * shape(f64::from(k) * sample_time);
            let (found, _) = exact.process(&mut state, STEP, 0.0);
            assert!((found - expected).abs() < 1e-9 * STEP, "{sample_time} {k}");
            let (found, _) = single.process(&mut single_state, STEP as f32, 0.0);
            let off = f64::from(found) - expected;
            assert!(off.abs() < 1e-5 * STEP, "{sample_time} {k}: {off}");
        }
    }
}

/// The servo moves under a held command by its closed form. q̇ + a q is the sum of the commands.
#[test]
fn a_servo_as_modelled_follows_the_model_at_any_sample_rate() {
    const STEP: f64 = 2.0;
    for sample_time in SAMPLE_TIMES {
        let units = Units::new(sample_time, 1.0).expect("valid");
        let controller = Controller::new(&units, &gains(), &CommandLimit::NONE, BackwardDifference)
            .with_shaping(shaped(lead(&units, &SETTINGS)));
        let undamped = Gains::new(9.0, 0.0, 60.0).expect("valid");
        let velocity = VelocityEstimate::<f64>::transfer(&BackwardDifference);
        let alone =
            FeedForward::<f64>::new(&units, &SETTINGS, &undamped, &velocity).expect("valid");
        let mut state = ControlState::default();
        let mut motion = FeedForward::at_rest(0.0);
        let (mut position, mut velocity, mut before, mut momentum) = (0.0, 0.0, 0.0, 0.0);
        let mut farthest = 0.0_f64;
        for k in 0..(1.0 / sample_time) as u32 {
            let time = f64::from(k) * sample_time;
            let sample = controller.process(&mut state, STEP - position, position - before);
            before = position;
            farthest = farthest.max((STEP * shape(time) - position).abs());
            let decay = (-A * sample_time).exp();
            let settled = B * sample.expect("in range").command / A;
            position += settled * sample_time + (velocity - settled) * (1.0 - decay) / A;
            velocity = settled + (velocity - settled) * decay;

            let (_, command) = alone.process(&mut motion, STEP, 0.0);
            momentum += B * command * sample_time;
            let x = OWN * (time + sample_time);
            let expected = OWN * 0.5 * x * x * (-x).exp() + A * shape(time + sample_time);
            let off = momentum - STEP * expected;
            assert!(off.abs() < 1e-10 * OWN * STEP, "{sample_time} {k}");
        }
        let rate = OWN * sample_time;
        // The largest ÿ/12, and what is left of b k_d ẏ, half of its second difference, if nothing brought the servo back.
        let bound = 0.2306 / 12.0 + 0.2707 / 2.0 * B * gains().kd() / OWN;
        let most = bound * rate * rate * STEP;
        assert!(farthest < most, "{sample_time}: {farthest}");
    }
}

/// The friction of a servo in motion is compensated in full, and that of one that stands not at all.
#[test]
fn friction_is_compensated_with_the_sign_of_the_motion() {
    let units = Units::new(1e-3, 1e-3).expect("valid");
    let rough = FeedForwardSettings {
        coulomb: 0.5,
        ..SETTINGS
    };
    let [smooth, rough] = [SETTINGS, rough].map(|settings| lead::<f32>(&units, &settings));
    for (sign, step) in [(1.0, 800.0), (-1.0, -800.0)] {
        let mut states = [FeedForward::at_rest(0.0); 2];
        let mut compensated = |k: u32| {
            let [smooth, rough] =
                [(&smooth, 0), (&rough, 1)].map(|(of, i)| of.process(&mut states[i], step, 0.0).1);
            (k, sign * (rough - smooth))
        };
        for (k, found) in (0..2000).map(&mut compensated) {
            if (5..150).contains(&k) {
                assert!((found - 0.5).abs() < 1e-5, "{k}: {found}");
            } else if k > 500 {
                assert!(found.abs() < 1e-4, "{k}: {found}");
            }
        }
    }
}

/// The command is at its limit for most of the step, and the servo arrives without overshooting for long.
#[test]
fn the_integral_does_not_wind_up_at_the_limit() {
    let sample_time = 1e-3;
    let units = Units::new(sample_time, 1.0).expect("valid");
    let step = |limit: CommandLimit| {
        let velocity = LowPass::new(&units, 400.0).expect("valid");
        let transfer = VelocityEstimate::<f64>::transfer(&velocity);
        let gains = Gains::new(7.0, 0.24, 65.0).expect("valid");
        let lead = FeedForward::<f64>::new(&units, &SETTINGS, &gains, &transfer).expect("valid");
        let controller = Controller::new(&units, &gains, &limit, velocity);
        let controller = controller.with_shaping(shaped(lead));
        let mut state = ControlState::default();
        let (mut position, mut velocity, mut before, mut most) = (0.0, 0.0, 0.0, 0.0_f64);
        for _ in 0..3000 {
            let sample = controller.process(&mut state, 1.0 - position, position - before);
            before = position;
            let acceleration = B * sample.expect("in range").command - A * velocity;
            position += sample_time * (velocity + 0.5 * sample_time * acceleration);
            velocity += sample_time * acceleration;
            most = most.max(position);
        }
        (most - 1.0, position - 1.0)
    };
    let (free, _) = step(CommandLimit::NONE);
    let (limited, left) = step(CommandLimit::symmetric(0.7).expect("valid"));
    assert!(free < 0.01, "{free}");
    assert!(limited < 0.25 && left.abs() < 1e-3, "{limited} {left}");
}

#[test]
fn a_setting_out_of_range_is_refused_by_name() {
    let units = Units::new(1e-3, 1e-3).expect("valid");
    let velocity = VelocityEstimate::<f64>::transfer(&BackwardDifference);
    type Change = fn(&mut FeedForwardSettings);
    let rows: [(&str, Change); 7] = [
        ("bandwidth", |of| of.bandwidth = 1001.0),
        ("bandwidth", |of| of.bandwidth = f64::NAN),
        ("bandwidth", |of| of.bandwidth = 0.009),
        ("acceleration", |of| of.acceleration = -1.0),
        ("velocity", |of| of.velocity = f64::INFINITY),
        ("coulomb", |of| of.coulomb = -0.1),
        ("coulomb_speed", |of| of.coulomb_speed = 0.0),
    ];
    for (name, change) in rows {
        let mut settings = SETTINGS;
        change(&mut settings);
        let refused = FeedForward::<f32>::new(&units, &settings, &gains(), &velocity);
        let parameter = refused.expect_err("refused").parameter;
        assert_eq!(parameter.strip_prefix("feed_forward."), Some(name));
    }
}

proptest! {
    /// The PID (3) written out.
    #[test]
    fn without_feed_forward_the_controller_has_the_bits_of_the_pid_alone(
        moves in prop::collection::vec((-3000_i32..3000, -200_i32..200), 1..200),
    ) {
        let units = Units::new(1e-3, 1e-3).expect("valid");
        let velocity = LowPass::<f32>::new(&units, 500.0).expect("valid");
        let limit = CommandLimit::asymmetric(-3.0, 5.0).expect("valid");
        let controller: Controller<_, _> = Controller::new(&units, &gains(), &limit, velocity);
        let unshaped: Controller<_, _, Shaped<_>> =
            Controller::new(&units, &gains(), &limit, velocity);
        let [kp, kd] = [gains().kp() / units.position(), gains().kd() / units.velocity()];
        let ki = (gains().ki() * units.rate() / units.position()) as f32;
        let (mut state, mut same) = (ControlState::default(), ControlState::default());
        let mut filter = Default::default();
        let mut integral = <f32 as Number>::Sum::new(0.0);
        for (error, increment) in moves {
            let (error, increment) = (error as f32, increment as f32);
            let found = controller.process(&mut state, error, increment).expect("in range");
            prop_assert_eq!(unshaped.process(&mut same, error, increment), Ok(found));
            let speed = velocity.process(&mut filter, increment);
            let wanted = kp as f32 * error - kd as f32 * speed + ki * integral.value();
            prop_assert_eq!(found.command.to_bits(), wanted.clamp(-3.0, 5.0).to_bits());
            prop_assert_eq!(found.error.to_bits(), error.to_bits());
            let winds_up = (wanted > 5.0 && error > 0.0) || (wanted < -3.0 && error < 0.0);
            if !winds_up {
                integral.add(error);
            }
        }
    }

    /// The servo moves and its counter wraps meanwhile; then the reference stands, and y ends there.
    #[test]
    fn the_model_does_not_depend_on_where_the_servo_is_and_ends_at_the_reference(
        start: i32,
        moves in prop::collection::vec((-300_i32..300, -200_i32..200), 1..400),
        rate in 0_usize..4,
        own in 5.0_f64..200.0,
    ) {
        let units = Units::new(SAMPLE_TIMES[rate], 1e-3).expect("valid");
        let settings = FeedForwardSettings { bandwidth: own, coulomb: 0.3, ..SETTINGS };
        let lead = lead::<f32>(&units, &settings);
        let (mut moving, mut standing) = (FeedForward::at_rest(0.0), FeedForward::at_rest(0.0));
        let (mut position, mut reference) = (0_i32, 0_i32);
        let mut follow = |position: i32, moved: i32, reference: i32| {
            let at = |counts: i32| start.wrapping_add(counts);
            let setpoint = Setpoint { count: at(reference), offset: 0.25_f32 };
            let (error, command) = lead.process(&mut moving, setpoint.error(at(position)), moved as f32);
            let (expected, same) = lead.process(&mut standing, reference as f32 + 0.25, 0.0);
            (error + position as f32, expected, command, same)
        };
        for (moved, led) in moves {
            position += moved;
            reference += led;
            let (found, expected, command, same) = follow(position, moved, reference);
            prop_assert!((found - expected).abs() < 0.1, "{found} {expected}");
            prop_assert!(command.is_finite() && (command - same).abs() < 1e-3 * (1.0 + same.abs()));
        }
        let mut last = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..(40.0 / (own * SAMPLE_TIMES[rate])) as u32 {
            last = follow(position, 0, reference);
        }
        let (found, _, command, _) = last;
        prop_assert_eq!(found.to_bits(), (reference as f32 + 0.25).to_bits());
        prop_assert!(command.abs() < 1e-6, "{command}");
    }
}
