//! The examples: they build for three cores and run on two emulated boards.

use crate::elf::Elf;
use crate::{emulator, firmware};

/// Their packages and binaries without an operating system. They have this project's PID, built by the chip or by its
/// build script. Or they have their own controller, and the identifier observes it.
const FIRMWARES: [[&str; 2]; 3] = [
    ["firmware", "firmware"],
    ["firmware", "constants"],
    ["cascade", "cascade"],
];

/// Their targets, and the board of each that is emulated.
const TARGETS: [(&str, Option<&str>); 3] = [
    ("thumbv6m-none-eabi", Some("microbit")),
    (firmware::TARGET, Some(emulator::BOARD)),
    ("thumbv8m.main-none-eabihf", None),
];

/// The one on an operating system, for one core.
const ON_A_SYSTEM: [&str; 2] = ["embassy", "embassy"];

/// Builds and runs them.
pub(crate) fn check() -> Result<(), String> {
    for (target, board) in TARGETS {
        for name in FIRMWARES {
            check_one(name, target, board)?;
        }
    }
    check_one(ON_A_SYSTEM, firmware::TARGET, Some(emulator::BOARD))
}

fn check_one([package, name]: [&str; 2], target: &str, board: Option<&str>) -> Result<(), String> {
    let binary = firmware::build_example(package, name, target)?;
    let Elf { flash, .. } = Elf::read(&binary)?;
    let found = match board {
        None => String::new(),
        Some(board) => {
            emulator::run(board, &binary)?;
            format!(", and finds its servo on an emulated {board}")
        }
    };
    println!("{name}, {target}: {flash} bytes of flash{found}");
    Ok(())
}
