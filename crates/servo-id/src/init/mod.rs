//! A scenario from the data sheet of a motor.
//!
//! [`DataSheet`] → [`ServoSheet`]: a, b, friction and limit. → [`Chosen`]: gains, parameter range and reference that
//! suit such a servo. → [`scenario`]: the text, in which every number has its derivation beside it.

mod chosen;
pub(crate) mod data_sheet;
mod text;

pub use chosen::Chosen;
pub use data_sheet::{DataSheet, Drive, ServoSheet, SheetError};
pub use text::scenario;
