//! The code lines of every package and of other languages, which `lines.toml` accepts: no blanks, no comments, no tests.
//!
//! Macros, build scripts and examples count; `all` and `tests` are Rust alone. A change that raises a figure does so in the same commit, with its reason.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Folders whose packages are the folders in them.
const GROUPS: [&str; 2] = ["crates", "examples"];

/// Folders without a line of the project's own sources.
const LEFT_OUT: [&str; 4] = ["target", "node_modules", "fuzz", "vendor"];

/// Other languages: their keys, the ends of their files, and what begins a comment.
const OTHERS: [(&str, &[&str], &[&str]); 3] = [
    ("python", &[".py", ".pyi"], &["#"]),
    ("javascript", &[".js"], &["//", "/*", "*"]),
    ("headers", &[".h", ".hpp"], &["//", "/*", "*"]),
];

#[test]
fn no_package_has_more_code_lines_than_accepted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut counted = Counted::default();
    add(&root, Path::new(""), &mut counted);
    let list = fs::read_to_string(root.join("lines.toml")).expect("the list");
    let list: toml::Table = list.parse().expect("a table of figures");
    let mut report = String::new();
    for (package, lines) in &counted.code {
        let accepted = list.get(package).and_then(toml::Value::as_integer);
        if accepted.is_none_or(|accepted| *lines > accepted) {
            writeln!(report, "{package:?} = {lines} # accepted: {accepted:?}").expect("a string");
        }
    }
    let all: i64 = counted.code.values().sum();
    println!(
        "{:#?}\n{:?}\n{all} code lines, {} lines of tests",
        counted.code, counted.others, counted.tests
    );
    let sums = [("all", all), ("tests", counted.tests)];
    let sums: BTreeMap<&str, i64> = sums.into_iter().chain(counted.others).collect();
    for (package, _) in list
        .iter()
        .filter(|(package, _)| !sums.contains_key(&***package))
    {
        assert!(
            counted.code.contains_key(package),
            "lines.toml: there is no package {package}"
        );
    }
    for (name, lines) in sums {
        let accepted = list.get(name).and_then(toml::Value::as_integer);
        if accepted.is_none_or(|accepted| lines > accepted) {
            writeln!(report, "{name} = {lines} # accepted: {accepted:?}").expect("a string");
        }
    }
    assert!(
        report.is_empty(),
        "more code lines than lines.toml accepts:\n{report}"
    );
}

/// Lines of code by package, of tests, and of other languages.
#[derive(Default)]
struct Counted {
    code: BTreeMap<String, i64>,
    tests: i64,
    others: BTreeMap<&'static str, i64>,
}

/// Adds the sources in a folder of the project.
fn add(root: &Path, folder: &Path, counted: &mut Counted) {
    for entry in fs::read_dir(root.join(folder)).expect("a folder") {
        let name = entry.expect("an entry").file_name();
        let name = name.to_str().expect("a plain name");
        let path = folder.join(name);
        if root.join(&path).is_dir() {
            if !name.starts_with('.') && !LEFT_OUT.contains(&name) {
                add(root, &path, counted);
            }
        } else if name.ends_with(".rs") {
            let text = fs::read_to_string(root.join(&path)).expect("readable");
            counted.add(&path, &text);
        } else if let Some((language, _, comments)) = OTHERS
            .iter()
            .find(|(_, ends, _)| ends.iter().any(|end| name.ends_with(end)))
            && !is_test(&path)
        {
            let text = fs::read_to_string(root.join(&path)).expect("readable");
            let is_code = |line: &&str| {
                let line = line.trim();
                !line.is_empty() && !comments.iter().any(|begin| line.starts_with(begin))
            };
            *counted.others.entry(language).or_default() +=
                text.lines().filter(is_code).count() as i64;
        }
    }
}

/// True for a file in a folder of tests.
fn is_test(path: &Path) -> bool {
    let mut folders = path.iter().filter_map(|part| part.to_str());
    folders.any(|folder| folder == "tests" || folder == "benches")
}

impl Counted {
    fn add(&mut self, path: &Path, text: &str) {
        let parts: Vec<&str> = path.iter().filter_map(|part| part.to_str()).collect();
        let (Some((&file, folders)), Some(&first)) = (parts.split_last(), parts.first()) else {
            return;
        };
        let lines: Vec<&str> = text.lines().collect();
        if is_test(path) || file == "tests.rs" || file.ends_with("_tests.rs") {
            self.tests += lines.len() as i64;
            return;
        }
        let package = match folders.get(1) {
            Some(second) if GROUPS.contains(&first) => format!("{first}/{second}"),
            _ => first.to_owned(),
        };
        let (code, tests) = count(&lines);
        *self.code.entry(package).or_default() += code;
        self.tests += tests;
    }
}

/// The lines of code of a file, and those of its modules of tests.
fn count(lines: &[&str]) -> (i64, i64) {
    let (mut code, mut tests) = (0, 0);
    let mut in_comment = false;
    let mut rest = lines.iter().peekable();
    while let Some(line) = rest.next() {
        let trimmed = line.trim();
        let module = |next: &&&str| {
            let next = next.trim();
            next.ends_with('{') && next.split_whitespace().any(|word| word == "mod")
        };
        if trimmed == "#[cfg(test)]" && rest.peek().is_some_and(module) {
            let end = format!("{}}}", &line[..line.len() - line.trim_start().len()]);
            tests += 2;
            tests += rest
                .by_ref()
                .take_while(|line| !line.starts_with(&end))
                .count() as i64;
        } else if in_comment || trimmed.starts_with("/*") {
            in_comment = !trimmed.contains("*/");
        } else if !trimmed.is_empty() && !trimmed.starts_with("//") {
            code += 1;
        }
    }
    (code, tests)
}

#[test]
fn blanks_comments_and_tests_are_no_code() {
    let text = "//! Page.\n\nfn f() {\n    /* long\n    comment */\n    g(); // ends\n}\n\n#[cfg(test)]\nmod tests {\n    fn t() {}\n}\n";
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(count(&lines), (3, 4));
}
