//! Instructions per whole sample (on the chip: cycles), per law and number format: from the register
//! of the encoder's counter, with a setpoint and an offset, to the command and the estimates. And
//! instructions of building the loops of a box, whose stability is proved before the first sample.
#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use firmware_stm32::host::{exit, say};
use firmware_stm32::instructions::{Counter as Instructions, Tally};
use firmware_stm32::paper;
use fixed::types::I16F16;
use identifier_core::Settings;
use identifier_core::excitation::{BandLimitedWhiteNoise, BandLimitedWhiteNoiseState, Excitation};
use identifier_core::fixed_point::{
    FixedLowPass, FixedServoLoop, FixedServoLoopState, FixedVelocity, Word, split_setpoint,
};
use identifier_core::identifier::{
    DiagonalGradientIdentifier, FitBlocks, GaussNewtonFitted, GaussNewtonFitter,
    GaussNewtonFitterState, GaussNewtonRecursion, GaussNewtonRecursionState, IdentifierError,
    Identify, NumberedBlock, RecordBlocks, ServoLoop, ServoLoopState,
};
use identifier_core::measurement::counter::Counter;
use identifier_core::measurement::velocity::{LowPass, LowPassState};
use identifier_core::model::ServoParameters;
use identifier_core::parameters::{Ab, AbCoulomb, AbCoulombLoad};
use identifier_core::settings::{BoxSettings, FromSettings, IdentifierSettings};
use virtual_servo::{Encoder, Plant};

type Filter = LowPass<f32>;
type Gradient = DiagonalGradientIdentifier<f32, Filter, Ab, 2>;
type GradientWithFriction = DiagonalGradientIdentifier<f32, Filter, AbCoulomb, 3>;
type Loop<I> = ServoLoop<f32, Filter, I>;
type Fixed = FixedServoLoop<FixedLowPass, Ab, 2>;
type GaussNewton = GaussNewtonRecursion<f32, AbCoulombLoad, 4, 64>;
type Fitter = GaussNewtonFitter<f32, AbCoulombLoad, 4, 64>;

/// Samples before the count begins and samples that are counted.
const STARTING: u32 = 500;
const COUNTED: u32 = 2000;

#[entry]
fn main() -> ! {
    let instructions = Instructions::start();
    let done = run(&instructions);
    if done.is_err() {
        say(&["a law could not be built"]);
    }
    exit(done.is_ok())
}

fn run(instructions: &Instructions) -> Result<(), IdentifierError> {
    single::<Gradient>(instructions, "gradient-f32-2")?;
    single::<GradientWithFriction>(instructions, "gradient-f32-friction")?;
    gauss_newton(instructions)?;
    words(instructions)?;
    builds(instructions)
}

/// The paper's motion, sample by sample.
struct Experiment {
    reference: BandLimitedWhiteNoise,
    wanted: BandLimitedWhiteNoiseState<f64>,
    plant: Plant,
    encoder: Encoder,
}

impl Experiment {
    /// A servo at rest with so much friction, rad/s².
    fn start(coulomb: f64) -> Result<Self, IdentifierError> {
        let reference = paper::reference()?;
        let (plant, encoder) = paper::servo_with(coulomb);
        Ok(Self {
            wanted: Excitation::start(&reference),
            reference,
            plant,
            encoder,
        })
    }

    /// Runs some samples and counts them. `sample` gets a reference in counts and the counter's
    /// register and answers with the command and the instructions that it took.
    fn count(&mut self, samples: u32, sample: &mut impl FnMut(f64, u16) -> (f64, u32)) -> Tally {
        let mut tally = Tally::default();
        for _ in 0..samples {
            let next: f64 = self.reference.process(&mut self.wanted);
            // The register has the low bits only.
            let (command, taken) = sample(next, self.encoder.read(self.plant.position) as u16);
            tally.add(taken);
            self.plant.advance(command);
        }
        tally
    }
}

/// Runs the paper's experiment with `sample`, and counts once it has started.
fn measure(
    name: &str,
    state_bytes: usize,
    mut sample: impl FnMut(f64, u16) -> (f64, u32),
) -> Result<(), IdentifierError> {
    let mut experiment = Experiment::start(0.0)?;
    experiment.count(STARTING, &mut sample);
    let tally = experiment.count(COUNTED, &mut sample);
    tally.say(name, state_bytes);
    Ok(())
}

/// A call's result and its instructions, less those that counting itself takes. What goes in and comes
/// out passes a black box, or the compiler would move its making and its use in between.
#[inline(always)]
fn counted<T>(instructions: &Instructions, work: impl FnOnce() -> T) -> (T, u32) {
    let empty = {
        let before = instructions.now();
        instructions.now().wrapping_sub(before)
    };
    let before = instructions.now();
    let result = work();
    let taken = instructions.now().wrapping_sub(before).wrapping_sub(empty);
    (black_box(result), taken)
}

/// A loop in single precision with its counter and its state, as a drive keeps them.
struct Single<I: Identify<f32>> {
    counter: Counter<u16>,
    servo_loop: Loop<I>,
    state: ServoLoopState<f32, LowPassState<f32>, I::State>,
}

impl<I: Identify<f32> + FromSettings> Single<I> {
    fn build(settings: &Settings) -> Result<Self, IdentifierError> {
        let servo_loop: Loop<I> = settings.build()?;
        Ok(Self {
            counter: Counter::new(0),
            state: servo_loop.start(0),
            servo_loop,
        })
    }

    #[inline(never)]
    fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        self.step(setpoint, offset, register)
    }

    /// As in a drive, which acts between control and learning.
    #[inline(always)]
    fn step(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        let count = self.counter.read(register);
        let control = self
            .servo_loop
            .control(&mut self.state, setpoint, offset, count);
        control.map_or(0.0, |sample| {
            self.servo_loop.learn(&mut self.state, &sample);
            sample.command
        })
    }

    /// Runs a sample and counts its instructions.
    fn counted(
        &mut self,
        instructions: &Instructions,
        given: (f64, u16),
        sample: impl FnOnce(&mut Self, i32, f32, u16) -> f32,
    ) -> (f64, u32) {
        let (whole, offset, register) = black_box(split(given));
        let (command, taken) = counted(instructions, || sample(self, whole, offset, register));
        (f64::from(command), taken)
    }
}

/// A reference as whole counts and an offset, with the register as it is.
fn split((reference, register): (f64, u16)) -> (i32, f32, u16) {
    let whole = reference as i32;
    (whole, (reference - f64::from(whole)) as f32, register)
}

fn single<I: Identify<f32> + FromSettings>(
    instructions: &Instructions,
    name: &str,
) -> Result<(), IdentifierError> {
    let mut parts = Single::<I>::build(&paper::settings())?;
    measure(name, size_of::<I::State>(), |reference, register| {
        parts.counted(instructions, (reference, register), Single::sample)
    })
}

/// Gauss–Newton's halves, as a drive keeps them: what is to be handed over is on its way in between.
struct Halves {
    interrupt: Single<GaussNewton>,
    fitter: Fitter,
    fitting: GaussNewtonFitterState<f32, 64>,
    fitted: Option<GaussNewtonFitted<f32, AbCoulombLoad, 4>>,
    block: Option<NumberedBlock<f32>>,
}

impl Halves {
    fn build(settings: &Settings) -> Result<Self, IdentifierError> {
        let fitter: Fitter = settings.build()?;
        Ok(Self {
            interrupt: Single::build(settings)?,
            fitting: fitter.start(),
            fitter,
            fitted: None,
            block: None,
        })
    }

    /// The interrupt's share: a sample, with what is handed over before and after.
    #[inline(never)]
    fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        let Self {
            interrupt,
            fitted,
            block,
            ..
        } = self;
        if let Some(fitted) = fitted.take() {
            let identifier = interrupt.servo_loop.identifier();
            identifier.take_over(interrupt.state.identification_mut(), &fitted);
        }
        let command = interrupt.step(setpoint, offset, register);
        let identifier = interrupt.servo_loop.identifier();
        *block = identifier.take_block(interrupt.state.identification_mut());
        command
    }

    /// The background's share: a block of the first fit.
    #[inline(never)]
    fn work(&mut self) {
        if let Some(block) = self.block.take() {
            self.fitter.take(&mut self.fitting, &block);
        }
        self.fitted = self.fitter.work(&mut self.fitting, 1);
    }

    fn is_running(&self) -> bool {
        let identifier = self.interrupt.servo_loop.identifier();
        identifier.is_running(self.interrupt.state.identification())
    }

    /// Runs a sample and counts the interrupt's instructions, and the background's apart.
    fn counted(
        &mut self,
        instructions: &Instructions,
        given: (f64, u16),
        background: &mut Tally,
    ) -> (f64, u32) {
        let (whole, offset, register) = black_box(split(given));
        let (command, taken) = counted(instructions, || self.sample(whole, offset, register));
        let ((), worked) = counted(instructions, || self.work());
        background.add(worked);
        (f64::from(command), taken)
    }
}

/// Gauss–Newton on a servo with friction, without any guess: once while it records and the background
/// makes its first fit, a block a sample, and once while the recursion runs.
fn gauss_newton(instructions: &Instructions) -> Result<(), IdentifierError> {
    /// Friction, rad/s², which reverses with the servo.
    const COULOMB: f64 = 10.0;
    /// Samples within which a first fit is found.
    const PATIENCE: u32 = 60_000;
    let settings = Settings {
        identifier: IdentifierSettings::UNSTATED,
        ..paper::settings()
    };
    let mut halves = Halves::build(&settings)?;
    let mut experiment = Experiment::start(COULOMB)?;
    let (mut recording, mut fitting) = (Tally::default(), Tally::default());
    let mut beginning = Tally::default();
    while !halves.is_running() {
        if recording.rounds() == PATIENCE {
            return Err(IdentifierError::NotGiven { setting: "motion" });
        }
        let one = experiment.count(1, &mut |reference, register| {
            halves.counted(instructions, (reference, register), &mut fitting)
        });
        let tally = if halves.is_running() {
            &mut beginning
        } else {
            &mut recording
        };
        tally.add(one.total());
    }
    let state = size_of::<GaussNewtonRecursionState<f32, AbCoulombLoad, 4>>();
    recording.say("gauss-newton-recording", state);
    beginning.say(
        "gauss-newton-beginning",
        size_of::<GaussNewtonFitted<f32, AbCoulombLoad, 4>>(),
    );
    fitting.say(
        "gauss-newton-fitting",
        size_of::<GaussNewtonFitterState<f32, 64>>(),
    );
    let mut sample =
        |reference, register| halves.counted(instructions, (reference, register), &mut fitting);
    experiment.count(STARTING, &mut sample);
    let tally = experiment.count(COUNTED, &mut sample);
    tally.say("gauss-newton-f32-4", state);
    // What is told of a sample that is shown.
    let interrupt = &halves.interrupt;
    let identifier = interrupt.servo_loop.identifier();
    let state = interrupt.state.identification();
    let (shown, taken) = counted(instructions, || identifier.show(black_box(state)));
    once("gauss-newton-shown", taken, size_of_val(&shown));
    let (_, taken) = counted(instructions, || identifier.estimates_of(black_box(&shown)));
    once("gauss-newton-in-si", taken, size_of::<ServoParameters>());
    Ok(())
}

/// What was counted once.
fn once(name: &str, taken: u32, bytes: usize) {
    let mut tally = Tally::default();
    tally.add(taken);
    tally.say(name, bytes);
}

/// The loop in fixed point with its counter and its state.
struct Words {
    counter: Counter<u16>,
    servo_loop: Fixed,
    state: FixedServoLoopState<<FixedLowPass as FixedVelocity>::State, 2>,
}

impl Words {
    #[inline(never)]
    fn sample(&mut self, setpoint: i32, offset: I16F16, register: u16) -> Word {
        let count = self.counter.read(register);
        let control = self
            .servo_loop
            .control(&mut self.state, setpoint, offset, count);
        control.map_or(Word::ZERO, |sample| {
            self.servo_loop.learn(&mut self.state, &sample);
            sample.command
        })
    }
}

fn words(instructions: &Instructions) -> Result<(), IdentifierError> {
    let servo_loop: Fixed = paper::settings().build()?;
    let mut parts = Words {
        counter: Counter::new(0),
        state: servo_loop.start(0),
        servo_loop,
    };
    let bytes = size_of_val(parts.state.identification());
    measure("gradient-fixed-2", bytes, |reference, register| {
        let (whole, offset) = split_setpoint(reference);
        let (whole, offset, register) = black_box((whole, offset, register));
        let (command, taken) = counted(instructions, || parts.sample(whole, offset, register));
        (parts.servo_loop.controller().command(command), taken)
    })
}

/// Building the gradient's loops: the paper's, and for three wide boxes from 250 Hz to 20 kHz, whose
/// estimates nobody bounds.
fn builds(instructions: &Instructions) -> Result<(), IdentifierError> {
    let mut tally = Tally::default();
    for settings in [
        paper::settings(),
        boxed(4e-3, [0.0, 20.0], [30.0, 300.0]),
        boxed(2.5e-4, [0.0, 100.0], [20.0, 2000.0]),
        boxed(5e-5, [0.0, 10.0], [10.0, 10_000.0]),
    ] {
        build::<Loop<Gradient>>(instructions, &settings, &mut tally)?;
        build::<Loop<GradientWithFriction>>(instructions, &settings, &mut tally)?;
        build::<Fixed>(instructions, &settings, &mut tally)?;
    }
    tally.say("gradient-build", size_of::<Loop<GradientWithFriction>>());
    Ok(())
}

fn build<L: FromSettings>(
    instructions: &Instructions,
    settings: &Settings,
    tally: &mut Tally,
) -> Result<(), IdentifierError> {
    let (built, taken) = counted(instructions, || black_box(settings).build::<L>());
    tally.add(taken);
    built.map(|_| ())
}

/// The paper's gains and limit at a sample time (s) with a box, a in 1/s and b in rad/s² per command
/// unit; everything else follows from these.
fn boxed(sample_time: f64, a: [f64; 2], b: [f64; 2]) -> Settings {
    let paper = paper::settings();
    Settings {
        controller: paper.controller,
        identifier: IdentifierSettings {
            plant_box: Some(BoxSettings { a, b }),
            gamma: paper.identifier.gamma,
            ..IdentifierSettings::UNSTATED
        },
        resolution: paper.resolution,
        ..Settings::new(sample_time, 1.0)
    }
}
