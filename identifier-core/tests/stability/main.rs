//! What the certificate and the verdicts on the sampled loop promise, against runs and dense searches.

mod certificate;
mod dense_search;
mod sampled_loop;
