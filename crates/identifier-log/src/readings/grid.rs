//! The grid that recorded positions lie on: the counts of an encoder, or the decimals of a log.

/// The different positions of a log, column units, ascending from the lowest at zero.
#[derive(Debug, Clone)]
pub(crate) struct Positions(Vec<f64>);

impl Positions {
    /// Fewest different positions that show a grid.
    const MIN_COUNT: usize = 20;
    /// Most that are examined.
    const MAX_COUNT: usize = 20_000;
    /// Part of the range below which two positions are one.
    const GRID_TOLERANCE: f64 = 1e-9;

    /// Those among some; none where there are too few to show a grid.
    pub(crate) fn of(positions: impl Iterator<Item = f64>) -> Option<Self> {
        let mut all: Vec<f64> = positions.collect();
        all.sort_unstable_by(f64::total_cmp);
        let (lowest, highest) = (*all.first()?, *all.last()?);
        let least = Self::GRID_TOLERANCE * (highest - lowest);
        all.iter_mut().for_each(|position| *position -= lowest);
        all.dedup_by(|next, before| *next - *before <= least);
        // The lowest of them are neighbours, which a step is measured from.
        all.truncate(Self::MAX_COUNT);
        (all.len() >= Self::MIN_COUNT).then_some(Self(all))
    }

    /// True if each lies on a multiple of a step of its own, to a tenth of the step.
    pub(crate) fn lie_on(&self, step: f64) -> bool {
        /// Largest distance from a multiple, as a part of the step, and the share of positions within it. By chance the
        /// share is a fifth.
        const MAX_DISTANCE: f64 = 0.1;
        const MIN_SHARE: f64 = 0.85;
        let mut last = None;
        let mut on = 0.0;
        for position in &self.0 {
            let steps = position / step;
            let multiple = steps.round();
            if (steps - multiple).abs() <= MAX_DISTANCE && last != Some(multiple) {
                on += 1.0;
                last = Some(multiple);
            }
        }
        on >= MIN_SHARE * self.0.len() as f64
    }

    /// The largest step that they lie on multiples of; none for a position without steps.
    pub(crate) fn step(&self) -> Option<f64> {
        /// Smallest differences are at most this many steps.
        const MAX_STEPS: u32 = 6;
        let differences = self.0.windows(2).map(|pair| pair[1] - pair[0]);
        let smallest = differences.min_by(f64::total_cmp)?;
        (1..=MAX_STEPS)
            .map(|steps| self.refined(smallest / f64::from(steps)))
            .find(|step| self.lie_on(*step))
    }

    /// A step that is nearly right, by least squares over ever longer distances.
    fn refined(&self, step: f64) -> f64 {
        const MAX_DISTANCE: f64 = 0.25;
        let (mut step, mut products, mut squares) = (step, 0.0, 0.0);
        for distance in &self.0[1..] {
            let steps = (distance / step).round();
            if steps > 0.0 && (distance / step - steps).abs() < MAX_DISTANCE {
                products += distance * steps;
                squares += steps * steps;
                step = products / squares;
            }
        }
        step
    }

    /// True if they are whole numbers of some thousandfold or finer part of one: written with a few decimals.
    pub(crate) fn is_decimal(step: f64) -> bool {
        /// Rounding of the step.
        const TOLERANCE: f64 = 1e-5;
        let decade = 10_f64.powf(step.log10().floor());
        let leading = step / decade;
        [1.0, 2.0, 5.0, 10.0]
            .iter()
            .any(|x| (leading / x - 1.0).abs() < TOLERANCE)
    }
}

/// True for a number of counts that is whole, as that of an encoder is, and not by chance.
pub(crate) fn is_whole(counts: f64) -> bool {
    const MAX_DISTANCE: f64 = 0.02;
    (20.0..1e7).contains(&counts) && (counts - counts.round()).abs() < MAX_DISTANCE
}

/// True for a number of counts that encoders have: a product of twos and fives, and at most two threes.
pub(crate) fn is_usual(counts: f64) -> bool {
    if !is_whole(counts) {
        return false;
    }
    let mut rest = counts.round() as u64;
    for (factor, times) in [(2, 32), (5, 5), (3, 2)] {
        for _ in 0..times {
            if rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
    }
    rest == 1
}
