//! The parts that a build has, by the features of the package.

#[cfg(not(feature = "commissioning"))]
use core::convert::Infallible;
#[cfg(not(feature = "commissioning"))]
use core::marker::PhantomData;
use core::ops::{Deref, DerefMut};

use drive_link::{NotAllowed, Why};

/// What only a drive that commissions its servo has. In another build there is no value of this type: it takes no memory,
/// and what it would do no flash.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Part<T> {
    #[cfg(feature = "commissioning")]
    Built(T),
    #[cfg(not(feature = "commissioning"))]
    #[expect(dead_code, reason = "there is none")]
    Missing(Infallible, PhantomData<T>),
}

impl<T> Part<T> {
    /// None in a build without commissioning.
    #[inline(always)]
    pub(crate) fn of(part: T) -> Option<Self> {
        #[cfg(feature = "commissioning")]
        return Some(Self::Built(part));
        #[cfg(not(feature = "commissioning"))]
        {
            let _ = part;
            None
        }
    }
}

impl<T> Deref for Part<T> {
    type Target = T;

    #[inline(always)]
    fn deref(&self) -> &T {
        match self {
            #[cfg(feature = "commissioning")]
            Self::Built(part) => part,
            #[cfg(not(feature = "commissioning"))]
            Self::Missing(never, _) => match *never {},
        }
    }
}

impl<T> DerefMut for Part<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut T {
        match self {
            #[cfg(feature = "commissioning")]
            Self::Built(part) => part,
            #[cfg(not(feature = "commissioning"))]
            Self::Missing(never, _) => match *never {},
        }
    }
}

/// True if the build has commissioning. Asked as a constant, so that what follows a refusal is left out of the others.
pub(crate) const HAS_COMMISSIONING: bool = cfg!(feature = "commissioning");

/// Checks that terms can be identified.
///
/// # Errors
/// A build without terms.
#[inline(always)]
pub(crate) fn has_terms() -> Result<(), NotAllowed> {
    if cfg!(feature = "terms") {
        Ok(())
    } else {
        Err(not_built("terms"))
    }
}

/// The refusal of a build without a part.
pub(crate) fn not_built(part: &str) -> NotAllowed {
    NotAllowed::new(part, Why::NotBuilt)
}
