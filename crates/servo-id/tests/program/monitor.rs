//! The monitor in a terminal, on a simulated drive: keys typed, screens read.

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::time::Duration;

use crate::support::terminal::Terminal;
use crate::support::{Folder, estimate, folder, scenario_text, signal, standard_error};

const PROGRAM: &str = env!("CARGO_BIN_EXE_servo-id");

/// The scenario of the page on the monitor.
fn shipped() -> String {
    scenario_text("drive.toml")
}

/// A simulated drive, and a person who looks at it.
pub(crate) struct Bench {
    drive: Child,
    pub(crate) port: String,
    pub(crate) folder: Folder,
}

impl Bench {
    fn new(test: &str) -> Self {
        Self::with(test, "")
    }

    /// With something more in the scenario.
    fn with(test: &str, more: &str) -> Self {
        Self::with_scenario(test, &format!("{}{more}", shipped()))
    }

    /// On a simulated drive of a scenario.
    pub(crate) fn with_scenario(test: &str, scenario: &str) -> Self {
        let folder = folder(test);
        folder.write("servo.toml", scenario);
        let mut drive = folder
            .program("drive simulate servo.toml --listen 127.0.0.1:0")
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let output = drive.stdout.take().expect("it is piped");
        let mut lines = BufReader::new(output).lines();
        let port = lines
            .find_map(|line| {
                let line = line.expect("text");
                let at = line.find("tcp:")?;
                line[at..].split(' ').next().map(str::to_owned)
            })
            .expect("it says where it is");
        let bench = Self {
            drive,
            port,
            folder,
        };
        // This machine may be busy.
        bench.drive("configure servo.toml --link-timeout 20");
        bench
    }

    /// Runs another verb on the drive.
    fn drive(&self, words: &str) -> String {
        self.folder
            .done(&format!("drive --port {} {words}", self.port))
    }

    fn command<'a>(&'a self, words: &'a str) -> Vec<&'a str> {
        let mut command = vec![PROGRAM, "drive", "--port", &self.port, "monitor"];
        command.extend(words.split_whitespace());
        command
    }

    fn monitor(&self, words: &str) -> Terminal {
        Terminal::start(&self.command(words), &self.folder, 80, 24)
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = self.drive.kill();
        let _ = self.drive.wait();
    }
}

/// Closes the loop, as a person does.
fn starts(monitor: &mut Terminal) {
    monitor.types("s");
    monitor.shows("y starts");
    monitor.types("y");
    monitor.shows(" RUNNING ");
}

/// The estimate of b that `identify` finds in a recording by the printed command. A controller that it declares is the one
/// that ran: the first motion is soft, and the reference is dithered.
fn replayed(folder: &Folder, name: &str) -> f64 {
    let result = folder.json(&format!("identify {name}.csv --scenario {name}.toml"));
    let is_declared = folder
        .read(&format!("{name}.toml"))
        .contains("[controller]");
    let agreement = &result["agreement"];
    assert_eq!(
        agreement["holds"] == true,
        is_declared,
        "{name}: {agreement}"
    );
    estimate(&result, "b")
}

#[test]
fn a_simulated_drive_has_room_for_any_dither_and_names_its_scenario() {
    let large = shipped().replace("amplitude = 0.05", "amplitude = 5.0");
    let bench = Bench::with_scenario("monitor-large-dither", &large);
    let status = bench.drive("status");
    assert!(status.contains("beyond 20 rad of"), "{status}");
    let other = shipped().replace("10000", "4096");
    bench.folder.write("other.toml", other);
    let commission = format!("drive --port {} commission other.toml", bench.port);
    let why = bench.folder.refused(&commission);
    assert!(why.contains("encoder.counts_per_rev"), "{why}");
}

#[test]
fn a_drive_is_operated_from_the_keyboard() {
    let bench = Bench::new("monitor_keyboard");
    let mut monitor = bench.monitor("--scenario servo.toml");
    monitor.shows(" DISABLED ");
    // A commissioning is a log, too.
    monitor.types("r");
    monitor.shows("recording recording.csv, 0 rows");
    monitor.types("c");
    monitor.shows("at most from -1.5");
    monitor.types("n");
    monitor.types("c");
    monitor.shows("y commissions");
    monitor.types("y");
    monitor.shows(" COMMISSIONING ");
    monitor.shows("rows: servo-id identify recording.csv");
    monitor.shows("commissioning: applied");

    // Nothing is replaced.
    monitor.types("r");
    monitor.shows("recording recording-2.csv");
    starts(&mut monitor);
    // Estimates while it moves.
    monitor.shows("b 257");
    monitor.types("t0.5");
    monitor.shows("0.5_");
    monitor.types("\r");
    monitor.shows("moving to 0.5 rad");
    monitor.shows("reference      +0.5");
    std::thread::sleep(Duration::from_secs(2));
    monitor.types(" ");
    let text = monitor.shows("servo-id identify recording-2.csv --scenario recording-2.toml");
    assert!(text.contains(" DISABLED "), "{text}");
    assert!(text.contains("none lost"), "{text}");
    monitor.types("q");
    let (status, text) = monitor.ends();
    assert_eq!(status, 0, "{text}");
    assert!(text.contains("frames, 0 lost"), "{text}");
    assert!(bench.drive("status").contains("as commissioned"));
    for name in ["recording", "recording-2"] {
        let b = replayed(&bench.folder, name);
        assert!((b / 257.7 - 1.0).abs() < 0.01, "{name}: {b}");
    }
}

#[test]
fn a_drive_that_vanishes_is_reported_and_the_terminal_restored() {
    let bench = Bench::new("monitor_vanishes");
    let mut monitor = bench.monitor("--record axis.csv");
    monitor.types("r");
    monitor.shows("recording axis.csv");
    starts(&mut monitor);
    monitor.shows("b 257");
    signal(bench.drive.id(), "-KILL");
    let (status, text) = monitor.ends();
    assert_eq!(status, 1, "{text}");
    assert!(text.contains("the connection is closed"), "{text}");
    // A sentence is divided where the line ends.
    let words: Vec<_> = text.split_whitespace().collect();
    let sentence = "stops by itself after 20 s";
    assert!(words.join(" ").contains(sentence), "{text}");
    // The recording up to then is kept.
    assert_eq!(
        bench.folder.names(),
        ["axis.csv", "axis.toml", "servo.toml"]
    );
    assert!(replayed(&bench.folder, "axis") > 200.0);
}

#[test]
fn leaving_releases_the_servo() {
    let bench = Bench::new("monitor_leaves");
    for keys in ["qy", "\x03"] {
        let mut monitor = bench.monitor("");
        monitor.shows(" DISABLED ");
        starts(&mut monitor);
        monitor.types("q");
        monitor.shows("Leaving disables it");
        // Another key stays.
        monitor.types("n");
        monitor.types(keys);
        let (status, text) = monitor.ends();
        assert_eq!(status, 0, "{text}");
        assert!(text.contains("the servo was disabled"), "{text}");
        assert!(bench.drive("status").contains("the last run was stopped"));
    }
    // `--leave` alone keeps it running, and only on a drive without a link timeout.
    let monitor = bench.monitor("--leave");
    let (status, text) = monitor.ends();
    assert_eq!(status, 2, "{text}");
    assert!(text.contains("--link-timeout 0"), "{text}");
    bench.drive("configure servo.toml --link-timeout 0");
    let mut monitor = bench.monitor("--leave");
    monitor.shows(" DISABLED ");
    starts(&mut monitor);
    monitor.types("qy");
    let (status, text) = monitor.ends();
    assert_eq!(status, 0, "{text}");
    assert!(text.contains("the drive keeps running"), "{text}");
    assert!(bench.drive("status").contains("running"));
}

#[test]
fn a_signal_restores_the_terminal_and_releases_the_servo() {
    let bench = Bench::new("monitor_signal");
    // The shell prints its own process id, which becomes the program's.
    let line = format!(
        "trap - TERM; echo $$ > pid; exec {} drive --port {} monitor",
        PROGRAM, bench.port
    );
    let command = ["env", "--default-signal=INT,TERM,HUP", "sh", "-c", &line];
    let mut monitor = Terminal::start(&command, &bench.folder, 80, 24);
    monitor.shows(" DISABLED ");
    starts(&mut monitor);
    let pid = std::fs::read_to_string(bench.folder.join("pid")).expect("it was printed");
    signal(pid.trim().parse().expect("a number"), "-TERM");
    let (status, text) = monitor.ends();
    assert_eq!(status, 0, "{text}");
    assert!(text.contains("the servo was disabled"), "{text}");
    assert!(bench.drive("status").contains("the last run was stopped"));
}

#[test]
fn a_full_disk_ends_the_recording_and_nothing_else() {
    let bench = Bench::new("monitor_disk");
    // No file may become larger than some 8 kB, as on a disk that is full.
    let line = format!(
        "trap '' XFSZ; ulimit -f 16; exec {} drive --port {} monitor",
        PROGRAM, bench.port
    );
    let mut monitor = Terminal::start(&["sh", "-c", &line], &bench.folder, 80, 24);
    monitor.shows(" DISABLED ");
    monitor.types("r");
    monitor.shows("recording recording.csv");
    starts(&mut monitor);
    let text = monitor.shows("discarded");
    assert!(text.contains("recording.csv cannot be written"), "{text}");
    assert!(text.contains(" RUNNING "), "{text}");
    assert_eq!(bench.folder.names(), ["servo.toml"]);
    monitor.types(" ");
    monitor.shows("the last run was stopped");
    monitor.types("q");
    assert_eq!(monitor.ends().0, 0);
}

#[test]
fn a_port_in_use_and_a_place_without_a_terminal_are_reported() {
    let bench = Bench::new("simulate_in_use");
    bench.folder.assert_refused(
        "drive --port tcp:127.0.0.1:9 monitor | drive watch
        drive monitor | --port",
    );
    let address = bench.port.trim_start_matches("tcp:");
    let call = format!("drive simulate servo.toml --listen {address}");
    let output = bench.folder.call(&call);
    assert_eq!(output.status.code(), Some(1));
    let why = standard_error(&output);
    assert!(why.contains("is in use by another program"), "{why}");
}
