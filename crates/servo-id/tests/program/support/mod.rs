//! Support of the command line's tests.

pub(crate) mod browser;
pub(crate) mod pages;
#[path = "../../../../../host-sim/tests/support/readable.rs"]
pub(crate) mod readable;
pub(crate) mod simulated_drive;
pub(crate) mod terminal;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

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

/// The text of a path, for an argument.
pub(crate) fn argument(path: &Path) -> String {
    path.display().to_string()
}

/// A fresh folder for a test with the paper's scenario, `scenario.toml`, for another duration, s.
#[cfg(target_os = "linux")]
pub(crate) fn folder_with_paper(test: &str, duration: &str) -> PathBuf {
    let folder = folder(test);
    let text = servo_id::paper::PROPOSED.replace("60.0", duration);
    std::fs::write(folder.join("scenario.toml"), text).expect("the scenario is written");
    folder
}

/// The committed log of a simulated servo, in CSV.
pub(crate) fn committed_log() -> String {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host-sim/logs/simulated-servo.csv.gz");
    let file = std::fs::File::open(path).expect("the log is committed");
    let mut text = String::new();
    flate2::read::GzDecoder::new(file)
        .read_to_string(&mut text)
        .expect("the log is text");
    text
}

/// Asserts exit status 0.
pub(crate) fn assert_done(output: &Output) {
    assert_eq!(output.status.code(), Some(0), "{}", standard_error(output));
}

/// Standard output of a command that succeeded.
pub(crate) fn printed(output: &Output) -> String {
    assert_done(output);
    String::from_utf8(output.stdout.clone()).expect("text")
}

/// The JSON that a command printed, and nothing else.
pub(crate) fn printed_json(output: &Output) -> Value {
    serde_json::from_str(&printed(output)).expect("only JSON")
}

/// Message of a refusal: exit status 2, and nothing on standard output.
pub(crate) fn refusal_message(output: &Output) -> String {
    let message = standard_error(output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty(), "no partial output");
    message
}

/// The program's standard error.
pub(crate) fn standard_error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A scenario that comes with the program.
pub(crate) fn scenario(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host-sim/scenarios");
    folder.join(name).display().to_string()
}
