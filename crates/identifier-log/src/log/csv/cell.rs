//! The numbers in the cells of a log.

use super::stamp;

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
        let no_number = || "it must be a finite number".to_owned();
        let cell = name_and_value(cell).map_or(cell, |(_, value)| value);
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

/// True for a number, with a decimal point or comma, for a missing number by its name, as NaN, for a time stamp, and for a list
/// of numbers.
pub(super) fn is_value(cell: &[u8]) -> bool {
    is_number(cell.trim_ascii()) || stamp::seconds(cell).is_some() || list(cell).is_some()
}

fn is_number(cell: &[u8]) -> bool {
    (!cell.is_empty() && is_missing(cell)) || Decimals::default().number(cell, 1).is_ok()
}

/// The elements of a list of numbers: `[0.1, 0.2]`, `(0.1, 0.2)` or `[0.1 0.2]`.
pub(super) fn list(cell: &[u8]) -> Option<Vec<&[u8]>> {
    let ([b'[', inside @ .., b']'] | [b'(', inside @ .., b')']) = cell.trim_ascii() else {
        return None;
    };
    let elements = inside.split(|byte| b", ;\t\n".contains(byte));
    let elements: Vec<_> = elements.filter(|element| !element.is_empty()).collect();
    (!elements.is_empty() && elements.iter().all(|element| is_number(element))).then_some(elements)
}

/// True for a cell of a quantity that was not measured: nothing, or a word for it.
pub(super) fn is_missing(cell: &[u8]) -> bool {
    let cell = cell.trim_ascii();
    let words = [&b"nan"[..], b"null", b"none", b"na", b"n/a", b"-", b"nil"];
    cell.is_empty() || words.iter().any(|word| cell.eq_ignore_ascii_case(word))
}

/// The name and the number of a cell `name:number`.
pub(super) fn name_and_value(cell: &[u8]) -> Option<(&[u8], &[u8])> {
    let place = memchr::memchr2(b':', b'=', cell)?;
    let (name, value) = (cell[..place].trim_ascii(), &cell[place + 1..]);
    let begins = name.first().is_some_and(u8::is_ascii_alphabetic);
    (begins && !value.is_empty()).then_some((name, value))
}

#[cfg(test)]
mod tests {
    use super::{Decimals, is_missing};

    #[test]
    fn numbers_are_read_with_points_or_with_commas_but_not_both() {
        let read = |cells: &[&str]| {
            let mut decimals = Decimals::default();
            let numbers = cells.iter().zip(1..);
            let read = numbers.map(|(cell, line)| decimals.number(cell.as_bytes(), line));
            read.collect::<Result<Vec<f64>, _>>()
        };
        let numbers = Ok(vec![1.0, -2.5, 3e-3, 1.0]);
        assert_eq!(read(&["1", " -2.5 ", "+3e-3", "1."]), numbers);
        assert_eq!(read(&["1", "-2,5", "3,0e-3", "1"]), numbers);
        for wrong in " fast nan inf 1e999 1,2,3 1,234.5 0x10".split(' ') {
            let answer = read(&[wrong]).expect_err(wrong);
            assert_eq!(answer, "it must be a finite number", "{wrong}");
        }
        for (cells, this, first) in [
            (&["1,5", "1.5"][..], "point", "comma"),
            (&["1.5", "2", "1,5"], "comma", "point"),
        ] {
            let answer = read(cells).expect_err("mixed");
            let part = format!("a decimal {this} where line 1 has a decimal {first}");
            assert!(answer.contains(&part), "{answer}");
        }
    }

    #[test]
    fn a_missing_number_is_no_word_and_a_name_may_stand_before_a_number() {
        for cell in ["", " ", "NaN", "-", "null"] {
            assert!(is_missing(cell.as_bytes()), "{cell}");
        }
        for cell in ["0", "s", "inf"] {
            assert!(!is_missing(cell.as_bytes()), "{cell}");
        }
        let number = Decimals::default().number(b"pos: -2.5", 1);
        assert_eq!(number, Ok(-2.5));
    }
}
