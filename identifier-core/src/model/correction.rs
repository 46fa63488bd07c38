use crate::constants::encode;
use crate::control::{Gains, PidTerms};
use crate::number::{Arithmetic, Encoded};
use crate::scales::FullScales;
use crate::units::Units;

/// The feedback on the output error ε that keeps the model close to the servo. It is the identifier's own, in the
/// paper's form as a command: u_ε = k_p ε + k_d ε̇ + k_i ω, ω = ∫ε.
///
/// It replaces the second PID (6). Gains, velocity filter and sum (the samples before this one) are the same. There is
/// no limit and no anti-windup, since the command that acted is limited already. The integral also estimates the load,
/// d̂ = b̂ k_i ω, by ω → 0 in (9). As b̂ multiplies the correction, the sampled loop must be stable for every b̂ that
/// the bounds allow ([`SampledLoop::check_estimates`](crate::stability::SampledLoop::check_estimates)).
///
/// In fixed point k_p ε + k_d ε̇ is limited to half of the command's full scale. The sum ω stops where k_i ω is as much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CommandCorrection<N: Arithmetic> {
    terms: PidTerms<N>,
    /// Half of the command's full scale, in that of the terms.
    most: N,
}

encode! {
    [N: Encoded] CommandCorrection<N> as "CommandCorrection" { terms, most }
}

impl<N: Arithmetic> CommandCorrection<N> {
    /// The correction with the gains of a PID: the user's own gives the paper's loop.
    pub(crate) fn new(units: &Units, gains: &Gains, scales: &FullScales) -> Self {
        let (terms, wanted) = PidTerms::new(units, gains, scales, scales.rate(), true);
        let most = if N::IS_FIXED {
            N::signal(scales.most_command(), wanted)
        } else {
            N::ZERO
        };
        Self { terms, most }
    }

    /// The command that acts on the model, u + u_ε. It follows from the command that acted, the sum ω of the samples
    /// before this one (as in the PID (3)), the output error and its rate. All are in machine units.
    #[inline(always)]
    pub(crate) fn process(&self, sum: &mut N::Sum, command: N, output_error: N, rate: N) -> N {
        let load = self.load_command(*sum);
        N::gather(sum, output_error, self.terms.to_sum);
        let feedback = output_error.by(self.terms.proportional) + rate.by(self.terms.derivative);
        let feedback = feedback
            .saturated_to(self.most)
            .raised(self.terms.to_command);
        (command + (feedback + load)).saturated()
    }

    /// k_i ω: the load over the gain as the integral estimates it, command units.
    #[inline(always)]
    pub(crate) fn load_command(&self, sum: N::Sum) -> N {
        N::of_sum(sum).by(self.terms.integral)
    }
}
