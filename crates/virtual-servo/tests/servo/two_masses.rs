//! Motor and load on a spring, and a load behind backlash.

use core::f64::consts::PI;

use identifier_core::parameters::ServoParameters;
use virtual_servo::{Effects, Plant};

use crate::{
    DRY, FREE, RUBBING, SAMPLE_TIME, assert_close, assert_moves_as, servo, to_and_fro, with,
};

const RESONANT: Effects = Effects {
    resonance: 150.0,
    inertia_ratio: 0.4,
    ..Effects::NONE
};

#[test]
fn the_motor_oscillates_at_the_resonance_and_decays_with_its_damping() {
    let effects = Effects {
        resonance_damping: Some(0.01),
        ..RESONANT
    };
    let mut elastic = servo(&FREE, &effects);
    let mut rigid = Plant::at_rest(&FREE, SAMPLE_TIME);
    elastic.advance(1.0);
    rigid.advance(1.0);
    // The centre of both moves as the rigid servo; the motor oscillates around it.
    let mut swing = Vec::new();
    for _ in 0..3000 {
        elastic.advance(0.0);
        rigid.advance(0.0);
        swing.push(elastic.position() - rigid.position);
    }
    let crossings: Vec<f64> = (1..swing.len())
        .filter(|&k| swing[k - 1] * swing[k] < 0.0)
        .map(|k| k as f64 - swing[k] / (swing[k] - swing[k - 1]))
        .collect();
    let halves = (crossings.len() - 1) as f64;
    let frequency = PI * halves / (crossings[crossings.len() - 1] - crossings[0]) / SAMPLE_TIME;
    let damped = 150.0 * (1.0_f64 - 1e-4).sqrt();
    assert_close(frequency, damped, 1e-4, "frequency");
    let largest = |from: usize| {
        let part = &swing[from..from + 100];
        part.iter().fold(0.0_f64, |most, x| most.max(x.abs()))
    };
    let decay = (largest(0) / largest(1000)).ln();
    assert_close(decay, 0.01 * 150.0, 0.01, "decay in a second");
}

#[test]
fn a_stiff_spring_makes_them_one_body() {
    let effects =
        with(|of| (of.resonance, of.resonance_damping, of.inertia_ratio) = (5e4, Some(0.7), 0.4));
    let mut elastic = servo(&RUBBING, &effects);
    let commands = (0..300).map(|sample| [to_and_fro(sample); 2]);
    assert_moves_as(&mut elastic, &RUBBING, 1e-6, commands);
}

#[test]
fn behind_a_stiff_spring_the_inertia_of_the_load_is_its_share_of_the_whole() {
    // Of 40 % that vary by 30 %, the whole varies by 12 %.
    let varying = with(|of| (of.inertia_variation, of.inertia_order) = ([0.3, 0.0], 2));
    let stiff = Effects {
        resonance: 5e4,
        resonance_damping: Some(0.7),
        inertia_ratio: 0.4,
        ..varying
    };
    let whole = Effects {
        inertia_variation: [0.12, 0.0],
        ..varying
    };
    let (mut elastic, mut rigid) = (servo(&FREE, &stiff), servo(&FREE, &whole));
    let mut even = Plant::at_rest(&FREE, SAMPLE_TIME);
    for _ in 0..300 {
        elastic.advance(0.8);
        rigid.advance(0.8);
        even.advance(0.8);
        assert_close(elastic.position(), rigid.position(), 1e-6, "position");
    }
    assert!((even.position - rigid.position()).abs() > 0.01, "it varies");
}

/// Only the motor within the backlash, b/(1 − ρ); beyond it the centre of both moves with b, whatever the flanks do.
#[test]
fn within_the_backlash_of_a_coupling_the_motor_moves_alone() {
    let loose = Effects {
        backlash: 0.02,
        ..RESONANT
    };
    let mut servo = servo(&FREE, &loose);
    let motor = ServoParameters::new(0.0, FREE.b / 0.6, 0.0, 0.0);
    let mut alone = Plant::at_rest(&motor, SAMPLE_TIME);
    let mut within = 0;
    for _ in 0..40 {
        servo.advance(0.2);
        alone.advance(0.2);
        if alone.position < 0.01 {
            within += 1;
            assert_close(servo.position(), alone.position, 1e-9, "alone");
        }
    }
    assert!(within > 10, "{within} samples in the play");
    let part = servo.position() / alone.position;
    assert!(part < 0.99, "it takes the load along");
    // Released, both go on with what the command gave them, and meet each other again and again.
    let given = FREE.b * 0.2 * 40.0 * SAMPLE_TIME;
    let before = servo.position();
    for _ in 0..20_000 {
        servo.advance(0.0);
    }
    let mean = (servo.position() - before) / (20_000.0 * SAMPLE_TIME);
    assert_close(mean, given, 0.01, "speed of the centre");
}

#[test]
fn a_load_on_its_spring_breaks_the_friction_of_the_motor() {
    // The spring overshoots: it pulls with up to 2 d, and d alone is less than c.
    let loaded = ServoParameters { load: 7.0, ..DRY };
    let mut rigid = Plant::at_rest(&loaded, SAMPLE_TIME);
    let mut elastic = servo(&loaded, &RESONANT);
    for _ in 0..3000 {
        rigid.advance(0.0);
        elastic.advance(0.0);
    }
    assert!(rigid.position == 0.0);
    assert!(elastic.position() > 1e-6, "{}", elastic.position());
    assert!(elastic.velocity() == 0.0, "it is held again");
}

#[test]
fn an_encoder_behind_backlash_rests_after_a_reversal_until_the_backlash_is_taken_up() {
    let effects = with(|of| of.backlash = 0.02);
    let mut motor = servo(&RUBBING, &Effects::NONE);
    let mut behind = servo(&RUBBING, &effects);
    let (mut turned_at, mut stood) = (None, 0);
    for sample in 0..2000 {
        let command = if sample < 500 { 0.4 } else { -0.4 };
        let before = behind.position();
        motor.advance(command);
        behind.advance(command);
        let ahead = motor.position() - behind.position();
        assert!(ahead.abs() <= 0.01 + 1e-12);
        if motor.velocity() < 0.0 {
            let top = *turned_at.get_or_insert(motor.position());
            let back = top - motor.position();
            if back < 0.019 {
                stood += 1;
                assert_eq!(behind.position().to_bits(), before.to_bits());
                assert!(behind.velocity() == 0.0);
            } else if back > 0.021 {
                assert_close(ahead, -0.01, 1e-12, "at the other end");
                assert_close(behind.velocity(), motor.velocity(), 1e-12, "velocity");
            }
        } else if motor.position() > 0.01 && motor.velocity() > 0.0 {
            assert_close(ahead, 0.01, 1e-12, "at the end of the play");
        }
    }
    assert!(stood > 10, "{stood} samples in the play");
}
