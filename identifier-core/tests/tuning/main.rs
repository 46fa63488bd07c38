//! Gains from identified servos, and their promise.

mod closed_forms;
mod feed_forward;
mod moving_axis;
mod properties;
mod servo_changes;
mod support;
mod two_masses;
