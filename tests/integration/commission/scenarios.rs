//! The scenarios that come with the simulator.

use commissioning::Phase;
use host_sim::scenario::{Arithmetic, Purpose, Scenario};

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
