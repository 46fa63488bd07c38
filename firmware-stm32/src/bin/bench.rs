//! Instructions per whole sample (on the chip: cycles), per law and number format: from the register
//! of the encoder's counter, with a setpoint and an offset, to the command and the estimates.
#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use firmware_stm32::host::{Text, exit, say};
use firmware_stm32::instructions::Counter as Instructions;
use firmware_stm32::paper;
use fixed::types::I16F16;
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::{
    FixedLowPass, FixedServoLoop, FixedServoLoopState, FixedVelocity, Word, split_setpoint,
};
use identifier_core::identifier::{
    DiagonalGradientIdentifier, IdentifierError, Identify, ServoLoop, ServoLoopState,
};
use identifier_core::measurement::counter::Counter;
use identifier_core::measurement::velocity::{LowPass, LowPassState};
use identifier_core::parameters::{Ab, AbCoulomb};
use identifier_core::settings::FromSettings;

type Filter = LowPass<f32>;

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
    single::<DiagonalGradientIdentifier<f32, Filter, Ab, 2>>(instructions, "gradient-f32-2")?;
    single::<DiagonalGradientIdentifier<f32, Filter, AbCoulomb, 3>>(
        instructions,
        "gradient-f32-friction",
    )?;
    words(instructions)
}

/// Runs the paper's loop with `sample`, which gets a reference in counts and the counter's register
/// and answers with the command and the instructions that it took.
fn measure(
    name: &str,
    state_bytes: usize,
    mut sample: impl FnMut(f64, u16) -> (f64, u32),
) -> Result<(), IdentifierError> {
    let reference = paper::reference()?;
    let (mut plant, encoder) = paper::servo();
    let mut wanted = Excitation::<f64>::start(&reference);
    let mut total = 0_u32;
    let mut most = 0_u32;
    for k in 0..STARTING + COUNTED {
        let next: f64 = reference.process(&mut wanted);
        // The register has the low bits only.
        let (command, taken) = sample(next, encoder.read(plant.position) as u16);
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
    servo_loop: ServoLoop<f32, Filter, I>,
    state: ServoLoopState<f32, LowPassState<f32>, I::State>,
}

impl<I: Identify<f32>> Single<I> {
    #[inline(never)]
    fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        let count = self.counter.read(register);
        // As in a drive, which acts in between.
        let control = self
            .servo_loop
            .control(&mut self.state, setpoint, offset, count);
        control.map_or(0.0, |sample| {
            self.servo_loop.learn(&mut self.state, &sample);
            sample.command
        })
    }
}

fn single<I: Identify<f32> + FromSettings>(
    instructions: &Instructions,
    name: &str,
) -> Result<(), IdentifierError> {
    let servo_loop: ServoLoop<f32, Filter, I> = paper::settings().build()?;
    let mut parts = Single {
        counter: Counter::new(0),
        state: servo_loop.start(0),
        servo_loop,
    };
    measure(name, size_of::<I::State>(), |reference, register| {
        let whole = reference as i32;
        let offset = (reference - f64::from(whole)) as f32;
        let (whole, offset, register) = black_box((whole, offset, register));
        let (command, taken) = counted(instructions, || parts.sample(whole, offset, register));
        (f64::from(command), taken)
    })
}

/// The loop in fixed point with its counter and its state.
struct Words {
    counter: Counter<u16>,
    servo_loop: FixedServoLoop<FixedLowPass, Ab, 2>,
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
    let servo_loop: FixedServoLoop<FixedLowPass, Ab, 2> = paper::settings().build()?;
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
