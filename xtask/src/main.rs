//! What CI and people do with the firmware besides building it.

mod budget;
mod drive;
mod elf;
mod elsewhere;
mod emulator;
mod firmware;
mod interrupt;
mod listing;
mod mutations;
mod same_bits;
mod soak;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run the virtual servo on an emulated STM32F405 and hold its bits against the simulator's.
    Same,
    /// Run the drive firmware on an emulated STM32F405 for hours of its time, every sample shown.
    Soak {
        /// Hours.
        #[arg(long, default_value_t = 2.0)]
        hours: f64,
    },
    /// Talk to the drive firmware on an emulated STM32F405.
    Drive,
    /// Count instructions and bytes on the emulated chip and hold them against the recorded budget.
    Budget {
        /// Record what was counted as the budget.
        #[arg(long)]
        accept: bool,
    },
    /// Count the whole sample interrupt of the drive on the emulated chip: instructions as they are
    /// executed, and cycles by the model of docs/cycles.md.
    Interrupt,
    /// Break the chip's drivers in one place after the other, in a copy, and see that their tests
    /// notice.
    Mutations,
    /// Build two firmwares of somebody else for three cores, run them on two emulated boards, and
    /// count a sample.
    Elsewhere,
    /// Run a binary of the firmware in the emulator.
    Qemu {
        /// The binary: virtual-servo or bench.
        binary: String,
    },
}

fn main() -> ExitCode {
    let done = match Arguments::parse().verb {
        Verb::Same => same_bits::check(),
        Verb::Drive => drive::check(),
        Verb::Soak { hours } => soak::check(hours),
        Verb::Interrupt => interrupt::print(),
        Verb::Mutations => mutations::check(),
        Verb::Elsewhere => elsewhere::check(),
        Verb::Budget { accept } => budget::check(accept),
        Verb::Qemu { binary } => firmware::build(&[&binary], &[])
            .and_then(|()| emulator::run(&firmware::path(&binary)))
            .map(|printed| print!("{printed}")),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("error: {fault}");
            ExitCode::FAILURE
        }
    }
}
