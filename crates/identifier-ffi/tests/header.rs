//! The header has what the library has: functions with their arguments, numbers, sizes and places.

use commissioning::Phase;
use identifier_ffi::commission::CONDITIONS;
use identifier_ffi::judge::STATES;
use identifier_ffi::object::Object;
use identifier_ffi::settings::NAMES;
use identifier_ffi::status::ALLOWED;
use identifier_ffi::tuner::CAPS;
use identifier_ffi::{Prototype, status};
use std::collections::BTreeSet;

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
        "c_char" => "char".to_owned(),
        "Each<f64>" => "servo_id_parameters".to_owned(),
        "Each<Range>" => "servo_id_bounds".to_owned(),
        "Each<i32>" => "servo_id_choice".to_owned(),
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
    let phases = Phase::ALL.map(|phase| {
        let name = phase.name().replace('-', "_").to_uppercase();
        (format!("PHASE_{name}"), phase as i32)
    });
    let listed = [ALLOWED, STATES, CAPS, &places, CONDITIONS]
        .into_iter()
        .flatten()
        .copied();
    let in_library: BTreeSet<(String, i32)> = own
        .chain(listed)
        .map(|(name, number)| (name.to_owned(), number))
        .chain(phases)
        .collect();
    let in_header: BTreeSet<(String, i32)> = HEADER
        .lines()
        .filter_map(|line| line.strip_prefix("    SERVO_ID_")?.split_once(" = "))
        .filter_map(|(name, rest)| Some((name.to_owned(), rest.split(',').next()?.parse().ok()?)))
        .collect();
    assert_eq!(in_header, in_library);
}

#[test]
fn objects_have_the_same_size() {
    assert_eq!((align_of::<Object<u8>>(), align_of::<u64>()), (8, 8));
    let code = code();
    for (name, words) in identifier_ffi::objects() {
        let declared = format!("SERVO_ID_ALIGNED uint64_t words[{words}]; }} servo_id_{name};");
        assert!(code.contains(&declared), "{declared}");
    }
}

/// The sources with structures that C has too: those of the core are its own.
const SOURCES: [&str; 10] = [
    include_str!("../../../identifier-core/src/control/feed_forward/mod.rs"),
    include_str!("../../../identifier-core/src/parameters/identified_servo.rs"),
    include_str!("../../../identifier-core/src/parameters/per_parameter.rs"),
    include_str!("../../../identifier-core/src/settings/identifier.rs"),
    include_str!("../src/commission.rs"),
    include_str!("../src/identifier.rs"),
    include_str!("../src/judge.rs"),
    include_str!("../src/settings.rs"),
    include_str!("../src/status.rs"),
    include_str!("../src/tuner.rs"),
];

/// A field of Rust as C has it.
fn field(line: &str) -> Option<String> {
    let (name, of) = line
        .trim_start()
        .strip_prefix("pub ")?
        .strip_suffix(',')?
        .split_once(": ")?;
    // The names of the parts, for refusals.
    let (of, _) = of.split_once(" {").unwrap_or((of, ""));
    let mut parts = of.trim_start_matches('[').split([';', ']']);
    let of = in_c(parts.next()?);
    let sizes: String = parts
        .filter_map(|part| part.strip_prefix(' '))
        .map(|size| format!("[{size}]"))
        .collect();
    let between = if of.ends_with('*') { "" } else { " " };
    Some(format!("{of}{between}{name}{sizes};"))
}

/// The structure of C for each type that the one structure of Rust has.
const OF_EACH: [(&str, &str); 3] = [
    ("parameters", "f64"),
    ("bounds", "Range"),
    ("choice", "i32"),
];

/// The fields of the core's predicted response, which C has in a tuning.
fn predicted_response() -> String {
    const SOURCE: &str = include_str!("../../../identifier-core/src/tuning/predicted_response.rs");
    let (_, fields) =
        (SOURCE.split_once("#[repr(C)]\npub struct PredictedResponse {")).expect("it");
    let (fields, _) = fields.split_once("\n}").expect("an end");
    let fields: Vec<_> = fields.lines().filter_map(field).collect();
    let times = "time; double quickest_rise_time; double slowest_rise_time;";
    let fields = fields.join(" ").replace(times, "time[3];");
    fields.replace("gain_margins", "gain_margin")
}

/// The fields are the same in the same order. As they are not padded, so are their places where the size is.
#[test]
fn structures_have_the_same_fields() {
    let code = code();
    let mut found = 0;
    let mut compare = |name: &str, fields: &str| {
        let lines = fields.lines().take_while(|line| line.trim() != "}");
        let fields: Vec<_> = lines.filter_map(field).collect();
        // C has no structure of its own for what is stored in an object.
        if fields.is_empty() || name.contains('<') {
            return;
        }
        let of_core = "servo_id_predicted_response predicted_response;";
        let fields = fields.join(" ").replace(of_core, &predicted_response());
        let declared = format!("typedef struct servo_id_{name} {{ {fields} }} servo_id_{name};");
        assert!(code.contains(&declared), "{declared}");
        found += 1;
    };
    for structure in SOURCES
        .iter()
        .flat_map(|of| of.split("#[repr(C)]\n").skip(1))
        .filter_map(|of| of.trim_start().strip_prefix("pub struct "))
    {
        match structure.split_once(" {\n").expect("fields") {
            ("PerParameter<T>", fields) => OF_EACH
                .iter()
                .for_each(|(name, of)| compare(name, &fields.replace(": T,", &format!(": {of},")))),
            ("FeedForwardSettings", fields) => compare("feed_forward", fields),
            ("IdentifiedServo", fields) => compare(
                "servo",
                &fields.replace("parameters: ServoParameters", "value: [f64; 4]"),
            ),
            ("ParameterRangeSettings", fields) => {
                compare("servo_range", &fields.replace("[f64; 2]", "Range"));
            }
            ("RangeSettings", fields) => compare("signal_ranges", fields),
            (name, fields) => compare(&snake_case(name), fields),
        }
    }
    compare("range", "pub low: f64,\npub high: f64,");
    compare("gains", "pub kp: f64,\npub kd: f64,\npub ki: f64,");
    let of_objects = code.matches("uint64_t words[").count();
    assert_eq!(found, code.matches("typedef struct").count() - of_objects);
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

/// Ends of a range and what is chosen are named by their whole field.
#[test]
fn a_refusal_names_a_field_of_the_header() {
    let whole = ["limit.", "travel.", "known."];
    let is_named = |field: &&String| !whole.iter().any(|of| field.starts_with(of));
    let fields = fields();
    let fields: BTreeSet<&str> = fields.iter().filter(is_named).map(String::as_str).collect();
    assert_eq!(
        NAMES.split_terminator('\0').collect::<BTreeSet<_>>(),
        fields
    );
}
