//! A load on a spring behind the motor: the second mass, on the motor's own friction and stops.

use super::acting::Acting;
use super::state::State;
use super::twisting::Twisting;
use super::{Effect, Values};

/// A load with the share ρ of the inertia behind a spring. The resonance of motor and load, both free, is ω, and its
/// damping is ζ. The twist w accelerates the load by (1 − ρ)(ω² w + 2ζω ẇ). It brakes the motor, of the inertia 1 − ρ,
/// by ρ times that. Both are integrated in pieces by a leapfrog, the motor by its own exact step. The leapfrog: Hairer,
/// Lubich and Wanner, "Geometric numerical integration illustrated by the Störmer–Verlet method", Acta Numerica 12,
/// 2003.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coupling {
    frequency: f64,
    damping: f64,
    share: f64,
}

impl Coupling {
    /// The angle of its oscillation in a piece, at most, rad.
    const ANGLE: f64 = 0.25;

    /// That of a model with two masses.
    pub(super) fn of(values: &Values) -> Option<Self> {
        let share = values.get(Effect::LoadShare);
        (share > 0.0).then(|| Self {
            frequency: values.get(Effect::ResonanceFrequency),
            damping: values.get(Effect::ResonanceDamping),
            share,
        })
    }

    /// Reciprocal of the motor's inertia.
    pub(super) fn motor_inertia_inverse(&self) -> f64 {
        1.0 / (1.0 - self.share)
    }

    /// By how much it holds the motor back.
    pub(super) fn holds(&self, twisting: &Twisting) -> f64 {
        self.share * (1.0 - self.share) * self.force(0.0, twisting.twist, twisting.rate)
    }

    /// ω² w + 2ζω ẇ, with the twist in the middle of a piece and the rate at its beginning. A leapfrog is too fast by
    /// the square of its angle over 24. A rate half a piece too early adds ζω²h w. The stiffness is reduced by both.
    fn force(&self, length: f64, twist: f64, rate: f64) -> f64 {
        let angle = self.frequency * length;
        let kept = 1.0 - angle * (self.damping + angle / 12.0);
        self.frequency * (self.frequency * kept * twist + 2.0 * self.damping * rate)
    }

    /// Its derivative by ω.
    fn force_per_frequency(&self, length: f64, twist: f64, rate: f64) -> f64 {
        let angle = self.frequency * length;
        let kept = 2.0 - angle * (3.0 * self.damping + angle / 3.0);
        self.frequency * kept * twist + 2.0 * self.damping * rate
    }

    /// Its derivative by ζ.
    fn force_per_damping(&self, length: f64, twist: f64, rate: f64) -> f64 {
        let angle = self.frequency * length;
        self.frequency * (2.0 * rate - self.frequency * angle * twist)
    }

    /// The pieces in which it moves over a part of a sample.
    pub(super) fn pieces(&self, length: f64) -> u32 {
        (self.frequency * length / Self::ANGLE) as u32 + 1
    }
}

impl<const C: usize, const PLAIN: bool> State<'_, C, PLAIN> {
    /// Integrates the motor, and a load on a spring if there is one, over a part of a sample.
    #[inline]
    pub(super) fn advance(&mut self, coupling: Option<&Coupling>, acting: &mut Acting<'_>) {
        let shaped = self.shaped(acting);
        let pieces = coupling.map_or(1, |coupling| coupling.pieces(acting.length));
        let push = acting.push;
        if pieces > 1 {
            acting.length /= f64::from(pieces);
        }
        for _ in 0..pieces {
            let before = coupling.map(|coupling| {
                acting.push =
                    push - acting.motor_inertia_inverse * self.twist(coupling, acting.length);
                (self.velocity, self.tangents.velocity)
            });
            self.advance_motor(acting, &shaped);
            if let Some((velocity, derivatives)) = &before {
                self.unload_spring(acting.length, *velocity, derivatives);
            }
        }
    }

    /// The force of the spring on the motor over a piece of a sample. Its derivatives are in the tangents.
    fn twist(&mut self, coupling: &Coupling, length: f64) -> f64 {
        let share = coupling.share;
        let rest = 1.0 - share;
        let middle = self.twisting.middle(length);
        let rate = self.twisting.rate;
        let force = coupling.force(length, middle, rate);
        self.twisting.carried = rest * force;
        for (i, column) in self.columns.iter().enumerate() {
            let own = &mut self.tangents.twisting[i];
            let by_twist = coupling.force(length, own.middle(length), own.rate);
            let (by_size, held) = match column.effect {
                Effect::ResonanceFrequency => {
                    let change = coupling.force_per_frequency(length, middle, rate);
                    (rest * change, 0.0)
                }
                Effect::ResonanceDamping => {
                    (rest * coupling.force_per_damping(length, middle, rate), 0.0)
                }
                Effect::LoadShare => (-force, rest * force),
                _ => (0.0, 0.0),
            };
            own.carried = rest * by_twist + by_size;
            self.tangents.held[i] = share * own.carried + held;
        }
        share * self.twisting.carried
    }

    /// The piece has ended; the motor had this velocity and these derivatives of it before.
    fn unload_spring(&mut self, length: f64, before: f64, derivatives: &[f64; C]) {
        self.twisting.end(length, self.velocity - before);
        let velocities = self.tangents.velocity.iter().zip(derivatives);
        for (own, (after, before)) in self.tangents.twisting.iter_mut().zip(velocities) {
            own.end(length, after - before);
        }
    }
}
