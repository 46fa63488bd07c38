//! From a choice of the velocity estimate to the core's type.

/// With the velocity estimate on a number. The macro calls a function that is generic over the choice; the types in the
/// call come first, the chosen one follows.
#[macro_export]
macro_rules! with_velocity {
    ($scenario:expr, $number:ty => $function:ident$(::<$given:ty>)? ($($argument:expr),* $(,)?)) => {{
        use ::identifier_core::measurement as velocity;
        use $crate::scenario::Velocity;
        match $scenario.velocity {
            Velocity::LowPass => $function::<$($given,)? velocity::LowPass<$number>>($($argument),*),
            Velocity::Difference => {
                $function::<$($given,)? velocity::BackwardDifference>($($argument),*)
            }
            Velocity::AveragedDifference => {
                $function::<$($given,)? velocity::AveragedDifference<$number>>($($argument),*)
            }
        }
    }};
}
