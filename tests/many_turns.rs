//! Single precision far from home: high rates, many turns, wrapping counters.

use identifier_core::adaptation::PositiveDefinite;
use identifier_core::control::{CommandLimit, ControlState, Gains};
use identifier_core::excitation::{BandLimitedWhiteNoise, Excitation};
use identifier_core::identifier::{Bounds, GradientIdentifier, GradientLaw, IdentifierConfig};
use identifier_core::interval::Interval;
use identifier_core::measurement::counter::Counter;
use identifier_core::measurement::origin::Origin;
use identifier_core::measurement::velocity::LowPass;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::parameters::Ab;
use identifier_core::stability::PlantBox;
use identifier_core::units::Units;
use virtual_servo::{Encoder, Plant};

const COUNTS_PER_REV: f64 = 10_000.0;

const NOTHING: ServoParameters = ServoParameters {
    a: 0.0,
    b: 0.0,
    coulomb: 0.0,
    load: 0.0,
};

/// A drive that travels: at a constant speed of whole counts per sample, with the paper's noise on
/// top. The register is 16 bits wide; the journey starts `start` counts from zero.
fn travel<N: Number>(sample_time: f64, duration: f64, start: i64, speed: i64) -> ServoParameters {
    let resolution = std::f64::consts::TAU / COUNTS_PER_REV;
    let units = Units::new(sample_time, resolution).expect("valid");
    let interval = |min, max| Interval::new("interval", min, max).expect("ordered");
    let config = IdentifierConfig {
        units,
        gains: Gains::new(9.0, 0.19, 4.0).expect("valid"),
        limit: CommandLimit::symmetric(10.0).expect("valid"),
        plant_box: Some(
            PlantBox::new(interval(0.0, 50.0), interval(110.0, 1000.0)).expect("valid"),
        ),
        initial: ServoParameters { b: 50.0, ..NOTHING },
        bounds: Bounds {
            a: interval(0.0, 100.0),
            b: interval(5.0, 5000.0),
            coulomb: interval(0.0, 0.0),
            load: interval(0.0, 0.0),
        },
    };
    let law = GradientLaw {
        gamma: PositiveDefinite::diagonal([0.2, 110.0]).expect("positive"),
        mu: Some(10.0),
        frozen: [false; 2],
    };
    let velocity = LowPass::<N>::new(&units, 500.0).expect("valid");
    let controller = config.controller(velocity);
    let identifier =
        GradientIdentifier::<_, _, Ab, 2>::new(&config, &law, velocity).expect("certified");

    let noise = BandLimitedWhiteNoise::new(&units, 0.005, 0.1, 1_212_121).expect("valid");
    let mut noise_state = Excitation::<f64>::start(&noise);
    let encoder = Encoder::new(COUNTS_PER_REV);
    let servo = ServoParameters {
        a: 0.2174,
        b: 257.7,
        coulomb: 0.0,
        load: 20.0,
    };
    // The plant's own position is kept relative to the start, or double precision would tell.
    let mut plant = Plant::at_rest(&servo, sample_time);
    let mut register = Counter::new(start as u16);
    let mut origin = Origin::new(0);
    let mut control = ControlState::at_rest(N::ZERO);
    let mut state = identifier.start();
    let mut base = 0_i64;
    let samples = (duration / sample_time).round() as i64;
    let mut tail = (NOTHING, 0.0);
    for k in 0..samples {
        let count = register.read((start + encoder.read(plant.position)) as u16);
        if let Some(moved) = origin.follow::<N>(count) {
            control.shift_origin(moved);
        }
        base += speed;
        let wiggle: f64 = noise.process(&mut noise_state);
        let reference = origin.position::<N>(base) + N::from_f64(wiggle);
        let sample = controller
            .process(&mut control, reference, origin.position(count))
            .expect("within reach");
        identifier.process(&mut state, &sample);
        plant.advance(sample.command.to_f64());
        if k >= samples * 3 / 4 {
            let now = identifier.estimates(&state);
            tail.0.a += now.a;
            tail.0.b += now.b;
            tail.0.load += now.load;
            tail.1 += 1.0;
        }
    }
    let (sum, count) = tail;
    ServoParameters {
        a: sum.a / count,
        b: sum.b / count,
        coulomb: 0.0,
        load: sum.load / count,
    }
}

fn assert_alike(single: &ServoParameters, double: &ServoParameters) {
    assert!((single.a - double.a).abs() < 5e-3, "{single:?} {double:?}");
    assert!(
        (single.b / double.b - 1.0).abs() < 1e-3,
        "{single:?} {double:?}"
    );
    assert!(
        (single.load / double.load - 1.0).abs() < 1e-2,
        "{single:?} {double:?}"
    );
}

#[test]
fn forty_kilohertz_costs_single_precision_nothing() {
    let single = travel::<f32>(25e-6, 20.0, 0, 0);
    let double = travel::<f64>(25e-6, 20.0, 0, 0);
    assert_alike(&single, &double);
}

#[test]
fn a_hundred_thousand_turns_cost_single_precision_nothing() {
    // 20 counts a millisecond over 60 s are 120 turns of travel, from 10⁵ turns away.
    let far = 100_000 * 10_000 + 1234;
    let single = travel::<f32>(1e-3, 60.0, far, 20);
    let double = travel::<f64>(1e-3, 60.0, far, 20);
    assert_alike(&single, &double);
    let at_home = travel::<f32>(1e-3, 60.0, 0, 20);
    assert_eq!(
        single.b.to_bits(),
        at_home.b.to_bits(),
        "the start plays no part at all"
    );
    assert!((single.b / 257.7 - 1.0).abs() < 2e-3, "{single:?}");
}
