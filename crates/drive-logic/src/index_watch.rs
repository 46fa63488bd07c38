//! The watch over the index pulses of a homed axis.

use drive_link::Fault;
use identifier_core::units::Units;

/// Counts by which a pulse may be off its place: it has a width, and is passed from both sides.
const OFF_PLACE: u32 = 4;

/// Bits of the fraction of a count that a revolution is kept with, so that no number of them drifts.
const FRACTION_BITS: u32 = 32;

/// Whole revolutions of an encoder, in counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Revolutions {
    /// With a fraction.
    counts: i64,
    per_count: f32,
}

impl Revolutions {
    pub(crate) fn new(units: &Units) -> Self {
        let counts = core::f64::consts::TAU * units.position();
        Self {
            counts: (counts * (1_u64 << FRACTION_BITS) as f64) as i64,
            per_count: (1.0 / counts) as f32,
        }
    }

    /// The distance from the nearest whole number of revolutions, counts.
    fn off(&self, distance: i32) -> u32 {
        let revolutions = distance as f32 * self.per_count;
        let half = if revolutions < 0.0 { -0.5 } else { 0.5 };
        let whole = i64::from((revolutions + half) as i32);
        // Less than 2⁶³: the distance is within 32 bits.
        let rounded = whole
            .wrapping_mul(self.counts)
            .wrapping_add(1 << (FRACTION_BITS - 1));
        distance
            .wrapping_sub((rounded >> FRACTION_BITS) as i32)
            .unsigned_abs()
    }

    /// Checks a pulse at a count of an axis with its home pulse at another.
    ///
    /// # Errors
    /// [`Fault::IndexShifted`].
    pub(crate) fn check_pulse(&self, pulse: i32, home: i32) -> Result<(), Fault> {
        if self.off(pulse.wrapping_sub(home)) > OFF_PLACE {
            Err(Fault::IndexShifted)
        } else {
            Ok(())
        }
    }

    /// Checks the home pulse at this distance from the edge of the home switch: near it, or near a revolution behind it,
    /// the next homing may find another pulse.
    ///
    /// # Errors
    /// [`Fault::IndexAtSwitch`].
    pub(crate) fn check_home(&self, from_edge: i32) -> Result<(), Fault> {
        let eighth = self.counts >> (FRACTION_BITS + 3);
        if i64::from(self.off(from_edge)) <= eighth {
            Err(Fault::IndexAtSwitch)
        } else {
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_lie_on_whole_revolutions_however_many_and_however_odd() {
        for per_revolution in [4.0, 400.0, 10_000.0, 4096.7] {
            let units = Units::new(1e-3, core::f64::consts::TAU / per_revolution).expect("allowed");
            let revolutions = Revolutions::new(&units);
            for n in [-20_000_i32, -3, -1, 0, 1, 2, 7, 20_000] {
                let home = i32::MAX - 5;
                let there = rounded(f64::from(n) * per_revolution);
                let off = if per_revolution < 20.0 {
                    0
                } else {
                    OFF_PLACE.cast_signed()
                };
                for (beside, is_fault) in
                    [(0, false), (off, false), (-off, false), (off + 1, off > 0)]
                {
                    let pulse = home.wrapping_add(there).wrapping_add(beside);
                    let checked = revolutions.check_pulse(pulse, home);
                    assert_eq!(checked.is_err(), is_fault, "{per_revolution} {n} {beside}");
                }
            }
        }
    }

    fn rounded(value: f64) -> i32 {
        (value + 0.5f64.copysign(value)) as i32
    }
}
