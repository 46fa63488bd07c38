//! A commissioning as CSV and as a picture.

mod picture;
mod rows;

pub use picture::{Traces, figures};
pub use rows::RowWriter;
