//! Limits of an axis, which only become narrower.

use drive_link::{NotAllowed, Settings, Why};
use identifier_core::units::Units;

/// Amplitudes of the dither by which targets stay within the travel.
pub(crate) const AMPLITUDES_OF_TRAVEL: f64 = 2.0;

/// A range of position, speed or command. No operation makes it wider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AllowedRange([f64; 2]);

impl AllowedRange {
    /// From the lower to the upper end, as configured.
    pub(crate) const fn new(ends: [f64; 2]) -> Self {
        Self(ends)
    }

    /// The positions to which the servo may be sent, rad from the origin.
    pub(crate) fn of_targets(settings: &Settings) -> Self {
        let [low, high] = settings.protection.travel;
        let margin = AMPLITUDES_OF_TRAVEL * settings.dither.amplitude;
        Self([low + margin, high - margin])
    }

    /// Its ends.
    pub(crate) const fn ends(self) -> [f64; 2] {
        self.0
    }

    /// From one end to the other.
    pub(crate) fn width(self) -> f64 {
        let [low, high] = self.0;
        high - low
    }

    /// True if a value is in it; not a number is in none.
    pub(crate) fn contains(self, value: f64) -> bool {
        let [low, high] = self.0;
        (low..=high).contains(&value)
    }

    /// The part that an order asks for.
    ///
    /// # Errors
    /// [`Why::BeyondDrive`] if the order is not wholly inside.
    pub(crate) fn narrowed(self, name: &str, given: [f64; 2]) -> Result<Self, NotAllowed> {
        if given.iter().all(|&end| self.contains(end)) {
            Ok(Self(given))
        } else {
            let allowed = self.0;
            Err(NotAllowed::new(name, Why::BeyondDrive { given, allowed }))
        }
    }

    /// The part of a range that is in it.
    pub(crate) fn clipped(self, [low, high]: [f64; 2]) -> [f64; 2] {
        let [lowest, highest] = self.0;
        [low.max(lowest), high.min(highest)]
    }

    /// As seen from a position in it.
    pub(crate) fn seen_from(self, position: f64) -> Self {
        Self(self.0.map(|end| end - position))
    }

    /// Its ends in counts, towards zero: distances are within what 32 bits hold.
    pub(crate) fn counts(self, units: &Units) -> [i32; 2] {
        self.0.map(|end| (end * units.position()) as i32)
    }
}
