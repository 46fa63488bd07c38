use core::fmt;

use commissioning::CommissionError;
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::settings::{GainError, SettingsError};
use serde::{Deserialize, Serialize};

use crate::guidance::{Homing, TargetSource};

/// The name of a setting.
pub type Name = heapless::String<32>;

/// Settings of a drive, SI.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Controller and identifier.
    pub closed_loop: LoopSettings,
    /// The dither on the reference during identification. The reference then has no filter, which would remove the
    /// dither from the command.
    pub dither: Dither,
    /// Limits beyond which the servo is disabled.
    pub protection: Protection,
    /// The way to the home position; none for an axis without one.
    pub homing: Option<Homing>,
    /// Where the targets of a run come from.
    pub source: TargetSource,
    /// Whether changes of a commissioned servo are looked for in a run.
    pub servo_changes: ServoChanges,
    /// The holding brake of the axis; none for an axis without one.
    pub brake: Option<HoldingBrake>,
}

impl Settings {
    /// Those of a drive that is not configured yet: for a loop, with a small dither and the protections of a bare motor.
    #[must_use]
    pub fn example(closed_loop: LoopSettings) -> Self {
        Self {
            closed_loop,
            dither: Dither {
                amplitude: 0.3,
                hold: 0.05,
            },
            protection: Protection::OF_A_BARE_MOTOR,
            homing: None,
            source: TargetSource::Line,
            servo_changes: ServoChanges::Ignored,
            brake: None,
        }
    }
}

/// A holding brake at an output of its own, which needs power to open. The loop holds the axis while it opens or closes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HoldingBrake {
    /// The longest that it takes to open, s, at most [`HoldingBrake::MAX_TIME`].
    pub opens: f64,
    /// The longest that it takes to close, s, at most [`HoldingBrake::MAX_TIME`].
    pub closes: f64,
}

impl HoldingBrake {
    /// The longest time in which a brake may open or close, s.
    pub const MAX_TIME: f64 = 1.0;
}

impl fmt::Display for HoldingBrake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { opens, closes } = self;
        write!(
            f,
            "a holding brake opens within {opens} s and closes within {closes} s"
        )
    }
}

/// Whether a run looks for changes of the servo for which a commissioning found the gains in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ServoChanges {
    /// It does not.
    #[default]
    Ignored,
    /// The status has the change, once it is certain; for Gauss–Newton without terms. It changes nothing else.
    Reported,
}

/// Settings of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LoopSettings {
    /// Controller and identifier, as the core takes them.
    pub core: identifier_core::Settings,
    /// The estimator.
    pub law: Estimator,
}

/// An estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Estimator {
    /// The paper's gradient estimator.
    Gradient {
        /// True to estimate Coulomb friction too.
        friction: bool,
    },
    /// Recursive Gauss–Newton over a, b, Coulomb friction and load, which needs no initial estimates.
    GaussNewton,
}

/// The pseudo-random binary signal that is added to the reference, so that there is something to
/// identify from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dither {
    /// Half the distance between its two levels, rad; 0 for none.
    pub amplitude: f64,
    /// Time between two decisions, s.
    pub hold: f64,
}

/// Limits that end a run and disable the servo, checked in every sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Protection {
    /// Largest position error, rad; at least three amplitudes of the dither, and at most the whole travel.
    pub following_error: f64,
    /// Lowest and highest position, rad from the origin: home, or where the servo started. It is sent no further than
    /// two amplitudes of the dither less.
    pub travel: [f64; 2],
    /// Speed at which it is sent to a target, rad/s.
    pub pace: f64,
    /// Largest speed, rad/s, averaged over 5 ms.
    pub speed: f64,
    /// The change of the command that friction and a hand on the shaft cannot withstand, as a part of its limit. A
    /// change that is larger, or as large as the dither asks for, must move the servo.
    pub breakaway: f64,
    /// The time for which such a command may act without moving the servo, s.
    pub stall_time: f64,
    /// Samples in a row that end too late and disable the servo.
    pub overruns: u8,
    /// The longest run, s; 0 for unbounded.
    pub duration: f64,
    /// The time for which the host may be silent while the servo is driven, s; 0 for unbounded.
    pub link_timeout: f64,
    /// The longest time in which a run may come to rest at its end, s. Then the servo is disabled, at rest or not.
    pub stop_time: f64,
}

impl Protection {
    /// For a bare motor: the built-in protection of a drive that is not configured yet.
    pub const OF_A_BARE_MOTOR: Self = Self {
        following_error: 1.5,
        travel: [-6.9, 6.9],
        pace: 6.3,
        speed: 100.0,
        breakaway: 0.3,
        stall_time: 0.1,
        overruns: 3,
        duration: 0.0,
        link_timeout: 1.0,
        stop_time: 0.5,
    };
}

/// All but the loop, whose settings are the keys of a scenario.
impl fmt::Display for Settings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            closed_loop: _,
            dither,
            protection,
            homing,
            source,
            servo_changes,
            brake,
        } = self;
        writeln!(
            f,
            "dither of {} rad, every {} s",
            dither.amplitude, dither.hold
        )?;
        writeln!(f, "{protection}")?;
        if let Some(homing) = homing {
            writeln!(f, "{homing}")?;
        }
        if let Some(brake) = brake {
            writeln!(f, "{brake}")?;
        }
        match servo_changes {
            ServoChanges::Ignored => {}
            ServoChanges::Reported => {
                writeln!(f, "changes of the commissioned servo are reported")?
            }
        }
        source.fmt(f)
    }
}

impl fmt::Display for Protection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            following_error,
            travel: [low, high],
            pace,
            speed,
            breakaway,
            stall_time,
            overruns,
            duration,
            link_timeout,
            stop_time,
        } = self;
        writeln!(
            f,
            "moves to a target at {pace} rad/s; disabled beyond {following_error} rad of following error, {low} to \
             {high} rad, {speed} rad/s,"
        )?;
        writeln!(
            f,
            "after {stall_time} s without motion although the command changed by {breakaway} of its limit, after {overruns} late \
             samples"
        )?;
        f.write_str("a run ")?;
        match (*duration > 0.0, *link_timeout > 0.0) {
            (true, true) => write!(
                f,
                "ends after {duration} s, or when the line is silent for {link_timeout} s"
            ),
            (true, false) => write!(
                f,
                "ends after {duration} s, and continues when the line is silent"
            ),
            (false, true) => write!(f, "ends when the line is silent for {link_timeout} s"),
            (false, false) => f.write_str("has no end, and continues when the line is silent"),
        }?;
        write!(f, "; it stops within {stop_time} s")
    }
}

/// A setting that is not allowed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NotAllowed {
    /// The setting.
    pub name: Name,
    /// The reason, and the allowed range.
    pub why: Why,
}

/// Reasons for refusing a setting, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Why {
    /// It is out of its range.
    OutOfRange {
        /// The given value.
        given: f64,
        /// The range.
        allowed: Allowed,
    },
    /// It contradicts another setting.
    TooSmallFor {
        /// The given value.
        given: f64,
        /// The smallest allowed value.
        least: f64,
        /// The other setting.
        other: Name,
    },
    /// With it the sampled loop is unstable for some servo of the parameter range.
    Unstable {
        /// The given value.
        given: f64,
    },
    /// It was not given, and none follows from the other settings.
    NoGamma(GainError),
    /// It has no default, and was not given.
    NotGiven,
    /// This firmware does not have it.
    NotHere,
    /// The travel does not contain the place where a run starts.
    WithoutStart {
        /// The given ends, rad.
        given: [f64; 2],
    },
    /// An order asks for more than the settings of the drive allow.
    BeyondDrive {
        /// The given range.
        given: [f64; 2],
        /// The drive's.
        allowed: [f64; 2],
    },
    /// This build of the firmware does not have it.
    NotBuilt,
}

impl NotAllowed {
    /// For a setting, by its name.
    #[must_use]
    pub fn new(name: &str, why: Why) -> Self {
        Self {
            name: Name::try_from(name).unwrap_or_default(),
            why,
        }
    }

    /// For a setting that is too small for another.
    #[must_use]
    pub fn too_small(name: &str, given: f64, least: f64, other: &str) -> Self {
        let other = Name::try_from(other).unwrap_or_default();
        let why = Why::TooSmallFor {
            given,
            least,
            other,
        };
        Self::new(name, why)
    }
}

impl From<OutOfRange> for NotAllowed {
    fn from(error: OutOfRange) -> Self {
        let (given, allowed) = (error.value, error.allowed);
        Self::new(error.parameter, Why::OutOfRange { given, allowed })
    }
}

impl From<SettingsError> for NotAllowed {
    fn from(error: SettingsError) -> Self {
        match error {
            SettingsError::Range(error) => error.into(),
            SettingsError::Certificate(error) => error.out_of_range().into(),
            SettingsError::SampledLoop(error) => {
                let given = error.sample_time;
                Self::new("sample_time", Why::Unstable { given })
            }
            SettingsError::Estimate(error) => error.out_of_range().into(),
            SettingsError::NotGiven { setting } => Self::new(setting, Why::NotGiven),
            SettingsError::NoGamma(error) => Self::new("gamma", Why::NoGamma(error)),
            SettingsError::NoSuchTerm { term } => Self::new(term.name(), Why::NotHere),
            SettingsError::NoAmplifier { setting } | SettingsError::NotShaped { setting } => {
                Self::new(setting, Why::NotHere)
            }
        }
    }
}

impl From<CommissionError> for NotAllowed {
    fn from(error: CommissionError) -> Self {
        let counts = "encoder's counts";
        let (parameter, value, most) = match error {
            CommissionError::Range(error) => return error.into(),
            CommissionError::TravelTooSmall { travel, needed } => {
                return Self::too_small("travel", travel, needed, counts);
            }
            CommissionError::SpeedTooSmall { speed, needed } => {
                return Self::too_small("speed", speed, needed, counts);
            }
            CommissionError::TooStrong {
                sample_time, most, ..
            } => ("sample_time", sample_time, most),
            CommissionError::TooFast { bandwidth, most } => ("bandwidth", bandwidth, most),
        };
        OutOfRange::new(parameter, value, Allowed::PositiveUpTo(most)).into()
    }
}

impl fmt::Display for NotAllowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, why } = self;
        match why {
            Why::OutOfRange { given, allowed } => OutOfRange::new(name, *given, *allowed).fmt(f),
            Why::TooSmallFor {
                given,
                least,
                other,
            } => write!(
                f,
                "{name} = {given} is too small for the {other}: it must be at least {least:.5}"
            ),
            Why::Unstable { given } => write!(
                f,
                "with {name} = {given} the sampled loop is unstable for a servo of the parameter range: sample \
                 faster, raise the cut-off, lower the gains, or narrow the parameter range"
            ),
            Why::NoGamma(error) => error.fmt(f),
            Why::NotGiven => write!(f, "{name} is required here"),
            Why::NotHere => write!(f, "this firmware has no such {name}"),
            Why::NotBuilt => write!(
                f,
                "the drive is a small build without {name}: flash one with the feature {name}"
            ),
            Why::WithoutStart { given: [low, high] } => write!(
                f,
                "{name} from {low} to {high} does not contain 0, where a run starts: give a lower end of at most 0 \
                 and an upper end of at least 0"
            ),
            Why::BeyondDrive {
                given: [low, high],
                allowed: [least, most],
            } => write!(
                f,
                "{name} from {low} to {high} is beyond the drive's own from {least:.5} to {most:.5}: order less, or \
                 configure the drive for more"
            ),
        }
    }
}

impl core::error::Error for NotAllowed {}
