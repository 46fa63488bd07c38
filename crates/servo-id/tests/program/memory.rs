//! Memory does not grow with the time of a run, and with the rows of a log by little.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::support::argument;

/// Lengths of two runs, s: both have more samples than the verdict looks at.
const DURATIONS: [f64; 2] = [300.0, 1000.0];

/// The most that a run may need, kB, and its largest growth from the shorter to the longer: one retained number per sample
/// would take 5600.
const RUN: [u64; 2] = [200_000, 3_500];

/// The most that identification needs for each row of a log of four columns, bytes: the columns and the samples.
const ROW: u64 = 210;

/// The most resident memory that the simulator needs for this, kB.
fn peak(arguments: &[&str]) -> u64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_servo-id"))
        .args(arguments)
        .stdout(Stdio::null())
        .spawn()
        .expect("the simulator runs");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    loop {
        // A process that has ended has no such line any more.
        let now = std::fs::read_to_string(&status).unwrap_or_default();
        let line = now.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let now = line.and_then(|line| line.trim().strip_suffix(" kB"));
        peak = peak.max(now.map_or(0, |now| now.parse().expect("a number")));
        if let Some(status) = child.try_wait().expect("it can be waited for") {
            assert!(status.success(), "{arguments:?}");
            return peak;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The peaks of a run and of the replay of its log, with every output there is, kB.
fn peaks_of(duration: f64, folder: &Path) -> [u64; 2] {
    let _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder).expect("a folder for the test");
    let scenario = folder.join("long.toml");
    let paper = include_str!("../../../../host-sim/scenarios/paper.toml");
    assert!(paper.contains("duration = 60.0"));
    let long = paper.replace("duration = 60.0", &format!("duration = {duration:?}"));
    std::fs::write(&scenario, long).expect("written");
    let [scenario, log] = [scenario, folder.join("long.csv")].map(|path| argument(&path));
    let outputs = |verb: &str| {
        ["json", "png"].map(|ending| argument(&folder.join(format!("{verb}.{ending}"))))
    };
    let [json, plot] = outputs("run");
    let run = peak(&[
        "run", &scenario, "--csv", &log, "--json", &json, "--plot", &plot,
    ]);
    let [json, plot] = outputs("replay");
    let again = argument(&folder.join("again.csv"));
    let replay = peak(&[
        "identify",
        &log,
        "--scenario",
        &scenario,
        "--csv",
        &again,
        "--json",
        &json,
        "--plot",
        &plot,
    ]);
    // The trace of a replay is a log like any other.
    assert!(std::fs::read(&log).expect("a log") == std::fs::read(&again).expect("a log"));
    [run, replay]
}

#[test]
fn a_longer_run_needs_no_more_memory_and_its_log_little() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("memory");
    let [short, long] = DURATIONS.map(|duration| peaks_of(duration, &folder));
    println!("peaks of run and replay: {short:?} kB, {long:?} kB");
    let [[run, identify], [long_run, long_identify]] = [short, long];
    assert!((1000..RUN[0]).contains(&long_run) && long_run < run + RUN[1]);
    let rows = 1000 * (DURATIONS[1] - DURATIONS[0]) as u64;
    let growth = 1024 * (long_identify - identify) / rows;
    assert!(growth < ROW, "{growth} bytes to a row");
    let _ = std::fs::remove_dir_all(&folder);
}
