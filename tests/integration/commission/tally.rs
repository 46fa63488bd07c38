//! Tables of the outcomes of many commissionings.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use identifier_core::reason::Reason;

use super::judged::{Judged, OVERSHOOT, RISE, SMALL_OVERSHOOT};

/// Outcomes of the servos of a class.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub(super) servos: usize,
    pub(super) refused: usize,
    pub(super) applied: usize,
    /// Those whose gains have a feed-forward, and of these those that match the prediction.
    led: [usize; 2],
    pub(super) kept: usize,
    pub(super) rise: usize,
    pub(super) overshoot: usize,
    /// Those whose step overshoots by little, whatever was predicted.
    pub(super) hardly_over: usize,
    pub(super) broken: usize,
    /// By reason, those that were not applied.
    pub(super) reasons: BTreeMap<u8, usize>,
    /// Durations of those that were applied, s.
    durations: Vec<f64>,
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
            let tuning = judged.outcome.tuning;
            if tuning.is_some_and(|tuning| tuning.feed_forward.is_some()) {
                self.led[0] += 1;
                self.led[1] += usize::from(kept.is_kept());
            }
            self.kept += usize::from(kept.is_kept());
            self.rise += usize::from(kept.rise.abs() <= RISE);
            self.overshoot += usize::from(kept.overshoot <= OVERSHOOT);
            self.hardly_over += usize::from(kept.whole_overshoot <= SMALL_OVERSHOOT);
            self.durations
                .push(judged.outcome.end.map_or(0.0, |end| end.time));
        }
    }

    /// The median duration, s; zero of none.
    fn median_duration(&self) -> f64 {
        let mut durations = self.durations.clone();
        durations.sort_by(f64::total_cmp);
        durations.get(durations.len() / 2).copied().unwrap_or(0.0)
    }

    /// The part of those that could be commissioned.
    pub(super) fn applied_part(&self) -> f64 {
        self.applied as f64 / (self.servos - self.refused).max(1) as f64
    }
}

/// A table by class.
pub(super) fn table(tallies: &BTreeMap<String, Tally>) -> String {
    let mut text = format!(
        "{:<32}{:>7}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>11}{:>8}{:>8}{:>8}  reasons of the others\n",
        "class",
        "servos",
        "refused",
        "applied",
        "kept",
        "led",
        "kept",
        "rise",
        "overshoot",
        "<= 3 %",
        "broken",
        "s"
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
            "{class:<32}{:>7}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>11}{:>8}{:>8}{:>8.2}  {}",
            tally.servos,
            tally.refused,
            tally.applied,
            tally.kept,
            tally.led[0],
            tally.led[1],
            tally.rise,
            tally.overshoot,
            tally.hardly_over,
            tally.broken,
            tally.median_duration(),
            reasons.join(", "),
        )
        .expect("a string takes any text");
    }
    text
}
