//! The half-cycles of a servo, from one turning point to the next.

use identifier_core::number::Number;

/// The present half-cycle. Positions in counts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct HalfCycles<N> {
    motion_direction: N,
    /// Its beginning, and the samples since then.
    turned_at: N,
    since: u32,
    /// The farthest place of it, and the samples since then.
    farthest: N,
    ago: u32,
}

/// A half-cycle that has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HalfCycle<N> {
    /// Counts, without a sign, and samples.
    pub(super) length: N,
    pub(super) samples: u32,
}

impl<N: Number> HalfCycles<N> {
    /// The longest distance that is no half-cycle, counts. It is an edge of the encoder to either side, and the
    /// rounding.
    const TURNED: f64 = 2.5;

    /// From a place.
    pub(super) fn from(position: N) -> Self {
        Self {
            motion_direction: N::ONE,
            turned_at: position,
            farthest: position,
            ..Self::default()
        }
    }

    /// Takes a sample and returns the half-cycle that has ended, if any.
    pub(super) fn take(&mut self, position: N) -> Option<HalfCycle<N>> {
        self.since = self.since.saturating_add(1);
        self.ago = self.ago.saturating_add(1);
        let on = self.motion_direction * (position - self.farthest);
        if on > N::ZERO {
            (self.farthest, self.ago) = (position, 0);
        }
        let half_cycle = HalfCycle {
            length: (self.farthest - self.turned_at).magnitude(),
            samples: self.since - self.ago,
        };
        let least = N::from_f64(Self::TURNED);
        let is_half_cycle = half_cycle.length > least;
        if on >= N::ZERO || !is_half_cycle && on >= -least {
            return None;
        }
        *self = Self {
            motion_direction: -self.motion_direction,
            turned_at: self.farthest,
            since: self.ago,
            farthest: position,
            ago: 0,
        };
        is_half_cycle.then_some(half_cycle)
    }
}

impl<N: Number> HalfCycle<N> {
    /// True if its mean speed exceeded this one, counts a sample. It must also be shorter than the half period of a
    /// bandwidth, ω T.
    pub(super) fn is_faster(&self, speed: N, bandwidth: N) -> bool {
        let samples = N::from_count(self.samples.min(1 << 20) as i32);
        self.length > speed * samples && bandwidth * samples < N::from_f64(core::f64::consts::PI)
    }

    /// True if it needed more than an acceleration, counts a sample², for half of it. The other half needs as much
    /// against it: L > ẍ t²/4.
    pub(super) fn is_harder(&self, acceleration: N) -> bool {
        let samples = N::from_count(self.samples.min(1 << 12) as i32);
        self.length > N::from_f64(0.25) * acceleration * samples * samples
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    /// The ends of the half-cycles of a sine with an amplitude in counts and a period in samples. The drift is in
    /// counts a sample.
    fn half_cycles(amplitude: f64, period: f64, drift: f64) -> Vec<HalfCycle<f32>> {
        let mut half_cycles = HalfCycles::from(0.0_f32);
        let position = |sample: u32| {
            let time = f64::from(sample);
            let angle = core::f64::consts::TAU * time / period;
            (amplitude * libm::sin(angle) + drift * time).floor() as f32
        };
        let samples = (10.0 * period) as u32;
        (0..samples)
            .filter_map(|sample| half_cycles.take(position(sample)))
            .collect()
    }

    #[test]
    fn a_half_cycle_lasts_from_one_turning_point_to_the_next_at_every_rate() {
        for (period, bandwidth) in [(20.0, 0.1), (80.0, 0.02), (400.0, 5e-3)] {
            let ended = half_cycles(100.0, period, 0.0);
            // The first begins in the middle, and the last has not ended.
            assert!((17..=20).contains(&ended.len()), "{}", ended.len());
            for half_cycle in &ended[1..] {
                assert!((f64::from(half_cycle.samples) / (0.5 * period) - 1.0).abs() < 0.15);
                assert!((half_cycle.length - 200.0).abs() < 6.0);
                let speed = 400.0 / period as f32;
                assert!(half_cycle.is_faster(0.8 * speed, bandwidth));
                assert!(!half_cycle.is_faster(1.2 * speed, bandwidth));
                // As long as the half period of the bandwidth, or longer.
                assert!(!half_cycle.is_faster(0.8 * speed, 5.0 * bandwidth));
                // As if by a constant acceleration: 4 L/t².
                let acceleration = 3200.0 / (period * period) as f32;
                assert!(half_cycle.is_harder(0.7 * acceleration));
                assert!(!half_cycle.is_harder(1.4 * acceleration));
            }
        }
    }

    #[test]
    fn an_edge_to_either_side_is_no_half_cycle() {
        assert!(half_cycles(1.0, 20.0, 0.0).is_empty());
        // Nor on a motion one way.
        assert!(half_cycles(1.0, 20.0, 0.5).is_empty());
    }

    #[test]
    fn a_half_cycle_ends_by_coming_back_whichever_way_it_begins() {
        let mut half_cycles = HalfCycles::from(0.0_f32);
        assert_eq!(half_cycles.take(-10.0), None);
        assert_eq!(half_cycles.take(-20.0), None);
        let half_cycle = half_cycles.take(-5.0).expect("it came back");
        assert!((half_cycle.length - 20.0).abs() < 1e-6);
        assert_eq!(half_cycle.samples, 2);
    }
}
