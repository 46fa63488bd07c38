//! The holding brake of an axis. The loop holds the axis while the brake opens or closes.

use drive_link::{Ended, HoldingBrake, NotAllowed};
use identifier_core::error::Allowed;
use identifier_core::units::Units;

use crate::time::samples;

/// The longest times of a brake, samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BrakeTimes {
    pub(crate) opens: u32,
    pub(crate) closes: u32,
}

/// What the brake of a driven axis does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum BrakeMotion {
    /// Nothing, or there is none.
    Settled,
    /// It opens, and motion waits: samples that are left.
    Opening { left: u32 },
    /// It closes, and the axis is held: samples that are left, the end that began it, and whether a stop has come.
    Closing {
        left: u32,
        ended: Ended,
        is_stopped: bool,
    },
}

impl BrakeTimes {
    /// # Errors
    /// A brake that takes too long.
    pub(crate) fn new(
        brake: Option<&HoldingBrake>,
        units: &Units,
    ) -> Result<Option<Self>, NotAllowed> {
        let Some(brake) = brake else {
            return Ok(None);
        };
        for (name, time) in [("brake.opens", brake.opens), ("brake.closes", brake.closes)] {
            Allowed::Within(0.0, HoldingBrake::MAX_TIME).check(name, time)?;
        }
        Ok(Some(Self {
            opens: samples(brake.opens, units),
            closes: samples(brake.closes, units),
        }))
    }
}
