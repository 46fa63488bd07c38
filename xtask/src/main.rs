//! Checks of the firmware on emulated chips, and its costs.

mod budget;
mod command;
mod drive;
mod elf;
mod emulator;
mod endings;
mod examples;
mod firmware;
mod interrupt;
mod lead;
mod listing;
mod meter;
mod metered;
mod playground;
mod python;
mod register_calls;
mod release;
mod same_bits;
mod seal;
mod soak;
mod thumb;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run the paper's experiment on an emulated STM32F405 and compare its bits with the simulator's.
    Same,
    /// Run the drive firmware on an emulated STM32F405 for hours of its time, with every sample sent to the
    /// host.
    Soak {
        /// Hours of the drive's time.
        #[arg(long, default_value_t = 2.0)]
        hours: f64,
    },
    /// Build the drive firmware for a board and seal it: it checks itself when it boots.
    Image {
        /// The board.
        #[arg(long, default_value = "nucleo-f446re")]
        board: String,
    },
    /// Operate the drive firmware on an emulated STM32F405: records, runs, faults, commissioning, ends of the program.
    Drive,
    /// Count instructions and bytes on the emulated chip and compare them with the accepted budget. Every command of
    /// a commissioning at 1, 10 and 20 kHz must be out within 12.5 µs of its sample; half of every sample of a run, and of a
    /// commissioning up to 10 kHz, must be free.
    Budget {
        /// Accept the figures as the budget.
        #[arg(long)]
        accept: bool,
    },
    /// Build the examples for three cores, and run them on two emulated boards.
    Examples,
    /// Build the playground: one page that runs the core and the virtual servo in a browser, from a file, without a
    /// server.
    Playground {
        /// The folder of its index.html; target/playground by default.
        #[arg(long)]
        out: Option<std::path::PathBuf>,
    },
    /// Build the Python package's wheel, install it in an environment of its own, and run its tests.
    Python,
    /// Build everything that is handed out into target/release-artefacts, and try each part in an empty folder.
    Release,
    /// Run a part of the firmware's bench in the emulator.
    Bench {
        /// The part: same, samples, terms, commission, turns or rivals.
        part: String,
        /// The optimiser level, 3 or s; that of the drive by default.
        #[arg(long, value_parser = ["3", "s"])]
        level: Option<String>,
    },
}

fn main() -> ExitCode {
    let done = match Arguments::parse().verb {
        Verb::Same => same_bits::check(),
        Verb::Image { board } => firmware::image(&board),
        Verb::Drive => drive::check().and_then(|()| endings::check()),
        Verb::Soak { hours } => soak::check(hours),
        Verb::Examples => examples::check(),
        Verb::Budget { accept } => budget::check(accept),
        Verb::Playground { out } => {
            playground::build(&out.unwrap_or_else(playground::usual_folder))
        }
        Verb::Python => python::check(),
        Verb::Release => release::make(),
        Verb::Bench { part, level } => firmware::bench(&part, firmware::level(level.as_deref()))
            .and_then(|bench| emulator::run(emulator::BOARD, &bench))
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
