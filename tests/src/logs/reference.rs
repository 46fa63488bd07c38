//! References as users have them: noise, steps, chirps, trapezoids, binary sequences; rad over time.

use std::f64::consts::PI;

use crate::Random;

/// The kind and size of a reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reference {
    /// Normal levels, each held for a time.
    Noise {
        /// Standard deviation, rad.
        amplitude: f64,
        /// S.
        hold: f64,
    },
    /// Uniform levels, each held for a time.
    Steps {
        /// The largest, rad.
        amplitude: f64,
        /// S.
        hold: f64,
    },
    /// A sine whose frequency rises and falls evenly.
    Chirp {
        /// Rad.
        amplitude: f64,
        /// The lowest and the highest frequency, rad/s.
        frequencies: [f64; 2],
        /// Time of a rise, s.
        sweep: f64,
    },
    /// Moves to uniform levels with a trapezoid of velocity, and pauses.
    Trapezoids {
        /// The largest level, rad.
        amplitude: f64,
        /// The highest velocity, rad/s.
        velocity: f64,
        /// Rad/s².
        acceleration: f64,
        /// S.
        pause: f64,
    },
    /// Two levels in random order.
    Binary {
        /// Rad.
        amplitude: f64,
        /// The shortest time of a level, s.
        hold: f64,
    },
}

impl Reference {
    /// Its values at some samples from zero on, rad.
    pub(super) fn values(&self, samples: usize, sample_time: f64, random: &mut Random) -> Vec<f64> {
        match *self {
            Self::Noise { amplitude, hold } => {
                let mut level = || amplitude * random.normal();
                held(samples, hold / sample_time, &mut level)
            }
            Self::Steps { amplitude, hold } => {
                let mut level = || amplitude * random.uniform(-1.0, 1.0);
                held(samples, hold / sample_time, &mut level)
            }
            Self::Binary { amplitude, hold } => {
                let mut level = || amplitude.copysign(random.uniform(-1.0, 1.0));
                held(samples, hold / sample_time, &mut level)
            }
            Self::Chirp {
                amplitude,
                frequencies: [low, high],
                sweep,
            } => {
                let mut phase = 0.0_f64;
                let frequency = |time: f64| {
                    let turn = (time / sweep) % 2.0;
                    low + (high - low) * (1.0 - (turn - 1.0).abs())
                };
                let of_sample = |sample: usize| {
                    phase =
                        (phase + sample_time * frequency(sample as f64 * sample_time)) % (2.0 * PI);
                    amplitude * phase.sin()
                };
                (0..samples).map(of_sample).collect()
            }
            Self::Trapezoids {
                amplitude,
                velocity,
                acceleration,
                pause,
            } => {
                let mut values = Vec::with_capacity(samples);
                let mut from = 0.0;
                while values.len() < samples {
                    let to = amplitude * random.uniform(-1.0, 1.0);
                    let lasting = move_time((to - from).abs(), velocity, acceleration) + pause;
                    let steps = (lasting / sample_time).ceil() as usize;
                    values.extend((0..steps).map(|step| {
                        let gone = travelled(
                            step as f64 * sample_time,
                            (to - from).abs(),
                            velocity,
                            acceleration,
                        );
                        from + gone.copysign(to - from)
                    }));
                    from = to;
                }
                values.truncate(samples);
                values
            }
        }
    }
}

/// Levels, each held for some samples, one or more.
fn held(samples: usize, hold: f64, level: &mut dyn FnMut() -> f64) -> Vec<f64> {
    let hold = (hold as usize).max(1);
    let mut value = 0.0;
    let of_sample = |sample: usize| {
        if sample.is_multiple_of(hold) {
            value = level();
        }
        value
    };
    (0..samples).map(of_sample).collect()
}

/// The time of a move over a distance, s.
fn move_time(distance: f64, velocity: f64, acceleration: f64) -> f64 {
    let ramp = (velocity / acceleration).min((distance / acceleration).sqrt());
    2.0 * ramp + (distance - acceleration * ramp * ramp) / (acceleration * ramp).max(1e-12)
}

/// The distance travelled in a time of such a move.
fn travelled(time: f64, distance: f64, velocity: f64, acceleration: f64) -> f64 {
    let ramp = (velocity / acceleration).min((distance / acceleration).sqrt());
    let left = move_time(distance, velocity, acceleration) - time;
    if time < ramp {
        0.5 * acceleration * time * time
    } else if left > ramp {
        acceleration * ramp * (time - 0.5 * ramp)
    } else {
        distance - 0.5 * acceleration * left.max(0.0) * left.max(0.0)
    }
}
