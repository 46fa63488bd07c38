//! The decisions of Levenberg's and Marquardt's method between two passes over a record: whether a pass
//! helped, how much the next is damped, and where it goes.

use crate::linalg::NormalEquations;
use crate::number::Number;

/// The factor by which a better or worse pass changes the damping.
const DAMPING_FACTOR: f64 = 10.0;

/// The judgement of a pass against the best before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Judged {
    /// It is the best so far.
    pub(crate) helped: bool,
    /// It changed the cost by so little that the next would as well.
    pub(crate) was_little: bool,
}

/// Judges a pass by its cost and the least before it, and damps the next one accordingly. A change by less
/// than the fraction `enough` of the least is little.
pub(crate) fn judge<N: Number>(cost: N, least: Option<N>, enough: f64, damping: &mut N) -> Judged {
    let helped = cost.is_finite() && least.is_none_or(|least| cost < least);
    let was_little =
        least.is_some_and(|least| (least - cost).magnitude() <= N::from_f64(enough) * least);
    let change = if helped {
        1.0 / DAMPING_FACTOR
    } else {
        DAMPING_FACTOR
    };
    *damping = *damping * N::from_f64(change);
    Judged { helped, was_little }
}

/// The damped step from unknowns of which the first P have bounds. One at a bound that would leave it is
/// kept there, and the step is taken without it, so that the others do not compensate for it.
pub(crate) fn bounded_step<N: Number, const P: usize, const Q: usize>(
    equations: &NormalEquations<N, Q>,
    unknowns: &[N; Q],
    damping: N,
    mut free: [bool; Q],
    low: &[N; P],
    high: &[N; P],
) -> [N; Q] {
    let mut step = equations.solve(damping, &free);
    for _ in 0..P {
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
        if !held {
            break;
        }
        step = equations.solve(damping, &free);
    }
    step
}

/// Unknowns moved by a step; one that would cease to be finite stays.
pub(crate) fn moved<N: Number, const Q: usize>(unknowns: &[N; Q], step: &[N; Q]) -> [N; Q] {
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
    use super::{Judged, bounded_step, judge, moved};
    use crate::linalg::NormalEquations;

    #[test]
    fn a_better_pass_is_damped_less_and_a_worse_one_more() {
        let mut damping = 1.0;
        let better = judge(2.0, Some(4.0), 1e-3, &mut damping);
        assert_eq!(
            better,
            Judged {
                helped: true,
                was_little: false
            }
        );
        assert!((damping - 0.1_f64).abs() < 1e-12);
        let worse = judge(4.0, Some(2.0), 1e-3, &mut damping);
        assert_eq!(
            worse,
            Judged {
                helped: false,
                was_little: false
            }
        );
        assert!((damping - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_first_pass_helps_unless_it_is_not_finite() {
        let judged = judge(2.0, None, 1e-3, &mut 1.0);
        assert_eq!(
            judged,
            Judged {
                helped: true,
                was_little: false
            }
        );
        assert!(!judge(f64::NAN, None, 1e-3, &mut 1.0).helped);
        assert!(!judge(f64::NAN, Some(1.0), 1e-3, &mut 1.0).helped);
    }

    #[test]
    fn a_small_change_is_little_in_either_direction() {
        assert!(judge(0.9999, Some(1.0), 1e-3, &mut 1.0).was_little);
        assert!(judge(1.0001, Some(1.0), 1e-3, &mut 1.0).was_little);
        assert!(!judge(0.99, Some(1.0), 1e-3, &mut 1.0).was_little);
    }

    /// Two unknowns with nearly the same effect on the measurement: held at its bound, one leaves the other its
    /// own best value, which the unbounded solution is far from.
    #[test]
    fn one_at_its_bound_is_not_compensated_for() {
        let mut equations = NormalEquations::<f64, 2>::EMPTY;
        for (regressor, error) in [([1.0, 1.0], 1.0), ([1.0, 0.9], 0.5)] {
            equations.add(&regressor, error);
        }
        let free = bounded_step(&equations, &[0.0; 2], 0.0, [true; 2], &[-9.0; 2], &[9.0; 2]);
        assert!(
            (free[0] + 4.0).abs() < 1e-6 && (free[1] - 5.0).abs() < 1e-6,
            "{free:?}"
        );
        let held = bounded_step(
            &equations,
            &[0.0; 2],
            0.0,
            [true; 2],
            &[0.0, -9.0],
            &[9.0; 2],
        );
        assert!(
            held[0].abs() < 1e-12 && (held[1] - 1.45 / 1.81).abs() < 1e-6,
            "{held:?}"
        );
    }

    #[test]
    fn an_unknown_with_an_infinite_step_stays() {
        let [stays, moves] = moved(&[1.0, 2.0], &[f64::INFINITY, 0.5]);
        assert!((stays - 1.0_f64).abs() < 1e-12 && (moves - 2.5).abs() < 1e-12);
    }
}
