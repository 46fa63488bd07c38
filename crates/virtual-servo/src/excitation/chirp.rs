use super::oscillator::{Phase, SineSeries};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::excitation::{Excitation, Hold};
use identifier_core::number::Number;
use identifier_core::units::Units;

/// A sine whose frequency changes linearly from one value to another and then starts again. The phase continues without
/// a jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chirp<N> {
    amplitude: N,
    first: Phase,
    change: Phase,
    samples: u32,
    series: SineSeries<N>,
}

/// Progress of a [`Chirp`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChirpState {
    phase: Phase,
    increment: Phase,
    sample: u32,
}

impl<N: Number> Chirp<N> {
    /// A chirp of an amplitude (rad), from and to an angular frequency (rad/s), in a time (s). The time is a whole
    /// number of control samples.
    ///
    /// # Errors
    /// `amplitude` must be above 0, both frequencies (`from`, `to`) above 0 and below π/T. `duration` must be a whole
    /// number of control samples.
    pub fn new(
        units: &Units,
        amplitude: f64,
        from: f64,
        to: f64,
        duration: f64,
    ) -> Result<Self, OutOfRange> {
        let nyquist = core::f64::consts::PI / units.sample_time();
        Allowed::Above(0.0).check("amplitude", amplitude)?;
        Allowed::Between(0.0, nyquist).check("from", from)?;
        Allowed::Between(0.0, nyquist).check("to", to)?;
        let samples = Hold::steps("duration", duration, units.sample_time())?;
        let turns = |frequency: f64| frequency * units.sample_time() / core::f64::consts::TAU;
        let first = Phase::from_turns(turns(from));
        let last = Phase::from_turns(turns(to));
        let change = last.0.wrapping_sub(first.0).cast_signed() / i64::from(samples);
        Ok(Self {
            amplitude: N::from_f64(amplitude * units.position()),
            first,
            change: Phase(change.cast_unsigned()),
            samples,
            series: SineSeries::new(),
        })
    }
}

impl<N: Number> Excitation<N> for Chirp<N> {
    type State = ChirpState;

    fn start(&self) -> ChirpState {
        ChirpState {
            phase: Phase(0),
            increment: self.first,
            sample: 0,
        }
    }

    #[inline]
    fn process(&self, state: &mut ChirpState) -> N {
        let value = self.amplitude * state.phase.sine(&self.series);
        state.phase.advance(state.increment);
        state.increment.advance(self.change);
        state.sample += 1;
        if state.sample == self.samples {
            state.sample = 0;
            state.increment = self.first;
        }
        value
    }
}
