//! Tests across crates: scenarios of the simulator against the project's claims.

mod commission;
mod compare;
mod emps;
mod gains;
mod gauss_newton;
mod number_formats;
mod paper_experiment;
mod random_servos;
mod stop;
mod sweep;
mod verdict;
