//! Fixed point beside floating point: the same estimates, under any input.
#![cfg(feature = "fixed")]

mod bounded_loop;
mod servo_loop;
