//! The watch over the lines while the servo is driven.

use drive_link::Fault;
use identifier_core::units::Units;

use crate::chip::Lines;
use crate::time::samples;

/// The time for which a limit switch must be open, s: contacts bounce, and lines catch disturbances.
const DEBOUNCE: f64 = 2e-3;

/// Whether the lines let the servo be driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineWatch {
    open: u32,
    open_most: u32,
}

impl LineWatch {
    pub(crate) fn new(units: &Units) -> Self {
        Self {
            open: 0,
            open_most: samples(DEBOUNCE, units),
        }
    }

    /// Looks at the lines of a sample.
    ///
    /// # Errors
    /// What they let the servo go for.
    #[inline]
    pub(crate) fn check(&mut self, lines: Lines) -> Result<(), Fault> {
        if !lines.amplifier {
            return Err(Fault::AmplifierFault);
        }
        if lines.low_switch && lines.high_switch {
            self.open = 0;
            return Ok(());
        }
        self.open = self.open.saturating_add(1);
        if self.open >= self.open_most {
            Err(Fault::LimitSwitch)
        } else {
            Ok(())
        }
    }
}
