//! A configuration as constants, computed elsewhere.
//!
//! A configuration is built from [`Settings`](crate::Settings), which are checked and converted in double precision.
//! The code of the certificate alone is several times as large as that of a sample. A firmware with a fixed
//! configuration needs none of that. [`words`] writes a configuration out on a PC, as 32-bit words in machine units.
//! [`Constants`] is the same configuration made from them, to the last bit.
//!
//! ```
//! use identifier_core::constants::{Constants, words};
//! use identifier_core::identifier::{GaussNewtonIdentifier, Identify};
//! use identifier_core::parameters::Unknowns;
//! use identifier_core::Settings;
//!
//! type Identifier = GaussNewtonIdentifier<f32, Unknowns<4>, 4>;
//!
//! // On the PC:
//! let built: Identifier = Settings::new(1e-3, 10_000.0).build()?;
//! let mut exported = Vec::new();
//! words(&built, |word| exported.push(word));
//!
//! // In the firmware, where `exported` is an array in its sources:
//! # let exported: &'static [u32] = exported.leak();
//! let constants = Constants::<Identifier>::new(exported)?;
//! let identifier = constants.build();
//! assert!(identifier == built);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! In a `const` the words are checked when the firmware is compiled. Words of another type of configuration or of
//! another version of this crate do not compile. Nor do words of which one was changed. `servo-id export --firmware
//! rust` writes such a `const`:
//!
//! ```compile_fail
//! # use identifier_core::constants::Constants;
//! # use identifier_core::identifier::GaussNewtonIdentifier;
//! # use identifier_core::parameters::Unknowns;
//! const IDENTIFIER: Constants<GaussNewtonIdentifier<f32, Unknowns<4>, 4>> =
//!     match Constants::new(&[1, 2, 3]) {
//!         Ok(constants) => constants,
//!         Err(error) => panic!("{}", error.remedy()),
//!     };
//! # let _ = IDENTIFIER.build();
//! ```
//!
//! **Invariant.** The words keep all that a constructor ensures of a configuration (ranges, no NaN, a certificate).
//! [`words`] takes only a built configuration, and a sum over the words is compared.

mod encode;

use core::marker::PhantomData;

pub(crate) use encode::{Decoder, Encode, encode, field, fingerprint};
use encode::{EMPTY, checksum, with};

/// A configuration that can be written as words and read back: the identifiers, controllers and loops of this crate.
///
/// It is sealed: its words are an internal layout, which a fingerprint identifies.
pub trait Configuration: Encode {}

impl<T: Encode> Configuration for T {}

/// The configuration T as words.
///
/// # Layout
/// The version of this crate, the fingerprint of the type, the fields in order, and a sum over these.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Constants<T> {
    fields: &'static [u32],
    built: PhantomData<fn() -> T>,
}

/// Words that are not constants of a configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.remedy())]
#[non_exhaustive]
pub enum ConstantsError {
    /// They were written by another version of this crate.
    Version,
    /// They are those of another type.
    Type,
    /// There are more or fewer than were written, or one of them has changed.
    Changed,
}

impl ConstantsError {
    /// The remedy, for the message of a `const` that does not compile.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::Version => {
                "the constants were written by another version of identifier-core: export them again with this one"
            }
            Self::Type => {
                "the constants are those of another type: declare the type that the exported file names"
            }
            Self::Changed => {
                "the constants were changed after they were exported: change the scenario, and export them again"
            }
        }
    }
}

impl<T: Configuration> Constants<T> {
    /// Words beside the fields.
    const FRAME: usize = 3;

    /// The number of words.
    pub const WORDS: usize = T::WORDS + Self::FRAME;

    /// The configuration of these words.
    ///
    /// # Errors
    /// See [`ConstantsError`].
    pub const fn new(words: &'static [u32]) -> Result<Self, ConstantsError> {
        match Self::check(words) {
            Err(error) => Err(error),
            Ok(()) => {
                let (_, from_type) = words.split_at(Self::FRAME - 1);
                let (fields, _) = from_type.split_at(T::WORDS);
                Ok(Self {
                    fields,
                    built: PhantomData,
                })
            }
        }
    }

    /// Checks words that may be anything.
    ///
    /// # Errors
    /// See [`ConstantsError`].
    pub const fn check(words: &[u32]) -> Result<(), ConstantsError> {
        match words {
            [version, ..] if *version != VERSION => Err(ConstantsError::Version),
            [_, shape, ..] if *shape != T::SHAPE => Err(ConstantsError::Type),
            [summed @ .., sum] if words.len() == Self::WORDS && *sum == checksum(summed) => Ok(()),
            _ => Err(ConstantsError::Changed),
        }
    }

    /// The configuration, to the last bit the one that was written.
    #[inline]
    #[must_use]
    pub fn build(&self) -> T {
        T::decode(&mut Decoder::new(self.fields))
    }

    /// The same from words that need not outlive the call.
    ///
    /// # Errors
    /// See [`ConstantsError`].
    #[inline]
    pub fn read(words: &[u32]) -> Result<T, ConstantsError> {
        Self::check(words)?;
        let fields = words.get(Self::FRAME - 1..).unwrap_or_default();
        Ok(T::decode(&mut Decoder::new(fields)))
    }
}

/// Writes a configuration as words, one after the other.
pub fn words<T: Configuration>(configuration: &T, mut word: impl FnMut(u32)) {
    let mut sum = EMPTY;
    let mut put = |next: u32| {
        sum = with(sum, next);
        word(next);
    };
    put(VERSION);
    put(T::SHAPE);
    configuration.encode(&mut put);
    word(sum);
}

/// The version of this crate: 10 bits for each of its three numbers.
const VERSION: u32 = decimal(env!("CARGO_PKG_VERSION_MAJOR")) << 20
    | decimal(env!("CARGO_PKG_VERSION_MINOR")) << 10
    | decimal(env!("CARGO_PKG_VERSION_PATCH"));

const fn decimal(digits: &str) -> u32 {
    let digits = digits.as_bytes();
    let mut number = 0;
    let mut place = 0;
    while place < digits.len() {
        number = number * 10 + (digits[place] - b'0') as u32;
        place += 1;
    }
    number
}
