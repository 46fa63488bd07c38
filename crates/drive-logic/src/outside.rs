//! Targets from outside: step pulses with a direction.

use drive_link::{Fault, NotAllowed, Settings, TargetSource};
use identifier_core::error::Allowed;
use identifier_core::units::Units;

use crate::chip::Chip;
use crate::limits::AllowedRange;
use crate::protection::is_within;
use crate::reference::Reference;
use crate::time::samples;

/// The time by which the reference may lag behind the steps, s: pulses come in bursts.
const MAX_LAG: f64 = 0.02;

/// The longest step, counts: as many of them as a sample may have stay within 64 bits.
const MAX_STEP_COUNTS: f64 = 32_768.0;

/// Bits of the fraction of a count that steps are summed with, so that no gear drifts.
const FRACTION_BITS: u32 = 32;

/// The source of a run's targets, other than the host.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outside {
    /// Distance of a step, counts with a fraction.
    step: i64,
    /// Distance that steps have gone from the base, the same.
    gone: i64,
    /// The count from which steps are counted.
    base: i32,
    /// Counts by which the reference may lag behind.
    max_lag: u32,
    /// Where targets may be, counts from the origin.
    reach: [i32; 2],
    /// Nothing was read from the input yet.
    is_fresh: bool,
    /// Steps came while nothing followed them.
    missed: bool,
}

impl Outside {
    /// None where the host sends the targets.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(settings: &Settings, units: &Units) -> Result<Option<Self>, NotAllowed> {
        let TargetSource::Steps { step } = settings.source else {
            return Ok(None);
        };
        let reach = AllowedRange::of_targets(settings);
        let most = (reach.width() / 2.0).min(MAX_STEP_COUNTS * units.position_unit());
        Allowed::Within(-most, most).check("source.step", step)?;
        Allowed::Above(0.0).check("source.step", step.abs())?;
        let counts = step * units.position();
        let pace = settings.protection.pace * units.velocity();
        let lag = pace * f64::from(samples(MAX_LAG, units)) + counts.abs() + 1.0;
        Ok(Some(Self {
            step: (counts * (1_u64 << FRACTION_BITS) as f64) as i64,
            gone: 0,
            base: 0,
            // A cast saturates.
            max_lag: (lag as u32).min(i32::MAX.unsigned_abs()),
            reach: reach.counts(units),
            is_fresh: true,
            missed: false,
        }))
    }

    /// Counts from a count on; what the input has seen before does not count.
    pub(crate) fn begin(&mut self, count: i32) {
        (self.is_fresh, self.gone, self.base) = (true, 0, count);
    }

    /// Counts from a count on again, after a time in which steps may have come that nothing followed.
    pub(crate) fn resume(&mut self, count: i32, missed: bool) {
        self.begin(count);
        (self.is_fresh, self.missed) = (false, missed);
    }

    /// Sends the reference on.
    ///
    /// # Errors
    /// The command cannot be followed.
    pub(crate) fn follow<C: Chip>(
        &mut self,
        chip: &mut C,
        origin: i32,
        reference: &mut Reference,
    ) -> Result<(), Fault> {
        if self.missed {
            return Err(Fault::StepsMissed);
        }
        let steps = chip.steps();
        if core::mem::replace(&mut self.is_fresh, false) {
            return Ok(());
        }
        let steps = steps.ok_or(Fault::StepsUnclear)?;
        if steps == 0 {
            return Ok(());
        }
        // Less than 2⁶² each, as the distance is within the travel.
        self.gone += i64::from(steps) * self.step;
        let rounded = self.gone + (1 << (FRACTION_BITS - 1));
        let target = self.base.wrapping_add((rounded >> FRACTION_BITS) as i32);
        let [low, high] = self.reach;
        // Steps are rounded to a count.
        if !(low - 1..=high + 1).contains(&target.wrapping_sub(origin)) {
            return Err(Fault::TargetOutside);
        }
        reference.send(target);
        if is_within(reference.distance(), self.max_lag) {
            Ok(())
        } else {
            Err(Fault::StepsTooFast)
        }
    }
}
