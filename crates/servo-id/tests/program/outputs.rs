//! Outputs are safe: complete or absent, no file of others replaced without `--force`, refused before any work.

use std::fs::{self, OpenOptions};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::support::{
    Folder, folder_with_paper, packed_log, scenario_text, signal, standard_error, table,
};

/// A folder with a scenario of this duration, s, and an old file.
fn with_scenario(test: &str, duration: &str) -> Folder {
    let folder = folder_with_paper(&format!("outputs-{test}"), duration);
    folder.write("old", "precious");
    folder
}

/// Asserts of each row, a call and a part of its message, that it is refused, and that no file has come or changed.
fn assert_refused(folder: &Folder, rows: &str) {
    for row in table(rows) {
        let before = listing(folder);
        let message = folder.refused(&row[0]);
        assert!(message.contains(&row[1]), "{row:?}: {message}");
        assert!(listing(folder) == before, "{row:?}");
    }
}

/// Every name of a folder with its content.
fn listing(folder: &Folder) -> Vec<(String, Vec<u8>)> {
    let with_content = |name: String| {
        let content = fs::read(folder.join(&name)).unwrap_or_default();
        (name, content)
    };
    folder.names().into_iter().map(with_content).collect()
}

/// A folder for calls that would take at least a minute if they were not refused.
fn long(test: &str) -> Folder {
    let folder = with_scenario(test, "10000.0");
    fs::create_dir(folder.join("sub")).expect("a folder");
    for (target, link) in [("scenario.toml", "link"), ("new", "to-new")] {
        symlink(target, folder.join(link)).expect("a link");
    }
    for (file, twin) in [("scenario.toml", "twin"), ("old", "old-twin")] {
        fs::hard_link(folder.join(file), folder.join(twin)).expect("a link");
    }
    folder
}

/// Calls that are refused before any work: a place that cannot be written, an output that is an input under any name, and
/// two outputs that are one file.
const REFUSED: &str = "
run scenario.toml --csv new --json old | --force
compare scenario.toml --json old | --force
sweep --runs 1 scenario.toml --json old | --force
run scenario.toml --json no/such/place | no such folder
run scenario.toml --json old/place | is a file
run scenario.toml --json . | a folder
run scenario.toml --plot picture.gif | .png or .svg
run scenario.toml --force --json scenario.toml | this file is an input
run scenario.toml --force --csv ./sub/../scenario.toml | this file is an input
run scenario.toml --force --json link | this file is an input
run scenario.toml --force --csv twin | this file is an input
run link --force --json scenario.toml | this file is an input
identify log.csv.gz --scenario replay.toml --force --json log.csv.gz | this file is an input
identify log.csv.gz --scenario replay.toml --force --json replay.toml | this file is an input
run scenario.toml --json new --csv new | the same file as
run scenario.toml --json new --csv ./new | the same file as
run scenario.toml --json new --csv sub/../new | the same file as
run scenario.toml --json new --csv to-new | the same file as
run scenario.toml --force --json old --csv old-twin | the same file as
run scenario.toml --json - --csv - | standard output
run scenario.toml --json - --csv /dev/stdout | standard output
";

#[test]
fn refusals_come_before_any_work() {
    let folder = long("before");
    folder.write("log.csv.gz", packed_log());
    folder.write("replay.toml", scenario_text("replay.toml"));
    let begun = Instant::now();
    assert_refused(&folder, REFUSED);
    assert!(begun.elapsed() < Duration::from_secs(60), "{begun:?}");
}

#[test]
fn a_link_is_followed_and_permissions_are_kept() {
    let folder = with_scenario("link", "1.0");
    fs::create_dir(folder.join("sub")).expect("a folder");
    for (link, target) in [("to-old", "sub/old"), ("to-new", "sub/new")] {
        symlink(target, folder.join(link)).expect("a link");
    }
    folder.write("sub/old", "precious");
    let old = fs::Permissions::from_mode(0o640);
    fs::set_permissions(folder.join("sub/old"), old).expect("permitted");
    folder.done("run scenario.toml --force --json to-old --csv to-new");
    for link in ["to-old", "to-new"] {
        let found = fs::symlink_metadata(folder.join(link)).expect("there");
        assert!(found.is_symlink(), "{link}");
    }
    assert!(folder.read("sub/old").starts_with('{'));
    let mode = |name: &str| fs::metadata(folder.join(name)).expect("there").mode() & 0o777;
    assert_eq!(mode("sub/old"), 0o640);
    // A new file has the permissions of any new file.
    assert_eq!(mode("sub/new"), mode("scenario.toml"));
    let names = fs::read_dir(folder.join("sub")).expect("a folder");
    assert_eq!(names.count(), 2);
}

#[test]
fn devices_and_pipes_are_written_and_not_replaced() {
    let folder = with_scenario("device", "1.0");
    let pipe = folder.join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo starts").success());
    let reader = {
        let pipe = pipe.clone();
        thread::spawn(move || fs::read_to_string(pipe).expect("read"))
    };
    folder.done("run scenario.toml --json pipe");
    assert!(fs::metadata(&pipe).expect("there").file_type().is_fifo());
    let text = reader.join().expect("read");
    assert!(text.starts_with('{') && text.ends_with("}\n"), "{text}");

    // Only after the pipe: root could replace /dev/null.
    folder.done("run scenario.toml --csv /dev/null --json /dev/null");
    let null = fs::metadata("/dev/null").expect("there");
    assert!(null.file_type().is_char_device());
}

#[test]
fn a_dash_is_standard_output_and_alone_there() {
    let folder = with_scenario("dash", "1.0");
    folder.write("axis.toml", scenario_text("commission.toml"));
    for (words, begin, end) in [
        ("run scenario.toml --json -", "{", "}\n"),
        ("run scenario.toml --json /dev/stdout", "{", "}\n"),
        ("run scenario.toml --csv -", "time_s,", "\n"),
        ("run scenario.toml --plot -", "<svg", "</svg>\n"),
        ("compare scenario.toml --json -", "{", "}\n"),
        ("commission axis.toml --csv -", "time_s,", "\n"),
        ("sweep scenario.toml --runs 2 --csv -", "run,", "\n"),
    ] {
        let text = folder.done(words);
        assert!(text.starts_with(begin), "{words}: {text:.80}");
        assert!(text.ends_with(end), "{words}");
        assert!(!text.contains('│'), "{words}: no table");
    }
    assert_eq!(
        folder.names(),
        ["axis.toml", "old", "scenario.toml"],
        "no file of the name -"
    );
}

#[test]
fn a_full_standard_output_is_a_failure_and_a_closed_one_is_not() {
    let folder = with_scenario("full", "1.0");
    let full = || {
        OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .expect("there")
    };
    for words in [
        "run scenario.toml",
        "run scenario.toml --json -",
        "run scenario.toml --csv -",
        "run scenario.toml --plot -",
        "compare scenario.toml",
        "run scenario.toml --formats",
        "sweep scenario.toml --runs 1",
        "paper --out paper --force",
        "keys",
        "keys --schema",
        "--help",
        "--version",
    ] {
        let output = folder.program(words).stdout(full()).output();
        let output = output.expect("the program starts");
        let message = standard_error(&output);
        assert_eq!(output.status.code(), Some(1), "{words}: {message}");
        assert!(message.contains("cannot be written"), "{words}: {message}");

        let mut child = folder
            .program(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(0), "{words}");
        assert_eq!(standard_error(&output), "", "{words}");
    }
}

#[test]
fn a_full_disk_leaves_the_old_file() {
    let folder = with_scenario("disk", "10.0");
    // A file of more than 512 bytes is one too large.
    let script = "trap '' XFSZ; ulimit -f 1; servo-id run scenario.toml --force --csv old";
    let message = ends(start(&folder, script), 1);
    assert!(message.contains("old cannot be written"), "{message}");
    assert_eq!(folder.read("old"), "precious");
    assert_eq!(folder.names(), ["old", "scenario.toml"]);
}

/// Starts a script of the shell that calls the program, in which no signal is ignored that it does not trap.
fn start(folder: &Folder, script: &str) -> Child {
    let program = format!("exec '{}'", env!("CARGO_BIN_EXE_servo-id"));
    let script = script.replace("servo-id", &program);
    Command::new("env")
        .args(["--default-signal=INT,TERM,HUP", "sh", "-c", &script])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

/// Waits for a call to end with this status: its message.
fn ends(child: Child, status: i32) -> String {
    let output = child.wait_with_output().expect("it ends");
    let message = standard_error(&output);
    assert_eq!(output.status.code(), Some(status), "{message}");
    assert!(status != 130 || output.stdout.is_empty(), "{message}");
    message
}

/// Waits until a call has begun its file.
fn wait_for_temporary(folder: &Folder) {
    let begun = Instant::now();
    let is_begun = |name: &String| name.starts_with(".servo-id-");
    while !folder.names().iter().any(is_begun) {
        let waited = begun.elapsed();
        assert!(waited < Duration::from_secs(60), "no file is begun");
        thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn an_interruption_leaves_nothing_half_written() {
    let folder = with_scenario("interrupted", "20000.0");
    let before = listing(&folder);
    for (verb, name) in [("run", "-INT"), ("run", "-TERM"), ("compare", "-INT")] {
        let words = format!("servo-id {verb} scenario.toml --json old --report new.html --force");
        let child = start(&folder, &words);
        wait_for_temporary(&folder);
        thread::sleep(Duration::from_millis(100));
        signal(child.id(), name);
        ends(child, 130);
        assert!(listing(&folder) == before, "{words}");
    }
}

#[test]
fn a_background_job_that_ignores_ctrl_c_leaves_nothing_when_it_is_terminated() {
    let folder = with_scenario("interrupted-background", "20000.0");
    let before = listing(&folder);
    let mut child = start(
        &folder,
        "trap '' INT; servo-id run scenario.toml --json new.json",
    );
    wait_for_temporary(&folder);
    signal(child.id(), "-INT");
    thread::sleep(Duration::from_millis(100));
    assert!(child.try_wait().expect("a child").is_none());
    signal(child.id(), "-TERM");
    ends(child, 130);
    assert!(listing(&folder) == before);
}

#[test]
fn an_interrupted_sweep_keeps_its_finished_runs() {
    let folder = with_scenario("interrupted-sweep", "1.0");
    let call = "servo-id sweep scenario.toml --runs 1000000 --threads 1 --csv rows.csv";
    let child = start(&folder, call);
    wait_for_temporary(&folder);
    thread::sleep(Duration::from_millis(500));
    signal(child.id(), "-INT");
    let message = ends(child, 1);
    assert!(message.contains("of 1000000 servos"), "{message}");
    let text = folder.read("rows.csv");
    assert!(text.lines().count() > 1 && text.ends_with('\n'));
    assert_eq!(folder.names(), ["old", "rows.csv", "scenario.toml"]);
}

/// Every verb that writes, with every kind of file that it writes.
const WRITING: &str = "
run scenario.toml --json run.json --csv run.csv --plot run.svg --report run.html
identify run.csv --json log.json --csv log-2.csv --plot log.png --report log.html --save-scenario log.toml
tune log.json --resonance inf --json tuned.json --report tuned.html --plot tuned.png
sweep scenario.toml --runs 2 --json sweep.json --csv sweep.csv --report sweep.html
compare compare.toml --json compare.json --report compare.html
commission axis.toml --json axis.json --csv axis.csv --plot axis.png --report axis.html
export log.json --format json --ratios --output joints.json
export log.json --format bam --ratios --output bam.json
export log.json --format urdf --ratios --output joints.urdf
export log.json --format mjcf --ratios --output joints.xml
export log.json --format isaac-lab --ratios --output joints.py
export run.json --firmware rust --output servo.rs
export run.json --firmware c --output servo.h
paper --out .
";

#[test]
fn a_second_call_replaces_the_files_of_the_first_and_no_other() {
    let folder = with_scenario("again", "5.0");
    folder.write("axis.toml", scenario_text("commission.toml"));
    let short = scenario_text("compare.toml").replace("60.0", "2.0");
    folder.write("compare.toml", short);
    let before = folder.names();
    for row in table(WRITING).iter().chain(&table(WRITING)) {
        folder.done(&row[0]);
    }
    let written: Vec<String> = (folder.names().into_iter())
        .filter(|name| !before.contains(name))
        .collect();
    assert_eq!(written.len(), 40, "{written:?}");
    for row in table(WRITING) {
        let words: Vec<&str> = row[0].split(' ').collect();
        let name = words.last().expect("a file");
        let name = if *name == "." { "figure-03.png" } else { name };
        folder.write(name, "name, the program's: servo-id\n1, 2\n");
        let message = folder.refused(&row[0]);
        assert!(
            message.contains(&format!("{name}: the file exists")),
            "{message}"
        );
        folder.done(&format!("{} --force", row[0]));
    }
}

#[test]
fn a_file_created_meanwhile_is_not_replaced() {
    let folder = with_scenario("meanwhile", "1000.0");
    let child = start(&folder, "servo-id run scenario.toml --json new");
    wait_for_temporary(&folder);
    folder.write("new", "precious");
    let message = ends(child, 1);
    assert!(message.contains("the file exists"), "{message}");
    assert_eq!(folder.read("new"), "precious");
    assert_eq!(folder.names(), ["new", "old", "scenario.toml"]);
}
