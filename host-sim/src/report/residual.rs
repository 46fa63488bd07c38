//! What the output error says of the model, in words.

use std::fmt;

use crate::analysis::{Finding, Residual};

/// The output error against what the encoder allows, and what explains the rest.
#[derive(Debug, Clone, Copy)]
pub struct Words<'a> {
    /// The output error over the end of the run.
    pub residual: &'a Residual,
    /// What stands out, if something does.
    pub cause: Option<&'a Finding>,
}

impl fmt::Display for Words<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let residual = self.residual;
        write!(
            f,
            "residual: output error {:.3e} rms, {:.1} times what the encoder's resolution leaves, \
             correlation from sample to sample {:.2}",
            residual.rms,
            residual.rms / residual.resolution_rms,
            residual.correlation
        )?;
        if residual.is_the_encoders() {
            return write!(f, ": the model explains all that the encoder shows");
        }
        match self.cause {
            Some(finding) => write!(
                f,
                "\n  {} ({:.3e} {}) explains {:.0} % of the rest: {}",
                finding.cause,
                finding.size,
                finding.unit,
                100.0 * finding.share,
                finding.cause.remedy()
            ),
            None if !residual.is_large() => write!(
                f,
                "\n  it is no larger than the encoder's; nothing stands out"
            ),
            None if residual.is_coloured() => {
                write!(f, "\n  the model lacks something; nothing stands out")
            }
            None => write!(
                f,
                "\n  it is white, as noise of the sensor is; nothing stands out"
            ),
        }
    }
}
