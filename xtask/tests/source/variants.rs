//! The variants of commissioning's enums: each is a case that a reader keeps in mind.

use std::path::Path;

use super::modules::Sources;
use super::rust::matching;

/// The most variants. It falls with every case that is none; 50 is the aim.
const MOST: usize = 85;

#[test]
fn commissioning_has_no_more_variants_than_accepted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let sources = Sources::read(&root.join("crates/commissioning/src"));
    let enums: Vec<_> = sources.code().flat_map(enums).collect();
    for (name, variants) in &enums {
        println!("{name}: {variants}");
    }
    let all: usize = enums.iter().map(|(_, variants)| variants).sum();
    println!("{all} variants of {} enums", enums.len());
    assert!(enums.len() > 10, "only {} enums were found", enums.len());
    assert!(all <= MOST, "{all} variants, {MOST} are accepted");
}

/// The enums of a code without comments, with the number of their variants.
fn enums(code: &str) -> Vec<(&str, usize)> {
    let begins = code.match_indices("enum ");
    let whole = begins
        .filter(|(at, _)| !code[..*at].ends_with(|one: char| one.is_alphanumeric() || one == '_'));
    let found = whole.filter_map(|(at, word)| {
        let rest = &code[at + word.len()..];
        let body = rest.find('{')?;
        let name = rest[..body]
            .split(|one: char| !one.is_alphanumeric())
            .next()?;
        let inside = &rest[body + 1..body + matching(&rest[body..]) - 1];
        Some((name, variants(inside)))
    });
    found.collect()
}

/// The parts between commas that stand outside of every bracket.
fn variants(inside: &str) -> usize {
    let (mut depth, mut count, mut is_empty) = (0, 0, true);
    for one in inside.chars() {
        depth += i32::from("([{".contains(one)) - i32::from(")]}".contains(one));
        if one == ',' && depth == 0 {
            count += usize::from(!is_empty);
            is_empty = true;
        } else {
            is_empty &= one.is_whitespace();
        }
    }
    count + usize::from(!is_empty)
}

#[test]
fn variants_of_every_form_are_counted() {
    let code = "#[derive(A, B)] pub(super) enum One<N> { #[default] Plain, Tuple(A, [B; 2]), Named { a: A, b: B }, }
        enum Two { Only } struct Three { a: A, b: B } macro_rules! my_enum { () => {} }";
    assert_eq!(enums(code), [("One", 3), ("Two", 1)]);
}
