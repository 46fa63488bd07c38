//! Support of the command line's tests.

pub(crate) mod browser;
pub(crate) mod live;
pub(crate) mod pages;
pub(crate) mod readable;
pub(crate) mod simulated_drive;
pub(crate) mod terminal;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program.
pub(crate) fn servo_id(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_servo-id"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// A fresh folder for a test.
pub(crate) fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}

/// The program's standard error.
pub(crate) fn standard_error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A scenario that comes with the program.
pub(crate) fn scenario(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    folder.join(name).display().to_string()
}
