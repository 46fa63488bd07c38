//! Round numbers along an axis.

/// Round values within a range, about so many, as text with no more digits than tell them apart.
#[must_use]
pub(super) fn linear((low, high): (f64, f64), about: f64) -> Vec<(f64, String)> {
    /// The part of a step by which rounding may put an end of the range beside a tick.
    const SLACK: f64 = 1e-6;
    let span = high - low;
    if !(span > 0.0 && span.is_finite()) {
        return Vec::new();
    }
    let rough = span / about;
    let decade = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|part| part * decade)
        .find(|step| *step >= rough)
        .unwrap_or(rough);
    let places = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    let first = (low / step - SLACK).ceil() as i64;
    let last = (high / step + SLACK).floor() as i64;
    (first..=last)
        .map(|count| {
            // + 0.0 turns a negative zero into zero.
            let value = count as f64 * step + 0.0;
            (value, format!("{value:.places$}").replace('-', "−"))
        })
        .collect()
}

/// Powers of ten within a range.
#[must_use]
pub(super) fn decades((low, high): (f64, f64)) -> Vec<(f64, String)> {
    if !(low > 0.0 && high.is_finite()) {
        return Vec::new();
    }
    let (first, last) = (low.log10().ceil() as i32, high.log10().floor() as i32);
    (first..=last)
        .map(|power| (10_f64.powi(power), format!("1e{power}")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(range: (f64, f64)) -> Vec<String> {
        linear(range, 5.0)
            .into_iter()
            .map(|(_, text)| text)
            .collect()
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(shown((0.0, 60.0)), ["0", "20", "40", "60"]);
        assert_eq!(shown((-0.35, 0.31)), ["−0.2", "0.0", "0.2"]);
        assert_eq!(
            shown((257.0, 257.4)),
            ["257.0", "257.1", "257.2", "257.3", "257.4"]
        );
        assert!(shown((1.0, 1.0)).is_empty() && shown((0.0, f64::INFINITY)).is_empty());
    }

    #[test]
    fn decades_are_whole_powers() {
        let values: Vec<f64> = decades((0.02, 30.0))
            .into_iter()
            .map(|(at, _)| at)
            .collect();
        assert_eq!(values, [0.1, 1.0, 10.0]);
    }
}
