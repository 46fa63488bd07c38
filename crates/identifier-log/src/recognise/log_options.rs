//! The user's statements about a log, as options.

use crate::scenario::{
    Column, CommandUnit, InnerLoop, Integrator, LogSettings, LogUnits, PhysicalSettings,
    PositionUnit, TimeUnit, in_order,
};

/// The user's statements about a log. Each option is the key of `[log]`, `[encoder]`, `[inner]` or `[physical]` of its
/// name.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(
    feature = "clap",
    derive(clap::Args),
    command(allow_negative_numbers = true)
)]
pub struct LogOptions {
    /// Column of the time, by name or number from 1; `none` if the rows are the samples.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub time: Option<String>,
    /// Unit of the time: s, ms, us, ns, samples or iso-8601.
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub time_unit: Option<TimeUnit>,
    /// Time from one sample to the next, s.
    #[cfg_attr(feature = "clap", arg(long, value_name = "S"))]
    pub sample_time: Option<f64>,
    /// Column of the measured position.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub position: Option<String>,
    /// Unit of the position: rad, deg, turns, counts, m, mm, or own if it is not known.
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub position_unit: Option<PositionUnit>,
    /// Position units per unit of the column; below 0 for the other direction.
    #[cfg_attr(feature = "clap", arg(long, value_name = "FACTOR"))]
    pub position_scale: Option<f64>,
    /// Period after which the position wraps, in its unit; 0 if it does not wrap.
    #[cfg_attr(feature = "clap", arg(long, value_name = "PERIOD"))]
    pub wrap: Option<f64>,
    /// Encoder counts per revolution, after ×4 quadrature.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub counts_per_rev: Option<f64>,
    /// Column of the command that acted.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub command: Option<String>,
    /// Command units per unit of the column; below 0 for the other direction.
    #[cfg_attr(feature = "clap", arg(long, value_name = "FACTOR"))]
    pub command_scale: Option<f64>,
    /// Unit of the command: V gives the feed-forward kS, kV, kA and kG; Nm, or N on a linear axis, gives inertia
    /// and friction; A or other.
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub command_unit: Option<CommandUnit>,
    /// Torque per command unit at the joint, N·m (N on a linear axis); gives inertia and friction.
    #[cfg_attr(feature = "clap", arg(long, value_name = "K"))]
    pub torque_constant: Option<f64>,
    /// Column of a known torque that acts on the joint beside the command, N·m (N on a linear axis), positive if it moves
    /// the position up, such as gravity by a model.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub known_torque: Option<String>,
    /// Total inertia about the joint, kg·m² (kg), if that is known instead.
    #[cfg_attr(feature = "clap", arg(long, value_name = "J"))]
    pub inertia: Option<f64>,
    /// Column of the position goal of a servo that closes its own loop, instead of a command.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN", conflicts_with_all = ["command", "reference"]))]
    pub goal: Option<String>,
    /// Proportional gain of the servo's own loop, command units per rad; without it b includes that gain.
    #[cfg_attr(feature = "clap", arg(long, value_name = "K", requires = "goal"))]
    pub kp: Option<f64>,
    /// Its derivative gain, command units per rad/s.
    #[cfg_attr(feature = "clap", arg(long, value_name = "K", requires = "goal"))]
    pub kd: Option<f64>,
    /// Limit of its command, command units.
    #[cfg_attr(feature = "clap", arg(long, value_name = "U", requires = "goal"))]
    pub limit: Option<f64>,
    /// Its own sample time, or a simulator's step, s; that of the log by default.
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", requires = "goal"))]
    pub loop_time: Option<f64>,
    /// How its command becomes motion: none for a drive, euler or implicit for a simulator's.
    #[cfg_attr(feature = "clap", arg(long, value_name = "KIND", requires = "goal"))]
    pub integrator: Option<Integrator>,
    /// Cut-off of the low-pass derivative that is its velocity, rad/s.
    #[cfg_attr(feature = "clap", arg(long, value_name = "W", requires = "goal"))]
    pub cutoff: Option<f64>,
    /// Column of the measured velocity: that on which a servo's own loop acts, or without a position what the log measures.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub velocity: Option<String>,
    /// Column of the reference; `none` to ignore it.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub reference: Option<String>,
    /// Unit of the reference; that of the position by default.
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub reference_unit: Option<PositionUnit>,
    /// Reference units per unit of the column.
    #[cfg_attr(feature = "clap", arg(long, value_name = "FACTOR"))]
    pub reference_scale: Option<f64>,
    /// Largest number of missing samples in a row that are interpolated linearly.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub bridge_gaps: Option<u32>,
    /// A range of the log's time that is left out, s, FROM:TO. May be repeated.
    #[cfg_attr(feature = "clap", arg(long, value_name = "FROM:TO", value_parser = range, allow_hyphen_values = true))]
    pub cut: Vec<[f64; 2]>,
}

impl LogOptions {
    /// True if a velocity is stated as what was measured.
    pub(super) fn measures_velocity(&self) -> bool {
        self.velocity.is_some() && self.position.is_none() && self.goal.is_none()
    }

    /// The stated settings of a log with this column of the position. The other columns and the units of time and
    /// position are not among them.
    pub(super) fn settings(&self, position: Column) -> LogSettings {
        LogSettings {
            bridge: self.bridge_gaps.unwrap_or(0),
            sample_time: self.sample_time,
            cut: in_order(&self.cut),
            wrap: self.wrap,
            units: LogUnits {
                position_scale: self.position_scale.unwrap_or(1.0),
                reference_scale: self.reference_scale.unwrap_or(1.0),
                command_scale: self.command_scale.unwrap_or(1.0),
                counts_per_rev: self.counts_per_rev,
                ..LogUnits::SI
            },
            ..LogSettings::with_position(position)
        }
    }

    /// The scale of torques and the unit of the command, which may be `found` with the column.
    pub(super) fn physical(&self, found: Option<CommandUnit>) -> PhysicalSettings {
        PhysicalSettings {
            command_unit: self.command_unit.or(found).unwrap_or(CommandUnit::Other),
            torque_constant: self.torque_constant,
            inertia: self.inertia,
            ..PhysicalSettings::NONE
        }
    }

    /// The servo's own position loop. With an unknown gain the command is the distance from the goal.
    pub(super) fn inner(&self) -> InnerLoop {
        InnerLoop {
            kd: self.kd.unwrap_or(0.0),
            limit: self
                .limit
                .map_or([f64::NEG_INFINITY, f64::INFINITY], |limit| [-limit, limit]),
            sample_time: self.loop_time,
            cutoff: self.cutoff,
            integrator: self.integrator.unwrap_or(Integrator::None),
            ..InnerLoop::proportional(self.kp.unwrap_or(1.0))
        }
    }

    /// Takes the value of an option by its name, as the answer to a question is one.
    ///
    /// # Errors
    /// The allowed values.
    pub fn answer(&mut self, flag: &str, answer: &str) -> Result<(), String> {
        let number = || {
            let number = answer.parse().ok().filter(|number| f64::is_finite(*number));
            number.ok_or_else(|| "a number, such as 0.05 or 5e-2".to_owned())
        };
        match flag {
            "time" => self.time = Some(answer.to_owned()),
            "position" => self.position = Some(answer.to_owned()),
            "command" => self.command = Some(answer.to_owned()),
            "reference" => self.reference = Some(answer.to_owned()),
            "goal" => self.goal = Some(answer.to_owned()),
            "velocity" => self.velocity = Some(answer.to_owned()),
            "kp" => self.kp = Some(number()?),
            "kd" => self.kd = Some(number()?),
            "limit" => self.limit = Some(number()?),
            "loop-time" => self.loop_time = Some(number()?),
            "cutoff" => self.cutoff = Some(number()?),
            "integrator" => self.integrator = Some(answer.parse()?),
            "time-unit" => self.time_unit = Some(answer.parse()?),
            "position-unit" => self.position_unit = Some(answer.parse()?),
            "reference-unit" => self.reference_unit = Some(answer.parse()?),
            "command-unit" => self.command_unit = Some(answer.parse()?),
            "torque-constant" => self.torque_constant = Some(number()?),
            "known-torque" => self.known_torque = Some(answer.to_owned()),
            "inertia" => self.inertia = Some(number()?),
            "position-scale" => self.position_scale = Some(number()?),
            "command-scale" => self.command_scale = Some(number()?),
            "reference-scale" => self.reference_scale = Some(number()?),
            "sample-time" => self.sample_time = Some(number()?),
            "counts-per-rev" => self.counts_per_rev = Some(number()?),
            "wrap" => self.wrap = Some(number()?),
            _ => return Err(format!("--{flag} is not an option with one value")),
        }
        Ok(())
    }
}

/// A range of time of an option.
#[cfg(feature = "clap")]
fn range(words: &str) -> Result<[f64; 2], String> {
    let range = words.split_once(':').and_then(|(from, to)| {
        let ends = [from.parse::<f64>().ok()?, to.parse::<f64>().ok()?];
        (ends[0].is_finite() && ends[0] < ends[1] && ends[1].is_finite()).then_some(ends)
    });
    range.ok_or_else(|| "it must be two times in s, the earlier first, such as 1.5:2".to_owned())
}
