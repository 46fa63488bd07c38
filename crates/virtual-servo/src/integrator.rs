//! Numerical integration of motions without a closed form.

use crate::equation::{Equation, Modes, State};

/// Integrates an equation of motion to a given accuracy: Dormand and Prince's pair of orders 5 and 4
/// (J. Comput. Appl. Math. 6, 1980), with steps as long as its own estimate of the error allows.
///
/// If motor or load stops, turns or breaks away, the time is found to 10⁻⁹ of the given time. The motion continues from
/// there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Integrator {
    /// Error allowed in a step, relative to 1 + the magnitude of the state.
    tolerance: f64,
    /// S.
    longest: f64,
    /// Length of the next step, s.
    step: f64,
}

impl Integrator {
    /// Errors of this size, rad and rad/s in a step, accumulate to far less than a thousandth of an encoder's count in
    /// 10 s.
    pub(crate) const TOLERANCE: f64 = 1e-11;

    /// The shortest step and the precision of an event, as parts of the time that is asked for.
    const FINEST_STEP: f64 = 1.0 / 4096.0;
    const FINEST_EVENT: f64 = 1e-9;

    /// Events in the requested time after which a motor that stops repeatedly is at standstill.
    const MAX_EVENTS: u32 = 1000;

    /// With steps of up to `longest`, s.
    pub(crate) fn new(tolerance: f64, longest: f64) -> Self {
        Self {
            tolerance,
            longest,
            step: longest,
        }
    }

    /// Moves a state by a time, s, from the beginning of the time for which a command is held.
    pub(crate) fn advance(&mut self, equation: &Equation, state: &mut State, time: f64) {
        let mut modes = equation.modes(0.0, state);
        let (mut now, mut events) = (0.0, 0);
        // A state that diverged stays as it is.
        while now < time && events < Self::MAX_EVENTS && state[1].is_finite() {
            let left = time - now;
            let step = self.step.min(left);
            let (next, error) = dormand_prince(equation, modes, now, state, step);
            let error = self.relative(&error, &next);
            let too_large = error.is_nan() || error > 1.0;
            if too_large && step > Self::FINEST_STEP * time {
                self.step = step * change(error);
                continue;
            }
            // A step cut short by the end of the time is no measure for the next.
            if self.step <= left || error > 1.0 {
                self.step = (step * change(error)).min(self.longest);
            }
            if must_change(equation, modes, now + step, &next) {
                let finest = Self::FINEST_EVENT * time;
                let until = time_of_event(equation, modes, now, state, step, finest);
                (*state, _) = dormand_prince(equation, modes, now, state, until);
                now += until;
                events += 1;
                equation.stop(modes, now, state);
                modes = equation.modes(now, state);
            } else {
                *state = next;
                now = if step < left { now + step } else { time };
            }
        }
    }

    /// The largest error, of what is allowed.
    fn relative(&self, error: &State, state: &State) -> f64 {
        let parts = error.iter().zip(state);
        let relative = parts.map(|(error, size)| error.abs() / (1.0 + size.abs()));
        let worst = relative.fold(0.0, |worst: f64, part| {
            if part > worst || part.is_nan() {
                part
            } else {
                worst
            }
        });
        worst / self.tolerance
    }
}

/// Factor from a step with an error, relative to the one allowed, to the next step.
fn change(error: f64) -> f64 {
    const SAFETY: f64 = 0.9;
    const BOUNDS: (f64, f64) = (0.2, 5.0);
    if error.is_nan() {
        return BOUNDS.0;
    }
    (SAFETY * libm::pow(error, -0.2)).clamp(BOUNDS.0, BOUNDS.1)
}

/// True if a mode of friction has ended.
fn must_change(equation: &Equation, modes: Modes, time: f64, state: &State) -> bool {
    equation
        .margins(modes, time, state)
        .iter()
        .any(|margin| *margin < 0.0)
}

/// The end of a friction mode within a step, at most a `finest` time late.
fn time_of_event(
    equation: &Equation,
    modes: Modes,
    now: f64,
    state: &State,
    step: f64,
    finest: f64,
) -> f64 {
    let (mut before, mut after) = (0.0, step);
    while after - before > finest {
        let middle = 0.5 * (before + after);
        let (there, _) = dormand_prince(equation, modes, now, state, middle);
        if must_change(equation, modes, now + middle, &there) {
            after = middle;
        } else {
            before = middle;
        }
    }
    after
}

/// A step, and the difference between its two orders.
fn dormand_prince(
    equation: &Equation,
    modes: Modes,
    now: f64,
    state: &State,
    step: f64,
) -> (State, State) {
    const TIMES: [f64; 5] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
    const STAGES: [&[f64]; 5] = [
        &[0.2],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[
            19_372.0 / 6561.0,
            -25_360.0 / 2187.0,
            64_448.0 / 6561.0,
            -212.0 / 729.0,
        ],
        &[
            9017.0 / 3168.0,
            -355.0 / 33.0,
            46_732.0 / 5247.0,
            49.0 / 176.0,
            -5103.0 / 18_656.0,
        ],
    ];
    const FIFTH: [f64; 6] = [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ];
    /// The fifth order's weights less the fourth's.
    const DIFFERENCE: [f64; 7] = [
        71.0 / 57_600.0,
        0.0,
        -71.0 / 16_695.0,
        71.0 / 1920.0,
        -17_253.0 / 339_200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ];

    let mut rates = [[0.0; 4]; 7];
    rates[0] = equation.rates(modes, now, state);
    for (stage, (time, weights)) in TIMES.iter().zip(STAGES).enumerate() {
        let there = moved(state, &rates, weights, step);
        rates[stage + 1] = equation.rates(modes, now + time * step, &there);
    }
    let next = moved(state, &rates, &FIFTH, step);
    rates[6] = equation.rates(modes, now + step, &next);
    (next, moved(&[0.0; 4], &rates, &DIFFERENCE, step))
}

/// A state moved by a weighted sum of rates over a time.
fn moved(state: &State, rates: &[State], weights: &[f64], time: f64) -> State {
    let mut next = *state;
    for (rate, weight) in rates.iter().zip(weights) {
        for (value, slope) in next.iter_mut().zip(rate) {
            *value += time * weight * slope;
        }
    }
    next
}
