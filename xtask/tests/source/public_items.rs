//! The names that a user of the core and of commissioning sees, with all their features: the reviewed lists are
//! `public-items.txt` in the folder of each. Every new name is one more to learn.
//!
//! `PUBLIC_ITEMS=write` writes the lists anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use syn::{Item, Visibility};

use super::rust::{code, leaves};

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
    let text = fs::read_to_string(root.join("src/lib.rs")).expect("readable");
    add(&text, &root.join("src"), "", &mut items);
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

/// Adds the public items of a text whose submodules are in a folder.
fn add(text: &str, folder: &Path, module: &str, found: &mut BTreeSet<String>) {
    let file: syn::File = syn::parse2(code(text)).expect("items");
    add_items(&file.items, folder, module, found);
}

fn add_items(items: &[Item], folder: &Path, module: &str, found: &mut BTreeSet<String>) {
    for item in items {
        let (visibility, name) = match item {
            Item::Const(item) => (&item.vis, &item.ident),
            Item::Enum(item) => (&item.vis, &item.ident),
            Item::Fn(item) => (&item.vis, &item.sig.ident),
            Item::Mod(item) => (&item.vis, &item.ident),
            Item::Static(item) => (&item.vis, &item.ident),
            Item::Struct(item) => (&item.vis, &item.ident),
            Item::Trait(item) => (&item.vis, &item.ident),
            Item::Type(item) => (&item.vis, &item.ident),
            Item::Use(item) if matches!(item.vis, Visibility::Public(_)) => {
                let names = leaves(&[], &item.tree)
                    .into_iter()
                    .filter_map(|mut path| path.pop());
                found.extend(names.map(|name| format!("{module}{name}")));
                continue;
            }
            _ => continue,
        };
        if !matches!(visibility, Visibility::Public(_)) {
            continue;
        }
        let path = format!("{module}{name}");
        let Item::Mod(inner) = item else {
            found.insert(path);
            continue;
        };
        let (path, folder) = (format!("{path}::"), folder.join(name.to_string()));
        match &inner.content {
            Some((_, items)) => add_items(items, &folder, &path, found),
            None => add(&source(&folder), &folder, &path, found),
        }
    }
}

/// The text of a module whose submodules are in a folder.
fn source(folder: &Path) -> String {
    let [file, root] = [folder.with_extension("rs"), folder.join("mod.rs")];
    let text = fs::read_to_string(file).or_else(|_| fs::read_to_string(root));
    text.expect("readable")
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
    add(text, Path::new(""), "", &mut items);
    let expected = ["A", "B", "C", "E", "F", "H", "I", "K", "M", "g", "n::O"];
    assert!(items.iter().eq(expected), "{items:?}");
}
