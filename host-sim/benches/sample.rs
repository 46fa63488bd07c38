//! The cost of one sample: of the identifier alone, and of a whole simulated servo.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use host_sim::experiment;
use host_sim::paper::{self, Case, Method};
use host_sim::scenario::{Arithmetic, Reference, Scenario};
use identifier_core::Settings;
use identifier_core::control::{ControlSample, ControlState, Controller};
use identifier_core::excitation::Excitation;
use identifier_core::identifier::{GradientIdentifier, Identify};
use identifier_core::measurement::velocity::LowPass;
use identifier_core::number::Number;
use identifier_core::parameters::Ab;

/// Samples of a recording that the identifier is fed with, again and again.
const RECORDED: usize = 10_000;

fn scenario() -> Scenario {
    paper::scenario(Method::Proposed, Case::Unbalanced)
}

/// What the controller showed the identifier in a run of the paper's experiment.
fn recording<N: Number>(scenario: &Scenario, settings: &Settings) -> Vec<ControlSample<N>> {
    let mut samples = Vec::with_capacity(RECORDED);
    let units = settings.units().expect("valid");
    let controller: Controller<N, LowPass<N>> = settings.build().expect("valid");
    let reference = Reference::<N>::new(&units, &scenario.excitation).expect("valid");
    let mut reference_state = reference.start();
    let mut control = ControlState::default();
    let mut last = N::ZERO;
    let mut plant =
        virtual_servo::Plant::at_rest(&scenario.plant.expect("known"), units.sample_time());
    for _ in 0..RECORDED {
        let wanted = reference.process(&mut reference_state);
        let position = N::from_f64(plant.position * units.position());
        let sample = controller
            .process(&mut control, wanted - position, position - last)
            .expect("finite");
        last = position;
        plant.advance(sample.command.to_f64());
        samples.push(sample);
    }
    samples
}

fn identifier_sample<N: Number>(criterion: &mut Criterion, name: &str) {
    let scenario = scenario();
    let settings = scenario.settings().expect("valid");
    let identifier: GradientIdentifier<N, LowPass<N>, Ab, 2> = settings.build().expect("certified");
    let samples = recording::<N>(&scenario, &settings);
    let mut state = identifier.start();
    let mut next = samples.iter().cycle();
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            let sample = next.next().expect("endless");
            let ControlSample {
                increment, command, ..
            } = *black_box(sample);
            identifier.learn(black_box(&mut state), increment, command)
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
                let start = Instant::now();
                let mut last = 0.0;
                experiment::run(&run, &mut |sample| last = sample.estimates.b);
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
