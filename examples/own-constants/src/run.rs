#[cfg(any(not(feature = "built"), feature = "compare"))]
use identifier_core::constants::Constants;
use identifier_core::identifier::MachineEstimates;
use identifier_core::parameters::{Parameter, PerParameter};

use crate::settings::{Configuration, Known, Loop};

/// Refused by the compiler if it is not what the build script wrote.
#[cfg(any(not(feature = "built"), feature = "compare"))]
pub(crate) const CONSTANTS: Constants<Configuration> =
    match Constants::new(include!(concat!(env!("OUT_DIR"), "/words.rs"))) {
        Ok(constants) => constants,
        Err(error) => panic!("{}", error.remedy()),
    };

/// The number that the loop computes in.
#[cfg(not(feature = "fixed-point"))]
pub(crate) type Number = f32;
#[cfg(feature = "fixed-point")]
pub(crate) type Number = identifier_core::fixed_point::Word;

/// Runs a loop: `sample` takes command and estimates of the sample before, in machine units, and gives the next count; it
/// ends the run with none.
#[inline(always)]
pub(crate) fn drive(
    (servo_loop, known): &Configuration,
    mut sample: impl FnMut(Number, &PerParameter<Number>, &Loop) -> Option<(i32, i32)>,
) {
    let mut state = servo_loop.start(0);
    begin(servo_loop, known, &mut state);
    let mut command = Number::default();
    loop {
        let identifier = servo_loop.identifier();
        let estimates = identifier.machine_estimates(state.identification());
        let Some((setpoint, count)) = sample(command, &estimates, servo_loop) else {
            return;
        };
        command = match servo_loop.process(&mut state, setpoint, Default::default(), count) {
            Ok(step) => step.control.command,
            Err(_) => Number::default(),
        };
    }
}

#[cfg(not(feature = "gauss-newton"))]
fn begin<T>(_: &Loop, (): &Known, _: &mut T) {}

#[cfg(feature = "gauss-newton")]
fn begin(servo_loop: &Loop, known: &Known, state: &mut State) {
    *state.identification_mut() = servo_loop.identifier().start_from(known);
}

#[cfg(feature = "gauss-newton")]
type State = identifier_core::identifier::ServoLoopState<
    f32,
    <identifier_core::measurement::LowPass<f32> as identifier_core::measurement::VelocityEstimate<
        f32,
    >>::State,
    <identifier_core::identifier::GaussNewtonRecursion<
        f32,
        identifier_core::parameters::AbCoulombLoad,
        4,
    > as identifier_core::identifier::Identify<f32>>::State,
>;

/// The bits of a number.
#[cfg(not(feature = "fixed-point"))]
pub(crate) fn bits(number: Number) -> u32 {
    number.to_bits()
}
#[cfg(feature = "fixed-point")]
pub(crate) fn bits(number: Number) -> u32 {
    number.to_bits().cast_unsigned()
}

#[cfg(not(feature = "built"))]
fn configuration() -> Option<Configuration> {
    Some(CONSTANTS.build())
}
#[cfg(feature = "built")]
fn configuration() -> Option<Configuration> {
    crate::settings::build().ok()
}

/// The loop on the chip's registers.
#[cfg_attr(
    feature = "compare",
    allow(dead_code, reason = "the comparison has a servo of its own")
)]
pub(crate) fn run() {
    const COUNTER: *const i32 = 0x4000_0024 as *const i32;
    const COMPARE: *mut u32 = 0x4000_0434 as *mut u32;
    const REPORT: *mut u32 = 0x4000_2850 as *mut u32;
    let Some(configuration) = configuration() else {
        return;
    };
    drive(&configuration, |command, estimates, _| {
        // SAFETY: TIM2 counts the encoder, TIM3 makes the PWM, and the RTC's backup registers are free.
        unsafe {
            COMPARE.write_volatile(bits(command));
            for (place, parameter) in Parameter::ALL.into_iter().enumerate() {
                REPORT
                    .add(place)
                    .write_volatile(bits(estimates.get(parameter)));
            }
            Some((1000, COUNTER.read_volatile()))
        }
    });
}
