//! Counts and comparisons on the emulated chip, and on a bare board, which counts cycles. Each part is a feature of its
//! name, so that a binary can have one estimator. Code that is linked with a sample changes its compilation.
#![no_std]
#![no_main]

#[cfg(feature = "commission")]
mod commission;
#[cfg(feature = "endings")]
mod endings;
#[cfg(feature = "rivals")]
mod rivals;
#[cfg(feature = "same")]
mod same;
#[cfg(feature = "samples")]
mod samples;
#[cfg(feature = "terms")]
mod terms;
#[cfg(feature = "turns")]
mod turns;

use cortex_m_rt::entry;
use firmware_stm32::host::{exit, print};

#[entry]
fn main() -> ! {
    let done = run();
    if let Err(fault) = done {
        print(&[fault]);
    }
    exit(done.is_ok())
}

/// The parts that were asked for, one after the other.
fn run() -> Result<(), &'static str> {
    #[cfg(feature = "same")]
    same::run()?;
    #[cfg(feature = "samples")]
    samples::run()?;
    #[cfg(feature = "terms")]
    terms::run()?;
    #[cfg(feature = "commission")]
    commission::run()?;
    #[cfg(feature = "turns")]
    turns::run()?;
    #[cfg(feature = "rivals")]
    rivals::run()?;
    #[cfg(feature = "endings")]
    endings::run()?;
    Ok(())
}
