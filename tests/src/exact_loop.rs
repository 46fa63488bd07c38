//! The sampled loop of gains around the true servo of one mass or two: largest pole and sensitivity, from the matrices of
//! the equation of motion alone. Nothing of it is the tuner's.
//!
//! (1 − ρ) q̈ = b u − a q̇ + K w + D ẇ, ρ (q̈ + ẅ) = −K w − D ẇ, K = ω² ρ (1 − ρ), D = 2 ζ ω ρ (1 − ρ). Here w is the load's
//! lead on the motor. A command acts from the part of a sample on by which it is late, and is held.

use std::f64::consts::PI;

use identifier_core::number::Complex;
use identifier_core::tuning::Tuning;
use virtual_servo::{Effects, ServoParameters};

/// Position and velocity of the motor, lead and lead rate of the load.
const STATES: usize = 4;

/// A square matrix.
type Matrix = Vec<Vec<f64>>;

/// A linear controller with one input, x⁺ = A x + B y, u = C x + D y.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearController {
    /// A.
    pub transition: Matrix,
    /// B.
    pub input: Vec<f64>,
    /// C.
    pub output: Vec<f64>,
    /// D.
    pub direct: f64,
}

/// A loop around a servo.
#[derive(Debug, Clone)]
pub struct ExactLoop {
    /// Of the servo over a sample.
    transition: Matrix,
    /// By a command over the last part of a sample, and by the one before over the first.
    newer: Vec<f64>,
    older: Vec<f64>,
    /// Whole samples of delay.
    whole: usize,
    /// The encoder's position.
    output: [f64; STATES],
    controller: LinearController,
    sample_time: f64,
    /// Frequencies about which L changes quickly and their damping, rad/s.
    narrow: Vec<[f64; 2]>,
}

impl ExactLoop {
    /// Of a controller around a servo with its resonance and delay.
    #[must_use]
    pub fn new(
        servo: &ServoParameters,
        effects: &Effects,
        sample_time: f64,
        controller: LinearController,
    ) -> Self {
        let share = effects.inertia_ratio;
        let damping = effects.resonance_damping.unwrap_or(0.0);
        let (stiff, damp) = match share > 0.0 {
            true => (
                effects.resonance.powi(2) * share * (1.0 - share),
                2.0 * damping * effects.resonance * share * (1.0 - share),
            ),
            false => (0.0, 0.0),
        };
        let of_motor = 1.0 / (1.0 - share);
        let of_load = if share > 0.0 { 1.0 / share } else { 0.0 };
        let lead = of_motor + of_load;
        // A lead that nothing shows ends.
        let rigid = if share > 0.0 { 0.0 } else { -1.0 / sample_time };
        // The command is a fifth state that stays.
        let rates = [
            [0.0, 1.0, 0.0, 0.0, 0.0],
            [
                0.0,
                -servo.a * of_motor,
                stiff * of_motor,
                damp * of_motor,
                servo.b * of_motor,
            ],
            [0.0, 0.0, rigid, 1.0, 0.0],
            [
                0.0,
                servo.a * of_motor,
                -stiff * lead,
                rigid - damp * lead,
                -servo.b * of_motor,
            ],
            [0.0; 5],
        ];
        let whole = (effects.delay / sample_time).floor();
        let part = effects.delay - whole * sample_time;
        let over = |time: f64| {
            let rows = rates
                .iter()
                .map(|row| row.iter().map(|rate| rate * time).collect());
            exponential(&rows.collect())
        };
        let (all, last) = (over(sample_time), over(sample_time - part));
        let column = |of: &Matrix| (0..STATES).map(|row| of[row][STATES]).collect::<Vec<_>>();
        let newer = column(&last);
        let older = column(&all)
            .iter()
            .zip(&newer)
            .map(|(all, newer)| all - newer)
            .collect();
        let on_load = if effects.encoder_on_load { 1.0 } else { 0.0 };
        let antiresonance = effects.resonance * (1.0 - share).sqrt();
        Self {
            transition: all[..STATES]
                .iter()
                .map(|row| row[..STATES].to_vec())
                .collect(),
            newer,
            older,
            whole: whole as usize,
            output: [1.0, 0.0, on_load, 0.0],
            controller,
            sample_time,
            narrow: match share > 0.0 {
                true => vec![[effects.resonance, damping], [antiresonance, damping]],
                false => Vec::new(),
            },
        }
    }

    /// The largest magnitude of a pole of the closed loop; one and more is unstable.
    #[must_use]
    pub fn largest_pole(&self) -> f64 {
        /// Squarings: powers up to 2⁴⁰.
        const SQUARINGS: i32 = 40;
        let own = self.controller.input.len();
        let late = self.whole + 1;
        let size = STATES + late + own;
        let mut closed = vec![vec![0.0; size]; size];
        // The command of this sample, of all states.
        let mut command = vec![0.0; size];
        for (place, output) in self.output.iter().enumerate() {
            command[place] = self.controller.direct * output;
        }
        command[STATES + late..].copy_from_slice(&self.controller.output);
        // Commands are kept the newest first: that of this sample is place zero.
        let kept = |age: usize| {
            let mut row = vec![0.0; size];
            match age.checked_sub(1) {
                None => row.clone_from(&command),
                Some(place) => row[STATES + place] = 1.0,
            }
            row
        };
        let (newer, older) = (kept(self.whole), kept(self.whole + 1));
        for row in 0..STATES {
            closed[row][..STATES].copy_from_slice(&self.transition[row]);
            for column in 0..size {
                closed[row][column] +=
                    self.newer[row] * newer[column] + self.older[row] * older[column];
            }
        }
        for place in 0..late {
            closed[STATES + place] = kept(place);
        }
        for row in 0..own {
            for (place, output) in self.output.iter().enumerate() {
                closed[STATES + late + row][place] = self.controller.input[row] * output;
            }
            closed[STATES + late + row][STATES + late..]
                .copy_from_slice(&self.controller.transition[row]);
        }
        let mut logarithm = 0.0;
        for squaring in 0..SQUARINGS {
            let norm = closed
                .iter()
                .flatten()
                .fold(0.0_f64, |most, entry| most.max(entry.abs()));
            logarithm += norm.ln() / 2.0_f64.powi(squaring);
            for entry in closed.iter_mut().flatten() {
                *entry /= norm;
            }
            closed = product(&closed, &closed);
        }
        logarithm.exp()
    }

    /// The servo's position per command at a frequency, rad/s.
    fn servo(&self, frequency: f64) -> Complex {
        let z = at(frequency * self.sample_time);
        let late = at(-frequency * self.sample_time * self.whole as f64);
        let before = at(-frequency * self.sample_time);
        let input: Vec<Complex> = (self.newer.iter().zip(&self.older))
            .map(|(newer, older)| (before.scaled(*older) + *newer) * late)
            .collect();
        let state = solved(z, &self.transition, input);
        let terms = state.iter().zip(self.output);
        terms.fold(Complex::new(0.0, 0.0), |sum, (state, output)| {
            sum + state.scaled(output)
        })
    }

    /// L at a frequency, rad/s, the loop opened at the command; its feedback is negative.
    #[must_use]
    pub fn gain(&self, frequency: f64) -> Complex {
        let z = at(frequency * self.sample_time);
        let input = self.controller.input.iter();
        let input = input.map(|own| Complex::new(*own, 0.0)).collect();
        let state = solved(z, &self.controller.transition, input);
        let terms = state.iter().zip(&self.controller.output);
        let command = terms.fold(
            Complex::new(self.controller.direct, 0.0),
            |sum, (state, output)| sum + state.scaled(*output),
        );
        (command * self.servo(frequency)).scaled(-1.0)
    }

    /// Mₛ, the largest |1/(1 + L)|; infinite if the loop is unstable.
    #[must_use]
    pub fn sensitivity(&self) -> f64 {
        /// Frequencies of the whole range, and about each that is narrow.
        const FREQUENCIES: i32 = 2500;
        const NEAR: i32 = 200;
        if self.largest_pole() >= 1.0 {
            return f64::INFINITY;
        }
        let highest = 0.9999 * PI / self.sample_time;
        let lowest = 1e-5 * highest;
        let ratio = (highest / lowest).powf(1.0 / f64::from(FREQUENCIES));
        let all = (0..=FREQUENCIES).map(|place| lowest * ratio.powi(place));
        let near = self.narrow.iter().flat_map(|[frequency, damping]| {
            // One beyond half of the sampling frequency appears below it.
            let angle = (frequency * self.sample_time) % (2.0 * PI);
            let seen = angle.min(2.0 * PI - angle) / self.sample_time;
            (-NEAR..=NEAR).map(move |place| {
                let distance = (4.5 * f64::from(place) / f64::from(NEAR)).sinh();
                seen + 0.3 * damping * frequency * distance
            })
        });
        let inside = |frequency: &f64| (lowest..=highest).contains(frequency);
        let distance = |frequency: f64| 1.0 / (self.gain(frequency) + 1.0).power().sqrt();
        all.chain(near)
            .filter(inside)
            .map(distance)
            .fold(0.0, f64::max)
    }
}

impl LinearController {
    /// The PID of gains that were tuned, as it runs: u = −k_p y − k_d v − k_i ∫y behind the notch, v the low-pass difference,
    /// the sum without the newest position.
    #[must_use]
    pub fn tuned(tuning: &Tuning, sample_time: f64) -> Self {
        let g = -(-tuning.cutoff * sample_time).exp_m1();
        let per_difference = tuning.kd * g / sample_time;
        // v, the last position, the sum.
        let pid = Self {
            transition: vec![
                vec![1.0 - g, -g / sample_time, 0.0],
                vec![0.0; 3],
                vec![0.0, 0.0, 1.0],
            ],
            input: vec![g / sample_time, 1.0, sample_time],
            output: vec![-tuning.kd * (1.0 - g), per_difference, -tuning.ki],
            direct: -tuning.kp - per_difference,
        };
        if tuning.notch == 0.0 {
            return pid;
        }
        // Tustin's (s² + 0.1 n s + n²)/(s² + n s + n²), n = tan(ωT/2) with s = (z − 1)/(z + 1).
        let n = (0.5 * tuning.notch * sample_time).tan();
        let of = |damping: f64| {
            [
                1.0 + damping * n + n * n,
                2.0 * (n * n - 1.0),
                1.0 - damping * n + n * n,
            ]
        };
        let (above, below) = (of(0.1), of(1.0));
        let [b0, b1, b2] = above.map(|own| own / below[0]);
        let [_, a1, a2] = below.map(|own| own / below[0]);
        pid.followed_by([b0, b1, b2], [a1, a2])
    }

    /// Behind it a filter (b₀ + b₁ z⁻¹ + b₂ z⁻²)/(1 + a₁ z⁻¹ + a₂ z⁻²).
    fn followed_by(&self, [b0, b1, b2]: [f64; 3], [a1, a2]: [f64; 2]) -> Self {
        let own = self.input.len();
        let mut transition: Matrix = (self.transition.iter())
            .map(|row| [&row[..], &[0.0, 0.0]].concat())
            .collect();
        // Transposed form: y = b₀ x + s₁; s₁⁺ = b₁ x − a₁ y + s₂; s₂⁺ = b₂ x − a₂ y.
        let row = |b: f64, a: f64, next: f64| {
            let by_input = b - a * b0;
            let states = self.output.iter().map(|of| by_input * of);
            (
                states.chain([-a, next]).collect::<Vec<_>>(),
                by_input * self.direct,
            )
        };
        let ((first, by_first), (second, by_second)) = (row(b1, a1, 1.0), row(b2, a2, 0.0));
        transition.extend([first, second]);
        let mut output: Vec<f64> = self.output.iter().map(|of| b0 * of).collect();
        output.extend([1.0, 0.0]);
        let mut input = self.input.clone();
        input.extend([by_first, by_second]);
        debug_assert_eq!(input.len(), own + 2);
        Self {
            transition,
            input,
            output,
            direct: b0 * self.direct,
        }
    }
}

fn at(angle: f64) -> Complex {
    Complex::new(angle.cos(), angle.sin())
}

fn product(one: &Matrix, other: &Matrix) -> Matrix {
    let size = one.len();
    let entry = |row: usize, column: usize| (0..size).map(|k| one[row][k] * other[k][column]).sum();
    (0..size)
        .map(|row| (0..size).map(|column| entry(row, column)).collect())
        .collect()
}

/// By squaring a series of a small part.
fn exponential(of: &Matrix) -> Matrix {
    const HALVINGS: i32 = 20;
    const TERMS: i32 = 10;
    let size = of.len();
    let identity: Matrix = (0..size)
        .map(|row| {
            (0..size)
                .map(|column| f64::from(u8::from(row == column)))
                .collect()
        })
        .collect();
    let part: Matrix = (of.iter())
        .map(|row| {
            row.iter()
                .map(|entry| entry / 2.0_f64.powi(HALVINGS))
                .collect()
        })
        .collect();
    // Without the identity, which small terms would drown in.
    let (mut sum, mut term) = (part.clone(), part.clone());
    for count in 2..=TERMS {
        term = product(&term, &part);
        for (sums, terms) in sum.iter_mut().zip(&mut term) {
            for (sum, term) in sums.iter_mut().zip(terms) {
                *term /= f64::from(count);
                *sum += *term;
            }
        }
    }
    for _ in 0..HALVINGS {
        let squared = product(&sum, &sum);
        for (sums, squares) in sum.iter_mut().zip(squared) {
            for (sum, square) in sums.iter_mut().zip(squares) {
                *sum = 2.0 * *sum + square;
            }
        }
    }
    let add = |(row, identity): (&Vec<f64>, Vec<f64>)| {
        row.iter()
            .zip(identity)
            .map(|(own, one)| own + one)
            .collect()
    };
    sum.iter().zip(identity).map(add).collect()
}

/// (z − A)⁻¹ b.
fn solved(z: Complex, matrix: &Matrix, right: Vec<Complex>) -> Vec<Complex> {
    let size = right.len();
    let mut rows: Vec<Vec<Complex>> = (0..size)
        .map(|row| {
            let entries = (0..size).map(|column| {
                let own = Complex::new(-matrix[row][column], 0.0);
                if row == column { own + z } else { own }
            });
            entries.chain([right[row]]).collect()
        })
        .collect();
    for column in 0..size {
        let largest = (column..size).max_by(|&one, &other| {
            rows[one][column]
                .power()
                .total_cmp(&rows[other][column].power())
        });
        rows.swap(column, largest.unwrap_or(column));
        for row in (0..size).filter(|&row| row != column) {
            let factor = rows[row][column] / rows[column][column];
            let pivot = rows[column].clone();
            for (entry, pivot) in rows[row].iter_mut().zip(pivot) {
                *entry = *entry - factor * pivot;
            }
        }
    }
    (0..size)
        .map(|row| rows[row][size] / rows[row][row])
        .collect()
}
