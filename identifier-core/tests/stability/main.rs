//! The certificate and the verdicts on the sampled loop, against runs and dense searches.

mod certificate;
mod dense_search;
mod sampled_loop;
