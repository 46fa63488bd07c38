//! Instructions per whole sample (on the chip: cycles), per law and number format.
#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use firmware_stm32::host::{Text, exit, say};
use firmware_stm32::instructions::Counter;
use firmware_stm32::paper;
use fixed::types::I48F16;
use identifier_core::control::ControlState;
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::{
    Accumulator, FixedControlSample, FixedControlState, FixedGradientIdentifier,
    FixedGradientState, FixedLowPass, Ranges, reference_of_counts,
};
use identifier_core::identifier::{
    DiagonalGradientIdentifier, GaussNewtonIdentifier, GaussNewtonIdentifierState,
    GradientIdentifierState, IdentifierError, Uncertainty,
};
use identifier_core::measurement::velocity::{LowPass, LowPassState};
use identifier_core::parameters::{Ab, AbCoulomb, AbCoulombLoad, ParameterSet};

type Filter = LowPass<f32>;

/// Samples before the count begins and samples that are counted.
const STARTING: u32 = 500;
const COUNTED: u32 = 2000;

#[entry]
fn main() -> ! {
    let counter = Counter::start();
    let done = run(&counter);
    if done.is_err() {
        say(&["a law could not be built"]);
    }
    exit(done.is_ok())
}

fn run(counter: &Counter) -> Result<(), IdentifierError> {
    gradient::<Ab, 2>(counter, "gradient-f32-2")?;
    gradient::<AbCoulomb, 3>(counter, "gradient-f32-friction")?;
    gauss_newton(counter)?;
    words(counter)
}

/// Runs the paper's loop with `sample`, which answers with the command and the ticks it took.
fn measure(
    name: &str,
    state_bytes: usize,
    mut sample: impl FnMut(f64, i64) -> (f64, u32),
) -> Result<(), IdentifierError> {
    let config = paper::config()?;
    let reference = paper::reference(&config.units)?;
    let (mut plant, encoder) = paper::servo();
    let mut wanted = Excitation::<f64>::start(&reference);
    let mut total = 0_u32;
    let mut most = 0_u32;
    for k in 0..STARTING + COUNTED {
        let next: f64 = reference.process(&mut wanted);
        let count = encoder.read(plant.position);
        let (command, taken) = sample(next, count);
        if k >= STARTING {
            total = total.wrapping_add(taken);
            most = most.max(taken);
        }
        plant.advance(command);
    }
    let [mean, most, bytes] = [total / COUNTED, most, state_bytes as u32].map(Text::whole);
    say(&[name, mean.as_str(), most.as_str(), bytes.as_str()]);
    Ok(())
}

/// A call's result and its ticks, less those that counting itself takes. What goes in and comes out
/// passes a black box, or the compiler would move its making and its use in between.
#[inline(always)]
fn counted<T>(counter: &Counter, work: impl FnOnce() -> T) -> (T, u32) {
    let empty = {
        let before = counter.now();
        counter.now().wrapping_sub(before)
    };
    let before = counter.now();
    let result = work();
    let taken = counter.now().wrapping_sub(before).wrapping_sub(empty);
    (black_box(result), taken)
}

/// The gradient identifier with its controller and their states, as a drive keeps them.
struct Gradient<S, const P: usize> {
    identifier: DiagonalGradientIdentifier<f32, Filter, S, P>,
    control: ControlState<f32, LowPassState<f32>>,
    learnt: GradientIdentifierState<f32, LowPassState<f32>, P>,
}

impl<S: ParameterSet<P>, const P: usize> Gradient<S, P> {
    #[inline(never)]
    fn sample(&mut self, reference: f32, position: f32) -> f32 {
        let sample = self
            .identifier
            .controller()
            .process(&mut self.control, reference, position);
        sample.map_or(0.0, |sample| {
            self.identifier.process(&mut self.learnt, &sample);
            sample.command
        })
    }
}

fn gradient<S: ParameterSet<P>, const P: usize>(
    counter: &Counter,
    name: &str,
) -> Result<(), IdentifierError> {
    let config = paper::config()?;
    let velocity = paper::velocity::<f32>(&config.units)?;
    let identifier = DiagonalGradientIdentifier::new(&config, &paper::law()?, velocity)?;
    let mut parts = Gradient::<S, P> {
        control: ControlState::at_rest(0.0),
        learnt: identifier.start(),
        identifier,
    };
    measure(name, size_of_val(&parts.learnt), |reference, count| {
        let (reference, position) = black_box((reference as f32, count as f32));
        let (command, taken) = counted(counter, || parts.sample(reference, position));
        (f64::from(command), taken)
    })
}

/// Controller and recursive Gauss–Newton.
struct GaussNewton {
    identifier: GaussNewtonIdentifier<f32, Filter, AbCoulombLoad, 4>,
    control: ControlState<f32, LowPassState<f32>>,
    learnt: GaussNewtonIdentifierState<f32, LowPassState<f32>, 4>,
}

impl GaussNewton {
    #[inline(never)]
    fn sample(&mut self, reference: f32, position: f32) -> f32 {
        let sample = self
            .identifier
            .controller()
            .process(&mut self.control, reference, position);
        sample.map_or(0.0, |sample| {
            self.identifier.process(&mut self.learnt, &sample);
            sample.command
        })
    }
}

fn gauss_newton(counter: &Counter) -> Result<(), IdentifierError> {
    let config = paper::config()?;
    let velocity = paper::velocity::<f32>(&config.units)?;
    let identifier =
        GaussNewtonIdentifier::new(&config, &Uncertainty::UNSTATED, [false; 4], velocity)?;
    let mut parts = GaussNewton {
        control: ControlState::at_rest(0.0),
        learnt: identifier.start(),
        identifier,
    };
    measure(
        "gauss-newton-f32-4",
        size_of_val(&parts.learnt),
        |reference, count| {
            let (reference, position) = black_box((reference as f32, count as f32));
            let (command, taken) = counted(counter, || parts.sample(reference, position));
            (f64::from(command), taken)
        },
    )
}

/// The gradient identifier in fixed point with its controller and their states.
struct Words {
    identifier: FixedGradientIdentifier<FixedLowPass, Ab, 2>,
    control: FixedControlState<Accumulator>,
    learnt: FixedGradientState<Accumulator, 2>,
}

impl Words {
    #[inline(never)]
    fn sample(&mut self, reference: I48F16, count: i64) -> FixedControlSample {
        let controller = self.identifier.controller();
        let sample = controller.process(&mut self.control, reference, count);
        self.identifier.process(&mut self.learnt, &sample);
        sample
    }
}

fn words(counter: &Counter) -> Result<(), IdentifierError> {
    let config = paper::config()?;
    let ranges = Ranges::of(&config);
    let velocity = paper::velocity::<f64>(&config.units)?;
    let identifier = FixedGradientIdentifier::new(&config, &paper::law()?, &ranges, velocity)?;
    let mut parts = Words {
        control: identifier.controller().start(0),
        learnt: identifier.start(),
        identifier,
    };
    measure(
        "gradient-fixed-2",
        size_of_val(&parts.learnt),
        |reference, count| {
            let (reference, count) = black_box((reference_of_counts(reference), count));
            let (sample, taken) = counted(counter, || parts.sample(reference, count));
            (parts.identifier.controller().command(&sample), taken)
        },
    )
}
