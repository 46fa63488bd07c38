//! The contract of `servo-id export`: formats, scales, refusals.

use serde_json::{Value, json};

use crate::support::{Folder, number, own_folder};

/// A folder with results by name: a file and its status.
fn with(results: &[(&str, &str)]) -> Folder {
    let folder = own_folder();
    let estimate = |value: f64, error: f64| json!({ "value": value, "std_error": error });
    for (name, status) in results {
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
        folder.write(name, result.to_string());
    }
    folder
}

/// A folder with the result of an elbow.
fn elbow() -> Folder {
    with(&[("elbow.json", "converged")])
}

/// The JSON that is exported.
fn exported(folder: &Folder, words: &str) -> Value {
    let text = folder.done(&format!("export {words}"));
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn each_format_names_the_quantities_as_its_simulator_does() {
    let folder = elbow();
    for format in ["mjcf", "urdf", "isaac-lab"] {
        let text = folder.done(&format!(
            "export elbow.json --format {format} --torque-constant 0.4 --link-inertia 0.0005 --limit 5"
        ));
        // The version changes with every commit.
        let version = text.split("servo-id ").nth(1);
        let version = version.and_then(|rest| rest.split(',').next());
        let text = version.map_or(text.clone(), |version| text.replace(version, "VERSION"));
        insta::assert_snapshot!(format!("export_{format}"), text);
    }
}

#[test]
fn json_has_every_quantity_with_its_error_and_unit() {
    let joints = exported(&elbow(), "elbow.json --format json --inertia 0.002");
    for (key, expected) in [
        ("/name", json!("elbow")),
        ("/torque_constant/value", json!(0.4)),
        ("/friction/unit", json!("N·m")),
        ("/damping/unit", json!("N·m·s/rad")),
        ("/effort_limit", Value::Null),
        ("/origin/status", json!("converged")),
    ] {
        assert_eq!(joints["joints"][0].pointer(key), Some(&expected), "{key}");
    }
}

#[test]
fn several_results_are_the_joints_of_one_file() {
    let folder = with(&[("one.json", "converged"), ("two.json", "converged")]);
    folder.done(
        "export one.json two.json --format mjcf --joint hip --joint knee --torque-constant 0.4 \
         --torque-constant 0.8 --output joints.xml",
    );
    let text = folder.read("joints.xml");
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
    let folder = elbow();
    const CALL: &str = "elbow.json --format bam --torque-constant 0.04";
    // J = K/b = 2·10⁻⁴: a J = 10⁻⁴, c J = 1.6·10⁻³.
    let of_current = exported(&folder, CALL);
    // Of a voltage, k = K R, and k²/R = K² R = 8·10⁻⁵ of the friction is the motor's own voltage.
    let of_voltage = exported(&folder, &format!("{CALL} --resistance 0.05"));
    for (of, name, value) in [
        (&of_current, "model", json!("m1")),
        (&of_current, "actuator", json!("elbow")),
        (&of_current, "kt", json!(0.04)),
        (&of_current, "armature", json!(2e-4)),
        (&of_current, "friction_base", json!(1.6e-3)),
        (&of_current, "friction_viscous", json!(1e-4)),
        (&of_current, "command_delay", json!(1e-3)),
        (&of_current, "R", Value::Null),
        (&of_voltage, "R", json!(0.05)),
        (&of_voltage, "kt", json!(0.002)),
        (&of_voltage, "friction_viscous", json!(2e-5)),
    ] {
        assert_eq!(of[name], value, "{name}");
    }
    let errors = &of_current["servo_id"]["errors"];
    let armature = json!({ "std_error": 2e-6, "unit": "kg·m²" });
    assert_eq!(errors["armature"], armature);
    assert_eq!(errors["kt"]["std_error"], Value::Null);
}

#[test]
fn a_payload_and_the_result_without_it_give_the_inertia() {
    let folder = with(&[("with.json", "converged"), ("bare.json", "converged")]);
    folder.write(
        "bare.json",
        folder.read("bare.json").replace("200.0", "250.0"),
    );
    let joints = exported(
        &folder,
        "with.json --format json --payload 0.001 --bare bare.json",
    );
    let inertia = number(&joints, "/joints/0/inertia/value");
    assert!((inertia - 0.005).abs() < 1e-12, "{inertia}");
}

const REFUSED: &str = r#"
export one.json --format mjcf | --torque-constant
export one.json moving.json --ratios --format mjcf | --accept-unconverged
export one.json --torque-constant -1 --format mjcf | torque-constant = -1
export one.json --inertia 1 --link-inertia 2 --format mjcf | link-inertia = 2
export one.json two.json --ratios --joint hip --format mjcf | --joint
export one.json one.json --ratios --format mjcf | --joint
export one.json --ratios --joint a"b --format mjcf | joint =
export one.json --inertia 1 --resistance 1 --format mjcf | resistance = 1
export one.json --payload 1 --bare one.json --format mjcf | payload = 1
export one.json none.json --ratios --format mjcf | none.json
export one.json two.json --format bam --ratios | 2
"#;

#[test]
fn what_would_be_a_guess_is_refused_with_its_remedy() {
    let folder = with(&[
        ("one.json", "converged"),
        ("two.json", "converged"),
        ("moving.json", "moving"),
    ]);
    folder.assert_refused(REFUSED);
}
