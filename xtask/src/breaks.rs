//! Breaks the drive's code in one place after the other, by a list, and demands that the tests notice.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use toml::{Table, Value};

use crate::firmware::{built, root};

/// The list.
const LIST: &str = "crates/drive-logic/breaks.toml";

/// One change of the code that a test must notice.
#[derive(Debug, Clone, PartialEq)]
struct Break {
    name: String,
    file: String,
    code: String,
    broken: String,
    /// The test target, and the beginning of the name of a test.
    test: String,
}

/// Makes every break of the list, or those that time allows, beginning with another one in every commit.
///
/// # Errors
/// A break that no test notices, or that is not of this code.
pub(crate) fn check(limit: Option<Duration>) -> Result<(), String> {
    let breaks = listed()?;
    for broken in &breaks {
        broken.applied(root())?;
    }
    let copy = copied()?;
    let first = if limit.is_some() {
        of_commit()? % breaks.len()
    } else {
        0
    };
    let begun = Instant::now();
    let (mut done, mut missed) = (0, Vec::new());
    for broken in breaks.iter().cycle().skip(first).take(breaks.len()) {
        if limit.is_some_and(|limit| begun.elapsed() > limit) {
            break;
        }
        let is_noticed = broken.is_noticed(&copy)?;
        println!(
            "{} {}",
            if is_noticed { "noticed" } else { "MISSED " },
            broken.name
        );
        done += 1;
        if !is_noticed {
            missed.push(broken.name.as_str());
        }
    }
    println!(
        "{done} of {} breaks made, {} missed",
        breaks.len(),
        missed.len()
    );
    if missed.is_empty() {
        Ok(())
    } else {
        Err(format!("no test notices: {}", missed.join("; ")))
    }
}

/// The breaks of the list.
fn listed() -> Result<Vec<Break>, String> {
    let text = read(&root().join(LIST))?;
    let table: Table = text.parse().map_err(|error| format!("{LIST}: {error}"))?;
    let entries = table.get("break").and_then(Value::as_array);
    let entries = entries.ok_or_else(|| format!("{LIST} lists no break"))?;
    entries
        .iter()
        .map(|entry| {
            let of = |key: &str| {
                let value = entry.get(key).and_then(Value::as_str);
                value
                    .map(|value| value.trim_matches('\n').to_owned())
                    .ok_or_else(|| format!("{LIST}: a break has no {key}"))
            };
            Ok(Break {
                name: of("name")?,
                file: of("file")?,
                code: of("code")?,
                broken: of("broken")?,
                test: of("test")?,
            })
        })
        .collect()
}

impl Break {
    /// The text of its file with the break.
    fn applied(&self, tree: &Path) -> Result<String, String> {
        let Self {
            name,
            file,
            code,
            broken,
            ..
        } = self;
        let text = read(&tree.join(file))?;
        match text.matches(code.as_str()).count() {
            1 => Ok(text.replacen(code.as_str(), broken, 1)),
            found => Err(format!(
                "{LIST}: the code of \"{name}\" is in {file} {found} times, and has to be there once: change the list \
                 with the code"
            )),
        }
    }

    /// True if its test fails with it, having passed without it.
    fn is_noticed(&self, tree: &Path) -> Result<bool, String> {
        let place = tree.join(&self.file);
        let whole = read(&place)?;
        let Self { name, test, .. } = self;
        if !self.passes(tree)? {
            return Err(format!(
                "the test \"{test}\" of \"{name}\" fails without the break"
            ));
        }
        write(&place, &self.applied(tree)?)?;
        let builds = self.cargo(tree, &["--no-run"]);
        let passes = self.passes(tree);
        write(&place, &whole)?;
        if !builds? {
            return Err(format!("\"{name}\" does not compile"));
        }
        passes.map(|passes| !passes)
    }

    /// The crate of its file, which is below `crates`.
    fn package(&self) -> &str {
        self.file.split('/').nth(1).unwrap_or_default()
    }

    fn passes(&self, tree: &Path) -> Result<bool, String> {
        let name = self.test.split_once(' ').map_or("", |(_, name)| name);
        self.cargo(tree, &["--", name])
    }

    /// True if cargo's test of its target succeeds with some arguments.
    fn cargo(&self, tree: &Path, with: &[&str]) -> Result<bool, String> {
        let target = self.test.split(' ').next().unwrap_or_default();
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        Command::new(cargo)
            .current_dir(tree)
            .args([
                "test",
                "--locked",
                "--quiet",
                "-p",
                self.package(),
                "--test",
                target,
            ])
            .args(with)
            // A lint is no test.
            .env("RUSTFLAGS", "--cap-lints=allow")
            .env("CARGO_TARGET_DIR", built().join("breaks").join("target"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .map(|status| status.success())
            .map_err(|error| format!("cargo does not start: {error}"))
    }
}

/// A copy of the project's files beside what is built; files that are as they were keep their time, so that cargo builds
/// them once.
fn copied() -> Result<PathBuf, String> {
    let copy = built().join("breaks").join("tree");
    for file in git(&["ls-files"])?.lines() {
        let (from, to) = (root().join(file), copy.join(file));
        let Ok(bytes) = fs::read(&from) else {
            continue;
        };
        if fs::read(&to).is_ok_and(|before| before == bytes) {
            continue;
        }
        let folder = to.parent().unwrap_or(&copy);
        fs::create_dir_all(folder)
            .and_then(|()| fs::write(&to, bytes))
            .map_err(|error| format!("{}: {error}", to.display()))?;
    }
    Ok(copy)
}

/// A number of the commit.
fn of_commit() -> Result<usize, String> {
    let commit = git(&["rev-parse", "HEAD"])?;
    let beginning = commit.get(..7).unwrap_or_default();
    usize::from_str_radix(beginning, 16).map_err(|error| format!("{commit}: {error}"))
}

fn git(arguments: &[&str]) -> Result<String, String> {
    let output = Command::new("git")
        .current_dir(root())
        .args(arguments)
        .output()
        .map_err(|error| format!("git does not start: {error}"))?;
    String::from_utf8(output.stdout).map_err(|error| error.to_string())
}

fn read(file: &Path) -> Result<String, String> {
    fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))
}

fn write(file: &Path, text: &str) -> Result<(), String> {
    fs::write(file, text).map_err(|error| format!("{}: {error}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_break_of_the_list_is_of_the_code_and_of_a_test() {
        for broken in listed().expect("readable") {
            let name = &broken.name;
            let text = broken.applied(root()).expect("in step with the code");
            assert_ne!(
                text,
                read(&root().join(&broken.file)).expect("readable"),
                "{name}"
            );
            let (target, test) = broken.test.split_once(' ').expect("target and test");
            let tests = root().join("crates").join(broken.package()).join("tests");
            let places = [tests.join(target).with_extension("rs"), tests.join(target)];
            let place = places
                .iter()
                .find(|place| place.exists())
                .expect("a target");
            let (folder, test) = test.split_once("::").unwrap_or(("", test));
            // A folder of tests may have modules of a shared one.
            let files = if folder.is_empty() {
                vec![place.clone()]
            } else {
                let module = |tests: &Path| tests.join(folder).with_extension("rs");
                vec![module(place), module(&tests.join("shared"))]
            };
            let file = files.iter().find(|file| file.exists()).expect("a module");
            let has_it = read(file).expect("readable").lines().any(|line| {
                line.trim_start()
                    .strip_prefix("fn ")
                    .is_some_and(|line| line.contains(test))
            });
            assert!(has_it, "{name}: {test} is not in {}", file.display());
        }
    }
}
