//! How results are shown: tables, JSON, CSV and pictures.

mod axes;
pub mod commission;
pub mod comparison;
pub mod csv;
pub mod distribution;
pub mod drift;
mod envelope;
pub mod heat;
mod ink;
pub mod json;
mod legend;
pub mod logs;
pub mod page;
pub mod panels;
pub mod plot;
pub mod promise;
pub mod residual;
mod rows;
mod scale;
pub mod style;
pub mod table;
pub mod terms;
pub mod timeline;

pub use envelope::Envelope;
