//! Loops and estimators with the paper's servo around them, sample by sample, and the instructions that a sample takes.

use core::hint::black_box;

use fixed::types::I16F16;
use identifier_core::Settings;
use identifier_core::control::{ControlSample, ControlState, Controller, Setpoint};
use identifier_core::error::StepError;
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::{FixedLoop, FixedLoopState, Word};
use identifier_core::identifier::{
    GaussNewtonFitted, GaussNewtonFitter, GaussNewtonFitterState, GaussNewtonRecursion,
    GradientIdentifier, IdentifiableSet, Identify, NumberedBlock, ServoLoop, ServoLoopState,
};
use identifier_core::measurement::{Counter, LowPass, VelocityEstimate};
use identifier_core::parameters::Unknowns;
use identifier_core::settings::{FromSettings, SettingsError};
use virtual_servo::excitation::{BandLimitedWhiteNoise, BandLimitedWhiteNoiseState};
use virtual_servo::{Encoder, Plant};

use crate::instructions::{Counter as Instructions, Tally};
use crate::paper;

type Filter = LowPass<f32>;
/// The PID with an identifier.
pub type Loop<I> = ServoLoop<f32, Filter, I>;
/// The paper's estimator.
pub type Gradient = GradientIdentifier<f32, Filter, Unknowns<2>, 2>;
/// The loop with it in fixed point.
pub type Fixed = FixedLoop;
/// Gauss–Newton's half in the interrupt.
pub type GaussNewton<S, const P: usize> = GaussNewtonRecursion<f32, S, P, 64>;
/// Its half in the background.
pub type Fitter<S, const P: usize> = GaussNewtonFitter<f32, S, P, 64>;

/// Samples before the count begins.
pub const STARTING: u32 = 500;
/// Samples that are counted: the worst of fewer is not the worst.
pub const COUNTED: u32 = 100_000;
/// Friction of a servo that sticks at every reversal, rad/s².
pub const COULOMB: f64 = 10.0;

/// The paper's motion, sample by sample.
pub struct Experiment {
    reference: BandLimitedWhiteNoise,
    wanted: BandLimitedWhiteNoiseState<f64>,
    plant: Plant,
    encoder: Encoder,
}

impl Experiment {
    /// A servo at rest with Coulomb friction, rad/s².
    ///
    /// # Errors
    /// A reference that is not allowed.
    pub fn start(coulomb: f64) -> Result<Self, SettingsError> {
        let reference = paper::reference()?;
        let (plant, encoder) = paper::servo_with(coulomb);
        Ok(Self {
            wanted: Excitation::start(&reference),
            reference,
            plant,
            encoder,
        })
    }

    /// Runs some samples and counts them. The function `sample` gets a reference in counts and the counter's register
    /// and returns the command and its instructions.
    pub fn count(
        &mut self,
        samples: u32,
        sample: &mut impl FnMut(f64, u16) -> (f64, u32),
    ) -> Tally {
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

/// Runs the paper's experiment with `sample` on a servo with some friction, rad/s², and counts once it has
/// started.
///
/// # Errors
/// As [`Experiment::start`].
pub fn measure(
    coulomb: f64,
    mut sample: impl FnMut(f64, u16) -> (f64, u32),
) -> Result<Tally, SettingsError> {
    let mut experiment = Experiment::start(coulomb)?;
    experiment.count(STARTING, &mut sample);
    Ok(experiment.count(COUNTED, &mut sample))
}

/// The samples of an estimator: their mean on one servo, and their maximum on two servos that differ by friction in
/// rad/s².
///
/// # Errors
/// As `measured`.
pub fn on_both(
    [own, other]: [f64; 2],
    mut measured: impl FnMut(f64) -> Result<Tally, SettingsError>,
) -> Result<Tally, SettingsError> {
    let mut tally = measured(own)?;
    tally.take_max(&measured(other)?);
    Ok(tally)
}

/// A call's result and its instructions, less those of counting. Inputs and results pass a black box, or the
/// compiler would move their computation and use in between.
#[inline(always)]
pub fn counted<T>(instructions: &Instructions, work: impl FnOnce() -> T) -> (T, u32) {
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
pub struct Single<I: Identify<f32>> {
    counter: Counter<u16>,
    /// The loop.
    pub servo_loop: Loop<I>,
    /// Its state.
    pub state: ServoLoopState<f32, <LowPass<f32> as VelocityEstimate<f32>>::State, I::State>,
}

impl<I: Identify<f32> + FromSettings> Single<I> {
    /// Builds it from settings.
    ///
    /// # Errors
    /// Settings that are not allowed.
    pub fn build(settings: &Settings) -> Result<Self, SettingsError> {
        let servo_loop: Loop<I> = settings.build()?;
        Ok(Self {
            counter: Counter::new(0),
            state: servo_loop.start(0),
            servo_loop,
        })
    }

    /// A sample that is not inlined.
    #[inline(never)]
    pub fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        self.step(setpoint, offset, register)
    }

    /// The same in one call of the loop.
    #[inline(never)]
    pub fn whole(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        let count = self.counter.read(register);
        let step = self
            .servo_loop
            .process(&mut self.state, setpoint, offset, count);
        step.map_or(0.0, |step| step.control.command)
    }

    /// As in a drive, which acts between control and learning.
    #[inline(always)]
    pub fn step(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
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
    pub fn counted(
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

/// A PID in single precision with its counter and its state, of a firmware that identifies nothing.
pub struct Pid {
    counter: Counter<u16>,
    controller: Controller<f32, Filter>,
    /// Its state.
    pub state: ControlState<f32, <Filter as VelocityEstimate<f32>>::State>,
}

impl Pid {
    /// Builds it from settings.
    ///
    /// # Errors
    /// Settings that are not allowed.
    pub fn build(settings: &Settings) -> Result<Self, SettingsError> {
        let controller: Controller<f32, Filter> = settings.build()?;
        Ok(Self {
            counter: Counter::new(0),
            state: controller.start(),
            controller,
        })
    }

    /// A sample that is not inlined: its command.
    #[inline(never)]
    pub fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        self.step(setpoint, offset, register)
            .map_or(0.0, |sample| sample.command)
    }

    /// The same with the velocity, as a firmware shows it.
    #[inline(never)]
    pub fn shown(&mut self, setpoint: i32, offset: f32, register: u16) -> (f32, f32) {
        self.step(setpoint, offset, register)
            .map_or((0.0, 0.0), |sample| (sample.command, sample.velocity))
    }

    #[inline(always)]
    fn step(
        &mut self,
        setpoint: i32,
        offset: f32,
        register: u16,
    ) -> Result<ControlSample<f32>, StepError> {
        let moved = self.counter.moved(register);
        let count = self.counter.count();
        let increment = self.controller.increment(moved);
        let error = self.controller.error(setpoint, offset, count);
        self.controller.process(&mut self.state, error, increment)
    }
}

/// The loop in fixed point with its counter and its state.
pub struct Words {
    counter: Counter<u16>,
    /// The loop.
    pub servo_loop: Fixed,
    /// Its state.
    pub state: FixedLoopState,
}

impl Words {
    /// Builds it from settings.
    ///
    /// # Errors
    /// Settings that are not allowed.
    // Compiled where it is called, which builds the loop by itself too: once.
    #[inline]
    pub fn build(settings: &Settings) -> Result<Self, SettingsError> {
        let servo_loop: Fixed = settings.build()?;
        Ok(Self {
            counter: Counter::new(0),
            state: servo_loop.start(0),
            servo_loop,
        })
    }

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

    /// The same in one call of the loop.
    #[inline(never)]
    fn whole(&mut self, setpoint: i32, offset: I16F16, register: u16) -> Word {
        let count = self.counter.read(register);
        let step = self
            .servo_loop
            .process(&mut self.state, setpoint, offset, count);
        step.map_or(Word::ZERO, |step| step.control.command)
    }

    /// Runs a sample, in one call of the loop or in two, and counts its instructions.
    pub fn counted(
        &mut self,
        instructions: &Instructions,
        (reference, register): (f64, u16),
        at_once: bool,
    ) -> (f64, u32) {
        let Setpoint { count, offset } = Setpoint::from_counts(reference);
        let (count, offset, register) = black_box((count, offset, register));
        let (command, taken) = if at_once {
            counted(instructions, || self.whole(count, offset, register))
        } else {
            counted(instructions, || self.sample(count, offset, register))
        };
        (self.servo_loop.controller().command(command), taken)
    }
}

/// A reference as whole counts and an offset, with the register unchanged.
pub fn split((reference, register): (f64, u16)) -> (i32, f32, u16) {
    let whole = reference as i32;
    (whole, (reference - f64::from(whole)) as f32, register)
}

/// Gauss–Newton's halves, as a drive keeps them, with the block or fit that is on its way between them.
pub struct Halves<S: IdentifiableSet<P>, const P: usize> {
    /// The interrupt's half.
    pub interrupt: Single<GaussNewton<S, P>>,
    fitter: Fitter<S, P>,
    fitting: GaussNewtonFitterState<f32, 64>,
    fitted: Option<GaussNewtonFitted<f32>>,
    block: Option<NumberedBlock<f32>>,
}

impl<S: IdentifiableSet<P>, const P: usize> Halves<S, P> {
    /// Builds it from settings.
    ///
    /// # Errors
    /// Settings that are not allowed.
    pub fn build(settings: &Settings) -> Result<Self, SettingsError> {
        let fitter: Fitter<S, P> = settings.build()?;
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
        if let Some(completed) = identifier.take_block(interrupt.state.identification_mut()) {
            *block = Some(completed);
        }
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

    /// True while the recursion runs.
    #[must_use]
    pub fn is_running(&self) -> bool {
        let identifier = self.interrupt.servo_loop.identifier();
        identifier.is_running(self.interrupt.state.identification())
    }

    /// Runs a sample and counts the interrupt's instructions, and the background's apart.
    pub fn counted(
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
