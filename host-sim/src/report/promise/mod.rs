//! The picture of a promise.

mod picture;

pub use picture::figures;
