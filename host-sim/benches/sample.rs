//! The cost of one sample: of the identifier alone, and of a whole simulated servo.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use host_sim::scenario::{Arithmetic, Purpose, Scenario};
use host_sim::simulate::{self, Simulation};
use identifier_core::identifier::{GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::number::Number;
use identifier_core::parameters::Unknowns;

/// Length of the recording that the identifier is fed with, again and again, s.
const RECORDED: f64 = 10.0;

/// The paper's experiment, with its amplifier unbalanced.
fn scenario() -> Scenario {
    let text = include_str!("../scenarios/paper.toml");
    let mut scenario = Scenario::parse("paper.toml", text, Purpose::Run).expect("valid");
    scenario.plant.as_mut().expect("a servo").load = 20.0;
    scenario
}

/// Inputs of an identifier in a run of the paper's experiment: increments in counts, and commands.
fn recording<N: Number>(scenario: &Scenario) -> Vec<(i32, N)> {
    let mut scenario = scenario.clone();
    scenario.duration = RECORDED;
    let unit = scenario.units().position_unit();
    let mut shown = Vec::new();
    let mut before = 0;
    simulate::run(&scenario, &mut |sample| {
        let count = (sample.position / unit).round() as i32;
        shown.push((count - before, N::from_f64(sample.command)));
        before = count;
    })
    .expect("the paper's scenario is valid");
    shown
}

fn identifier_sample<N: Number>(criterion: &mut Criterion, name: &str) {
    let scenario = scenario();
    let settings = scenario.settings().expect("valid");
    let identifier: GradientIdentifier<N, LowPass<N>, Unknowns<2>, 2> =
        settings.build().expect("certified");
    let samples = recording::<N>(&scenario);
    let mut state = identifier.start();
    let mut next = samples.iter().cycle();
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            let &(moved, command) = black_box(next.next().expect("endless"));
            identifier.process(black_box(&mut state), moved, command)
        });
    });
}

fn simulated_sample(criterion: &mut Criterion, arithmetic: Arithmetic) {
    let mut scenario = scenario();
    scenario.identifier.arithmetic = arithmetic;
    let name = format!("simulated sample, {}", arithmetic.name());
    criterion.bench_function(&name, |bencher| {
        bencher.iter_custom(|iterations| {
            let mut spent = Duration::ZERO;
            let mut left = iterations;
            let sample_time = scenario.sample_time();
            while left > 0 {
                let samples = left.min(60_000);
                let mut run = scenario.clone();
                run.duration = samples as f64 * sample_time;
                let simulation = Simulation::build(&run).expect("valid");
                let start = Instant::now();
                let mut last = 0.0;
                simulation.run(&mut |sample| last = sample.estimates.b);
                spent += start.elapsed();
                black_box(last);
                left -= samples;
            }
            spent
        });
    });
}

fn benchmarks(criterion: &mut Criterion) {
    identifier_sample::<f32>(criterion, "identifier sample, f32");
    identifier_sample::<f64>(criterion, "identifier sample, f64");
    simulated_sample(criterion, Arithmetic::F32);
    simulated_sample(criterion, Arithmetic::F64);
}

criterion_group!(benches, benchmarks);
criterion_main!(benches);
