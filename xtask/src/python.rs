//! The Python package: its wheel in an environment of its own, and its tests there.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::firmware::root;
use crate::playground::target;

/// The largest wheel, bytes.
const MAX_WHEEL: u64 = 1_500_000;

/// Packages of the environment: the builder and packer, and those that the tests need.
const PACKAGES: [&str; 4] = [
    "maturin>=1.9,<2",
    "zopfli>=0.2",
    "numpy>=1.26",
    "distributed>=2024.1",
];

/// The extras of the wheel whose libraries the tests of readers need, which are skipped without.
const EXTRAS: &str = "mat,parquet,ros,ulog,wpilog";

/// Builds the wheel, installs it and runs its tests against the program, which is built.
pub(crate) fn check() -> Result<(), String> {
    let folder = target().join("python");
    let environment = folder.join("environment");
    run(Command::new("python3")
        .args(["-m", "venv"])
        .arg(&environment))
    .map_err(|fault| {
        format!("{fault}: Python 3.11 or later with venv is needed (Debian: python3-venv)")
    })?;
    let program = |name: &str| Command::new(environment.join("bin").join(name));
    let quiet = ["install", "--quiet", "--disable-pip-version-check"];
    if run(program("pip").args(quiet).args(PACKAGES)).is_err() {
        println!("skipped: pip cannot get {}", PACKAGES.join(", "));
        return Ok(());
    }
    let package = root().join("crates/identifier-py");
    let wheels = folder.join("wheels");
    let _ = fs::remove_dir_all(&wheels);
    run(program("maturin")
        .args(["build", "--release", "--locked", "--out"])
        .arg(&wheels)
        .env("CARGO_TARGET_DIR", &folder)
        .current_dir(&package))?;
    let wheel = only_file(&wheels)?;
    run(program("python").arg(package.join("pack.py")).arg(&wheel))?;
    let bytes = fs::metadata(&wheel).map_or(u64::MAX, |found| found.len());
    if bytes > MAX_WHEEL {
        return Err(format!(
            "{} has {bytes} bytes, at most {MAX_WHEEL} are allowed",
            wheel.display()
        ));
    }
    println!("{}: {bytes} bytes", wheel.display());
    let anew = ["--no-deps", "--force-reinstall"];
    run(program("pip").args(quiet).args(anew).arg(&wheel))?;
    let with_extras = format!("{}[{EXTRAS}]", wheel.display());
    if run(program("pip").args(quiet).args([&with_extras, "pandas>=2"])).is_err() {
        println!("skipped: pip cannot get the libraries of {EXTRAS}, and pandas");
    }
    // From a folder in which nothing but the installed package can be found.
    for tests in ["tests/test_servo_id.py", "tests/test_read.py"] {
        run(program("python")
            .arg(package.join(tests))
            .env("SERVO_ID_PROGRAM", target().join("debug/servo-id"))
            .current_dir(&wheels))?;
    }
    Ok(())
}

fn run(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().display().to_string();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{name} fails ({status})")),
        Err(error) => Err(format!("{name} does not start ({error})")),
    }
}

fn only_file(folder: &Path) -> Result<PathBuf, String> {
    let unreadable = |error| format!("{}: {error}", folder.display());
    let entries = fs::read_dir(folder).map_err(unreadable)?;
    let files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    match &files[..] {
        [one] => Ok(one.clone()),
        several => Err(format!("{} wheels in {}", several.len(), folder.display())),
    }
}
