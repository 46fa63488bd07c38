//! The drive without its pins, on a simulated servo.

mod any_input;
mod brake;
mod commission;
mod commission_beside;
mod commission_course;
mod day;
mod first_fit;
mod first_motion;
mod homing;
mod line;
mod operation;
mod outside;
mod refusals;
mod safety;
mod servo_changes;
mod store;
mod storms;
mod support;
mod watch_in_run;
