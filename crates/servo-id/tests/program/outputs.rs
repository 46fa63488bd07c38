//! Outputs are safe: complete or absent, nothing replaced without `--force`, refused before any work.

use std::fs::{self, OpenOptions};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::support::{assert_done, folder, folder_with_paper, refusal_message, standard_error};

/// A folder with a scenario of this duration, s.
fn with_scenario(test: &str, duration: &str) -> PathBuf {
    folder_with_paper(&format!("outputs-{test}"), duration)
}

fn program(folder: &Path, words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_servo-id"));
    command
        .current_dir(folder)
        .args(words.split_whitespace())
        .stdin(Stdio::null());
    command
}

fn call(folder: &Path, words: &str) -> Output {
    program(folder, words).output().expect("the program starts")
}

/// The call is refused as bad input, with this part of a message, and no file has come or changed.
fn assert_refused(folder: &Path, words: &str, message: &str) {
    let before = listing(folder);
    let answer = refusal_message(&call(folder, words));
    assert!(answer.contains(message), "{words}: {answer}");
    assert_eq!(listing(folder), before, "{words}");
}

/// Every name of a folder with its content.
fn listing(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .map(|path| {
            let text = if path.is_file() {
                fs::read(&path).expect("a file")
            } else {
                Vec::new()
            };
            (path, text)
        })
        .collect();
    found.sort();
    found
}

fn names(folder: &Path) -> Vec<String> {
    listing(folder)
        .iter()
        .filter_map(|(path, _)| Some(path.file_name()?.to_string_lossy().into_owned()))
        .collect()
}

/// For a call that would take at least a minute if it were not refused.
fn long(test: &str) -> PathBuf {
    with_scenario(test, "10000.0")
}

#[test]
fn an_existing_file_requires_force() {
    let folder = with_scenario("force", "1.0");
    fs::write(folder.join("old"), "precious").expect("written");
    for verb in ["run", "compare", "sweep --runs 1"] {
        assert_refused(
            &folder,
            &format!("{verb} scenario.toml --json old"),
            "--force",
        );
    }
    assert_done(&call(&folder, "run scenario.toml --json old --force"));
    let text = fs::read_to_string(folder.join("old")).expect("written");
    assert!(text.starts_with('{') && text.ends_with("}\n"), "{text}");
    assert_eq!(names(&folder), ["old", "scenario.toml"]);
}

#[test]
fn refusals_come_before_any_work() {
    let folder = long("before");
    fs::write(folder.join("old"), "precious").expect("written");
    let begun = Instant::now();
    assert_refused(&folder, "run scenario.toml --csv new --json old", "--force");
    assert_refused(
        &folder,
        "run scenario.toml --json no/such/place",
        "no such folder",
    );
    assert_refused(&folder, "run scenario.toml --json old/place", "is a file");
    assert_refused(&folder, "run scenario.toml --json .", "a folder");
    assert_refused(
        &folder,
        "run scenario.toml --plot picture.gif",
        ".png or .svg",
    );
    assert!(begun.elapsed() < Duration::from_secs(20), "{begun:?}");
}

#[test]
fn an_output_is_no_input_under_any_name() {
    let folder = long("input");
    fs::create_dir(folder.join("sub")).expect("a folder");
    symlink("scenario.toml", folder.join("link")).expect("a link");
    fs::hard_link(folder.join("scenario.toml"), folder.join("twin")).expect("a link");
    for name in ["scenario.toml", "./sub/../scenario.toml", "link", "twin"] {
        for option in ["--json", "--csv"] {
            let words = format!("run scenario.toml --force {option} {name}");
            assert_refused(&folder, &words, "this file is an input");
        }
    }
    assert_refused(
        &folder,
        "run link --force --json scenario.toml",
        "this file is an input",
    );
    for name in ["logs/simulated-servo.csv.gz", "scenarios/replay.toml"] {
        let source = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../host-sim")
            .join(name);
        let name = source.file_name().expect("a name");
        fs::copy(&source, folder.join(name)).expect("copied");
    }
    for name in ["simulated-servo.csv.gz", "replay.toml"] {
        let words =
            format!("identify simulated-servo.csv.gz --scenario replay.toml --force --json {name}");
        assert_refused(&folder, &words, "this file is an input");
    }
}

#[test]
fn two_outputs_are_two_files() {
    let folder = long("twice");
    fs::create_dir(folder.join("sub")).expect("a folder");
    symlink("new", folder.join("link")).expect("a link");
    for name in ["new", "./new", "sub/../new", "link"] {
        let words = format!("run scenario.toml --json new --csv {name}");
        assert_refused(&folder, &words, "the same file as");
    }
    fs::write(folder.join("old"), "precious").expect("written");
    fs::hard_link(folder.join("old"), folder.join("twin")).expect("a link");
    assert_refused(
        &folder,
        "run scenario.toml --force --json old --csv twin",
        "the same file as",
    );
    for name in ["-", "/dev/stdout"] {
        let words = format!("run scenario.toml --json - --csv {name}");
        assert_refused(&folder, &words, "standard output");
    }
}

#[test]
fn a_link_is_followed_and_permissions_are_kept() {
    let folder = with_scenario("link", "1.0");
    fs::create_dir(folder.join("sub")).expect("a folder");
    for (link, target) in [("to-old", "sub/old"), ("to-new", "sub/new")] {
        symlink(target, folder.join(link)).expect("a link");
    }
    let old = folder.join("sub/old");
    fs::write(&old, "precious").expect("written");
    fs::set_permissions(&old, fs::Permissions::from_mode(0o640)).expect("permitted");
    assert_done(&call(
        &folder,
        "run scenario.toml --force --json to-old --csv to-new",
    ));
    for link in ["to-old", "to-new"] {
        let found = fs::symlink_metadata(folder.join(link)).expect("there");
        assert!(found.is_symlink(), "{link}");
    }
    let mode = |name: &str| fs::metadata(folder.join(name)).expect("there").mode() & 0o777;
    assert_eq!(mode("sub/old"), 0o640);
    // A new file has the permissions of any new file.
    assert_eq!(mode("sub/new"), mode("scenario.toml"));
    assert_eq!(names(&folder.join("sub")), ["new", "old"]);
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
    assert_done(&call(&folder, "run scenario.toml --json pipe"));
    assert!(fs::metadata(&pipe).expect("there").file_type().is_fifo());
    let text = reader.join().expect("read");
    assert!(text.starts_with('{') && text.ends_with("}\n"), "{text}");

    // Only after the pipe: root could replace /dev/null.
    assert_done(&call(
        &folder,
        "run scenario.toml --csv /dev/null --json /dev/null",
    ));
    let null = fs::metadata("/dev/null").expect("there");
    assert!(null.file_type().is_char_device());
}

#[test]
fn a_dash_is_standard_output_and_alone_there() {
    let folder = with_scenario("dash", "1.0");
    for (words, begin, end) in [
        ("run scenario.toml --json -", "{", "}\n"),
        ("run scenario.toml --json /dev/stdout", "{", "}\n"),
        ("run scenario.toml --csv -", "time_s,", "\n"),
        ("run scenario.toml --plot -", "<svg", "</svg>\n"),
        ("compare scenario.toml --json -", "{", "}\n"),
        ("sweep scenario.toml --runs 2 --csv -", "run,", "\n"),
    ] {
        let output = call(&folder, words);
        assert_done(&output);
        let text = String::from_utf8(output.stdout).expect("text");
        assert!(text.starts_with(begin), "{words}: {text:.80}");
        assert!(text.ends_with(end), "{words}");
        assert!(!text.contains('│'), "{words}: no table");
    }
    assert_eq!(names(&folder), ["scenario.toml"], "no file of the name -");
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
        let output = program(&folder, words).stdout(full()).output();
        let output = output.expect("the program starts");
        let message = standard_error(&output);
        assert_eq!(output.status.code(), Some(1), "{words}: {message}");
        assert!(message.contains("cannot be written"), "{words}: {message}");

        let mut child = program(&folder, words)
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
    fs::write(folder.join("old"), "precious").expect("written");
    // A file of more than 512 bytes is one too large.
    let script = format!(
        "trap '' XFSZ; ulimit -f 1; exec {} run scenario.toml --force --csv old",
        env!("CARGO_BIN_EXE_servo-id")
    );
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(&folder)
        .output()
        .expect("a shell");
    let message = standard_error(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("old cannot be written"), "{message}");
    assert_eq!(fs::read(folder.join("old")).expect("there"), b"precious");
    assert_eq!(names(&folder), ["old", "scenario.toml"]);
}

/// Starts a call as from a terminal, where no signal is ignored.
fn start(folder: &Path, words: &str) -> Child {
    Command::new("env")
        .args([
            "--default-signal=INT,TERM,HUP",
            env!("CARGO_BIN_EXE_servo-id"),
        ])
        .args(words.split_whitespace())
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

/// Starts a call as a shell starts a background job of a script, whose SIGINT is ignored.
fn start_in_background(folder: &Path, words: &str) -> Child {
    let script = format!(
        "trap '' INT; exec {} {words}",
        env!("CARGO_BIN_EXE_servo-id")
    );
    Command::new("env")
        .args(["--default-signal=TERM,HUP", "sh", "-c", &script])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

fn signal(child: &Child, name: &str) {
    let script = format!("kill -{name} {}", child.id());
    let sent = Command::new("sh").args(["-c", &script]).status();
    assert!(sent.expect("a shell").success());
}

/// Waits until a call has begun its file.
fn wait_for_temporary(folder: &Path) {
    let begun = Instant::now();
    while !names(folder)
        .iter()
        .any(|name| name.starts_with(".servo-id-"))
    {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "no file is begun"
        );
        thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn an_interruption_leaves_nothing_half_written() {
    let folder = with_scenario("interrupted", "20000.0");
    fs::write(folder.join("old"), "precious").expect("written");
    let before = listing(&folder);
    for (verb, name) in [("run", "INT"), ("run", "TERM"), ("compare", "INT")] {
        let words = format!("{verb} scenario.toml --json old --report new.html --force");
        let child = start(&folder, &words);
        wait_for_temporary(&folder);
        thread::sleep(Duration::from_millis(100));
        signal(&child, name);
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(130), "{words}");
        assert!(output.stdout.is_empty(), "{words}");
        assert_eq!(listing(&folder), before, "{words}");
    }
}

#[test]
fn a_background_job_that_ignores_ctrl_c_leaves_nothing_when_it_is_terminated() {
    let folder = with_scenario("interrupted-background", "20000.0");
    let before = listing(&folder);
    let mut child = start_in_background(&folder, "run scenario.toml --json new.json");
    wait_for_temporary(&folder);
    signal(&child, "INT");
    thread::sleep(Duration::from_millis(100));
    assert!(child.try_wait().expect("a child").is_none());
    signal(&child, "TERM");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130));
    assert_eq!(listing(&folder), before);
}

#[test]
fn an_interrupted_sweep_keeps_its_finished_runs() {
    let folder = with_scenario("interrupted-sweep", "1.0");
    let child = start(
        &folder,
        "sweep scenario.toml --runs 1000000 --threads 1 --csv rows.csv",
    );
    wait_for_temporary(&folder);
    thread::sleep(Duration::from_millis(500));
    signal(&child, "INT");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(1));
    let message = standard_error(&output);
    assert!(message.contains("of 1000000 servos"), "{message}");
    let text = fs::read_to_string(folder.join("rows.csv")).expect("kept");
    assert!(text.lines().count() > 1 && text.ends_with('\n'));
    assert_eq!(names(&folder), ["rows.csv", "scenario.toml"]);
}

#[test]
fn the_papers_own_folder_is_overwritten_and_any_other_requires_force() {
    let folder = folder("outputs-paper");
    for _ in 0..2 {
        assert_done(&call(&folder, "paper"));
    }
    assert_eq!(names(&folder.join("results/paper")).len(), 9);
    fs::write(folder.join("figure-03.png"), "precious").expect("written");
    assert_refused(&folder, "paper --out .", "--force");
    assert_refused(&folder, "paper --out figure-03.png", "exists");
    assert_done(&call(&folder, "paper --out . --force"));
    assert_eq!(names(&folder).len(), 10);
}

#[test]
fn a_file_created_meanwhile_is_not_replaced() {
    let folder = with_scenario("meanwhile", "1000.0");
    let child = start(&folder, "run scenario.toml --json new");
    wait_for_temporary(&folder);
    fs::write(folder.join("new"), "precious").expect("written");
    let output = child.wait_with_output().expect("it ends");
    let message = standard_error(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("the file exists"), "{message}");
    assert_eq!(fs::read(folder.join("new")).expect("there"), b"precious");
    assert_eq!(names(&folder), ["new", "scenario.toml"]);
}
