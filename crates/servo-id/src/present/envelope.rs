//! Traces of any length in bounded memory, as a figure needs them.
//!
//! The lowest and the highest point of each segment of a trace are kept. More is invisible in a segment narrower than a
//! pixel, and no peak is lost (U. Jugel, Z. Jerzak, G. Hackenbroich and V. Markl, "M4: A visualization-oriented time
//! series data aggregation", Proceedings of the VLDB Endowment 7(10), 2014).

use super::Trace;

/// A trace that is gathered point by point. Up to [`Envelope::MAX_BUCKETS`] points all are kept. Beyond, the lowest
/// and highest of segments that grow with its length are kept.
#[derive(Debug, Clone, Default)]
pub struct Envelope {
    buckets: Vec<Bucket>,
    /// Points to a full segment, as a power of two.
    doublings: u32,
    in_newest: u64,
    newest: Option<Point>,
}

#[derive(Debug, Clone, Copy)]
struct Bucket {
    lowest: Point,
    highest: Point,
}

#[derive(Debug, Clone, Copy)]
struct Point {
    place: f64,
    value: f64,
    half_width: Option<f64>,
}

impl Bucket {
    /// Joined with the next one.
    fn and(self, next: Self) -> Self {
        Self {
            lowest: if next.lowest.value < self.lowest.value {
                next.lowest
            } else {
                self.lowest
            },
            highest: if next.highest.value > self.highest.value {
                next.highest
            } else {
                self.highest
            },
        }
    }

    /// The points that are drawn, in the trace's order.
    fn points(&self) -> impl Iterator<Item = Point> {
        let (first, second) = if self.lowest.place <= self.highest.place {
            (self.lowest, self.highest)
        } else {
            (self.highest, self.lowest)
        };
        std::iter::once(first).chain((second.place > first.place).then_some(second))
    }
}

impl Envelope {
    /// Stretches that are kept at most: more than a figure has pixels across. An even number.
    pub const MAX_BUCKETS: usize = 1500;

    /// Takes in the next point, with half the width of its confidence band where it has one. A value that is
    /// not finite is left out.
    pub fn add(&mut self, place: f64, value: f64, half_width: Option<f64>) {
        if !value.is_finite() {
            return;
        }
        let point = Point {
            place,
            value,
            half_width,
        };
        let bucket = Bucket {
            lowest: point,
            highest: point,
        };
        self.newest = Some(point);
        match self.buckets.last_mut() {
            Some(last) if self.in_newest < 1 << self.doublings => {
                *last = last.and(bucket);
                self.in_newest += 1;
            }
            _ => {
                if self.buckets.len() == Self::MAX_BUCKETS {
                    self.double();
                }
                self.buckets.push(bucket);
                self.in_newest = 1;
            }
        }
    }

    /// Joins every two segments.
    fn double(&mut self) {
        self.buckets = self
            .buckets
            .chunks(2)
            .filter_map(|pair| pair.iter().copied().reduce(Bucket::and))
            .collect();
        self.doublings += 1;
    }

    /// True without a point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.buckets.is_empty()
    }

    /// The lowest and the highest value after this part of the trace, from 0 to 1, at its beginning.
    #[must_use]
    pub fn range_after(&self, part: f64) -> Option<(f64, f64)> {
        let left_out = (part * self.buckets.len() as f64) as usize;
        let rest = self.buckets.get(left_out..)?;
        rest.iter()
            .copied()
            .reduce(Bucket::and)
            .map(|all| (all.lowest.value, all.highest.value))
    }

    /// The trace to be drawn. It has a band if a point has one, of no width where there is none yet.
    #[must_use]
    pub fn trace(&self, name: &str) -> Trace {
        let mut points: Vec<Point> = self.buckets.iter().flat_map(Bucket::points).collect();
        // The trace reaches its end.
        let end = self.newest.filter(|newest| {
            let drawn = points.last().map(|last| last.place);
            drawn.is_some_and(|drawn| drawn < newest.place)
        });
        points.extend(end);
        let has_band = points.iter().any(|point| point.half_width.is_some());
        let band = points.iter().map(|point| point.half_width.unwrap_or(0.0));
        Trace {
            name: name.to_owned(),
            points: points.iter().map(|p| (p.place, p.value)).collect(),
            band: band.filter(|_| has_band).collect(),
        }
    }
}

impl FromIterator<(f64, f64)> for Envelope {
    fn from_iter<I: IntoIterator<Item = (f64, f64)>>(points: I) -> Self {
        let mut envelope = Self::default();
        for (place, value) in points {
            envelope.add(place, value, None);
        }
        envelope
    }
}

#[cfg(test)]
mod tests {
    use super::Envelope;

    fn points(count: u32) -> impl Iterator<Item = (f64, f64)> {
        (0..count).map(|k| (f64::from(k), (0.37 * f64::from(k)).sin()))
    }

    #[test]
    fn a_short_trace_is_kept_as_it_is() {
        let most = Envelope::MAX_BUCKETS as u32;
        let trace = points(most).collect::<Envelope>().trace("");
        assert_eq!(trace.points, points(most).collect::<Vec<_>>());
    }

    #[test]
    fn a_long_trace_stays_small_and_keeps_every_peak_the_order_and_the_end() {
        for count in [1501, 3001, 1_000_003] {
            for peak in [0, 1, 777, count / 2, count - 2, count - 1] {
                let envelope: Envelope = points(count)
                    .map(|(place, value)| {
                        let here = place as u32 == peak;
                        (place, if here { 9.0 } else { value })
                    })
                    .collect();
                let trace = envelope.trace("");
                assert!(trace.points.len() <= 2 * Envelope::MAX_BUCKETS + 1);
                assert!(trace.points.len() >= Envelope::MAX_BUCKETS / 2);
                assert!(trace.points.contains(&(f64::from(peak), 9.0)));
                assert!(trace.points.is_sorted_by(|x, y| x.0 < y.0));
                let end = trace.points.last().map(|end| end.0);
                assert_eq!(end, Some(f64::from(count - 1)));
            }
        }
    }

    #[test]
    fn a_range_leaves_the_beginning_out() {
        let values = [9.0, -9.0, 1.0, 2.0, 3.0, 1.5, 1.0, 1.0, 1.0, 1.0];
        let places = (0..).map(f64::from);
        let envelope: Envelope = places.zip(values).collect();
        assert_eq!(envelope.range_after(0.2), Some((1.0, 3.0)));
        assert_eq!(Envelope::default().range_after(0.2), None);
    }

    #[test]
    fn a_band_is_kept_with_the_points_it_belongs_to() {
        let mut envelope = Envelope::default();
        for (place, value) in points(10_000) {
            envelope.add(place, value, Some(2.0 * value));
        }
        let trace = envelope.trace("");
        assert_eq!(trace.band.len(), trace.points.len());
        let belongs = |((_, value), half): (&(f64, f64), &f64)| (half - 2.0 * value).abs() < 1e-12;
        assert!(trace.points.iter().zip(&trace.band).all(belongs));
        envelope.add(10_000.0, 0.0, None);
        assert_eq!(envelope.trace("").band.last(), Some(&0.0));
        let bare: Envelope = points(10).collect();
        assert!(bare.trace("").band.is_empty());
    }
}
