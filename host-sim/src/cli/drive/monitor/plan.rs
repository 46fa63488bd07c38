//! What a commissioning may do, from a scenario.

use std::path::{Path, PathBuf};

use drive_link::{Command, Settings, Status};
use identifier_core::commission::{CommissionIsr, CommissionSettings, HoldingGains};

use crate::cli::drive::commission::{gains, unconfigured};
use crate::cli::fault::Fault;
use crate::report::commission as report;
use crate::scenario::{Purpose, Scenario};

/// A commissioning that can be ordered.
#[derive(Debug)]
pub(super) struct Plan {
    file: PathBuf,
    scenario: Scenario,
    order: CommissionSettings,
    gains: Option<HoldingGains>,
}

/// The orders of a commissioning, and how far it moves at most, in words.
#[derive(Debug)]
pub(super) struct Orders {
    /// First, if nobody has told the drive anything yet.
    pub(super) configure: Option<Command>,
    pub(super) commission: Command,
    pub(super) most: String,
}

impl Plan {
    /// The limits of a scenario's [commission].
    pub(super) fn of(file: &Path) -> Result<Self, Fault> {
        let scenario = Scenario::load(file, Purpose::Commission)?;
        let of_scenario = |fault| Fault::of_scenario(file, fault);
        Ok(Self {
            file: file.to_owned(),
            order: scenario.commission_settings().map_err(of_scenario)?,
            gains: scenario.gains_before().map_err(of_scenario)?,
            scenario,
        })
    }

    /// The same for a drive that stands so.
    pub(super) fn for_drive(self, settings: &Settings, status: &Status) -> Result<Orders, Fault> {
        let told = if status.configured {
            *settings
        } else {
            unconfigured(settings, &self.order, self.gains.as_ref())
        };
        let mut planned = self.order;
        planned.command_delay += f64::from(status.command_delay);
        let machine =
            CommissionIsr::<f32>::new(&planned, gains(&told).as_ref()).map_err(|error| {
                Fault::of_scenario(&self.file, self.scenario.fault_of_commission(&error))
            })?;
        Ok(Orders {
            configure: (!status.configured).then_some(Command::Configure(told)),
            commission: Command::Commission(self.order),
            most: report::largest_motion(&machine.largest_motion()),
        })
    }
}
