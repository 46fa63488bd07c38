//! The variants of commissioning's enums: each is a case that a reader keeps in mind.

use std::path::Path;

use proc_macro2::TokenStream;
use syn::ItemEnum;
use syn::visit::Visit;

use super::modules::Sources;

/// The most variants. It falls with every case that is none; 50 is the aim.
const MOST: usize = 80;

#[test]
fn commissioning_has_no_more_variants_than_accepted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let sources = Sources::read(&root.join("crates/commissioning/src"));
    let enums: Vec<_> = sources.code().flat_map(Enums::of).collect();
    for (name, variants) in &enums {
        println!("{name}: {variants}");
    }
    let all: usize = enums.iter().map(|(_, variants)| variants).sum();
    println!("{all} variants of {} enums", enums.len());
    assert!(enums.len() > 10, "only {} enums were found", enums.len());
    assert!(all <= MOST, "{all} variants, {MOST} are accepted");
}

/// Enums with the number of their variants.
#[derive(Default)]
struct Enums(Vec<(String, usize)>);

impl Enums {
    fn of(code: &TokenStream) -> Vec<(String, usize)> {
        let mut enums = Self::default();
        enums.visit_file(&syn::parse2(code.clone()).expect("items"));
        enums.0
    }
}

impl Visit<'_> for Enums {
    fn visit_item_enum(&mut self, item: &ItemEnum) {
        self.0.push((item.ident.to_string(), item.variants.len()));
    }
}

#[test]
fn variants_of_every_form_are_counted() {
    let code = "#[derive(A, B)] pub(super) enum One<N> { #[default] Plain, Tuple(A, [B; 2]), Named { a: A, b: B }, }
        enum Two { Only } struct Three { a: A, b: B } macro_rules! my_enum { () => {} }";
    let enums = Enums::of(&code.parse().expect("Rust"));
    assert_eq!(enums, [("One".to_owned(), 3), ("Two".to_owned(), 1)]);
}
