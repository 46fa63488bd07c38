//! Builds the firmware's binaries.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::{Path, PathBuf};

use crate::command::{self, built, root, run};
use crate::emulator;
use crate::seal::seal;

/// The chip.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// The board without room for commissioning and terms.
pub(crate) const SMALL_BOARD: &str = "black-pill-f401cc";

/// Builds and seals the drive with some features, one of them its board, and returns its file. Of a board with room it has
/// every part. It links only without a panic.
pub(crate) fn drive(features: &[&str]) -> Result<PathBuf, String> {
    let parts = match features.contains(&SMALL_BOARD) {
        true => &[][..],
        false => &["commissioning", "terms"],
    };
    let features = of(&[features, parts].concat());
    release(
        &folder(),
        &["--bin=drive", "--no-default-features", &features],
    )?;
    let drive = built().join(TARGET).join("release/drive");
    seal(&drive)?;
    Ok(drive)
}

/// The same for the emulator.
pub(crate) fn emulated_drive() -> Result<PathBuf, String> {
    drive(&[emulator::BOARD, "emulator"])
}

/// Builds and seals the drive for a board.
pub(crate) fn image(board: &str) -> Result<(), String> {
    let drive = drive(&[board])?;
    println!("sealed: {}", drive.display());
    Ok(())
}

/// Cargo's word for features.
fn of(features: &[&str]) -> String {
    format!("--features={}", features.join(","))
}

/// The crates whose code is generic or the firmware's own, which a bench is of.
const OF_A_BENCH: [&str; 3] = ["firmware-stm32", "identifier-core", "virtual-servo"];

/// An optimiser level of these crates, with 3 for their dependencies. It overrides that of the drive.
pub(crate) const FOR_SPEED: Option<&str> = Some("3");
pub(crate) const FOR_SIZE: Option<&str> = Some("\"s\"");

/// The level of a name.
pub(crate) fn level(name: Option<&str>) -> Option<&'static str> {
    match name? {
        "s" => FOR_SIZE,
        _ => FOR_SPEED,
    }
}

/// Builds a part of the bench and returns its file. It links only without a panic, but for size.
pub(crate) fn bench(part: &str, level: Option<&str>) -> Result<PathBuf, String> {
    let mut what = ["--bin=bench", "--no-default-features"]
        .map(str::to_owned)
        .to_vec();
    what.push(of(&[emulator::BOARD, part]));
    if let Some(level) = level {
        let own = OF_A_BENCH.map(|name| format!("package.{name}.opt-level={level}"));
        let levels = own.into_iter().chain(["opt-level=3".to_owned()]);
        what.extend(levels.map(|level| format!("--config=profile.release.{level}")));
    }
    if level == FOR_SIZE {
        let survives = "-Clink-arg=--defsym=a_panic_survived_in_this_release=0";
        what.extend(["--", survives].map(str::to_owned));
    }
    let what: Vec<&str> = what.iter().map(String::as_str).collect();
    cargo(&folder(), "rustc", &what)?;
    // Another part takes its place.
    let bench = built().join(TARGET).join("release/bench");
    let level = level.unwrap_or("drive").trim_matches('"');
    let kept = bench.with_extension(format!("{part}-{level}"));
    std::fs::copy(&bench, &kept).map_err(|error| format!("{}: {error}", kept.display()))?;
    Ok(kept)
}

/// Where the firmware is built: the settings there name its target.
fn folder() -> PathBuf {
    root().join("firmware-stm32")
}

/// Builds the emulator's plugin for this machine and returns its file.
pub(crate) fn build_trace() -> Result<PathBuf, String> {
    release(root(), &["-p", "trace"])?;
    let name = format!("{DLL_PREFIX}trace{DLL_SUFFIX}");
    Ok(built().join("release").join(name))
}

/// Builds a binary of the examples, which are a workspace of their own, and returns its file. They share the folder of what
/// is built, so that common dependencies are built once.
///
/// Its package alone: those of one on an operating system have other features.
pub(crate) fn build_example(package: &str, name: &str, target: &str) -> Result<PathBuf, String> {
    let what = ["-p", package, "--bin", name, "--target", target];
    release(&root().join("examples"), &what)?;
    Ok(built().join(target).join("release").join(name))
}

/// Builds a release in a folder.
fn release(folder: &Path, what: &[&str]) -> Result<(), String> {
    cargo(folder, "build", what)
}

/// Runs `cargo build` or `cargo rustc` for a release in a folder, whose settings may name a target.
fn cargo(folder: &Path, verb: &str, what: &[&str]) -> Result<(), String> {
    let mut cargo = command::cargo(verb);
    run(cargo
        .args(["--release", "--locked"])
        .args(what)
        .current_dir(folder))
}
