//! The verdict that a call requires.

use clap::ValueEnum;
use identifier_log::verdict::Status;

use super::fault::Fault;

/// The verdict that a call requires.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct Required {
    /// Required verdict: exit status 3 for another one, with every output written.
    #[arg(long, value_enum, value_name = "VERDICT")]
    require: Option<Verdict>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Verdict {
    /// All estimates are within tolerance and settled.
    Converged,
}

impl Required {
    /// Checks the verdict of a result.
    ///
    /// # Errors
    /// One that is not the required one.
    pub(super) fn check(self, status: Status) -> Result<(), Fault> {
        if self.require.is_none() || status == Status::Converged {
            return Ok(());
        }
        let name = status.name();
        Err(Fault::Unmet(format!(
            "the result is {name}, but --require converged was stated"
        )))
    }
}
