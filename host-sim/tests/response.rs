//! The measured response of logs in closed loop, beside that of the model that was identified from them.

use host_sim::scenario::{Purpose, Scenario};
use host_sim::{identify_run, simulate};
use identifier_log::RecordedSamples;
use identifier_log::analysis::Seen;

/// The analysis of one in `every` sample of a servo under a controller that answers the sensor's noise, with its reference
/// or without.
fn seen(every: usize, excitation: &str, counts: u32, has_reference: bool) -> Seen {
    let of = |sample_time: f64| scenario(excitation, counts, sample_time);
    let mut recorded = RecordedSamples::default();
    let mut place = 0;
    let outcome = simulate::run(&of(1e-3), &mut |sample| {
        let mut sample = *sample;
        if !has_reference {
            sample.reference = f64::NAN;
        }
        if place % every == 0 {
            recorded.add(&sample);
        }
        place += 1;
    })
    .expect("a run");
    let scenario = of(1e-3 * every as f64);
    let found = identifier_log::identify_run(&scenario, recorded, outcome, None, &|| true);
    found.seen.expect("a servo")
}

fn scenario(excitation: &str, counts: u32, sample_time: f64) -> Scenario {
    let text = format!(
        "plant = {{ a = 1.875, b = 281.25, coulomb = 20.0, load = -18.75 }}
         encoder = {{ counts_per_rev = {counts} }}
         amplifier = {{ limit = 4.0 }}
         controller = {{ kp = 9.0, kd = 0.19, ki = 4.0, sample_time = {sample_time} }}
         excitation = {{ {excitation} }}
         identifier = {{ law = \"fit\" }}
         run = {{ duration = 12.0 }}"
    );
    Scenario::parse("response", &text, Purpose::Run).expect("a scenario")
}

/// A model that never runs free has no response of its own, and the log's is not drawn in its place.
#[test]
fn a_log_that_does_not_tell_where_its_model_starts_has_no_response() {
    let excitation = "kind = \"prbs\", amplitude = 0.5, hold = 0.08";
    let all =
        [(4, 200), (8, 200), (8, 500)].map(|(every, counts)| seen(every, excitation, counts, true));
    let without: Vec<_> = all.iter().filter(|seen| seen.free_run.is_none()).collect();
    assert!(!without.is_empty());
    for seen in without {
        assert!(seen.response.is_empty(), "{:?}", seen.response);
    }
}

#[test]
fn the_measured_response_is_the_models_wherever_it_is_drawn() {
    let noise = "kind = \"band-limited-white-noise\", power = 0.01";
    let binary = "kind = \"prbs\", amplitude = 0.5, hold = 0.08";
    for counts in [500, 1000, 2000, 5000, 20_000] {
        for excitation in [noise, binary] {
            for has_reference in [true, false] {
                let seen = seen(1, excitation, counts, has_reference);
                assert_eq!(seen.has_reference, has_reference);
                let off = |measured: f64, model: f64| 20.0 * (measured / model).log10().abs();
                let worst = seen.response.iter().map(|one| off(one.measured, one.model));
                let worst = worst.fold(0.0, f64::max);
                assert!(worst < 2.0, "{:?}", seen.response);
                assert!(seen.response.len() >= 5);
            }
        }
    }
}

#[test]
fn friction_is_that_of_the_servo() {
    let text = "plant = { a = 2.0, b = 180.0, coulomb = 10.0, load = 12.0 }
        identifier = { law = \"fit\" }
        run = { duration = 20.0 }";
    let scenario = Scenario::parse("seen", text, Purpose::Run).expect("a scenario");
    let found = identify_run(scenario, &|| true, &mut |_, _| {}).expect("a run");
    let seen = found.seen.expect("a servo");
    let [mut ahead, mut back] = [0, 0];
    for one in &seen.friction {
        let true_force = 2.0 * one.velocity + 10.0 * one.velocity.signum();
        let off = one.measured - true_force;
        assert!(off.abs() < 0.3 + 4.0 * one.deviation, "{one:?}");
        assert!((one.model - true_force).abs() < 0.3, "{one:?}");
        let is_sharp = one.deviation < 1.0;
        ahead += usize::from(is_sharp && one.velocity > 0.0);
        back += usize::from(is_sharp && one.velocity < 0.0);
    }
    assert!(ahead >= 5 && back >= 5, "{:?}", seen.friction);
}
