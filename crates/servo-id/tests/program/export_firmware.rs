//! `servo-id export --firmware`: the loop of a scenario as constants, which begin at the estimates of a result.

use identifier_core::constants::{Configuration, Constants};
use identifier_core::control::{Shaped, Unshaped};
use identifier_core::fixed_point::{FixedLoop, Word};
use identifier_core::identifier::{
    GaussNewtonIdentifier, GaussNewtonRecursion, GradientIdentifier, Identify, MachineEstimates,
    PreparedServo, ServoLoop,
};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{Parameter, Unknowns};

use crate::support::{Folder, estimate, own_folder, scenario_text, table};

type Gradient<S, const P: usize> = GradientIdentifier<f32, LowPass<f32>, S, P>;
type Closed<I, S = Unshaped> = ServoLoop<f32, LowPass<f32>, I, S>;

/// A folder with a scenario for a firmware, the result of the servo with friction, and its estimates.
fn identified() -> (Folder, [f64; 4]) {
    let folder = own_folder();
    for name in ["friction.toml", "firmware.toml"] {
        folder.write(name, scenario_text(name));
    }
    let result = folder.json("run friction.toml");
    folder.write("result.json", result.to_string());
    (
        folder,
        ["a", "b", "coulomb", "load"].map(|name| estimate(&result, name)),
    )
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

/// Asserts that estimates begin where the result ended, in SI and by the units of the sources.
fn assert_begins<N: Copy, I: MachineEstimates<N>>(
    (identifier, state): (&I, &I::State),
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
        let si = number(machine.get(parameter)) * units(source)[place];
        for found in [found.get(parameter), si] {
            let off = (found / expected - 1.0).abs();
            assert!(off < 1e-4, "{parameter:?}: {found}, {expected}");
        }
    }
}

fn assert_contains(source: &str, parts: &[&str]) {
    for part in parts {
        assert!(source.contains(part), "{part}: {source}");
    }
}

#[test]
fn a_loop_begins_at_the_estimates_of_the_result() {
    let (folder, estimates) = identified();
    let export = |scenario: &str, form: &str| {
        folder.done(&format!(
            "export result.json --scenario {scenario} --firmware {form}"
        ))
    };
    let with_friction = [Parameter::A, Parameter::B, Parameter::Coulomb];

    let rust = export("firmware.toml", "rust");
    let own: Closed<Gradient<Unknowns<3>, 3>> = read(&rust);
    let (identifier, state) = (own.identifier(), own.start(0));
    let begun = (identifier, state.identification());
    assert_begins(begun, f64::from, &rust, estimates, &with_friction);
    assert!(identifier.certificate().is_some());
    assert_contains(
        &rust,
        &[
            "pub type Loop = ::identifier_core::identifier::ServoLoop<f32,",
            "::identifier_core::parameters::Unknowns<3>, 3>>;",
            "pub const LOOP: ::identifier_core::constants::Constants<Loop>",
            "kp = 9, kd = 0.19, ki = 4",
            "a from 0 to 50 1/s and b from 110 to 1000",
        ],
    );

    let c = export("firmware.toml", "c --joint elbow");
    let (of_c, ()): (Closed<Gradient<Unknowns<3>, 3>, Shaped<f32>>, ()) = read(&c);
    assert!(of_c.identifier() == identifier);
    assert_begins(begun, f64::from, &c, estimates, &with_friction);
    assert_contains(
        &c,
        &[
            "servo_id_gradient_coulomb_loop_init_from_constants",
            "static const uint32_t elbow_words[139] = {",
            "static const float elbow_si[4] = {",
        ],
    );

    // Without friction, and in fixed point.
    let fixed = "parameters = [\"a\", \"b\"]\narithmetic = \"fixed\"";
    folder.write_scenario("firmware.toml", UNKNOWNS, fixed);
    let [rust, c] = ["rust", "c"].map(|form| export("firmware.toml", form));
    let own: FixedLoop<2> = read(&rust);
    let (identifier, state) = (own.identifier(), own.start(0));
    let (begun, known) = ((identifier, state.identification()), &with_friction[..2]);
    assert_begins(begun, |word: Word| word.to_num(), &rust, estimates, known);
    let bits = |word: Word| f64::from(word.to_bits());
    assert_begins(begun, bits, &c, estimates, known);
    assert_contains(&c, &["servo_id_fixed_loop_init_from_constants"]);
    let of_c = read::<(FixedLoop<2, Shaped<Word>>, ())>(&c).0;
    assert!(of_c.identifier() == identifier);

    // With a filter of the reference.
    let (folder, _) = identified();
    folder.write_scenario(
        "firmware.toml",
        "ki = 4.0",
        "ki = 4.0\nreference_filter = 0.02",
    );
    let rust = folder.done("export result.json --scenario firmware.toml --firmware rust");
    read::<Closed<Gradient<Unknowns<3>, 3>, Shaped<f32>>>(&rust);
    assert_contains(&rust, &["::identifier_core::control::Shaped<f32>>;"]);

    // Beside a controller of the firmware's own.
    folder.write_scenario(
        "firmware.toml",
        "[controller]\nkp = 9.0\nkd = 0.19\nki = 4.0\nsample_time = 0.001\n\n[identifier]",
        "[identifier]\ncorrection = { kp = 9.0, kd = 0.19, ki = 4.0 }",
    );
    let rust = export("firmware.toml", "rust");
    let own: Gradient<Unknowns<3>, 3> = read(&rust);
    let begun = (&own, &own.start());
    assert_begins(begun, f64::from, &rust, estimates, &with_friction);
    assert_contains(&rust, &["pub const IDENTIFIER"]);
}

#[test]
fn gauss_newton_starts_from_the_servo_of_the_result() {
    type Known<I, S = Unshaped> = (Closed<I, S>, PreparedServo<f32>);
    let (folder, estimates) = identified();
    // The scenario of the result itself.
    let [rust, c] =
        ["rust", "c"].map(|form| folder.done(&format!("export result.json --firmware {form}")));
    let (own, known): Known<GaussNewtonRecursion<f32, Unknowns<4>, 4>> = read(&rust);
    let identifier = own.identifier();
    let state = identifier.start_from(&known);
    assert_begins(
        (identifier, &state),
        f64::from,
        &rust,
        estimates,
        &Parameter::ALL,
    );
    let errors = identifier.report(&state).errors_of_parameters();
    let error = errors.expect("known ones").b;
    assert!(error > 0.0 && error < 0.01 * estimates[1], "{error}");
    assert_contains(&rust, &["GaussNewtonRecursion<f32,", "(Loop, "]);

    let (own, known): Known<GaussNewtonIdentifier<f32, Unknowns<4>, 4>, Shaped<f32>> = read(&c);
    let state = own.identifier().start_from(&known);
    let begun = (own.identifier(), &state);
    assert_begins(begun, f64::from, &c, estimates, &Parameter::ALL);
    assert_contains(&c, &["servo_id_gauss_newton_loop_init_from_constants"]);
}

const UNKNOWNS: &str = "parameters = [\"a\", \"b\", \"coulomb\"]";
const RANGE: &str = "servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }";

/// What is changed in the scenario, to what, the form, and the key that the answer names.
const NO_SUCH_FORM: &str = r#"
law = "gradient"; UNKNOWNS; RANGE | law = "fit" | rust | identifier.law
RANGE | | rust | identifier.servo_range
RANGE | RANGE; arithmetic = "f64" | rust | identifier.arithmetic
"coulomb"] | "coulomb", "load"] | c | identifier.parameters
limit = 10.0 | limit = 10.0; delay = 0.002 | rust | amplifier
kp = 9.0 | kp = 0.5 | rust | controller
"#;

const REFUSED: &str = "
export moving.json --firmware rust --scenario own.toml | --accept-unconverged
export result.json --firmware c --scenario own.toml --joint 1x | 1x
export result.json moving.json --firmware c --scenario own.toml | 2
export result.json --firmware rust --ratios | --ratios
export result.json --scenario own.toml --format mjcf --ratios | --scenario
export elsewhere.json --firmware rust | --scenario
";

#[test]
fn what_has_no_such_form_is_refused_with_the_remedy() {
    let (folder, _) = identified();
    folder.write("own.toml", scenario_text("firmware.toml"));
    let rows = NO_SUCH_FORM
        .replace("UNKNOWNS", UNKNOWNS)
        .replace("RANGE", RANGE);
    for row in table(&rows) {
        folder.write_scenario("firmware.toml", &row[0], &row[1]);
        let call = "export result.json --scenario firmware.toml --firmware";
        let message = folder.refused(&format!("{call} {}", row[2]));
        assert!(message.contains(&row[3]), "{row:?}: {message}");
    }
    let mut result = folder.read_json("result.json");
    let mut elsewhere = result.clone();
    elsewhere["origin"].take();
    folder.write("elsewhere.json", elsewhere.to_string());
    result["status"] = "moving".into();
    folder.write("moving.json", result.to_string());
    folder.assert_refused(REFUSED);
}
