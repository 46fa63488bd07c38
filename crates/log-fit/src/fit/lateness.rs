//! Whether the command was recorded after it acted.

use super::fitter::RecordFitter;
use super::search::Search;
use super::{Effect, Horizon, Values};

impl RecordFitter<'_> {
    /// How late the command was recorded, samples, and the standard error; it is late if it acts before it was
    /// recorded. The estimates are those at a long horizon. There a command that already responds to the position
    /// cannot explain the lateness.
    #[must_use]
    pub fn lateness(&self, values: &Values) -> Option<Lateness> {
        let rows = self.record.len() as f64;
        let white = (8.0 / self.statistics.bandwidth).clamp(30.0, (rows / 10.0).max(30.0));
        let search = Search {
            steps: 10,
            tolerance: 1e-7,
        };
        let horizon = Horizon { white, walk: None };
        let fitted = self.fit(values, &Effect::BASE, horizon, search)?;
        Some(Lateness {
            samples: -fitted.values.get(Effect::Delay),
            std_error: fitted.std_errors()[4],
            values: fitted.values,
        })
    }
}

/// How late the command was recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lateness {
    /// By how much, samples; negative is a delay of the servo.
    pub samples: f64,
    /// Standard error.
    pub std_error: f64,
    /// The estimates with it.
    pub values: Values,
}

impl Lateness {
    /// True if it cannot be a delay: beyond 0.6 samples, and beyond 0.3 by four standard errors.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.samples > 0.6 && self.samples - 0.3 > 4.0 * self.std_error
    }
}
