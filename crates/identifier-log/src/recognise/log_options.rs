//! The user's statements about a log, as options.

use crate::scenario::{
    Column, CommandUnit, InnerLoop, Integrator, LogSettings, LogUnits, PhysicalSettings,
    PositionUnit, TimeUnit, in_order,
};

/// The user's statements about a log. Each option is the key of `[log]`, `[encoder]`, `[inner]` or `[physical]` of its
/// name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LogOptions {
    /// Column of the time, by name or number from 1; `none` if the rows are the samples.
    pub time: Option<String>,
    /// Unit of the time: s, ms, us, ns, samples or iso-8601.
    pub time_unit: Option<TimeUnit>,
    /// Time from one sample to the next, s.
    pub sample_time: Option<f64>,
    /// Column of the measured position.
    pub position: Option<String>,
    /// Unit of the position: rad, deg, turns, counts, m, mm, or own if it is not known.
    pub position_unit: Option<PositionUnit>,
    /// Position units for one of the column's; below 0 for the other direction.
    pub position_scale: Option<f64>,
    /// Period after which the position begins again, in its unit; 0 if it does not.
    pub wrap: Option<f64>,
    /// Encoder counts per revolution, after ×4 quadrature.
    pub counts_per_rev: Option<f64>,
    /// Column of the command that acted.
    pub command: Option<String>,
    /// Command units for one of the column's; below 0 for the other direction.
    pub command_scale: Option<f64>,
    /// Unit of the command. V gives the feed-forward kS, kV, kA and kG. Nm, or N on a linear axis, gives inertia and
    /// friction. The others are A and other.
    pub command_unit: Option<CommandUnit>,
    /// Torque of a unit of command at the joint, N·m (N on a linear axis). With it the result has inertia and friction.
    pub torque_constant: Option<f64>,
    /// Column of a known torque that acts on the joint beside the command, N·m (N on a linear axis).
    pub known_torque: Option<String>,
    /// Inertia of all that moves about the joint, kg·m² (kg), where that is known instead.
    pub inertia: Option<f64>,
    /// Column of the position goal, not the command, of a servo that closes its own loop.
    pub goal: Option<String>,
    /// Proportional gain of the servo's own loop, command units per rad. Without it b is that of a rad of distance from
    /// the goal.
    pub kp: Option<f64>,
    /// Its derivative gain, command units per rad/s.
    pub kd: Option<f64>,
    /// The largest command that it gives, command units.
    pub limit: Option<f64>,
    /// Its own sample time, or a simulator's step, s; that of the log by default.
    pub loop_time: Option<f64>,
    /// How its command becomes motion: none for a drive, euler or implicit for a simulator's.
    pub integrator: Option<Integrator>,
    /// Cut-off of the low-pass derivative that is its velocity, rad/s.
    pub cutoff: Option<f64>,
    /// Column of the measured velocity that it acts on.
    pub velocity: Option<String>,
    /// Column of the reference; `none` to leave it aside.
    pub reference: Option<String>,
    /// Unit of the reference; that of the position by default.
    pub reference_unit: Option<PositionUnit>,
    /// Reference units for one of the column's.
    pub reference_scale: Option<f64>,
    /// The most missing samples in a row that straight lines bridge.
    pub bridge_gaps: Option<u32>,
    /// A range of the log's time that is left out, s, FROM:TO. May be repeated.
    pub cut: Vec<[f64; 2]>,
}

impl LogOptions {
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
