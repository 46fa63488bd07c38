//! Output to the host over semihosting, without formatting machinery (which can panic).

use cortex_m_semihosting::{debug, hio};

/// Writes words, separated by blanks, as a line.
pub fn print(words: &[&str]) {
    let Ok(mut out) = hio::hstdout() else {
        return;
    };
    for word in words {
        let _ = out.write_all(word.as_bytes());
        let _ = out.write_all(b" ");
    }
    let _ = out.write_all(b"\n");
}

/// Ends the emulation with success or failure; a chip without a debugger stops here.
pub fn exit(well: bool) -> ! {
    debug::exit(if well {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    loop {
        cortex_m::asm::wfi();
    }
}

/// A number as text.
#[derive(Debug, Clone, Copy)]
pub struct Text {
    digits: [u8; 20],
    first: usize,
}

impl Text {
    /// The bits of a double, sixteen hexadecimal digits.
    #[must_use]
    pub fn bits(value: f64) -> Self {
        Self::based(value.to_bits(), 16, 16)
    }

    /// A whole number.
    #[must_use]
    pub fn whole(value: u32) -> Self {
        Self::based(u64::from(value), 10, 1)
    }

    fn based(mut value: u64, base: u64, least: usize) -> Self {
        const DIGITS: &[u8; 16] = b"0123456789abcdef";
        let mut text = Self {
            digits: [b'0'; 20],
            first: 20,
        };
        for place in (0..20).rev() {
            if value == 0 && 20 - text.first >= least {
                break;
            }
            let digit = DIGITS.get((value % base) as usize).unwrap_or(&b'?');
            if let Some(slot) = text.digits.get_mut(place) {
                *slot = *digit;
            }
            text.first = place;
            value /= base;
        }
        text
    }

    /// Its characters.
    #[must_use]
    pub fn as_str(&self) -> &str {
        self.digits
            .get(self.first..)
            .and_then(|digits| core::str::from_utf8(digits).ok())
            .unwrap_or("?")
    }
}
