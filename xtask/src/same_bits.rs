//! One experiment on the emulated chip and on the PC, with the same bits.

use host_sim::scenario::{Arithmetic, Purpose, Scenario};
use host_sim::simulate;

use crate::command::root;
use crate::{emulator, firmware};

/// The scenario that the firmware's constants were made from.
const SCENARIO: &str = "host-sim/scenarios/paper.toml";

/// Runs the experiment on both.
pub(crate) fn check() -> Result<(), String> {
    let on_chip = emulator::run(emulator::BOARD, &firmware::bench("same", None)?)?;
    for arithmetic in [Arithmetic::F32, Arithmetic::Fixed] {
        let expected = on_pc(arithmetic)?;
        let name = arithmetic.name();
        let found = on_chip
            .lines()
            .find(|line| line.split_whitespace().next() == Some(name))
            .ok_or_else(|| format!("the chip prints no line {name}: {on_chip}"))?;
        if found.trim() != expected {
            return Err(format!(
                "{name}: the chip ends with\n  {}\nand the simulator with\n  {expected}\n(bits of \
                 a, b and load after {SCENARIO})",
                found.trim()
            ));
        }
        println!("{name}: the chip's estimates after 60 s are the simulator's, bit for bit");
    }
    Ok(())
}

fn on_pc(arithmetic: Arithmetic) -> Result<String, String> {
    let mut scenario =
        Scenario::load(&root().join(SCENARIO), Purpose::Run).map_err(|error| error.to_string())?;
    scenario.identifier.arithmetic = arithmetic;
    let mut last = None;
    simulate::run(&scenario, &mut |sample| last = Some(sample.estimates))
        .map_err(|error| format!("{SCENARIO}: {error}"))?;
    let last = last.ok_or("the simulator ran no sample")?;
    let [a, b, load] = [last.a, last.b, last.load].map(f64::to_bits);
    Ok(format!(
        "{} {a:016x} {b:016x} {load:016x}",
        arithmetic.name()
    ))
}
