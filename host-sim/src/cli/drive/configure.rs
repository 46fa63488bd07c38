use std::path::{Path, PathBuf};

use drive_link::{Command, Settings};

use super::fault;
use crate::cli::fault::Fault;
use crate::drive::{Client, loop_settings};
use crate::scenario::{ExcitationKind, Purpose, Scenario};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario: controller, amplifier, encoder and identifier. The excitation `prbs` becomes the dither,
    /// `none` disables it; any other is refused.
    scenario: PathBuf,
    /// Largest position error, rad: at least three amplitudes of the dither.
    #[arg(long, value_name = "RAD")]
    following_error: Option<f64>,
    /// Largest distance from where the servo started, rad: at least two amplitudes of the dither.
    #[arg(long, value_name = "RAD")]
    travel: Option<f64>,
    /// Speed of a motion to a target, rad/s.
    #[arg(long, value_name = "RAD/S")]
    pace: Option<f64>,
    /// Largest speed, rad/s.
    #[arg(long, value_name = "RAD/S")]
    speed: Option<f64>,
    /// The change of the command that must move the servo, as a fraction of its limit.
    #[arg(long, value_name = "FRACTION")]
    breakaway: Option<f64>,
    /// Longest time that such a command may act without moving the servo, s.
    #[arg(long, value_name = "S", alias = "silence")]
    stall_time: Option<f64>,
    /// Longest run, s; 0 for no limit.
    #[arg(long, value_name = "S")]
    duration: Option<f64>,
    /// Longest silence of the line in a run, s; 0 for no limit.
    #[arg(long, value_name = "S")]
    link_timeout: Option<f64>,
    /// Longest time to come to rest at the end of a run, s.
    #[arg(long, value_name = "S")]
    stop_time: Option<f64>,
}

impl Arguments {
    pub(super) fn run(&self, client: &mut Client) -> Result<(), Fault> {
        let settings = self.settings(client.settings().map_err(fault)?)?;
        client.ask(Command::Configure(settings)).map_err(fault)
    }

    /// The drive's settings with the scenario and the options applied.
    fn settings(&self, now: Settings) -> Result<Settings, Fault> {
        let scenario = Scenario::load(&self.scenario, Purpose::Run)?;
        let mut settings = with_scenario(&self.scenario, &scenario, now)?;
        let protection = &mut settings.protection;
        for (place, given) in [
            (&mut protection.following_error, self.following_error),
            (&mut protection.travel, self.travel),
            (&mut protection.pace, self.pace),
            (&mut protection.speed, self.speed),
            (&mut protection.breakaway, self.breakaway),
            (&mut protection.stall_time, self.stall_time),
            (&mut protection.duration, self.duration),
            (&mut protection.link_timeout, self.link_timeout),
            (&mut protection.stop_time, self.stop_time),
        ] {
            *place = given.unwrap_or(*place);
        }
        Ok(settings)
    }
}

/// A drive's settings with the loop and the dither of a scenario, which was read from a file.
pub(super) fn with_scenario(
    file: &Path,
    scenario: &Scenario,
    now: Settings,
) -> Result<Settings, Fault> {
    let closed_loop = loop_settings(scenario).map_err(|error| Fault::of_scenario(file, error))?;
    let mut settings = Settings { closed_loop, ..now };
    let (excitation, dither) = (&scenario.excitation, &mut settings.dither);
    match excitation.kind {
        ExcitationKind::Prbs => {
            dither.amplitude = excitation.amplitude;
            dither.hold = excitation.hold;
        }
        ExcitationKind::None => dither.amplitude = 0.0,
        _ => {
            let fault = "excitation.kind: the drive has \"prbs\" and \"none\"";
            return Err(Fault::of_scenario(file, fault));
        }
    }
    Ok(settings)
}
