use std::path::{Path, PathBuf};

use clap::Args;
use drive_link::{Homing, Refusal, ServoChanges, Settings, TargetSource};
use host_sim::scenario::{ExcitationKind, Purpose, Scenario, key_of_loop};

use crate::cli::fault::Fault;
use crate::drive::{Client, DriveError, holding_brake, loop_settings};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The scenario: controller, amplifier, encoder and identifier. The excitation `prbs` becomes the dither,
    /// `none` disables it; any other is refused.
    scenario: PathBuf,
    /// Largest position error, rad: at least three amplitudes of the dither.
    #[arg(long, value_name = "RAD")]
    following_error: Option<f64>,
    /// Lowest and highest position, rad from home or from where the servo started, or one distance either way: at least
    /// two amplitudes of the dither.
    #[arg(long, value_name = "LOW,HIGH", value_parser = travel, allow_hyphen_values = true)]
    travel: Option<[f64; 2]>,
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
    /// Longest time to reach standstill at the end of a run, s.
    #[arg(long, value_name = "S")]
    stop_time: Option<f64>,
    /// Velocity of the search for the home switch, rad/s, negative for one at the lower end; 0 for an axis without a
    /// home position.
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    home_seek: Option<f64>,
    /// Speed at which the home switch is left and approached, rad/s; a tenth of --home-seek if it was never given.
    #[arg(long, value_name = "RAD/S")]
    home_approach: Option<f64>,
    /// Distance within which the home switch must open when the axis moves off it, rad; half a radian if it was never
    /// given.
    #[arg(long, value_name = "RAD")]
    home_clearance: Option<f64>,
    /// The home position: where the switch closes, or the first index pulse of the encoder after it.
    #[arg(long, value_name = "PLACE")]
    home_at: Option<HomeAt>,
    /// The origin of targets and travel, rad from the home position.
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    home_offset: Option<f64>,
    /// The axis has no holding brake any more; a brake is stated by amplifier.brake in the scenario.
    #[arg(long)]
    no_brake: bool,
    /// Source of targets: line, or steps:RAD (each step moves the target by RAD).
    #[arg(long, value_name = "SOURCE", value_parser = source)]
    source: Option<TargetSource>,
    /// Changes of the servo after its commissioning, found by the Gauss-Newton estimator in a run: ignore, or report in
    /// the status.
    #[arg(long, value_name = "WHAT", value_parser = servo_changes)]
    servo_changes: Option<ServoChanges>,
}

/// The home position of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum HomeAt {
    /// Where the home switch closes.
    Switch,
    /// The first index pulse behind the home switch.
    Index,
}

impl Arguments {
    pub(super) fn run(&self, client: &mut Client) -> Result<(), Fault> {
        let settings = self.settings(client.settings()?)?;
        client.configure(settings).map_err(refused)
    }

    /// The drive's settings with the scenario and the options applied.
    fn settings(&self, now: Settings) -> Result<Settings, Fault> {
        let scenario = Scenario::load(&self.scenario, Purpose::Run)?;
        let mut settings = with_scenario(&self.scenario, &scenario, now)?;
        settings.brake = settings.brake.filter(|_| !self.no_brake);
        let protection = &mut settings.protection;
        for (place, given) in [
            (&mut protection.following_error, self.following_error),
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
        protection.travel = self.travel.unwrap_or(protection.travel);
        settings.homing = self.homing(settings.homing)?;
        settings.source = self.source.unwrap_or(settings.source);
        settings.servo_changes = self.servo_changes.unwrap_or(settings.servo_changes);
        Ok(settings)
    }

    /// The drive's way home with the options applied.
    fn homing(&self, now: Option<Homing>) -> Result<Option<Homing>, Fault> {
        const APPROACH_SHARE: f64 = 0.1;
        const CLEARANCE: f64 = 0.5;
        let begun = |seek: f64| Homing {
            seek,
            approach: APPROACH_SHARE * seek.abs(),
            clearance: CLEARANCE,
            index: false,
            offset: 0.0,
        };
        let mut homing = match (self.home_seek, now) {
            (Some(0.0), _) => return Ok(None),
            (Some(seek), Some(now)) => Homing { seek, ..now },
            (Some(seek), None) => begun(seek),
            (None, Some(now)) => now,
            (None, None) => {
                let is_given = self.home_approach.is_some()
                    || self.home_clearance.is_some()
                    || self.home_at.is_some()
                    || self.home_offset.is_some();
                if is_given {
                    return Err(Fault::Input(
                        "homing is not configured: state --home-seek".to_owned(),
                    ));
                }
                return Ok(None);
            }
        };
        for (place, given) in [
            (&mut homing.approach, self.home_approach),
            (&mut homing.clearance, self.home_clearance),
            (&mut homing.offset, self.home_offset),
        ] {
            *place = given.unwrap_or(*place);
        }
        if let Some(at) = self.home_at {
            homing.index = at == HomeAt::Index;
        }
        Ok(Some(homing))
    }
}

/// Both ends of a travel, or the distance of both.
fn travel(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| {
        text.trim()
            .parse::<f64>()
            .map_err(|error| error.to_string())
    };
    match text.split_once(',') {
        Some((low, high)) => Ok([number(low)?, number(high)?]),
        None => number(text).map(|distance| [-distance, distance]),
    }
}

/// A refusal, with the option or the key of the scenario that changes the setting.
fn refused(error: DriveError) -> Fault {
    let place = match &error {
        DriveError::Refused(Refusal::Setting(refused)) => place_of(refused.name.as_str()),
        _ => None,
    };
    match place {
        Some(place) => Fault::Input(format!("{error}; {place} states it")),
        None => error.into(),
    }
}

/// The option or the key that states a setting, by its name on the line.
fn place_of(setting: &str) -> Option<String> {
    let options = Arguments::augment_args(clap::Command::new("configure"));
    let mut options = options.get_arguments();
    if options.any(|option| option.get_id() == setting) {
        return Some(format!("--{}", setting.replace('_', "-")));
    }
    let key = match setting {
        "brake.opens" | "brake.closes" => format!("amplifier.{setting}"),
        _ => key_of_loop(setting)?,
    };
    Some(format!("{key} in the scenario"))
}

fn servo_changes(text: &str) -> Result<ServoChanges, String> {
    match text {
        "ignore" => Ok(ServoChanges::Ignored),
        "report" => Ok(ServoChanges::Reported),
        "follow" => {
            Err("gains are no longer adapted: state report, and commission the servo again".into())
        }
        _ => Err("it must be ignore or report".into()),
    }
}

fn source(text: &str) -> Result<TargetSource, String> {
    let wrong = || "it must be line or steps:RAD, such as steps:0.001".to_owned();
    let number = |text: &str| text.parse::<f64>().map_err(|_| wrong());
    match text.split_once(':') {
        None if text == "line" => Ok(TargetSource::Line),
        Some(("steps", step)) => Ok(TargetSource::Steps {
            step: number(step)?,
        }),
        Some(("voltage", _)) => {
            Err("the drive has no analogue input any more: use its step input, steps:RAD".into())
        }
        _ => Err(wrong()),
    }
}

/// A drive's settings with the loop and the dither of a scenario, which was read from a file.
pub(super) fn with_scenario(
    file: &Path,
    scenario: &Scenario,
    now: Settings,
) -> Result<Settings, Fault> {
    let closed_loop = loop_settings(scenario).map_err(|error| Fault::of_file(file, error))?;
    let mut settings = Settings {
        closed_loop,
        brake: holding_brake(scenario).or(now.brake),
        ..now
    };
    let (excitation, dither) = (&scenario.excitation, &mut settings.dither);
    match excitation.kind {
        ExcitationKind::Prbs => {
            dither.amplitude = excitation.amplitude;
            dither.hold = excitation.hold;
        }
        ExcitationKind::None => dither.amplitude = 0.0,
        _ => {
            let fault = "excitation.kind: the drive has \"prbs\" and \"none\"";
            return Err(Fault::of_file(file, fault));
        }
    }
    Ok(settings)
}
