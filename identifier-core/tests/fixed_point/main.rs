//! Words beside numbers: the same answers, whatever comes in.
#![cfg(feature = "fixed")]

mod bounded_loop;
mod servo_loop;
