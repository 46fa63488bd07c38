//! The numbers in the cells of a log.

/// The decimal mark of a log's numbers, once known, with the line that showed it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Decimals(Option<(Mark, u64)>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    Point,
    Comma,
}

impl Decimals {
    /// True for a log with decimal commas.
    pub(super) fn are_commas(self) -> bool {
        matches!(self.0, Some((Mark::Comma, _)))
    }

    /// The finite number in a cell of a line.
    ///
    /// # Errors
    /// Why there is none.
    pub(super) fn number(&mut self, cell: &[u8], line: u64) -> Result<f64, String> {
        let no_number = || "it must be any finite number".to_owned();
        let text = std::str::from_utf8(cell.trim_ascii()).map_err(|_| no_number())?;
        let (number, mark) = match text.parse() {
            Ok(number) => (number, Mark::Point),
            Err(_) => (with_comma(text).ok_or_else(no_number)?, Mark::Comma),
        };
        match self.0 {
            Some((known, _)) if known == mark => {}
            _ if mark == Mark::Point && !text.contains('.') => {}
            None => self.0 = Some((mark, line)),
            Some((_, since)) => {
                let [here, there] = match mark {
                    Mark::Point => ["point", "comma"],
                    Mark::Comma => ["comma", "point"],
                };
                return Err(format!(
                    "it has a decimal {here} where line {since} has a decimal {there}: write all \
                     numbers alike, without separators of thousands"
                ));
            }
        }
        match number {
            number if f64::is_finite(number) => Ok(number),
            _ => Err(no_number()),
        }
    }
}

/// A number with one comma before its decimals.
fn with_comma(text: &str) -> Option<f64> {
    let (whole, decimals) = text.split_once(',')?;
    if decimals.contains(',') || text.contains('.') {
        return None;
    }
    format!("{whole}.{decimals}").parse().ok()
}

/// True for a number, with a decimal point or comma; false for infinity and for what is none.
pub(super) fn is_number(cell: &[u8]) -> bool {
    Decimals::default().number(cell, 1).is_ok()
}

/// True for a cell of a row of units: words, or nothing.
pub(super) fn is_words(cell: &[u8]) -> bool {
    match std::str::from_utf8(cell.trim_ascii()) {
        Ok(text) => text.parse::<f64>().is_err() && with_comma(text).is_none(),
        Err(_) => true,
    }
}

#[cfg(test)]
mod tests {
    use super::{Decimals, is_words};

    #[test]
    fn numbers_are_read_with_points_or_with_commas_but_not_both() {
        let read = |cells: &[&str]| {
            let mut decimals = Decimals::default();
            let numbers = cells.iter().zip(1..);
            let read = numbers.map(|(cell, line)| decimals.number(cell.as_bytes(), line));
            read.collect::<Result<Vec<f64>, _>>()
        };
        assert_eq!(
            read(&["1", " -2.5 ", "+3e-3", "1."]),
            Ok(vec![1.0, -2.5, 3e-3, 1.0])
        );
        assert_eq!(
            read(&["1", "-2,5", "3,0e-3", "4"]),
            Ok(vec![1.0, -2.5, 3e-3, 4.0])
        );
        for wrong in [
            "", "fast", "nan", "inf", "1e999", "1,2,3", "1,234.5", "0x10",
        ] {
            let answer = read(&[wrong]).expect_err(wrong);
            assert_eq!(answer, "it must be any finite number", "{wrong}");
        }
        let answer = read(&["1,5", "1.5"]).expect_err("mixed");
        assert!(
            answer.contains("a decimal point where line 1 has a decimal comma"),
            "{answer}"
        );
        let answer = read(&["1.5", "2", "1,5"]).expect_err("mixed");
        assert!(
            answer.contains("a decimal comma where line 1 has a decimal point"),
            "{answer}"
        );
    }

    #[test]
    fn a_unit_is_a_word_and_a_missing_number_is_none() {
        for word in ["s", "rad", "m/s^2", "[V]", "%", ""] {
            assert!(is_words(word.as_bytes()), "{word}");
        }
        for number in ["1", "1,5", "nan", "-inf"] {
            assert!(!is_words(number.as_bytes()), "{number}");
        }
    }
}
