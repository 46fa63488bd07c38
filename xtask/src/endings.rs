//! The ends of a program on an emulated chip: each must disable the output first.

use crate::{emulator, firmware};

/// The ends by the numbers by which the program chooses them.
const ENDS: [(u32, &str); 4] = [
    (1, "a hard fault"),
    (2, "an overflow of the stack"),
    (3, "a failed oscillator"),
    (4, "an interrupt without a handler"),
];

/// The word of the memory that chooses one.
const CHOICE: &str = "0x2001fffc";

/// Ends a program that drives its output in every way.
pub(crate) fn check() -> Result<(), String> {
    let bench = firmware::bench("endings", None)?;
    for (number, name) in ENDS {
        let device = format!("loader,addr={CHOICE},data={number},data-len=4");
        let printed = emulator::run_with(emulator::BOARD, &bench, &["-device", &device])
            .map_err(|error| format!("{name} leaves the output driven: {error}"))?;
        if printed.trim() != "disabled" {
            return Err(format!("{name} ends in {printed:?}"));
        }
        println!("{name} disables the output first");
    }
    Ok(())
}
