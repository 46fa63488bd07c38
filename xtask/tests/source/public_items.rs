//! The names that a user of the core and of commissioning sees, with all their features: the reviewed lists are
//! `public-items.txt` in the folder of each. Every new name is one more to learn.
//!
//! `PUBLIC_ITEMS=write` writes the lists anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::rust::{code, imports, without_tests};

/// The crates with a list, and the least number of names that each certainly has.
const LISTED: [(&str, usize); 2] = [("identifier-core", 50), ("crates/commissioning", 15)];

/// The most names of all of them together.
const MOST: usize = 170;

#[test]
fn the_public_items_are_those_of_the_lists_and_no_more_than_can_be_learnt() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let count = |&(folder, least): &(&str, usize)| checked(&root, folder, least);
    let all: usize = LISTED.iter().map(count).sum();
    println!("{all} public names");
    assert!(
        all <= MOST,
        "{all} public names, of which {MOST} are accepted"
    );
}

/// Compares the public items of the crate in a folder with its list: how many they are.
fn checked(root: &Path, folder: &str, least: usize) -> usize {
    let root = root.join(folder);
    let mut items = BTreeSet::new();
    add(&root.join("src/lib.rs"), &root.join("src"), "", &mut items);
    let count = items.len();
    assert!(count > least, "{folder}: only {count} items were found");
    let found: String = items.iter().map(|item| format!("{item}\n")).collect();
    let list = root.join("public-items.txt");
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
        "{folder}: public and not listed: {more:?}; listed and not public: {fewer:?}"
    );
    count
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
