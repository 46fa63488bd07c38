//! The examples: they build for three cores and run on two emulated boards, and a sample costs as much there
//! as in the bench.

use std::path::PathBuf;

use crate::elf::Elf;
use crate::{budget, emulator, firmware};

/// Each is a workspace of its own in the folder of its name: one with this project's PID, and one with a
/// controller of its own, beside which the identifier observes.
const FIRMWARES: [&str; 2] = ["own-firmware", "own-cascade"];

/// Their targets, and the board of each that is emulated.
const TARGETS: [(&str, Option<&str>); 3] = [
    ("thumbv6m-none-eabi", Some("microbit")),
    ("thumbv7em-none-eabihf", Some(emulator::BOARD)),
    ("thumbv8m.main-none-eabihf", None),
];

/// The firmware that counts the instructions of its sample, the target that it counts on, and the
/// figure of the budget that it is compared with.
const COUNTS: (&str, &str, &str) = (
    "own-firmware",
    "thumbv7em-none-eabihf",
    "gradient-f32-2-mean",
);

/// Relative cost of a sample above the bench's that is allowed.
const TOLERANCE: f64 = 0.05;

/// Firmwares on an operating system, each of which has more to build than all that CI builds for a chip.
const ON_SYSTEMS: [&str; 2] = ["own-embassy", "own-rtic"];

/// Builds and runs those on an operating system.
pub(crate) fn check_on_systems() -> Result<(), String> {
    let (_, target, _) = COUNTS;
    for name in ON_SYSTEMS {
        emulator::run(emulator::BOARD, &build(name, target, &[], &[])?)?;
        println!(
            "{name}, {target}: builds, and finds its servo on an emulated {}",
            emulator::BOARD
        );
    }
    Ok(())
}

/// The example whose loop is constants.
const OF_CONSTANTS: &str = "own-constants";

/// Its loops: features, and the most flash that each may take at either optimiser level, bytes, where there is a bound.
const LOOPS: [(&[&str], Option<u64>); 5] = [
    (&[], Some(4096)),
    (&["friction"], None),
    (&["fixed-point"], Some(4096)),
    (&["fixed-point", "friction"], None),
    (&["gauss-newton"], Some(12_288)),
];

/// Checks that a loop of constants has the bits of the one that the chip builds itself, and prints the flash that each
/// takes.
pub(crate) fn check_constants() -> Result<(), String> {
    let (_, target, _) = COUNTS;
    for (features, _) in LOOPS {
        let compared = [features, &["compare"]].concat();
        emulator::run(
            emulator::BOARD,
            &build(OF_CONSTANTS, target, &compared, &[])?,
        )?;
    }
    println!(
        "flash of the loop alone, bytes: as constants at 3 and \"s\", built by the chip at 3 and \"s\""
    );
    for (features, bound) in LOOPS {
        let mut row = Vec::new();
        for own in [&[][..], &["built"]] {
            for level in ["3", "\"s\""] {
                let level = format!("profile.release.opt-level={level}");
                let flash = |features: &[&str]| {
                    let binary = build(OF_CONSTANTS, target, features, &["--config", &level])?;
                    Elf::read(&binary).map(|read| read.flash)
                };
                row.push(flash(&[features, own].concat())?.saturating_sub(flash(&["empty"])?));
            }
        }
        let name = [&["loop"], features].concat().join(", ");
        if let (Some(bound), [at_3, at_s, ..]) = (bound, &row[..])
            && (*at_3).max(*at_s) > bound
        {
            return Err(format!(
                "{name}: {at_3} and {at_s} bytes, at most {bound} are allowed"
            ));
        }
        println!("{name}: {row:?}");
    }
    Ok(())
}

/// Builds and runs them.
pub(crate) fn check() -> Result<(), String> {
    FIRMWARES.into_iter().try_for_each(check_one)?;
    count()
}

/// Counts a sample in an example.
fn count() -> Result<(), String> {
    let (name, target, figure) = COUNTS;
    let budget = budget::accepted()?;
    let accepted = *budget
        .get(figure)
        .ok_or_else(|| format!("the budget has no {figure}"))?;
    let binary = build(name, target, &["count"], &[])?;
    let printed = emulator::run(emulator::BOARD, &binary)?;
    let counted: u64 = printed
        .trim()
        .parse()
        .map_err(|error| format!("{name} counted {printed:?}: {error}"))?;
    if counted as f64 > accepted as f64 * (1.0 + TOLERANCE) {
        return Err(format!(
            "a sample of {name} takes {counted} instructions, more than 5 % above the bench's \
             {accepted}"
        ));
    }
    println!("{name}: a sample takes {counted} instructions; in the bench, {accepted}");
    Ok(())
}

fn check_one(name: &str) -> Result<(), String> {
    for (target, board) in TARGETS {
        let binary = build(name, target, &[], &[])?;
        let Some(board) = board else {
            println!("{name}, {target}: builds");
            continue;
        };
        emulator::run(board, &binary)?;
        println!("{name}, {target}: builds, and finds its servo on an emulated {board}");
    }
    Ok(())
}

/// Builds one and returns its binary.
fn build(name: &str, target: &str, features: &[&str], more: &[&str]) -> Result<PathBuf, String> {
    let folder = firmware::root().join("examples").join(name);
    Ok(firmware::build_example(&folder, target, features, more)?.join(name))
}
