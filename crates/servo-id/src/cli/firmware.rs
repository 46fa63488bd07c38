use std::path::{Path, PathBuf};

use host_sim::scenario::{Purpose, Scenario};
use identifier_log::result::KeptResult;
use identifier_log::tune::IdentifiedResult;

use super::fault::Fault;
use super::kept_result;
use crate::export::{Firmware, Language};
use crate::program;

/// Options of an export for a firmware.
#[derive(Debug, clap::Args)]
pub(super) struct FirmwareOptions {
    /// Export the loop of the scenario instead of a joint, as constants for a firmware in this language.
    #[arg(long, value_enum, value_name = "LANGUAGE", conflicts_with_all = ["format", "link_inertia", "limit", "bare", "resistance"])]
    pub(super) firmware: Option<Language>,
    /// The scenario of the firmware: controller, identifier, encoder; that of the result by default.
    #[arg(long, value_name = "SCENARIO.toml")]
    pub(super) scenario: Option<PathBuf>,
}

impl FirmwareOptions {
    /// The sources for a language, with arrays that are named so in C.
    pub(super) fn source(
        &self,
        language: Language,
        result: &Path,
        name: &str,
        accept_unconverged: bool,
    ) -> Result<String, Fault> {
        let of_result = |fault: &dyn std::fmt::Display| Fault::of_file(result, fault);
        let kept = kept_result::read(result)?;
        let identified = IdentifiedResult::new(&kept).map_err(|error| of_result(&error))?;
        if let Some(reservation) = identified
            .reservation
            .as_ref()
            .filter(|_| !accept_unconverged)
        {
            return Err(of_result(&format!(
                "{reservation}: a loop would start at a guess; correct that first, or state --accept-unconverged"
            )));
        }
        let is_name = |name: &str| {
            let mut letters = name.chars();
            let first = letters
                .next()
                .is_some_and(|first| first.is_ascii_alphabetic());
            first && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
        };
        if !is_name(name) {
            return Err(Fault::Input(format!(
                "--joint {name} is not allowed: the firmware's arrays get this name, so it must have ASCII letters, \
                 digits and _ only, and begin with a letter"
            )));
        }
        let (scenario, place) = self.scenario(&kept, &of_result)?;
        let built = Firmware::new(scenario, &identified, language);
        let built = built.map_err(|fault| Fault::Input(format!("{place}: {fault}")))?;
        let origin = format!(
            "Written by {} {} from {}, {place}. {}.",
            program::NAME,
            program::VERSION,
            result.display(),
            identified
                .reservation
                .as_deref()
                .unwrap_or("The result has converged")
        );
        Ok(built.source(name, &origin))
    }

    /// The scenario of the firmware, and where it stands.
    fn scenario(
        &self,
        result: &KeptResult,
        of_result: &dyn Fn(&dyn std::fmt::Display) -> Fault,
    ) -> Result<(Scenario, String), Fault> {
        if let Some(path) = &self.scenario {
            let scenario = Scenario::load(path, Purpose::Replay)?;
            return Ok((scenario, format!("scenario {}", path.display())));
        }
        let origin = result.origin.as_ref().ok_or_else(|| {
            of_result(
                &"it has no provenance: state the firmware's scenario, --scenario FIRMWARE.toml",
            )
        })?;
        Ok((Scenario::of_origin(origin)?, origin.scenario.file.clone()))
    }
}
