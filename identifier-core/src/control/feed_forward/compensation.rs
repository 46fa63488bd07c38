use super::{FeedForward, FeedForwardSettings, Lead, MovingReference, ReferenceMotion, braking};
use crate::control::Gains;
use crate::error::{Allowed, OutOfRange};
use crate::measurement::angle::AngleSettings;
use crate::measurement::velocity::Transfer;
use crate::number::Number;
use crate::units::Units;

/// Compensation of known forces and of a dead band, SI: u = d₀ + g_s sin y + g_c cos y + r_s sin Ny + r_c cos Ny in command units,
/// and up to δ of the command that the reference model needs once more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensationSettings {
    /// Holds a constant load: −d/b, command units.
    pub constant: f64,
    /// Hold gravity, with sin y and cos y: −g_s/b and −g_c/b, command units.
    pub gravity: [f64; 2],
    /// Take a ripple away, with sin Ny and cos Ny: −r_s/b and −r_c/b, command units.
    pub ripple: [f64; 2],
    /// N, periods per revolution; at least 0.
    pub ripple_order: f64,
    /// The travel after which gravity and ripple repeat, rad: 2π but on a linear axis.
    pub revolution: f64,
    /// δ, the command that a bridge swallows to either side, command units, at least 0.
    pub dead_band: f64,
    /// Time from a command to its acceleration besides the hold's, s, at least 0: gravity and ripple are those of where the model
    /// is then.
    pub delay: f64,
}

/// A [`FeedForward`] that compensates a load, gravity, a ripple and a dead band too.
///
/// All of it is a function of the reference model alone, y + (τ + T/2) ẏ, and of no measurement: neither the loop nor its margins
/// change, and nothing chatters at rest, where the model stands. For the dead band the command that the model needs is added once
/// more, but δ at most: one that passes zero while the servo brakes makes no jump, and none is more than doubled.
///
/// The angle is that of the measured increments since where the servo was at first, with the distance of the model from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensatedFeedForward<N> {
    lead: FeedForward<N>,
    constant: N,
    waves: [N; 4],
    angle: AngleSettings<N>,
    /// Samples after which a command acts, in the mean.
    ahead: N,
    dead_band: N,
    /// The parts of the lead's command for acceleration and velocity that the derivative takes back.
    braking: [N; 2],
}

/// State of a [`CompensatedFeedForward`], machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensatedMotion<N> {
    pub(super) reference: ReferenceMotion<N>,
    /// The measured position within a revolution.
    pub(super) position: N,
}

impl CompensationSettings {
    /// None.
    pub const NONE: Self = Self {
        constant: 0.0,
        gravity: [0.0; 2],
        ripple: [0.0; 2],
        ripple_order: 0.0,
        revolution: core::f64::consts::TAU,
        dead_band: 0.0,
        delay: 0.0,
    };

    /// The largest command that it adds, command units.
    #[must_use]
    pub fn largest(&self) -> f64 {
        let amplitude = |[sine, cosine]: [f64; 2]| libm::hypot(sine, cosine);
        libm::fabs(self.constant)
            + amplitude(self.gravity)
            + amplitude(self.ripple)
            + self.dead_band
    }

    /// What it adds to a command, by name.
    fn added(&self) -> [(&'static str, f64); 6] {
        let ([sine, cosine], [of_sine, of_cosine]) = (self.gravity, self.ripple);
        [
            ("feed_forward_constant", self.constant),
            ("feed_forward_gravity", sine),
            ("feed_forward_gravity", cosine),
            ("feed_forward_ripple", of_sine),
            ("feed_forward_ripple", of_cosine),
            ("feed_forward_dead_band", self.dead_band),
        ]
    }

    /// # Errors
    /// The setting that is out of its range, by name.
    fn check(&self) -> Result<(), OutOfRange> {
        const LARGEST: f64 = Gains::LARGEST;
        for (name, added) in self.added() {
            Allowed::Within(-LARGEST, LARGEST).check(name, added)?;
        }
        Allowed::AtLeast(0.0).check("feed_forward_dead_band", self.dead_band)?;
        Allowed::Within(0.0, LARGEST).check("feed_forward_ripple_order", self.ripple_order)?;
        Allowed::PositiveUpTo(LARGEST).check("feed_forward_revolution", self.revolution)?;
        Allowed::Within(0.0, LARGEST).check("feed_forward_delay", self.delay)?;
        Ok(())
    }
}

impl<N: Number> CompensatedFeedForward<N> {
    /// That of a controller with these gains and this estimate of the velocity.
    ///
    /// # Errors
    /// As [`FeedForward::new`], or `feed_forward_constant`, `feed_forward_gravity`, `feed_forward_ripple`,
    /// `feed_forward_ripple_order`, `feed_forward_revolution`, `feed_forward_dead_band` or `feed_forward_delay`.
    pub fn new(
        units: &Units,
        settings: &FeedForwardSettings,
        known: &CompensationSettings,
        gains: &Gains,
        velocity: &Transfer,
    ) -> Result<Self, OutOfRange> {
        let lead = FeedForward::new(units, settings, gains, velocity)?;
        known.check()?;
        let [of_acceleration, of_velocity] = braking(units, gains, velocity);
        let ([sine, cosine], [of_sine, of_cosine]) = (known.gravity, known.ripple);
        Ok(Self {
            lead,
            constant: N::from_f64(known.constant),
            waves: [sine, cosine, of_sine, of_cosine].map(N::from_f64),
            angle: AngleSettings::new(known.revolution * units.position(), known.ripple_order),
            ahead: N::from_f64(0.5 + known.delay / units.sample_time()),
            dead_band: N::from_f64(known.dead_band),
            braking: [
                N::from_f64(of_acceleration / units.acceleration()),
                N::from_f64(of_velocity / units.velocity()),
            ],
        })
    }

    /// The model at rest where the servo is, at a position (position units) from where the angle is zero.
    #[must_use]
    pub fn at(&self, position: N) -> CompensatedMotion<N> {
        CompensatedMotion {
            reference: FeedForward::at_rest(N::ZERO),
            position: self.angle.within(position),
        }
    }

    #[inline(never)]
    fn follow(&self, motion: &mut CompensatedMotion<N>, error: N, increment: N) -> (N, N) {
        let moving = self.lead.advance(&mut motion.reference, error, increment);
        motion.position = self.angle.within(motion.position + increment);
        let command = self.lead.command(&moving);
        (
            moving.distance,
            command + self.compensation(motion.position, &moving, command),
        )
    }

    /// What is added to a lead's command.
    #[inline]
    fn compensation(&self, position: N, moving: &MovingReference<N>, command: N) -> N {
        let there = position + moving.distance + self.ahead * moving.velocity;
        let waves = self.angle.waves(there);
        let held = (0..4).fold(self.constant, |held, i| held + self.waves[i] * waves[i]);
        let [of_acceleration, of_velocity] = self.braking;
        let braking = of_acceleration * moving.acceleration + of_velocity * moving.velocity;
        let needed = command - braking + held;
        held + needed.limited(-self.dead_band, self.dead_band)
    }
}

impl<N: Number> Lead<N> for CompensatedFeedForward<N> {
    type Motion = CompensatedMotion<N>;

    const NONE: Self = Self {
        lead: FeedForward::NONE,
        constant: N::ZERO,
        waves: [N::ZERO; 4],
        angle: AngleSettings::NONE,
        ahead: N::ZERO,
        dead_band: N::ZERO,
        braking: [N::ZERO; 2],
    };

    fn at_rest(error: N) -> CompensatedMotion<N> {
        CompensatedMotion {
            reference: FeedForward::at_rest(error),
            position: N::ZERO,
        }
    }

    #[inline]
    fn process(&self, motion: &mut CompensatedMotion<N>, error: N, increment: N) -> (N, N) {
        if self.lead.leads() {
            self.follow(motion, error, increment)
        } else {
            // What is added changes no bit of a command.
            (error, -N::ZERO)
        }
    }
}
