//! What a motion has shown of a servo's response beside its model.

use super::TuningSettings;
use super::measured_line::MeasuredLine;
use super::resonance::Mode;

/// What a motion has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shown<'a> {
    /// Nothing.
    Nothing,
    /// Lines of a measured response, and whether the model explains them. On each of them the gains keep their distance
    /// from −1.
    Lines(&'a [MeasuredLine], bool),
    /// The ratio of a mode up to which it may be there, by frequencies that go up by
    /// a tenth. Above the last any may be there that [`TuningSettings::resonance`](super::TuningSettings::resonance) allows.
    Modes(&'a [HiddenMode]),
}

impl<'a> Shown<'a> {
    pub(super) const fn lines(self) -> (&'a [MeasuredLine], bool) {
        match self {
            Self::Lines(lines, is_explained) => (lines, is_explained),
            _ => (&[], true),
        }
    }
}

/// The ratios of a mode at a frequency that a motion leaves open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HiddenMode {
    /// ω, rad/s.
    pub frequency: f64,
    /// The least and the largest [β](Mode::ratio).
    pub ratios: [f64; 2],
}

impl HiddenMode {
    /// Any mode at a frequency, rad/s.
    pub(super) const fn any(frequency: f64) -> Self {
        Self {
            frequency,
            ratios: [Mode::ON_LOAD, TuningSettings::HIDDEN_RATIO],
        }
    }
}
