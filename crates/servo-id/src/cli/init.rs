use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::fault::Fault;
use super::files::{self, Files};
use super::standard_output::show;
use crate::init::{Chosen, DataSheet, Drive, data_sheet, scenario};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario to write; `-`, the default, is standard output.
    file: Option<PathBuf>,
    /// Quantity of the command: the current of an amplifier with a current loop, or the voltage at the motor.
    #[arg(long, value_enum)]
    drive: Option<Command>,
    /// Torque constant of the motor, N m/A (the back-EMF constant in V s/rad is the same number).
    #[arg(long, value_name = "KT")]
    torque_constant: Option<f64>,
    /// Inertia of the rotor, kg m²; 1 g cm² is 1e-7.
    #[arg(long, value_name = "J")]
    rotor_inertia: Option<f64>,
    /// Inertia of the load behind the gear, kg m²; 0 by default.
    #[arg(long, value_name = "J")]
    load_inertia: Option<f64>,
    /// Motor revolutions per load revolution; 1 by default.
    #[arg(long, value_name = "N")]
    gear: Option<f64>,
    /// Encoder counts per motor revolution, after ×4 quadrature.
    #[arg(long, value_name = "N")]
    counts: Option<f64>,
    /// Largest current, A (driven by current).
    #[arg(long, value_name = "A")]
    peak_current: Option<f64>,
    /// Supply voltage, V (driven by voltage).
    #[arg(long, value_name = "V")]
    voltage: Option<f64>,
    /// Winding resistance, ohm (driven by voltage).
    #[arg(long, value_name = "OHM")]
    resistance: Option<f64>,
    /// Viscous friction, N m s/rad; 0 by default.
    #[arg(long, value_name = "B")]
    viscous: Option<f64>,
    /// Coulomb friction, N m; 0 by default.
    #[arg(long, value_name = "TORQUE")]
    coulomb: Option<f64>,
    /// Sample time of the loop, s; 0.001 by default.
    #[arg(long, value_name = "T")]
    sample_time: Option<f64>,
    /// Replace an existing file.
    #[arg(long)]
    force: bool,
}

/// The quantity of the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Command {
    Current,
    Voltage,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let mut files = Files::reading(&[], arguments.force);
    let file = arguments.file.as_deref().unwrap_or(Path::new("-"));
    let output = files.output(Some(file))?;
    let sheet = arguments.sheet()?;
    let servo = sheet
        .servo()
        .map_err(|error| Fault::Input(error.to_string()))?;
    let text = scenario(&sheet, &servo, &Chosen::for_servo(&sheet, &servo));
    let output = output.map(|mut output| {
        output.bytes(text.as_bytes())?;
        Ok(output)
    });
    files::commit([output])?;
    if !files.own_standard_output() {
        let file = file.display();
        show!("{file} is written: `run {file}` tries it")?;
    }
    Ok(())
}

impl Arguments {
    /// The data sheet.
    #[rustfmt::skip]
    fn sheet(&self) -> Result<DataSheet, Fault> {
        let drive = match (self.drive, self.peak_current, self.voltage) {
            (Some(drive), ..) => drive,
            (None, Some(_), None) => Command::Current,
            (None, None, Some(_)) => Command::Voltage,
            _ => {
                return Err(Fault::Input(
                    "--drive is missing: current (with --peak-current) or voltage (with --voltage and --resistance)"
                        .to_owned(),
                ));
            }
        };
        let drive = match drive {
            Command::Current => Drive::Current {
                peak: number(self.peak_current, "peak-current", "largest current, A", None)?,
            },
            Command::Voltage => Drive::Voltage {
                supply: number(self.voltage, "voltage", "supply voltage, V", None)?,
                resistance: number(self.resistance, "resistance", "winding resistance, ohm", None)?,
            },
        };
        Ok(DataSheet {
            drive,
            torque_constant: number(self.torque_constant, "torque-constant", "torque constant, N m/A", None)?,
            rotor_inertia: number(
                self.rotor_inertia, "rotor-inertia", "inertia of the rotor, kg m² (1 g cm² = 1e-7)", None,
            )?,
            counts: number(
                self.counts, "counts", "encoder counts per motor revolution, after ×4 quadrature", None,
            )?,
            load_inertia: number(
                self.load_inertia, "load-inertia", "inertia of the load at the gear's output, kg m²", Some(0.0),
            )?,
            gear: number(self.gear, "gear", "motor revolutions per load revolution", Some(1.0))?,
            viscous: number(self.viscous, "viscous", "viscous friction, N m s/rad", Some(0.0))?,
            coulomb: number(self.coulomb, "coulomb", "Coulomb friction, N m", Some(0.0))?,
            sample_time: number(self.sample_time, "sample-time", "sample time of the loop, s", Some(1e-3))?,
        })
    }
}

/// The stated number, or the default.
fn number(
    stated: Option<f64>,
    name: &'static str,
    meaning: &str,
    usual: Option<f64>,
) -> Result<f64, Fault> {
    let number = stated.or(usual);
    let number = number.ok_or_else(|| Fault::Input(format!("--{name} is missing: {meaning}")))?;
    data_sheet::check(name, number).map_err(|error| Fault::Input(error.to_string()))?;
    Ok(number)
}
