//! The fixed-point loop: the same as that of double precision on the same measurements, safe under any
//! input, and refused by name where fixed point does not suffice.

use crate::support::{Bench, certified, paper_noise, shown};
use fixed::types::I16F16;
use identifier_core::GradientLoop;
use identifier_core::control::{Controller, Setpoint, Shaped};
use identifier_core::error::{Allowed, StepError};
use identifier_core::fixed_point::{FixedLoop, Word};
use identifier_core::identifier::{Event, GradientIdentifier, Identify, ServoLoop};
use identifier_core::measurement::{
    AveragedDifference, BackwardDifference, LowPass, VelocityEstimate,
};
use identifier_core::parameters::{
    AbLoad, Parameter, ParameterSet, PerParameter, ServoParameters, Unknowns,
};
use identifier_core::settings::{ControllerSettings, RangeSettings, Settings, SettingsError};
use proptest::prelude::*;

/// The paper's loop with a box and a limit.
fn settings() -> Settings {
    let mut settings = certified();
    let identifier = &mut settings.identifier;
    identifier.initial.b = Some(150.0);
    identifier.bounds.a = Some([0.0, 100.0]);
    identifier.bounds.coulomb = Some([0.0, 100.0]);
    identifier.bounds.load = Some([-100.0, 100.0]);
    identifier.gamma = Some(PerParameter::new(20.0, 1000.0, 100.0, 100.0));
    settings
}

/// The same with a filter of the reference, s.
fn filtered(reference_filter: f64) -> Settings {
    let mut settings = settings();
    let controller = settings.controller.as_mut().expect("it has one");
    controller.reference_filter = reference_filter;
    settings
}

/// The sum of squares of a signal and of how far another is from it.
#[derive(Default)]
struct Distance {
    signal: f64,
    noise: f64,
}

impl Distance {
    fn add(&mut self, exact: f64, found: f64) {
        self.signal += exact * exact;
        self.noise += (found - exact) * (found - exact);
    }

    fn decibel(&self) -> f64 {
        10.0 * (self.signal / self.noise).log10()
    }
}

/// Both loops on the measurements of that in double precision, from a count where the counter wraps:
/// the distance of fixed point from it, and the two sets of estimates.
fn side_by_side<S: ParameterSet<P>, const P: usize>(
    settings: &Settings,
    servo: &ServoParameters,
    seconds: f64,
) -> ([Distance; 3], [ServoParameters; 2]) {
    let exact: ServoLoop<f64, LowPass<f64>, GradientIdentifier<f64, LowPass<f64>, S, P>> =
        settings.build().expect("valid");
    let words: ServoLoop<Word, LowPass<Word>, GradientIdentifier<Word, LowPass<Word>, S, P>> =
        settings.build().expect("it fits");
    let (identifier, controller) = (words.identifier(), words.controller());
    let start = i32::MAX - 500;
    let mut bench = Bench::new(servo, settings, start);
    let mut wanted = paper_noise(settings, 1_212_121);
    let (mut exact_state, mut state) = (exact.start(start), words.start(start));
    let mut distances = [(); 3].map(|()| Distance::default());
    for _ in 0..(seconds / settings.sample_time) as u64 {
        let setpoint = Setpoint::from_counts(f64::from(start) + wanted());
        // The same reference to the last bit.
        let part = f64::from(setpoint.count.wrapping_sub(start)) + setpoint.offset.to_num::<f64>();
        let count = bench.count();
        let step = exact.process(&mut exact_state, start, part, count);
        let step = step.expect("in reach");
        let found = words.process(&mut state, setpoint.count, setpoint.offset, count);
        let found = found.expect("in reach");
        let [velocity, command, output_error] = &mut distances;
        let (own, of_words) = (step.control, found.control);
        velocity.add(own.velocity, controller.velocity(of_words.velocity));
        command.add(own.command, controller.command(of_words.command));
        let error = identifier.output_error(&found.seen);
        output_error.add(step.seen.output_error, error);
        bench.plant.advance(own.command);
    }
    let estimates = [exact.estimates(&exact_state), words.estimates(&state)];
    let estimates = estimates.map(|found| found.expect("estimates"));
    (distances, estimates)
}

const SERVO: ServoParameters = ServoParameters::new(0.2174, 257.7, 0.0, 0.0);

const WITH_FRICTION: ServoParameters = ServoParameters::new(0.2174, 257.7, 10.0, 20.0);

#[test]
fn on_the_same_measurements_fixed_and_floating_point_agree() {
    let servo = ServoParameters::new(SERVO.a, SERVO.b, 0.0, 20.0);
    let ([velocity, command, output_error], [exact, found]) =
        side_by_side::<Unknowns<2>, 2>(&settings(), &servo, 20.0);
    let decibel = [velocity, command, output_error].map(|distance| distance.decibel());
    println!("velocity, command, output error: {decibel:.0?} dB; {exact:?} {found:?}");
    assert!(decibel[0] > 145.0 && decibel[1] > 135.0 && decibel[2] > 75.0);
    assert!((exact.b / servo.b - 1.0).abs() < 2e-3, "{exact:?}");
    assert_alike([exact, found], 1e-4);
    let friction = |(_, estimates)| assert_alike(estimates, 2e-3);
    friction(side_by_side::<Unknowns<3>, 3>(
        &settings(),
        &WITH_FRICTION,
        20.0,
    ));
    friction(side_by_side::<Unknowns<4>, 4>(
        &settings(),
        &WITH_FRICTION,
        20.0,
    ));
    friction(side_by_side::<AbLoad, 3>(&settings(), &WITH_FRICTION, 20.0));
}

/// Without a box the guard follows the estimate; under a limit that acts the words of the correction
/// must not.
#[test]
fn without_a_range_and_under_a_limit_fixed_and_floating_point_agree() {
    let mut settings = settings();
    settings.controller = Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(1.0));
    let identifier = &mut settings.identifier;
    identifier.parameter_range = None;
    identifier.bounds.b = Some([5.0, 1000.0]);
    identifier.mu = Some(10.0);
    let servo = ServoParameters::new(SERVO.a, SERVO.b, 0.0, 40.0);
    let (_, estimates) = side_by_side::<Unknowns<2>, 2>(&settings, &servo, 20.0);
    let off = estimates[0].load - 40.0;
    assert!(off.abs() < 0.5, "{estimates:?}");
    assert_alike(estimates, 1e-3);
}

fn assert_alike(estimates: [ServoParameters; 2], tolerance: f64) {
    for (of, size) in [
        (Parameter::A, 10.0),
        (Parameter::B, estimates[0].b),
        (Parameter::Coulomb, 10.0),
        (Parameter::Load, 20.0),
    ] {
        let [exact, found] = estimates.each_ref().map(|found| found.get(of));
        let off = (found - exact).abs();
        assert!(off < tolerance * size, "{exact} in words {found}");
    }
}

#[test]
fn fast_loops_fit_and_give_the_same_estimates() {
    for sample_time in [2.5e-5, 1e-4, 2.5e-4] {
        for gamma in [
            PerParameter::new(20.0, 1000.0, 100.0, 100.0),
            PerParameter::new(0.2, 110.0, 10.0, 10.0),
        ] {
            let mut settings = Settings {
                sample_time,
                cutoff: 500.0,
                ..settings()
            };
            settings.identifier.gamma = Some(gamma);
            let (_, estimates) = side_by_side::<Unknowns<4>, 4>(&settings, &WITH_FRICTION, 5.0);
            assert_alike(estimates, 5e-3);
        }
    }
}

/// The identifier beside an undeclared controller.
#[test]
fn it_identifies_beside_any_controller() {
    let mut settings = settings();
    settings.controller = None;
    settings.identifier.correction = Some([9.0, 0.19, 4.0]);
    settings.identifier.ranges = Some(RangeSettings {
        error: 10.0,
        velocity: 200.0,
        command: 12.0,
    });
    let identifier: GradientIdentifier<Word, LowPass<Word>, Unknowns<2>, 2> =
        settings.build().expect("it fits");
    let mut bench = Bench::new(&SERVO, &settings, 0);
    let mut state = identifier.start();
    let mut last = bench.count();
    for k in 0..20_000 {
        // A relay.
        let count = bench.count();
        let wanted = if k % 400 < 200 { 400 } else { -400 };
        let command = if count < wanted { 3.0 } else { -3.0 };
        let word = identifier.command_word(command);
        assert!((identifier.command(word) - command).abs() < 1e-6);
        identifier
            .process(&mut state, count.wrapping_sub(last), word)
            .expect("in reach");
        last = count;
        bench.plant.advance(command);
    }
    let found = identifier.estimates(&state).expect("estimates");
    assert!((found.b / SERVO.b - 1.0).abs() < 0.01, "{found:?}");
    assert!(!identifier.at_bounds_in(&identifier.snapshot(&state)).b);
}

#[test]
fn nothing_is_learnt_from_a_servo_at_rest() {
    let settings = settings();
    let words: FixedLoop<3> = settings.build().expect("it fits");
    let identifier = words.identifier();
    let mut state = identifier.start();
    let small = identifier.command_word(0.0);
    let before = identifier.estimates(&state).expect("estimates");
    for _ in 0..200 {
        let seen = identifier.process(&mut state, 0, small).expect("in reach");
        assert_eq!(seen.event, Event::Standing);
    }
    let large = identifier.command_word(5.0);
    let reported = (0..200).position(|_| {
        let seen = identifier.process(&mut state, 0, large).expect("in reach");
        seen.event == Event::NotFollowing
    });
    // Not before the servo has had a tenth of a second to move.
    assert_eq!(reported, Some(100));
    let after = identifier.estimates(&state).expect("estimates");
    assert!((after.b - before.b).abs() < 1e-9 && (after.coulomb - before.coulomb).abs() < 1e-9);
}

#[test]
fn an_impossible_increment_is_refused_and_the_state_unchanged() {
    let mut settings = settings();
    settings.identifier.max_speed = Some(60.0);
    let words: FixedLoop<2> = settings.build().expect("it fits");
    let mut state = words.start(0);
    let before = state;
    let jump = words.process(&mut state, 0, I16F16::ZERO, 5000);
    assert_eq!(jump, Err(StepError::CountJumped));
    assert!(state == before);
    assert!(words.process(&mut state, 0, I16F16::ZERO, 90).is_ok());
    let joined = words.identifier().increment(90);
    words
        .identifier()
        .resume_moving(state.identification_mut(), joined);
    assert!(words.process(&mut state, 0, I16F16::ZERO, 180).is_ok());
}

type Words = GradientIdentifier<Word, LowPass<Word>, Unknowns<3>, 3>;

/// The ranges as they follow from the settings.
fn ranges(settings: &mut Settings) -> &mut RangeSettings {
    let ranges = RangeSettings::from_settings(settings).expect("a controller");
    settings.identifier.ranges.insert(ranges)
}

#[test]
fn settings_out_of_range_are_refused_with_a_value_that_fits() {
    fn gamma(settings: &mut Settings, b: f64) {
        settings.identifier.gamma = Some(PerParameter::new(20.0, b, 100.0, 100.0));
    }
    type Change = fn(&mut Settings);
    fn pid(settings: &mut Settings) -> &mut ControllerSettings {
        settings.controller.as_mut().expect("it has one")
    }
    let rows: [(&str, Change); 9] = [
        ("ranges.error = 1000000 … at most 42165", |s| {
            ranges(s).error = 1e6
        }),
        ("ranges.command = 5 … at least 10", |s| {
            ranges(s).command = 5.0
        }),
        ("gamma = 1e12 … at most", |s| gamma(s, 1e12)),
        ("gamma = 1e-11 … at least", |s| gamma(s, 1e-11)),
        ("sample_time = 0.001 … at least", |s| pid(s).ki = 1e-7),
        ("bounds.a = 300 … 250", |s| {
            s.identifier.bounds.a = Some([0.0, 300.0])
        }),
        ("bounds.coulomb … required", |s| {
            s.identifier.bounds.coulomb = None
        }),
        ("bounds.b … required", |s| {
            s.identifier.parameter_range = None
        }),
        ("ranges … required", |s| {
            s.controller = None;
            s.identifier.correction = Some([9.0, 0.19, 4.0]);
        }),
    ];
    for (parts, change) in rows {
        let mut settings = settings();
        change(&mut settings);
        let built: Result<Words, SettingsError> = settings.build();
        let answer = built.expect_err("it does not fit").to_string();
        assert!(
            parts.split(" … ").all(|part| answer.contains(part)),
            "{answer}"
        );
    }
}

/// The numbers that refusals name work.
#[test]
fn the_value_that_a_refusal_names_is_accepted() {
    for (error, velocity) in [(1e6, 200.0), (4.0, 1e-9), (1e-9, 1e-9)] {
        let mut settings = settings();
        let mut ranges = RangeSettings {
            error,
            velocity,
            command: 1.0,
        };
        let mut gamma = [20.0_f64, 1000.0, 100.0, 100.0];
        let built = (0..12).any(|_| {
            settings.identifier.ranges = Some(ranges);
            let [a, b, coulomb, load] = gamma;
            settings.identifier.gamma = Some(PerParameter::new(a, b, coulomb, load));
            let built: Result<Words, SettingsError> = settings.build();
            let Err(SettingsError::Range(refused)) = built else {
                return built.is_ok();
            };
            let (Allowed::AtMost(named) | Allowed::AtLeast(named) | Allowed::PositiveUpTo(named)) =
                refused.allowed
            else {
                panic!("{refused}");
            };
            match refused.parameter {
                "ranges.error" => ranges.error = named,
                "ranges.velocity" => ranges.velocity = named,
                "ranges.command" => ranges.command = named,
                "gamma" => {
                    let is_it = |entry: &&mut f64| entry.to_bits() == refused.value.to_bits();
                    *gamma.iter_mut().find(is_it).expect("an entry of gamma") = named;
                }
                other => panic!("{other}"),
            }
            false
        });
        assert!(built, "{ranges:?} {gamma:?}");
    }
}

/// Runs a loop over any samples: setpoint, offset, count and a command from outside.
fn nothing_wraps<V, S, const P: usize>(
    settings: &Settings,
    samples: &[(i32, i32, i32, Option<i32>)],
) -> Result<(), TestCaseError>
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    let words: ServoLoop<Word, V, GradientIdentifier<Word, V, S, P>, Shaped<Word>> =
        (settings.build()).map_err(|refused| TestCaseError::reject(refused.to_string()))?;
    let ControllerSettings { kp, kd, limit, .. } = settings.controller.expect("it has one");
    let [low, high] = limit;
    let identifier = words.identifier();
    // A limit is rounded to the terms' last bit, at most four times what one of the error, velocity or command demands.
    let controller = words.controller();
    let per_count = f64::from(controller.error(1, I16F16::ZERO, 0).to_bits());
    let per_sample = controller.velocity(Word::from_bits(1)) / settings.sample_time;
    let room = 2.0
        * (kp * settings.resolution / per_count)
            .max(kd * settings.resolution * per_sample)
            .max(controller.command(Word::from_bits(1)));
    let mut state = words.start(0);
    for &(setpoint, offset, count, command) in samples {
        let offset = I16F16::from_bits(offset);
        let control = words
            .control(&mut state, setpoint, offset, count)
            .expect("every increment saturates");
        let seen = match command.map(Word::from_bits) {
            None => words.learn(&mut state, &control),
            Some(any) => {
                if any.to_bits() % 16 == 0 {
                    identifier.resume_moving(state.identification_mut(), any);
                }
                let increment = if count % 2 == 0 {
                    any
                } else {
                    control.increment
                };
                identifier.update(state.identification_mut(), increment, any)
            }
        };
        prop_assert!(seen.output_error.abs() <= Word::ONE);
        let applied = words.controller().command(control.command);
        prop_assert!(applied >= low - room && applied <= high + room, "{applied}");
        let found = shown(identifier, state.identification());
        for parameter in S::PARAMETERS {
            let value = found.get(parameter);
            let bounds = identifier.bounds(parameter).expect("one of the set");
            let room = 1e-6 * (bounds.max() - bounds.min());
            let within = value >= bounds.min() - room && value <= bounds.max() + room;
            // The load holds what the integral has found besides.
            let is_load = parameter == Parameter::Load && value.is_finite();
            prop_assert!(within || is_load, "{parameter:?} {value}");
        }
    }
    Ok(())
}

/// The time constant of a filter of the reference, s: none, and from a sample on.
fn reference_filters() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 1e-3_f64..0.3, Just(100.0)]
}

fn any_samples() -> impl Strategy<Value = Vec<(i32, i32, i32, Option<i32>)>> {
    let count = || {
        prop_oneof![
            any::<i32>(),
            -1_000_i32..1_000,
            Just(i32::MIN),
            Just(i32::MAX)
        ]
    };
    let command = prop_oneof![
        4 => Just(None),
        1 => any::<i32>().prop_map(Some),
        1 => prop_oneof![Just(i32::MIN), Just(i32::MAX), Just(0)].prop_map(Some),
    ];
    prop::collection::vec((count(), any::<i32>(), count(), command), 1..200)
}

proptest! {
    /// With any sensor readings nothing wraps (the tests check every sum for it), no estimate
    /// leaves its bounds, and the command stays within its limit.
    #[test]
    fn nothing_wraps_with_any_input(
        samples in any_samples(),
        reference_filter in reference_filters(),
    ) {
        let mut settings = filtered(reference_filter);
        nothing_wraps::<LowPass<Word>, Unknowns<2>, 2>(&settings, &samples)?;
        nothing_wraps::<LowPass<Word>, Unknowns<4>, 4>(&settings, &samples)?;
        nothing_wraps::<AveragedDifference<Word>, Unknowns<3>, 3>(&settings, &samples)?;
        nothing_wraps::<BackwardDifference, AbLoad, 3>(&settings, &samples)?;
        // Steps that are large, and a guard that follows b̂.
        settings.identifier.gamma = Some(PerParameter::new(400.0, 30_000.0, 400.0, 400.0));
        settings.identifier.parameter_range = None;
        settings.identifier.bounds.b = Some([0.1, 2000.0]);
        settings.identifier.mu = Some(10.0);
        nothing_wraps::<LowPass<Word>, Unknowns<4>, 4>(&settings, &samples)?;
    }

    /// The same for any servo, gains, limit, rate and encoder that are taken.
    #[test]
    fn nothing_wraps_with_any_settings(
        samples in any_samples(),
        shape in prop::array::uniform9(0.0_f64..1.0),
        correction in any::<bool>(),
    ) {
        let log = |part: f64, low: f64, high: f64| low * (high / low).powf(part);
        let [b, rate, counts, limit, friction, load, gamma, speed, integral] = shape;
        let b = log(b, 1.0, 1e5);
        let sample_time = log(rate, 2.5e-5, 4e-3);
        let omega = 0.05 / sample_time;
        let (kp, kd) = (omega * omega / b, 2.0 * omega / b);
        let ki = if integral < 0.2 { 0.0 } else { integral * 0.2 * omega * kp };
        let limit = log(limit, 0.1, 1000.0);
        let mut settings = Settings {
            controller: Some(ControllerSettings {
                limit: [-limit, 0.3 * limit],
                ..ControllerSettings::pid(kp, kd, ki)
            }),
            ..Settings::new(sample_time, log(counts, 100.0, 1e6).round())
        };
        let identifier = &mut settings.identifier;
        identifier.correction = correction.then_some([0.25 * kp, 0.5 * kd, 0.1 * ki]);
        identifier.initial.b = Some(b);
        identifier.bounds.a = Some([-0.1 / sample_time, 0.25 / sample_time]);
        identifier.bounds.b = Some([0.1 * b, 2.0 * b]);
        let most = b * limit;
        identifier.bounds.coulomb = Some([0.0, friction * most]);
        identifier.bounds.load = Some([-load * most, most]);
        let gamma = log(gamma, 1e-3, 1e3);
        let speed_of = limit / kd * log(speed, 0.01, 1.0);
        identifier.gamma = Some(PerParameter::new(gamma * omega / (speed_of * speed_of),
            gamma * omega / (limit * limit),
            gamma * omega,
            gamma * omega));
        nothing_wraps::<LowPass<Word>, Unknowns<4>, 4>(&settings, &samples)?;
    }

    /// The words' controller is the numbers' controller, also where the counter wraps.
    #[test]
    fn the_controller_is_that_of_floating_point(
        steps in prop::collection::vec((-2000_i32..2000, -20_i32..20), 1..300),
        start in prop_oneof![any::<i32>(), i32::MAX - 20..=i32::MAX],
        reference_filter in reference_filters(),
    ) {
        let settings = filtered(reference_filter);
        // Each sample rounds the filtered reference by a last bit of the error.
        let last_bit = 9.0 * settings.resolution * 8192.0 / f64::from(1 << 30);
        let tolerance = 1e-6 + last_bit * (1e3 * reference_filter).min(300.0);
        let exact: GradientLoop<f64, 2, Shaped<f64>> = settings.build().expect("valid");
        let words: Controller<Word, LowPass<Word>, Shaped<Word>> = settings.build().expect("it fits");
        let mut exact_state = exact.start(start);
        let mut state = words.start();
        let mut count = start;
        for (reference, moved) in steps {
            count = count.wrapping_add(moved);
            let setpoint = start.wrapping_add(reference);
            let real = exact.control(&mut exact_state, setpoint, 0.25, count).expect("in reach");
            let error = words.error(setpoint, I16F16::from_num(0.25), count);
            let found = words.process(&mut state, error, words.increment(moved)).expect("in reach");
            prop_assert!((words.command(found.command) - real.command).abs() < tolerance);
            prop_assert!((words.velocity(found.velocity) - real.velocity).abs() < 1e-5);
        }
    }

    #[test]
    fn a_setpoint_is_split_to_the_nearest_and_its_counts_wrap(
        counts in prop_oneof![-1e5_f64..1e5, -1e13_f64..1e13],
    ) {
        let Setpoint { count: whole, offset: part } = Setpoint::from_counts(counts);
        let found = f64::from(whole) + part.to_num::<f64>();
        let wrap = 2_f64.powi(32);
        let apart = (counts - found).rem_euclid(wrap);
        prop_assert!(apart.min(wrap - apart) <= 0.5 / 65_536.0 + 1e-15 * counts.abs());
        prop_assert!((0.0..1.0).contains(&part.to_num::<f64>()));
    }
}

#[test]
fn a_setpoint_that_is_no_number_is_refused() {
    for counts in [f64::NAN, f64::INFINITY, f64::MAX] {
        let setpoint = Setpoint::from_counts(counts);
        assert_eq!((setpoint.count, setpoint.offset), (0, I16F16::ZERO));
    }
}

#[test]
fn a_chosen_gamma_is_lowered_to_the_range_of_fixed_point() {
    for (counts, limit, b) in [(1e3, 0.1, 3.0), (1e3, 0.1, 100.0), (1e5, 0.1, 3.0)] {
        let settings = Settings::new(5e-5, counts)
            .with_pid(850.0 / b, 39.0 / b, 1600.0 / b, limit)
            .with_servo_range([0.0, 20.0], [b, 3.0 * b]);
        let words: Result<FixedLoop, _> = settings.build();
        assert!(words.is_ok(), "{words:?}");
    }
}
