use core::marker::PhantomData;

use super::fitting::Listening;
use super::{FromSettings, Settings, SettingsError};
use crate::adaptation::IdentifiableSet;
use crate::fit::{Blocking, Fitter};
use crate::identifier::{WindowFitter, WindowRecorder};
use crate::number::Number;

impl<N, S, const P: usize, const W: usize, F, const U: usize> FromSettings
    for WindowRecorder<N, S, P, W, F, U>
where
    N: Number,
    S: IdentifiableSet<P>,
    F: IdentifiableSet<U>,
{
    /// # Errors
    /// See [`SettingsError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let config = Listening::new(settings)?;
        let time = WindowFitter::<N, S, P, W, F, U>::TIME;
        let fitter = config.fitter_with_terms::<N, S, P, F, U>(W, time)?;
        Ok(Self {
            blocking: Blocking::new(fitter.block),
            units: config.units,
            longest: config.longest_increment()?,
            initial: Self::own_values(&fitter.initial).map(|initial| initial.unwrap_or(0.0)),
            set: PhantomData,
        })
    }
}

impl<N, S, const P: usize, const W: usize, F, const U: usize> FromSettings
    for WindowFitter<N, S, P, W, F, U>
where
    N: Number,
    S: IdentifiableSet<P>,
    F: IdentifiableSet<U>,
{
    /// # Errors
    /// See [`SettingsError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        const {
            assert!(
                W >= Self::MIN_BLOCKS,
                "a window of fewer blocks tells too little"
            )
        };
        let config = Listening::new(settings)?.fitter_with_terms::<N, S, P, F, U>(W, Self::TIME)?;
        Ok(Self {
            fitter: Fitter::new(&config),
            set: PhantomData,
        })
    }
}
