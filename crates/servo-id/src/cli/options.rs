//! The library's inputs as options of the same names.

use host_sim::scenario::{CommandUnit, Integrator, PositionUnit, TimeUnit};
use identifier_log::recognise::LogOptions;
use identifier_log::tune::{Conditions, Form};

/// Declares the options that the fields of a type are.
macro_rules! options {
    ($(#[$doc:meta])* $name:ident of $type:ident { $($(#[$meta:meta])* $field:ident: $value:ty,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, clap::Args)]
        pub(super) struct $name {
            $($(#[$meta])* $field: $value,)*
        }

        impl From<$name> for $type {
            fn from(options: $name) -> Self {
                Self { $($field: options.$field,)* }
            }
        }
    };
}

options! {
    /// The user's statements about a log.
    StatedOptions of LogOptions {
        /// Column of the time, by name or number from 1; `none` if the rows are the samples.
        #[arg(long, value_name = "COLUMN")]
        time: Option<String>,
        /// Unit of the time: s, ms, us, ns, samples or iso-8601.
        #[arg(long, value_name = "UNIT")]
        time_unit: Option<TimeUnit>,
        /// Time from one sample to the next, s.
        #[arg(long, value_name = "S", allow_negative_numbers = true)]
        sample_time: Option<f64>,
        /// Column of the measured position.
        #[arg(long, value_name = "COLUMN")]
        position: Option<String>,
        /// Unit of the position: rad, deg, turns, counts, m, mm, or own if it is not known.
        #[arg(long, value_name = "UNIT")]
        position_unit: Option<PositionUnit>,
        /// Position units per unit of the column; below 0 for the other direction.
        #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
        position_scale: Option<f64>,
        /// Period after which the position wraps, in its unit; 0 if it does not wrap.
        #[arg(long, value_name = "PERIOD", allow_negative_numbers = true)]
        wrap: Option<f64>,
        /// Encoder counts per revolution, after ×4 quadrature.
        #[arg(long, value_name = "N", allow_negative_numbers = true)]
        counts_per_rev: Option<f64>,
        /// Column of the command that acted.
        #[arg(long, value_name = "COLUMN")]
        command: Option<String>,
        /// Command units per unit of the column; below 0 for the other direction.
        #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
        command_scale: Option<f64>,
        /// Unit of the command: V gives the feed-forward kS, kV, kA and kG; Nm, or N on a linear axis, gives inertia
        /// and friction; A or other.
        #[arg(long, value_name = "UNIT")]
        command_unit: Option<CommandUnit>,
        /// Torque per command unit at the joint, N·m (N on a linear axis); gives inertia and friction.
        #[arg(long, value_name = "K", allow_negative_numbers = true)]
        torque_constant: Option<f64>,
        /// Column of a known torque that acts on the joint beside the command, N·m (N on a linear axis), positive if it moves
        /// the position up, such as gravity by a model.
        #[arg(long, value_name = "COLUMN")]
        known_torque: Option<String>,
        /// Total inertia about the joint, kg·m² (kg), if that is known instead.
        #[arg(long, value_name = "J", allow_negative_numbers = true)]
        inertia: Option<f64>,
        /// Column of the position goal of a servo that closes its own loop, instead of a command.
        #[arg(long, value_name = "COLUMN", conflicts_with_all = ["command", "reference"])]
        goal: Option<String>,
        /// Proportional gain of the servo's own loop, command units per rad; without it b includes that gain.
        #[arg(long, value_name = "K", requires = "goal")]
        kp: Option<f64>,
        /// Its derivative gain, command units per rad/s.
        #[arg(long, value_name = "K", requires = "goal")]
        kd: Option<f64>,
        /// Limit of its command, command units.
        #[arg(long, value_name = "U", requires = "goal")]
        limit: Option<f64>,
        /// Its own sample time, or a simulator's step, s; that of the log by default.
        #[arg(long, value_name = "S", requires = "goal")]
        loop_time: Option<f64>,
        /// How its command becomes motion: none for a drive, euler or implicit for a simulator's.
        #[arg(long, value_name = "KIND", requires = "goal")]
        integrator: Option<Integrator>,
        /// Cut-off of the low-pass derivative that is its velocity, rad/s.
        #[arg(long, value_name = "W", requires = "goal")]
        cutoff: Option<f64>,
        /// Column of the measured velocity that it acts on.
        #[arg(long, value_name = "COLUMN", requires = "goal")]
        velocity: Option<String>,
        /// Column of the reference; `none` to ignore it.
        #[arg(long, value_name = "COLUMN")]
        reference: Option<String>,
        /// Unit of the reference; that of the position by default.
        #[arg(long, value_name = "UNIT")]
        reference_unit: Option<PositionUnit>,
        /// Reference units per unit of the column.
        #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
        reference_scale: Option<f64>,
        /// Largest number of missing samples in a row that are interpolated linearly.
        #[arg(long, value_name = "N")]
        bridge_gaps: Option<u32>,
        /// A range of the log's time that is left out, s, FROM:TO. May be repeated.
        #[arg(long, value_name = "FROM:TO", value_parser = range, allow_hyphen_values = true)]
        cut: Vec<[f64; 2]>,
    }
}

options! {
    /// The conditions that gains are computed for.
    ConditionOptions of Conditions {
        /// Sample time of the loop, s; the result's by default.
        #[arg(long, value_name = "T", allow_negative_numbers = true)]
        sample_time: Option<f64>,
        /// Counts of the encoder per revolution; 0 for an ideal sensor.
        #[arg(long, value_name = "N", group = "encoder", allow_negative_numbers = true)]
        counts: Option<f64>,
        /// Position of a count, rad (m on a linear axis); 0 for an ideal sensor.
        #[arg(long, value_name = "R", group = "encoder", allow_negative_numbers = true)]
        resolution: Option<f64>,
        /// The largest command, command units; inf for none.
        #[arg(long, value_name = "U", allow_negative_numbers = true)]
        limit: Option<f64>,
        /// Delay from encoder reading to output that was not identified, s; the scenario's, or none, by default.
        #[arg(long, value_name = "S", allow_negative_numbers = true)]
        command_delay: Option<f64>,
        /// Cut-off of the velocity estimate, rad/s; chosen with the gains by default.
        #[arg(long, value_name = "W", allow_negative_numbers = true)]
        cutoff: Option<f64>,
        /// Largest sensitivity Ms; 1.6 by default.
        #[arg(long, value_name = "M", allow_negative_numbers = true)]
        max_sensitivity: Option<f64>,
        /// Largest noise of the command due to encoder noise, as a fraction of the limit; 0.03 by default.
        #[arg(long, value_name = "PART", allow_negative_numbers = true)]
        max_noise: Option<f64>,
        /// Lowest known resonance, rad/s.
        #[arg(long, value_name = "W", allow_negative_numbers = true)]
        resonance: Option<f64>,
        /// Step of the predicted response, rad; 0.1 by default, at least 10 counts.
        #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
        step: Option<f64>,
        /// Add a reference model with feed-forward if the step then rises faster.
        #[arg(long, conflicts_with = "response_time")]
        feed_forward: bool,
        /// Print the gains in the form of a drive's firmware: pid, cascade, simplefoc, odrive, moteus, vesc, dynamixel,
        /// wpilib, sparkmax, linuxcnc or cia402.
        #[arg(long = "for", value_name = "FORM", conflicts_with = "feed_forward")]
        form: Option<Form>,
        /// Torque per command unit, N·m, for a form that takes a torque; the result's by default.
        #[arg(long, value_name = "K", requires = "form", allow_negative_numbers = true)]
        torque_constant: Option<f64>,
        /// Supply voltage, V, for a form whose command is a share of it.
        #[arg(long, value_name = "V", requires = "form", allow_negative_numbers = true)]
        bus_voltage: Option<f64>,
        /// The largest current, A, for a form whose command is a share of it.
        #[arg(long, value_name = "A", requires = "form", allow_negative_numbers = true)]
        max_current: Option<f64>,
    }
}

fn range(words: &str) -> Result<[f64; 2], String> {
    let range = words.split_once(':').and_then(|(from, to)| {
        let ends = [from.parse::<f64>().ok()?, to.parse::<f64>().ok()?];
        (ends[0].is_finite() && ends[0] < ends[1] && ends[1].is_finite()).then_some(ends)
    });
    range.ok_or_else(|| "it must be two times in s, the earlier first, such as 1.5:2".to_owned())
}
