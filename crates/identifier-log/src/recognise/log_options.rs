//! The user's statements about a log, as options.

use crate::options::options;
use crate::scenario::{
    Column, CommandUnit, InnerLoop, Integrator, LogSettings, LogUnits, PhysicalSettings,
    PositionUnit, TimeUnit, in_order,
};

options! {
    /// The user's statements about a log. Each option is the key of `[log]`, `[encoder]`, `[inner]` or `[physical]` of its
    /// name.
    #[derive(Debug, Clone, PartialEq, Default)]
    pub struct LogOptions {
        /// Column of the time, by name or number from 1; `none` if the rows are the samples.
        time: String = "COLUMN",
        /// Unit of the time: s, ms, us, ns, min, h, samples or iso-8601.
        time_unit: TimeUnit = "UNIT",
        /// Time from one sample to the next, s.
        sample_time: f64 = "S",
        /// Column of the measured position.
        position: String = "COLUMN",
        /// Unit of the position: rad, deg, turns, counts, m, mm, or own if it is not known.
        position_unit: PositionUnit = "UNIT",
        /// Position units per unit of the column; below 0 for the other direction.
        position_scale: f64 = "FACTOR",
        /// Period after which the position wraps, in its unit; 0 if it does not wrap.
        wrap: f64 = "PERIOD",
        /// Encoder counts per revolution, after ×4 quadrature.
        counts_per_rev: f64 = "N",
        /// Column of the command that acted.
        command: String = "COLUMN",
        /// Command units per unit of the column; below 0 for the other direction.
        command_scale: f64 = "FACTOR",
        /// Unit of the command: V gives the feed-forward kS, kV, kA and kG; Nm, or N on a linear axis, gives inertia
        /// and friction; A or other.
        command_unit: CommandUnit = "UNIT",
        /// Torque per command unit at the joint, N·m (N on a linear axis); gives inertia and friction.
        torque_constant: f64 = "K",
        /// Column of a known torque that acts on the joint beside the command, N·m (N on a linear axis), positive if it moves
        /// the position up, such as gravity by a model.
        known_torque: String = "COLUMN",
        /// Total inertia about the joint, kg·m² (kg), if that is known instead.
        inertia: f64 = "J",
        /// Column of the position goal of a servo that closes its own loop, instead of a command.
        goal: String = "COLUMN" { conflicts_with_all = ["command", "reference"] },
        /// Proportional gain of the servo's own loop, command units per rad; without it b includes that gain.
        kp: f64 = "K" { requires = "goal" },
        /// Its derivative gain, command units per rad/s.
        kd: f64 = "K" { requires = "goal" },
        /// Limit of its command, command units.
        limit: f64 = "U" { requires = "goal" },
        /// Its own sample time, or a simulator's step, s; that of the log by default.
        loop_time: f64 = "S" { requires = "goal" },
        /// How its command becomes motion: none for a drive, euler or implicit for a simulator's.
        integrator: Integrator = "KIND" { requires = "goal" },
        /// Cut-off of the low-pass derivative that is its velocity, rad/s.
        cutoff: f64 = "W" { requires = "goal" },
        /// Column of the measured velocity: that on which a servo's own loop acts, or without a position what the log measures.
        velocity: String = "COLUMN",
        /// Column of the reference; `none` to ignore it.
        reference: String = "COLUMN",
        /// Unit of the reference; that of the position by default.
        reference_unit: PositionUnit = "UNIT",
        /// Reference units per unit of the column.
        reference_scale: f64 = "FACTOR",
    }
    more {
        /// Largest number of missing samples in a row that are interpolated linearly.
        #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
        pub bridge_gaps: Option<u32>,
        /// A range of the log's time that is left out, s; there may be several.
        #[cfg_attr(feature = "clap", arg(long, value_name = "FROM:TO", value_parser = range, allow_hyphen_values = true))]
        pub cut: Vec<[f64; 2]>,
    }
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
