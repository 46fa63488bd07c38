//! Objects from constants: certificate and conversions of the settings were computed elsewhere.

use identifier_core::constants::{Configuration, Constants, ConstantsError};

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
