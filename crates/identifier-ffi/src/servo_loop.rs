//! The core's PID with an identifier.

use crate::Prototype;
use crate::object::check;

/// A loop, its state, and the sample of the controller that nothing was learnt from yet.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Closed<L, T, C> {
    servo_loop: L,
    state: T,
    sample: Option<C>,
}

impl<L, T, C> Closed<L, T, C> {
    /// The loop and its state for the next sample. It takes the place of one that nothing was learnt from.
    fn next_sample(&mut self) -> (&L, &mut T) {
        self.sample = None;
        (&self.servo_loop, &mut self.state)
    }
}

/// Writes a command with its status, zero where it is refused.
///
/// # Safety
/// An address that is neither null nor misaligned may be written.
#[inline(always)]
unsafe fn commanded<C: Default>(
    address: *mut C,
    sample: impl FnOnce() -> Result<(C, i32), i32>,
) -> Result<i32, i32> {
    check(address)?;
    let (command, answer) = match sample() {
        Ok((command, event)) => (command, Ok(event)),
        Err(status) => (C::default(), Err(status)),
    };
    // SAFETY: guaranteed by the caller; it was checked.
    unsafe { address.write(command) };
    answer
}

/// The functions of a loop with numbers of a type: offsets and commands as the caller has them, and back.
macro_rules! closed {
    (
        $object:ident: $servo_loop:ty, $state:ty, $mark:literal, $words:literal words;
        $init:ident $process:ident $control:ident $learn:ident $estimates:ident
        $init_from_constants:ident $machine_estimates:ident;
        $identifier:ty, $number:ty: |$offset:ident: $c_offset:ty| $as_offset:expr;
        |$acted:ident: $c_number:ty| $as_number:expr; |$word:ident| $as_c:expr;
        $($more:tt)*
    ) => {
        use identifier_core::control::ControlSample;

        use identifier_core::identifier::MachineEstimates;

        use super::{Closed, commanded};
        use crate::constants::{InC, configuration};
        use crate::identifier::{Estimates, Readiness};
        use crate::object::{Content, Object, answered, content, fill, shared, storage, write};
        use crate::settings::{Settings, given};
        use crate::status::{self, Error, of_step};

        type Loop = $servo_loop;

        /// The loop and its state.
        pub type Inner = Closed<Loop, $state, ControlSample<$number>>;

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
            count: i32,
        ) -> Result<i32, Error> {
            // SAFETY: guaranteed by the caller.
            unsafe {
                let object = storage(object, size)?;
                let servo_loop: Loop = given(settings)?.build()?;
                let state = servo_loop.start(count);
                fill(object, Closed { servo_loop, state, sample: None });
            }
            Ok(status::OK)
        }

        face! {
            /// Builds it from settings, at rest at a count.
            fn $init(
                object: *mut $object,
                size: u32,
                settings: *const Settings,
                count: i32,
                error: *mut Error,
            ) {
                // SAFETY: the header's conditions.
                unsafe { answered(error, build(object, size, settings, count)) }
            }

            /// Builds it from constants, at rest at a count.
            fn $init_from_constants(
                object: *mut $object,
                size: u32,
                constants: *const u32,
                words: u32,
                count: i32,
            ) {
                // SAFETY: the header's conditions.
                unsafe {
                    let object = storage(object, size)?;
                    let (servo_loop, known): (Loop, <$identifier as Readiness<$number>>::Known) =
                        configuration(constants, words)?;
                    let mut state = servo_loop.start(count);
                    servo_loop.identifier().begin(state.identification_mut(), &known);
                    fill(object, Closed { servo_loop, state, sample: None });
                }
                Ok(status::OK)
            }

            /// A sample: the command, zero where it is refused.
            fn $process(
                object: *mut $object,
                setpoint: i32,
                $offset: $c_offset,
                count: i32,
                command: *mut $c_number,
            ) {
                // SAFETY: the header's conditions.
                unsafe {
                    commanded(command, || {
                        let (servo_loop, state) = content(object)?.next_sample();
                        let step = servo_loop.process(state, setpoint, $as_offset, count);
                        let step = step.map_err(of_step)?;
                        let $word = step.control.command;
                        Ok(($as_c, step.seen.event as i32))
                    })
                }
            }

            /// The first half of a sample: the command, zero where it is refused.
            fn $control(
                object: *mut $object,
                setpoint: i32,
                $offset: $c_offset,
                count: i32,
                command: *mut $c_number,
            ) {
                // SAFETY: the header's conditions.
                unsafe {
                    commanded(command, || {
                        let own = content(object)?;
                        let (servo_loop, state) = own.next_sample();
                        let sample = servo_loop.control(state, setpoint, $as_offset, count).map_err(of_step)?;
                        own.sample = Some(sample);
                        let $word = sample.command;
                        Ok(($as_c, status::OK))
                    })
                }
            }

            /// The second half, with the command that acts.
            fn $learn(object: *mut $object, $acted: $c_number) {
                // SAFETY: the header's conditions.
                let own = unsafe { content(object) }?;
                let sample = own.sample.take().ok_or(status::NO_SAMPLE)?;
                let update = own.servo_loop.learn_with(&mut own.state, &sample, $as_number);
                update.map(|update| update.event as i32).map_err(of_step)
            }

            /// The estimates.
            fn $estimates(object: *const $object, estimates: *mut Estimates) {
                // SAFETY: the header's conditions.
                let own = unsafe { shared(object) }?;
                let (identifier, state) = (own.servo_loop.identifier(), own.state.identification());
                let found = Estimates::of(identifier, state);
                // SAFETY: the header's conditions.
                unsafe { write(estimates, found) }?;
                Ok(identifier.readiness(state))
            }

            /// The estimates in machine units.
            fn $machine_estimates(object: *const $object, machine: *mut $c_number) {
                // SAFETY: the header's conditions.
                let own = unsafe { shared(object) }?;
                let (identifier, state) = (own.servo_loop.identifier(), own.state.identification());
                let found = identifier.machine_estimates(state).in_c();
                // SAFETY: the header's conditions.
                unsafe { write(machine.cast(), found) }?;
                Ok(identifier.readiness(state))
            }

            $($more)*
        }
    };
}

/// The same for floating point.
macro_rules! closed_on_numbers {
    (
        $object:ident: $identifier:ty, $mark:literal, $words:literal words;
        $init:ident $process:ident $control:ident $learn:ident $estimates:ident
        $init_from_constants:ident $machine_estimates:ident;
        $($more:tt)*
    ) => {
        use identifier_core::control::{Shaped, ShapedState};
        use identifier_core::identifier::{Identify, ServoLoop, ServoLoopState};
        use identifier_core::measurement::{LowPass, VelocityEstimate};

        closed! {
            $object: ServoLoop<f32, LowPass<f32>, $identifier, Shaped<f32>>,
            ServoLoopState<
                f32,
                <LowPass<f32> as VelocityEstimate<f32>>::State,
                <$identifier as Identify<f32>>::State,
                ShapedState<f32>,
            >,
            $mark, $words words;
            $init $process $control $learn $estimates $init_from_constants $machine_estimates;
            $identifier, f32: |offset: f32| offset; |acted: f32| acted; |command_of_loop| command_of_loop;
            $($more)*
        }
    };
}

/// The same for fixed point, where a command is a word.
macro_rules! closed_on_words {
    (
        $object:ident: $parameters:literal, $mark:literal, $words:literal words;
        $init:ident $process:ident $control:ident $learn:ident $estimates:ident $scale:ident
        $init_from_constants:ident $machine_estimates:ident;
    ) => {
        use fixed::types::I16F16;
        use identifier_core::control::{Shaped, ShapedState};
        use identifier_core::fixed_point::{self, FixedLoopState, Word};
        use identifier_core::Gradient;

        closed! {
            $object: fixed_point::FixedLoop<$parameters, Shaped<Word>>,
            FixedLoopState<$parameters, ShapedState<Word>>,
            $mark, $words words;
            $init $process $control $learn $estimates $init_from_constants $machine_estimates;
            Gradient<Word, $parameters>, Word: |offset: i32| I16F16::from_bits(offset); |acted: i32| Word::from_bits(acted);
            |word| word.to_bits();

            /// Command units of a word's last bit.
            fn $scale(object: *const $object, scale: *mut f64) {
                // SAFETY: the header's conditions.
                let own = unsafe { shared(object) }?;
                let last_bit = own.servo_loop.identifier().command(Word::from_bits(1));
                // SAFETY: the header's conditions.
                unsafe { write(scale, last_bit) }?;
                Ok(status::OK)
            }
        }
    };
}

/// With the paper's estimator of a and b.
pub mod gradient {
    use identifier_core::identifier::GradientIdentifier;
    use identifier_core::parameters::Unknowns;

    closed_on_numbers! {
        GradientLoop: GradientIdentifier<f32, LowPass<f32>, Unknowns<2>, 2>, 0x5e1d_0012, 76 words;
        servo_id_gradient_loop_init servo_id_gradient_loop_process servo_id_gradient_loop_control
        servo_id_gradient_loop_learn servo_id_gradient_loop_estimates
        servo_id_gradient_loop_init_from_constants servo_id_gradient_loop_machine_estimates;
    }
}

/// The same with Coulomb friction.
pub mod gradient_coulomb {
    use identifier_core::identifier::GradientIdentifier;
    use identifier_core::parameters::Unknowns;

    closed_on_numbers! {
        GradientCoulombLoop: GradientIdentifier<f32, LowPass<f32>, Unknowns<3>, 3>, 0x5e1d_0013, 90 words;
        servo_id_gradient_coulomb_loop_init servo_id_gradient_coulomb_loop_process
        servo_id_gradient_coulomb_loop_control servo_id_gradient_coulomb_loop_learn
        servo_id_gradient_coulomb_loop_estimates
        servo_id_gradient_coulomb_loop_init_from_constants servo_id_gradient_coulomb_loop_machine_estimates;
    }
}

/// With Gauss–Newton.
pub mod gauss_newton {
    use identifier_core::identifier::GaussNewtonIdentifier;
    use identifier_core::parameters::Unknowns;

    closed_on_numbers! {
        GaussNewtonLoop: GaussNewtonIdentifier<f32, Unknowns<4>, 4>, 0x5e1d_0014, 690 words;
        servo_id_gauss_newton_loop_init servo_id_gauss_newton_loop_process
        servo_id_gauss_newton_loop_control servo_id_gauss_newton_loop_learn
        servo_id_gauss_newton_loop_estimates
        servo_id_gauss_newton_loop_init_from_constants servo_id_gauss_newton_loop_machine_estimates;

        /// Continues the first fit by at most this number of blocks.
        fn servo_id_gauss_newton_loop_work(object: *mut GaussNewtonLoop, blocks: u32) {
            // SAFETY: the header's conditions.
            let own = unsafe { content(object) }?;
            let identifier = own.servo_loop.identifier();
            identifier.work(own.state.identification_mut(), blocks);
            Ok(status::OK)
        }
    }
}

/// With the paper's estimator of a and b in fixed point.
pub mod fixed_point {
    closed_on_words! {
        FixedLoop: 2, 0x5e1d_0015, 92 words;
        servo_id_fixed_loop_init servo_id_fixed_loop_process servo_id_fixed_loop_control
        servo_id_fixed_loop_learn servo_id_fixed_loop_estimates servo_id_fixed_loop_scale
        servo_id_fixed_loop_init_from_constants servo_id_fixed_loop_machine_estimates;
    }
}

/// The same with Coulomb friction.
pub mod fixed_point_coulomb {
    closed_on_words! {
        FixedCoulombLoop: 3, 0x5e1d_0016, 108 words;
        servo_id_fixed_coulomb_loop_init servo_id_fixed_coulomb_loop_process
        servo_id_fixed_coulomb_loop_control servo_id_fixed_coulomb_loop_learn
        servo_id_fixed_coulomb_loop_estimates servo_id_fixed_coulomb_loop_scale
        servo_id_fixed_coulomb_loop_init_from_constants servo_id_fixed_coulomb_loop_machine_estimates;
    }
}

/// The lists of all of them.
pub(crate) const FACES: [&[Prototype]; 5] = [
    gradient::FACE,
    gradient_coulomb::FACE,
    gauss_newton::FACE,
    fixed_point::FACE,
    fixed_point_coulomb::FACE,
];
