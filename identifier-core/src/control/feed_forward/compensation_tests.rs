use super::*;
use crate::control::{CommandLimit, Controller};
use crate::measurement::velocity::{LowPass, VelocityEstimate};
use proptest::prelude::*;

const SAMPLE_TIME: f64 = 1e-3;

const COUNT: f64 = 1e-3;

const KNOWN: CompensationSettings = CompensationSettings {
    constant: 0.3,
    gravity: [-0.5, 0.2],
    ripple: [0.05, -0.02],
    ripple_order: 7.0,
    revolution: core::f64::consts::TAU,
    dead_band: 0.0,
    delay: 0.0,
};

const LED: FeedForwardSettings = FeedForwardSettings {
    bandwidth: 40.0,
    acceleration: 0.004,
    velocity: 0.012,
    coulomb: 0.1,
    coulomb_speed: 0.1,
};

fn units() -> Units {
    Units::new(SAMPLE_TIME, COUNT).expect("valid")
}

/// Gains with this derivative, and the estimate of the velocity.
fn gains(kd: f64) -> (Gains, Transfer) {
    let velocity = LowPass::<f64>::new(&units(), 500.0).expect("valid");
    (
        Gains::new(9.0, kd, 60.0).expect("valid"),
        velocity.transfer(),
    )
}

fn plain<N: Number>(kd: f64) -> FeedForward<N> {
    let (gains, velocity) = gains(kd);
    FeedForward::new(&units(), &LED, &gains, &velocity).expect("valid")
}

fn lead<N: Number>(
    kd: f64,
    known: &CompensationSettings,
) -> Result<CompensatedFeedForward<N>, OutOfRange> {
    let (gains, velocity) = gains(kd);
    CompensatedFeedForward::new(&units(), &LED, known, &gains, &velocity)
}

fn compensated<N: Number>(kd: f64, known: &CompensationSettings) -> CompensatedFeedForward<N> {
    lead(kd, known).expect("valid")
}

/// Where the model stands, the command is that of its angle, wherever the servo is and wherever it began.
#[test]
fn known_forces_are_those_of_the_angle_of_the_reference() {
    let lead = compensated::<f64>(0.19, &KNOWN);
    for began in [0.0, 2000.0, -1.0e6] {
        for from_reference in [0.0, 100.0, -3000.0] {
            let mut motion = CompensatedMotion {
                reference: FeedForward::at_rest(from_reference),
                ..lead.at(began)
            };
            let (_, found) = lead.process(&mut motion, from_reference, 0.0);
            let q = (began + from_reference) * COUNT;
            let exact = 0.3 - 0.5 * q.sin() + 0.2 * q.cos() + 0.05 * (7.0 * q).sin()
                - 0.02 * (7.0 * q).cos();
            assert!(
                (found - exact).abs() < 1e-9,
                "{began} {from_reference}: {found} {exact}"
            );
        }
    }
}

/// A measured position that jumps to and fro about a reference that stands changes no command.
#[test]
fn nothing_chatters_at_rest() {
    let known = CompensationSettings {
        dead_band: 0.4,
        ..KNOWN
    };
    let lead = compensated::<f32>(0.19, &known);
    let mut motion = lead.at(1500.0);
    let (_, first) = lead.process(&mut motion, 0.0, 0.0);
    let mut position = 0.0;
    for k in 0..10_000_u32 {
        let to = (k * 7919 % 13) as f32 - 6.0;
        let (_, now) = lead.process(&mut motion, -to, to - position);
        position = to;
        assert!((now - first).abs() < 1e-6, "{k}: {now} {first}");
    }
}

/// The command that the model needs once more, but δ at most; what the derivative of the controller takes back is no part of it.
#[test]
fn a_dead_band_is_added_in_the_direction_of_the_command_that_is_needed() {
    const DEAD_BAND: f64 = 0.2;
    const STEP: f64 = 800.0;
    let known = CompensationSettings {
        dead_band: DEAD_BAND,
        ..CompensationSettings::NONE
    };
    let plain = [0.19, 0.0].map(plain::<f64>);
    let compensated = [0.19, 0.0].map(|kd| compensated::<f64>(kd, &known));
    let mut motions = compensated.map(|lead| lead.at(0.0));
    let mut plain_motions = [FeedForward::at_rest(0.0); 2];
    let mut directions = [0; 2];
    for k in 0..2000 {
        let mut commands = [0.0; 2];
        let added: [f64; 2] = core::array::from_fn(|i| {
            (_, commands[i]) = plain[i].process(&mut plain_motions[i], STEP, 0.0);
            compensated[i].process(&mut motions[i], STEP, 0.0).1 - commands[i]
        });
        // Without a derivative the command is the one that is needed.
        let needed = commands[1].clamp(-DEAD_BAND, DEAD_BAND);
        assert!(
            added.iter().all(|added| (added - needed).abs() < 1e-9),
            "{k}: {added:?}"
        );
        directions[usize::from(needed > 0.0)] += i32::from(needed.abs() > 0.99 * DEAD_BAND);
    }
    assert!(directions.iter().all(|&full| full > 20), "{directions:?}");
}

#[test]
fn a_compensation_out_of_range_is_refused_by_name() {
    const NONE: CompensationSettings = CompensationSettings::NONE;
    let cases = [
        (
            "feed_forward_constant",
            CompensationSettings {
                constant: f64::NAN,
                ..NONE
            },
        ),
        (
            "feed_forward_gravity",
            CompensationSettings {
                gravity: [0.0, f64::INFINITY],
                ..NONE
            },
        ),
        (
            "feed_forward_ripple",
            CompensationSettings {
                ripple: [f64::NAN, 0.0],
                ..NONE
            },
        ),
        (
            "feed_forward_ripple_order",
            CompensationSettings {
                ripple_order: -1.0,
                ..NONE
            },
        ),
        (
            "feed_forward_revolution",
            CompensationSettings {
                revolution: 0.0,
                ..NONE
            },
        ),
        (
            "feed_forward_dead_band",
            CompensationSettings {
                dead_band: -0.1,
                ..NONE
            },
        ),
        (
            "feed_forward_delay",
            CompensationSettings {
                delay: -1e-3,
                ..NONE
            },
        ),
    ];
    for (name, known) in cases {
        let refused = lead::<f32>(0.1, &known);
        assert_eq!(refused.expect_err("refused").parameter, name);
    }
}

proptest! {
    /// With its settings all zero, the controller's command is that of the plain feed-forward.
    #[test]
    fn a_compensation_of_nothing_changes_no_bit(
        moves in prop::collection::vec((-3000_i32..3000, -200_i32..200), 1..200),
    ) {
        let units = units();
        let velocity = LowPass::<f32>::new(&units, 500.0).expect("valid");
        let gains = Gains::new(9.0, 0.19, 60.0).expect("valid");
        let limit = CommandLimit::symmetric(5.0).expect("valid");
        let controller = || Controller::new(&units, &gains, &limit, velocity);
        let nothing = compensated::<f32>(0.19, &CompensationSettings::NONE);
        let compensated = controller().with_feed_forward(nothing);
        let plain = controller().with_feed_forward(plain::<f32>(0.19));
        let (mut state, mut other) = (plain.start(), compensated.start());
        for (error, increment) in moves {
            let (error, increment) = (error as f32, increment as f32);
            let found = compensated.process(&mut other, error, increment).expect("in range");
            let expected = plain.process(&mut state, error, increment).expect("in range");
            prop_assert_eq!(found.command.to_bits(), expected.command.to_bits());
            prop_assert_eq!(found.error.to_bits(), expected.error.to_bits());
        }
    }
}
