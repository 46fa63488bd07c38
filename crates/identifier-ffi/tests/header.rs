//! The header has what the library has: functions with their arguments, numbers, sizes and places.

use std::collections::BTreeSet;
use std::mem::offset_of;

use commissioning::Phase;
use identifier_ffi::commission::{CONDITIONS, CommissionResult, CommissionStep, PHASES};
use identifier_ffi::identifier::Estimates;
use identifier_ffi::judge::{STATES, Verdict};
use identifier_ffi::object::Object;
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
    let own = parameter::ROWS.iter().map(|row| (row.constant, row.number));
    let own = own.chain(status::ROWS.iter().map(|row| (row.constant, row.number)));
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
        .filter_map(|line| line.strip_prefix("#define SERVO_ID_"))
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            Some((words.next()?.to_owned(), words.next()?.parse().ok()?))
        })
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
        ("error, value", offset_of!(Error, value)),
        ("error, low", offset_of!(Error, low)),
        ("error, high", offset_of!(Error, high)),
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

#[test]
fn parameters_have_places_and_one_name_each() {
    let names: BTreeSet<_> = parameter::ROWS.iter().map(|row| row.name).collect();
    assert_eq!(names.len(), parameter::ROWS.len());
    // Of parameters that went, used by none.
    const GONE: [i32; 1] = [53];
    let numbers = (1..).filter(|number| !GONE.contains(number));
    for (number, row) in numbers.zip(parameter::ROWS) {
        assert_eq!(row.number, number, "{}", row.constant);
    }
}

#[test]
fn phases_are_numbered_in_their_order() {
    for (phase, (name, number)) in Phase::ALL.into_iter().zip(PHASES) {
        assert_eq!(phase as i32, number, "{name}");
    }
}
