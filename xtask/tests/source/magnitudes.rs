//! The magnitudes that core and commissioning are built on: float literals in their code other than 0, ½, 1 and 2. Each is a
//! figure that somebody chose and that a reader has to trust. Integers, tests and comments do not count.

use std::path::Path;

use proc_macro2::{Literal, TokenStream, TokenTree};
use syn::Lit;

use super::modules::Sources;

/// The folders that are counted together.
const COUNTED: [&str; 2] = ["identifier-core/src", "crates/commissioning/src"];

/// The most literals. It falls with every figure that another one implies or that is stated once; 300 is the aim.
const MOST: usize = 502;

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

/// The float literals of a code that are not plain values.
fn magnitudes(code: &TokenStream) -> Vec<f64> {
    let mut found = Vec::new();
    let mut is_field = false;
    for token in code.clone() {
        match &token {
            TokenTree::Group(group) => found.extend(magnitudes(&group.stream())),
            // In `x.0.1` the two fields look like a float.
            TokenTree::Literal(literal) if !is_field => found.extend(float(literal)),
            _ => {}
        }
        is_field = matches!(&token, TokenTree::Punct(mark) if mark.as_char() == '.' && !is_field);
    }
    found.retain(|value| !PLAIN.contains(value));
    found
}

/// The value of a literal, if it is a float: it has a point, an exponent or the type.
fn float(literal: &Literal) -> Option<f64> {
    match Lit::new(literal.clone()) {
        Lit::Float(value) => value.base10_parse().ok(),
        Lit::Int(value) if value.suffix().starts_with('f') => value.base10_parse().ok(),
        _ => None,
    }
}

#[test]
fn every_form_of_a_float_is_found_and_no_integer() {
    let code = "const A: [f64; 3] = [0.5, 1.0, 3.0]; x.0.max(1e-3) + 4. * b.1 as f64 + 7_f64 + 12u8 + 0x1f32
        + (3.5..=4.5).len() + 5.max(6) + 1_000.25e+2_f32 + a[9] + 2.0 + id2.3 + 0e0;";
    let code = code.parse().expect("Rust");
    assert_eq!(
        magnitudes(&code),
        [3.0, 1e-3, 4.0, 7.0, 3.5, 4.5, 100_025.0]
    );
}
