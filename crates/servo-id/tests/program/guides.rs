//! Every command that README and pages show is run as it is printed, in a folder of its own for each page, and every
//! output that they show is compared with the output of the commands.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::support::pages::{assert_block_is_printed, root};
use crate::support::simulated_drive::{SERVO, SimulatedDrive, built_in};
use crate::support::{Folder, folder, standard_error};
use drive_link::Estimator;
use rayon::prelude::*;

/// Commands that are not run here, each with the reason. One that no page shows any more is an error.
const ELSEWHERE: &str = "
cargo install | builds everything anew; what it installs is run here
(cd firmware-stm32 && cargo | is for a board: CI builds it and boots it in an emulator
mdbook build | takes mdBook: a test reads the book's contents
servo-id identify emps_train | takes the measured log: its tests run where it is
pip install | builds the package: its own tests do
python -m servo_id | takes the package: its own tests run it
cargo test | runs every test: CI does
cargo xtask | takes an emulator: CI does
servo-id drive simulate | runs until it is interrupted: the tests of the monitor run it
servo-id drive --port tcp:127.0.0.1:5760 monitor | takes a terminal: the tests of the monitor type into one";

/// Files that a reader has: their names on a page, and the commands that make them.
const READERS: &str = "
axis.toml | cp host-sim/scenarios/friction.toml axis.toml
monday.csv | servo-id run axis.toml --quiet --csv monday.csv
tuesday.csv | servo-id run axis.toml --quiet --csv tuesday.csv
wednesday.csv | servo-id run axis.toml --quiet --csv wednesday.csv
result.json | servo-id run axis.toml --quiet --json result.json
my-servo.toml | cp host-sim/scenarios/drive.toml my-servo.toml";

/// The two cells of each row.
fn rows(table: &'static str) -> impl Iterator<Item = (&'static str, &'static str)> {
    table.lines().filter_map(|row| row.split_once(" | "))
}

/// The blocks of one language of a page, as they are printed; those without a language are output.
fn blocks(page: &Path, language: &str) -> Vec<String> {
    let text = fs::read_to_string(page).expect("a page");
    let mut blocks = Vec::new();
    let mut block: Option<String> = None;
    let mut is_wanted = false;
    for line in text.lines().map(str::trim_start) {
        match (line.strip_prefix("```"), &mut block) {
            (Some(label), None) => {
                block = Some(String::new());
                is_wanted = label == language;
            }
            (Some(_), Some(_)) => blocks.extend(block.take().filter(|_| is_wanted)),
            (None, Some(block)) => *block += &format!("{line}\n"),
            _ => {}
        }
    }
    blocks
}

/// The lines of a block that are run here; lines that are shown and not run are noted.
fn runnable(block: &str, shown: &mut Vec<&str>) -> String {
    let is_run = |line: &&str| {
        let elsewhere = rows(ELSEWHERE).find(|(begin, _)| line.starts_with(begin));
        shown.extend(elsewhere.map(|(begin, _)| begin));
        elsewhere.is_none()
    };
    let lines = block.replace("\\\n", " ");
    lines
        .lines()
        .filter(is_run)
        .map(|line| format!("{line}\n"))
        .collect()
}

/// A folder in which the project's own lie, and where `cargo run` and `servo-id` are the programs of this build.
fn reader(name: &str) -> Folder {
    let folder = folder(&format!("guides-{name}"));
    for own in ["host-sim", "docs", "firmware-stm32"] {
        symlink(root().join(own), folder.join(own)).expect("a link");
    }
    let bin = folder.join("bin");
    fs::create_dir(&bin).expect("a folder");
    symlink(env!("CARGO_BIN_EXE_servo-id"), bin.join("servo-id")).expect("a link");
    let cargo = format!(
        "#!/bin/sh\ncase \"$*\" in\n'run --release') exec '{0}' ;;\n\
         'run --release -- '*) shift 3; exec '{0}' \"$@\" ;;\nesac\n\
         echo \"no test runs: cargo $*\" >&2; exit 97\n",
        env!("CARGO_BIN_EXE_servo-id")
    );
    fs::write(bin.join("cargo"), cargo).expect("a script");
    fs::set_permissions(bin.join("cargo"), fs::Permissions::from_mode(0o755)).expect("a script");
    folder
}

/// Runs commands; their output, or their error.
fn shell(folder: &Path, commands: &str) -> Result<String, String> {
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("bash")
        .args(["-euc", commands])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", folder.join("bin").display()))
        // As in the terminal of a page.
        .env("COLUMNS", "100")
        .stdin(Stdio::null())
        .output()
        .expect("bash is there");
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(standard_error(&output)),
    }
}

/// The port of a drive on pages.
const PORT: &str = "/dev/ttyUSB0";

/// A drive that was never configured.
fn drive() -> SimulatedDrive {
    let drive = SimulatedDrive::start(SERVO, built_in(Estimator::GaussNewton));
    drive.with(|around| around.supply = true);
    drive
}

/// Pages whose commands and output other tests run and compare.
const TESTED_ELSEWHERE: [&str; 2] = ["comparison.md", "guide-c.md"];

/// The commands of this file of `docs` are run.
fn is_run(file: &Path) -> bool {
    let is_page = file.extension().is_some_and(|kind| kind == "md");
    is_page && !TESTED_ELSEWHERE.iter().any(|other| file.ends_with(other))
}

/// Writes the files that a page shows with their names in the first line.
fn write_shown(page: &Path, folder: &Path) {
    for text in blocks(page, "toml") {
        let name = text.lines().next().and_then(|line| line.strip_prefix("# "));
        if let Some(name) = name.filter(|name| name.ends_with(".toml") && !name.contains(' ')) {
            fs::write(folder.join(name), &text).expect("written");
        }
    }
}

/// What came of the commands of a page.
#[derive(Default)]
struct Followed {
    /// Lines that were run, and outputs that were compared.
    run: usize,
    compared: usize,
    /// Commands that are run elsewhere.
    shown: Vec<&'static str>,
    failed: Vec<String>,
}

fn follow(page: &Path) -> Followed {
    let mut followed = Followed::default();
    let name = page.file_stem().unwrap_or_default().to_string_lossy();
    let folder = reader(&name);
    write_shown(page, &folder);
    let mut printed = String::new();
    let commands = blocks(page, "sh");
    let is_of_drive = commands.iter().any(|block| block.contains(PORT));
    let drive = is_of_drive.then(drive);
    for block in commands {
        // A longer link timeout: this machine may be busy.
        let commands = runnable(&block, &mut followed.shown)
            .replace(PORT, drive.as_ref().map_or(PORT, |drive| &drive.port))
            .replace(
                "configure my-servo.toml",
                "configure my-servo.toml --link-timeout 20",
            );
        // Files that a block reads but does not write are made for it.
        for (file, make) in rows(READERS) {
            if commands.contains(file)
                && !commands.contains(&format!("> {file}"))
                && !commands.contains(&format!("--json {file}"))
                && !folder.join(file).exists()
            {
                let scenario =
                    "test -e axis.toml || cp host-sim/scenarios/friction.toml axis.toml\n";
                shell(&folder, &format!("{scenario}{make}")).expect("what a reader has");
            }
        }
        followed.run += commands.lines().count();
        match shell(&folder, &commands) {
            Ok(output) => printed += &output,
            Err(why) => {
                let why = format!("{}:\n{commands}{why}", page.display());
                followed.failed.push(why);
            }
        }
    }
    for output in blocks(page, "") {
        let words = output
            .trim_start()
            .split_inclusive(' ')
            .next()
            .expect("it has a word");
        assert_block_is_printed(page, words, &printed);
        followed.compared += 1;
    }
    followed
}

#[test]
fn every_command_of_readme_and_pages_works_as_it_is_printed() {
    let guides = fs::read_dir(root().join("docs")).expect("a folder");
    let mut pages: Vec<PathBuf> = guides
        .map(|entry| entry.expect("an entry").path())
        .filter(|page| is_run(page))
        .collect();
    pages.push(root().join("README.md"));
    // A drive is waited for in real time.
    let all: Vec<Followed> = pages.par_iter().map(|page| follow(page)).collect();
    let failed: Vec<&str> = all
        .iter()
        .flat_map(|page| &page.failed)
        .map(String::as_str)
        .collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    let run: usize = all.iter().map(|page| page.run).sum();
    let compared: usize = all.iter().map(|page| page.compared).sum();
    assert!(run > 60 && compared > 0, "{run} lines, {compared} outputs");
    for (begin, why) in rows(ELSEWHERE) {
        assert!(
            all.iter().any(|page| page.shown.contains(&begin)),
            "no page shows {begin}, which is left out: {why}"
        );
    }
}

#[test]
fn ci_calls_the_test_command_of_the_readme() {
    let readme = blocks(&root().join("README.md"), "sh").concat();
    let command = readme.lines().find(|line| line.starts_with("cargo test"));
    let command = command.expect("the README has a command that tests");
    let ci = fs::read_to_string(root().join(".ci/run")).expect("a script");
    let step = format!("step {command}");
    assert!(
        ci.lines().any(|line| line == step),
        "no `{step}` in .ci/run"
    );
}

#[test]
fn the_manual_of_the_drive_shows_no_output_that_no_test_compares() {
    let shown = blocks(&root().join("firmware-stm32/README.md"), "");
    assert!(shown.is_empty(), "{}", shown.join("\n"));
}
