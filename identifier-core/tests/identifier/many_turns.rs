//! Single precision at high rates, after many turns, with counters that wrap.

use identifier_core::excitation::Excitation;
use identifier_core::identifier::Identify;
use identifier_core::measurement::Counter;
use identifier_core::number::Number;
use identifier_core::parameters::{Ab, ServoParameters};
use identifier_core::settings::BoxSettings;
use identifier_core::{ControllerSettings, GradientLoop, Settings};
use virtual_servo::excitation::BandLimitedWhiteNoise;
use virtual_servo::{Encoder, Plant};

const COUNTS_PER_REV: f64 = 10_000.0;

const NOTHING: ServoParameters = ServoParameters {
    a: 0.0,
    b: 0.0,
    coulomb: 0.0,
    load: 0.0,
};

/// The paper's loop and identifier.
fn settings(sample_time: f64) -> Settings {
    let mut settings = Settings {
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(sample_time, COUNTS_PER_REV)
    };
    let learning = &mut settings.identifier;
    learning.plant_box = Some(BoxSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    learning.initial.b = Some(50.0);
    learning.bounds.a = Some([0.0, 100.0]);
    learning.bounds.b = Some([5.0, 5000.0]);
    let mut gamma = [[0.0; 4]; 4];
    gamma[0][0] = 0.2;
    gamma[1][1] = 110.0;
    learning.gamma = Some(gamma);
    learning.mu = Some(10.0);
    settings
}

/// A drive that travels: at a constant speed of whole counts per sample, with the paper's noise on
/// top. The register is 16 bits wide; the count of the drive begins at `start`.
fn travel<N: Number>(sample_time: f64, duration: f64, start: i64, speed: i32) -> ServoParameters {
    let settings = settings(sample_time);
    let units = settings.units().expect("valid");
    let servo_loop: GradientLoop<N, Ab, 2> = settings.build().expect("certified");

    let noise = BandLimitedWhiteNoise::new(&units, 0.005, 0.1, 1_212_121).expect("valid");
    let mut noise_state = Excitation::<f64>::start(&noise);
    let encoder = Encoder::new(COUNTS_PER_REV);
    let servo = ServoParameters {
        a: 0.2174,
        b: 257.7,
        coulomb: 0.0,
        load: 20.0,
    };
    // The plant's own position is relative to the start, or the rounding of double precision would show.
    let mut plant = Plant::at_rest(&servo, sample_time);
    let mut register = Counter::new(start as u16);
    // As after many turns: a count of 32 bits, through however many wraps.
    let begin = start as i32;
    let mut setpoint = begin;
    let mut state = servo_loop.start(begin);
    let samples = (duration / sample_time).round() as i64;
    let mut tail = (NOTHING, 0.0);
    for k in 0..samples {
        let moved = register.read((start + encoder.read(plant.position)) as u16);
        setpoint = setpoint.wrapping_add(speed);
        let wiggle: f64 = noise.process(&mut noise_state);
        let count = begin.wrapping_add(moved);
        let step = servo_loop
            .process(&mut state, setpoint, N::from_f64(wiggle), count)
            .expect("within reach");
        plant.advance(step.control.command.to_f64());
        if k >= samples * 3 / 4 {
            let now = servo_loop.identifier().estimates(state.identification());
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

#[test]
fn a_counter_that_wraps_on_the_way_costs_nothing() {
    // 120 turns of travel through the end of 32 bits.
    let edge = i64::from(i32::MAX) - 600_000;
    for single in [
        travel::<f32>(1e-3, 60.0, edge, 20),
        travel::<f32>(1e-3, 60.0, edge + 500_000, 20),
    ] {
        let at_home = travel::<f32>(1e-3, 60.0, 0, 20);
        assert_eq!(single.b.to_bits(), at_home.b.to_bits());
        assert_eq!(single.load.to_bits(), at_home.load.to_bits());
    }
}
