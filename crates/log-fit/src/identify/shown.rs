//! The frequencies at which a record would have shown a resonance.

use std::f64::consts::TAU;

use crate::fit::{Effect, MAX_COLUMNS, RecordFitter};
use crate::parallel;

use super::candidate::{Answer, Candidate, Range};
use super::model::Model;
use super::scan::scan;
use crate::cause::Cause;

/// A second mode beside the model at a frequency: b β/(s² + 2ζωs + ω²), by linear algebra beside everything that the
/// model estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondMode {
    /// ω, rad/sample.
    pub frequency: f64,
    /// β: the load's inertia over the motor's, or −1 for an encoder on the load.
    pub ratio: f64,
    /// Its standard error, counted in independent rows.
    pub std_error: f64,
}

impl SecondMode {
    /// Of the answer of a candidate, at a number of samples to one of the record.
    pub(super) fn of(answer: &Answer, samples: f64) -> Option<Self> {
        let frequency = answer.candidate.columns[0].setting;
        let ratio = answer.sizes[0] * frequency * frequency;
        let std_error = ratio.abs() / answer.gain.sqrt();
        std_error.is_finite().then_some(Self {
            frequency: frequency * samples,
            ratio,
            std_error,
        })
    }
}

/// The answers of modes at a geometric series of frequencies, from twice the bandwidth of the motion to the sampling
/// frequency.
pub(super) fn modes(fitter: &RecordFitter<'_>, model: &Model, range: &Range) -> Vec<Answer> {
    /// Half of the width of a resonance that is looked for.
    const RATIO: f64 = 1.1;
    let first = 2.0 * fitter.statistics.bandwidth;
    let frequencies = std::iter::successors(Some(first), |last| Some(RATIO * last));
    let mode = |frequency| Candidate::at(Cause::Resonance, &[Effect::Compliance], frequency);
    let modes: Vec<Candidate> = frequencies.take_while(|of| *of < TAU).map(mode).collect();
    let at_once = MAX_COLUMNS - model.free.len();
    let parts: Vec<&[Candidate]> = modes.chunks(at_once).collect();
    let scanned = parallel::map(&parts, |some| scan(fitter, model, range, some));
    scanned.flatten().collect()
}
