use super::GaussNewtonRecursion;
use super::fitted::{COVARIANCE_FACTOR, FirstFitSolution};
use super::interrupt::GaussNewtonRecursionState;
use crate::constants::{Encode, encode};
use crate::identify::Identify;
use crate::linalg::Factors;
use crate::model::IdentifiableSet;
use crate::number::Number;
use crate::parameters::{IdentifiedServo, Parameter, Unknown};

/// The motion in which a servo that is known already is identified further.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedMotion {
    /// The bandwidth of the loop that moves it, rad/s.
    pub bandwidth: f64,
    /// The usual command, command units. Its acceleration is the size of the largest load steps and friction errors.
    pub command: f64,
}

/// A servo that is known already, prepared for a recursion over any unknowns: 20 words in `f32`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreparedServo<N>(FirstFitSolution<N>);

encode! {
    [N: Encode] PreparedServo<N> as "PreparedServo" { 0 }
}

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// Starts from an identified servo with its covariance, without a first fit. For the background: it converts from
    /// SI.
    ///
    /// The model joins the servo with the first samples; effects that its model lacks are identified anew.
    #[must_use]
    pub fn start_from_known(
        &self,
        servo: &IdentifiedServo,
        motion: &ExpectedMotion,
    ) -> GaussNewtonRecursionState<N, S, P> {
        self.start_from(&self.prepare(servo, motion))
    }

    /// The same in two steps, of which the first may be computed elsewhere.
    #[must_use]
    pub fn start_from(&self, known: &PreparedServo<N>) -> GaussNewtonRecursionState<N, S, P> {
        let known = &known.0;
        let start = self.start();
        GaussNewtonRecursionState {
            recursion: self.recursion(known, &start.recursion, N::ZERO),
            usual: known.unexplained,
            recording: false,
            ..start
        }
    }

    /// A servo that was identified, in machine units: it converts from SI.
    #[must_use]
    pub fn prepare(&self, servo: &IdentifiedServo, motion: &ExpectedMotion) -> PreparedServo<N> {
        let units = &self.units;
        let places = Parameter::ALL.map(place_of);
        let scales = Parameter::ALL.map(|parameter| Unknown::from(parameter).scale(units));
        let has = Parameter::ALL.map(|parameter| S::UNKNOWNS.contains(&parameter.into()));
        let values = servo.values();
        let values = places.map(|place| values.get(place).copied().unwrap_or(0.0));
        let estimates = core::array::from_fn(|i| N::from_f64(values[i] * scales[i]));
        let covariance = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                if !has[i] || !has[j] {
                    return 0.0;
                }
                let row = servo.covariance.get(places[i]);
                let entry = row.and_then(|row| row.get(places[j])).copied();
                COVARIANCE_FACTOR * entry.unwrap_or(0.0) * scales[i] * scales[j]
            })
        });
        let unexplained = servo.unexplained * units.position();
        let acceleration = servo.parameters.b * motion.command * units.acceleration();
        PreparedServo(FirstFitSolution {
            estimates,
            covariance: Factors::from_matrix(&covariance),
            unexplained: N::from_f64(unexplained * unexplained),
            noise: N::ONE,
            per_noise: N::ONE,
            bandwidth: N::from_f64(motion.bandwidth * units.sample_time()),
            acceleration: N::from_f64(acceleration),
            one_way: false,
        })
    }
}

/// The place of a parameter among the values of a servo that was identified, and in their covariance.
const fn place_of(parameter: Parameter) -> usize {
    match parameter {
        Parameter::A => IdentifiedServo::A,
        Parameter::B => IdentifiedServo::B,
        Parameter::Coulomb => IdentifiedServo::COULOMB,
        Parameter::Load => IdentifiedServo::LOAD,
    }
}
