//! Numbers of a fixed width.

/// A value and its standard error, with two digits of that, or with as many as fit.
pub(super) fn with_error(value: f64, error: Option<f64>) -> String {
    match error.filter(|error| error.is_finite() && *error > 0.0) {
        Some(error) => {
            let digits = (1.0 - error.log10().floor()).clamp(0.0, 6.0) as usize;
            format!("{value:.digits$} ± {error:.digits$}")
        }
        None => plain(value),
    }
}

/// A value with some five digits.
pub(super) fn plain(value: f64) -> String {
    let size = value.abs();
    let digits = match size {
        _ if size >= 1e6 => return format!("{value:.3e}"),
        _ if size >= 1e3 => 1,
        _ if size >= 10.0 => 3,
        _ => 4,
    };
    format!("{value:.digits$}")
}

/// The same with a sign, or with a power of ten where it is small.
pub(super) fn signed(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && size < 1e-2 {
        format!("{value:+.2e}")
    } else {
        format!("{value:+.4}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_digits_as_are_known() {
        for (value, error, wanted) in [
            (0.217_412, Some(0.000_91), "0.21741 ± 0.00091"),
            (257.7049, Some(0.05), "257.705 ± 0.050"),
            (257.7049, Some(12.0), "258 ± 12"),
            (257.7049, Some(0.0), "257.705"),
            (5.0, None, "5.0000"),
            (5.0, Some(f64::NAN), "5.0000"),
        ] {
            assert_eq!(with_error(value, error), wanted);
        }
        assert_eq!(signed(-0.000_123), "-1.23e-4");
        assert_eq!(signed(0.0), "+0.0000");
    }
}
