//! The check of the program in the flash.

use crc::{CRC_32_ISO_HDLC, Crc};
use drive_link::Fault;

const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The seal of a program that was never sealed.
pub const UNSEALED: u32 = u32::MAX;

/// The seal of a program of these parts, never [`UNSEALED`].
#[must_use]
pub fn seal<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> u32 {
    let mut digest = CHECK.digest();
    for part in parts {
        digest.update(part);
    }
    match digest.finalize() {
        UNSEALED => !UNSEALED,
        sealed => sealed,
    }
}

/// Checks a program against its seal; false if it has none.
///
/// # Errors
/// [`Fault::ImageDamaged`].
pub fn check_image<'a>(
    parts: impl IntoIterator<Item = &'a [u8]>,
    sealed: u32,
) -> Result<bool, Fault> {
    if sealed == UNSEALED {
        return Ok(false);
    }
    if seal(parts) == sealed {
        Ok(true)
    } else {
        Err(Fault::ImageDamaged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bit_of_any_part_or_of_the_seal_is_noticed() {
        let first = [1, 2, 3];
        let second: [u8; 64] = core::array::from_fn(|k| k as u8);
        let sealed = seal([&first[..], &second]);
        assert_eq!(check_image([&first[..], &second], sealed), Ok(true));
        for bit in 0..8 * second.len() {
            let mut damaged = second;
            damaged[bit / 8] ^= 1 << (bit % 8);
            let checked = check_image([&first[..], &damaged], sealed);
            assert_eq!(checked, Err(Fault::ImageDamaged));
        }
        for bit in 0..32 {
            let checked = check_image([&first[..], &second], sealed ^ 1 << bit);
            assert_eq!(checked, Err(Fault::ImageDamaged));
        }
    }

    #[test]
    fn a_program_without_a_seal_is_not_checked() {
        assert_eq!(check_image([&[1_u8, 2][..]], UNSEALED), Ok(false));
    }
}
