//! The first estimates, and the time at which the command acts.

use super::fitter::Fitter;
use super::search::Search;
use super::{Effect, Horizon, Values};

/// A start, and the horizons with which it is searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beginning {
    pub(crate) values: Values,
    pub(crate) has_gravity: bool,
    pub(crate) horizons: [Horizon; 2],
}

impl Fitter<'_> {
    /// The estimates to which a beginning leads, and their −2 ln L; none if every search diverges.
    #[must_use]
    pub fn search_from(&self, beginning: &Beginning) -> Option<(Values, f64)> {
        let search = Search {
            steps: 6,
            tolerance: 1e-5,
        };
        let gravity: &[Effect] = match beginning.has_gravity {
            true => &[Effect::GravitySine, Effect::GravityCosine],
            false => &[],
        };
        let free = [&Effect::BASE[..], gravity].concat();
        let mut values = beginning.values;
        let mut likelihood = f64::INFINITY;
        for horizon in beginning.horizons {
            if let Some((found, sums)) = self.search(&values, &free, horizon, search) {
                values = found;
                likelihood = sums.minus_two_log_likelihood();
            }
        }
        likelihood.is_finite().then_some((values, likelihood))
    }

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

/// The estimates with the least −2 ln L.
pub fn likeliest(searched: impl Iterator<Item = (Values, f64)>) -> Option<Values> {
    let least = searched.reduce(|least, one| if one.1 < least.1 { one } else { least });
    least.map(|(values, _)| values)
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
