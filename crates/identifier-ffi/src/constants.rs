//! Objects from constants: certificate and conversions of the settings were computed elsewhere.

use identifier_core::constants::{Configuration, Constants, ConstantsError};
use identifier_core::fixed_point::Word;
use identifier_core::parameters::PerParameter;

use crate::object::check;
use crate::status::{CONSTANTS_CHANGED, CONSTANTS_TYPE, CONSTANTS_VERSION};

/// A configuration of constants, of which there are `words`.
///
/// # Safety
/// An address that is neither null nor misaligned is of as many words.
pub(crate) unsafe fn configuration<T: Configuration>(
    constants: *const u32,
    words: u32,
) -> Result<T, i32> {
    check(constants)?;
    let wanted = Constants::<T>::WORDS;
    // More are read in no case, and their number is judged after version and type.
    let there = (words as usize).min(wanted);
    // SAFETY: guaranteed by the caller.
    let slice = unsafe { core::slice::from_raw_parts(constants, there) };
    let read = Constants::<T>::read(slice).map_err(status_of)?;
    if words as usize == wanted {
        Ok(read)
    } else {
        Err(CONSTANTS_CHANGED)
    }
}

fn status_of(error: ConstantsError) -> i32 {
    match error {
        ConstantsError::Version => CONSTANTS_VERSION,
        ConstantsError::Type => CONSTANTS_TYPE,
        _ => CONSTANTS_CHANGED,
    }
}

/// Values of four parameters as C has them.
pub(crate) trait InC {
    /// An array of C.
    type Values;

    /// As C has them.
    fn in_c(self) -> Self::Values;
}

impl InC for PerParameter<f32> {
    type Values = [f32; 4];

    fn in_c(self) -> [f32; 4] {
        [self.a, self.b, self.coulomb, self.load]
    }
}

impl InC for PerParameter<Word> {
    type Values = [i32; 4];

    fn in_c(self) -> [i32; 4] {
        [self.a, self.b, self.coulomb, self.load].map(Word::to_bits)
    }
}
