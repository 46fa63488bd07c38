//! The magnitudes that core and commissioning are built on: float literals in their code other than 0, ½, 1 and 2. Each is a
//! figure that somebody chose and that a reader has to trust. Integers, tests and comments do not count.

use std::path::Path;

use super::modules::Sources;

/// The folders that are counted together.
const COUNTED: [&str; 2] = ["identifier-core/src", "crates/commissioning/src"];

/// The most literals. It falls with every figure that another one implies or that is stated once; 300 is the aim.
const MOST: usize = 474;

/// Values that need no source.
const PLAIN: [f64; 4] = [0.0, 0.5, 1.0, 2.0];

#[test]
fn core_and_commissioning_have_no_more_float_literals_than_accepted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut all = 0;
    for folder in COUNTED {
        let sources = Sources::read(&root.join(folder));
        let count: usize = (sources.code()).map(|code| magnitudes(code).len()).sum();
        assert!(count > 100, "{folder}: only {count} were found");
        println!("{folder}: {count} float literals");
        all += count;
    }
    assert!(all <= MOST, "{all} float literals, {MOST} are accepted");
}

/// The float literals of a code without comments that are not plain values.
fn magnitudes(code: &str) -> Vec<f64> {
    let numbers = code.char_indices().filter(|&(at, character)| {
        let before = code[..at].chars().next_back();
        let continues = |before: char| before.is_alphanumeric() || "_.".contains(before);
        // `0..3.0` begins a number behind two points.
        let in_range = code[..at].ends_with("..");
        character.is_ascii_digit() && (in_range || !before.is_some_and(continues))
    });
    let floats = numbers.filter_map(|(at, _)| float(&code[at..]));
    floats.filter(|value| !PLAIN.contains(value)).collect()
}

/// The value of a number that begins here, if it is a float: it has a point, an exponent or the type.
fn float(text: &str) -> Option<f64> {
    let digits = |text: &str| {
        let is_digit = |one: char| one.is_ascii_digit() || one == '_';
        text.find(|one| !is_digit(one)).unwrap_or(text.len())
    };
    let mut end = digits(text);
    let follows = |end: usize| text[end..].chars().nth(1);
    let mut is_float = false;
    if text[end..].starts_with('.')
        && !follows(end).is_some_and(|next| next.is_alphabetic() || next == '.' || next == '_')
    {
        is_float = true;
        end += 1 + digits(&text[end + 1..]);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(follows(end).is_some_and(|next| "+-".contains(next)));
        let exponent = digits(&text[end + 1 + sign..]);
        if exponent > 0 {
            is_float = true;
            end += 1 + sign + exponent;
        }
    }
    let rest = text[end..].trim_start_matches('_');
    is_float |= rest.starts_with("f32") || rest.starts_with("f64");
    is_float.then(|| text[..end].replace('_', "").parse().expect("a number"))
}

#[test]
fn every_form_of_a_float_is_found_and_no_integer() {
    let code = "const A: [f64; 3] = [0.5, 1.0, 3.0]; x.0.max(1e-3) + 4. * b.1 as f64 + 7_f64 + 12u8 + 0x1f32
        + (3.5..=4.5).len() + 5.max(6) + 1_000.25e+2_f32 + a[9] + 2.0 + id2.3 + 0e0;";
    assert_eq!(magnitudes(code), [3.0, 1e-3, 4.0, 7.0, 3.5, 4.5, 100_025.0]);
}
