use std::path::{Path, PathBuf};

use identifier_log::physical::Scale;

use super::fault::Fault;
use super::files::{self, Files};
use super::firmware::FirmwareOptions;
use super::{kept_result, standard_output};
use crate::export::{Identified, Joint, JointFormat, Language};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The results that `run` or `identify` wrote with --json, one joint each.
    #[arg(required = true, value_name = "RESULT.json")]
    results: Vec<PathBuf>,
    /// Format of the joints.
    #[arg(long, value_enum, required_unless_present = "firmware")]
    format: Option<JointFormat>,
    #[command(flatten)]
    firmware: FirmwareOptions,
    /// Names of the joints in the order of the results; the results' names by default, and "servo" in a firmware.
    #[arg(long, value_name = "NAME", num_args = 1)]
    joint: Vec<String>,
    #[command(flatten)]
    scale: Scaling,
    /// Inertia about the joint of the links in the robot's model, kg·m² (kg on a linear axis); once for all, or for
    /// each result.
    #[arg(long, value_name = "J", allow_negative_numbers = true, num_args = 1)]
    link_inertia: Vec<f64>,
    /// The result without the payload.
    #[arg(long, value_name = "RESULT.json", requires = "payload")]
    bare: Option<PathBuf>,
    /// Winding resistance of the motor, Ω, if the command is its voltage: for `bam`.
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    resistance: Option<f64>,
    /// The largest command, command units; that of the result by default.
    #[arg(long, value_name = "U", value_parser = above_zero)]
    limit: Option<f64>,
    /// Export even a result that has not converged.
    #[arg(long)]
    accept_unconverged: bool,
    /// Write to this file; standard output by default.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace what this program did not write, too.
    #[arg(long)]
    force: bool,
}

/// The scale of torques, which a result leaves open unless its scenario has [physical].
#[derive(Debug, clap::Args)]
#[group(multiple = false, conflicts_with = "firmware")]
struct Scaling {
    /// Torque per command unit at the joint, N·m (N on a linear axis): torque constant times gear ratio; once for all,
    /// or for each result.
    #[arg(long, value_name = "K", allow_negative_numbers = true, num_args = 1)]
    torque_constant: Vec<f64>,
    /// Total inertia about the joint, kg·m² (kg on a linear axis), if that is known instead; once for all, or for each
    /// result.
    #[arg(long, value_name = "J", allow_negative_numbers = true, num_args = 1)]
    inertia: Vec<f64>,
    /// Inertia about the joint of a payload that was attached, kg·m² (kg), if neither is known; it needs --bare.
    #[arg(
        long,
        value_name = "J",
        allow_negative_numbers = true,
        requires = "bare"
    )]
    payload: Option<f64>,
    /// Export ratios, for an inertia of 1, if neither is known.
    #[arg(long)]
    ratios: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = arguments.firmware.scenario.as_deref();
    let inputs = arguments.results.iter().chain(&arguments.bare);
    let inputs: Vec<&Path> = inputs.map(PathBuf::as_path).chain(scenario).collect();
    let mut files = Files::reading(&inputs, arguments.force);
    let output = files.output(arguments.output.as_deref())?;
    let text = match (arguments.firmware.firmware, arguments.format) {
        (Some(language), _) => arguments.loop_of_firmware(language)?,
        (None, _) if scenario.is_some() => {
            return Err(Fault::Input(
                "--scenario belongs to --firmware rust and --firmware c: a joint needs none"
                    .to_owned(),
            ));
        }
        (None, Some(format)) => arguments.joints(format)?,
        // Refused as it was read.
        (None, None) => String::new(),
    };
    let Some(mut file) = output else {
        return standard_output::result(format_args!("{}", text.trim_end()));
    };
    file.bytes(text.as_bytes())?;
    files::commit([Some(Ok(file))])?;
    Ok(())
}

impl Arguments {
    /// The loop of the only result.
    fn loop_of_firmware(&self, language: Language) -> Result<String, Fault> {
        let (result, name) = match (&self.results[..], &self.joint[..]) {
            ([result], []) => (result, "servo"),
            ([result], [name]) => (result, name.as_str()),
            _ => {
                return Err(Fault::Input(format!(
                    "a firmware's loop takes one result and at most one --joint, but {} are given: export each by \
                     itself",
                    self.results.len()
                )));
            }
        };
        self.firmware
            .source(language, result, name, self.accept_unconverged)
    }

    /// The joints of all results.
    fn joints(&self, format: JointFormat) -> Result<String, Fault> {
        let joints = (0..self.results.len()).map(|place| self.joint(place));
        let joints = joints.collect::<Result<Vec<_>, _>>()?;
        for (place, joint) in joints.iter().enumerate() {
            let name = joint.name();
            if joints[..place].iter().any(|earlier| earlier.name() == name) {
                return Err(Fault::Input(format!(
                    "two joints are named {name}: state --joint for each result, in their order"
                )));
            }
        }
        (format.of(&joints)).map_err(|error| Fault::Input(error.to_string()))
    }

    /// The joint of the result at a place.
    fn joint(&self, place: usize) -> Result<Joint, Fault> {
        let path = &self.results[place];
        let of_result = |fault: &dyn std::fmt::Display| Fault::of_file(path, fault);
        let identified = read(path, self.limit)?;
        if let Some(reservation) = identified
            .reservation()
            .filter(|_| !self.accept_unconverged)
        {
            return Err(of_result(&format!(
                "{reservation}: its model would be a guess; correct that first, or state --accept-unconverged"
            )));
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let name = self.one_of("joint", &self.joint, place)?;
        let links = self.one_of("link-inertia", &self.link_inertia, place)?;
        let constant = self.one_of("torque-constant", &self.scale.torque_constant, place)?;
        let inertia = self.one_of("inertia", &self.scale.inertia, place)?;
        let scale = match (constant, inertia, self.scale.payload, &self.bare) {
            (Some(&constant), ..) => Scale::TorqueConstant(constant),
            (_, Some(&inertia), ..) => Scale::Inertia(inertia),
            (_, _, Some(inertia), Some(bare)) => Scale::Payload {
                inertia,
                bare: read(bare, None)?.gain(),
            },
            _ if self.scale.ratios => Scale::Ratios,
            _ => identified.scale().ok_or_else(|| {
                of_result(
                    &"position and command do not determine torques: state --torque-constant K (N·m per command \
                      unit), --inertia J (kg·m²), or --payload J with --bare RESULT.json; --ratios exports ratios, \
                      for an inertia of 1",
                )
            })?,
        };
        let joint = identified
            .joint(
                name.map_or(&*stem, String::as_str),
                scale,
                links.copied().unwrap_or(0.0),
            )
            .map_err(|error| of_result(&error))?;
        match self.resistance {
            Some(resistance) => {
                (joint.with_resistance(resistance)).map_err(|error| of_result(&error))
            }
            None => Ok(joint),
        }
    }

    /// The value of an option for the result at a place: the one that is stated for all, or its own.
    fn one_of<'v, T>(
        &self,
        option: &str,
        stated: &'v [T],
        place: usize,
    ) -> Result<Option<&'v T>, Fault> {
        let results = self.results.len();
        match stated {
            [] => Ok(None),
            [one] if option != "joint" => Ok(Some(one)),
            several if several.len() == results => Ok(Some(&several[place])),
            several => Err(Fault::Input(format!(
                "--{option} is stated {} times for {results} results: state it once for each, in their order",
                several.len()
            ))),
        }
    }
}

/// A result in a file.
fn read(path: &Path, limit: Option<f64>) -> Result<Identified, Fault> {
    Identified::new(&kept_result::read(path)?, limit).map_err(|error| Fault::of_file(path, error))
}

fn above_zero(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    let number = number.filter(|number: &f64| *number > 0.0);
    number.ok_or_else(|| "it must be a number above 0".to_owned())
}
