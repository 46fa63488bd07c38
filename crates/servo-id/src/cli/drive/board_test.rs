//! `servo-id drive board-test`: what the drive's chip computes, and how fast, as a file that a person can send.

use std::path::PathBuf;

use drive_link::{Cycles, InterruptCycles, PROTOCOL, Status};
use drive_logic::{BOARD_TEST_INSTRUCTIONS, self_test};
use serde::Serialize;

use super::status::{NOT_MEASURED, interrupt_line};
use crate::cli::fault::Fault;
use crate::cli::files::{self, Files};
use crate::cli::standard_output::show;
use crate::drive::Client;
use crate::program::VERSION;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Write the result as JSON to this file, to be sent; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace what this program did not write, too.
    #[arg(long)]
    force: bool,
}

/// The result; its fields are the keys.
#[derive(Debug, Serialize)]
struct Tested<'a> {
    program: &'static str,
    protocol: u8,
    board: &'a str,
    servo_on_chip: bool,
    /// Bits of a, b and Coulomb friction as doubles, in hexadecimal digits.
    bits: [String; 3],
    expected_bits: [String; 3],
    same_bits: bool,
    sample_cycles: Option<Cycles>,
    sample_instructions: Cycles,
    interrupt_cycles: Option<InterruptCycles>,
    resets_in_time: bool,
    image_checked: bool,
}

impl Arguments {
    pub(super) fn run(&self, client: &mut Client, status: &Status) -> Result<(), Fault> {
        let mut files = Files::reading(&[], self.force);
        let json = files.output(self.json.as_deref())?;
        let test = client.board_test()?;
        let (own, _) = self_test("", || 0);
        let [mean, most] = BOARD_TEST_INSTRUCTIONS;
        let digits = |bits: [u64; 3]| bits.map(|bits| format!("{bits:016x}"));
        let tested = Tested {
            program: VERSION,
            protocol: PROTOCOL,
            board: &test.board,
            servo_on_chip: test.servo_on_chip,
            bits: digits(test.bits),
            expected_bits: digits(own.bits),
            same_bits: test.bits == own.bits,
            sample_cycles: test.cycles,
            sample_instructions: Cycles { mean, most },
            interrupt_cycles: status.interrupt_cycles,
            resets_in_time: status.boot.resets_in_time,
            image_checked: status.boot.image_checked,
        };
        files::commit([json.map(|json| json.document(&tested))])?;
        if !files.own_standard_output() {
            print(&tested, status)?;
        }
        if tested.same_bits {
            return Ok(());
        }
        Err(Fault::Other(format!(
            "the drive computes {} where this machine computes {}: flash the firmware of this program's version; if it \
             stays so, replace the chip",
            tested.bits.join(" "),
            tested.expected_bits.join(" ")
        )))
    }
}

fn print(tested: &Tested<'_>, status: &Status) -> Result<(), Fault> {
    let servo = if tested.servo_on_chip {
        ", which simulates its servo"
    } else {
        ""
    };
    show!("board: {}{servo}", tested.board)?;
    if tested.same_bits {
        show!("bits: those of this machine, {}", tested.bits.join(" "))?;
    }
    let Cycles { mean, most } = tested.sample_instructions;
    match tested.sample_cycles {
        Some(cycles) => show!(
            "a sample: {} cycles in the mean, {} at most, for {mean} and {most} instructions: {:.2} cycles each",
            cycles.mean,
            cycles.most,
            f64::from(cycles.mean) / f64::from(mean)
        )?,
        None => {
            show!("a sample of {mean} instructions in the mean, {most} at most: {NOT_MEASURED}")?;
        }
    }
    show!("sample interrupt: {}", interrupt_line(status))
}
