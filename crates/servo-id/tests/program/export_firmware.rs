//! `servo-id export --firmware`: the loop of a scenario as constants, which begin at the estimates of a result.

use std::path::Path;

use identifier_core::constants::{Configuration, Constants};
use identifier_core::fixed_point::{FixedLoop, Word};
use identifier_core::identifier::{
    GaussNewtonIdentifier, GaussNewtonRecursion, GradientIdentifier, Identify, MachineEstimates,
    PreparedServo, ServoLoop,
};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{Parameter, Unknowns};

use crate::support::{assert_done, folder, refusal_message, scenario, servo_id};

type Gradient<S, const P: usize> = GradientIdentifier<f32, LowPass<f32>, S, P>;
type Closed<I> = ServoLoop<f32, LowPass<f32>, I>;

/// The result of the servo with friction, and where it is.
fn result(folder: &Path) -> (String, [f64; 4]) {
    let file = folder.join("result.json").display().to_string();
    let scenario = scenario("friction.toml");
    assert_done(&servo_id(&["run", &scenario, "--json", &file, "--quiet"]));
    let text = std::fs::read_to_string(&file).expect("written");
    let result: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let value = |name| {
        result["estimates"][name]["value"]
            .as_f64()
            .expect("a number")
    };
    (file, ["a", "b", "coulomb", "load"].map(value))
}

/// A scenario for a firmware in a folder: the one that comes with the program, with a change.
fn changed(folder: &Path, name: &str, from: &str, to: &str) -> String {
    let own = std::fs::read_to_string(scenario("firmware.toml")).expect("it is there");
    assert!(own.contains(from), "{from}");
    let file = folder.join(name);
    std::fs::write(&file, own.replace(from, to)).expect("written");
    file.display().to_string()
}

fn exported(arguments: &[&str]) -> String {
    let output = servo_id(&[&["export"], arguments].concat());
    assert_done(&output);
    String::from_utf8(output.stdout).expect("text")
}

/// The words of sources.
fn words(source: &str) -> Vec<u32> {
    let word = |word: &str| u32::from_str_radix(word.get(..8)?, 16).ok();
    source.split("0x").skip(1).filter_map(word).collect()
}

/// The configuration of sources.
fn read<T: Configuration>(source: &str) -> T {
    Constants::<T>::read(&words(source)).unwrap_or_else(|error| panic!("{error}: {source}"))
}

/// The SI values of machine estimates of one, as the sources have them.
fn units(source: &str) -> [f64; 4] {
    let after = source.rsplit(" SI: ").next().expect("the units");
    let numbers = after.split("_si[4] = {").last().expect("the units");
    let numbers: Vec<f64> = numbers
        .split([' ', ',', '}', ';'])
        .filter_map(|number| number.trim_end_matches('f').parse().ok())
        .collect();
    numbers.try_into().expect("four numbers")
}

/// Estimates that begin where the result ended, in SI and by the units of the sources.
fn begins_at<N: Copy, I: MachineEstimates<N>>(
    identifier: &I,
    state: &I::State,
    number: impl Fn(N) -> f64,
    source: &str,
    estimates: [f64; 4],
    parameters: &[Parameter],
) {
    let machine = identifier.machine_estimates(state);
    let found = identifier.estimates(state).expect("estimates");
    for &parameter in parameters {
        let place = parameter as usize;
        let expected = estimates[place];
        let close = |found: f64| (found / expected - 1.0).abs() < 1e-4;
        assert!(
            close(parameter.value_in(&found)),
            "{parameter:?}: {found:?}"
        );
        let si = number(machine.get(parameter)) * units(source)[place];
        assert!(close(si), "{parameter:?}: {si}, {expected}");
    }
}

#[test]
fn a_loop_begins_at_the_estimates_of_the_result() {
    let folder = folder("export-firmware");
    let (result, estimates) = result(&folder);
    let scenario = scenario("firmware.toml");
    let with_friction = [Parameter::A, Parameter::B, Parameter::Coulomb];

    let rust = exported(&[&result, "--firmware", "rust", "--scenario", &scenario]);
    let own: Closed<Gradient<Unknowns<3>, 3>> = read(&rust);
    let (identifier, state) = (own.identifier(), own.start(0));
    let state = state.identification();
    begins_at(
        identifier,
        state,
        f64::from,
        &rust,
        estimates,
        &with_friction,
    );
    assert!(identifier.certificate().is_some());
    for part in [
        "pub type Loop = ::identifier_core::identifier::ServoLoop<f32,",
        "::identifier_core::parameters::Unknowns<3>, 3>>;",
        "pub const LOOP: ::identifier_core::constants::Constants<Loop>",
        "kp = 9, kd = 0.19, ki = 4",
        "a from 0 to 50 1/s and b from 110 to 1000",
    ] {
        assert!(rust.contains(part), "{part}: {rust}");
    }

    let c = exported(&[
        &result,
        "--firmware",
        "c",
        "--scenario",
        &scenario,
        "--joint",
        "elbow",
    ]);
    let (of_c, ()): (Closed<Gradient<Unknowns<3>, 3>>, ()) = read(&c);
    assert!(of_c == own);
    begins_at(identifier, state, f64::from, &c, estimates, &with_friction);
    for part in [
        "servo_id_gradient_coulomb_loop_init_from_constants",
        "static const uint32_t elbow_words[130] = {",
        "static const float elbow_si[4] = {",
    ] {
        assert!(c.contains(part), "{part}: {c}");
    }

    // Without friction, and in fixed point.
    let fixed = changed(
        &folder,
        "fixed.toml",
        "parameters = [\"a\", \"b\", \"coulomb\"]",
        "parameters = [\"a\", \"b\"]\narithmetic = \"fixed\"",
    );
    let rust = exported(&[&result, "--firmware", "rust", "--scenario", &fixed]);
    let own: FixedLoop<2> = read(&rust);
    let (identifier, state) = (own.identifier(), own.start(0));
    let (state, known) = (state.identification(), &with_friction[..2]);
    begins_at(
        identifier,
        state,
        |word: Word| word.to_num(),
        &rust,
        estimates,
        known,
    );
    let c = exported(&[&result, "--firmware", "c", "--scenario", &fixed]);
    let bits = |word: Word| f64::from(word.to_bits());
    begins_at(identifier, state, bits, &c, estimates, known);
    assert!(c.contains("servo_id_fixed_loop_init_from_constants"), "{c}");
    assert!(read::<(FixedLoop<2>, ())>(&c).0 == own);

    // Beside a controller of the firmware's own.
    let beside = changed(
        &folder,
        "beside.toml",
        "[controller]\nkp = 9.0\nkd = 0.19\nki = 4.0\nsample_time = 0.001\n\n[identifier]",
        "[identifier]\ncorrection = { kp = 9.0, kd = 0.19, ki = 4.0 }",
    );
    let rust = exported(&[&result, "--firmware", "rust", "--scenario", &beside]);
    let own: Gradient<Unknowns<3>, 3> = read(&rust);
    begins_at(
        &own,
        &own.start(),
        f64::from,
        &rust,
        estimates,
        &with_friction,
    );
    assert!(rust.contains("pub const IDENTIFIER"), "{rust}");
}

#[test]
fn gauss_newton_starts_from_the_servo_of_the_result() {
    type Known<I> = (Closed<I>, PreparedServo<f32>);
    let folder = folder("export-firmware-gauss-newton");
    let (result, estimates) = result(&folder);
    // The scenario of the result itself.
    let rust = exported(&[&result, "--firmware", "rust"]);
    let (own, known): Known<GaussNewtonRecursion<f32, Unknowns<4>, 4>> = read(&rust);
    let state = own.identifier().start_from(&known);
    begins_at(
        own.identifier(),
        &state,
        f64::from,
        &rust,
        estimates,
        &Parameter::ALL,
    );
    let errors = own
        .identifier()
        .report(&state)
        .errors_of_parameters()
        .expect("known ones");
    assert!(
        errors.b > 0.0 && errors.b < 0.01 * estimates[1],
        "{errors:?}"
    );
    assert!(
        rust.contains("GaussNewtonRecursion<f32,") && rust.contains("(Loop, "),
        "{rust}"
    );

    let c = exported(&[&result, "--firmware", "c"]);
    let (own, known): Known<GaussNewtonIdentifier<f32, Unknowns<4>, 4>> = read(&c);
    let state = own.identifier().start_from(&known);
    begins_at(
        own.identifier(),
        &state,
        f64::from,
        &c,
        estimates,
        &Parameter::ALL,
    );
    assert!(
        c.contains("servo_id_gauss_newton_loop_init_from_constants"),
        "{c}"
    );
}

#[test]
fn what_has_no_such_form_is_refused_with_the_remedy() {
    let folder = folder("export-firmware-refusals");
    let (result, _) = result(&folder);
    let text = std::fs::read_to_string(&result).expect("written");
    let moving = folder.join("moving.json").display().to_string();
    std::fs::write(&moving, text.replacen("\"converged\"", "\"moving\"", 1)).expect("written");
    let own = scenario("firmware.toml");
    let law = "law = \"gradient\"\nparameters = [\"a\", \"b\", \"coulomb\"]";
    let parameter_range = "servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }";
    for (number, (to, from, change, part)) in [
        (
            "rust",
            law.to_owned() + "\n" + parameter_range,
            "law = \"fit\"",
            "identifier.law",
        ),
        (
            "rust",
            parameter_range.to_owned(),
            "",
            "identifier.servo_range",
        ),
        (
            "rust",
            parameter_range.to_owned(),
            &*format!("{parameter_range}\narithmetic = \"f64\""),
            "identifier.arithmetic",
        ),
        (
            "c",
            "\"coulomb\"]".to_owned(),
            "\"coulomb\", \"load\"]",
            "identifier.parameters",
        ),
        (
            "rust",
            "limit = 10.0".to_owned(),
            "limit = 10.0\ndelay = 0.002",
            "amplifier",
        ),
        // No certificate: the PID is too weak for the parameter range.
        ("rust", "kp = 9.0".to_owned(), "kp = 0.5", "controller"),
    ]
    .into_iter()
    .enumerate()
    {
        let changed = changed(&folder, &format!("{number}.toml"), &from, change);
        let call = ["export", &result, "--firmware", to, "--scenario", &changed];
        let message = refusal_message(&servo_id(&call));
        assert!(message.contains(part), "{change}: {message}");
    }
    for (call, part) in [
        (
            "MOVING --firmware rust --scenario OWN",
            "--accept-unconverged",
        ),
        ("RESULT --firmware c --scenario OWN --joint 1x", "1x"),
        ("RESULT MOVING --firmware c --scenario OWN", "2"),
        ("RESULT --firmware rust --ratios", "--ratios"),
        ("RESULT --scenario OWN --format mjcf --ratios", "--scenario"),
    ] {
        let call = call
            .replace("MOVING", &moving)
            .replace("RESULT", &result)
            .replace("OWN", &own);
        let call: Vec<&str> = ["export"].into_iter().chain(call.split(' ')).collect();
        let message = refusal_message(&servo_id(&call));
        assert!(message.contains(part), "{call:?}: {message}");
    }
    // A result of elsewhere has no scenario.
    let without = folder.join("without.json").display().to_string();
    let (before, _) = text.split_once("\"origin\"").expect("an origin");
    let before = before.trim_end().trim_end_matches(',');
    std::fs::write(&without, format!("{before}}}")).expect("written");
    let message = refusal_message(&servo_id(&["export", &without, "--firmware", "rust"]));
    assert!(message.contains("--scenario"), "{message}");
}
