//! The parts that a build has, by the features of the package.

#[cfg(not(feature = "commissioning"))]
use core::convert::Infallible;
#[cfg(not(feature = "commissioning"))]
use core::marker::PhantomData;
use core::ops::{Deref, DerefMut};

use drive_link::NotAllowed;
#[cfg(any(not(feature = "commissioning"), not(feature = "terms")))]
use drive_link::Why;

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
    /// # Errors
    /// Those of what makes it, and that of a build without commissioning.
    #[inline(always)]
    pub(crate) fn build(make: impl FnOnce() -> Result<T, NotAllowed>) -> Result<Self, NotAllowed> {
        #[cfg(feature = "commissioning")]
        return make().map(Self::Built);
        #[cfg(not(feature = "commissioning"))]
        {
            let _ = make;
            Err(NotAllowed::new("commissioning", Why::NotBuilt))
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

/// Checks that terms can be identified.
///
/// # Errors
/// A build without terms.
#[inline(always)]
pub(crate) fn has_terms() -> Result<(), NotAllowed> {
    #[cfg(feature = "terms")]
    return Ok(());
    #[cfg(not(feature = "terms"))]
    Err(NotAllowed::new("terms", Why::NotBuilt))
}
