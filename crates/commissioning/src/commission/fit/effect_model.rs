use super::effect::{Effect, SIZES};
use super::{ALL, UNKNOWNS};
use identifier_core::number::Number;

/// An effect of given sizes in a model. Counts, samples and command units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EffectModel<N> {
    effect: Effect,
    sizes: [N; SIZES],
    /// Rad per count.
    resolution: N,
}

/// State of an effect: the position in the backlash, or deflection and its rate.
pub(super) type Memory<N> = [N; 2];

impl<N: Number> EffectModel<N> {
    /// Damping ratio of a resonance: of a coupling of steel.
    const DAMPING: f64 = 0.03;

    /// With the sizes among some unknowns.
    pub(super) fn new(effect: Effect, unknowns: &[N; ALL], resolution: N) -> Self {
        Self {
            effect,
            sizes: core::array::from_fn(|i| unknowns[UNKNOWNS + i]),
            resolution,
        }
    }

    /// Part of a command that acts.
    pub(super) fn command(&self, command: N) -> N {
        if self.effect != Effect::DeadBand {
            return command;
        }
        let band = self.sizes[0];
        command - command.limited(-band, band)
    }

    /// The mean acceleration over a way about a position.
    pub(super) fn push(&self, position: N, way: N) -> N {
        let order = match self.effect {
            Effect::Gravity => N::ONE,
            Effect::Ripple => self.sizes[2],
            _ => return N::ZERO,
        };
        let angle = order * self.resolution;
        let (sine, cosine) = (angle * position).sine_cosine();
        // The mean of a wave is sin x/x of its middle, x being half of the way: to the second order.
        let half = N::from_f64(0.5) * angle * way;
        let mean = (N::ONE - N::from_f64(1.0 / 6.0) * half * half).limited(N::ZERO, N::ONE);
        mean * (self.sizes[0] * sine + self.sizes[1] * cosine) - self.sizes[1]
    }

    /// Friction at a velocity, beside Coulomb's.
    pub(super) fn friction(&self, velocity: N) -> N {
        if self.effect != Effect::LowSpeedFriction {
            return N::ZERO;
        }
        let relative = velocity * self.sizes[1].reciprocal();
        // 1/(1 + x²)², a bell without a transcendental.
        let bell = (N::ONE + relative * relative).reciprocal();
        self.sizes[0] * bell * bell
    }

    /// Its initial state.
    pub(super) fn memory(&self) -> Memory<N> {
        match self.effect {
            Effect::Backlash => {
                let half = N::from_f64(0.5) * self.sizes[0];
                [self.sizes[1].limited(-half, half), N::ZERO]
            }
            _ => [N::ZERO; 2],
        }
    }

    /// The displacement of the rigid servo minus that of the encoder over a time. It follows from the rigid servo's
    /// displacement and its change of velocity.
    pub(super) fn hides(&self, memory: &mut Memory<N>, time: N, way: N, change: N) -> N {
        match self.effect {
            Effect::Backlash => {
                let half = N::from_f64(0.5) * self.sizes[0];
                let before = memory[0];
                memory[0] = (before - way).limited(-half, half);
                before - memory[0]
            }
            Effect::Resonance => self.swing(memory, time, change),
            _ => N::ZERO,
        }
    }

    /// The motor oscillates about the rigid servo: ẅ + 2ζω ẇ + ω² w = r times that one's acceleration. The ratio of the
    /// masses is r. The steps are short beside the oscillation.
    fn swing(&self, [swing, rate]: &mut Memory<N>, time: N, change: N) -> N {
        /// The largest angle of a step, rad, and the most steps.
        const MAX_ANGLE: f64 = 0.3;
        const MAX_STEPS: i32 = 16;
        let before = *swing;
        let [ratio, omega, _] = self.sizes;
        let steps = (omega * time * N::from_f64(1.0 / MAX_ANGLE))
            .limited(N::ZERO, N::from_count(MAX_STEPS - 1))
            .whole()
            + 1;
        let part = N::from_count(steps).reciprocal();
        let short = time * part;
        let turn = omega * short;
        let damping = N::from_f64(2.0 * Self::DAMPING) * turn;
        let drive = ratio * change * part;
        for _ in 0..steps {
            *rate += drive - turn * omega * *swing - damping * *rate;
            *swing += *rate * short;
        }
        before - *swing
    }
}
