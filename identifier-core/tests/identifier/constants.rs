//! Configurations as constants: the same bits as from the constructor, and refused if they are not what was written.

use crate::support::{Bench, shown};
use fixed::types::I16F16;
use identifier_core::constants::{Configuration, Constants, ConstantsError, words};
use identifier_core::fixed_point::{FixedLoop, Word};
use identifier_core::identifier::{
    ExpectedMotion, GaussNewtonIdentifier, GaussNewtonRecursion, GradientIdentifier, Identify,
    MachineEstimates, PreparedServo, ServoLoop,
};
use identifier_core::measurement::{AveragedDifference, BackwardDifference, LowPass};
use identifier_core::parameters::{
    AbLoad, IdentifiedServo, Parameter, ParameterSet, PerParameter, ServoParameters, Unknowns,
};
use identifier_core::settings::FromSettings;
use identifier_core::{GradientLoop, Settings};

type GaussNewtonLoop<I> = ServoLoop<f32, LowPass<f32>, I>;

const TRUTH: ServoParameters = ServoParameters::new(0.2174, 257.7, 6.0, -15.0);

/// The paper's gains, at a bandwidth and a resolution of a seed's choice.
fn settings(seed: u32) -> Settings {
    let part = f64::from(seed) / 16.0;
    let counts = 10_000.0 + 977.0 * f64::from(seed);
    let mut settings = Settings::new(1e-3 * (1.0 - 0.3 * part), counts)
        .with_pid(9.0 + part, 0.19, 4.0 - part, 10.0)
        .with_servo_range([0.0, 50.0], [110.0, 1000.0]);
    let identifier = &mut settings.identifier;
    identifier.initial.b = Some(150.0 + 100.0 * part);
    identifier.bounds.coulomb = Some([0.0, 100.0]);
    identifier.bounds.load = Some([-100.0, 100.0]);
    identifier.gamma = Some(PerParameter::new(20.0, 1000.0, 100.0, 100.0));
    settings
}

fn words_of<T: Configuration>(configuration: &T) -> Vec<u32> {
    let mut all = Vec::new();
    words(configuration, |word| all.push(word));
    all
}

/// A configuration as the constructor has it and as it is read from constants: every word of both is the same.
fn both<T: Configuration + FromSettings + PartialEq>(settings: &Settings) -> (T, T) {
    let built: T = settings.build().expect("valid");
    let written: &'static [u32] = words_of(&built).leak();
    assert_eq!(written.len(), Constants::<T>::WORDS);
    let constants = Constants::<T>::new(written).expect("written so");
    let read = constants.build();
    assert_eq!(words_of(&read), written);
    assert!(read == built && Constants::<T>::read(written) == Ok(read));
    (built, read)
}

/// The bits of commands and estimates of a run; `sample` is a sample of the loop, and returns the command.
fn bits(settings: &Settings, mut sample: impl FnMut(i32, i32) -> (f64, [f64; 4])) -> Vec<u64> {
    let mut bench = Bench::new(&TRUTH, settings, 0);
    let mut bits = Vec::new();
    for k in 0..2500 {
        let way = k % 680;
        let setpoint = 3 * if way < 340 { way } else { 680 - way };
        let (command, estimates) = sample(setpoint, bench.count());
        bench.plant.advance(command);
        bits.push(command.to_bits());
        bits.extend(estimates.map(f64::to_bits));
    }
    bits
}

fn in_order(of: ServoParameters) -> [f64; 4] {
    [of.a, of.b, of.coulomb, of.load]
}

fn run_floating<I: Identify<f32> + MachineEstimates<f32>>(
    settings: &Settings,
    servo_loop: &ServoLoop<f32, LowPass<f32>, I>,
) -> Vec<u64> {
    let mut state = servo_loop.start(0);
    bits(settings, |setpoint, count| {
        let step = servo_loop.process(&mut state, setpoint, 0.0, count);
        let identifier = servo_loop.identifier();
        identifier.work(state.identification_mut(), 8);
        let estimates = in_order(shown(identifier, state.identification()));
        let machine = identifier.machine_estimates(state.identification());
        for (parameter, si) in Parameter::ALL.into_iter().zip(estimates) {
            let found = f64::from(machine.get(parameter)) * identifier.machine_unit(parameter);
            let off = found - si;
            assert!(off.abs() <= 1e-6 * si.abs(), "{parameter:?}: {found}, {si}");
        }
        (step.expect("in range").control.command.into(), estimates)
    })
}

fn run_fixed<const P: usize>(settings: &Settings, servo_loop: &FixedLoop<P>) -> Vec<u64>
where
    Unknowns<P>: ParameterSet<P>,
{
    let mut state = servo_loop.start(0);
    bits(settings, |setpoint, count| {
        let step = servo_loop.process(&mut state, setpoint, I16F16::ZERO, count);
        let identifier = servo_loop.identifier();
        let estimates = in_order(shown(identifier, state.identification()));
        let machine = identifier.machine_estimates(state.identification());
        for (parameter, si) in Parameter::ALL.into_iter().zip(estimates) {
            let found = machine.get(parameter).to_num::<f64>();
            let off = found - si / identifier.machine_unit(parameter);
            let most = 2.0 * Word::DELTA.to_num::<f64>();
            assert!(off.abs() <= most, "{parameter:?}: {off}");
        }
        let command = step.expect("in range").control.command;
        (identifier.command(command), estimates)
    })
}

#[test]
fn a_loop_of_constants_has_the_bits_of_the_one_that_was_built() {
    for seed in 0..12 {
        let settings = settings(seed);
        macro_rules! same {
            ($run:ident, $($loop:ty),*) => {$(
                let (built, read) = both::<$loop>(&settings);
                assert_eq!($run(&settings, &read), $run(&settings, &built), "{}", stringify!($loop));
            )*};
        }
        same!(
            run_floating,
            GradientLoop<f32, 2>,
            GradientLoop<f32, 3>,
            ServoLoop<f32, LowPass<f32>, GradientIdentifier<f32, LowPass<f32>, AbLoad, 3>>,
            GradientLoop<f32, 4>,
            GaussNewtonLoop<GaussNewtonIdentifier<f32, Unknowns<4>, 4>>
        );
        same!(run_fixed, FixedLoop<2>, FixedLoop<3>, FixedLoop<4>);
    }
}

#[test]
fn every_other_configuration_is_the_same_after_it_was_written() {
    let settings = settings(3);
    both::<GradientIdentifier<f64, LowPass<f64>, Unknowns<4>, 4>>(&settings);
    both::<GradientIdentifier<f32, BackwardDifference, Unknowns<2>, 2>>(&settings);
    both::<GradientIdentifier<f32, AveragedDifference<f32>, Unknowns<2>, 2>>(&settings);
    let mut delayed = settings;
    delayed.identifier.terms.delay = 1.6e-3;
    delayed.identifier.memory = Some(3.0);
    delayed.identifier.bandwidth = Some(40.0);
    let (amplifier, behind) = delayed.amplifier::<f32, 8>().expect("valid");
    let written = words_of(&amplifier);
    assert!(Constants::read(&written) == Ok(amplifier));
    both::<GaussNewtonIdentifier<f32, Unknowns<4>, 4>>(&behind);
}

/// A recursion that starts from a servo that is known needs no first fit: the servo is prepared where the configuration
/// is.
#[test]
fn a_recursion_starts_from_constants() {
    type Loop = GaussNewtonLoop<GaussNewtonRecursion<f32, Unknowns<4>, 4>>;
    type Constant = (Loop, PreparedServo<f32>);
    let settings = settings(1);
    let built: Loop = settings.build().expect("valid");
    let servo = IdentifiedServo {
        unexplained: 2e-4,
        ..IdentifiedServo::known(TRUTH, 0.0).with_errors([0.1, 1.0, 0.3, 0.0, 0.3])
    };
    let motion = ExpectedMotion {
        bandwidth: 30.0,
        command: 1.0,
    };
    let prepared = built.identifier().prepare(&servo, &motion);
    let written: &'static [u32] = words_of(&(built, prepared)).leak();
    let constants = Constants::<Constant>::new(written).expect("written so");
    let (read, known) = constants.build();
    let run = |servo_loop: &Loop, start| {
        let mut state = servo_loop.start(0);
        *state.identification_mut() = start;
        let identifier = servo_loop.identifier();
        assert!(identifier.is_running(state.identification()));
        let bits = bits(&settings, |setpoint, count| {
            let step = servo_loop.process(&mut state, setpoint, 0.0, count);
            let estimates = in_order(shown(identifier, state.identification()));
            (step.expect("in range").control.command.into(), estimates)
        });
        (bits, shown(identifier, state.identification()))
    };
    let (bits_read, found) = run(&read, read.identifier().start_from(&known));
    let (bits_built, _) = run(&built, built.identifier().start_from_known(&servo, &motion));
    assert_eq!(bits_read, bits_built);
    assert!((found.b / TRUTH.b - 1.0).abs() < 0.01, "{found:?}");
}

#[test]
fn words_that_were_not_written_so_are_refused() {
    type Loop = GradientLoop<f32, 2>;
    let (built, _) = both::<Loop>(&settings(2));
    let written = words_of(&built);
    let refusal = |words: &[u32]| Constants::<Loop>::check(words).expect_err("not as written");
    for place in 0..written.len() {
        for bit in 0..u32::BITS {
            let mut changed = written.clone();
            changed[place] ^= 1 << bit;
            let expected = match place {
                0 => ConstantsError::Version,
                1 => ConstantsError::Type,
                _ => ConstantsError::Changed,
            };
            assert_eq!(refusal(&changed), expected, "bit {bit} of word {place}");
        }
        assert_eq!(refusal(&written[..place.max(2)]), ConstantsError::Changed);
    }
    // Two signs.
    for one in 2..written.len() - 1 {
        for other in 2..one {
            let mut changed = written.clone();
            changed[one] ^= 1 << 31;
            changed[other] ^= 1 << 31;
            assert_eq!(refusal(&changed), ConstantsError::Changed, "{one} {other}");
        }
    }
    let longer = [&written[..], &[0]].concat();
    assert_eq!(refusal(&longer), ConstantsError::Changed);
    assert_eq!(refusal(&[]), ConstantsError::Changed);

    fn assert_other<T: Configuration>(words: &[u32]) {
        assert_eq!(Constants::<T>::check(words), Err(ConstantsError::Type));
    }
    type Alone<S, const P: usize> = GradientIdentifier<f32, LowPass<f32>, S, P>;
    assert_other::<GradientLoop<f64, 2>>(&written);
    assert_other::<GradientLoop<f32, 3>>(&written);
    assert_other::<Alone<Unknowns<2>, 2>>(&written);
    let three = words_of(&both::<GradientLoop<f32, 3>>(&settings(2)).0);
    assert_other::<ServoLoop<f32, LowPass<f32>, Alone<AbLoad, 3>>>(&three);
}
