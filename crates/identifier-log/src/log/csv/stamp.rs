//! Time stamps by the calendar and the clock, `2026-11-22T06:25:00.125Z`, as seconds.

/// The seconds of a time stamp since 1970 at the meridian, or since midnight if it has no date. None for a cell that is
/// no time stamp.
///
/// Dates are `2026-11-22`, `2026/11/22` or `22.11.2026`. Times are `06:25:00`, with decimals behind a point or a comma.
/// Zones are `Z`, `+01:00` or `+0100` (ISO 8601 and its usual variants).
pub(super) fn seconds(cell: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(cell.trim_ascii()).ok()?;
    let (date, time) = match text.split_once(['T', ' ', '_']) {
        Some((date, time)) => (Some(date), time.trim_start()),
        None => (None, text),
    };
    let (time, zone) = without_zone(time)?;
    let mut parts = time.split(':');
    let [hours, minutes] = [whole(parts.next()?, 23)?, whole(parts.next()?, 59)?];
    let seconds = match parts.next() {
        Some(seconds) if seconds.starts_with(|c: char| c.is_ascii_digit()) => {
            seconds.replacen(',', ".", 1).parse::<f64>().ok()?
        }
        Some(_) => return None,
        None => 0.0,
    };
    // A leap second is the sixty-first.
    if parts.next().is_some() || !(0.0..61.0).contains(&seconds) {
        return None;
    }
    let days = match date {
        Some(date) => days(date)?,
        None => 0,
    };
    let whole_minutes = days * 1440 + hours * 60 + minutes - zone;
    Some(60.0 * whole_minutes as f64 + seconds)
}

/// A time without its zone, and the zone's minutes east of the meridian.
fn without_zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time.trim_end(), 0));
    }
    let Some(place) = time.find(['+', '-']) else {
        return Some((time, 0));
    };
    let (time, zone) = time.split_at(place);
    let digits = zone[1..].replacen(':', "", 1);
    let (hours, minutes) = match digits.len() {
        2 => (whole(&digits, 14)?, 0),
        4 => (whole(digits.get(..2)?, 14)?, whole(digits.get(2..)?, 59)?),
        _ => return None,
    };
    let east = 60 * hours + minutes;
    let east = if zone.starts_with('-') { -east } else { east };
    Some((time.trim_end(), east))
}

/// The days of a date since 1970-01-01 (H. Hinnant, "chrono-compatible low-level date algorithms", `days_from_civil`).
fn days(date: &str) -> Option<i64> {
    let mut numbers = date.split(['-', '/', '.']);
    let parts = [numbers.next()?, numbers.next()?, numbers.next()?];
    if numbers.next().is_some() {
        return None;
    }
    let [year, month, day] = match parts[0].len() {
        4 => parts,
        _ if parts[2].len() == 4 => [parts[2], parts[1], parts[0]],
        _ => return None,
    };
    let (year, month, day) = (whole(year, 9999)?, whole(month, 12)?, whole(day, 31)?);
    if month == 0 || day == 0 {
        return None;
    }
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let year_of_era = year.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    Some(era * 146_097 + day_of_era - 719_468)
}

/// A whole number up to a largest one.
fn whole(digits: &str, largest: i64) -> Option<i64> {
    let is_short = (1..=4).contains(&digits.len());
    let number = (is_short && digits.bytes().all(|digit| digit.is_ascii_digit()))
        .then(|| digits.parse().ok())??;
    (number <= largest).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn stamps_are_seconds_since_1970_or_midnight() {
        for (cell, expected) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2000-03-01 00:00:00", 951_868_800.0),
            ("2026-11-22T06:25:00.125Z", 1_795_328_700.125),
            ("2026-11-22T07:25:00.125+01:00", 1_795_328_700.125),
            ("2026-11-22T02:55:00,125-0330", 1_795_328_700.125),
            ("22.11.2026 06:25:00,125", 1_795_328_700.125),
            ("2026/11/22 06:25:00.125", 1_795_328_700.125),
            ("06:25:00.125", 23_100.125),
            ("00:01", 60.0),
        ] {
            assert_eq!(seconds(cell.as_bytes()), Some(expected), "{cell}");
        }
        let none = ";1.5;12:;:30;12:60:00;24:00:00;1:2:3:4;2026-13-01T00:00:00;26-11-22T00:00:00;\
                    12:00:inf;12:00:-1;a:b;2026-11-22";
        for cell in none.split(';') {
            assert_eq!(seconds(cell.as_bytes()), None, "{cell}");
        }
    }
}
