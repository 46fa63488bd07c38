//! Support of the command line's tests.

pub(crate) mod browser;
pub(crate) mod pages;
#[path = "../../../../../host-sim/tests/support/readable.rs"]
pub(crate) mod readable;
pub(crate) mod simulated_drive;
#[path = "../../../src/tests/status.rs"]
pub(crate) mod status;
pub(crate) mod terminal;

use std::fs;
use std::io::Read;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// Runs the program.
pub(crate) fn servo_id(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_servo-id"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// A folder for a test, in which the program is called.
pub(crate) struct Folder(PathBuf);

impl Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl AsRef<Path> for Folder {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

impl Folder {
    /// Writes a file.
    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.join(name), bytes).expect("written");
    }

    /// The text of a file.
    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The JSON of a file.
    pub(crate) fn read_json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).expect("JSON")
    }

    /// Writes a scenario that comes with the program, with a text in place of another.
    pub(crate) fn write_scenario(&self, name: &str, from: &str, to: &str) {
        let text = scenario_text(name);
        assert!(text.contains(from), "{name}: {from}");
        self.write(name, text.replace(from, to));
    }

    /// The names of its files, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).expect("a folder");
        let name = |entry: fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
        let mut names: Vec<_> = entries
            .map(|entry| name(entry.expect("an entry")))
            .collect();
        names.sort();
        names
    }

    /// The program with words, divided at spaces.
    pub(crate) fn program(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_servo-id"));
        command.args(words.split_whitespace()).current_dir(&self.0);
        command.stdin(Stdio::null());
        command
    }

    /// What the program answers to words.
    pub(crate) fn call(&self, words: &str) -> Output {
        let output = self.program(words).output();
        output.expect("the program starts")
    }

    /// Standard output of a call that succeeds.
    pub(crate) fn done(&self, words: &str) -> String {
        printed(&self.call(words))
    }

    /// The JSON of a call that succeeds.
    pub(crate) fn json(&self, words: &str) -> Value {
        printed_json(&self.call(&format!("{words} --json -")))
    }

    /// The message of a call that is refused.
    pub(crate) fn refused(&self, words: &str) -> String {
        refusal_message(&self.call(words))
    }

    /// Asserts of each row, a call and a part of its message divided by `|`, that it is refused so.
    pub(crate) fn assert_refused(&self, rows: &str) {
        for row in table(rows) {
            let message = self.refused(&row[0]);
            assert!(message.contains(&row[1]), "{row:?}: {message}");
        }
    }
}

/// The cells of rows, divided by `|`, in which `;` begins a line.
pub(crate) fn table(rows: &str) -> Vec<Vec<String>> {
    let cell = |cell: &str| cell.trim().replace("; ", "\n");
    let rows = rows.trim().lines();
    rows.map(|row| row.split('|').map(cell).collect()).collect()
}

/// A fresh folder for a test.
pub(crate) fn folder(test: &str) -> Folder {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder for the test");
    Folder(folder)
}

/// A fresh folder for the test that runs in this thread.
pub(crate) fn own_folder() -> Folder {
    let thread = std::thread::current();
    folder(&thread.name().unwrap_or("thread").replace("::", "-"))
}

/// A number of a result.
pub(crate) fn number(result: &Value, pointer: &str) -> f64 {
    let value = result.pointer(pointer).and_then(Value::as_f64);
    value.unwrap_or_else(|| panic!("no {pointer} in {result}"))
}

/// An estimate of a result.
pub(crate) fn estimate(result: &Value, name: &str) -> f64 {
    number(result, &format!("/estimates/{name}/value"))
}

/// The text of a path, for an argument.
pub(crate) fn argument(path: &Path) -> String {
    path.display().to_string()
}

/// A fresh folder for a test with the paper's scenario, `scenario.toml`, for another duration, s.
pub(crate) fn folder_with_paper(test: &str, duration: &str) -> Folder {
    let folder = folder(test);
    let text = servo_id::paper::PROPOSED.replace("60.0", duration);
    folder.write("scenario.toml", text);
    folder
}

/// The committed log of a simulated servo, packed.
pub(crate) fn packed_log() -> Vec<u8> {
    fs::read(scenario("../logs/simulated-servo.csv.gz")).expect("the log is committed")
}

/// The same, in CSV.
pub(crate) fn committed_log() -> String {
    let mut text = String::new();
    flate2::read::GzDecoder::new(&*packed_log())
        .read_to_string(&mut text)
        .expect("the log is text");
    text
}

/// Sends a signal to a process.
#[cfg(unix)]
pub(crate) fn signal(process: u32, name: &str) {
    let sent = Command::new("kill")
        .args([name, &process.to_string()])
        .status();
    assert!(sent.is_ok_and(|status| status.success()));
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

/// Its text.
pub(crate) fn scenario_text(name: &str) -> String {
    fs::read_to_string(scenario(name)).expect("it is there")
}
