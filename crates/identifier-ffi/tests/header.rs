//! The header has what the library has: functions with their arguments, numbers, sizes and places.

use std::collections::BTreeSet;
use std::mem::offset_of;

use commissioning::Phase;
use identifier_ffi::commission::{CONDITIONS, CommissionResult, CommissionStep, PHASES};
use identifier_ffi::identifier::Estimates;
use identifier_ffi::judge::{STATES, Verdict};
use identifier_ffi::object::Object;
use identifier_ffi::settings::Settings;
use identifier_ffi::status::{ALLOWED, Error};
use identifier_ffi::tuner::{CAPS, Servo, Tuning};
use identifier_ffi::{Prototype, parameter, status};

const HEADER: &str = include_str!("../include/servo_id.h");

/// A type of Rust as C has it.
fn in_c(of: &str) -> String {
    let of = of.replace("* ", "*");
    let of = of.as_str();
    if let Some(to) = of.strip_prefix("*mut ") {
        return match to.strip_prefix("*const ") {
            Some("c_char") => "const char **".to_owned(),
            _ => format!("{} *", in_c(to)),
        };
    }
    if let Some(to) = of.strip_prefix("*const ") {
        return format!("const {} *", in_c(to));
    }
    match of {
        "i32" => "int32_t".to_owned(),
        "u32" => "uint32_t".to_owned(),
        "f32" => "float".to_owned(),
        "f64" => "double".to_owned(),
        name => format!("servo_id_{}", snake_case(name)),
    }
}

fn snake_case(name: &str) -> String {
    let mut found = String::new();
    for (place, letter) in name.char_indices() {
        if letter.is_uppercase() && place > 0 {
            found.push('_');
        }
        found.extend(letter.to_lowercase());
    }
    found
}

fn prototype(of: &Prototype) -> String {
    let argument = |(name, of): &(&str, &str)| {
        let of = in_c(of);
        let between = if of.ends_with('*') { "" } else { " " };
        format!("{of}{between}{name}")
    };
    let arguments: Vec<String> = of.arguments.iter().map(argument).collect();
    format!("int32_t {}({});", of.name, arguments.join(", "))
}

/// The header without comments, on one line.
fn code() -> String {
    let mut parts = HEADER.split("/*");
    let first = parts.next().unwrap_or_default().to_owned();
    let rest = parts
        .filter_map(|part| part.split_once("*/"))
        .map(|(_, code)| code);
    let code = rest.fold(first, |code, part| code + part);
    code.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn functions_have_the_same_arguments() {
    let code = code();
    let in_header: BTreeSet<String> = code
        .match_indices("int32_t servo_id_")
        .filter_map(|(from, _)| code.get(from..)?.split_once(';'))
        .filter(|(text, _)| text.contains('('))
        .map(|(text, _)| format!("{text};"))
        .collect();
    let in_library: BTreeSet<String> = identifier_ffi::prototypes().map(prototype).collect();
    assert!(in_library.len() > 60);
    assert_eq!(in_header, in_library);
}

#[test]
fn numbers_are_the_same() {
    let own = status::ROWS.iter().map(|row| (row.constant, row.number));
    let places = [("A", 0), ("B", 1), ("COULOMB", 2), ("LOAD", 3)];
    let listed = [ALLOWED, STATES, CAPS, &places, &PHASES, CONDITIONS]
        .into_iter()
        .flatten()
        .copied();
    let in_library: BTreeSet<(String, i32)> = own
        .chain(listed)
        .map(|(name, number)| (name.to_owned(), number))
        .collect();
    let in_header: BTreeSet<(String, i32)> = HEADER
        .lines()
        .filter_map(|line| line.strip_prefix("    SERVO_ID_")?.split_once(" = "))
        .filter_map(|(name, rest)| Some((name.to_owned(), rest.split(',').next()?.parse().ok()?)))
        .collect();
    assert_eq!(in_header, in_library);
}

/// True if the header asserts this of sizes and places when C compiles it.
fn asserts(text: &str) -> bool {
    code().contains(text)
}

#[test]
fn sizes_and_places_are_the_same() {
    assert_eq!(align_of::<Object<u8>>(), 8);
    for (name, words) in identifier_ffi::objects() {
        let bytes = 8 * words;
        assert!(
            asserts(&format!("uint64_t words[{words}]; }} servo_id_{name};")),
            "{name}"
        );
        assert!(
            asserts(&format!(
                "SERVO_ID_ASSERT(sizeof(servo_id_{name}) == {bytes},"
            )),
            "{name}"
        );
        assert!(
            asserts(&format!(
                "SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_{name}) == 8,"
            )),
            "{name}"
        );
    }
    for (name, size) in [
        ("settings", size_of::<Settings>()),
        ("error", size_of::<Error>()),
        ("estimates", size_of::<Estimates>()),
        ("verdict", size_of::<Verdict>()),
        ("servo", size_of::<Servo>()),
        ("tuning", size_of::<Tuning>()),
        ("commission_step", size_of::<CommissionStep>()),
        ("commission_result", size_of::<CommissionResult>()),
    ] {
        assert!(
            asserts(&format!(
                "SERVO_ID_ASSERT(sizeof(servo_id_{name}) == {size},"
            )),
            "{name}"
        );
    }
    let places = [
        ("settings, limit", offset_of!(Settings, limit)),
        ("settings, feed_forward", offset_of!(Settings, feed_forward)),
        ("settings, bounds", offset_of!(Settings, bounds)),
        ("settings, servo_range", offset_of!(Settings, servo_range)),
        ("settings, ranges", offset_of!(Settings, ranges)),
        ("settings, resonance", offset_of!(Settings, resonance)),
        ("settings, travel", offset_of!(Settings, travel)),
        ("settings, known", offset_of!(Settings, known)),
        ("error, value", offset_of!(Error, value)),
        ("error, high", offset_of!(Error, high)),
        ("error, parameter", offset_of!(Error, parameter)),
        ("estimates, std_error", offset_of!(Estimates, std_error)),
        ("estimates, at_bound", offset_of!(Estimates, at_bound)),
        ("verdict, state", offset_of!(Verdict, state)),
        ("servo, delay", offset_of!(Servo, delay)),
        ("servo, covariance", offset_of!(Servo, covariance)),
        ("servo, unexplained", offset_of!(Servo, unexplained)),
        ("tuning, step", offset_of!(Tuning, step)),
        ("tuning, rise_time", offset_of!(Tuning, rise_time)),
        ("tuning, overshoot", offset_of!(Tuning, overshoot)),
        ("tuning, gain_margin", offset_of!(Tuning, gain_margin)),
        ("tuning, compliance", offset_of!(Tuning, compliance)),
        ("tuning, cap", offset_of!(Tuning, cap)),
        (
            "commission_step, record",
            offset_of!(CommissionStep, record),
        ),
        (
            "commission_result, tuning",
            offset_of!(CommissionResult, tuning),
        ),
        (
            "commission_result, measured_rise_time",
            offset_of!(CommissionResult, measured_rise_time),
        ),
    ];
    for (field, place) in places {
        assert!(
            asserts(&format!("offsetof(servo_id_{field}) == {place},")),
            "{field}"
        );
    }
    assert_eq!(code().matches("offsetof(").count(), places.len());
}

/// The members of a structure of the header, with their types.
fn members(name: &str) -> Vec<(String, String)> {
    let code = code();
    let end = code.find(&format!("}} servo_id_{name};"));
    let begin = code[..end.expect("a structure")]
        .rfind('{')
        .expect("its beginning")
        + 1;
    let members = code[begin..end.expect("a structure")].split(';');
    let pairs = members.filter_map(|member| member.trim().rsplit_once(' '));
    pairs
        .map(|(of, name)| (name.to_owned(), of.to_owned()))
        .collect()
}

/// The fields of the settings in the order of the header, and those of their structures.
fn fields() -> Vec<String> {
    let mut all = Vec::new();
    for (name, of) in members("settings") {
        if let Some(inner) = of.strip_prefix("servo_id_") {
            let own = members(inner);
            all.extend(own.iter().map(|(part, _)| format!("{name}.{part}")));
        }
        all.push(name);
    }
    all
}

#[test]
fn fields_of_the_settings_are_in_the_order_of_the_library() {
    let library = format!("{:?}", Settings::default());
    let mut from = 0;
    for (name, _) in members("settings") {
        let place = library[from..].find(&format!(" {name}: "));
        from += place.unwrap_or_else(|| panic!("{name} in {}", &library[from..])) + 1;
    }
}

#[test]
fn a_refusal_names_a_field_of_the_header() {
    let fields = fields();
    for (core, field) in parameter::NAMES {
        let field = field.to_str().expect("text");
        assert!(fields.iter().any(|own| own == field), "{core}: {field}");
    }
}

#[test]
fn phases_are_numbered_in_their_order() {
    for (phase, (name, number)) in Phase::ALL.into_iter().zip(PHASES) {
        assert_eq!(phase as i32, number, "{name}");
    }
}
