//! Tables of the outcomes of many commissionings.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use identifier_core::commission::Reason;

use super::judged::{Judged, OVERSHOOT, RISE};

/// Outcomes of the servos of a class.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub(super) servos: usize,
    pub(super) refused: usize,
    pub(super) applied: usize,
    pub(super) kept: usize,
    pub(super) rise: usize,
    pub(super) overshoot: usize,
    pub(super) broken: usize,
    /// By reason, those that were not applied.
    pub(super) reasons: BTreeMap<u8, usize>,
    /// Durations of those that were applied, s.
    duration: f64,
}

impl Tally {
    /// Adds a servo whose commissioning was refused before anything moved.
    pub(super) fn refuse(&mut self) {
        self.servos += 1;
        self.refused += 1;
    }

    /// Takes in a commissioning.
    pub(super) fn add(&mut self, judged: &Judged) {
        self.servos += 1;
        self.broken += usize::from(!judged.broken.is_empty());
        if let Some(reason) = judged.outcome.reason() {
            *self.reasons.entry(reason.number()).or_default() += 1;
        }
        if let Some(kept) = &judged.kept {
            self.applied += 1;
            self.kept += usize::from(kept.is_kept());
            self.rise += usize::from(kept.rise.abs() <= RISE);
            self.overshoot += usize::from(kept.overshoot <= OVERSHOOT);
            self.duration += judged.outcome.end.map_or(0.0, |end| end.time);
        }
    }

    /// The part of those that could be commissioned.
    pub(super) fn applied_part(&self) -> f64 {
        self.applied as f64 / (self.servos - self.refused).max(1) as f64
    }
}

/// A table by class.
pub(super) fn table(tallies: &BTreeMap<String, Tally>) -> String {
    let mut text = format!(
        "{:<32}{:>7}{:>9}{:>9}{:>9}{:>9}{:>11}{:>8}{:>8}  reasons of the others\n",
        "class", "servos", "refused", "applied", "kept", "rise", "overshoot", "broken", "s"
    );
    for (class, tally) in tallies {
        let reasons: Vec<_> = tally
            .reasons
            .iter()
            .map(|(number, times)| {
                let name = Reason::from_number(*number).map_or("?", Reason::name);
                format!("{times} × {name}")
            })
            .collect();
        writeln!(
            text,
            "{class:<32}{:>7}{:>9}{:>9}{:>9}{:>9}{:>11}{:>8}{:>8.2}  {}",
            tally.servos,
            tally.refused,
            tally.applied,
            tally.kept,
            tally.rise,
            tally.overshoot,
            tally.broken,
            tally.duration / tally.applied.max(1) as f64,
            reasons.join(", "),
        )
        .expect("a string takes any text");
    }
    text
}
