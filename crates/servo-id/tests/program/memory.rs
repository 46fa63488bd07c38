//! Memory does not grow with the time of a run, and with the rows of a log by little.

use std::process::Stdio;
use std::time::Duration;

use crate::support::{Folder, folder};

/// Lengths of two runs, s: both have more samples than the verdict looks at.
const DURATIONS: [f64; 2] = [150.0, 400.0];

/// The most that a run may need, kB, and its largest growth from the shorter to the longer: one retained number per sample
/// would take 2000.
const RUN: [u64; 2] = [200_000, 1_250];

/// The most that identification needs for each row of a log of four columns, bytes: the columns and the samples.
const ROW: u64 = 210;

/// The most resident memory that the program needs for a call, kB.
fn peak(folder: &Folder, words: &str) -> u64 {
    let mut child = folder
        .program(words)
        .stdout(Stdio::null())
        .spawn()
        .expect("it starts");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    loop {
        // A process that has ended has no such line any more.
        let now = std::fs::read_to_string(&status).unwrap_or_default();
        let line = now.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let now = line.and_then(|line| line.trim().strip_suffix(" kB"));
        peak = peak.max(now.map_or(0, |now| now.parse().expect("a number")));
        if let Some(status) = child.try_wait().expect("it can be waited for") {
            assert!(status.success(), "{words}");
            return peak;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The peaks of a run and of the replay of its log, with every output there is, kB.
fn peaks_of(duration: f64) -> [u64; 2] {
    let folder = folder("memory");
    let long = format!("duration = {duration:?}");
    folder.write_scenario("paper.toml", "duration = 60.0", &long);
    let peaks = [
        "run paper.toml --csv log.csv --json run.json --plot run.png",
        "identify log.csv --scenario paper.toml --csv again.csv --json replay.json --plot replay.png",
    ]
    .map(|words| peak(&folder, words));
    // To the last bit: time, position, what the model leaves, command, estimates.
    let columns = |file: &str, places: [usize; 8]| -> Vec<String> {
        let cells = |row: &str| {
            let row: Vec<&str> = row.split(',').collect();
            places.map(|place| row[place]).join(",")
        };
        folder.read(file).lines().skip(1).map(cells).collect()
    };
    let log = columns("log.csv", [0, 2, 4, 3, 5, 6, 7, 8]);
    assert!(log == columns("again.csv", [0, 1, 3, 4, 5, 6, 7, 8]));
    let _ = std::fs::remove_dir_all(&folder);
    peaks
}

#[test]
fn a_longer_run_needs_no_more_memory_and_its_log_little() {
    let [short, long] = DURATIONS.map(peaks_of);
    println!("peaks of run and replay: {short:?} kB, {long:?} kB");
    let [[run, identify], [long_run, long_identify]] = [short, long];
    assert!((1000..RUN[0]).contains(&long_run) && long_run < run + RUN[1]);
    let rows = 1000 * (DURATIONS[1] - DURATIONS[0]) as u64;
    let growth = 1024 * (long_identify - identify) / rows;
    assert!(growth < ROW, "{growth} bytes to a row");
}
