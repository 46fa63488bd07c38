//! Applies one deliberate break of `mutations.toml` after the other and checks that tests notice it.
//!
//! It takes some minutes, so CI leaves it out.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Deserialize;

use crate::firmware;

/// The list of mutations.
#[derive(Deserialize)]
struct List {
    mutation: Vec<Mutation>,
}

/// A text that stands once in a file, and its replacement.
#[derive(Deserialize)]
struct Mutation {
    /// In the folder of the crates; its first part is the package whose tests must fail.
    file: PathBuf,
    effect: String,
    from: String,
    to: String,
}

impl Mutation {
    fn package(&self) -> &Path {
        self.file.iter().next().map_or(&self.file, Path::new)
    }

    /// The mutated text of its file.
    fn apply(&self, text: &str) -> Result<String, String> {
        let (file, from) = (self.file.display(), &self.from);
        match text.matches(from).count() {
            1 if *from != self.to => Ok(text.replace(from, &self.to)),
            1 => Err(format!("{file}: {from:?} is replaced with itself")),
            places => Err(format!(
                "{from:?} stands in {file} {places} times, not once"
            )),
        }
    }
}

fn list() -> Result<Vec<Mutation>, String> {
    let file = firmware::root().join("xtask/mutations.toml");
    let list: List = toml::from_str(&read(&file)?).map_err(|error| error.to_string())?;
    Ok(list.mutation)
}

/// Applies each mutation in a copy, runs the tests of its package, and prints a table of the results.
pub(crate) fn check() -> Result<(), String> {
    let mutations = list()?;
    let folder = firmware::root().join("target/mutations");
    let copy = folder.join("source");
    copy_workspace(&copy)?;
    let mut packages: Vec<&Path> = mutations.iter().map(Mutation::package).collect();
    packages.dedup();
    for package in packages {
        if !passes(&copy, package)? {
            return Err(format!(
                "the tests of {} fail without any mutation",
                package.display()
            ));
        }
    }
    println!("| | file | mutation | caught |\n|---|---|---|---|");
    let mut missed = 0;
    for (number, mutation) in (1..).zip(&mutations) {
        let file = copy.join("crates").join(&mutation.file);
        let original = read(&file)?;
        write(&file, &mutation.apply(&original)?)?;
        let is_caught = !passes(&copy, mutation.package())?;
        write(&file, &original)?;
        missed += u32::from(!is_caught);
        println!(
            "| {number} | `{}` | {} | {} |",
            mutation.file.display(),
            mutation.effect,
            if is_caught { "yes" } else { "**no**" }
        );
    }
    match missed {
        0 => Ok(()),
        _ => Err(format!("{missed} mutations pass the tests")),
    }
}

/// True if the tests pass. A mutation that does not compile is an error: no test caught it.
fn passes(copy: &Path, package: &Path) -> Result<bool, String> {
    let test = |more: &[&str]| {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        Command::new(cargo)
            .current_dir(copy)
            .args(["test", "--quiet", "--lib", "--tests", "--target-dir"])
            .args([Path::new("../target"), Path::new("-p"), package])
            .args(more)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .map(|status| status.success())
            .map_err(|error| format!("cargo does not start: {error}"))
    };
    if !test(&["--no-run"])? {
        return Err(format!("{} does not compile", copy.display()));
    }
    test(&[])
}

/// Copies every file of the project, as it is now.
fn copy_workspace(copy: &Path) -> Result<(), String> {
    let root = firmware::root();
    let listed = Command::new("git")
        .current_dir(root)
        .args(["ls-files", "-z", "--cached", "--others"])
        .arg("--exclude-standard")
        .output()
        .map_err(|error| format!("git does not start: {error}"))?;
    let _ = fs::remove_dir_all(copy);
    let files = String::from_utf8_lossy(&listed.stdout).into_owned();
    let files = files.split_terminator('\0').map(Path::new);
    // Git lists a file that was deleted until that is committed.
    for file in files.filter(|file| root.join(file).exists()) {
        let target = copy.join(file);
        let folder = target.parent().unwrap_or(copy);
        fs::create_dir_all(folder)
            .and_then(|()| fs::copy(root.join(file), &target))
            .map_err(|error| format!("{}: {error}", file.display()))?;
    }
    Ok(())
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
    fn every_mutation_has_its_place() {
        for mutation in list().expect("the list is TOML") {
            let file = firmware::root().join("crates").join(&mutation.file);
            let text = read(&file).expect("the file is there");
            mutation.apply(&text).expect("it stands there once");
        }
    }
}
