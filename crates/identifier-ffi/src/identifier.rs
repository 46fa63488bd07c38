//! Identifiers that listen to a controller of the caller's.

use identifier_core::constants::Configuration;
use identifier_core::identifier::Identify;
use identifier_core::parameters::{Parameter, PerParameter, ServoParameters};

use crate::Prototype;
use crate::status;

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

/// An identifier as it starts from constants, and whether it has estimates.
pub(crate) trait Readiness<N: Copy>: Identify<N> {
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

/// The functions of an identifier with numbers of a type, and further functions.
macro_rules! listening {
    (
        $object:ident: $identifier:ty, $mark:literal, $words:literal words;
        $init:ident $resume:ident $estimates:ident $init_from_constants:ident $machine_estimates:ident;
        $number:ty, $c_number:ty;
        $($more:tt)*
    ) => {
        use identifier_core::identifier::{Identify, MachineEstimates};

        use super::{Estimates, Listening, Readiness};
        use crate::constants::{InC, configuration};
        use crate::object::{Content, Object, content, fill, answered, shared, storage, write};
        use crate::settings::{Settings, given};
        use crate::status::{self, Error, of_step};

        type Identifier = $identifier;

        /// The identifier and its state.
        pub type Inner = Listening<Identifier, <Identifier as Identify<$number>>::State>;

        /// Its object in the header.
        pub type $object = Object<Inner>;

        impl Content for Inner {
            const MARK: u32 = $mark;
            const WORDS: usize = $words;
        }

        /// # Safety
        /// As the header says.
        unsafe fn build(
            object: *mut $object,
            size: u32,
            settings: *const Settings,
        ) -> Result<i32, Error> {
            // SAFETY: guaranteed by the caller.
            unsafe {
                let object = storage(object, size)?;
                let identifier: Identifier = given(settings)?.build()?;
                let state = identifier.start();
                fill(object, Listening { identifier, state });
            }
            Ok(status::OK)
        }

        face! {
            /// Builds it from settings.
            fn $init(
                object: *mut $object,
                size: u32,
                settings: *const Settings,
                error: *mut Error,
            ) {
                // SAFETY: the header's conditions.
                unsafe { answered(error, build(object, size, settings)) }
            }

            /// Builds it from constants.
            fn $init_from_constants(object: *mut $object, size: u32, constants: *const u32, words: u32) {
                // SAFETY: the header's conditions.
                unsafe {
                    let object = storage(object, size)?;
                    let (identifier, known): (Identifier, <Identifier as Readiness<$number>>::Known) =
                        configuration(constants, words)?;
                    let mut state = identifier.start();
                    identifier.begin(&mut state, &known);
                    fill(object, Listening { identifier, state });
                }
                Ok(status::OK)
            }

            /// Joins a motion after a gap.
            fn $resume(object: *mut $object, moved: i32) {
                // SAFETY: the header's conditions.
                let own = unsafe { content(object) }?;
                let increment = own.identifier.increment(moved);
                own.identifier.check(increment, Default::default()).map_err(of_step)?;
                own.identifier.resume_moving(&mut own.state, increment);
                Ok(status::OK)
            }

            /// The estimates.
            fn $estimates(object: *const $object, estimates: *mut Estimates) {
                // SAFETY: the header's conditions.
                let own = unsafe { shared(object) }?;
                let found = Estimates::of(&own.identifier, &own.state);
                // SAFETY: the header's conditions.
                unsafe { write(estimates, found) }?;
                Ok(own.identifier.readiness(&own.state))
            }

            /// The estimates in machine units.
            fn $machine_estimates(object: *const $object, machine: *mut $c_number) {
                // SAFETY: the header's conditions.
                let own = unsafe { shared(object) }?;
                let found = own.identifier.machine_estimates(&own.state).in_c();
                // SAFETY: the header's conditions.
                unsafe { write(machine.cast(), found) }?;
                Ok(own.identifier.readiness(&own.state))
            }

            $($more)*
        }
    };
}

/// The same for floating point, which takes increments of sensors that do not count.
macro_rules! listening_to_numbers {
    (
        $object:ident: $identifier:ty, $mark:literal, $words:literal words;
        $init:ident $sample:ident $resume:ident $estimates:ident $learn:ident
        $init_from_constants:ident $machine_estimates:ident;
        $($more:tt)*
    ) => {
        use identifier_core::number::Number;

        listening! {
            $object: $identifier, $mark, $words words;
            $init $resume $estimates $init_from_constants $machine_estimates;
            f32, f32;

            /// A sample.
            fn $sample(object: *mut $object, moved: i32, command: f32) {
                // One function for both: a second copy of the estimator would be called from here instead of being
                // inlined. SAFETY: the header's conditions.
                Ok(unsafe { $learn(object, f32::from_count(moved), command) })
            }

            /// A sample of a sensor that does not count.
            fn $learn(object: *mut $object, increment: f32, command: f32) {
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
    (
        $object:ident: $identifier:ty, $mark:literal, $words:literal words;
        $init:ident $sample:ident $resume:ident $estimates:ident $scale:ident
        $init_from_constants:ident $machine_estimates:ident;
    ) => {
        use identifier_core::fixed_point::Word;

        listening! {
            $object: $identifier, $mark, $words words;
            $init $resume $estimates $init_from_constants $machine_estimates;
            Word, i32;

            /// A sample.
            fn $sample(object: *mut $object, moved: i32, command: i32) {
                // SAFETY: the header's conditions.
                let own = unsafe { content(object) }?;
                let command = Word::from_bits(command);
                let update = own.identifier.process(&mut own.state, moved, command);
                update.map(|update| update.event as i32).map_err(of_step)
            }

            /// Command units of a word's last bit.
            fn $scale(object: *const $object, scale: *mut f64) {
                // SAFETY: the header's conditions.
                let own = unsafe { shared(object) }?;
                let last_bit = own.identifier.command(Word::from_bits(1));
                // SAFETY: the header's conditions.
                unsafe { write(scale, last_bit) }?;
                Ok(status::OK)
            }
        }
    };
}

/// The paper's estimator of a and b; the correction carries the load.
pub mod gradient {
    use identifier_core::identifier::GradientIdentifier;
    use identifier_core::measurement::LowPass;
    use identifier_core::parameters::Unknowns;

    listening_to_numbers! {
        Gradient: GradientIdentifier<f32, LowPass<f32>, Unknowns<2>, 2>, 0x5e1d_0002, 52 words;
        servo_id_gradient_init servo_id_gradient_sample servo_id_gradient_resume
        servo_id_gradient_estimates servo_id_gradient_learn
        servo_id_gradient_init_from_constants servo_id_gradient_machine_estimates;
    }

    impl Readiness<f32> for Identifier {
        type Known = ();
    }
}

/// The same with Coulomb friction.
pub mod gradient_coulomb {
    use identifier_core::identifier::GradientIdentifier;
    use identifier_core::measurement::LowPass;
    use identifier_core::parameters::Unknowns;

    listening_to_numbers! {
        GradientCoulomb: GradientIdentifier<f32, LowPass<f32>, Unknowns<3>, 3>, 0x5e1d_0003, 66 words;
        servo_id_gradient_coulomb_init servo_id_gradient_coulomb_sample servo_id_gradient_coulomb_resume
        servo_id_gradient_coulomb_estimates servo_id_gradient_coulomb_learn
        servo_id_gradient_coulomb_init_from_constants servo_id_gradient_coulomb_machine_estimates;
    }

    impl Readiness<f32> for Identifier {
        type Known = ();
    }
}

/// Recursive Gauss–Newton for a, b, Coulomb friction and load.
pub mod gauss_newton {
    use identifier_core::identifier::{GaussNewtonIdentifier, PreparedServo};
    use identifier_core::parameters::Unknowns;

    listening_to_numbers! {
        GaussNewton: GaussNewtonIdentifier<f32, Unknowns<4>, 4>, 0x5e1d_0004, 680 words;
        servo_id_gauss_newton_init servo_id_gauss_newton_sample servo_id_gauss_newton_resume
        servo_id_gauss_newton_estimates servo_id_gauss_newton_learn
        servo_id_gauss_newton_init_from_constants servo_id_gauss_newton_machine_estimates;

        /// Continues the first fit by at most this number of blocks.
        fn servo_id_gauss_newton_work(object: *mut GaussNewton, blocks: u32) {
            // SAFETY: the header's conditions.
            let own = unsafe { content(object) }?;
            own.identifier.work(&mut own.state, blocks);
            Ok(status::OK)
        }
    }

    impl Readiness<f32> for Identifier {
        type Known = PreparedServo<f32>;

        fn begin(&self, state: &mut Self::State, known: &Self::Known) {
            *state = self.start_from(known);
        }
    }
}

/// The paper's estimator of a and b in fixed point.
pub mod fixed {
    use identifier_core::identifier::GradientIdentifier;
    use identifier_core::measurement::LowPass;
    use identifier_core::parameters::Unknowns;

    listening_to_words! {
        Fixed: GradientIdentifier<Word, LowPass<Word>, Unknowns<2>, 2>, 0x5e1d_0005, 64 words;
        servo_id_fixed_init servo_id_fixed_sample servo_id_fixed_resume servo_id_fixed_estimates
        servo_id_fixed_scale
        servo_id_fixed_init_from_constants servo_id_fixed_machine_estimates;
    }

    impl Readiness<Word> for Identifier {
        type Known = ();
    }
}

/// The same with Coulomb friction.
pub mod fixed_coulomb {
    use identifier_core::identifier::GradientIdentifier;
    use identifier_core::measurement::LowPass;
    use identifier_core::parameters::Unknowns;

    listening_to_words! {
        FixedCoulomb: GradientIdentifier<Word, LowPass<Word>, Unknowns<3>, 3>, 0x5e1d_0006, 80 words;
        servo_id_fixed_coulomb_init servo_id_fixed_coulomb_sample servo_id_fixed_coulomb_resume
        servo_id_fixed_coulomb_estimates servo_id_fixed_coulomb_scale
        servo_id_fixed_coulomb_init_from_constants servo_id_fixed_coulomb_machine_estimates;
    }

    impl Readiness<Word> for Identifier {
        type Known = ();
    }
}

/// The lists of all of them.
pub(crate) const FACES: [&[Prototype]; 5] = [
    gradient::FACE,
    gradient_coulomb::FACE,
    gauss_newton::FACE,
    fixed::FACE,
    fixed_coulomb::FACE,
];
