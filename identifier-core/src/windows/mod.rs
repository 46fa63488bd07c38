//! Windows of a motion: a servo without a model, an observer or a guess.
//!
//! q̈ = −a q̇ + b u(t − τ) + d − c sign q̇ is integrated twice over pieces of m samples. With the mean velocities v̄ of a
//! piece and the next, (v̄₊ − v̄)/m = −a g_v + b g_u − c g_s + d − (b τ/m)(ū₊ − ū). Each g is a mean weighted by a triangle
//! over both pieces. The last term is that of a delay, to first order.
//!
//! A window adds five of these lines by −1, −2, 0, 2, 1: the third difference of positions over 2m samples. A constant
//! load vanishes in it, and a step of the load spoils one window. Pieces join by two, so that each longer window costs
//! half of the one before.
//!
//! Of the windows the normal equations Ω θ = Y remain, each window weighted by the sensor's noise. The unknowns are a, b,
//! c and b τ. They forget by motion, not by time: a servo at rest, or one that only coasts, forgets nothing.
//!
//! θ ← (Ω + R)⁻¹ (Y + R θ), R = ρ Γ⁻¹, brings estimates closer to a servo that the windows describe: with x =
//! R^½ (θ − θ*), x₊ = (R^(−½) Ω R^(−½) + 1)⁻¹ x. That holds for every Ω ≥ 0, so a short motion teaches what it shows and
//! leaves the rest. The regressor with memory is Kreisselmeier's ("Adaptive observers with exponential rate of
//! convergence", IEEE Transactions on Automatic Control 22(1), 1977).

mod length;
mod piece;

pub(crate) use length::COLUMNS;
use length::{Length, Scale};
pub use piece::MeasuredPiece;
#[cfg(test)]
use piece::Moments;
use piece::Piece;
pub(crate) use piece::{Measuring, Pieces};

use crate::constants::{Encode, encode};
use crate::number::Number;

/// Lengths of windows, each twice the one before.
const LENGTHS: usize = 3;

/// Windows of pieces, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WindowSettings<F> {
    per_length: F,
    weight: F,
    least: F,
    /// Windows that are remembered.
    memory: F,
    /// Roots of the diagonal of R.
    stiffness: [F; COLUMNS],
}

encode! {
    [F: Encode] WindowSettings<F> as "WindowSettings" { per_length, weight, least, memory, stiffness }
}

/// What the windows have of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Windows<F> {
    lengths: [Length<F>; LENGTHS],
    /// The first of two pieces that become one of the next length.
    open: [Option<Piece<F>>; LENGTHS],
}

/// The surest of the answers of all lengths, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found<F> {
    /// a, b, c and b τ.
    pub(crate) unknowns: [F; COLUMNS],
    /// Their variances, with what differs between lengths.
    pub(crate) variances: [F; COLUMNS],
    /// The load, and its variance.
    pub(crate) load: [F; 2],
}

impl<F: Number> WindowSettings<F> {
    /// Windows of pieces of `samples`, of a sensor whose position has a standard deviation of `noise` position units.
    /// `spread` are the standard deviations that the unknowns may have about an estimate: the roots of Γ's diagonal but for
    /// a factor. Zero is that of a known one.
    #[must_use]
    pub(crate) fn new(samples: u16, noise: f64, spread: &[f64; COLUMNS]) -> Self {
        /// Variance of a third difference of positions over that of a position.
        const THIRD: f64 = 20.0;
        /// Counts of an encoder of a servo that only trembles, and standard deviations that no noise has.
        const TREMBLE: f64 = 1.5;
        const SIGNIFICANT: f64 = 4.0;
        /// With more, one that has changed is followed slowly; with less, chance rules.
        const MEMORY: f64 = 100.0;
        /// Far above all that windows say.
        const KNOWN: f64 = 1e15;
        let length = f64::from(samples);
        let rounding = noise.min(libm::sqrt(1.0 / 12.0));
        let beyond = libm::sqrt(noise * noise - rounding * rounding);
        let least = TREMBLE * libm::sqrt(12.0) * rounding + SIGNIFICANT * beyond;
        Self {
            per_length: F::from_f64(1.0 / length),
            weight: F::from_f64(length * length / (libm::sqrt(THIRD) * noise)),
            least: F::from_f64(least / length),
            memory: F::from_f64(MEMORY),
            stiffness: spread.map(|spread| F::from_f64((1.0 / spread).min(KNOWN))),
        }
    }

    /// Without a window.
    #[inline(never)]
    #[must_use]
    pub(crate) fn start(&self) -> Windows<F> {
        Windows {
            lengths: [Length::new(); LENGTHS],
            open: [None; LENGTHS],
        }
    }

    /// Takes the next piece of the motion. True if there is a new window of any length.
    pub(crate) fn push(&self, windows: &mut Windows<F>, piece: &Piece<F>) -> bool {
        let mut scale = Scale {
            per_length: self.per_length,
            weight: self.weight,
            least: self.least,
            memory: self.memory,
        };
        let (mut next, mut any) = (Some(*piece), false);
        for (length, open) in windows.lengths.iter_mut().zip(&mut windows.open) {
            let Some(piece) = next else { break };
            let (done, is_new) = length.push(&scale, &piece);
            any |= is_new;
            next = done.and_then(|done| match open.take() {
                Some(before) => Some(before.joined(&done)),
                None => {
                    *open = Some(done);
                    None
                }
            });
            scale = scale.twice();
        }
        any
    }

    /// What the surest length finds about the `present` unknowns. None before one has enough windows.
    #[must_use]
    pub(crate) fn find(&self, windows: &Windows<F>, present: &[F; COLUMNS]) -> Option<Found<F>> {
        /// Windows over the same pieces are not independent: by this the variance by noise is more than without.
        const OVERLAP: f64 = 2.0;
        /// The same by forces that the equations lack. They last longer than a window.
        const LASTING: f64 = 8.0;
        let [overlap, lasting] = [OVERLAP, LASTING].map(F::from_f64);
        let sixteenth = F::from_f64(1.0 / 16.0);
        let mut answers = [None; LENGTHS];
        // What is unexplained, in windows of the least noise and by forces: longer windows have less noise.
        let (mut noise, mut force) = (F::from_f64(f64::from(f32::MAX)), F::ZERO);
        let mut noise_of_window = (self.weight * self.weight).reciprocal();
        for (answer, length) in answers.iter_mut().zip(&windows.lengths) {
            *answer = self.found_by(length, noise_of_window, present);
            if let Some((_, unexplained)) = answer {
                noise = noise.smaller(*unexplained);
                force = (*unexplained - noise) * noise_of_window;
            }
            noise_of_window = sixteenth * noise_of_window;
        }
        let mut per_noise = self.weight * self.weight;
        let mut found = [None; LENGTHS];
        for (found, answer) in found.iter_mut().zip(&answers) {
            *found = answer.map(|(found, unexplained)| {
                found.scaled(overlap * unexplained + lasting * (force * per_noise))
            });
            per_noise = F::from_f64(16.0) * per_noise;
        }
        let [first, second, third] = &found;
        let beside = [
            first.map(|own| own.beside(&[second])),
            second.map(|own| own.beside(&[first, third])),
            third.map(|own| own.beside(&[second])),
        ];
        let price = |found: &Found<F>| {
            let ([_, gain, ..], [_, variance, ..]) = (found.unknowns, found.variances);
            variance
                * (gain * gain)
                    .larger(F::from_f64(f64::from(f32::MIN_POSITIVE)))
                    .reciprocal()
        };
        let mut surest: Option<Found<F>> = None;
        for found in beside.into_iter().flatten() {
            if surest.is_none_or(|surest| price(&found) < price(&surest)) {
                surest = Some(found);
            }
        }
        surest
    }

    /// What a length finds, with variances for windows of variance one, and the variance of its windows that is left.
    fn found_by(
        &self,
        length: &Length<F>,
        noise_of_window: F,
        present: &[F; COLUMNS],
    ) -> Option<(Found<F>, F)> {
        /// Windows of which a length may speak.
        const LEAST: f64 = 8.0;
        /// Variance of a line of the mean over that of a window.
        const LINE: f64 = 6.0 / 20.0 / 16.0;
        if length.count < F::from_f64(LEAST) {
            return None;
        }
        let mut equations = length.equations.about(present);
        for (unknown, weight) in self.stiffness.into_iter().enumerate() {
            equations.expect(unknown, weight, F::ZERO);
        }
        let free = &[true; COLUMNS];
        let step = equations.solve(F::ZERO, free);
        let [a, b, c, delay] = present;
        let [to_a, to_b, to_c, to_delay] = step;
        let unknowns = [*a + to_a, *b + to_b, *c + to_c, *delay + to_delay];
        let spare = length.count - F::from_f64(COLUMNS as f64);
        let unexplained = (equations.left_by(&step) * spare.reciprocal()).larger(F::ONE);
        let [zero, one] = [F::ZERO, F::ONE];
        let [a, b, c, delay, mean] = equations.variances(&[
            [one, zero, zero, zero],
            [zero, one, zero, zero],
            [zero, zero, one, zero],
            [zero, zero, zero, one],
            length.mean_columns(),
        ]);
        let (load, lines) = length.load(&unknowns);
        let of_line = F::from_f64(LINE) * noise_of_window * lines.larger(one).reciprocal();
        let found = Found {
            unknowns,
            variances: [a, b, c, delay],
            load: [load, mean + of_line],
        };
        Some((found, unexplained))
    }
}

impl<F: Number> Found<F> {
    pub(crate) fn is_finite(&self) -> bool {
        let numbers = self.unknowns.iter().chain(&self.variances);
        numbers
            .chain(&self.load)
            .all(|number| F::is_finite(*number))
    }

    /// With variances of which these are for errors of variance one.
    fn scaled(mut self, variance: F) -> Self {
        let [_, load] = &mut self.load;
        for own in self.variances.iter_mut().chain([load]) {
            *own = variance * *own;
        }
        self
    }

    /// With what the neighbours differ by beyond chance. A neighbour that knows little says little.
    fn beside(mut self, neighbours: &[&Option<Self>]) -> Self {
        for other in neighbours.iter().copied().flatten() {
            let own = self.unknowns.iter().zip(&mut self.variances);
            for ((own, variance), (other, theirs)) in
                own.zip(other.unknowns.iter().zip(&other.variances))
            {
                let off = (*own - *other) * (*own - *other);
                let share = *variance * theirs.larger(*variance).reciprocal();
                *variance += (off - *theirs).smaller(off * share).larger(F::ZERO);
            }
        }
        self
    }
}

impl<F: Number> Windows<F> {
    /// Begins a motion anew after a gap; what was learnt is kept.
    pub(crate) fn interrupt(&mut self) {
        self.open = [None; LENGTHS];
        self.lengths.iter_mut().for_each(Length::interrupt);
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const SAMPLES: u16 = 4;

    fn settings() -> WindowSettings<f64> {
        WindowSettings::new(SAMPLES, 1e-3, &[1.0, 10.0, 10.0, 10.0])
    }

    /// The pieces of a servo without damping and friction, in closed form; the command acts `late`, a part of a sample.
    fn pieces(count: u32, [gain, late]: [f64; 2], load: impl Fn(f64) -> f64) -> Vec<Piece<f64>> {
        let m = f64::from(SAMPLES);
        let command = |time: f64| {
            30.0 * (0.05 * time).sin() + 20.0 * (0.013 * time).cos() * (0.031 * time).sin()
        };
        let (mut velocity, mut before) = (0.0, 0.0);
        let mut next = |piece: u32| {
            let mut own = Piece::default();
            let mut travel = 0.0;
            for j in 0..u32::from(SAMPLES) {
                let time = f64::from(piece * u32::from(SAMPLES) + j);
                let (now, weight) = (command(time), (m - f64::from(j) - 0.5) / (m * m));
                let [first, then] = [before, now].map(|u| gain * u + load(time));
                // The command before acts for a part of the sample.
                let rest = 1.0 - late;
                let turn = velocity + late * first;
                let moved = late * velocity
                    + 0.5 * late * late * first
                    + rest * turn
                    + 0.5 * rest * rest * then;
                let area = 0.5 * late * late * velocity
                    + late.powi(3) / 6.0 * first
                    + rest * (late * velocity + 0.5 * late * late * first)
                    + 0.5 * rest * rest * turn
                    + rest.powi(3) / 6.0 * then;
                own.velocity.early += (travel + area) / (m * m);
                own.velocity.mean += moved / m;
                own.command.mean += now / m;
                own.command.early += weight * now;
                own.later.mean += (before - now) / m;
                own.later.early += weight * (before - now);
                travel += moved;
                velocity = turn + rest * then;
                before = now;
            }
            own
        };
        (0..count).map(&mut next).collect()
    }

    fn windows(pieces: &[Piece<f64>]) -> Windows<f64> {
        let settings = settings();
        let mut windows = settings.start();
        for piece in pieces {
            settings.push(&mut windows, piece);
        }
        windows
    }

    fn each(windows: &Windows<f64>) -> [Found<f64>; LENGTHS] {
        let settings = settings();
        windows.lengths.map(|length| {
            let found = settings.found_by(&length, 1.0, &[0.0, 1.0, 0.0, 0.0]);
            found.expect("enough windows").0
        })
    }

    #[test]
    fn of_a_servo_that_only_accelerates_every_length_has_the_gain_and_the_load() {
        for found in each(&windows(&pieces(900, [3.0, 0.0], |_| 7.0))) {
            let [_, gain, _, delayed] = found.unknowns;
            assert!((gain / 3.0 - 1.0).abs() < 1e-5, "{found:?}");
            assert!((delayed / gain).abs() < 1e-3, "{found:?}");
            assert!((found.load[0] / 7.0 - 1.0).abs() < 1e-3, "{found:?}");
        }
    }

    #[test]
    fn a_step_of_the_load_spoils_little() {
        let steps = |time: f64| if time > 6000.0 { 4.0 } else { 0.0 };
        for found in each(&windows(&pieces(2400, [3.0, 0.0], steps))) {
            assert!((found.unknowns[1] / 3.0 - 1.0).abs() < 1e-3, "{found:?}");
        }
    }

    #[test]
    fn a_delay_is_told_from_the_gain() {
        for late in [0.3, 0.8, 1.0] {
            for found in each(&windows(&pieces(1200, [3.0, late], |_| 0.0))) {
                let [_, gain, _, delayed] = found.unknowns;
                assert!((gain / 3.0 - 1.0).abs() < 1e-3, "{late}: {found:?}");
                assert!((delayed / gain - late).abs() < 0.02, "{late}: {found:?}");
            }
        }
    }

    #[test]
    fn a_gap_leaves_what_was_learnt_and_spoils_no_window() {
        let motion = pieces(900, [3.0, 0.0], |_| 7.0);
        let settings = settings();
        let mut windows = windows(&motion[..450]);
        let before = windows.lengths.map(|length| length.equations);
        windows.interrupt();
        assert_eq!(before, windows.lengths.map(|length| length.equations));
        for piece in &motion[470..] {
            settings.push(&mut windows, piece);
        }
        for found in each(&windows) {
            assert!((found.unknowns[1] / 3.0 - 1.0).abs() < 1e-5, "{found:?}");
        }
    }

    #[test]
    fn at_rest_nothing_is_forgotten() {
        let mut windows = windows(&pieces(900, [3.0, 0.0], |_| 0.0));
        let settings = settings();
        let held = Piece {
            command: Moments {
                mean: 1.0,
                early: 0.5,
            },
            ..Piece::default()
        };
        for _ in 0..8 {
            settings.push(&mut windows, &held);
        }
        let before = windows.lengths.map(|length| length.equations);
        for _ in 0..10_000 {
            assert!(!settings.push(&mut windows, &held));
        }
        assert_eq!(before, windows.lengths.map(|length| length.equations));
    }

    /// The storage function (12) in the metric of the spreads.
    #[test]
    fn no_step_raises_the_storage_function() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1_u32 << 23) - 1.0
        };
        for _ in 0..2000 {
            let spread: [f64; COLUMNS] = core::array::from_fn(|_| (8.0 * next()).exp2());
            let settings = WindowSettings::<f64>::new(SAMPLES, 1.0, &spread);
            let mut length = Length::new();
            let truth: [f64; COLUMNS] = core::array::from_fn(|_| next());
            let rank = 1 + (next().abs() * 6.0) as u32;
            for _ in 0..rank {
                let row: [f64; COLUMNS] =
                    core::array::from_fn(|i| next() * [1.0, 100.0, 1e-2, 3.0][i]);
                let change = (0..COLUMNS).map(|i| row[i] * truth[i]).sum();
                length.equations.add(&row, change);
            }
            length.count = 8.0;
            let mut theta: [f64; COLUMNS] = core::array::from_fn(|_| 3.0 * next());
            let storage = |theta: &[f64; COLUMNS]| -> f64 {
                let parts = (0..COLUMNS).map(|i| ((theta[i] - truth[i]) / spread[i]).powi(2));
                parts.sum()
            };
            for _ in 0..20 {
                let before = storage(&theta);
                let (found, _) = settings.found_by(&length, 1.0, &theta).expect("windows");
                theta = found.unknowns;
                assert!(storage(&theta) <= before * (1.0 + 1e-9) + 1e-12);
            }
        }
    }
}
