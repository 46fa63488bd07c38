//! The core's PID with an identifier.

use identifier_core::constants::Configuration;
use identifier_core::control::{ControlSample, Controller, Shaped, ShapedState};
use identifier_core::identifier::{Identify, ServoLoop, ServoLoopState};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::settings::FromSettings;

use crate::Prototype;
use crate::constants::configuration;
use crate::identifier::{Identifies, NumberOfC, Readiness};
use crate::object::{Content, Object, check, content, fill, given, storage};
use crate::settings::Settings;
use crate::status::{self, Error, of_step};

/// A loop, its state, and the sample of the controller that nothing was learnt from yet.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Closed<L, T, C> {
    servo_loop: L,
    state: T,
    sample: Option<C>,
}

type Loop<N, I> = ServoLoop<N, LowPass<N>, I, Shaped<N>>;
type StateOf<N> = <LowPass<N> as VelocityEstimate<N>>::State;
type State<N, I> = ServoLoopState<N, StateOf<N>, <I as Identify<N>>::State, ShapedState<N>>;

/// The loop of an identifier.
pub type InnerOf<N, I> = Closed<Loop<N, I>, State<N, I>, ControlSample<N>>;

impl<N: NumberOfC, I: Readiness<N>> Identifies<N> for InnerOf<N, I>
where
    Self: Content,
{
    type Identifier = I;

    fn parts(&self) -> (&I, &I::State) {
        (self.servo_loop.identifier(), self.state.identification())
    }
}

unsafe fn build<N: NumberOfC, I: Identify<N> + FromSettings>(
    object: *mut Object<InnerOf<N, I>>,
    size: u32,
    settings: *const Settings,
    count: i32,
) -> Result<i32, Error>
where
    Controller<N, LowPass<N>, Shaped<N>>: FromSettings,
    InnerOf<N, I>: Content,
{
    // SAFETY: guaranteed by the caller.
    unsafe {
        let object = storage(object, size)?;
        let servo_loop: Loop<N, I> = given(settings)?.build()?;
        let closed = Closed {
            state: servo_loop.start(count),
            servo_loop,
            sample: None,
        };
        fill(object, closed);
    }
    Ok(status::OK)
}

#[inline(always)]
unsafe fn from_constants<N: NumberOfC, I: Readiness<N>>(
    object: *mut Object<InnerOf<N, I>>,
    size: u32,
    constants: *const u32,
    words: u32,
    count: i32,
) -> Result<i32, i32>
where
    Loop<N, I>: Configuration,
    InnerOf<N, I>: Content,
{
    // SAFETY: guaranteed by the caller.
    unsafe {
        let object = storage(object, size)?;
        let (servo_loop, known): (Loop<N, I>, I::Known) = configuration(constants, words)?;
        let mut state = servo_loop.start(count);
        (servo_loop.identifier()).begin(state.identification_mut(), &known);
        let closed = Closed {
            servo_loop,
            state,
            sample: None,
        };
        fill(object, closed);
    }
    Ok(status::OK)
}

/// The first half of a sample with its `setpoint`, offset and `count`, or with `LEARNS` all of it. Writes the command, zero
/// where it is refused.
#[inline(always)]
unsafe fn sample<N: NumberOfC, I: Identify<N>, const LEARNS: bool>(
    object: *mut Object<InnerOf<N, I>>,
    (setpoint, offset, count): (i32, N::C, i32),
    command: *mut N::C,
) -> Result<i32, i32>
where
    InnerOf<N, I>: Content,
{
    check(command)?;
    let done = || {
        // SAFETY: guaranteed by the caller.
        let own = unsafe { content(object) }?;
        // It takes the place of one that nothing was learnt from.
        own.sample = None;
        let (servo_loop, state) = (&own.servo_loop, &mut own.state);
        let offset = N::offset(offset);
        if LEARNS {
            let step = servo_loop.process(state, setpoint, offset, count);
            let step = step.map_err(of_step)?;
            return Ok((step.control.command, step.seen.event as i32));
        }
        let sample = servo_loop.control(state, setpoint, offset, count);
        let sample = own.sample.insert(sample.map_err(of_step)?);
        Ok((sample.command, status::OK))
    };
    let (written, answer) = match done() {
        Ok((command, event)) => (command.to_c(), Ok(event)),
        Err(refused) => (N::C::default(), Err(refused)),
    };
    // SAFETY: guaranteed by the caller; it was checked.
    unsafe { command.write(written) };
    answer
}

/// The functions of a loop with numbers of a type, and further functions.
macro_rules! closed {
    ($name:ident $object:ident: $identifier:ty, $number:ty, $c:ty, $mark:literal, $words:literal words; $($more:tt)*) => {
        use super::InnerOf;
        use crate::identifier::NumberOfC;

        identifying! {
            $name $object: InnerOf<$number, $identifier>, $number, $c, $mark, $words words;

            /// Builds it from settings, at rest at a count.
            fn [<servo_id_ $name _init>](
                object: *mut $object,
                size: u32,
                settings: *const Settings,
                count: i32,
                error: *mut Error,
            ) {
                // SAFETY: the header's conditions.
                unsafe { answered(error, super::build(object, size, settings, count)) }
            }

            /// Builds it from constants, at rest at a count.
            fn [<servo_id_ $name _init_from_constants>](
                object: *mut $object,
                size: u32,
                constants: *const u32,
                words: u32,
                count: i32,
            ) {
                // SAFETY: the header's conditions.
                unsafe { super::from_constants(object, size, constants, words, count) }
            }

            /// A sample: the command, zero where it is refused.
            fn [<servo_id_ $name _process>](
                object: *mut $object,
                setpoint: i32,
                offset: $c,
                count: i32,
                command: *mut $c,
            ) {
                // SAFETY: the header's conditions.
                unsafe { super::sample::<_, _, true>(object, (setpoint, offset, count), command) }
            }

            /// The first half of a sample: the command, zero where it is refused.
            fn [<servo_id_ $name _control>](
                object: *mut $object,
                setpoint: i32,
                offset: $c,
                count: i32,
                command: *mut $c,
            ) {
                // SAFETY: the header's conditions.
                unsafe { super::sample::<_, _, false>(object, (setpoint, offset, count), command) }
            }

            /// The second half, with the command that acts.
            fn [<servo_id_ $name _learn>](object: *mut $object, acted: $c) {
                // SAFETY: the header's conditions.
                let own = unsafe { content(object) }?;
                let sample = own.sample.take().ok_or(crate::status::NO_SAMPLE)?;
                let acted = NumberOfC::from_c(acted);
                let update = own.servo_loop.learn_with(&mut own.state, &sample, acted);
                update.map(|update| update.event as i32).map_err(of_step)
            }

            /// Background work: at most this number of blocks of a first fit, or a piece of the motion.
            fn [<servo_id_ $name _work>](object: *mut $object, blocks: u32) {
                // SAFETY: the header's conditions.
                let own = unsafe { content(object) }?;
                own.servo_loop.work(&mut own.state, blocks);
                Ok(crate::status::OK)
            }

            $($more)*
        }
    };
}

/// The same for fixed point, where a command is a word.
macro_rules! closed_on_words {
    ($name:ident $object:ident: $identifier:ty, $mark:literal, $words:literal words;) => {
        use identifier_core::fixed_point::Word;

        use crate::object::{shared, write};

        closed! {
            $name $object: $identifier, Word, i32, $mark, $words words;

            /// Command units of a word's last bit.
            fn [<servo_id_ $name _scale>](object: *const $object, scale: *mut f64) {
                // SAFETY: the header's conditions.
                let own = unsafe { shared(object) }?;
                let last_bit = own.servo_loop.identifier().command(Word::from_bits(1));
                // SAFETY: the header's conditions.
                unsafe { write(scale, last_bit) }?;
                Ok(crate::status::OK)
            }
        }
    };
}

/// With the paper's estimator of a and b.
pub mod gradient {
    closed! { gradient_loop GradientLoop: identifier_core::Gradient<f32, 2>, f32, f32, 0x5e1d_0012, 236 words; }
}

/// The same with Coulomb friction.
pub mod gradient_coulomb {
    closed! {
        gradient_coulomb_loop GradientCoulombLoop: identifier_core::Gradient<f32, 3>, f32, f32, 0x5e1d_0013, 250 words;
    }
}

/// With Gauss–Newton.
pub mod gauss_newton {
    closed! { gauss_newton_loop GaussNewtonLoop: identifier_core::GaussNewton, f32, f32, 0x5e1d_0014, 690 words; }
}

/// With the paper's estimator of a and b in fixed point.
pub mod fixed_point {
    closed_on_words! { fixed_loop FixedLoop: identifier_core::Gradient<Word, 2>, 0x5e1d_0015, 252 words; }
}

/// The same with Coulomb friction.
pub mod fixed_point_coulomb {
    closed_on_words! { fixed_coulomb_loop FixedCoulombLoop: identifier_core::Gradient<Word, 3>, 0x5e1d_0016, 268 words; }
}

/// The lists of all of them.
pub(crate) const FACES: [&[Prototype]; 5] = [
    gradient::FACE,
    gradient_coulomb::FACE,
    gauss_newton::FACE,
    fixed_point::FACE,
    fixed_point_coulomb::FACE,
];
