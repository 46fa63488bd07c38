//! The cost of one sample: of the identifier alone, and of a whole simulated servo.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use host_sim::experiment;
use host_sim::paper::{self, Case, Method};
use host_sim::scenario::{Arithmetic, Law, Reference, Scenario};
use identifier_core::control::{ControlSample, ControlState};
use identifier_core::excitation::Excitation;
use identifier_core::identifier::GradientIdentifier;
use identifier_core::measurement::velocity::LowPass;
use identifier_core::number::Number;
use identifier_core::parameters::Ab;

/// Samples of a recording that the identifier is fed with, again and again.
const RECORDED: usize = 10_000;

fn scenario() -> Scenario {
    paper::scenario(Method::Proposed, Case::Unbalanced)
}

/// What the controller showed the identifier in a run of the paper's experiment.
fn recording<N: Number>(scenario: &Scenario) -> Vec<ControlSample<N>> {
    let mut samples = Vec::with_capacity(RECORDED);
    let units = &scenario.controller.units;
    let velocity = LowPass::<N>::new(units, 500.0).expect("valid");
    let controller = scenario.controller::<N, _>(velocity);
    let reference = Reference::<N>::new(units, &scenario.excitation).expect("valid");
    let mut reference_state = reference.start();
    let mut control = ControlState::at_rest(N::ZERO);
    let mut plant =
        virtual_servo::Plant::at_rest(&scenario.plant.expect("known"), units.sample_time());
    for _ in 0..RECORDED {
        let wanted = reference.process(&mut reference_state);
        let position = N::from_f64(plant.position * units.position());
        let sample = controller
            .process(&mut control, wanted, position)
            .expect("finite");
        plant.advance(sample.command.to_f64());
        samples.push(sample);
    }
    samples
}

fn identifier_sample<N: Number>(criterion: &mut Criterion, name: &str) {
    let scenario = scenario();
    let Law::Gradient(settings) = &scenario.identifier.law else {
        unreachable!("the paper's law is the gradient");
    };
    let config = scenario.identifier_config();
    let reference = Reference::new(&config.units, &scenario.excitation).expect("valid");
    let law = scenario
        .gradient_law::<Ab, 2>(settings, &reference)
        .expect("valid");
    let velocity = LowPass::<N>::new(&config.units, 500.0).expect("valid");
    let identifier =
        GradientIdentifier::<N, _, Ab, 2>::new(&config, &law, velocity).expect("valid");
    let samples = recording::<N>(&scenario);
    let mut state = identifier.start();
    let mut next = samples.iter().cycle();
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            let sample = next.next().expect("endless");
            identifier.process(black_box(&mut state), black_box(sample))
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
            let sample_time = scenario.controller.units.sample_time();
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
