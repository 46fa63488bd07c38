//! The scenarios that come with the simulator.

use commissioning::Phase;
use host_sim::scenario::{Arithmetic, Purpose, Scenario};
use identifier_core::reason::Reason;

use super::judged::{Judged, commission};

fn scenario(name: &str, text: &str) -> Scenario {
    Scenario::parse(name, text, Purpose::Commission).expect("a valid scenario")
}

/// Commissioned within its limits, in both number formats.
fn commissioned(name: &str, text: &str) -> Judged {
    let mut scenario = scenario(name, text);
    let single = commission(&scenario);
    scenario.identifier.arithmetic = Arithmetic::F64;
    let double = commission(&scenario);
    for judged in [&single, &double] {
        assert!(judged.broken.is_empty(), "{name}: {:?}", judged.broken);
    }
    assert_eq!(
        single.outcome.reason(),
        double.outcome.reason(),
        "{name}: single and double precision"
    );
    single
}

fn assert_applied(name: &str, text: &str) {
    let judged = commissioned(name, text);
    assert!(
        judged.outcome.is_applied(),
        "{name}: {:?}",
        judged.outcome.end
    );
    let kept = judged.kept.expect("it is applied");
    assert!(kept.is_kept(), "{name}: {kept:?}");
}

#[test]
fn the_papers_servo_a_coarse_encoder_and_a_joint_under_gravity_are_commissioned() {
    assert_applied(
        "paper",
        include_str!("../../../host-sim/scenarios/commission.toml"),
    );
    assert_applied(
        "coarse",
        include_str!("../../../host-sim/scenarios/commission_coarse.toml"),
    );
    assert_applied(
        "joint",
        include_str!("../../../host-sim/scenarios/commission_gravity.toml"),
    );
}

#[test]
fn much_backlash_is_refused_and_nothing_kept() {
    let text = include_str!("../../../host-sim/scenarios/commission_play.toml");
    let judged = commissioned("play", text);
    let end = judged.outcome.end.expect("it ended");
    assert_eq!(end.phase, Phase::Aborted);
    assert!(end.reason.is_some());
    assert!(judged.outcome.tuning.is_none());
}

/// An axis on which more acts than its limits bear, what is said of it, and the remedy that this names.
#[test]
fn what_is_said_of_an_axis_that_is_held_helps() {
    let gravity = "coulomb = 90.0\ngravity = [0.0, -2200.0]";
    let cogs = "coulomb = 90.0\nripple = [1200.0, 0.0]\nripple_order = 48";
    let is_held = "coulomb = 1200.0\nripple = [1500.0, 0.0]\nripple_order = 12";
    let long_waves = "coulomb = 90.0\nripple = [250.0, 0.0]\nripple_order = 12";
    // Travel, speed and command, where all of the command is 2577 rad/s², and those that the reason asks for.
    for (rate, forces, [before, after], reason) in [
        (
            1.0,
            gravity,
            [[0.5, 20.0, 10.0], [0.5, 20.0, 20.0]],
            Reason::TooLittleEvidence,
        ),
        (
            1.0,
            cogs,
            [[0.5, 20.0, 10.0], [0.5, 20.0, 25.0]],
            Reason::Reversed,
        ),
        (
            4.0,
            is_held,
            [[0.5, 50.0, 10.0], [0.5, 50.0, 40.0]],
            Reason::DoesNotMove,
        ),
        (
            1.0,
            long_waves,
            [[0.15, 20.0, 10.0], [0.5, 20.0, 10.0]],
            Reason::PartlyExplained,
        ),
    ] {
        let outcome = |[travel, speed, limit]: [f64; 3]| {
            let text = format!(
                "[plant]\na = 1.2\nb = 257.7\n{forces}\n[encoder]\ncounts_per_rev = {}\n[amplifier]\nlimit = {limit}\n\
                 [commission]\ntravel = {travel}\nspeed = {speed}\nsample_time = {}\n",
                16384.0 * rate,
                1e-3 / rate
            );
            commission(&scenario("held", &text)).outcome
        };
        assert_eq!(outcome(before).reason(), Some(reason), "{forces}");
        let after = outcome(after);
        assert!(after.is_applied(), "{forces}: {:?}", after.end);
    }
}

/// Friction at rest holds it 0.1 rad short of where the trial's step is to begin.
#[test]
fn the_trial_of_an_axis_that_sticks_begins_where_its_step_has_room() {
    let text = "[plant]\na = 0.3\nb = 75.0\ncoulomb = 145.0\nlow_speed_friction = 100.0\nlow_speed_velocity = 0.4\n\
                [encoder]\ncounts_per_rev = 3000\n[amplifier]\nlimit = 10.0\n\
                [commission]\ntravel = 0.22\nspeed = 15.0\nsample_time = 0.00025\n";
    let judged = commission(&scenario("sticks", text));
    assert!(judged.broken.is_empty(), "{:?}", judged.broken);
    assert!(judged.outcome.is_applied(), "{:?}", judged.outcome.end);
}
