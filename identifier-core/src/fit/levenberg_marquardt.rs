//! Levenberg's and Marquardt's method between two passes over a record. It decides whether a pass helped, how much the
//! next step is damped, and where it leads.

use crate::linalg::{Factor, NormalEquations};
use crate::number::Number;

/// The factor by which a better or worse pass changes the damping.
const DAMPING_FACTOR: f64 = 10.0;

/// How a descent begins and ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DescentSettings {
    /// The damping of the first step, a part of the diagonal.
    pub damping: f64,
    /// The most passes.
    pub max_passes: u32,
    /// A pass that changes the cost by less than this fraction is the last.
    pub min_change: f64,
}

/// A pass over a record as a fit keeps it. Its sum of squared errors is the cost that compares passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Explanation<N, const Q: usize, T = ()> {
    /// Its unknowns.
    pub unknowns: [N; Q],
    /// The normal equations at them.
    pub equations: NormalEquations<N, Q>,
    /// Other sums of the pass.
    pub sums: T,
}

impl<N: Number, const Q: usize, T> Explanation<N, Q, T> {
    /// True if it explains more than another.
    pub fn is_better_than(&self, other: Option<&Self>) -> bool {
        other.is_none_or(|other| self.equations.cost() < other.equations.cost())
    }
}

/// A descent from a start: the best pass so far, and the damping of the next step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Descent<N, const Q: usize, T = ()> {
    best: Option<Explanation<N, Q, T>>,
    damping: N,
    passes: u32,
}

impl<N: Number, const Q: usize, T: Copy> Descent<N, Q, T> {
    /// Before the first pass.
    pub fn begin(settings: &DescentSettings) -> Self {
        Self {
            best: None,
            damping: N::from_f64(settings.damping),
            passes: 0,
        }
    }

    /// The pass that explains most; none before the first, or if none has a finite cost.
    pub fn best(&self) -> Option<&Explanation<N, Q, T>> {
        self.best.as_ref()
    }

    /// Takes a pass. Returns the unknowns of the next one: those of the best plus a damped step of the `free` ones. The
    /// first P stay within bounds. None if this was the last.
    pub fn descend<const P: usize>(
        &mut self,
        settings: &DescentSettings,
        pass: Explanation<N, Q, T>,
        free: [bool; Q],
        bounds: [&[N; P]; 2],
    ) -> Option<[N; Q]> {
        let mut step = self.take(settings, pass, free)?;
        loop {
            if let Some(next) = self.step_on(&mut step, bounds)? {
                return Some(next);
            }
        }
    }

    /// Takes a pass, and begins the step to the next one. None if this was the last.
    pub fn take(
        &mut self,
        settings: &DescentSettings,
        pass: Explanation<N, Q, T>,
        free: [bool; Q],
    ) -> Option<DescentStep<N, Q>> {
        let cost = pass.equations.cost();
        let least = self.best().map(|best| best.equations.cost());
        let helped = cost.is_finite() && pass.is_better_than(self.best());
        let enough = N::from_f64(settings.min_change);
        let was_little = least.is_some_and(|least| (least - cost).magnitude() <= enough * least);
        let change = if helped {
            1.0 / DAMPING_FACTOR
        } else {
            DAMPING_FACTOR
        };
        self.damping = self.damping * N::from_f64(change);
        if helped {
            self.best = Some(pass);
        }
        self.passes += 1;
        if was_little || self.passes >= settings.max_passes {
            return None;
        }
        let equations = &self.best()?.equations;
        let factor = equations.begin_factor(self.damping, &free);
        Some(DescentStep { free, factor })
    }

    /// Goes on with a step. Returns the unknowns that it leads to once it is found; none of a descent without a pass.
    pub fn step_on<const P: usize>(
        &self,
        DescentStep { free, factor }: &mut DescentStep<N, Q>,
        [low, high]: [&[N; P]; 2],
    ) -> Option<Option<[N; Q]>> {
        let best = self.best()?;
        let (unknowns, equations) = (&best.unknowns, &best.equations);
        let Some(step) = equations.solve_on(factor) else {
            return Some(None);
        };
        let mut held = false;
        for i in 0..P {
            let at = unknowns[i];
            let outward =
                (at <= low[i] && step[i] < N::ZERO) || (at >= high[i] && step[i] > N::ZERO);
            if free[i] && outward {
                free[i] = false;
                held = true;
            }
        }
        if held {
            *factor = equations.begin_factor(self.damping, free);
            return Some(None);
        }
        let mut next = moved(unknowns, &step);
        for ((value, &low), &high) in next.iter_mut().zip(low).zip(high) {
            *value = value.limited(low, high);
        }
        Some(Some(next))
    }
}

/// A damped step that is being found, in parts. An unknown at a bound that would leave it is kept there. The step is taken
/// without it, so that the others do not compensate for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DescentStep<N, const Q: usize> {
    free: [bool; Q],
    factor: Factor<N, Q>,
}

/// Unknowns moved by a step; one that would cease to be finite stays.
fn moved<N: Number, const Q: usize>(unknowns: &[N; Q], step: &[N; Q]) -> [N; Q] {
    core::array::from_fn(|i| {
        let moved = unknowns[i] + step[i];
        if moved.is_finite() {
            moved
        } else {
            unknowns[i]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::{Descent, DescentSettings, Explanation, moved};
    use crate::linalg::NormalEquations;

    const SETTINGS: DescentSettings = DescentSettings {
        damping: 1.0,
        max_passes: 6,
        min_change: 1e-3,
    };

    /// Descends by passes of these costs, the unknown being the number of the pass. True for one that was the last.
    fn judged<const C: usize>(costs: [f64; C]) -> (Descent<f64, 1>, [bool; C]) {
        let mut descent = Descent::begin(&SETTINGS);
        let mut number = 0.0;
        let last = costs.map(|cost| {
            let mut equations = NormalEquations::default();
            equations.add(&[0.0], cost.sqrt());
            number += 1.0;
            let pass = Explanation {
                unknowns: [number],
                equations,
                sums: (),
            };
            let next = descent.descend(&SETTINGS, pass, [true], [&[], &[]]);
            next.is_none()
        });
        (descent, last)
    }

    fn best(descent: &Descent<f64, 1>) -> Option<u32> {
        descent.best().map(|best| best.unknowns[0] as u32)
    }

    #[test]
    fn a_better_pass_is_kept_and_damped_less_and_a_worse_one_damped_more() {
        let (better, last) = judged([4.0, 2.0]);
        assert_eq!((best(&better), last), (Some(2), [false; 2]));
        assert!((better.damping - 0.01).abs() < 1e-12);
        let (worse, last) = judged([4.0, 2.0, 3.0]);
        assert_eq!((best(&worse), last), (Some(2), [false; 3]));
        assert!((worse.damping - 0.1).abs() < 1e-12);
    }

    #[test]
    fn the_first_pass_is_kept_unless_its_cost_is_not_finite() {
        let (descent, last) = judged([f64::NAN]);
        assert_eq!((best(&descent), last), (None, [true]));
        let (descent, last) = judged([1.0, f64::NAN]);
        assert_eq!((best(&descent), last), (Some(1), [false; 2]));
    }

    #[test]
    fn a_small_change_in_either_direction_or_too_many_passes_are_the_end() {
        assert_eq!(judged([1.0, 0.9999]).1, [false, true]);
        assert_eq!(judged([1.0, 1.0001]).1, [false, true]);
        assert_eq!(judged([1.0, 0.99]).1, [false, false]);
        let many = judged([64.0, 32.0, 16.0, 8.0, 4.0, 2.0]).1;
        assert_eq!(many, [false, false, false, false, false, true]);
    }

    #[test]
    fn the_next_unknowns_are_within_their_bounds() {
        let mut descent = Descent::begin(&SETTINGS);
        let mut equations = NormalEquations::<f64, 2>::default();
        equations.add(&[1.0, 0.0], 9.0);
        equations.add(&[0.0, 1.0], 9.0);
        let pass = Explanation {
            unknowns: [1.0; 2],
            equations,
            sums: (),
        };
        let next = descent.descend(&SETTINGS, pass, [true; 2], [&[0.0], &[2.0]]);
        let next = next.expect("a further pass");
        assert!((next[0] - 2.0).abs() < 1e-12 && next[1] > 5.0, "{next:?}");
    }

    /// Two unknowns have nearly the same effect on the measurement. If one is held at its bound, the other reaches its
    /// own best value. The unbounded solution is far from it.
    #[test]
    fn one_at_its_bound_is_not_compensated_for() {
        let mut equations = NormalEquations::<f64, 2>::default();
        for (regressor, error) in [([1.0, 1.0], 1.0), ([1.0, 0.9], 0.5)] {
            equations.add(&regressor, error);
        }
        for (lowest, expected) in [(-9.0, [-4.0, 5.0]), (0.0, [0.0, 1.45 / 1.81])] {
            let low = [lowest, -9.0];
            let undamped = DescentSettings {
                damping: 0.0,
                ..SETTINGS
            };
            let pass = Explanation {
                unknowns: [0.0; 2],
                equations,
                sums: (),
            };
            let next =
                Descent::begin(&undamped).descend(&undamped, pass, [true; 2], [&low, &[9.0; 2]]);
            let found = next.expect("a step");
            let off = [0, 1].map(|i| found[i] - expected[i]);
            assert!(off.iter().all(|off| off.abs() < 1e-6), "{found:?}");
            assert!(found[0] >= lowest - 1e-12);
        }
    }

    #[test]
    fn an_unknown_with_an_infinite_step_stays() {
        let [stays, moves] = moved(&[1.0, 2.0], &[f64::INFINITY, 0.5]);
        assert!((stays - 1.0_f64).abs() < 1e-12 && (moves - 2.5).abs() < 1e-12);
    }
}
