//! A commissioning that a scenario describes, checked against the drive before it is requested.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use commissioning::{CommissionIsr, CommissionSettings, HoldingGains, LargestMotion};
use drive_link::{Dither, Estimator, LoopSettings, Protection, ServoChanges, Settings, Status};
use host_sim::scenario::{Purpose, Scenario};
use identifier_log::provenance::ScenarioText;

use crate::cli::fault::Fault;
use crate::drive::holding_brake;

/// The commissioning of a scenario.
#[derive(Debug)]
pub(super) struct Plan {
    file: PathBuf,
    pub(super) scenario: Scenario,
    pub(super) order: CommissionSettings,
    gains: Option<HoldingGains>,
}

/// The same for one drive.
#[derive(Debug)]
pub(super) struct DrivePlan {
    /// Settings to configure the drive with first, if it is not configured.
    pub(super) configure: Option<Settings>,
    pub(super) order: CommissionSettings,
    /// The gains that the drive returns to if the commissioning fails.
    pub(super) gains_before: Option<HoldingGains>,
    pub(super) largest_motion: LargestMotion,
    /// From the settings then in force, s; 0 for none.
    pub(super) link_timeout: f64,
}

impl Plan {
    /// # Errors
    /// A scenario that cannot be read, or whose [commission] is refused.
    pub(super) fn read(file: &Path) -> Result<Self, Fault> {
        Self::from_text(&ScenarioText::read(file)?)
    }

    /// # Errors
    /// As [`read`](Self::read).
    pub(super) fn from_text(text: &ScenarioText) -> Result<Self, Fault> {
        let scenario = Scenario::of_text(text, Purpose::Commission)?;
        let file = Path::new(&text.file);
        let of_scenario = |fault| Fault::of_file(file, fault);
        Ok(Self {
            file: file.to_owned(),
            order: scenario.commission_settings().map_err(of_scenario)?,
            gains: scenario.gains_before().map_err(of_scenario)?,
            scenario,
        })
    }

    /// Checks it against a drive with these settings and this status.
    ///
    /// # Errors
    /// Another encoder or sample time than the drive's, or limits that it would refuse.
    pub(super) fn for_drive(
        &self,
        settings: &Settings,
        status: &Status,
    ) -> Result<DrivePlan, Fault> {
        let order = self.order;
        let configure = (!status.configured).then(|| Settings {
            brake: holding_brake(&self.scenario).or(settings.brake),
            ..unconfigured(settings, &order, self.gains.as_ref())
        });
        let settings = configure.as_ref().unwrap_or(settings);
        let core = &settings.closed_loop.core;
        for (key, own, wanted) in [
            (
                "encoder.counts_per_rev",
                TAU / core.resolution,
                TAU / order.resolution,
            ),
            (
                "commission.sample_time",
                core.sample_time,
                order.sample_time,
            ),
        ] {
            if (own / wanted - 1.0).abs() > 1e-9 {
                let text = format!(
                    "{key} is {wanted} here, and {own} in the drive: `drive configure` changes the drive's"
                );
                return Err(Fault::of_file(&self.file, text));
            }
        }
        let gains_before = HoldingGains::of(core);
        let mut planned = order;
        planned.command_delay += f64::from(status.command_delay);
        let machine =
            CommissionIsr::<f32>::new(&planned, gains_before.as_ref()).map_err(|error| {
                Fault::of_file(&self.file, self.scenario.fault_of_commission(&error))
            })?;
        Ok(DrivePlan {
            largest_motion: machine.largest_motion(),
            link_timeout: settings.protection.link_timeout,
            configure,
            order,
            gains_before,
        })
    }
}

/// Settings for a drive that is not configured: encoder and sample time of the commissioning, and its gains, if any.
/// The protections allow as much as the commissioning. The rest is the drive's example.
fn unconfigured(
    example: &Settings,
    order: &CommissionSettings,
    gains: Option<&HoldingGains>,
) -> Settings {
    let [low, high] = order.limits.travel;
    let mut core = identifier_core::Settings {
        resolution: order.resolution,
        ..identifier_core::Settings::new(order.sample_time, 1.0)
    };
    if let Some(gains) = gains {
        core.controller = Some(gains.controller);
        core.cutoff = gains.cutoff;
    }
    Settings {
        closed_loop: LoopSettings {
            core,
            law: Estimator::GaussNewton,
        },
        dither: Dither {
            amplitude: 0.0,
            ..example.dither
        },
        protection: Protection {
            following_error: 0.5 * (high - low),
            travel: order.limits.travel,
            speed: order.limits.speed,
            pace: 0.2 * order.limits.speed,
            ..example.protection
        },
        servo_changes: ServoChanges::Ignored,
        ..*example
    }
}
