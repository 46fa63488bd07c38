//! Every command that README, guides and the pages of the verbs show is run as it is printed, in a folder
//! of its own.

#![cfg(target_os = "linux")]

#[path = "support/simulated_drive.rs"]
#[expect(dead_code, reason = "its shaft is free here")]
mod simulated_drive;
mod support;

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use drive_link::{Dither, Format, Law, LoopSettings, Protection, Settings};
use identifier_core::ControllerSettings;
use identifier_core::parameters::ServoParameters;
use simulated_drive::SimulatedDrive;
use support::{folder, standard_error};

/// What is not run here, each with the reason. One that no page shows any more is an error.
const ELSEWHERE: [(&str, &str); 6] = [
    ("cargo test", "checks everything: CI does"),
    (
        "cargo install",
        "builds everything anew; what it installs is run here",
    ),
    (
        "(cd firmware-stm32 && cargo run",
        "flashes a board: CI builds it and boots it in an emulator",
    ),
    ("cargo xtask", "takes an emulator: CI does"),
    (
        "servo-id drive simulate",
        "runs until it is interrupted: the tests of the monitor run it",
    ),
    (
        "servo-id drive --port tcp:127.0.0.1:5760 monitor",
        "takes a terminal: the tests of the monitor type into one",
    ),
];

/// Files that a reader has: what they are called on a page, and what makes them.
const READERS: [(&str, &str); 6] = [
    ("axis.toml", "cp host-sim/scenarios/friction.toml axis.toml"),
    (
        "monday.csv",
        "servo-id run axis.toml --quiet --csv monday.csv",
    ),
    (
        "tuesday.csv",
        "servo-id run axis.toml --quiet --csv tuesday.csv",
    ),
    (
        "wednesday.csv",
        "servo-id run axis.toml --quiet --csv wednesday.csv",
    ),
    (
        "result.json",
        "servo-id run axis.toml --quiet --json result.json",
    ),
    (
        "my-servo.toml",
        "cp host-sim/scenarios/drive.toml my-servo.toml",
    ),
];

fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.canonicalize().expect("the project's root")
}

/// The blocks of commands of a page, as they are printed.
fn blocks(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).expect("a page");
    let mut blocks = Vec::new();
    let mut block: Option<String> = None;
    for line in text.lines() {
        match (line, &mut block) {
            ("```sh", None) => block = Some(String::new()),
            ("```", Some(_)) => blocks.extend(block.take()),
            (line, Some(block)) => *block += &format!("{line}\n"),
            _ => {}
        }
    }
    blocks
}

/// The lines of a block that are run here; what is shown and not run is noted.
fn runnable(block: &str, shown: &mut Vec<&str>) -> String {
    let is_run = |line: &&str| {
        let elsewhere = ELSEWHERE.iter().find(|(begin, _)| line.starts_with(begin));
        shown.extend(elsewhere.map(|(begin, _)| begin));
        elsewhere.is_none()
    };
    block
        .lines()
        .filter(is_run)
        .map(|line| format!("{line}\n"))
        .collect()
}

/// A folder in which the project's own lie, and where `cargo run` and `servo-id` are the programs of this build.
fn reader(name: &str) -> PathBuf {
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

fn shell(folder: &Path, commands: &str) -> Result<(), String> {
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("bash")
        .args(["-euc", commands])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", folder.join("bin").display()))
        .stdin(Stdio::null())
        .output()
        .expect("bash is there");
    match output.status.success() {
        true => Ok(()),
        false => Err(standard_error(&output)),
    }
}

/// What a drive shows before anybody has told it anything.
fn drive() -> SimulatedDrive {
    let servo = ServoParameters {
        a: 0.2174,
        b: 257.7,
        coulomb: 5.0,
        load: 0.0,
    };
    let mut core = identifier_core::Settings {
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..identifier_core::Settings::new(1e-3, 10_000.0)
    };
    core.identifier.initial.b = Some(150.0);
    let drive = SimulatedDrive::start(
        servo,
        Settings {
            closed_loop: LoopSettings {
                core,
                law: Law::GaussNewton,
                format: Format::Single,
            },
            dither: Dither {
                amplitude: 0.3,
                hold: 0.05,
            },
            protection: Protection::OF_A_BARE_MOTOR,
        },
    );
    drive.with(|around| around.supply = true);
    drive
}

#[test]
fn every_command_of_readme_and_guides_works_as_it_is_printed() {
    let root = root();
    let guides = fs::read_dir(root.join("docs")).expect("a folder");
    let mut pages: Vec<PathBuf> = guides
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("guide-")
        })
        .collect();
    pages.extend(
        [
            "README.md",
            "docs/command-line.md",
            "docs/commissioning.md",
            "docs/tuning.md",
            "docs/terms.md",
        ]
        .map(|page| root.join(page)),
    );
    let (mut run, mut shown, mut failed) = (0, Vec::new(), Vec::new());
    for page in &pages {
        let name = page.file_stem().unwrap_or_default().to_string_lossy();
        let folder = reader(&name);
        let drive = drive();
        for block in blocks(page) {
            // A longer link timeout: this machine may be busy.
            let commands = runnable(&block, &mut shown)
                .replace("/dev/ttyUSB0", &drive.port)
                .replace(
                    "configure my-servo.toml",
                    "configure my-servo.toml --link-timeout 20",
                );
            // What a block does not write itself, it takes for granted.
            for (file, make) in READERS {
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
            run += commands.lines().count();
            if let Err(why) = shell(&folder, &commands) {
                failed.push(format!("{}:\n{commands}{why}", page.display()));
            }
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    assert!(run > 60, "{run} lines");
    for (begin, why) in ELSEWHERE {
        assert!(
            shown.contains(&begin),
            "no page shows {begin}, which is left out: {why}"
        );
    }
}
