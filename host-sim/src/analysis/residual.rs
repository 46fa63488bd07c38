//! What the output error says of the model: is it the encoder's, is it white, and if not, why.

use std::collections::VecDeque;
use std::fmt;

use identifier_core::model::ServoParameters;

use super::Summary;
use crate::experiment::Sample;
use crate::scenario::Scenario;

/// What of a run a [`Report`] is made from: position and output error of its last
/// [`Recording::MOST`] samples. A shorter run is recorded whole; of a longer one its end is judged,
/// where the estimates are at their best.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    samples: VecDeque<(f64, f64)>,
}

impl Recording {
    /// The most samples that are recorded: seventeen minutes at 1 kHz, 16 MB.
    pub const MOST: usize = 1 << 20;

    /// Takes in a sample.
    pub fn add(&mut self, sample: &Sample) {
        if self.samples.len() == Self::MOST {
            self.samples.pop_front();
        }
        let error = sample.output_error.unwrap_or(0.0);
        self.samples.push_back((sample.position, error));
    }

    /// Forgets everything: what was recorded goes on elsewhere.
    pub fn clear(&mut self) {
        self.samples.clear();
    }
}

/// The output error against what the encoder allows, and its likely cause where that is not all.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Root mean square of the output error over the second half of the recording, rad.
    pub rms: f64,
    /// What rounding to the encoder's resolution alone would leave, rad.
    pub resolution_rms: f64,
    /// Correlation of the output error from sample to sample.
    pub correlation: f64,
    /// The best explanation of the rest and the part of it that it explains, if it explains
    /// [`Report::TELLING`].
    pub cause: Option<(Cause, f64)>,
}

/// What a model without it would show in its output error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Viscous friction that differs with the direction.
    AsymmetricFriction,
    /// Friction that grows with the square of the velocity.
    QuadraticFriction,
    /// Friction that is larger at low speed.
    Stribeck,
    /// Coulomb friction that the model has not got.
    Coulomb,
    /// A gap between motor and load.
    Backlash,
    /// A delay between command and motion, or of the measurement.
    Delay,
}

impl Cause {
    const ALL: [Self; 6] = [
        Self::Coulomb,
        Self::AsymmetricFriction,
        Self::QuadraticFriction,
        Self::Stribeck,
        Self::Backlash,
        Self::Delay,
    ];
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AsymmetricFriction => "viscous friction that differs with the direction",
            Self::QuadraticFriction => "friction that grows with the square of the velocity",
            Self::Stribeck => "friction that is larger at low speed (Stribeck)",
            Self::Coulomb => "Coulomb friction: add \"coulomb\" to the parameters",
            Self::Backlash => "backlash between motor and load",
            Self::Delay => "a delay that the declared loop has not got",
        })
    }
}

impl Report {
    /// Output error beyond this many times the encoder's is not the encoder's.
    const BEYOND_ENCODER: f64 = 1.5;

    /// A cause that explains less of the output error's variance than this is not named.
    pub const TELLING: f64 = 0.1;

    /// The report of a run.
    #[must_use]
    pub fn new(scenario: &Scenario, summary: &Summary, recording: Recording) -> Self {
        let (positions, errors): (Vec<f64>, Vec<f64>) = recording.samples.into_iter().unzip();
        let second_half = errors.len() / 2..errors.len();
        let judged = &errors[second_half.clone()];
        let rms = (mean(judged.iter().map(|e| e * e))).sqrt();
        let resolution_rms = scenario.stated.resolution / 12.0_f64.sqrt();
        let mut report = Self {
            rms,
            resolution_rms,
            correlation: correlation(judged),
            cause: None,
        };
        if !report.is_the_encoders() {
            let servo = ServoParameters {
                a: summary.a.last,
                b: summary.b.last,
                coulomb: summary.coulomb.last,
                load: summary.load.last,
            };
            let velocity = smooth_velocity(&positions, scenario.sample_time());
            let bandwidth = summary.outcome.bandwidth;
            let shapes = Shapes::new(scenario, &servo, &velocity, bandwidth);
            let own: Vec<Vec<f64>> = shapes
                .of_the_model(servo.coulomb > 0.0)
                .iter()
                .map(|shape| centred(&shape[second_half.clone()]))
                .collect();
            let own = orthogonal(own);
            let rest = without(&own, centred(judged));
            report.cause = Cause::ALL
                .into_iter()
                .filter(|cause| *cause != Cause::Coulomb || servo.coulomb == 0.0)
                .map(|cause| {
                    let shape = shapes.of(cause);
                    let shape = without(&own, centred(&shape[second_half.clone()]));
                    (cause, explained(&rest, &shape))
                })
                .filter(|(_, part)| *part >= Self::TELLING)
                .max_by(|x, y| x.1.total_cmp(&y.1));
        }
        report
    }

    /// Whether the encoder's resolution accounts for the output error.
    #[must_use]
    pub fn is_the_encoders(&self) -> bool {
        self.rms <= Self::BEYOND_ENCODER * self.resolution_rms
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "residual: output error {:.3e} rms, {:.1} times what the encoder's resolution leaves, \
             correlation from sample to sample {:.2}",
            self.rms,
            self.rms / self.resolution_rms,
            self.correlation
        )?;
        if self.is_the_encoders() {
            return write!(f, ": the model explains all that the encoder shows");
        }
        match self.cause {
            Some((cause, part)) => write!(
                f,
                "\n  the model lacks something; likeliest: {cause} ({:.0} % of the rest)",
                100.0 * part
            ),
            None => write!(
                f,
                "\n  the model lacks something, or has not converged; none of the usual causes \
                 stands out"
            ),
        }
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.sum::<f64>() / count
}

fn correlation(errors: &[f64]) -> f64 {
    let centre = mean(errors.iter().copied());
    let variance = mean(errors.iter().map(|e| (e - centre).powi(2)));
    let lagged = errors.windows(2).map(|w| (w[0] - centre) * (w[1] - centre));
    if variance > 0.0 {
        mean(lagged) / variance
    } else {
        0.0
    }
}

/// The part of the errors' square that a multiple of a shape explains.
fn explained(errors: &[f64], shape: &[f64]) -> f64 {
    let (errors_square, shape_square) = (dot(errors, errors), dot(shape, shape));
    if errors_square > 0.0 && shape_square > 0.0 {
        dot(errors, shape).powi(2) / (errors_square * shape_square)
    } else {
        0.0
    }
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

fn centred(values: &[f64]) -> Vec<f64> {
    let centre = mean(values.iter().copied());
    values.iter().map(|value| value - centre).collect()
}

/// What is left of values once every multiple of mutually orthogonal shapes is taken out.
fn without(shapes: &[Vec<f64>], mut values: Vec<f64>) -> Vec<f64> {
    for shape in shapes {
        let square = dot(shape, shape);
        if square > 0.0 {
            let part = dot(&values, shape) / square;
            for (value, s) in values.iter_mut().zip(shape) {
                *value -= part * s;
            }
        }
    }
    values
}

/// The shapes made orthogonal to each other (Gram and Schmidt).
fn orthogonal(shapes: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    shapes.into_iter().fold(Vec::new(), |mut done, shape| {
        let next = without(&done, shape);
        done.push(next);
        done
    })
}

/// The shapes that accelerations which a model lacks, or has in the wrong measure, would give the
/// output error: each passes through the loop that pulls the model to the servo,
/// ẍ = −α ẋ − l_p x − l_i ∫x + f.
struct Shapes<'a> {
    scenario: &'a Scenario,
    servo: &'a ServoParameters,
    velocity: &'a [f64],
    rms: f64,
    /// Of the model's correction, where the law chose it as it went.
    bandwidth: Option<f64>,
}

/// What pulls the model to the servo: acceleration per output error, per its rate and per its
/// integral.
struct Pull {
    stiffness: f64,
    damping: f64,
    integral: f64,
}

impl<'a> Shapes<'a> {
    fn new(
        scenario: &'a Scenario,
        servo: &'a ServoParameters,
        velocity: &'a [f64],
        bandwidth: Option<f64>,
    ) -> Self {
        Self {
            scenario,
            servo,
            velocity,
            bandwidth,
            rms: mean(velocity.iter().map(|v| v * v)).sqrt(),
        }
    }

    /// The change of the velocity in each sample, rad/s².
    fn accelerations(&self) -> Vec<f64> {
        let t = self.scenario.sample_time();
        let steps = self.velocity.windows(2).map(|w| (w[1] - w[0]) / t);
        let mut accelerations: Vec<f64> = steps.collect();
        accelerations.extend(accelerations.last().copied());
        accelerations
    }

    fn pull(&self) -> Pull {
        let b = self.servo.b;
        match self.scenario.stated.correction_gains() {
            Ok(gains) if self.scenario.identifier.law.is_gradient() => Pull {
                stiffness: b * gains.kp(),
                damping: b * gains.kd(),
                integral: b * gains.ki(),
            },
            _ => {
                let of_motion =
                    || mean(self.accelerations().iter().map(|a| a * a)).sqrt() / self.rms;
                let stated = self.scenario.stated.identifier.bandwidth;
                let bandwidth = self.bandwidth.or(stated).unwrap_or_else(of_motion);
                Pull {
                    stiffness: bandwidth * bandwidth,
                    damping: 2.0 * bandwidth,
                    integral: 0.0,
                }
            }
        }
    }

    fn direction(&self, v: f64) -> f64 {
        /// Below this part of the usual velocity the servo counts as standing.
        const STANDING: f64 = 0.02;
        if v.abs() > STANDING * self.rms {
            v.signum()
        } else {
            0.0
        }
    }

    /// Those of the model's own parameters. What a cause has in common with them the model has
    /// already taken up, in the wrong measure.
    fn of_the_model(&self, coulomb: bool) -> Vec<Vec<f64>> {
        let mut shapes = vec![
            self.response(self.velocity.iter().copied()),
            self.response(self.accelerations().into_iter()),
        ];
        if coulomb {
            shapes.push(self.response(self.velocity.iter().map(|&v| self.direction(v))));
        }
        shapes
    }

    /// That of a cause. A gap or a delay displaces, and shows directly.
    fn of(&self, cause: Cause) -> Vec<f64> {
        let velocity = || self.velocity.iter().copied();
        let through_loop = |force: &dyn Fn(f64) -> f64| self.response(velocity().map(force));
        let slow = |v: f64| (-(v / (0.2 * self.rms)).powi(2)).exp();
        match cause {
            Cause::Coulomb => through_loop(&|v| -self.direction(v)),
            Cause::AsymmetricFriction => through_loop(&|v| -v.abs()),
            Cause::QuadraticFriction => through_loop(&|v| -v * v.abs()),
            Cause::Stribeck => through_loop(&|v| -self.direction(v) * slow(v)),
            Cause::Backlash => velocity().map(|v| self.direction(v)).collect(),
            Cause::Delay => velocity().collect(),
        }
    }

    fn response(&self, forces: impl Iterator<Item = f64>) -> Vec<f64> {
        let pull = self.pull();
        let t = self.scenario.sample_time();
        let damping = self.servo.a + pull.damping;
        // Steps short enough for the loop, however coarse the sampling.
        let fastest = damping + pull.stiffness.sqrt();
        let parts = (10.0 * t * fastest).ceil().clamp(1.0, 1000.0);
        let h = t / parts;
        let (mut x, mut rate, mut integral) = (0.0, 0.0, 0.0);
        forces
            .map(|f| {
                for _ in 0..parts as u32 {
                    let acceleration =
                        f - damping * rate - pull.stiffness * x - pull.integral * integral;
                    rate += h * acceleration;
                    x += h * rate;
                    integral += h * x;
                }
                x
            })
            .collect()
    }
}

/// The velocity over a few samples to both sides.
fn smooth_velocity(positions: &[f64], t: f64) -> Vec<f64> {
    const REACH: usize = 5;
    (0..positions.len())
        .map(|k| {
            let (from, to) = (
                k.saturating_sub(REACH),
                (k + REACH).min(positions.len() - 1),
            );
            let span = (to - from).max(1) as f64 * t;
            (positions[to] - positions[from]) / span
        })
        .collect()
}
