//! The frequency at which the output error swings most.

/// Frequencies that are looked at to an octave.
const PER_OCTAVE: f64 = 24.0;

/// The frequency of the highest peak of a signal's power from a frequency on, radians a sample: the
/// highest that is higher than both its neighbours.
pub(super) fn frequency(signal: &[f64], from: f64) -> Option<f64> {
    const MAX_FREQUENCY: f64 = 0.9 * std::f64::consts::PI;
    let octaves = (MAX_FREQUENCY / from).log2().max(0.0);
    let powers: Vec<(f64, f64)> = (0..=(octaves * PER_OCTAVE) as u32)
        .map(|k| from * (f64::from(k) / PER_OCTAVE).exp2())
        .map(|frequency| (frequency, power(signal, frequency)))
        .collect();
    powers
        .windows(3)
        .filter(|three| three[1].1 > three[0].1 && three[1].1 > three[2].1)
        .max_by(|x, y| x[1].1.total_cmp(&y[1].1))
        .map(|three| three[1].0)
}

/// The power of a signal about a frequency: over pieces so short that each sees a band as wide as the
/// steps between the frequencies.
fn power(signal: &[f64], frequency: f64) -> f64 {
    let piece =
        ((std::f64::consts::TAU * PER_OCTAVE / frequency) as usize).clamp(8, signal.len().max(8));
    let turn = 2.0 * frequency.cos();
    signal
        .chunks_exact(piece)
        .map(|piece| {
            // Goertzel's recursion.
            let (mut last, mut before) = (0.0, 0.0);
            for value in piece {
                (before, last) = (last, value + turn * last - before);
            }
            (last * last + before * before - turn * last * before) / piece.len() as f64
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use virtual_servo::excitation::NormalSource;

    use super::frequency;

    #[test]
    fn a_swing_is_found_in_noise_of_its_size() {
        let mut source = NormalSource::new(1);
        let noise: Vec<f64> = (0..8000).map(|_| source.next_uniform() - 0.5).collect();
        let swinging: Vec<f64> = noise
            .iter()
            .enumerate()
            .map(|(k, noise)| noise + (0.37 * k as f64).sin())
            .collect();
        let found = frequency(&swinging, 0.05).expect("a peak");
        assert!((found / 0.37 - 1.0).abs() < 0.03, "{found}");
    }
}
