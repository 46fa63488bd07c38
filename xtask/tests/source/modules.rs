//! The modules of every crate are a tree, and so are its files: none depends on one that depends on it. A module depends
//! on the modules that it names by `use`, or in a path from `crate` or `super`; its tests do not count. A file depends on
//! those that define what it names: a name that a module passes on is that of its own file.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::TokenStream;

use super::rust::{How, Named, code, named};

#[test]
fn the_modules_of_every_crate_are_a_tree() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = 0;
    let mut cycles = Vec::new();
    for member in members(&root) {
        let sources = Sources::read(&root.join(&member).join("src"));
        files += sources.0.len();
        for graph in [sources.graph(), sources.files()] {
            for cycle in cycles_of(&graph) {
                cycles.push(format!("{member}: {cycle}"));
            }
        }
    }
    assert!(files > 500, "only {files} files were found");
    assert!(cycles.is_empty(), "in a circle:\n{}", cycles.join("\n"));
}

/// The folders of the workspace's crates, and the firmware, which is one of its own.
fn members(root: &Path) -> Vec<String> {
    let manifest = fs::read_to_string(root.join("Cargo.toml")).expect("readable");
    let list = manifest.split("members = [").nth(1).expect("members");
    let list = list.split(']').next().expect("closed");
    let quoted = list.split('"').skip(1).step_by(2);
    let all = quoted.chain(["firmware-stm32"]);
    all.map(str::to_owned).collect()
}

/// The sources of a crate by module: comments and tests are left out.
#[derive(Debug, Default)]
pub(crate) struct Sources(Vec<Source>);

#[derive(Debug)]
struct Source {
    module: Vec<String>,
    code: TokenStream,
    named: Vec<Named>,
}

/// For each module those it depends on.
type Graph = BTreeMap<String, BTreeSet<String>>;

impl Sources {
    pub(crate) fn read(folder: &Path) -> Self {
        let mut sources = Self::default();
        let mut folders = vec![folder.to_owned()];
        while let Some(next) = folders.pop() {
            let entries = fs::read_dir(&next).expect("a folder");
            for path in entries.map(|entry| entry.expect("an entry").path()) {
                if path.is_dir() {
                    // Each program of `bin` is a crate of its own, and tests do not count.
                    if !path.ends_with("src/bin") && !path.ends_with("tests") {
                        folders.push(path);
                    }
                } else if path.extension().is_some_and(|extension| extension == "rs") {
                    let text = fs::read_to_string(&path).expect("readable");
                    sources.add(module(folder, &path), &text);
                }
            }
        }
        sources
    }

    /// The code of every module that is none of tests.
    pub(crate) fn code(&self) -> impl Iterator<Item = &TokenStream> {
        let sources = self.0.iter();
        let is_test = |source: &&Source| source.module.last().is_some_and(|name| name == "tests");
        let own = sources.filter(move |source| !is_test(source));
        own.map(|source| &source.code)
    }

    fn add(&mut self, module: Vec<String>, text: &str) {
        let code = code(text);
        self.0.push(Source {
            named: named(&module, code.clone()),
            module,
            code,
        });
    }

    /// The dependencies between the modules at the root.
    fn graph(&self) -> Graph {
        let mut graph = Graph::new();
        for name in self.0.iter().filter_map(|source| source.module.first()) {
            graph.entry(name.clone()).or_default();
        }
        let reexported = self.reexports(&graph);
        for source in &self.0 {
            let Some(own) = source.module.first() else {
                continue;
            };
            for path in source.named.iter().filter_map(absolute) {
                let Some(name) = path.first() else {
                    continue;
                };
                let other = if graph.contains_key(name) {
                    Some(name)
                } else {
                    reexported.get(name)
                };
                if let Some(other) = other.filter(|&other| other != own).cloned() {
                    graph.entry(own.clone()).or_default().insert(other);
                }
            }
        }
        graph
    }

    /// The dependencies between the files.
    fn files(&self) -> Graph {
        let name = |module: &[String]| match module {
            [] => "the root".to_owned(),
            _ => module.join("/"),
        };
        let mut graph = Graph::new();
        for Source { module, named, .. } in &self.0 {
            let imports = named.iter().filter(|named| named.how == How::Imported);
            let mut paths: Vec<_> = imports.filter_map(|named| self.own(named)).collect();
            let inline = named.iter().filter(|named| named.how == How::Inline);
            for named in inline {
                // What is named in an imported module.
                let first = named.path.first();
                let through = paths.iter().find(|import| import.last() == first);
                let through = through.map(|import| [import, &named.path[1..]].concat());
                paths.extend(through.or_else(|| absolute(named)));
            }
            let others = paths.iter().filter_map(|path| self.file_of(path, 0));
            let others = others.filter(|other| other != module);
            graph.insert(name(module), others.map(|other| name(&other)).collect());
        }
        graph
    }

    fn has(&self, module: &[String]) -> bool {
        self.source(module).is_some()
    }

    fn source(&self, module: &[String]) -> Option<&Source> {
        self.0.iter().find(|source| source.module == module)
    }

    /// A path from the root, also of one that begins at a module of the module.
    fn own(&self, named: &Named) -> Option<Vec<String>> {
        let below = [&named.module[..], &named.path].concat();
        absolute(named).or_else(|| self.has(&below[..=named.module.len()]).then_some(below))
    }

    /// The file that defines what a path from the root names.
    fn file_of(&self, path: &[String], passed: usize) -> Option<Vec<String>> {
        let deepest = (0..=path.len()).rev().find(|&end| self.has(&path[..end]))?;
        let (module, item) = path.split_at(deepest);
        let name = item.first()?;
        let named = &self.source(module)?.named;
        let passed_on = named.iter().filter(|named| named.how == How::PassedOn);
        let further = passed_on
            .filter_map(|named| self.own(named))
            .find(|path| path.last() == Some(name));
        match further {
            Some(further) if passed < 8 => {
                self.file_of(&[&further[..], &item[1..]].concat(), passed + 1)
            }
            _ => Some(module.to_vec()),
        }
    }

    /// The names that the root passes on, with the module that each is from.
    fn reexports(&self, modules: &Graph) -> BTreeMap<String, String> {
        let named = self.source(&[]).map_or(&[][..], |root| &root.named);
        let imports = named.iter().filter(|named| named.how != How::Inline);
        let paths = imports.map(|named| absolute(named).unwrap_or(named.path.clone()));
        let from_a_module = paths.filter(|path| modules.contains_key(&path[0]));
        from_a_module
            .filter_map(|path| Some((path.last()?.clone(), path[0].clone())))
            .collect()
    }
}

/// The module that a file is.
fn module(folder: &Path, file: &Path) -> Vec<String> {
    let inside: PathBuf = file
        .strip_prefix(folder)
        .expect("inside")
        .with_extension("");
    let mut module: Vec<String> = inside
        .iter()
        .map(|part| part.to_str().expect("a name").to_owned())
        .collect();
    if matches!(
        module.last().map(String::as_str),
        Some("mod" | "lib" | "main")
    ) {
        module.pop();
    }
    module
}

/// A path from the root of the crate; none if it leads out of it, or begins at a name in scope.
fn absolute(Named { module, path, .. }: &Named) -> Option<Vec<String>> {
    let mut absolute = match path.first()?.as_str() {
        "crate" => Vec::new(),
        "self" | "super" => module.clone(),
        _ => return None,
    };
    for name in path {
        match name.as_str() {
            "crate" | "self" => {}
            "super" => {
                absolute.pop()?;
            }
            _ => absolute.push(name.clone()),
        }
    }
    Some(absolute)
}

/// The modules that can reach each other.
fn cycles_of(graph: &Graph) -> Vec<String> {
    let reach = |from: &String| {
        let mut found = BTreeSet::new();
        let mut left: Vec<_> = graph[from].iter().collect();
        while let Some(next) = left.pop() {
            if found.insert(next.clone()) {
                left.extend(&graph[next]);
            }
        }
        found
    };
    let reached: BTreeMap<_, _> = graph.keys().map(|name| (name, reach(name))).collect();
    let mut cycles = BTreeSet::new();
    for (name, others) in &reached {
        if others.contains(*name) {
            let together = others
                .iter()
                .filter(|&other| reached[other].contains(*name));
            let links = together.map(|other| {
                let next = graph[other]
                    .iter()
                    .filter(|&next| reached[next].contains(*name));
                format!("{other} → {}", next.cloned().collect::<Vec<_>>().join(", "))
            });
            cycles.insert(links.collect::<Vec<_>>().join("; "));
        }
    }
    cycles.into_iter().collect()
}

#[test]
fn two_files_of_a_module_that_name_each_other_are_a_circle() {
    let cycles = |back: &str| {
        let mut sources = Sources::default();
        let path = |path: &[&str]| path.iter().map(|&name| name.to_owned()).collect();
        sources.add(vec![], "mod a;");
        sources.add(path(&["a"]), "mod b; mod c; pub use b::B; pub use c::C;");
        sources.add(path(&["a", "b"]), "use super::C; pub struct B;");
        sources.add(path(&["a", "c"]), back);
        cycles_of(&sources.files())
    };
    assert_eq!(cycles("pub struct C;"), [""; 0]);
    assert_eq!(
        cycles("#[cfg(test)] mod tests { use super::super::B; }"),
        [""; 0]
    );
    for back in [
        "use super::B;",
        "use crate::a::B;",
        "fn f() -> super::b::B { todo() }",
        "use super::b; fn f() -> b::B {}",
    ] {
        assert_eq!(cycles(back), ["a/b → a/c; a/c → a/b"], "{back}");
    }
}

#[test]
fn a_circle_is_found_however_it_is_written() {
    let cycles = |links: [&str; 3]| {
        let mut sources = Sources::default();
        sources.add(
            vec![],
            "pub mod a; mod b; mod c; pub use a::{Thing, Other};",
        );
        for (module, text) in ["a", "b", "c"].into_iter().zip(links) {
            sources.add(vec![module.to_owned()], text);
        }
        cycles_of(&sources.graph())
    };
    let tree = ["use crate::b::X;", "use crate::c::{Y, Z as W};", ""];
    assert_eq!(cycles(tree), [""; 0]);
    for back in [
        "use crate::a::X;",
        "use crate::{c, a::{self, X}};",
        "use super::a::X;",
        "fn f() -> crate::a::X { todo() }",
        "fn f(x: &super::a::X) {}",
        "use crate::Thing;",
        "pub use crate::{Other};",
        "#[cfg(feature = \"x\")]\nuse crate::a::X;",
        "#[cfg(test)]\nmod tests { use super::*; }\nuse crate::a::X;",
        "const QUOTE: char = '\"'; use crate::a::X; const END: char = '\"';",
    ] {
        let found = cycles([tree[0], tree[1], back]);
        assert_eq!(found, ["a → b; b → c; c → a"], "{back}");
    }
    for none in [
        "// use crate::a::X;",
        "/* crate::a::X */",
        "const TEXT: &str = \"crate::a::X\";",
        "const TEXT: &str = r#\"use crate::a::\"X\";\"#;",
        "#[cfg(test)]\nmod tests { use crate::a::X; fn f() { if true {} } }",
        "use crate::c::X;",
        "use other::a::X;",
        "fn f<'a>(x: &'a X) {}",
    ] {
        assert_eq!(cycles([tree[0], tree[1], none]), [""; 0], "{none}");
    }
}
