use core::ops::ControlFlow;

use super::fitted_servo::FittedServo;
use identifier_core::reason::Reason;

/// The forces that are fitted beside a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Forces {
    None,
    /// A wave of the angle with so many periods to a revolution: one is gravity.
    Wave(f64),
    /// Friction that rises below a speed, of which this is the logarithm over the fastest.
    LowSpeed(f64),
}

/// The search for forces beside a servo that explain its motion. After the servo alone it is gravity, then friction that
/// rises at low speed; or waves, from few periods to many. The speed, or the number of periods, is where the squared errors
/// are least: the vertex of a parabola through three, then through closer ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ForceSearch {
    /// The distance of the numbers of periods, if waves are looked for.
    apart: Option<f64>,
    /// What was found without any, and the squared error that it leaves.
    plain: Option<(Result<FittedServo, Reason>, f64)>,
    /// The best with other forces, with its squared error.
    best: Option<(FittedServo, f64)>,
    /// The waves with which a linear estimate leaves least of the motion, and what it leaves, from the least on.
    likely: [(f64, f64); Self::LIKELY],
    /// The one that is looked around.
    tried: usize,
    place: usize,
    /// The center of the parabola, and the squared errors there, below and above.
    center: f64,
    left: [f64; 3],
}

impl ForceSearch {
    /// The logarithm of the first speed over the fastest, and of the factors between those of a parabola.
    const FIRST_SPEED: f64 = -3.0;
    const SPEEDS: [f64; 3] = [1.4, 0.4, 0.12];

    /// The parts of the distance of two waves between those of a parabola.
    const WAVES: [f64; 3] = [0.5, 0.15, 0.05];

    /// The waves that are looked around, at most.
    const LIKELY: usize = 3;

    /// The distance of two waves over the range of the motion, rad, and the most periods to a revolution.
    const APART: f64 = 1.5;
    const MOST_PERIODS: f64 = 100.0;

    /// The most waves of which a linear estimate is made, as it takes a chip long.
    const MOST_WAVES: usize = 80;

    /// The part of the squared errors of the servo alone, beyond rounding, that forces beside it leave if they act. A
    /// resonance or a dead band looks like some of it. The best of many waves leaves less by chance.
    const LESS: f64 = 0.0625;
    const LESS_OF_WAVES: f64 = 0.01;

    /// The part of it that a first speed or wave leaves if another may explain the motion.
    const PROMISING: f64 = 0.25;

    /// Counts², beyond rounding, that no other would make less.
    const ROUNDING: f64 = 0.1;

    /// For gravity, or friction at low speed.
    pub(super) const BEGIN: Self = Self {
        apart: None,
        plain: None,
        best: None,
        likely: [(0.0, f64::INFINITY); Self::LIKELY],
        tried: 0,
        place: 0,
        center: Self::FIRST_SPEED,
        left: [0.0; 3],
    };

    /// For waves in a motion of this range (rad), of which the servo alone leaves this much, squared, for a reason. None if
    /// the motion is too short to tell any from another.
    pub(super) fn waves(range: f64, plain: (Reason, f64)) -> Option<Self> {
        let (reason, left) = plain;
        let search = Self {
            apart: Some(Self::APART / range),
            plain: Some((Err(reason), left)),
            ..Self::BEGIN
        };
        (search.first() > 0).then_some(search)
    }

    /// Fits before the parabolas.
    fn first(&self) -> usize {
        // Casts saturate.
        (self.apart).map_or(1, |apart| {
            Self::MOST_WAVES.min((Self::MOST_PERIODS / apart) as usize)
        })
    }

    /// The distance of the speeds or waves of a parabola.
    fn width(&self, parabola: usize) -> f64 {
        let (widths, unit) = match self.apart {
            Some(apart) => (Self::WAVES, apart),
            None => (Self::SPEEDS, 1.0),
        };
        unit * widths.get(parabola).copied().unwrap_or(0.0)
    }

    /// Those that are fitted next.
    pub(super) fn forces(&self) -> Forces {
        if self.plain.is_none() {
            return Forces::None;
        }
        let Some(place) = self.place.checked_sub(self.first()) else {
            return Forces::Wave(self.first_wave());
        };
        let side = [0.0, -1.0, 1.0].get(place % 3).copied().unwrap_or(0.0);
        let at = self.center + side * self.width(place / 3);
        match self.apart {
            Some(_) => Forces::Wave(at),
            None => Forces::LowSpeed(at),
        }
    }

    fn first_wave(&self) -> f64 {
        self.apart
            .map_or(1.0, |apart| apart * (self.place + 1) as f64)
    }

    /// The servo and the forces to begin with.
    pub(super) fn begins_with(&self) -> Option<FittedServo> {
        self.best
            .map(|(best, _)| best)
            .filter(|_| self.place > self.first())
    }

    /// True if forces leave so little of the motion, squared, that they act.
    fn is_little(&self, left: f64) -> bool {
        let less = match self.apart {
            Some(_) => Self::LESS_OF_WAVES,
            None => Self::LESS,
        };
        self.plain.is_none_or(|(_, plain)| left < less * plain)
    }

    /// Takes the part of the motion that a linear estimate with one of the first waves leaves: the search with the next
    /// ones. None if the fit is to go on.
    pub(super) fn take_first(&self, left: f64) -> Option<Self> {
        if self.apart.is_none() || self.plain.is_none() || self.place >= self.first() {
            return None;
        }
        let mut next = *self;
        next.rank(self.first_wave(), left);
        next.place += 1;
        (next.center, _) = next.likely[0];
        Some(next)
    }

    /// Ranks a wave among the likely ones, of which neighbours are one.
    fn rank(&mut self, wave: f64, left: f64) {
        let near = 1.5 * self.apart.unwrap_or(0.0);
        let mut carried = (wave, left);
        for likely in &mut self.likely {
            let is_near = libm::fabs(likely.0 - carried.0) < near;
            if carried.1 < likely.1 {
                core::mem::swap(likely, &mut carried);
            }
            if is_near {
                return;
            }
        }
    }

    /// Takes what was found with the forces, and the squared error that it leaves: the search with the next ones, or what
    /// it ends with, which is the best that explains the motion or what was found without forces.
    pub(super) fn take(
        mut self,
        found: Result<FittedServo, Reason>,
        left: f64,
    ) -> ControlFlow<Result<FittedServo, Reason>, Self> {
        let first = self.first();
        let is_gravity = self.apart.is_none() && self.place == 0;
        let explains = found.is_ok_and(|found| found.explains) && self.is_little(left);
        if explains && (is_gravity || left < Self::ROUNDING) {
            return ControlFlow::Break(found);
        }
        let Some((plain, plain_left)) = self.plain else {
            self.plain = Some((found, left));
            return ControlFlow::Continue(self);
        };
        if let Ok(found) = found
            && !is_gravity
            && self.best.is_none_or(|(_, least)| left < least)
        {
            self.best = Some((found, left));
        }
        self.place += 1;
        if let Some(place) = self.place.checked_sub(first + 1) {
            if let Some(one) = self.left.get_mut(place % 3) {
                *one = left;
            }
            if place % 3 == 2 {
                self.center += self.width(place / 3) * vertex(self.left);
            }
        }
        let least = self.best.map_or(f64::INFINITY, |(_, left)| left);
        let parabolas = self.place.saturating_sub(first) / 3;
        // The first speed is a guess, the first wave is not.
        let is_guess = self.apart.is_none() && parabolas == 0;
        if is_guess || (parabolas < Self::SPEEDS.len() && least < Self::PROMISING * plain_left) {
            return ControlFlow::Continue(self);
        }
        let best = self
            .best
            .filter(|(best, left)| best.explains && self.is_little(*left));
        let next = self.likely.get(self.tried + 1).filter(|_| best.is_none());
        if let Some(&(wave, left)) = next
            && left.is_finite()
        {
            (self.center, self.place, self.best) = (wave, first, None);
            self.tried += 1;
            return ControlFlow::Continue(self);
        }
        ControlFlow::Break(best.map_or(plain, |(best, _)| Ok(best)))
    }
}

/// Where a parabola through three values at 0, −1 and 1 is least, within these.
fn vertex([center, below, above]: [f64; 3]) -> f64 {
    let curvature = below - center - center + above;
    if curvature > 0.0 {
        (0.5 * (below - above) / curvature).clamp(-1.0, 1.0)
    } else if below < above {
        -1.0
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identifier_core::parameters::{IdentifiedServo, ServoParameters};
    use identifier_core::tuning::AxisForces;

    #[test]
    fn the_vertex_of_a_parabola_is_found_within_its_points() {
        let through = |at: f64| vertex([0.0, -1.0, 1.0].map(|x| (x - at) * (x - at)));
        for at in [-0.9, 0.0, 0.4] {
            assert!((through(at) - at).abs() < 1e-12);
        }
        for (found, at) in [
            (through(3.0), 1.0),
            (vertex([2.0, 1.0, 3.0]), -1.0),
            (vertex([5.0, 4.0, 3.0]), 1.0),
        ] {
            assert!((found - at).abs() < 1e-12, "{found} {at}");
        }
    }

    fn in_waves(range: f64) -> Option<ForceSearch> {
        ForceSearch::waves(range, (Reason::PartlyExplained, 100.0))
    }

    #[test]
    fn no_wave_is_looked_for_in_a_motion_that_is_too_short_for_any() {
        assert!(in_waves(0.016).is_some());
        assert_eq!([0.014, 0.0].map(in_waves), [None; 2]);
    }

    /// Of waves 2, 4, 6… those that leave least are kept, and of neighbours the better one.
    #[test]
    fn likely_waves_are_those_that_leave_least() {
        let mut search = in_waves(0.75).expect("a period");
        assert_eq!(search.forces(), Forces::Wave(2.0));
        for left in [0.9, 0.3, 0.8, 0.5, 0.7, 0.1, 0.2, 0.6, 0.9] {
            search = search.take_first(left).expect("a first wave");
        }
        assert_eq!(search.likely, [(12.0, 0.1), (4.0, 0.3), (8.0, 0.5)]);
        assert!((search.center - 12.0).abs() < 1e-12);
    }

    /// A wave that leaves two parts of a hundred, and then one of a thousand.
    #[test]
    fn forces_that_leave_too_much_are_not_taken() {
        let fitted = FittedServo {
            servo: IdentifiedServo::known(ServoParameters::new(0.0, 9.0, 1.0, 0.0), 1e-3),
            forces: AxisForces::default(),
            explains: true,
        };
        for (left, is_taken) in [(2.0, false), (0.09, true)] {
            let mut search = in_waves(0.75).expect("a period");
            while let Some(next) = search.take_first(0.5) {
                search = next;
            }
            let found = loop {
                match search.take(Ok(fitted), left) {
                    ControlFlow::Continue(next) => search = next,
                    ControlFlow::Break(found) => break found,
                }
            };
            assert_eq!(found.is_ok(), is_taken, "{left}");
        }
    }
}
