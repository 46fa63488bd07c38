//! The contract of `servo-id export`: formats, scales, refusals.

use std::path::Path;

use serde_json::{Value, json};

use crate::support::{assert_done, folder, refusal_message, servo_id};

fn result(folder: &Path, name: &str, status: &str) -> String {
    let estimate = |value: f64, error: f64| json!({ "value": value, "std_error": error });
    let result = json!({
        "law": "fit", "status": status, "reason": "it moves", "sample_time": 1e-3,
        "estimates": {
            "a": estimate(0.5, 0.05),
            "b": { "value": 200.0, "std_error": 2.0, "unit": "rad/s² per command unit" },
            "coulomb": estimate(8.0, 0.4),
            "load": estimate(-4.0, 0.2),
            "delay": estimate(1e-3, 1e-4),
        },
    });
    let path = folder.join(name);
    std::fs::write(&path, result.to_string()).expect("a file");
    path.display().to_string()
}

/// The output of an export without a failure, the version left out, which changes with every commit.
fn exported(arguments: &[&str]) -> String {
    let output = servo_id(&[&["export"], arguments].concat());
    assert_done(&output);
    let text = String::from_utf8(output.stdout).expect("text");
    let version = text
        .split("servo-id ")
        .nth(1)
        .and_then(|rest| rest.split(',').next());
    version.map_or(text.clone(), |version| text.replace(version, "VERSION"))
}

#[test]
fn each_format_names_the_quantities_as_its_simulator_does() {
    let folder = folder("export-formats");
    let elbow = result(&folder, "elbow.json", "converged");
    for format in ["mjcf", "urdf", "isaac-lab"] {
        let text = exported(&[
            &elbow,
            "--format",
            format,
            "--torque-constant",
            "0.4",
            "--link-inertia",
            "0.0005",
            "--limit",
            "5",
        ]);
        insta::assert_snapshot!(format!("export_{format}"), text);
    }
}

#[test]
fn json_has_every_quantity_with_its_error_and_unit() {
    let folder = folder("export-json");
    let elbow = result(&folder, "elbow.json", "converged");
    let text = exported(&[&elbow, "--format", "json", "--inertia", "0.002"]);
    let joints: Value = serde_json::from_str(&text).expect("JSON");
    let joint = &joints["joints"][0];
    assert_eq!(joint["name"], "elbow");
    assert_eq!(joint["torque_constant"]["value"], 0.4);
    assert_eq!(joint["friction"]["unit"], "N·m");
    assert_eq!(joint["damping"]["unit"], "N·m·s/rad");
    assert_eq!(joint["effort_limit"], Value::Null);
    assert_eq!(joint["origin"]["status"], "converged");
}

#[test]
fn several_results_are_the_joints_of_one_file() {
    let folder = folder("export-joints");
    let [one, two] = ["one.json", "two.json"].map(|name| result(&folder, name, "converged"));
    let file = folder.join("joints.xml").display().to_string();
    let output = servo_id(&[
        "export",
        &one,
        &two,
        "--format",
        "mjcf",
        "--joint",
        "hip",
        "--joint",
        "knee",
        "--torque-constant",
        "0.4",
        "--torque-constant",
        "0.8",
        "--output",
        &file,
    ]);
    assert_done(&output);
    let text = std::fs::read_to_string(&file).expect("a file");
    for part in [
        "class=\"hip\"",
        "class=\"knee\"",
        "armature=\"0.002\"",
        "armature=\"0.004\"",
    ] {
        assert_eq!(text.matches(part).count(), 1, "{part}: {text}");
    }
}

#[test]
fn bam_takes_the_parameters_of_its_model_m1() {
    let folder = folder("export-bam");
    let elbow = result(&folder, "elbow.json", "converged");
    let bam = |more: &[&str]| -> Value {
        let options = ["--format", "bam", "--torque-constant", "0.04"];
        let text = exported(&[&[elbow.as_str()], &options[..], more].concat());
        serde_json::from_str(&text).expect("JSON")
    };
    // J = K/b = 2·10⁻⁴: a J = 10⁻⁴, c J = 1.6·10⁻³.
    let of_current = bam(&[]);
    assert_eq!(of_current["model"], "m1");
    assert_eq!(of_current["actuator"], "elbow");
    for (name, value) in [
        ("kt", 0.04),
        ("armature", 2e-4),
        ("friction_base", 1.6e-3),
        ("friction_viscous", 1e-4),
        ("command_delay", 1e-3),
    ] {
        assert_eq!(of_current[name], value, "{name}");
    }
    assert_eq!(of_current["R"], Value::Null);
    let errors = &of_current["servo_id"]["errors"];
    assert_eq!(
        errors["armature"],
        json!({ "std_error": 2e-6, "unit": "kg·m²" })
    );
    assert_eq!(errors["kt"]["std_error"], Value::Null);

    // Of a voltage, k = K R, and k²/R = K² R = 8·10⁻⁵ of the friction is the motor's own voltage.
    let of_voltage = bam(&["--resistance", "0.05"]);
    assert_eq!(of_voltage["R"], 0.05);
    assert_eq!(of_voltage["kt"], 0.002);
    assert_eq!(of_voltage["friction_viscous"], 2e-5);
}

#[test]
fn a_payload_and_the_result_without_it_give_the_inertia() {
    let folder = folder("export-payload");
    let [with, bare] = ["with.json", "bare.json"].map(|name| result(&folder, name, "converged"));
    let text = std::fs::read_to_string(&bare).expect("a file");
    std::fs::write(&bare, text.replace("200.0", "250.0")).expect("a file");
    let options = ["--format", "json", "--payload", "0.001", "--bare"];
    let text = exported(&[&[with.as_str()], &options[..], &[&bare]].concat());
    let joints: Value = serde_json::from_str(&text).expect("JSON");
    let inertia = joints["joints"][0]["inertia"]["value"].as_f64();
    assert!(
        inertia.is_some_and(|inertia| (inertia - 0.005).abs() < 1e-12),
        "{text}"
    );
}

#[test]
fn what_would_be_a_guess_is_refused_with_its_remedy() {
    let folder = folder("export-refusals");
    let [one, two, moving] = [
        ("one.json", "converged"),
        ("two.json", "converged"),
        ("moving.json", "moving"),
    ]
    .map(|(name, status)| result(&folder, name, status));
    for (options, part) in [
        ("", "--torque-constant"),
        ("MOVING --ratios", "--accept-unconverged"),
        ("--torque-constant -1", "torque-constant = -1"),
        ("--inertia 1 --link-inertia 2", "link-inertia = 2"),
        ("TWO --ratios --joint hip", "--joint"),
        ("ONE --ratios", "--joint"),
        ("--ratios --joint a\"b", "joint = "),
        ("--inertia 1 --resistance 1", "resistance = 1"),
        ("--payload 1 --bare ONE", "payload = 1"),
        ("none.json --ratios", "none.json"),
        ("TWO --format bam --ratios", "2"),
    ] {
        let options = options
            .replace("ONE", &one)
            .replace("TWO", &two)
            .replace("MOVING", &moving);
        let format = if options.contains("--format") {
            ""
        } else {
            " --format mjcf"
        };
        let call = format!("export {one} {options}{format}");
        let message = refusal_message(&servo_id(&call.split_whitespace().collect::<Vec<_>>()));
        assert!(message.contains(part), "{call}: {message}");
    }
}
