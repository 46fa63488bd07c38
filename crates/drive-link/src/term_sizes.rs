use identifier_core::parameters::Unknown;
use serde::{Deserialize, Serialize};

/// The number of unknowns that are sizes of terms.
const COUNT: usize = {
    let mut count = 0;
    let mut i = 0;
    while i < Unknown::COUNT {
        count += Unknown::ALL[i].term().is_some() as usize;
        i += 1;
    }
    count
};

/// Sizes of the optional terms of a model, SI: one that has not entered has the declared value, or zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TermSizes {
    sizes: [f32; COUNT],
    /// Infinite for those that have not entered.
    standard_errors: Option<[f32; COUNT]>,
}

impl TermSizes {
    /// The sizes of a model that knows each; none if it does not know one.
    #[must_use]
    pub fn where_known(size: impl Fn(Unknown) -> Option<f64>) -> Option<Self> {
        let mut sizes = [0.0; COUNT];
        for (own, unknown) in sizes.iter_mut().zip(Self::unknowns()) {
            *own = size(unknown)? as f32;
        }
        Some(Self {
            sizes,
            standard_errors: None,
        })
    }

    /// With standard errors; none is a term that has not entered.
    #[must_use]
    pub fn with_errors(self, error: impl Fn(Unknown) -> Option<f64>) -> Self {
        let mut errors = [f32::INFINITY; COUNT];
        for (own, unknown) in errors.iter_mut().zip(Self::unknowns()) {
            *own = error(unknown).map_or(f32::INFINITY, |error| error as f32);
        }
        Self {
            standard_errors: Some(errors),
            ..self
        }
    }

    /// Those that have entered, with their standard errors; without errors, as in a snapshot, those that are not
    /// zero.
    pub fn entered(&self) -> impl Iterator<Item = (Unknown, f32, Option<f32>)> + '_ {
        let own = Self::unknowns().zip(self.sizes).enumerate();
        let all = own.map(|(i, (unknown, size))| {
            (unknown, size, self.standard_errors.map(|errors| errors[i]))
        });
        all.filter(|(_, size, error)| error.map_or(*size != 0.0, f32::is_finite))
    }

    fn unknowns() -> impl Iterator<Item = Unknown> {
        let all = Unknown::ALL.into_iter();
        all.filter(|unknown| unknown.term().is_some())
    }
}
