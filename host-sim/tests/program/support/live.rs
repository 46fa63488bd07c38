//! Runs that browsers show live.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// A live run and its address.
pub(crate) struct Shown {
    pub(crate) program: Child,
    /// HOST:PORT.
    pub(crate) address: String,
}

impl Shown {
    pub(crate) fn start(words: &[&str]) -> Self {
        // A shell's background jobs, and so their children, ignore Ctrl-C.
        let mut program = Command::new("env")
            .args(["--default-signal=INT", env!("CARGO_BIN_EXE_servo-id")])
            .args(words)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut line = String::new();
        let mut errors = BufReader::new(program.stderr.take().expect("it is piped"));
        errors.read_line(&mut line).expect("it prints its address");
        let address = line
            .split("http://")
            .nth(1)
            .and_then(|rest| rest.split('/').next());
        let address = address
            .unwrap_or_else(|| panic!("no address: {line}"))
            .to_owned();
        program.stderr = Some(errors.into_inner());
        Self { program, address }
    }

    /// Presses Ctrl-C; the status it ends with.
    pub(crate) fn interrupt(mut self) -> Option<i32> {
        let sent = Command::new("kill")
            .args(["-INT", &self.program.id().to_string()])
            .status();
        assert!(sent.expect("kill").success());
        self.program.wait().expect("it ends").code()
    }
}
