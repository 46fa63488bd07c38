//! The Python package: its wheel in an environment of its own, and its tests there.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{built, root, run};

/// The package.
const PACKAGE: &str = "crates/identifier-py";

const QUIET: [&str; 3] = ["install", "--quiet", "--disable-pip-version-check"];

/// The largest wheel, bytes: 1.75 MiB.
const MAX_WHEEL: u64 = 7 << 18;

/// Packages of the tests' environment: the builder and packer, and those that the tests need.
const PACKAGES: [&str; 4] = [
    "maturin>=1.9,<2",
    PACKER,
    "numpy>=1.26",
    "distributed>=2024.1",
];

/// Packs a wheel smaller than the builder does.
pub(crate) const PACKER: &str = "zopfli>=0.2";

/// The extras of the wheel whose libraries the tests of readers and servos need, which are skipped without.
const EXTRAS: &str = "dynamixel,feetech,mat,parquet,ros,ulog,wpilog";

/// Builds the wheel, installs it and runs its tests against the program, which is built.
pub(crate) fn check() -> Result<(), String> {
    let Some(environment) = environment(&PACKAGES)? else {
        return Ok(());
    };
    let wheel = wheel(&environment, &[])?;
    let program = |name: &str| Command::new(environment.join("bin").join(name));
    let anew = ["--no-deps", "--force-reinstall"];
    run(program("pip").args(QUIET).args(anew).arg(&wheel))?;
    let with_extras = format!("{}[{EXTRAS}]", wheel.display());
    if run(program("pip").args(QUIET).args([&with_extras, "pandas>=2"])).is_err() {
        println!("skipped: pip cannot get the libraries of {EXTRAS}, and pandas");
    }
    // From a folder in which nothing but the installed package can be found.
    for tests in [
        "tests/test_servo_id.py",
        "tests/test_read.py",
        "tests/test_servos.py",
    ] {
        run(program("python")
            .arg(root().join(PACKAGE).join(tests))
            .env("SERVO_ID_PROGRAM", built().join("debug/servo-id"))
            .current_dir(wheels()))?;
    }
    installs(&environment)
}

/// Runs each line of the pages that installs the package, as it is written, in an empty environment.
fn installs(environment: &Path) -> Result<(), String> {
    let docs = root().join("docs");
    let pages = fs::read_dir(&docs).map_err(|error| format!("{}: {error}", docs.display()))?;
    let mut pages: Vec<_> = pages.flatten().map(|page| page.path()).collect();
    pages.extend([PACKAGE, ""].map(|folder| root().join(folder).join("README.md")));
    let texts = pages
        .iter()
        .filter_map(|page| fs::read_to_string(page).ok());
    let lines: BTreeSet<String> = texts
        .flat_map(|text| {
            let code = text.lines().filter_map(|line| line.split(" #").next());
            let installs = code.filter(|line| line.starts_with("pip install"));
            installs
                .map(|line| line.trim_end().to_owned())
                .collect::<Vec<_>>()
        })
        .collect();
    if lines.is_empty() {
        return Err("no page says how the package is installed".to_owned());
    }
    for line in lines {
        println!("{line}");
        let empty = built().join("python/empty");
        let venv = ["-m", "venv", "--clear"];
        run(Command::new(environment.join("bin/python"))
            .args(venv)
            .arg(&empty))?;
        run(Command::new("bash")
            .args(["-euc", &format!("{line}\npython -c 'import servo_id'")])
            .envs([
                ("CARGO_TARGET_DIR", built().join("python").as_os_str()),
                ("PATH", &path_with(&empty)?),
                ("PIP_QUIET", "1".as_ref()),
                ("PIP_DISABLE_PIP_VERSION_CHECK", "1".as_ref()),
            ])
            .current_dir(root()))?;
    }
    Ok(())
}

/// The paths of programs, those of an environment before all others.
fn path_with(environment: &Path) -> Result<OsString, String> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let own = [environment.join("bin")].into_iter();
    std::env::join_paths(own.chain(std::env::split_paths(&path))).map_err(|error| error.to_string())
}

/// An environment with packages; none if they cannot be had, which is said.
pub(crate) fn environment(packages: &[&str]) -> Result<Option<PathBuf>, String> {
    let environment = built().join("python/environment");
    run(Command::new("python3")
        .args(["-m", "venv"])
        .arg(&environment))
    .map_err(|fault| {
        format!("{fault}: Python 3.11 or later with venv is needed (Debian: python3-venv)")
    })?;
    let mut pip = Command::new(environment.join("bin/pip"));
    if run(pip.args(QUIET).args(packages)).is_err() {
        println!("skipped: pip cannot get {}", packages.join(", "));
        return Ok(None);
    }
    Ok(Some(environment))
}

fn wheels() -> PathBuf {
    built().join("python/wheels")
}

/// Builds a wheel by the builder of an environment, with further options of it.
pub(crate) fn wheel(environment: &Path, options: &[&str]) -> Result<PathBuf, String> {
    let _ = fs::remove_dir_all(wheels());
    run(Command::new(environment.join("bin/maturin"))
        .args(["build", "--release", "--locked", "--out"])
        .arg(wheels())
        .args(options)
        .envs([
            ("CARGO_TARGET_DIR", built().join("python").as_os_str()),
            // Where the builder looks for its linker.
            ("PATH", &path_with(environment)?),
        ])
        .current_dir(root().join(PACKAGE)))?;
    let wheel = only_file(&wheels())?;
    let pack = root().join(PACKAGE).join("pack.py");
    run(Command::new(environment.join("bin/python"))
        .arg(pack)
        .arg(&wheel))?;
    let bytes = fs::metadata(&wheel).map_or(u64::MAX, |found| found.len());
    if bytes > MAX_WHEEL {
        return Err(format!(
            "{} has {bytes} bytes, at most {MAX_WHEEL} are allowed",
            wheel.display()
        ));
    }
    println!("{}: {bytes} bytes", wheel.display());
    Ok(wheel)
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
