//! The noise of the position sensor, as every law reports it.

use serde_json::Value;

use crate::support::{folder, printed_json, servo_id};

/// Noise in counts, and how far it may be off beside rounding.
const NOISE: f64 = 2.0;
const COUNTS: f64 = 10_000.0;

/// The result of a run of a servo whose encoder has this noise.
fn result(law: &str) -> Value {
    let file = folder(&format!("noise-{law}")).join("noisy.toml");
    let noise = NOISE * std::f64::consts::TAU / COUNTS;
    let text = format!(
        "[plant]\na = 0.5\nb = 200.0\ncoulomb = 4.0\nload = 1.0\n[encoder]\ncounts_per_rev = {COUNTS:?}\n\
         noise = {noise:?}\n[identifier]\nlaw = \"{law}\"\n[run]\nduration = 4.0\n"
    );
    std::fs::write(&file, text).expect("written");
    printed_json(&servo_id(&[
        "run",
        &file.display().to_string(),
        "--json",
        "-",
    ]))
}

fn assert_is_the_sensors(noise: &Value) {
    let expected = NOISE.hypot(12.0_f64.sqrt().recip());
    let counts = noise["moving_counts"].as_f64().expect("it moves");
    assert!((counts / expected - 1.0).abs() < 0.05, "{noise}");
    let rad = noise["moving"].as_f64().expect("it moves");
    let of_counts = counts * std::f64::consts::TAU / COUNTS;
    assert!((rad / of_counts - 1.0).abs() < 1e-9, "{noise}");
}

#[test]
fn every_law_reports_the_noise_of_the_sensor() {
    for law in ["gradient", "gauss-newton", "fit"] {
        assert_is_the_sensors(&result(law)["noise"]);
    }
}

#[test]
fn the_terminal_shows_it_in_counts() {
    let file = folder("noise-terminal").join("plain.toml");
    let text = "[plant]\na = 0.5\nb = 200.0\n[identifier]\nlaw = \"gauss-newton\"\n[run]\nduration = 4.0\n";
    std::fs::write(&file, text).expect("written");
    let output = servo_id(&["run", &file.display().to_string()]);
    let shown = String::from_utf8_lossy(&output.stdout);
    assert!(
        shown.contains("counts (") && shown.contains("in motion"),
        "{shown}"
    );
}
