//! What a sample and a binary cost, against what was accepted.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::firmware::Paths;
use crate::{emulator, firmware};

/// The budget, beside the firmware.
const FILE: &str = "firmware-stm32/budget.toml";

/// By how much a figure may rise unnoticed.
const TOLERANCE: f64 = 0.02;

/// Counts and compares; with `accept` records instead.
pub(crate) fn check(accept: bool) -> Result<(), String> {
    firmware::build(&[])?;
    let counted = count()?;
    let path = firmware::root().join(FILE);
    if accept {
        let mut text = String::from(
            "# Counted on the emulated chip; `cargo xtask budget --accept` records it anew.\n",
        );
        for (name, value) in &counted {
            writeln!(text, "{name} = {value}").map_err(|error| error.to_string())?;
        }
        return std::fs::write(&path, text)
            .map_err(|error| format!("{} cannot be written: {error}", path.display()));
    }
    let budget = accepted()?;
    let mut over = Vec::new();
    for (name, &value) in &counted {
        let accepted = budget.get(name).copied();
        println!(
            "{name:<32} {value:>7}  (accepted: {})",
            accepted.map_or_else(|| "none".to_owned(), |accepted| accepted.to_string())
        );
        let most = accepted.unwrap_or(0) as f64 * (1.0 + TOLERANCE);
        if value as f64 > most {
            over.push(name.as_str());
        }
    }
    if over.is_empty() {
        Ok(())
    } else {
        Err(format!(
            "more than 2 % above {FILE}: {}; make it cheaper, or `cargo xtask budget --accept` if \
             that is what it takes",
            over.join(", ")
        ))
    }
}

/// The budget.
pub(crate) fn accepted() -> Result<BTreeMap<String, u64>, String> {
    let path = firmware::root().join(FILE);
    let text =
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Name and figure: instructions a sample, bytes of state, flash, static memory and stack.
fn count() -> Result<BTreeMap<String, u64>, String> {
    let printed = emulator::run(&firmware::path("bench"))?;
    let mut counted = BTreeMap::new();
    for line in printed.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [name, mean, most, state] = words[..] else {
            return Err(format!("the bench printed a line that is none: {line}"));
        };
        for (what, figure) in [("mean", mean), ("most", most), ("state-bytes", state)] {
            let figure = figure.parse().map_err(|error| format!("{line}: {error}"))?;
            counted.insert(format!("{name}-{what}"), figure);
        }
    }
    for binary in ["virtual-servo", "bench", "drive", "pil"] {
        let (flash, memory) = firmware::sizes(&firmware::path(binary))?;
        counted.insert(format!("{binary}-flash-bytes"), flash);
        counted.insert(format!("{binary}-memory-bytes"), memory);
    }
    let Paths { stack, loops } = firmware::paths(&firmware::path("drive"))?;
    counted.insert("drive-stack-bytes".to_owned(), stack);
    counted.insert("drive-sample-loops".to_owned(), loops);
    Ok(counted)
}
