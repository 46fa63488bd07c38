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

/// Shows the mean velocity and acceleration of every window of a half width, a third of it apart. The weights are
/// (1 − x²)³.
fn windows(record: &Record<'_>, half_width: usize, observe: &mut impl FnMut([f64; 2])) {
    let width = half_width as f64;
    let around = (half_width / 4).max(1);
    let step = (half_width / 3).max(1);
    for (first, end) in record.motions() {
        let mut centre = first + half_width + around + 1;
        while centre + half_width + around + 1 < end {
            let (mut sum, mut velocity, mut acceleration) = (0.0, 0.0, 0.0);
            for sample in centre - half_width + 1..centre + half_width {
                let x = (sample as f64 - centre as f64) / width;
                let weight = (1.0 - x * x) * (1.0 - x * x) * (1.0 - x * x);
                sum += weight;
                let [before, after] = [record.increment(sample - 1), record.increment(sample)];
                acceleration += weight * (after - before);
                velocity += weight * 0.5 * (before + after);
            }
            observe([velocity / sum, acceleration / sum]);
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
            windows(record, half_width, &mut |[velocity, acceleration]| {
                count += 1.0;
                v += velocity;
                vv += velocity * velocity;
                aa += acceleration * acceleration;
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
