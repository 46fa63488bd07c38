//! The modules of every crate are a tree, and so are its files: none depends on one that depends on it. A module depends
//! on the modules that it names by `use`, or in a path from `crate` or `super`; its tests do not count. A file depends on
//! those that define what it names: a name that a module passes on is that of its own file.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::rust::{code, imports, matching, uses, without_tests};

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

/// The sources of a crate by module: comments, literals and tests are left out.
#[derive(Debug, Default)]
pub(crate) struct Sources(Vec<(Vec<String>, String)>);

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
    pub(crate) fn code(&self) -> impl Iterator<Item = &str> {
        let modules = self.0.iter();
        let own = modules.filter(|(module, _)| module.last().is_none_or(|name| name != "tests"));
        own.map(|(_, text)| text.as_str())
    }

    fn add(&mut self, module: Vec<String>, text: &str) {
        self.0.push((module, without_tests(&code(text))));
    }

    /// The dependencies between the modules at the root.
    fn graph(&self) -> Graph {
        let mut graph = Graph::new();
        for (module, _) in &self.0 {
            if let Some(name) = module.first() {
                graph.entry(name.clone()).or_default();
            }
        }
        let reexported = self.reexports(&graph);
        for (module, text) in &self.0 {
            let Some(own) = module.first() else {
                continue;
            };
            for path in references(module, text) {
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
        let mut graph = Graph::new();
        for (module, text) in &self.0 {
            let text = &without_inline_modules(text);
            let mut paths: Vec<_> = inline(text)
                .iter()
                .filter_map(|path| absolute(module, path))
                .collect();
            for (passes_on, path) in uses(text) {
                let Some(path) = self.own(module, &path).filter(|_| !passes_on) else {
                    continue;
                };
                if self.has(&path)
                    && let Some(name) = path.last()
                {
                    // A module: what is named in it.
                    for (at, _) in text.match_indices(&format!("{name}::")) {
                        let rest = &text[at + name.len() + 2..];
                        let item = rest.split(|next: char| !next.is_alphanumeric() && next != '_');
                        paths.extend(
                            item.take(1)
                                .map(|item| [&path[..], &[item.to_owned()]].concat()),
                        );
                    }
                }
                paths.push(path);
            }
            let others = paths.iter().filter_map(|path| self.file_of(path, 0));
            let others = others.filter(|other| other != module);
            let name = |module: &[String]| match module {
                [] => "the root".to_owned(),
                _ => module.join("/"),
            };
            let others = others.map(|other| name(&other)).collect();
            graph.insert(name(module), others);
        }
        graph
    }

    fn has(&self, module: &[String]) -> bool {
        self.0.iter().any(|(own, _)| own == module)
    }

    /// A path from the root, also of one that begins at a module of the module.
    fn own(&self, module: &[String], path: &[String]) -> Option<Vec<String>> {
        let below = [module, &path[..1]].concat();
        absolute(module, path).or_else(|| self.has(&below).then(|| [module, path].concat()))
    }

    /// The file that defines what a path from the root names.
    fn file_of(&self, path: &[String], passed: usize) -> Option<Vec<String>> {
        let deepest = (0..=path.len()).rev().find(|&end| self.has(&path[..end]))?;
        let (module, item) = path.split_at(deepest);
        let name = item.first()?;
        let (_, text) = self.0.iter().find(|(own, _)| own == module)?;
        let further = uses(text)
            .into_iter()
            .filter(|(passes_on, _)| *passes_on)
            .filter_map(|(_, path)| self.own(module, &path))
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
        let mut names = BTreeMap::new();
        for (_, text) in self.0.iter().filter(|(module, _)| module.is_empty()) {
            for path in imports(text) {
                let path = absolute(&[], &path).unwrap_or(path);
                if let (Some(from), Some(name)) = (path.first(), path.last())
                    && modules.contains_key(from)
                {
                    names.insert(name.clone(), from.clone());
                }
            }
        }
        names
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

/// Every path of a module's code, from the root of the crate.
fn references(module: &[String], code: &str) -> Vec<Vec<String>> {
    let paths = imports(code).into_iter().chain(inline(code));
    paths.filter_map(|path| absolute(module, &path)).collect()
}

/// A path from the root of the crate; none if it leads out of it, or begins at a name in scope.
fn absolute(module: &[String], path: &[String]) -> Option<Vec<String>> {
    let first = path.first()?;
    let mut absolute = match first.as_str() {
        "crate" => Vec::new(),
        "self" | "super" => module.to_vec(),
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

/// The code without modules that are written in it, whose `super` is the file itself.
fn without_inline_modules(code: &str) -> String {
    let mut kept = String::new();
    let mut rest = code;
    while let Some(at) = rest.find("mod ") {
        let end = rest[at..]
            .find(['{', ';'])
            .map_or(rest.len(), |end| at + end);
        let is_inline = rest[end..].starts_with('{');
        kept.push_str(&rest[..end]);
        let past = if is_inline { matching(&rest[end..]) } else { 0 };
        rest = &rest[end + past..];
    }
    kept + rest
}

/// The paths that begin with `crate` or `super` anywhere.
fn inline(code: &str) -> Vec<Vec<String>> {
    let name = |character: char| character.is_alphanumeric() || character == '_';
    let mut paths = Vec::new();
    for begin in ["crate::", "super::"] {
        for (at, _) in code.match_indices(begin) {
            let before = code[..at].chars().next_back();
            // A second `super` belongs to the path that the first began.
            if before.is_some_and(|before| name(before) || before == ':' || before == '$') {
                continue;
            }
            let text = &code[at..];
            let end = text.find(|character| !name(character) && character != ':');
            let names = text[..end.unwrap_or(text.len())].split("::");
            let names = names.filter(|name| !name.is_empty());
            paths.push(names.map(str::to_owned).collect());
        }
    }
    paths
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
