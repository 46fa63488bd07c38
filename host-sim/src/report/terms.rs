//! A table of the optional terms that have entered the model.

use identifier_core::parameters::Unknown;
use virtual_servo::Effects;

use crate::render::terminal::table::Rows;
use crate::result::Summary;

/// One row for each size of a term, with the truth where there is one; empty where none has entered.
/// Of a term without a size, when it entered.
#[must_use]
pub fn terms(summary: &Summary, truth: Option<&Effects>, width: u16) -> String {
    let outcome = &summary.outcome;
    if outcome.entered.is_empty() {
        return String::new();
    }
    let seconds = |sample: u64| format!("{:.2}", sample as f64 * summary.sample_time);
    let columns = 5 + usize::from(truth.is_some());
    let mut table = Rows::default().words("term").figures("size");
    table = table.figures("standard error").words("unit");
    if truth.is_some() {
        table = table.figures("truth");
    }
    table = table.figures("since [s]").dispensable(0);
    for term in &outcome.terms {
        let digits = digits(term.std_error);
        let mut row = vec![
            term.unknown.name().to_owned(),
            format!("{:.digits$}", term.value),
            format!("{:.digits$}", term.std_error),
            term.unknown.unit().to_owned(),
        ];
        row.extend(truth.map(|effects| self::truth(effects, term.unknown).to_string()));
        row.push(seconds(term.since));
        table.row(row);
    }
    let has_size = |term| {
        let mut sizes = outcome.terms.iter();
        sizes.any(|size| size.unknown.term() == Some(term))
    };
    for (term, since) in outcome.entered.iter().filter(|(term, _)| !has_size(*term)) {
        let mut row = vec![String::new(); columns];
        row[0] = term.name().to_owned();
        row[columns - 1] = seconds(*since);
        table.row(row);
    }
    table.within(width)
}

/// Digits behind the point that show two of a standard error.
fn digits(std_error: f64) -> usize {
    /// What a table has room for.
    const MOST: f64 = 9.0;
    if std_error > 0.0 && std_error.is_finite() {
        (1.0 - std_error.log10().floor()).clamp(0.0, MOST) as usize
    } else {
        MOST as usize
    }
}

/// The true size, SI; zero for what is no term.
#[must_use]
pub fn truth(effects: &Effects, unknown: Unknown) -> f64 {
    match unknown {
        Unknown::Delay => effects.delay,
        Unknown::Asymmetry => effects.asymmetry,
        Unknown::LowSpeed => effects.low_speed_friction,
        Unknown::GravitySine => effects.gravity[0],
        Unknown::GravityCosine => effects.gravity[1],
        Unknown::RippleSine => effects.ripple[0],
        Unknown::RippleCosine => effects.ripple[1],
        Unknown::DeadBand => effects.dead_band,
        Unknown::A | Unknown::B | Unknown::Coulomb | Unknown::Load => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn two_digits_of_a_standard_error_are_shown() {
        for (std_error, shown) in [(1.5e-6, 7), (0.03, 3), (2.0, 1), (40.0, 0), (0.0, 9)] {
            assert_eq!(digits(std_error), shown, "{std_error}");
        }
    }
}
