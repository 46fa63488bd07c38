//! The user's statements about a log, as options.

use super::Question;
use crate::scenario::{
    Column, CommandUnit, InnerLoop, Integrator, LogSettings, LogUnits, PhysicalSettings,
    PositionUnit, Scan, TimeUnit,
};

/// The user's statements about a log: each option is the key of `[log]`, `[encoder]`, `[inner]` or `[physical]` of its name.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "program", derive(clap::Args))]
pub struct Stated {
    /// Column of the time, by name or number from 1; `none` if the rows are the samples.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN"))]
    pub time: Option<String>,
    /// Unit of the time: s, ms, us, ns, samples or iso-8601.
    #[cfg_attr(feature = "program", arg(long, value_name = "UNIT", value_parser = time_unit))]
    pub time_unit: Option<TimeUnit>,
    /// Time from one sample to the next, s.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "S", allow_negative_numbers = true)
    )]
    pub sample_time: Option<f64>,
    /// Column of the measured position.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN"))]
    pub position: Option<String>,
    /// Unit of the position: rad, deg, turns, counts, m or mm.
    #[cfg_attr(feature = "program", arg(long, value_name = "UNIT", value_parser = position_unit))]
    pub position_unit: Option<PositionUnit>,
    /// Position units for one of the column's; below 0 for the other direction.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "FACTOR", allow_negative_numbers = true)
    )]
    pub position_scale: Option<f64>,
    /// Period after which the position begins again, in its unit; 0 if it does not.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "PERIOD", allow_negative_numbers = true)
    )]
    pub wrap: Option<f64>,
    /// Counts of the encoder for a revolution, after fourfold evaluation.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "N", allow_negative_numbers = true)
    )]
    pub counts_per_rev: Option<f64>,
    /// Column of the command that acted.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN"))]
    pub command: Option<String>,
    /// Command units for one of the column's; below 0 for the other direction.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "FACTOR", allow_negative_numbers = true)
    )]
    pub command_scale: Option<f64>,
    /// Unit of the command: V for the feed-forward kS, kV, kA and kG, Nm, or N on a linear axis, for inertia and friction;
    /// A or other.
    #[cfg_attr(feature = "program", arg(long, value_name = "UNIT", value_parser = command_unit))]
    pub command_unit: Option<CommandUnit>,
    /// Torque of a unit of command at the joint, N·m (N on a linear axis): the result has inertia and friction.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "K", allow_negative_numbers = true)
    )]
    pub torque_constant: Option<f64>,
    /// Inertia of all that moves about the joint, kg·m² (kg), where that is known instead.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "J", allow_negative_numbers = true)
    )]
    pub inertia: Option<f64>,
    /// Column of the position goal of a servo that closes its own loop, in place of a command: it needs --kp.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN", conflicts_with_all = ["command", "reference"]))]
    pub goal: Option<String>,
    /// Proportional gain of the servo's own loop, command units per rad.
    #[cfg_attr(feature = "program", arg(long, value_name = "K", requires = "goal"))]
    pub kp: Option<f64>,
    /// Its derivative gain, command units per rad/s.
    #[cfg_attr(feature = "program", arg(long, value_name = "K", requires = "goal"))]
    pub kd: Option<f64>,
    /// The largest command that it gives, command units.
    #[cfg_attr(feature = "program", arg(long, value_name = "U", requires = "goal"))]
    pub limit: Option<f64>,
    /// Its own sample time, or a simulator's step, s; that of the log by default.
    #[cfg_attr(feature = "program", arg(long, value_name = "S", requires = "goal"))]
    pub loop_time: Option<f64>,
    /// How its command becomes motion: none for a drive, euler or implicit for a simulator's.
    #[cfg_attr(feature = "program", arg(long, value_name = "KIND", requires = "goal", value_parser = integrator))]
    pub integrator: Option<Integrator>,
    /// Cut-off of the low-pass derivative that is its velocity, rad/s.
    #[cfg_attr(feature = "program", arg(long, value_name = "W", requires = "goal"))]
    pub cutoff: Option<f64>,
    /// Column of the measured velocity that it acts on.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "COLUMN", requires = "goal")
    )]
    pub velocity: Option<String>,
    /// Column of the reference; `none` to leave it aside.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN"))]
    pub reference: Option<String>,
    /// Unit of the reference; that of the position by default.
    #[cfg_attr(feature = "program", arg(long, value_name = "UNIT", value_parser = position_unit))]
    pub reference_unit: Option<PositionUnit>,
    /// Reference units for one of the column's.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "FACTOR", allow_negative_numbers = true)
    )]
    pub reference_scale: Option<f64>,
    /// The most missing samples in a row that straight lines bridge.
    #[cfg_attr(feature = "program", arg(long, value_name = "N"))]
    pub bridge_gaps: Option<u32>,
    /// A range of the log's time that is left out, s, FROM:TO. May be repeated.
    #[cfg_attr(feature = "program", arg(long, value_name = "FROM:TO", value_parser = range, allow_hyphen_values = true))]
    pub cut: Vec<[f64; 2]>,
    /// What follows where the scan of the log finds a contradiction: refuse or warn.
    #[cfg_attr(feature = "program", arg(long, value_name = "refuse|warn", value_parser = scan))]
    pub scan: Option<Scan>,
}

impl Stated {
    /// The settings of a log with this column of the position, as far as they are stated; the other columns and the
    /// units of time and position are not among them.
    pub(super) fn settings(&self, position: Column) -> LogSettings {
        let mut cut = self.cut.clone();
        cut.sort_by(|one, other| one[0].total_cmp(&other[0]));
        LogSettings {
            bridge: self.bridge_gaps.unwrap_or(0),
            sample_time: self.sample_time,
            cut,
            wrap: self.wrap,
            scan: self.scan.unwrap_or(Scan::Refuse),
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

    /// The servo's own position loop.
    ///
    /// # Errors
    /// The gain that is missing.
    pub(super) fn inner(&self) -> Result<Option<InnerLoop>, Question> {
        match (&self.goal, self.kp) {
            (None, _) => Ok(None),
            (Some(_), Some(kp)) => Ok(Some(InnerLoop {
                kd: self.kd.unwrap_or(0.0),
                limit: self
                    .limit
                    .map_or([f64::NEG_INFINITY, f64::INFINITY], |limit| [-limit, limit]),
                sample_time: self.loop_time,
                cutoff: self.cutoff,
                integrator: self.integrator.unwrap_or(Integrator::None),
                ..InnerLoop::proportional(kp)
            })),
            (Some(goal), None) => Err(Question {
                flag: "kp",
                text: format!(
                    "{goal} is the goal of the servo's own loop: state its proportional gain, command units per rad"
                ),
            }),
        }
    }

    /// Takes the value of an option by its name, as the answer to a question is one.
    ///
    /// # Errors
    /// The allowed values.
    pub fn answer(&mut self, flag: &str, answer: &str) -> Result<(), String> {
        let number = || {
            let number = answer.parse().ok().filter(|number| f64::is_finite(*number));
            number.ok_or_else(|| "a number, as 0.05 or 5e-2".to_owned())
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
            "integrator" => self.integrator = Some(integrator(answer)?),
            "time-unit" => self.time_unit = Some(time_unit(answer)?),
            "position-unit" => self.position_unit = Some(position_unit(answer)?),
            "reference-unit" => self.reference_unit = Some(position_unit(answer)?),
            "command-unit" => self.command_unit = Some(command_unit(answer)?),
            "torque-constant" => self.torque_constant = Some(number()?),
            "inertia" => self.inertia = Some(number()?),
            "position-scale" => self.position_scale = Some(number()?),
            "command-scale" => self.command_scale = Some(number()?),
            "reference-scale" => self.reference_scale = Some(number()?),
            "sample-time" => self.sample_time = Some(number()?),
            "counts-per-rev" => self.counts_per_rev = Some(number()?),
            "wrap" => self.wrap = Some(number()?),
            "scan" => self.scan = Some(scan(answer)?),
            _ => return Err(format!("--{flag} is no option that takes one value")),
        }
        Ok(())
    }
}

/// One of some values by its name.
fn named<T: Copy>(all: &[T], name: fn(T) -> &'static str, word: &str) -> Result<T, String> {
    let found = all.iter().copied().find(|of| name(*of) == word);
    found.ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|of| name(*of)).collect();
        format!("one of {}", names.join(", "))
    })
}

fn time_unit(word: &str) -> Result<TimeUnit, String> {
    named(TimeUnit::ALL, TimeUnit::name, word)
}

fn position_unit(word: &str) -> Result<PositionUnit, String> {
    named(PositionUnit::ALL, PositionUnit::name, word)
}

fn command_unit(word: &str) -> Result<CommandUnit, String> {
    named(CommandUnit::ALL, CommandUnit::name, word)
}

fn integrator(word: &str) -> Result<Integrator, String> {
    named(Integrator::ALL, Integrator::name, word)
}

fn scan(word: &str) -> Result<Scan, String> {
    named(Scan::ALL, Scan::name, word)
}

fn range(words: &str) -> Result<[f64; 2], String> {
    let range = words.split_once(':').and_then(|(from, to)| {
        let ends = [from.parse::<f64>().ok()?, to.parse::<f64>().ok()?];
        (ends[0].is_finite() && ends[0] < ends[1] && ends[1].is_finite()).then_some(ends)
    });
    range.ok_or_else(|| "two times in s, the earlier first, as 1.5:2".to_owned())
}
