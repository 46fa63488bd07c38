//! From a scenario's choices to the core's types. Only here do a number format, a velocity estimate and a set of
//! parameters become types.
//!
//! Each macro calls a function that is generic over the choice. The types in the call come first, the chosen ones
//! follow. `with_velocity!(scenario, N => pid::<N>(settings))` is `pid::<N, LowPass<N>>(settings)` for a scenario with
//! a low-pass.

/// With the number format of a loop. A loop without a form in fixed point is computed in `f64`.
#[cfg(feature = "experiments")]
macro_rules! with_number {
    ($scenario:expr => $function:ident ($($argument:expr),* $(,)?)) => {
        match $scenario.identifier.arithmetic {
            $crate::scenario::Arithmetic::F32 => $function::<f32>($($argument),*),
            $crate::scenario::Arithmetic::F64 | $crate::scenario::Arithmetic::Fixed => {
                $function::<f64>($($argument),*)
            }
        }
    };
}

/// With the parameter set and the number of its parameters.
#[cfg(feature = "experiments")]
#[macro_export]
macro_rules! with_set {
    ($scenario:expr => $function:ident::<$($given:ty),+> ($($argument:expr),* $(,)?)) => {{
        use ::identifier_core::parameters::{Unknowns, AbLoad};
        use $crate::scenario::ModelSet;
        match $scenario.model_set() {
            ModelSet::Ab => $function::<$($given,)+ Unknowns<2>, 2>($($argument),*),
            ModelSet::AbCoulomb => $function::<$($given,)+ Unknowns<3>, 3>($($argument),*),
            ModelSet::AbLoad => $function::<$($given,)+ AbLoad, 3>($($argument),*),
            ModelSet::AbCoulombLoad => $function::<$($given,)+ Unknowns<4>, 4>($($argument),*),
        }
    }};
}

/// With the velocity estimate on a number, the parameter set and the number of its parameters.
#[cfg(feature = "experiments")]
#[macro_export]
macro_rules! with_types {
    ($scenario:expr, $number:ty => $function:ident$(::<$given:ty>)? ($($argument:expr),* $(,)?)) => {{
        use ::identifier_core::measurement as velocity;
        use $crate::{scenario::Velocity, with_set};
        match $scenario.velocity {
            Velocity::LowPass => with_set!(
                $scenario => $function::<$($given,)? velocity::LowPass<$number>>($($argument),*)
            ),
            Velocity::Difference => with_set!(
                $scenario => $function::<$($given,)? velocity::BackwardDifference>($($argument),*)
            ),
            Velocity::AveragedDifference => with_set!(
                $scenario => $function::<$($given,)? velocity::AveragedDifference<$number>>($($argument),*)
            ),
        }
    }};
}

pub(crate) use identifier_log::with_velocity;
#[cfg(feature = "experiments")]
pub(crate) use {with_number, with_set, with_types};
