//! How results are shown: tables, JSON, CSV and pictures.

pub mod commission;
pub mod comparison;
pub mod csv;
pub mod distribution;
pub mod drift;
pub mod promise;
