//! Robot models and firmware from results. One is the identified servo in physical units, with a simulator's names. The
//! other is the loop of a scenario as constants that begin at its estimates.
//!
//! result.json → [`Identified`]; with a [`Scale`](identifier_log::physical::Scale) of torques → [`Joint`]; joints in a
//! [`JointFormat`] → text. A result.json with a scenario → [`Firmware`] → sources.

mod bam;
mod firmware;
mod isaac_lab;
mod joint;
mod json;
mod mjcf;
mod urdf;

pub use firmware::{Firmware, Language};
pub use joint::{ExportError, Identified, Joint};

use identifier_log::named;

named! {
    /// A format of joints.
    #[cfg_attr(feature = "program", derive(clap::ValueEnum))]
    pub enum JointFormat {
        /// Default classes of MuJoCo, to include in a model.
        Mjcf = "mjcf",
        /// The elements of a URDF's joints.
        Urdf = "urdf",
        /// Actuators of Isaac Lab.
        IsaacLab = "isaac-lab",
        /// The parameters of an actuator of BAM, model m1.
        Bam = "bam",
        /// Every quantity with its standard error and unit.
        Json = "json",
    }
}

impl JointFormat {
    /// Joints as text.
    ///
    /// # Errors
    /// Several joints for a format of one.
    pub fn of(self, joints: &[Joint]) -> Result<String, ExportError> {
        Ok(match self {
            Self::Mjcf => mjcf::written(joints),
            Self::Urdf => urdf::written(joints),
            Self::IsaacLab => isaac_lab::written(joints),
            Self::Bam => match joints {
                [joint] => bam::written(joint),
                several => return Err(ExportError::Several(several.len())),
            },
            Self::Json => json::written(joints),
        })
    }
}

/// A number with seven digits, which no result knows more of, as all formats read it.
fn number(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}
