//! Builds the library for C: an archive with one object that has only the functions of the header. Or builds the folder
//! of an Arduino library.

mod archive;
mod build;
mod files;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo c-library [--target TARGET]... [--out FOLDER] [--arduino]

Builds libservo_id.a for this machine or for TARGET, and writes it with header and CMake file into FOLDER (target/c).
With --arduino FOLDER/ServoId is a library of the Arduino IDE for Cortex-M0+, M4F and M33.

Tested targets: thumbv6m-none-eabi, thumbv7em-none-eabihf, thumbv8m.main-none-eabihf, riscv32imac-unknown-none-elf.";

/// The arguments of the command line.
#[derive(Debug, Default)]
struct Arguments {
    targets: Vec<String>,
    out: Option<PathBuf>,
    arduino: bool,
}

impl Arguments {
    fn read(words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut read = Self::default();
        let mut words = words;
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value\n{USAGE}"));
            match word.as_str() {
                "--target" => read.targets.push(value()?),
                "--out" => read.out = Some(value()?.into()),
                "--arduino" => read.arduino = true,
                _ => return Err(USAGE.to_owned()),
            }
        }
        Ok(read)
    }
}

fn run() -> Result<(), String> {
    let arguments = Arguments::read(std::env::args().skip(1))?;
    let out = arguments.out.unwrap_or_else(|| build::folder().join("c"));
    if arguments.arduino {
        return files::arduino(&out);
    }
    let targets = match arguments.targets.as_slice() {
        [] => vec![build::this_machine()?],
        targets => targets.to_vec(),
    };
    for target in targets {
        files::library(&target, &out)?;
    }
    Ok(())
}

/// The folder of this package.
fn own() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("error: {fault}");
            ExitCode::FAILURE
        }
    }
}
