//! Identifiers that listen to a controller of the caller's.

use ::fixed::types::I16F16;
use identifier_core::constants::Configuration;
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{Identify, MachineEstimates, PreparedServo};
use identifier_core::number::Arithmetic;
use identifier_core::parameters::{
    Parameter, ParameterSet, PerParameter, ServoParameters, Unknowns,
};
use identifier_core::settings::FromSettings;
use identifier_core::{GaussNewton, Gradient};

use crate::Prototype;
use crate::constants::configuration;
use crate::object::{Content, Object, content, fill, given, shared, storage, write};
use crate::settings::Settings;
use crate::status::{self, Error, of_step};

/// Estimates for a, b, Coulomb friction and load, SI: `servo_id_estimates` in the header.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Estimates {
    /// The estimates; zero for a parameter that the model does not have.
    pub value: [f64; 4],
    /// Their standard errors; NaN if the estimator has none.
    pub std_error: [f64; 4],
    /// One for an estimate at a bound, which is no result.
    pub at_bound: [i32; 4],
}

/// An identifier and its state.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Listening<I, T> {
    pub(crate) identifier: I,
    pub(crate) state: T,
}

fn in_order(of: ServoParameters) -> [f64; 4] {
    [of.a, of.b, of.coulomb, of.load]
}

impl Estimates {
    /// The estimates of an identifier by its state.
    pub(crate) fn of<N: Copy, I: Identify<N>>(identifier: &I, state: &I::State) -> Self {
        let snapshot = identifier.snapshot(state);
        let at_bounds: PerParameter<bool> = identifier.at_bounds_in(&snapshot);
        let errors = identifier.report(state).errors_of_parameters();
        let errors = errors.map(in_order);
        Self {
            value: in_order(identifier.estimates_in(&snapshot)),
            std_error: errors.unwrap_or([f64::NAN; 4]),
            at_bound: Parameter::ALL.map(|parameter| at_bounds.get(parameter).into()),
        }
    }
}

/// A number format of an identifier. In C a number of fixed point is an integer.
pub(crate) trait NumberOfC: Arithmetic + Default {
    /// A command, an offset of the setpoint, or an estimate in machine units.
    type C: Copy + Default;

    fn from_c(number: Self::C) -> Self;
    fn to_c(self) -> Self::C;
    fn offset(number: Self::C) -> Self::Offset;
}

impl NumberOfC for f32 {
    type C = Self;

    fn from_c(number: Self) -> Self {
        number
    }

    fn to_c(self) -> Self {
        self
    }

    fn offset(number: Self) -> Self {
        number
    }
}

impl NumberOfC for Word {
    type C = i32;

    fn from_c(number: i32) -> Self {
        Self::from_bits(number)
    }

    fn to_c(self) -> i32 {
        self.to_bits()
    }

    fn offset(number: i32) -> I16F16 {
        I16F16::from_bits(number)
    }
}

/// An identifier as it starts from constants, and whether it has estimates.
pub(crate) trait Readiness<N: Copy>: MachineEstimates<N> {
    /// The part of its constants besides the configuration.
    type Known: Configuration;

    /// Begins with what is known.
    fn begin(&self, _: &mut Self::State, _: &Self::Known) {}

    /// The status of the estimates: before a first fit they are no result.
    fn readiness(&self, state: &Self::State) -> i32 {
        match self.report(state).has_estimates {
            true => status::OK,
            false => status::NO_FIT,
        }
    }
}

impl<N: NumberOfC, const P: usize> Readiness<N> for Gradient<N, P>
where
    Unknowns<P>: ParameterSet<P>,
    Self: MachineEstimates<N>,
{
    type Known = ();
}

impl Readiness<f32> for GaussNewton {
    type Known = PreparedServo<f32>;

    fn begin(&self, state: &mut Self::State, known: &Self::Known) {
        *state = self.start_from(known);
    }
}

/// The content of an object that identifies.
pub(crate) trait Identifies<N: Copy>: Content {
    type Identifier: Readiness<N>;

    /// The identifier and its state.
    fn parts(&self) -> (&Self::Identifier, &<Self::Identifier as Identify<N>>::State);
}

impl<N: Copy, I: Readiness<N>> Identifies<N> for Listening<I, I::State>
where
    Self: Content,
{
    type Identifier = I;

    fn parts(&self) -> (&I, &I::State) {
        (&self.identifier, &self.state)
    }
}

/// # Safety
/// As the header says.
pub(crate) unsafe fn estimates<N: Copy, T: Identifies<N>>(
    object: *const Object<T>,
    estimates: *mut Estimates,
) -> Result<i32, i32> {
    // SAFETY: guaranteed by the caller.
    let (identifier, state) = unsafe { shared(object) }?.parts();
    // SAFETY: guaranteed by the caller.
    unsafe { write(estimates, Estimates::of(identifier, state)) }?;
    Ok(identifier.readiness(state))
}

/// # Safety
/// As the header says.
#[inline(always)]
pub(crate) unsafe fn machine_estimates<N: NumberOfC, T: Identifies<N>>(
    object: *const Object<T>,
    machine: *mut N::C,
) -> Result<i32, i32> {
    // SAFETY: guaranteed by the caller.
    let (identifier, state) = unsafe { shared(object) }?.parts();
    let found = identifier.machine_estimates(state);
    let found = [found.a, found.b, found.coulomb, found.load].map(N::to_c);
    // SAFETY: guaranteed by the caller.
    unsafe { write(machine.cast(), found) }?;
    Ok(identifier.readiness(state))
}

unsafe fn build<N: Copy, I: Identify<N> + FromSettings>(
    object: *mut Object<Listening<I, I::State>>,
    size: u32,
    settings: *const Settings,
) -> Result<i32, Error>
where
    Listening<I, I::State>: Content,
{
    // SAFETY: guaranteed by the caller.
    unsafe {
        let object = storage(object, size)?;
        let identifier: I = given(settings)?.build()?;
        let state = identifier.start();
        fill(object, Listening { identifier, state });
    }
    Ok(status::OK)
}

#[inline(always)]
unsafe fn from_constants<N: Copy, I: Readiness<N> + Configuration>(
    object: *mut Object<Listening<I, I::State>>,
    size: u32,
    constants: *const u32,
    words: u32,
) -> Result<i32, i32>
where
    Listening<I, I::State>: Content,
{
    // SAFETY: guaranteed by the caller.
    unsafe {
        let object = storage(object, size)?;
        let (identifier, known): (I, I::Known) = configuration(constants, words)?;
        let mut state = identifier.start();
        identifier.begin(&mut state, &known);
        fill(object, Listening { identifier, state });
    }
    Ok(status::OK)
}

unsafe fn resume<N: NumberOfC, I: Identify<N>>(
    object: *mut Object<Listening<I, I::State>>,
    moved: i32,
) -> Result<i32, i32>
where
    Listening<I, I::State>: Content,
{
    // SAFETY: guaranteed by the caller.
    let own = unsafe { content(object) }?;
    let increment = own.identifier.increment(moved);
    let checked = own.identifier.check(increment, N::default());
    checked.map_err(of_step)?;
    own.identifier.resume_moving(&mut own.state, increment);
    Ok(status::OK)
}

/// An object that identifies: its content, and its functions, those for its estimates first.
macro_rules! identifying {
    ($name:ident $object:ident: $inner:ty, $number:ty, $c:ty, $mark:literal, $words:literal words; $($more:tt)*) => {
        ::pastey::paste! {
            use crate::identifier::Estimates;
            use crate::object::{Content, Object, answered, content};
            use crate::settings::Settings;
            use crate::status::{Error, of_step};

            /// Its content.
            pub type Inner = $inner;

            /// Its object in the header.
            pub type $object = Object<Inner>;

            impl Content for Inner {
                const MARK: u32 = $mark;
                const WORDS: usize = $words;
            }

            face! {
                /// The estimates.
                fn [<servo_id_ $name _estimates>](object: *const $object, estimates: *mut Estimates) {
                    // SAFETY: the header's conditions.
                    unsafe { crate::identifier::estimates::<$number, _>(object, estimates) }
                }

                /// The estimates in machine units.
                fn [<servo_id_ $name _machine_estimates>](object: *const $object, machine: *mut $c) {
                    // SAFETY: the header's conditions.
                    unsafe { crate::identifier::machine_estimates::<$number, _>(object, machine) }
                }

                $($more)*
            }
        }
    };
}

/// The functions of an identifier with numbers of a type, and further functions.
macro_rules! listening {
    ($name:ident $object:ident: $identifier:ty, $number:ty, $c:ty, $mark:literal, $words:literal words; $($more:tt)*) => {
        use identifier_core::identifier::Identify;

        use super::Listening;

        type Identifier = $identifier;

        identifying! {
            $name $object: Listening<Identifier, <Identifier as Identify<$number>>::State>, $number, $c, $mark, $words words;

            /// Builds it from settings.
            fn [<servo_id_ $name _init>](
                object: *mut $object,
                size: u32,
                settings: *const Settings,
                error: *mut Error,
            ) {
                // SAFETY: the header's conditions.
                unsafe { answered(error, super::build::<$number, Identifier>(object, size, settings)) }
            }

            /// Builds it from constants.
            fn [<servo_id_ $name _init_from_constants>](
                object: *mut $object,
                size: u32,
                constants: *const u32,
                words: u32,
            ) {
                // SAFETY: the header's conditions.
                unsafe { super::from_constants::<$number, Identifier>(object, size, constants, words) }
            }

            /// Joins a motion after a gap.
            fn [<servo_id_ $name _resume>](object: *mut $object, moved: i32) {
                // SAFETY: the header's conditions.
                unsafe { super::resume::<$number, Identifier>(object, moved) }
            }

            /// Background work: at most this number of blocks of a first fit, or a piece of the motion.
            fn [<servo_id_ $name _work>](object: *mut $object, blocks: u32) {
                // SAFETY: the header's conditions.
                let own = unsafe { content(object) }?;
                own.identifier.work(&mut own.state, blocks);
                Ok(crate::status::OK)
            }

            $($more)*
        }
    };
}

/// The same for floating point, which takes increments of sensors that do not count.
macro_rules! listening_to_numbers {
    ($name:ident $object:ident: $identifier:ty, $mark:literal, $words:literal words; $($more:tt)*) => {
        use identifier_core::number::Number;

        listening! {
            $name $object: $identifier, f32, f32, $mark, $words words;

            /// A sample.
            fn [<servo_id_ $name _sample>](object: *mut $object, moved: i32, command: f32) {
                // One function for both: a second copy of the estimator would be called from here instead of being
                // inlined. SAFETY: the header's conditions.
                Ok(unsafe { [<servo_id_ $name _learn>](object, f32::from_count(moved), command) })
            }

            /// A sample of a sensor that does not count.
            fn [<servo_id_ $name _learn>](object: *mut $object, increment: f32, command: f32) {
                // SAFETY: the header's conditions.
                let own = unsafe { content(object) }?;
                let update = own.identifier.learn(&mut own.state, increment, command);
                update.map(|update| update.event as i32).map_err(of_step)
            }

            $($more)*
        }
    };
}

/// The same for fixed point, where a command is a word.
macro_rules! listening_to_words {
    ($name:ident $object:ident: $identifier:ty, $mark:literal, $words:literal words;) => {
        use identifier_core::fixed_point::Word;

        use crate::object::{shared, write};

        listening! {
            $name $object: $identifier, Word, i32, $mark, $words words;

            /// A sample.
            fn [<servo_id_ $name _sample>](object: *mut $object, moved: i32, command: i32) {
                // SAFETY: the header's conditions.
                let own = unsafe { content(object) }?;
                let command = Word::from_bits(command);
                let update = own.identifier.process(&mut own.state, moved, command);
                update.map(|update| update.event as i32).map_err(of_step)
            }

            /// Command units of a word's last bit.
            fn [<servo_id_ $name _scale>](object: *const $object, scale: *mut f64) {
                // SAFETY: the header's conditions.
                let own = unsafe { shared(object) }?;
                let last_bit = own.identifier.command(Word::from_bits(1));
                // SAFETY: the header's conditions.
                unsafe { write(scale, last_bit) }?;
                Ok(crate::status::OK)
            }
        }
    };
}

/// The paper's estimator of a and b; the correction carries the load.
pub mod gradient {
    listening_to_numbers! { gradient Gradient: identifier_core::Gradient<f32, 2>, 0x5e1d_0002, 212 words; }
}

/// The same with Coulomb friction.
pub mod gradient_coulomb {
    listening_to_numbers! { gradient_coulomb GradientCoulomb: identifier_core::Gradient<f32, 3>, 0x5e1d_0003, 226 words; }
}

/// Recursive Gauss–Newton for a, b, Coulomb friction and load.
pub mod gauss_newton {
    listening_to_numbers! { gauss_newton GaussNewton: identifier_core::GaussNewton, 0x5e1d_0004, 680 words; }
}

/// The paper's estimator of a and b in fixed point.
pub mod fixed {
    listening_to_words! { fixed Fixed: identifier_core::Gradient<Word, 2>, 0x5e1d_0005, 224 words; }
}

/// The same with Coulomb friction.
pub mod fixed_coulomb {
    listening_to_words! { fixed_coulomb FixedCoulomb: identifier_core::Gradient<Word, 3>, 0x5e1d_0006, 240 words; }
}

/// The lists of all of them.
pub(crate) const FACES: [&[Prototype]; 5] = [
    gradient::FACE,
    gradient_coulomb::FACE,
    gauss_newton::FACE,
    fixed::FACE,
    fixed_coulomb::FACE,
];
