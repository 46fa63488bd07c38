//! Breaks the chip's drivers and the drive's logic in one place after the other and sees that their tests
//! notice.
//!
//! It takes some minutes, so CI leaves it out.

mod list;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::firmware;
use list::{DRIVERS, LOGIC, Mutation};

/// Folders of the workspace that both and their tests are made of; the others are left out of
/// the copy's workspace.
const MEMBERS: [&str; 5] = [
    "crates/drive-chip",
    "crates/drive-link",
    "crates/drive-logic",
    "crates/virtual-servo",
    "identifier-core",
];

/// Applies each mutation in a copy, runs the tests, and prints what came of it as a table.
pub(crate) fn check() -> Result<(), String> {
    let copy = firmware::root().join("target/mutations");
    copy_workspace(&copy)?;
    for package in [CHIP_PACKAGE, LOGIC_PACKAGE] {
        if !passes(&copy, package)? {
            return Err(format!("the tests of {package} fail without any mutation"));
        }
    }
    println!("| | file | mutation | caught |\n|---|---|---|---|");
    let mut missed = 0;
    for (number, (package, mutation)) in (1..).zip(all()) {
        let file = copy
            .join("crates")
            .join(package)
            .join("src")
            .join(mutation.file);
        let original = read(&file)?;
        if original.matches(mutation.from).count() != 1 {
            return Err(format!(
                "mutation {number}: {:?} does not stand in {} once",
                mutation.from, mutation.file
            ));
        }
        write(&file, &original.replace(mutation.from, mutation.to))?;
        let caught = !passes(&copy, package)?;
        write(&file, &original)?;
        missed += u32::from(!caught);
        let answer = if caught { "yes" } else { "**no**" };
        println!(
            "| {number} | `{}` | {} | {answer} |",
            mutation.file, mutation.what
        );
    }
    match missed {
        0 => Ok(()),
        _ => Err(format!("{missed} mutations pass the tests")),
    }
}

/// The drivers' package, and that of the logic.
const CHIP_PACKAGE: &str = "drive-chip";
const LOGIC_PACKAGE: &str = "drive-logic";

/// Every mutation with its package.
fn all() -> impl Iterator<Item = (&'static str, Mutation)> {
    let drivers = DRIVERS.into_iter().map(|mutation| (CHIP_PACKAGE, mutation));
    drivers.chain(LOGIC.into_iter().map(|mutation| (LOGIC_PACKAGE, mutation)))
}

/// Whether the tests compile and pass; a mutation that does not compile is an error, for nothing
/// caught it.
fn passes(copy: &Path, package: &str) -> Result<bool, String> {
    let tests = |build_only: &[&str]| {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        Command::new(cargo)
            .current_dir(copy)
            .args(["test", "--quiet", "--lib", "--tests", "-p", package])
            .args(build_only)
            .env("CARGO_TARGET_DIR", copy.join("target"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .map(|status| status.success())
            .map_err(|error| format!("cargo does not start: {error}"))
    };
    if !tests(&["--no-run"])? {
        return Err(format!("{} does not compile", copy.display()));
    }
    tests(&[])
}

/// The sources of the drivers and of what they are made of, as a workspace of their own.
fn copy_workspace(copy: &Path) -> Result<(), String> {
    let root = firmware::root();
    fs::create_dir_all(copy).map_err(|error| format!("{}: {error}", copy.display()))?;
    let manifest = read(&root.join("Cargo.toml"))?;
    let mut workspace: toml::Table = manifest
        .parse()
        .map_err(|error| format!("Cargo.toml: {error}"))?;
    if let Some(toml::Value::Table(table)) = workspace.get_mut("workspace") {
        table.insert("members".to_owned(), MEMBERS.to_vec().into());
        table.remove("default-members");
        table.remove("exclude");
    }
    write(&copy.join("Cargo.toml"), &workspace.to_string())?;
    for file in ["Cargo.lock", "rust-toolchain.toml"] {
        write(&copy.join(file), &read(&root.join(file))?)?;
    }
    for member in MEMBERS {
        copy_folder(&root.join(member), &copy.join(member))?;
    }
    Ok(())
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), String> {
    let fault = |error: std::io::Error| format!("{}: {error}", from.display());
    fs::create_dir_all(to).map_err(fault)?;
    for entry in fs::read_dir(from).map_err(fault)? {
        let entry = entry.map_err(fault)?;
        let target: PathBuf = to.join(entry.file_name());
        if entry.file_type().map_err(fault)?.is_dir() {
            copy_folder(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), &target).map_err(fault)?;
        }
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
        for (package, mutation) in all() {
            let file = firmware::root()
                .join("crates")
                .join(package)
                .join("src")
                .join(mutation.file);
            let text = read(&file).expect("the file is there");
            let places = text.matches(mutation.from).count();
            assert_eq!(places, 1, "{}: {}", mutation.file, mutation.from);
            assert_ne!(mutation.from, mutation.to);
        }
    }
}
