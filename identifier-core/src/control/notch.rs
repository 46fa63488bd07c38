use crate::constants::{Encode, encode};
use crate::error::{Allowed, OutOfRange};
use crate::number::{Arithmetic, Complex};
use crate::units::Units;

/// Notch filter of the command, for the resonance of a servo of two masses:
///
/// N(s) = (s² + 2 ζ_z ω s + ω²)/(s² + 2 ζ_p ω s + ω²), ζ_z = [`Notch::DEPTH`], ζ_p = [`Notch::WIDTH`],
///
/// under Tustin's transform with ω mapped exactly. At rest it passes a command unchanged.
///
/// It is computed as u − 2 (ζ_p − ζ_z) v. Here v is the band-pass of a state-variable filter in trapezoidal integration
/// (Zavalishin, The Art of VA Filter Design, 2018, chapter 4). The low-pass is kept as the distance from the command.
/// At rest both are zero, so at a small ω T no rounding remains in the command. Without a notch the command keeps its
/// bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Notch<N> {
    /// tan(ωT/2).
    rate: N,
    /// 1/(1 + g (g + 2 ζ_p)).
    feedback: N,
    /// 2 (ζ_p − ζ_z); zero for no notch.
    taken: N,
}

encode! {
    [N: Encode] Notch<N> as "Notch" { rate, feedback, taken }
}

/// State of a [`Notch`], command units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NotchState<N> {
    band: N,
    /// The last command, and how far the low-pass is from it.
    command: N,
    lag: N,
}

impl<N: Arithmetic> NotchState<N> {
    /// At rest with a command.
    pub(crate) fn at(command: N) -> Self {
        Self {
            band: N::ZERO,
            command,
            lag: N::ZERO,
        }
    }
}

impl<N: Arithmetic> Notch<N> {
    /// No notch.
    pub const NONE: Self = Self {
        rate: N::ZERO,
        feedback: N::ONE,
        taken: N::ZERO,
    };

    /// Damping ratio of the zeros. A smaller one would leave nothing of a command at ω, and more of a resonance near ω.
    pub const DEPTH: f64 = 0.05;

    /// Damping ratio of the poles. The notch covers the shift of resonances by wear and load. It costs 23° of phase at
    /// a third of ω.
    pub const WIDTH: f64 = 0.5;

    /// The highest ω, rad per sample.
    pub const HIGHEST: f64 = 2.5;

    /// At a frequency ω, rad/s: zero for none.
    ///
    /// # Errors
    /// `notch` must be from 0 to [`Notch::HIGHEST`] per sample time.
    pub fn new(units: &Units, frequency: f64) -> Result<Self, OutOfRange> {
        let highest = Self::HIGHEST / units.sample_time();
        Allowed::Within(0.0, highest).check("notch", frequency)?;
        if frequency == 0.0 {
            return Ok(Self::NONE);
        }
        let rate = tangent(0.5 * frequency * units.sample_time());
        Ok(Self {
            rate: N::signal(rate, 0),
            feedback: N::signal(1.0 / (1.0 + rate * (rate + 2.0 * Self::WIDTH)), 0),
            taken: N::signal(2.0 * (Self::WIDTH - Self::DEPTH), 0),
        })
    }

    /// True if there is one.
    #[inline]
    pub(crate) fn is_there(&self) -> bool {
        self.taken != N::ZERO
    }

    /// A command behind it, command units.
    #[inline]
    pub(crate) fn process(&self, state: &mut NotchState<N>, command: N) -> N {
        if self.is_there() {
            self.filter(state, command)
        } else {
            command
        }
    }

    /// A function of its own, for a sample without a notch not to pay for its registers.
    #[inline(never)]
    fn filter(&self, state: &mut NotchState<N>, command: N) -> N {
        let lag = state.lag + (command - state.command);
        let band = (state.band + lag.part(self.rate)).part(self.feedback);
        let risen = band.part(self.rate);
        state.command = command;
        state.lag = lag - (risen + risen);
        state.band = band + band - state.band;
        command - band.part(self.taken)
    }
}

/// tan x by Lambert's continued fraction, x/(1 − x²/(3 − x²/(5 − …))), to 10⁻¹⁴ up to 1.25. The tables of a reduction
/// for any angle would take ten kilobytes on a chip.
fn tangent(x: f64) -> f64 {
    let odd = (0..10).map(|place| f64::from(2 * place + 1));
    let fraction = odd
        .rev()
        .fold(f64::INFINITY, |below, odd| odd - x * x / below);
    x / fraction
}

/// N of a notch at ω (rad/s) at a frequency, both as ν = tan(ωT/2).
pub(crate) fn notch_at(notch: f64, nu: f64) -> Complex {
    let ratio = nu / notch;
    let of = |damping: f64| Complex::new(1.0 - ratio * ratio, 2.0 * damping * ratio);
    of(Notch::<f64>::DEPTH) / of(Notch::<f64>::WIDTH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::Number;
    use proptest::prelude::*;

    const SAMPLE_TIMES: [f64; 4] = [4e-3, 1e-3, 250e-6, 50e-6];

    fn notch<N: Number>(sample_time: f64, frequency: f64) -> Notch<N> {
        let units = Units::new(sample_time, 1e-3).expect("valid");
        Notch::new(&units, frequency).expect("valid")
    }

    /// The response to a sine after many periods, in phase and in quadrature.
    fn response<N: Number>(notch: &Notch<N>, angle: f64) -> [f64; 2] {
        let mut state = NotchState::at(N::ZERO);
        let settling = (60.0 / angle) as u32;
        // Whole periods, nearly: a Hann window has no use for the rest.
        let samples = (400.0 / angle) as u32;
        let mut sums = [0.0; 3];
        for k in 0..settling + samples {
            let phase = angle * f64::from(k);
            let passed = notch.process(&mut state, N::from_f64(phase.sin())).to_f64();
            if k >= settling {
                let place = f64::from(k - settling) / f64::from(samples);
                let weight = 1.0 - (core::f64::consts::TAU * place).cos();
                sums[0] += weight * passed * phase.sin();
                sums[1] += weight * passed * phase.cos();
                sums[2] += weight * 0.5;
            }
        }
        [sums[0] / sums[2], sums[1] / sums[2]]
    }

    #[test]
    fn a_sine_passes_as_the_formula_has_it_at_any_sample_rate() {
        for sample_time in SAMPLE_TIMES {
            let omega = 100.0;
            let exact = notch::<f64>(sample_time, omega);
            let single = notch::<f32>(sample_time, omega);
            for ratio in [0.2, 0.8, 1.0, 1.3, 3.0] {
                let angle = ratio * omega * sample_time;
                let nu = (0.5 * angle).tan();
                let expected = notch_at((0.5 * omega * sample_time).tan(), nu);
                let found = [response(&exact, angle), response(&single, angle)];
                for ([re, im], close) in found.into_iter().zip([1e-3, 2e-3]) {
                    let off = (re - expected.re).abs().max((im - expected.im).abs());
                    assert!(off < close, "{sample_time} {ratio}: {off}");
                }
            }
            let [left, _] = response(&exact, omega * sample_time);
            let part = Notch::<f64>::DEPTH / Notch::<f64>::WIDTH;
            assert!((left - part).abs() < 1e-3, "{left}");
        }
    }

    #[test]
    fn the_tangent_is_the_tangent() {
        for place in 1..=1250 {
            let x = f64::from(place) * 1e-3;
            assert!((tangent(x) / x.tan() - 1.0).abs() < 1e-14, "{x}");
        }
    }

    #[test]
    fn a_frequency_out_of_range_is_refused_by_name() {
        let units = Units::new(1e-3, 1e-3).expect("valid");
        for refused in [-1.0, f64::NAN, f64::INFINITY, 2501.0] {
            let error = Notch::<f32>::new(&units, refused).expect_err("refused");
            assert_eq!(error.parameter, "notch");
        }
        assert_eq!(Notch::<f32>::new(&units, 0.0), Ok(Notch::NONE));
        assert!(Notch::<f32>::new(&units, 2500.0).is_ok());
    }

    proptest! {
        /// It comes to rest with the command after any input. It then keeps no trace of the past.
        #[test]
        fn a_command_that_stands_passes_as_it_is(
            commands in prop::collection::vec(-100.0_f32..100.0, 1..200),
            held in -100.0_f32..100.0,
            rate in 0_usize..4,
            frequency in 30.0_f64..600.0,
        ) {
            let notch = notch::<f32>(SAMPLE_TIMES[rate], frequency);
            let mut state = NotchState::at(0.0);
            for command in commands {
                notch.process(&mut state, command);
            }
            let mut passed = 0.0;
            for _ in 0..(40.0 / (frequency * SAMPLE_TIMES[rate])) as u32 + 80 {
                passed = notch.process(&mut state, held);
            }
            prop_assert!((passed - held).abs() < 1e-4, "{} {}", passed, held);
            let mut begun = NotchState::at(held);
            prop_assert_eq!(notch.process(&mut begun, held).to_bits(), held.to_bits());
        }
    }
}
