//! The windowed law identifies the servo from a short motion.

use host_sim::scenario::Scenario;
use host_sim::simulate;
use integration_tests::{Random, in_parallel, parse, servo};

/// The paper's servo under 20 references and three loads, from b̂ far below and far above.
fn scenarios(arithmetic: &str) -> Vec<Scenario> {
    let mut random = Random::new(20);
    let seeds: Vec<u32> = (0..20).map(|_| random.seed()).collect();
    let mut scenarios = Vec::new();
    for initial_b in [50.0, 2000.0] {
        for load in [0.0, 20.0, -20.0] {
            for &seed in &seeds {
                let mut scenario = parse(&format!(
                    "[plant]\n\
                     a = 0.2174\n\
                     b = 257.7\n\
                     [amplifier]\n\
                     limit = 10.0\n\
                     [identifier]\n\
                     law = \"window\"\n\
                     initial = {{ a = 0.0, b = {initial_b} }}\n\
                     arithmetic = \"{arithmetic}\"\n\
                     [run]\n\
                     duration = 3.0\n"
                ));
                servo(&mut scenario).load = load;
                scenario.excitation.seed = seed;
                scenarios.push(scenario);
            }
        }
    }
    scenarios
}

/// The times from which errors count, s.
const FROM: [f64; 3] = [0.15, 0.16, 0.25];

/// The largest errors of b̂ (relative), d̂ (rad/s²) and â (1/s) from each of the times on.
fn worst(scenario: &Scenario) -> [(f64, f64, f64); FROM.len()] {
    let truth = scenario.plant.expect("a run has a plant");
    let mut worst = [(0.0_f64, 0.0_f64, 0.0_f64); FROM.len()];
    simulate::run(scenario, &mut |sample| {
        let found = &sample.estimates;
        for ((b, load, a), from) in worst.iter_mut().zip(FROM) {
            if sample.time >= from {
                *b = b.max((found.b / truth.b - 1.0).abs());
                *load = load.max((found.load - truth.load).abs());
                *a = a.max((found.a - truth.a).abs());
            }
        }
    })
    .expect("a valid scenario");
    worst
}

/// d̂ counts as known within 2 % of the load that is put on, also where none is.
const LOAD: f64 = 0.02 * 20.0;

#[test]
fn gain_and_load_are_identified_after_a_sixth_of_a_second_and_viscosity_after_a_quarter() {
    for arithmetic in ["f32", "f64"] {
        let worst = in_parallel(&scenarios(arithmetic), worst);
        let known = |from: usize| {
            let known = |(b, load, _): (f64, f64, f64)| b < 0.01 && load < LOAD;
            worst.iter().filter(|worst| known(worst[from])).count()
        };
        // Two of the twenty references move the servo so little in their first 0.15 s that the
        // rounding of the encoder shows: b̂ is 1.1 % off in one, d̂ 2.2 % in the other.
        assert!(known(0) >= 116, "{} of 120", known(0));
        assert_eq!(known(1), 120);
        for [.., (_, _, a)] in worst {
            assert!(a < 0.1, "â off by {a}");
        }
    }
}
