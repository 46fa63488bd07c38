use super::scales::RecordScales;
use core::f64::consts::TAU;
use identifier_core::reason::Reason;

/// An effect of a servo beside a, b, c, d and a delay. Its sizes are fitted, in counts, samples and
/// command units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Effect {
    /// Nothing.
    None,
    /// The command within ± the size does not act.
    DeadBand,
    /// A load g_s sin q + g_c (cos q − 1).
    Gravity,
    /// Backlash before the encoder: its width, and the position of the motor in it at first.
    Backlash,
    /// Friction that is higher at rest by the first size, s/(1 + (v/v_s)²)², v_s being the second.
    LowSpeedFriction,
    /// Two masses with a spring between them. Its sizes are the ratio of the masses, and the frequency of both free,
    /// rad/sample.
    Resonance,
    /// A load r_s sin Nq + r_c (cos Nq − 1) with the third size N.
    Ripple,
}

/// Sizes of an effect.
pub(super) const SIZES: usize = 3;

/// Sizes, or changes of them.
pub(super) type Sizes = [f64; SIZES];

/// Orders of ripple, periods per revolution.
const ORDERS: [f64; 2] = [2.0, 48.0];

/// More than any size.
const ANY: f64 = f32::MAX as f64;

impl Effect {
    /// All, in the order in which they are tried: the slowest last.
    pub(super) const ALL: [Self; 7] = [
        Self::None,
        Self::DeadBand,
        Self::Gravity,
        Self::Backlash,
        Self::LowSpeedFriction,
        Self::Resonance,
        Self::Ripple,
    ];

    /// The reason that names it; none for nothing.
    pub(super) const fn reason(self) -> Option<Reason> {
        Some(match self {
            Self::None => return None,
            Self::DeadBand => Reason::LacksDeadBand,
            Self::Gravity => Reason::LacksGravity,
            Self::Backlash => Reason::LacksBacklash,
            Self::LowSpeedFriction => Reason::LacksLowSpeedFriction,
            Self::Resonance => Reason::LacksResonance,
            Self::Ripple => Reason::LacksRipple,
        })
    }

    /// From how many first sizes it is looked for. Frequencies and orders lie so close together that a fit
    /// finds the way from the nearest.
    pub(super) const fn starts(self) -> u32 {
        match self {
            Self::None | Self::DeadBand | Self::Gravity => 1,
            Self::Backlash => 4,
            Self::LowSpeedFriction => 3,
            Self::Resonance => 40,
            Self::Ripple => 28,
        }
    }

    /// The first sizes from a start.
    pub(super) fn first(self, start: u32, scales: &RecordScales) -> Sizes {
        /// Widths of the backlash, counts.
        const PLAYS: [f64; 2] = [3.0, 200.0];
        /// Speeds below which friction is another, over the mean.
        const LOW_SPEEDS: [f64; 2] = [0.03, 0.5];
        /// First size of a dead band, over the largest command. At zero its start would be no dead band.
        const DEAD_BAND: f64 = 0.01;
        /// The fewest periods of a resonance in a record, and its largest angle in a block, rad.
        const PERIODS: f64 = 3.0;
        const ANGLE: f64 = 1.0;
        let between = |[low, high]: [f64; 2]| {
            let part = f64::from(start) / f64::from(self.starts().saturating_sub(1).max(1));
            low * libm::pow(high / low, part)
        };
        match self {
            Self::None | Self::Gravity => [0.0; SIZES],
            Self::DeadBand => [DEAD_BAND * scales.command, 0.0, 0.0],
            Self::Backlash => [between(PLAYS), 0.0, 0.0],
            Self::LowSpeedFriction => [0.0, between(LOW_SPEEDS) * scales.speed, 0.0],
            Self::Resonance => {
                let lowest = PERIODS * TAU / scales.lasting;
                let highest = (ANGLE / scales.samples).max(2.0 * lowest);
                [0.0, between([lowest, highest]), 0.0]
            }
            Self::Ripple => [0.0, 0.0, between(ORDERS)],
        }
    }

    /// Steps of the sizes for difference quotients.
    pub(super) fn changes(self, sizes: &Sizes, scales: &RecordScales) -> Sizes {
        let force = RecordScales::SMALL_CHANGE * scales.acceleration;
        match self {
            Self::None => [0.0; SIZES],
            Self::DeadBand => [RecordScales::SMALL_CHANGE * scales.command, 0.0, 0.0],
            Self::Gravity => [force, force, 0.0],
            Self::Backlash => [0.5, 0.5, 0.0],
            Self::LowSpeedFriction => [force, 0.1 * sizes[1], 0.0],
            Self::Resonance => [0.01, 0.01 * sizes[1], 0.0],
            Self::Ripple => [force, force, 0.05],
        }
    }

    /// The largest change of the sizes in one pass. Beyond it the effect of a change is not proportional to its size.
    pub(super) fn most(self, sizes: &Sizes) -> Sizes {
        match self {
            Self::LowSpeedFriction => [ANY, 0.4 * sizes[1], ANY],
            Self::Resonance => [ANY, 0.03 * sizes[1], ANY],
            Self::Ripple => [ANY, ANY, 0.06 * sizes[2]],
            _ => [ANY; SIZES],
        }
    }

    /// True if there is as much of it as to be what it is called. With almost no mass behind the spring, a fit only
    /// gains a servo that may move at first.
    pub(super) fn is_material(self, sizes: &Sizes) -> bool {
        const RATIO: f64 = 0.03;
        self != Self::Resonance || sizes[0] >= RATIO
    }

    /// The least and the largest sizes, about the first ones.
    pub(super) fn bounds(self, first: &Sizes, scales: &RecordScales) -> [Sizes; 2] {
        /// The largest ratio of the masses.
        const RATIO: f64 = 20.0;
        let force = scales.acceleration;
        match self {
            Self::None => [[0.0; SIZES]; 2],
            Self::DeadBand => [[0.0; SIZES], [scales.command, 0.0, 0.0]],
            Self::Gravity => [[-force, -force, 0.0], [force, force, 0.0]],
            Self::Backlash => [[0.0, -ANY, 0.0], [ANY, ANY, 0.0]],
            Self::LowSpeedFriction => [[0.0, 0.3 * first[1], 0.0], [force, 3.0 * first[1], 0.0]],
            Self::Resonance => [[0.0, 0.5 * first[1], 0.0], [RATIO, 2.0 * first[1], 0.0]],
            Self::Ripple => [
                [-force, -force, (0.7 * first[2]).max(ORDERS[0])],
                [force, force, 1.4 * first[2]],
            ],
        }
    }
}
