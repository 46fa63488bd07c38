//! The drawn logs as files, for experiments with other programs.

use std::io::Write;
use std::path::PathBuf;

use integration_tests::logs::{RecordedLog, drawn};
use integration_tests::{environment, in_parallel};
use serde_json::json;
use virtual_servo::Effects;

/// The truth of a log.
fn truth(number: u32, log: &RecordedLog) -> serde_json::Value {
    let setup = &log.setup;
    let (servo, effects, sensor) = (&setup.servo, &setup.effects, &setup.sensor);
    let count = std::f64::consts::TAU / setup.counts_per_rev;
    let names: Vec<&str> = setup.present.iter().map(|effect| effect.name()).collect();
    let steps: Vec<_> = setup
        .load_steps
        .iter()
        .map(|step| json!([step.sample, step.load]))
        .collect();
    let sizes = sizes(effects);
    json!({
        "log": number,
        "file": format!("{number:05}.bin"),
        "sample_time": setup.sample_time,
        "counts_per_rev": setup.counts_per_rev,
        "samples": setup.samples,
        "limit": setup.limit,
        "at_rest_at_first": setup.skipped == 0,
        "controller": setup.controller.name(),
        "reference": setup.reference.name(),
        "bandwidth": setup.bandwidth,
        "a": servo.a, "b": servo.b, "coulomb": servo.coulomb, "load": servo.load,
        "command_peak": log.command_exceeded_by(0.001),
        "velocity_rms": log.velocity_rms,
        "range_counts": log.range / count,
        "effects": names,
        "shift": setup.shift,
        "noise_counts": sensor.noise / count,
        "jitter": sensor.jitter,
        "eccentricity": sensor.eccentricity,
        "load_steps": steps,
        "sizes": sizes,
    })
}

/// The sizes of its effects, as [`Effects`] has them.
fn sizes(effects: &Effects) -> serde_json::Value {
    json!({
        "delay": effects.delay,
        "current_loop": effects.current_loop,
        "asymmetry": effects.asymmetry,
        "quadratic_friction": effects.quadratic_friction,
        "low_speed_friction": effects.low_speed_friction,
        "low_speed_velocity": effects.low_speed_velocity,
        "load_dependent_friction": effects.load_dependent_friction,
        "gravity": effects.gravity,
        "ripple": effects.ripple,
        "ripple_order": effects.ripple_order,
        "torque_ripple": effects.torque_ripple,
        "torque_ripple_order": effects.torque_ripple_order,
        "inertia_variation": effects.inertia_variation,
        "inertia_order": effects.inertia_order,
        "gain_asymmetry": effects.gain_asymmetry,
        "dead_band": effects.dead_band,
        "hidden_limit": effects.hidden_limit,
        "gain_drift": effects.gain_drift,
        "friction_drift": effects.friction_drift,
        "resonance": effects.resonance,
        "resonance_damping": effects.resonance_damping,
        "inertia_ratio": effects.inertia_ratio,
        "backlash": effects.backlash,
    })
}

/// Writes a log: per sample the position in counts and the command as recorded, f64, little endian.
fn write(file: std::fs::File, log: &RecordedLog) -> std::io::Result<()> {
    let mut file = std::io::BufWriter::new(file);
    for (count, command) in log.counts.iter().zip(&log.commands) {
        file.write_all(&(*count as f64).to_le_bytes())?;
        file.write_all(&command.to_le_bytes())?;
    }
    file.flush()
}

#[test]
#[ignore = "writes files: LOGS_DIR=directory"]
fn are_written_with_their_truth() {
    let directory: PathBuf =
        environment("LOGS_DIR").expect("LOGS_DIR is the directory to write to");
    let (campaign, count) = super::campaign(300);
    std::fs::create_dir_all(&directory).expect("the directory can be made");
    let numbers: Vec<u32> = (0..count).collect();
    let lines = in_parallel(&numbers, |&number| {
        let log = drawn(campaign, number);
        let file = std::fs::File::create(directory.join(format!("{number:05}.bin")));
        write(file.expect("a file"), &log).expect("written");
        truth(number, &log).to_string()
    });
    std::fs::write(directory.join("truth.jsonl"), lines.join("\n") + "\n").expect("written");
}
