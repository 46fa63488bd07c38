//! A motion that repeats itself to a count. Its later periods have the rounding of the first again.

use super::fitter::RecordFitter;
use super::{Horizon, Record, Values};

impl RecordFitter<'_> {
    /// Rows per row that says something new. The part of the innovations that is the same in every period is averaged
    /// out by none of them. One for a motion that does not repeat itself, and under noise that does not.
    pub(super) fn repeated(&self, values: &Values, horizon: Horizon) -> f64 {
        /// Deviations of a correlation that chance has.
        const BY_CHANCE: f64 = 3.0;
        let rows = self.record.len();
        let Some(period) = period(self.record) else {
            return 1.0;
        };
        let mut innovations = vec![0.0; rows];
        self.pass(values, horizon).run(values, &[], &mut |row| {
            innovations[row.sample] = row.innovation;
        });
        // The first period may begin at rest.
        let [mut squares, mut products] = [0.0; 2];
        for (one, next) in innovations[period..].iter().zip(&innovations[2 * period..]) {
            squares += one * one;
            products += one * next;
        }
        let pairs = ((rows - 2 * period) / self.record.stride.max(1)) as f64;
        let same = products / squares - BY_CHANCE / libm::sqrt(pairs);
        1.0 + (rows as f64 / period as f64 - 1.0) * same.clamp(0.0, 1.0)
    }
}

/// The samples after which the second half of a record repeats itself to a count, if they are no more than a quarter of it.
fn period(record: &Record<'_>) -> Option<usize> {
    let positions = record.positions;
    let rows = positions.len();
    let mean = positions.iter().sum::<f64>() / rows as f64;
    let square = positions
        .iter()
        .map(|at| (at - mean) * (at - mean))
        .sum::<f64>();
    let band = 0.5 * libm::sqrt(square / rows as f64);
    let mut is_low = false;
    let rises = (0..rows).filter(|&sample| {
        let beyond = positions[sample] - mean;
        let rises = is_low && beyond > band;
        is_low = beyond < -band || (is_low && !rises);
        rises
    });
    let rises: Vec<usize> = rises.collect();
    let &first = rises.get(1)?;
    let lags = rises[2..].iter().map(|rise| rise - first);
    let mut lags = lags.take_while(|lag| 4 * lag <= rows);
    lags.find(|lag| {
        let late = &positions[rows / 2..];
        let mut pairs = late.iter().zip(&late[*lag..]);
        let (count, mut apart) = (pairs.len() as f64, 0.0);
        lag.is_multiple_of(record.stride.max(1))
            && pairs.all(|(one, next)| {
                apart += (one - next) * (one - next);
                apart <= count
            })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_repeats_itself_if_every_period_has_the_same_counts() {
        let period_of = |position: &dyn Fn(f64) -> f64| {
            let positions: Vec<f64> = (0..2000).map(|k| position(f64::from(k)).round()).collect();
            period(&Record::of(&positions, &[]))
        };
        let wave = |period: f64, k: f64| 300.0 * (std::f64::consts::TAU * k / period).sin();
        assert_eq!(period_of(&|k| wave(100.0, k)), Some(100));
        // A start from rest dies out.
        let start = |k: f64| 90.0 * (-0.02 * k).exp();
        assert_eq!(period_of(&|k| wave(100.0, k) + start(k)), Some(100));
        assert_eq!(period_of(&|k| wave(100.0, k) + wave(50.0, k)), Some(100));
        assert_eq!(period_of(&|k| wave(150.5, k)), Some(301));
        assert_eq!(period_of(&|k| wave(100.0, k) + 0.1 * k), None);
        assert_eq!(period_of(&|k| wave(100.0, k) + wave(61.8, k)), None);
        assert_eq!(period_of(&|k| wave(1000.0, k)), None);
        assert_eq!(period_of(&|_| 0.0), None);
    }
}
