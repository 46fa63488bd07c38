use crate::number::Number;
use crate::parameters::{ModelParameters, Unknown, UnknownSet};
use crate::unrolled::each;

/// The sizes of the optional terms, machine units. The default is no term.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TermValues<N> {
    /// τ/T, samples.
    pub delay: N,
    /// δa T.
    pub asymmetry: N,
    /// s T²/ρ.
    pub low_speed: N,
    /// ρ/(T v_s), declared, not estimated: velocities in multiples of v_s.
    pub per_low_speed_velocity: N,
    /// g_s, g_c, r_s and r_c, each times T²/ρ.
    pub waves: [N; 4],
    /// δ, command units.
    pub dead_band: N,
}

impl<N: Number> TermValues<N> {
    /// The addition of terms to Coulomb friction, from the Stribeck factor of the sample.
    #[inline]
    pub(crate) fn coulomb(&self, stribeck_factor: N) -> N {
        self.low_speed * stribeck_factor
    }

    /// The deceleration by the terms of viscous friction at a velocity.
    #[inline]
    pub(super) fn brake(&self, velocity: N) -> N {
        self.asymmetry * velocity.magnitude()
    }
}

/// The values of all unknowns of a model, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelValues<N: Number> {
    /// The four parameters.
    pub parameters: ModelParameters<N>,
    /// The terms.
    pub terms: TermValues<N>,
}

impl<N: Number> ModelValues<N> {
    /// The model of a set with these values.
    #[inline]
    pub(crate) fn from_values<S: UnknownSet<P>, const P: usize>(values: &[N; P]) -> Self {
        let mut parameters = ModelParameters {
            x: N::ZERO,
            gain: N::ZERO,
            coulomb: N::ZERO,
            load: N::ZERO,
        };
        let mut terms = TermValues::default();
        let [gravity_sine, gravity_cosine, ripple_sine, ripple_cosine] = &mut terms.waves;
        each::<P>(|i| {
            let place = match S::UNKNOWNS[i] {
                Unknown::A => &mut parameters.x,
                Unknown::B => &mut parameters.gain,
                Unknown::Coulomb => &mut parameters.coulomb,
                Unknown::Load => &mut parameters.load,
                Unknown::Delay => &mut terms.delay,
                Unknown::Asymmetry => &mut terms.asymmetry,
                Unknown::LowSpeed => &mut terms.low_speed,
                Unknown::GravitySine => &mut *gravity_sine,
                Unknown::GravityCosine => &mut *gravity_cosine,
                Unknown::RippleSine => &mut *ripple_sine,
                Unknown::RippleCosine => &mut *ripple_cosine,
                Unknown::DeadBand => &mut terms.dead_band,
            };
            *place = values[i];
        });
        Self { parameters, terms }
    }
}
