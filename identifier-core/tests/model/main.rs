//! The model loop in discrete time.

mod discretisation;
