//! Controller and Γ-gradient identifier in fixed point, for drives without a floating-point unit.
//!
//! Controller and identifier are those of floating point, over the arithmetic of 32-bit words with 64-bit sums. The
//! [`Settings`](crate::settings::Settings) are the same. [`FixedLoop`] is controller and identifier together;
//! [`Gradient<Word>`](crate::Gradient) alone listens to any controller. Here are the [`Word`] and its arithmetic. Fixed
//! point also needs full scales, and checks of the settings.
//!
//! A word is a fraction of its quantity's full scale, which is a power of two. It is chosen when the parts are built.
//! It follows from an SI [`RangeSettings`](crate::settings::RangeSettings), the gains and the bounds of the estimates:
//!
//! | quantity | format | full scale, at least | beyond it |
//! |---|---|---|---|
//! | setpoint, count | 32 bits, offset Q16.16 | – | wrap: only their difference enters |
//! | position error e, output error ε as read | Q2.30 | `ranges.error`, four times that of the velocity | saturates |
//! | error of the filtered reference | Q2.30 | as above, its decay rounded towards zero | saturates |
//! | ε between samples | Q2.62 | as above | the model is restarted at the servo's position |
//! | velocity q̇, q̇_e, increments, acceleration per sample | Q2.30, filters and q̇_e Q2.62 | `ranges.velocity`, twice bounds.b u, sixteen times bounds of c and d, eight counts | the servo's saturate; the model is restarted |
//! | ε̇ | Q2.30, filter Q2.62 | twice the velocity's | – |
//! | y = μ ε + ε̇ | Q2.30 | four times that of ε̇, twice μ times the error's | – |
//! | command that acted, u | Q2.30 | `ranges.command`, twice the limit | limited to half |
//! | k_p ε + k_d ε̇ of the correction u_ε | Q2.30 | the command's | limited to half |
//! | k_i ω of the correction | Q2.30 | the command's | ω stops at half |
//! | command of the model, u + u_ε | Q2.30 | the command's | saturates |
//! | terms of PID and correction before the limit | Q2.30 | twice what any of them can be | – |
//! | sums of errors z, ω | Q2.62 | what commands half of the command's | stop there |
//! | estimate â T | Q2.62, acting with 32 fraction bits | one quarter | the projection keeps it inside |
//! | estimates b̂, ĉ, d̂ | Q2.62, acting as Q2.30 | b: velocity over command; c, d: velocity | the projection keeps them inside |
//! | regressor: u_e, −q̇_e, −sign | Q2.30 | as the signal | – |
//! | Γφ | Q2.30 | twice Γᵢᵢ times the regressor's; so that Γφ y has the estimate's last bits | – |
//! | φᵀΓφ | Q2.30 | sixteen times the largest Γᵢᵢφᵢ² | – |
//!
//! **Why nothing wraps.** A word is from −1 to just below 1 and has one guard bit. So the sum and the difference of any
//! two fit, and the sum of three halves. Inputs (position error, increments, commands) saturate and integrals stop at
//! their limits. A model that leaves its ranges is restarted. So every word is below one between samples.
//!
//! Within a sample the full scales leave a margin. The three terms of the PID are at most one half each. The model's
//! command has three parts: the command that acted, k_p ε + k_d ε̇ and k_i ω. Each is at most one half, and the sum
//! saturates to one. The estimate b̂ is at most one half of its full scale, so b̂ u_e is too. Both d̂ and ĉ are at most
//! a sixteenth, and the damping â T q̇_e is at most a quarter. So an acceleration is below seven eighths. With it a
//! velocity is below two, also if â is negative. The rate ε̇ is the filtered *half* of the difference of two increments.
//!
//! A factor of the configuration is below one half of the value that its scales make one. So its product never needs a
//! shift up. The step of an estimate needs one if Γ is large: y is raised before it is multiplied. Where a shift up
//! would overflow, 64 bits are raised and saturate. The property tests drive all of this with arbitrary inputs, for any
//! servo, with every sum checked.
//!
//! **Where it differs from real numbers**: only where something saturates. A u_ε beyond the command's full scale is cut off.
//! So a narrow command range slows the correction of a model that is far from the servo. An estimate b̂ without a given
//! bound is kept below four times the parameter range.
//!
//! **Why it is fast.** Each factor is one `SMMULR`, or `SMMLAR` with the sum it is added to. Each slow sum, and each
//! filter, is one `SMLAL`. Its high half is a word, so reading it costs nothing. A limit to ±1 is one `SSAT`. A shift by
//! a distance from the configuration acts on 32 bits: upwards it is a `MUL`, downwards a factor.
//!
//! **Rejected settings**, each with a number that would pass:
//!
//! An error range that leaves less than a sixteenth of a count. Bounds of a beyond a quarter of the sample rate. A
//! cut-off beyond 0.693 of the sample rate. A velocity range so far below the error's that ε would not fit 64 bits. A
//! command range below the limit. A sample time at which an error adds nothing to an integral. A μ that vanishes.
//!
//! A Γ that moves an estimate by more than its sum can hold. A Γ so small that less than ten bits of Γφ are left (four
//! for friction and load). A Γ whose φᵀΓφ at full scale is so large that the guard's bound would be lost in it.
//!
//! Bounds from which a full scale follows must be given. The bound of b is such if there is no parameter range. Those
//! of Coulomb friction and load are such if the model has them.
//!
//! Gauss–Newton stays in floating point. A covariance spans the square of the signals' range, from 10⁻¹² to 1 within a
//! second. A word would need its own exponent per entry and sample, and that is a floating-point number.

mod word;

use fixed::types::I16F16;

use crate::control::{Setpoint, Unshaped};
use crate::{AB, GradientLoop, GradientLoopState};

pub use word::Word;

/// The PID with a gradient identifier of P unknowns: [`AB`] or [`AB_COULOMB`](crate::AB_COULOMB).
pub type FixedLoop<const P: usize = AB, S = Unshaped> = GradientLoop<Word, P, S>;

/// The state of a [`FixedLoop`].
pub type FixedLoopState<const P: usize = AB, H = ()> = GradientLoopState<Word, P, H>;

impl Setpoint<I16F16> {
    /// Converts a setpoint in counts to fixed point, to the nearest 2⁻¹⁶. It consists of whole counts, which wrap at 32
    /// bits, and a fraction of a count from 0 to 1. Zero for a value that is no number, or infinite.
    #[must_use]
    pub fn from_counts(counts: f64) -> Self {
        const FRACTION: i32 = I16F16::FRAC_NBITS as i32;
        let bits = libm::rint(libm::ldexp(counts, FRACTION));
        if !bits.is_finite() {
            return Self {
                count: 0,
                offset: I16F16::ZERO,
            };
        }
        // All of it is exact: the wrap is a power of two.
        let wrap = libm::ldexp(1.0, FRACTION + 32);
        let wrapped = (bits - wrap * libm::floor(bits / wrap)) as i64;
        let part = wrapped & ((1 << FRACTION) - 1);
        Self {
            count: (wrapped >> FRACTION) as i32,
            offset: I16F16::from_bits(part as i32),
        }
    }
}
