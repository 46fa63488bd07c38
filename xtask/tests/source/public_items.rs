//! The names that a user of the core sees, with all its features: the reviewed list is
//! `identifier-core/public-items.txt`. Every new name is one more to learn.
//!
//! `PUBLIC_ITEMS=write` writes the list anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::rust::{code, imports, without_tests};

#[test]
fn the_public_items_of_the_core_are_those_of_the_list() {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../identifier-core");
    let mut items = BTreeSet::new();
    add(&core.join("src/lib.rs"), &core.join("src"), "", &mut items);
    assert!(items.len() > 50, "only {} items were found", items.len());
    let found: String = items.iter().map(|item| format!("{item}\n")).collect();
    let list = core.join("public-items.txt");
    if std::env::var_os("PUBLIC_ITEMS").is_some_and(|order| order == "write") {
        fs::write(&list, &found).expect("writable");
    }
    let listed = fs::read_to_string(&list).expect("the list");
    let listed: BTreeSet<&str> = listed.lines().collect();
    let found: BTreeSet<&str> = found.lines().collect();
    let more: Vec<_> = found.difference(&listed).collect();
    let fewer: Vec<_> = listed.difference(&found).collect();
    assert!(
        more.is_empty() && fewer.is_empty(),
        "public and not listed: {more:?}; listed and not public: {fewer:?}"
    );
}

/// Adds the public items of a file whose submodules are in a folder.
fn add(file: &Path, folder: &Path, module: &str, items: &mut BTreeSet<String>) {
    let text = fs::read_to_string(file).expect("readable");
    add_text(&without_tests(&code(&text)), folder, module, items);
}

/// Adds the public items of a module's text.
fn add_text(text: &str, folder: &Path, module: &str, items: &mut BTreeSet<String>) {
    let mut rest = text;
    while let Some(item) = next_public(&mut rest) {
        let words: Vec<&str> = item
            .split(|character: char| !(character.is_alphanumeric() || character == '_'))
            .filter(|word| !word.is_empty())
            .collect();
        // `const fn` is a function.
        let Some((&kind, &name)) = words
            .iter()
            .zip(&words[1..])
            .find(|(kind, name)| KINDS.contains(kind) && !KINDS.contains(name))
        else {
            continue;
        };
        match kind {
            "use" => {
                for path in imports(item) {
                    let name = path.last().expect("a name");
                    items.insert(format!("{module}{name}"));
                }
            }
            "mod" => {
                let path = format!("{module}{name}::");
                match item.split_once('{') {
                    Some((_, inside)) => add_text(inside, folder, &path, items),
                    None => add(&source(folder, name), &folder.join(name), &path, items),
                }
            }
            _ => {
                items.insert(format!("{module}{name}"));
            }
        }
    }
}

/// The words that begin an item.
const KINDS: [&str; 9] = [
    "use", "mod", "fn", "struct", "enum", "trait", "type", "static", "const",
];

/// The next public item outside of braces, up to its `;` or the end of its body.
fn next_public<'a>(rest: &mut &'a str) -> Option<&'a str> {
    let text = *rest;
    let (mut depth, mut begins, mut public) = (0, true, None);
    for (at, character) in text.char_indices() {
        if depth == 0 && begins && public.is_none() && text[at..].starts_with("pub ") {
            public = Some(at + "pub ".len());
        }
        match character {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        let ends = depth == 0 && matches!(character, ';' | '}');
        if let Some(begin) = public
            && (depth < 0 || character == ';' && depth == 0 || ends && body(&text[begin..=at]))
        {
            *rest = &text[at + 1..];
            return Some(&text[begin..=at]);
        }
        begins = ends || character == ']' || begins && character.is_whitespace();
    }
    None
}

/// An item with a body ends with its brace; a list of imports ends with its semicolon.
fn body(item: &str) -> bool {
    !item.starts_with("use ")
}

/// The file of a module.
fn source(folder: &Path, module: &str) -> PathBuf {
    let file = folder.join(format!("{module}.rs"));
    if file.exists() {
        file
    } else {
        folder.join(module).join("mod.rs")
    }
}

#[test]
fn every_form_of_an_item_is_found() {
    let mut items = BTreeSet::new();
    let text = "
        mod hidden;
        pub(crate) fn hidden() {}
        pub use hidden::{A, deep::{B, C as D}};
        #[derive(Debug)]
        pub struct E<const N: usize> { pub field: [u8; 4] }
        pub struct F(u8);
        impl E { pub fn method() {} }
        pub const fn g() -> u8 { if true { 1 } else { 2 } }
        pub const H: [u8; 2] = [1, 2];
        pub enum I { J }
        pub trait K { fn l(); }
        pub type M = u8;
        pub mod n { pub use crate::hidden::O; fn hidden() {} }
    ";
    add_text(text, Path::new(""), "", &mut items);
    let expected = ["A", "B", "C", "E", "F", "H", "I", "K", "M", "g", "n::O"];
    assert!(items.iter().eq(expected), "{items:?}");
}
