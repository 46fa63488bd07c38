//! Targets from outside: step pulses with a direction, or a voltage.

use drive_link::{Fault, NotAllowed, Settings, TargetSource};
use identifier_core::number::Number;
use identifier_core::units::Units;

use crate::chip::Chip;
use crate::conversion::out_of_range;
use crate::protection::{is_within, reach};
use crate::reference::Reference;
use crate::time::samples;

/// The time by which the reference may lag behind the steps, s: pulses come in bursts.
const MAX_LAG: f64 = 0.02;

/// Time constant of the filter on the voltage, s.
const VOLTAGE_FILTER: f64 = 5e-3;

/// The time for which the voltage must be invalid, s: lines catch disturbances.
const INVALID_TIME: f64 = 2e-3;

/// The longest step, counts: as many of them as a sample may have stay within 64 bits.
const MAX_STEP_COUNTS: f64 = 32_768.0;

/// Bits of the fraction of a count that steps are summed with, so that no gear drifts.
const FRACTION_BITS: u32 = 32;

/// The source of a run's targets, other than the host.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outside {
    input: Input,
    /// The largest distance of a target from the origin, counts.
    reach: u32,
    /// Nothing was read from the input yet.
    is_fresh: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Input {
    Steps {
        /// Distance of a step, counts with a fraction.
        step: i64,
        /// Distance that steps have gone from the base, the same.
        gone: i64,
        /// The count from which steps are counted.
        base: i32,
        /// Counts by which the reference may lag behind.
        max_lag: u32,
    },
    Voltage {
        /// Target at 10 V, counts.
        range: f32,
        /// Part of a change that a sample takes in.
        share: f32,
        /// The filtered voltage, parts of 10 V.
        filtered: f32,
        /// Samples in a row without a valid one, and those that are a fault.
        invalid: u32,
        max_invalid: u32,
    },
}

impl Outside {
    /// None where the host sends the targets.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(settings: &Settings, units: &Units) -> Result<Option<Self>, NotAllowed> {
        let farthest = reach(settings);
        let checked = |name: &str, value: f64, most: f64| {
            let size = value.abs();
            if size > 0.0 && size <= most {
                Ok(())
            } else {
                Err(out_of_range(name, value, (-most, most)))
            }
        };
        let input = match settings.source {
            TargetSource::Line => return Ok(None),
            TargetSource::Steps { step } => {
                let most = MAX_STEP_COUNTS * units.position_unit();
                checked("source.step", step, farthest.min(most))?;
                let counts = step * units.position();
                let pace = settings.protection.pace * units.velocity();
                let lag = pace * f64::from(samples(MAX_LAG, units)) + counts.abs() + 1.0;
                Input::Steps {
                    step: (counts * (1_u64 << FRACTION_BITS) as f64) as i64,
                    gone: 0,
                    base: 0,
                    // A cast saturates.
                    max_lag: (lag as u32).min(i32::MAX.unsigned_abs()),
                }
            }
            TargetSource::Voltage { range } => {
                checked("source.range", range, farthest)?;
                Input::Voltage {
                    range: f32::from_f64(range * units.position()),
                    share: f32::from_f64((units.sample_time() / VOLTAGE_FILTER).min(1.0)),
                    filtered: 0.0,
                    invalid: 0,
                    max_invalid: samples(INVALID_TIME, units),
                }
            }
        };
        Ok(Some(Self {
            input,
            // Within 2³⁰ counts.
            reach: (farthest * units.position()) as u32 + 1,
            is_fresh: true,
        }))
    }

    /// Counts from a count on; what the input has seen before does not count.
    pub(crate) fn begin(&mut self, count: i32) {
        self.is_fresh = true;
        if let Input::Steps { gone, base, .. } = &mut self.input {
            (*gone, *base) = (0, count);
        }
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
        let is_fresh = core::mem::replace(&mut self.is_fresh, false);
        match &mut self.input {
            Input::Steps {
                step,
                gone,
                base,
                max_lag,
            } => {
                let steps = chip.steps();
                if is_fresh {
                    return Ok(());
                }
                let steps = steps.ok_or(Fault::StepsUnclear)?;
                if steps == 0 {
                    return Ok(());
                }
                // Less than 2⁶² each, as the distance is within the travel.
                *gone += i64::from(steps) * *step;
                let rounded = *gone + (1 << (FRACTION_BITS - 1));
                let target = base.wrapping_add((rounded >> FRACTION_BITS) as i32);
                if !is_within(target.wrapping_sub(origin), self.reach) {
                    return Err(Fault::TargetOutside);
                }
                reference.send(target);
                if is_within(reference.distance(), *max_lag) {
                    Ok(())
                } else {
                    Err(Fault::StepsTooFast)
                }
            }
            Input::Voltage {
                range,
                share,
                filtered,
                invalid,
                max_invalid,
            } => {
                let Some(voltage) = chip.voltage() else {
                    *invalid += 1;
                    return if *invalid >= *max_invalid {
                        Err(Fault::VoltageInvalid)
                    } else {
                        Ok(())
                    };
                };
                *invalid = 0;
                if is_fresh {
                    *filtered = voltage;
                }
                *filtered += (voltage - *filtered) * *share;
                let target = *range * filtered.clamp(-1.0, 1.0);
                reference.send(origin.wrapping_add(target as i32));
                Ok(())
            }
        }
    }
}
