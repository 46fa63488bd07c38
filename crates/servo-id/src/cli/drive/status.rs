//! A drive's state, estimates and settings in words.

use std::path::PathBuf;

use drive_link::{Estimates, InterruptCycles, Settings, Snapshot, Status, TermSizes};
use identifier_core::parameters::Parameter;
use identifier_core::reason::Reason;

use crate::SIDES;
use crate::cli::fault::Fault;
use crate::cli::files::{self, Files};
use crate::cli::standard_output::show;
use crate::drive::{Client, DriveStatus, tables_of};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Write state, gains, estimates and changes of the servo as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace what this program did not write, too.
    #[arg(long)]
    force: bool,
}

impl Arguments {
    pub(super) fn run(&self, client: &mut Client, status: &Status) -> Result<(), Fault> {
        let mut files = Files::reading(&[], self.force);
        let json = files.output(self.json.as_deref())?;
        let settings = client.settings()?;
        let result = DriveStatus::from(status);
        files::commit([json.map(|json| json.document(&result))])?;
        if files.own_standard_output() {
            return Ok(());
        }
        print(status, &settings)
    }
}

/// A snapshot on one line.
pub(super) fn snapshot_line(snapshot: &Snapshot) -> String {
    format!(
        "sample {}: reference {:.4}, position {:.4} rad, command {:.3}; {}",
        snapshot.sample,
        snapshot.reference,
        snapshot.position,
        snapshot.command,
        estimates_line(&snapshot.estimates)
    )
}

/// Estimates with their standard errors on one line.
pub(super) fn estimates_line(estimates: &Estimates) -> String {
    let line = |parameter: Parameter| {
        let (digits, unit) = match parameter {
            Parameter::A => (4, "1/s"),
            Parameter::B => (3, "rad/s²/u"),
            Parameter::Coulomb | Parameter::Load => (3, "rad/s²"),
        };
        let error = match estimates.standard_errors {
            _ if estimates.at_bounds.get(parameter) => " (at a bound)".to_owned(),
            Some(errors) => format!(" ± {:.digits$}", SIDES * errors.get(parameter)),
            None => String::new(),
        };
        let (name, value) = (parameter.name(), estimates.servo.get(parameter));
        format!("{name} {value:.digits$}{error} {unit}")
    };
    let mut line = Parameter::ALL.map(line).join(", ");
    for (unknown, size, error) in estimates.terms.iter().flat_map(TermSizes::entered) {
        let (name, unit) = (unknown.name(), unknown.unit());
        let error = error.map_or_else(String::new, |error| {
            format!(" ± {:.2e}", SIDES * f64::from(error))
        });
        line += &format!(", {name} {size:.4e}{error} {unit}");
    }
    line
}

/// Why there is no first fit, on one line.
pub(super) fn no_first_fit(rejection_reason: Reason) -> String {
    format!(
        "no first fit: {}; {}",
        rejection_reason.cause(),
        rejection_reason.remedy()
    )
}

/// The change of the servo, on one line.
pub(super) fn change_line(status: &Status) -> Option<String> {
    status.servo_change.map(|change| change.to_string())
}

/// In place of cycles.
pub(super) const NOT_MEASURED: &str = "not measured: the chip has no cycle counter that runs";

/// The cycles of the sample interrupt.
pub(super) fn interrupt_line(status: &Status) -> String {
    status.interrupt_cycles.map_or_else(
        || NOT_MEASURED.to_owned(),
        |InterruptCycles { last, longest }| {
            format!("{last} cycles the last, {longest} the longest since the start")
        },
    )
}

/// Prints state, estimates, history and settings.
fn print(status: &Status, settings: &Settings) -> Result<(), Fault> {
    show!("{}", status.state)?;
    if status.simulated {
        show!("simulated: the drive computes its servo, and no motor is driven")?;
    }
    match &status.estimates {
        Some(estimates) => show!("estimates: {}", estimates_line(estimates))?,
        None => show!("the servo is not identified yet")?,
    }
    if let Some(rejection_reason) = &status.rejection_reason {
        show!("{}", no_first_fit(*rejection_reason))?;
    }
    if let Some(noise) = status.noise {
        show!("encoder noise {noise:.2} counts in motion (0.29: quantisation only)")?;
    }
    if let Some(line) = change_line(status) {
        show!("{line}")?;
    }
    show!("{}", status.home)?;
    if let Some(distance) = status.index_from_edge {
        let eighth = std::f64::consts::FRAC_PI_4;
        show!(
            "the index pulse is {distance:.4} rad from the home switch's edge ({eighth:.4} at least)"
        )?;
    }
    if !status.configured {
        show!("not configured: it does not start; the settings below are an example")?;
    }
    if let Some(ended) = &status.ended {
        show!("{ended}")?;
    }
    if let Some(gains) = &status.gains {
        show!("gains: {gains}")?;
    }
    if let Some(commissioning) = &status.commissioning {
        show!("commissioning: {commissioning}")?;
    }
    let noticed = &status.noticed;
    show!(
        "first fits {}, load steps {}, samples not followed {}, friction lowered {}, model restarted {}",
        noticed.started,
        noticed.load_steps,
        noticed.not_following,
        noticed.friction_lowered,
        noticed.restarted
    )?;
    show!("{}", status.kept)?;
    show!(
        "late samples {}, samples not reported {}, frames not understood {}, line errors {}",
        status.overruns,
        status.dropped,
        status.garbled,
        status.disturbed
    )?;
    show!("sample interrupt: {}", interrupt_line(status))?;
    if !status.boot.resets_in_time {
        show!(
            "the chip's brown-out reset is too low: set it in the option bytes, level 3 of an STM32F4 (BOR_LEV = 0), \
             level 1 or more of an STM32G4 (BOR_LEV = 1 to 4)"
        )?;
    }
    if !status.boot.image_checked {
        show!(
            "the program in its flash has no checksum and was not checked: flash an image made by `cargo xtask image`"
        )?;
    }
    show!(
        "{:.1} µs from the reading of the encoder to the change of the output",
        1e6 * status.command_delay
    )?;
    let core = &settings.closed_loop.core;
    show!(
        "sample time {} s, a count is {} rad; its loop where a scenario's defaults do not hold:",
        core.sample_time,
        core.resolution
    )?;
    show!("{}", tables_of(&settings.closed_loop))?;
    show!("{settings}")
}
