//! Counters that wrap after many turns.

use identifier_core::excitation::Excitation;
use identifier_core::identifier::Identify;
use identifier_core::measurement::Counter;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::{ControllerSettings, ParameterRangeSettings};
use identifier_core::{GradientLoop, Settings};
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
    learning.parameter_range = Some(ParameterRangeSettings {
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
fn travel(start: i64, speed: i32) -> ServoParameters {
    let (sample_time, duration) = (1e-3, 60.0);
    let settings = settings(sample_time);
    let units = settings.units().expect("valid");
    let servo_loop: GradientLoop<f32, 2> = settings.build().expect("certified");

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
        let probe: f64 = noise.process(&mut noise_state);
        let count = begin.wrapping_add(moved);
        let step = servo_loop
            .process(&mut state, setpoint, probe as f32, count)
            .expect("within reach");
        plant.advance(f64::from(step.control.command));
        if k >= samples * 3 / 4 {
            let now = servo_loop
                .identifier()
                .estimates(state.identification())
                .expect("estimates");
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

#[test]
fn a_counter_that_wraps_on_the_way_costs_nothing() {
    // 120 turns of travel through the end of 32 bits.
    let edge = i64::from(i32::MAX) - 600_000;
    for single in [travel(edge, 20), travel(edge + 500_000, 20)] {
        let at_home = travel(0, 20);
        assert_eq!(single.b.to_bits(), at_home.b.to_bits());
        assert_eq!(single.load.to_bits(), at_home.load.to_bits());
    }
}
