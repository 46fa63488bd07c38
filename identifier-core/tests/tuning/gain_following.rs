//! Gains that follow the inertia of a servo.

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{
    Cap, FollowedGains, GainFollowing, Goal, NotFollowed, Tuning, TuningSettings,
};
use identifier_core::units::Units;

const LIMIT: f64 = 10.0;

const MAX_SLICES: u32 = 10_000;

/// Sample times of 250 Hz, 1, 4 and 20 kHz.
const SAMPLE_TIMES: [f64; 4] = [4e-3, 1e-3, 250e-6, 50e-6];

const SERVO: ServoParameters = ServoParameters {
    a: 0.1,
    b: 250.0,
    coulomb: 2.0,
    load: 10.0,
};

const ERRORS: ServoParameters = ServoParameters {
    a: 0.05,
    b: 0.5,
    coulomb: 0.5,
    load: 0.5,
};

fn servo() -> IdentifiedServo {
    IdentifiedServo {
        parameters: SERVO,
        delay: 0.0,
        covariance: std::array::from_fn(|i| {
            let errors = [ERRORS.a, ERRORS.b, ERRORS.coulomb, 1e-5, ERRORS.load];
            std::array::from_fn(|j| if i == j { errors[i] * errors[i] } else { 0.0 })
        }),
        unexplained: 1e-4,
    }
}

fn settings(sample_time: f64, counts: f64) -> TuningSettings {
    let resolution = std::f64::consts::TAU / counts;
    TuningSettings {
        goal: Goal::Bandwidth(30.0),
        ..TuningSettings::new(sample_time, resolution, LIMIT, 0.2)
    }
}

/// All accelerations over a factor.
fn with_mass(servo: &ServoParameters, factor: f64) -> ServoParameters {
    ServoParameters {
        a: servo.a / factor,
        b: servo.b / factor,
        coulomb: servo.coulomb / factor,
        load: servo.load / factor,
    }
}

fn follow(
    settings: &TuningSettings,
    tuning: &Tuning,
    found: [ServoParameters; 2],
) -> Result<FollowedGains, NotFollowed> {
    let units = Units::new(settings.sample_time, settings.resolution).expect("valid");
    let following = GainFollowing::new(&servo(), tuning, &found, &units, LIMIT)?;
    let mut state = following.start();
    for _ in 0..MAX_SLICES {
        if let Some(end) = following.work(&mut state) {
            return end;
        }
    }
    panic!("no end: {found:?}");
}

#[test]
fn the_loop_of_the_promise_is_kept_from_a_fifth_to_five_times_the_inertia_at_any_sample_rate() {
    for sample_time in SAMPLE_TIMES {
        let settings = settings(sample_time, 50_000.0);
        let tuning = settings.tune(&servo()).expect("gains");
        for factor in [0.2, 0.5, 1.0, 2.0, 5.0] {
            let found = [with_mass(&SERVO, factor), with_mass(&ERRORS, factor)];
            let followed = follow(&settings, &tuning, found).expect("it follows");
            let FollowedGains { tuning: gains, .. } = followed;
            for (gain, before) in [
                (gains.kp, tuning.kp),
                (gains.kd, tuning.kd),
                (gains.ki, tuning.ki),
            ] {
                assert!((gain / before - factor).abs() < 1e-9 * factor);
            }
            let (own, promised) = (gains.promise, tuning.promise);
            for (own, promised, expected) in [
                (own.rise_time, promised.rise_time, 1.0),
                (own.slowest_rise_time, promised.slowest_rise_time, 1.0),
                (own.compliance, promised.compliance, 1.0),
                (own.sensitivity, promised.sensitivity, 1.0),
                (own.gain_margins[1], promised.gain_margins[1], 1.0),
                (own.noise, promised.noise, factor),
            ] {
                let ratio = own / promised;
                assert!(
                    (ratio / expected - 1.0).abs() < 0.05,
                    "{sample_time} {factor} {own} {promised}"
                );
            }
            assert!(own.overshoot < promised.overshoot + 0.01);
        }
    }
}

#[test]
fn a_servo_beyond_the_bounds_or_hardly_known_is_not_followed() {
    let settings = settings(1e-3, 50_000.0);
    let tuning = settings.tune(&servo()).expect("gains");
    let to = |factor: f64, error: f64| {
        let found = [
            with_mass(&SERVO, factor),
            with_mass(&ERRORS, factor / error),
        ];
        follow(&settings, &tuning, found)
    };
    for factor in [0.19, 5.2, 1e300, 1e-300] {
        assert_eq!(to(factor, 1.0), Err(NotFollowed::TooFar), "{factor}");
    }
    for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(to(factor, 1.0).is_err(), "{factor}");
    }
    assert!(to(2.0, 10.0).is_ok());
    // Three standard errors of b are a half of it, and then all of it.
    assert_eq!(to(2.0, 80.0), Err(NotFollowed::Limited(Cap::Delay)));
    for error in [200.0, f64::NAN, f64::INFINITY] {
        assert_eq!(to(2.0, error), Err(NotFollowed::NotKnown), "{error}");
    }
}

#[test]
fn gains_that_ask_for_too_much_of_the_command_or_its_noise_do_not_follow() {
    let found = |factor| [with_mass(&SERVO, factor), with_mass(&ERRORS, factor)];
    // The step takes a third of the command.
    let large = TuningSettings {
        step: 3.0,
        ..settings(1e-3, 50_000.0)
    };
    let tuning = large.tune(&servo()).expect("gains");
    assert!(follow(&large, &tuning, found(2.0)).is_ok());
    let limited = Err(NotFollowed::Limited(Cap::CommandLimit));
    assert_eq!(follow(&large, &tuning, found(5.0)), limited);
    // A coarse encoder, of which less noise is allowed as ever.
    let coarse = settings(1e-3, 1000.0);
    let tuning = coarse.tune(&servo()).expect("gains");
    let noisy = Err(NotFollowed::Limited(Cap::EncoderNoise));
    assert_eq!(follow(&coarse, &tuning, found(5.0)), noisy);
    let mut loud = tuning;
    loud.promise.noise = 0.1 * LIMIT;
    assert!(follow(&coarse, &loud, found(0.5)).is_ok());
    assert_eq!(follow(&coarse, &loud, found(1.5)), noisy);
    // The load leaves nothing.
    let mut loaded = found(1.0);
    loaded[0].load = LIMIT * SERVO.b;
    assert_eq!(follow(&coarse, &tuning, loaded), limited);
}

#[test]
fn gains_that_a_resonance_limits_are_lowered_alone() {
    let settings = settings(1e-3, 50_000.0);
    let mut tuning = settings.tune(&servo()).expect("gains");
    tuning.cap = Some(Cap::Resonance);
    let found = |factor| [with_mass(&SERVO, factor), with_mass(&ERRORS, factor)];
    let limited = Err(NotFollowed::Limited(Cap::Resonance));
    assert_eq!(follow(&settings, &tuning, found(2.0)), limited);
    assert!(follow(&settings, &tuning, found(0.5)).is_ok());
    // A notch stays where the resonance was.
    (tuning.cap, tuning.notch) = (None, 500.0);
    assert_eq!(follow(&settings, &tuning, found(0.5)), limited);
}

#[test]
fn a_change_of_friction_beside_the_inertia_is_not_promised_for() {
    let settings = settings(1e-3, 50_000.0);
    let tuning = settings.tune(&servo()).expect("gains");
    let mut found = with_mass(&SERVO, 2.0);
    found.coulomb *= 3.0;
    let followed = follow(&settings, &tuning, [found, with_mass(&ERRORS, 2.0)]);
    let servo = followed.expect("it follows").servo;
    let expected = with_mass(&SERVO, 2.0);
    assert!((servo.parameters.coulomb - expected.coulomb).abs() < 1e-9);
    assert!((servo.parameters.a - expected.a).abs() < 1e-9);
    assert!((servo.parameters.b - expected.b).abs() < 1e-9);
    assert!((servo.standard_error(IdentifiedServo::COULOMB) - 0.25).abs() < 1e-9);
}

#[test]
fn a_loop_that_does_not_bear_the_servo_is_refused_by_its_margins() {
    // As stiff as it bears: with much less friction the same gains lose their margin.
    let stiffest = TuningSettings {
        goal: Goal::Stiffest,
        cutoff: Some(800.0),
        ..settings(1e-3, 2e6)
    };
    let damped = IdentifiedServo {
        parameters: ServoParameters { a: 300.0, ..SERVO },
        ..servo()
    };
    let tuning: Result<Tuning, _> = stiffest.tune(&damped);
    let tuning = tuning.expect("gains");
    let units = Units::new(stiffest.sample_time, stiffest.resolution).expect("valid");
    let end = |a: f64| {
        let found = [ServoParameters { a, ..SERVO }, ERRORS];
        let following = GainFollowing::new(&damped, &tuning, &found, &units, f64::INFINITY)?;
        let mut state = following.start();
        (0..MAX_SLICES)
            .find_map(|_| following.work(&mut state))
            .expect("an end")
    };
    assert!(end(300.0).is_ok());
    assert_eq!(end(0.5), Err(NotFollowed::Limited(Cap::Delay)));
}
