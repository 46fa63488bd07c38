//! A record seen without a model: how noisy, how fast and how quick its motion is.

use super::Record;

/// Figures of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordStatistics {
    /// Deviation of the noise of the positions, counts: by third differences, in which no motion is left.
    pub noise: f64,
    /// A large velocity of the motion: two standard deviations, counts/sample.
    pub velocity: f64,
    /// The largest command, command units.
    pub command: f64,
    /// Bandwidth of the motion: deviation of acceleration over that of velocity, rad/sample.
    pub bandwidth: f64,
}

/// Means over a window of the record, with the weights (1 − x²)³.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    pub(super) acceleration: f64,
    pub(super) velocity: f64,
    pub(super) command: f64,
    pub(super) command_change: f64,
    /// Mean direction of the motion.
    pub(super) direction: f64,
    /// The part of the window in which the servo moved.
    pub(super) moving: f64,
    /// Means of the angle's sine and cosine; zero on an axis without angle.
    pub(super) wave: [f64; 2],
}

/// ∫(1 − x²)³, ∫(d/dx (1 − x²)³)² and ∫(d²/dx² (1 − x²)³)² from −1 to 1.
const KERNEL: [f64; 3] = [0.914_286, 2.659_75, 29.257_1];

/// Deviations of a window's velocity and acceleration by noise of deviation one.
fn window_noise(half_width: usize) -> [f64; 2] {
    let width = half_width as f64;
    let [mean, slope, curvature] = KERNEL;
    [
        libm::sqrt(slope / (width * width * width)) / mean,
        libm::sqrt(curvature / libm::pow(width, 5.0)) / mean,
    ]
}

/// Shows every window of a half width, a third of it apart.
pub(super) fn windows(
    record: &Record<'_>,
    half_width: usize,
    noise: f64,
    observe: &mut impl FnMut(&Window),
) {
    let width = half_width as f64;
    // A direction is distinguished from noise by the means over a quarter of the half width to either side.
    let partial_regression = (half_width / 4).max(1);
    let threshold =
        partial_regression as f64 * (2.8 * noise / libm::sqrt(partial_regression as f64) + 0.35);
    let positions = record.positions;
    let step = (half_width / 3).max(1);
    for (first, end) in record.motions() {
        let mut centre = first + half_width + partial_regression + 1;
        while centre + half_width + partial_regression + 1 < end {
            let mut sum = 0.0;
            let mut window = Window {
                acceleration: 0.0,
                velocity: 0.0,
                command: 0.0,
                command_change: 0.0,
                direction: 0.0,
                moving: 0.0,
                wave: [0.0; 2],
            };
            // Sum of the positions ahead of a sample less that behind.
            let begin = centre - half_width + 1;
            let mut moved: f64 = (1..=partial_regression)
                .map(|k| positions[begin + k] - positions[begin - k])
                .sum();
            for sample in begin..centre + half_width {
                let x = (sample as f64 - centre as f64) / width;
                let weight = (1.0 - x * x) * (1.0 - x * x) * (1.0 - x * x);
                sum += weight;
                let [before, after] = [record.increment(sample - 1), record.increment(sample)];
                let [earlier, command] = [record.commands[sample - 1], record.commands[sample]];
                window.acceleration += weight * (after - before);
                window.velocity += weight * 0.5 * (before + after);
                window.command += weight * 0.5 * (earlier + command);
                window.command_change += weight * (command - earlier);
                if let Some([sine, cosine]) = record.angles.get(sample) {
                    window.wave[0] += weight * sine;
                    window.wave[1] += weight * cosine;
                }
                if moved.abs() > threshold {
                    window.direction += weight * moved.signum();
                    window.moving += weight;
                }
                moved += positions[sample + 1 + partial_regression]
                    - positions[sample + 1]
                    - positions[sample]
                    + positions[sample - partial_regression];
            }
            let per = 1.0 / sum;
            observe(&Window {
                acceleration: window.acceleration * per,
                velocity: window.velocity * per,
                command: window.command * per,
                command_change: window.command_change * per,
                direction: window.direction * per,
                moving: window.moving * per,
                wave: window.wave.map(|sum| sum * per),
            });
            centre += step;
        }
    }
}

impl RecordStatistics {
    /// The survey of a record; none without motion.
    #[must_use]
    pub fn new(record: &Record<'_>) -> Option<Self> {
        /// Variance of a third difference of white noise.
        const THIRD_DIFFERENCE: f64 = 20.0;
        /// Signal over noise from which on a window's figures are the motion's.
        const CLEAR: f64 = 4.0;
        /// Bandwidth where none can be seen, rad/sample.
        const UNKNOWN_BANDWIDTH: f64 = 0.02;
        let (mut third, mut rows, mut path) = (0.0, 0.0, 0.0);
        let command = record.largest_command();
        for (first, end) in record.motions() {
            for sample in first..end {
                let stride = record.stride.max(1);
                if record.is_measured(sample - first) && sample + 3 * stride < end {
                    let p = [0, 1, 2, 3].map(|k| record.positions[sample + k * stride]);
                    let change = p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0];
                    third += change * change;
                    rows += 1.0;
                    path += (p[1] - p[0]).abs();
                }
            }
        }
        if rows < 10.0 || path == 0.0 || command == 0.0 {
            return None;
        }
        let noise = libm::sqrt(third / rows / THIRD_DIFFERENCE).max(super::QUANTISATION_SIGMA);
        let mut half_width = 6;
        let mut statistics = Self {
            noise,
            velocity: 0.0,
            command,
            bandwidth: UNKNOWN_BANDWIDTH,
        };
        while half_width < record.len() / 10 {
            let (mut count, mut v, mut vv, mut aa) = (0.0, 0.0, 0.0, 0.0);
            windows(record, half_width, noise, &mut |window| {
                count += 1.0;
                v += window.velocity;
                vv += window.velocity * window.velocity;
                aa += window.acceleration * window.acceleration;
            });
            if count < 4.0 {
                break;
            }
            let speed = libm::sqrt((vv / count - v * v / (count * count)).max(0.0));
            let acceleration = libm::sqrt(aa / count);
            let [slow, quick] = window_noise(half_width).map(|per| per * noise);
            statistics.velocity = statistics.velocity.max(2.0 * libm::sqrt(vv / count));
            if speed > CLEAR * slow && acceleration > CLEAR * quick {
                statistics.bandwidth = acceleration / speed;
                break;
            }
            half_width = half_width * 7 / 5;
        }
        (statistics.velocity > 0.0).then_some(statistics)
    }

    /// Standard deviation of the position of a motion of one frequency, counts.
    #[must_use]
    pub fn amplitude(&self) -> f64 {
        0.5 * self.velocity / self.bandwidth
    }

    /// The shortest horizon of the filter, samples. It is the motion's own time. Below it the filter would follow
    /// everything that the model lacks.
    #[must_use]
    pub fn shortest_horizon(&self, samples: usize) -> f64 {
        (0.7 / self.bandwidth).clamp(6.0, (samples as f64 / 100.0).max(8.0))
    }
}
