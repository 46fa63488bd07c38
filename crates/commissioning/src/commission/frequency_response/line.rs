use super::plan::PlannedLine;
use identifier_core::number::Number;

/// A line of the multisine under way: its oscillator and its sums.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LineState<N> {
    rotation: [N; 2],
    /// e^(jωkT).
    turned: [N; 2],
    amplitude: N,
    max_amplitude: N,
    pub(super) position: [N; 2],
    pub(super) command: [N; 2],
}

impl<N: Number> LineState<N> {
    /// By how much an amplitude may change after a motion.
    const ADAPTATION: [f64; 2] = [0.15, 2.0];

    /// The first amplitude for a servo that is identified as one mass only, as a part of the largest amplitude.
    const CAUTION: f64 = 0.4;

    /// Begins line k at a phase of k (k + 1)/2 quarters. Phases that grow with k² halve the peak of lines that begin
    /// together (M. R. Schroeder, "Synthesis of low-peak-factor signals", IEEE Trans. Inf. Theory 16, 1970).
    pub(super) fn plan(&mut self, planned: &PlannedLine<N>, place: usize) {
        *self = Self {
            rotation: planned.rotation,
            turned: match place * (place + 1) / 2 % 4 {
                0 => [N::ONE, N::ZERO],
                1 => [N::ZERO, N::ONE],
                2 => [-N::ONE, N::ZERO],
                _ => [N::ZERO, -N::ONE],
            },
            amplitude: N::from_f64(Self::CAUTION) * planned.amplitude,
            max_amplitude: planned.amplitude,
            ..Self::default()
        };
    }

    /// The injection of the next sample.
    #[inline(always)]
    pub(super) fn inject(&mut self) -> N {
        self.turned = product(self.turned, self.rotation);
        self.amplitude * self.turned[0]
    }

    /// Takes increment and command of a sample, weighted.
    #[inline(always)]
    pub(super) fn gather(&mut self, increment: N, command: N) {
        let [re, im] = self.turned;
        self.position[0] += increment * re;
        self.position[1] += -(increment * im);
        self.command[0] += command * re;
        self.command[1] += -(command * im);
    }

    /// Changes the amplitude so that the sum of the increments becomes half of `wanted`: that of a velocity of the wanted
    /// amplitude.
    pub(super) fn adapt(&mut self, wanted: N) {
        let [least, most] = Self::ADAPTATION;
        let [re, im] = self.position;
        let power = re * re + im * im;
        let half = N::from_f64(0.5) * wanted;
        // A line without motion has no root.
        let tiny = N::from_f64(1e-6);
        let factor = if power > tiny {
            half * power.reciprocal_root()
        } else {
            N::from_f64(most)
        };
        let factor = factor.limited(N::from_f64(least), N::from_f64(most));
        self.amplitude = (factor * self.amplitude).limited(N::ZERO, self.max_amplitude);
    }

    /// Empties the sums, and takes back the length that the oscillator has gained or lost by rounding.
    pub(super) fn begin_anew(&mut self) {
        (self.position, self.command) = ([N::ZERO; 2], [N::ZERO; 2]);
        let [re, im] = self.turned;
        let scale = N::from_f64(1.5) - N::from_f64(0.5) * (re * re + im * im);
        self.turned = [scale * re, scale * im];
    }
}

/// The product of two complex numbers.
#[inline(always)]
pub(super) fn product<N: Number>([re, im]: [N; 2], [other_re, other_im]: [N; 2]) -> [N; 2] {
    [re * other_re - im * other_im, re * other_im + im * other_re]
}
