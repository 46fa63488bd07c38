//! Numbers as people read them: the one place that formats a value with its uncertainty.

use crate::SIDES;

/// Digits behind the point that a table has room for.
const MAX_PLACES: f64 = 9.0;

/// From here on a number has more digits than people read.
const LONG: f64 = 999_999.5;

/// True if an interval is so far beyond a value that nothing is known of it.
fn is_unknown(value: f64, half: f64) -> bool {
    /// Part of the interval below which a value is none.
    const LEAST: f64 = 1e-4;
    half >= LONG.max(value.abs()) || (value != 0.0 && value.abs() < LEAST * half)
}

/// A value ± half of its interval of 95 %, both with the digits that two of the latter take. Without a standard error
/// it is the value alone, with four digits. A dash where there is no value, or the standard error is infinite; "unknown"
/// where that is far beyond the value.
pub(crate) fn with_error(value: f64, std_error: Option<f64>) -> String {
    match std_error.map(|error| SIDES * error) {
        _ if !value.is_finite() => DASH.to_owned(),
        Some(error) if !error.is_finite() => DASH.to_owned(),
        Some(error) if is_unknown(value, error) => "unknown".to_owned(),
        Some(error) if error > 0.0 && value.abs() >= LONG => {
            let digits =
                (value.abs().log10().floor() - error.log10().floor() + 1.0).clamp(0.0, MAX_PLACES);
            format!("{} ± {}", large(value, digits as usize), large(error, 1))
        }
        Some(error) if error > 0.0 => {
            let places = (1.0 - error.log10().floor()).clamp(0.0, MAX_PLACES) as usize;
            format!("{} ± {}", fixed(value, places), fixed(error, places))
        }
        _ => figure(value),
    }
}

/// The part of a value within which it is known, in 95 % of cases.
pub(crate) fn known_to(value: f64, std_error: Option<f64>) -> String {
    match std_error.map(|error| SIDES * error) {
        Some(half) if half < value.abs() => per_cent(half / value),
        Some(half) if half.is_finite() && !is_unknown(value, half) => "may be zero".to_owned(),
        _ => DASH.to_owned(),
    }
}

/// Stands for what is not known.
pub(crate) const DASH: &str = "–";

/// Two digits that count.
pub(crate) fn rough(value: f64) -> String {
    let order = value.abs().log10().floor();
    if value == 0.0 || !order.is_finite() {
        figure(value)
    } else if order < -5.0 {
        scientific(value)
    } else if value.abs() >= LONG {
        large(value, 1)
    } else {
        fixed(value, (1.0 - order).clamp(0.0, MAX_PLACES) as usize)
    }
}

/// Four digits that count.
pub(crate) fn figure(value: f64) -> String {
    if !value.is_finite() {
        return if value.is_nan() { "–" } else { "∞" }.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let order = value.abs().log10().floor();
    if order < -5.0 {
        return scientific(value);
    }
    if value.abs() >= LONG {
        return large(value, 3);
    }
    fixed(value, (3.0 - order).clamp(0.0, MAX_PLACES) as usize)
}

/// The same without zeros at its end.
pub(crate) fn plain(value: f64) -> String {
    let text = figure(value);
    if text.contains('.') && !text.contains(['·', 'e']) {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Two digits that count, and a power of ten.
fn scientific(value: f64) -> String {
    let text = format!("{value:.1e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let power = power_of_ten(power.parse().unwrap_or(0));
    format!("{digits}·{power}").replace('-', "−")
}

/// A number of many digits, and a power of ten.
fn large(value: f64, places: usize) -> String {
    format!("{value:.places$e}").replace('-', "−")
}

/// `10⁻³`.
pub(crate) fn power_of_ten(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let power = power.to_string();
    let raised = power.chars().map(|character| match character.to_digit(10) {
        Some(digit) => DIGITS[digit as usize],
        None => '⁻',
    });
    format!("10{}", raised.collect::<String>())
}

/// A part in per cent, two digits of it.
pub(crate) fn per_cent(part: f64) -> String {
    let per_cent = 100.0 * part.abs();
    if !per_cent.is_finite() {
        return "–".to_owned();
    }
    if per_cent == 0.0 {
        return "0 %".to_owned();
    }
    let places = (1.0 - per_cent.log10().floor()).clamp(0.0, 4.0) as usize;
    match format!("{per_cent:.places$}") {
        text if text.parse() == Ok(0.0) => format!("below 0.{} %", "0".repeat(places - 1) + "1"),
        text => format!("{text} %"),
    }
}

/// Fixed decimals, with a typographic minus sign.
pub(crate) fn fixed(value: f64, places: usize) -> String {
    let scale = 10_f64.powi(places as i32);
    let rounded = (value * scale).round() / scale;
    // + 0.0 turns a negative zero into zero; what is too large to be rounded needs no places.
    let value = if rounded.is_finite() {
        rounded + 0.0
    } else {
        value
    };
    format!("{value:.places$}").replace('-', "−")
}

/// The same with its sign in any case.
pub(crate) fn signed(value: f64, places: usize) -> String {
    let text = fixed(value, places);
    match text.strip_prefix('−') {
        Some(_) => text,
        None => format!("+{text}"),
    }
}

/// A text with its first letter large.
pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

/// A text with its first letter large and a full stop.
pub(crate) fn sentence(text: &str) -> String {
    let end = match text.ends_with('.') || text.is_empty() {
        true => "",
        false => ".",
    };
    capitalised(text) + end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_the_digits_that_its_standard_error_leaves() {
        assert_eq!(with_error(257.694_12, Some(0.0123)), "257.694 ± 0.025");
        assert_eq!(with_error(-0.004, Some(3.0)), "0.0 ± 6.0");
        assert_eq!(with_error(-12.3, Some(40.0)), "−12 ± 80");
        assert_eq!(with_error(0.0, Some(3.0)), "0.0 ± 6.0");
        assert_eq!(with_error(0.217_44, None), "0.2174");
        assert_eq!(
            with_error(-73_368_324.0, Some(14_623_518.0)),
            "−7.3e7 ± 2.9e7"
        );
        assert_eq!(with_error(73_368_324.0, Some(15.0)), "7.3368324e7 ± 3.0e1");
        for (value, std_error) in [(1.0, 1.8e7), (2.0, 3.2e149), (1e-9, 0.01)] {
            assert_eq!(with_error(value, Some(std_error)), "unknown");
            assert_eq!(known_to(value, Some(std_error)), DASH);
        }
        assert_eq!(with_error(1.0, Some(f64::INFINITY)), "–");
        assert_eq!(with_error(f64::NAN, Some(1.0)), "–");
    }

    #[test]
    fn the_uncertainty_of_a_value_is_two_standard_errors() {
        assert_eq!(known_to(200.0, Some(1.0)), "1.0 %");
        assert_eq!(known_to(0.5, Some(0.3)), "may be zero");
        assert_eq!(known_to(0.5, None), "–");
    }

    #[test]
    fn rough_figures_have_two_digits_that_count() {
        for (value, text) in [
            (0.0, "0"),
            (0.012_34, "0.012"),
            (123.4, "123"),
            (7.3e7, "7.3e7"),
            (3e-7, "3.0·10⁻⁷"),
        ] {
            assert_eq!(rough(value), text);
        }
    }

    #[test]
    fn figures_have_four_digits_that_count() {
        for (value, text) in [
            (0.0, "0"),
            (134.267, "134.3"),
            (-0.013_81, "−0.01381"),
            (30_900.2, "30900"),
            (999_999.4, "999999"),
            (-73_368_324.0, "−7.337e7"),
            (0.000_000_32, "3.2·10⁻⁷"),
            (f64::NAN, "–"),
            (f64::INFINITY, "∞"),
        ] {
            assert_eq!(figure(value), text);
        }
    }

    #[test]
    fn plain_figures_end_with_no_zero() {
        for (value, text) in [
            (60.0, "60"),
            (0.001, "0.001"),
            (30_900.2, "30900"),
            (1e10, "1.000e10"),
            (1e-6, "1.0·10⁻⁶"),
        ] {
            assert_eq!(plain(value), text);
        }
    }

    #[test]
    fn parts_are_per_cents() {
        for (part, text) in [
            (0.0, "0 %"),
            (0.123, "12 %"),
            (-0.000_123, "0.012 %"),
            (1e-8, "below 0.0001 %"),
            (3.0, "300 %"),
        ] {
            assert_eq!(per_cent(part), text);
        }
    }

    #[test]
    fn sentences_begin_large_and_end() {
        assert_eq!(sentence("ä b"), "Ä b.");
        assert_eq!(sentence("A."), "A.");
        assert_eq!(sentence(""), "");
    }
}
