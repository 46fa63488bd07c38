use core::fmt;

use serde::{Deserialize, Serialize};

/// The name of a setting.
pub type Name = heapless::String<24>;

/// What a drive is told of its servo and of what it shall do, SI.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Controller and identifier.
    pub closed_loop: LoopSettings,
    /// Reference while it identifies.
    pub shaking: Shaking,
    /// What lets the servo go.
    pub protection: Protection,
}

/// What controller and identifier are built from, SI.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LoopSettings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Encoder counts a revolution, after fourfold evaluation.
    pub counts_per_rev: f64,
    /// kp, kd, ki: command units per rad, per rad/s, per rad s.
    pub gains: [f64; 3],
    /// Lowest and highest command, command units; infinite for none.
    pub limit: [f64; 2],
    /// Cut-off of the velocity estimate, rad/s.
    pub cutoff: f64,
    /// Lowest and highest a (1/s) and b (rad/s² per command unit) of the servo, to be certified.
    pub plant_box: Option<[[f64; 2]; 2]>,
    /// a, b, c and d to begin with.
    pub initial: [f64; 4],
    /// Lowest and highest estimates of a, b, c and d.
    pub bounds: [[f64; 2]; 4],
    /// Diagonal of Γ over a, b and, with friction, c.
    pub gamma: [f64; 3],
    /// μ, 1/s; none for the automatic one.
    pub mu: Option<f64>,
    /// Whether Coulomb friction is estimated too.
    pub friction: bool,
    /// What the loop is computed in.
    pub format: Format,
}

/// A number format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Format {
    /// Single precision.
    Single,
    /// Fixed point, words of 32 bits.
    Fixed,
}

/// The pseudo-random binary reference that shakes the servo while it is identified.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Shaking {
    /// Half the distance between its two levels, rad; 0 for none.
    pub amplitude: f64,
    /// Time between two decisions, s.
    pub hold: f64,
}

/// What lets the servo go.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Protection {
    /// Largest position error, rad.
    pub following_error: f64,
    /// How far from where it started the servo may be sent, rad.
    pub travel: f64,
    /// How fast it is sent there, rad/s.
    pub speed: f64,
    /// How long the servo may be driven (a command at its limit, or a twentieth of the largest position
    /// error) without moving, s.
    pub silence: f64,
    /// Samples running that may end too late.
    pub overruns: u8,
}

impl fmt::Display for Settings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            closed_loop,
            shaking,
            protection,
        } = self;
        let [kp, kd, ki] = closed_loop.gains;
        let [low, high] = closed_loop.limit;
        writeln!(
            f,
            "sample time {} s, {} counts a revolution, {:?}",
            closed_loop.sample_time, closed_loop.counts_per_rev, closed_loop.format
        )?;
        writeln!(
            f,
            "kp {kp}, kd {kd}, ki {ki}, cut-off {} rad/s, command {low} to {high}",
            closed_loop.cutoff
        )?;
        match closed_loop.plant_box {
            Some([[a_min, a_max], [b_min, b_max]]) => writeln!(
                f,
                "certified for a from {a_min} to {a_max}, b from {b_min} to {b_max}"
            )?,
            None => writeln!(f, "not certified")?,
        }
        let names = ["a", "b", "coulomb", "load"];
        for ((name, initial), [min, max]) in names
            .iter()
            .zip(closed_loop.initial)
            .zip(closed_loop.bounds)
        {
            writeln!(f, "{name} begins with {initial}, within {min} to {max}")?;
        }
        let [of_a, of_b, of_coulomb] = closed_loop.gamma;
        write!(f, "gamma {of_a}, {of_b}")?;
        if closed_loop.friction {
            write!(f, ", {of_coulomb}")?;
        }
        match closed_loop.mu {
            Some(mu) => writeln!(f, ", mu {mu} 1/s")?,
            None => writeln!(f, ", mu automatic")?,
        }
        writeln!(
            f,
            "shaken by {} rad, every {} s",
            shaking.amplitude, shaking.hold
        )?;
        write!(
            f,
            "let go beyond {} rad of error, after {} s of silence, after {} late samples; sent up to \
             {} rad away, at {} rad/s",
            protection.following_error,
            protection.silence,
            protection.overruns,
            protection.travel,
            protection.speed
        )
    }
}

/// A setting that is not allowed, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NotAllowed {
    /// Which.
    pub name: Name,
    /// What was given.
    pub given: f64,
    /// The least that would do; infinite if that end is open, no number if the sampled loop is
    /// unstable and several settings could mend that.
    pub least: f64,
    /// The most that would do; infinite if that end is open.
    pub most: f64,
}

impl fmt::Display for NotAllowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            given,
            least,
            most,
        } = self;
        if least.is_nan() {
            return write!(
                f,
                "with {name} = {given} the sampled loop is unstable for some servo of the box: sample \
                 faster, raise the cut-off, lower the gains, or shrink the box"
            );
        }
        write!(
            f,
            "{name} = {given} is not allowed: it must be from {least} to {most}"
        )
    }
}

impl core::error::Error for NotAllowed {}
