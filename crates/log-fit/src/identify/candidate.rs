//! Effects that a servo may have beyond friction, load and delay.

use std::f64::consts::TAU;

use crate::fit::{Column, Effect, RecordFitter, RecordStatistics, Values};

use super::recording::Recording;
use crate::cause::Cause;

/// An effect in one of its forms, as columns of a pass.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    pub(super) cause: Cause,
    pub(super) columns: Vec<Column>,
}

/// The highest order of a torque ripple, and of a ripple that may be missing: slots and pole pairs of usual motors.
const MAX_ORDER: u32 = 40;

/// The fewest counts to a period of cogging.
const MIN_COUNTS: f64 = 4.0;

/// Orders of an inertia that depends on the angle: one per turn for an arm, two for a crank.
const INERTIA_ORDERS: [f64; 2] = [1.0, 2.0];

/// Speeds at which friction may fade, of a large velocity of the motion.
const FADING: [f64; 3] = [0.03, 0.1, 0.3];

/// Plays between motor and encoder that are looked for, counts.
const BACKLASHES: [f64; 3] = [3.0, 12.0, 48.0];

/// Ratio of the resonances that are looked for.
const RESONANCES_APART: f64 = 1.2;

/// Way above which both parts of a wave may show, and above which no part does alone, rad.
const SEPARABLE: [f64; 2] = [0.1 * TAU, 0.5 * TAU];

/// The longest delay with which a search for one begins, samples.
const MAX_FIRST_DELAY: f64 = 3.0;

/// The figures of a record that candidates depend on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Range {
    /// A large velocity, counts/sample.
    pub(super) velocity: f64,
    /// Distance between the ends of the motion, rad, and whether forces may repeat with it.
    pub(super) angle: f64,
    pub(super) turns: bool,
    /// The highest order of cogging that the encoder shows.
    pub(super) order: u32,
    /// The means of sin and cos over the motion.
    pub(super) mean_wave: [f64; 2],
    /// A large command.
    pub(super) peak: f64,
    /// Levels of the command below which half, three quarters, nine tenths and most of it lies. Empty if it has a
    /// single size.
    pub(super) levels: Vec<f64>,
    /// Resonances faster than the motion, rad/sample.
    pub(super) resonances: Vec<f64>,
}

impl Range {
    /// The candidates for a record with these figures.
    pub(super) fn new(recording: &Recording<'_>, statistics: &RecordStatistics) -> Self {
        let [small, half, most, nearly, all, peak] =
            recording.levels([0.1, 0.5, 0.75, 0.9, 0.97, 0.99]);
        // A command of few sizes has none in between, but a share of the largest is; of one size there is none.
        let levels = [(half, 0.6), (most, 0.75), (nearly, 0.85), (all, 0.95)]
            .map(|(level, share)| level.min(share * peak));
        let [slowest, fastest] = RecordFitter::RESONANCES;
        let first = (2.0 * statistics.bandwidth).max(slowest);
        let resonances = std::iter::successors(Some(first), |last| Some(RESONANCES_APART * last));
        Self {
            velocity: statistics.velocity,
            angle: recording.span(),
            turns: recording.turns(),
            order: Self::highest_order(recording),
            mean_wave: recording.mean_wave(1.0),
            peak,
            levels: levels.into_iter().filter(|level| *level > small).collect(),
            resonances: resonances.take_while(|one| *one < fastest).collect(),
        }
    }

    /// True if both parts of a wave may show.
    fn shows(&self, order: f64) -> bool {
        self.turns && self.angle * order >= SEPARABLE[1]
    }

    fn highest_order(recording: &Recording<'_>) -> u32 {
        let seen = TAU * recording.radian() / MIN_COUNTS;
        Effect::MAX_ORDER.min(seen as u32)
    }

    /// The mean over the motion of a gravity of some sizes.
    pub(super) fn mean_gravity(&self, sizes: impl Iterator<Item = f64>) -> f64 {
        sizes
            .zip(self.mean_wave)
            .map(|(size, mean)| size * mean)
            .sum()
    }
}

/// Sizes of a motion, by which effects are small or large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TypicalMagnitudes {
    /// The largest command.
    command: f64,
    /// The acceleration by it, counts/sample².
    acceleration: f64,
    /// A large velocity, counts/sample.
    velocity: f64,
    /// Reciprocal of the motion's bandwidth, samples.
    time: f64,
    /// Counts to a rad of the angle.
    radian: f64,
}

impl TypicalMagnitudes {
    /// The usual sizes for a record with some values.
    pub(super) fn new(fitter: &RecordFitter<'_>, values: &Values) -> Self {
        let statistics = &fitter.statistics;
        Self {
            command: statistics.command,
            acceleration: fitter.usual_size(values, Effect::Load),
            velocity: statistics.velocity,
            time: 1.0 / statistics.bandwidth,
            radian: fitter.record.radian,
        }
    }
}

impl Candidate {
    pub(super) fn plain(cause: Cause, effects: &[Effect]) -> Self {
        Self::at(cause, effects, 0.0)
    }

    pub(super) fn at(cause: Cause, effects: &[Effect], setting: f64) -> Self {
        let column = |&effect: &Effect| Column { effect, setting };
        Self {
            cause,
            columns: effects.iter().map(column).collect(),
        }
    }

    /// All but those whose effects are free.
    pub(super) fn all(range: &Range, free: &[Effect]) -> Vec<Self> {
        use Effect as E;
        let mut all = vec![
            Self::plain(Cause::Coulomb, &[E::Coulomb]),
            Self::plain(Cause::Load, &[E::Load]),
            Self::plain(Cause::Delay, &[E::Delay]),
            Self::plain(Cause::Asymmetry, &[E::Asymmetry]),
            Self::plain(Cause::QuadraticFriction, &[E::Quadratic]),
            Self::plain(Cause::DeadBand, &[E::DeadBand]),
            Self::plain(Cause::LoadFriction, &[E::LoadFriction]),
            Self::plain(Cause::GainDrift, &[E::GainDrift]),
            Self::plain(Cause::FrictionDrift, &[E::FrictionDrift]),
            Self::plain(Cause::GainAsymmetry, &[E::GainAsymmetry]),
            Self::plain(Cause::Resonance, &[E::Compliance]),
        ];
        // Without a delay in the model a current loop looks like one.
        if free.contains(&E::Delay) {
            all.push(Self::plain(Cause::CurrentLoop, &[E::CurrentLoop]));
        }
        for &level in &range.levels {
            all.push(Self::at(Cause::HiddenLimit, &[E::LimitSlope], level));
        }
        for &resonance in &range.resonances {
            all.push(Self::at(Cause::Resonance, &[E::Compliance], resonance));
        }
        for backlash in BACKLASHES {
            all.push(Self::at(Cause::Backlash, &[E::Backlash], backlash));
        }
        for share in FADING {
            let fading = share * range.velocity;
            all.push(Self::at(Cause::LowSpeedFriction, &[E::LowSpeed], fading));
        }
        // Over a short way only the odd part of a wave shows beside a constant, over a long one both do.
        let [short, long] = SEPARABLE;
        if range.angle < long {
            all.push(Self::plain(Cause::Gravity, &[E::GravitySine]));
        }
        if range.angle > short {
            let gravity = [E::GravitySine, E::GravityCosine];
            all.push(Self::plain(Cause::Gravity, &gravity));
        }
        if range.turns && range.angle < long {
            all.push(Self::at(Cause::VaryingInertia, &[E::InertiaSine], 1.0));
        }
        if range.turns && range.angle > long {
            let eccentricity = [E::EccentricitySine, E::EccentricityCosine];
            all.push(Self::plain(Cause::Eccentricity, &eccentricity));
        }
        let seen = |order: &f64| range.shows(*order);
        for order in INERTIA_ORDERS.into_iter().filter(seen) {
            let inertia = [E::InertiaSine, E::InertiaCosine];
            all.push(Self::at(Cause::VaryingInertia, &inertia, order));
        }
        all.extend(Self::waves(range, free, range.order.min(MAX_ORDER)));
        let orders = (2..=MAX_ORDER).map(f64::from).filter(seen);
        all.extend(orders.filter_map(|order| Self::torque_ripple(order, free)));
        let is_free = |effect: &E| free.contains(effect);
        all.retain(|candidate| {
            let is_further = candidate.cause == Cause::Ripple;
            is_further || !effects(candidate.cause).iter().any(is_free)
        });
        all
    }

    /// The waves of ripple that the motion may show beside the free effects, up to an order.
    pub(super) fn waves(range: &Range, free: &[Effect], highest: u32) -> Vec<Self> {
        let is_new = |wave: &&[Effect; 2]| !wave.iter().any(|effect| free.contains(effect));
        let Some(wave) = Effect::FORCES[1..].iter().find(is_new) else {
            return Vec::new();
        };
        let orders = (2..=highest)
            .map(f64::from)
            .filter(|order| range.shows(*order));
        orders
            .map(|order| Self::at(Cause::Ripple, wave, order))
            .collect()
    }

    /// A gain with a wave of an order, beside free effects without one.
    pub(super) fn torque_ripple(order: f64, free: &[Effect]) -> Option<Self> {
        let wave = [Effect::TorqueRippleSine, Effect::TorqueRippleCosine];
        let is_new = order <= f64::from(MAX_ORDER) && !free.contains(&wave[0]);
        is_new.then(|| Self::at(Cause::TorqueRipple, &wave, order))
    }

    /// True of a shaft without a resonance.
    pub(super) fn is_stiff(&self) -> bool {
        self.cause == Cause::Resonance && self.columns[0].setting == 0.0
    }

    /// True of a second mass at a frequency.
    pub(super) fn is_mode(&self) -> bool {
        self.cause == Cause::Resonance && !self.is_stiff()
    }

    /// True if its size cannot be negative.
    pub(super) fn is_positive(&self) -> bool {
        matches!(
            self.cause,
            Cause::Coulomb
                | Cause::Delay
                | Cause::DeadBand
                | Cause::CurrentLoop
                | Cause::LoadFriction
                | Cause::Backlash
                | Cause::HiddenLimit
        ) || self.is_stiff()
    }

    /// Its usual size.
    pub(super) fn usual_size(&self, usual: &TypicalMagnitudes) -> f64 {
        match self.cause {
            Cause::Delay | Cause::CurrentLoop => 0.1 * usual.time,
            Cause::Asymmetry => 0.05 * usual.acceleration / usual.velocity,
            Cause::QuadraticFriction => 0.05 * usual.acceleration / usual.velocity.powi(2),
            Cause::Coulomb | Cause::Load | Cause::LowSpeedFriction | Cause::Gravity => {
                0.05 * usual.acceleration
            }
            Cause::Ripple => 0.02 * usual.acceleration,
            Cause::DeadBand => 0.02 * usual.command,
            Cause::LoadFriction => 0.07,
            Cause::VaryingInertia => 0.1,
            Cause::GainDrift => 0.05,
            Cause::FrictionDrift => 0.2,
            // A twentieth of the largest command is lost.
            Cause::HiddenLimit => {
                let beyond = usual.command - self.columns[0].setting;
                (0.05 * usual.command / beyond.max(f64::MIN_POSITIVE)).min(0.5)
            }
            Cause::Backlash => 0.01 * usual.velocity * usual.time,
            Cause::Eccentricity => 1e-3 * usual.radian,
            Cause::Resonance => 0.03 * usual.time.powi(2),
            _ => 0.02,
        }
    }

    /// Odds that a servo has it, before its record is seen.
    pub(super) const fn prior_odds(&self) -> f64 {
        match self.cause {
            // Every bridge has a dead time.
            Cause::DeadBand => 1.0,
            // Every gear has some.
            Cause::LoadFriction => 0.3,
            _ => 0.1,
        }
    }

    /// True if an effect of this size matters. No servo matches its model to better than a fiftieth of usual sizes.
    /// But a resonance matters to a loop that is faster than the motion.
    pub(super) fn matters(&self, values: &Values, usual: &TypicalMagnitudes) -> bool {
        const MIN_SHARE: f64 = 0.02;
        const MIN_WAVE: f64 = 0.06;
        if self.is_mode() {
            return true;
        }
        let size = |column: &Column| match column.effect {
            Effect::Compliance => values.twist(),
            effect => values.get(effect),
        };
        let squares = self.columns.iter().map(|column| size(column).powi(2));
        let size = squares.sum::<f64>().sqrt();
        // What a large wave leaves by an error of its form, or of the encoder, looks like a small one.
        let least = match self.cause {
            Cause::Ripple => MIN_WAVE * values.largest_ripple(),
            _ => 0.0,
        };
        size >= least.max(MIN_SHARE * self.usual_size(usual))
    }

    /// The start values of a search for it, and the effects that are free with it. Linear algebra gives its sizes.
    pub(super) fn enter(
        &self,
        values: &Values,
        free: &[Effect],
        answer: &Answer,
        range: &Range,
    ) -> (Values, Vec<Effect>) {
        /// The part of friction that a dead band begins as.
        const OF_FRICTION: f64 = 0.6;
        let sizes = &answer.sizes;
        let mut values = *values;
        let mut free = free.to_vec();
        let setting = self.columns[0].setting;
        if self.cause == Cause::HiddenLimit {
            values.set(Effect::LimitSlope, 1.0);
            let kept = (1.0 - sizes[0]).clamp(0.0, 1.0);
            values.set(Effect::HiddenLimit, setting + kept * (range.peak - setting));
            // With the gain of a model without the limit a search would leave it.
            for (&effect, shift) in free.iter().zip(&answer.shifts) {
                if effect == Effect::B {
                    // A step by linear algebra may be longer than the gain itself.
                    let gain = values.get(effect);
                    values.set(effect, (gain + shift).clamp(0.5 * gain, 2.0 * gain));
                }
            }
            free.push(Effect::HiddenLimit);
            return (values, free);
        }
        if self.is_mode() {
            // The scan has the twist of the spring, the fit both masses: see `Values::twist`.
            let ratio = sizes[0] * setting * setting;
            values.set(Effect::ResonanceFrequency, setting);
            values.set(Effect::ResonanceDamping, Values::USUAL_DAMPING);
            free.extend([Effect::ResonanceFrequency, Effect::ResonanceDamping]);
            if ratio < 0.0 {
                // What the load shows of a motor's motion has nothing of its share.
                values.set(Effect::EncoderOnLoad, 1.0);
                values.set(Effect::LoadShare, 0.5);
            } else {
                values.set(Effect::LoadShare, (ratio / (1.0 + ratio)).clamp(0.05, 0.9));
                free.push(Effect::LoadShare);
            }
            return (values, free);
        }
        for (column, &size) in self.columns.iter().zip(sizes) {
            let effect = column.effect;
            free.push(effect);
            let known = values.get(effect);
            let size = known + size;
            let value = match effect {
                Effect::Delay => size.clamp(0.0, known + MAX_FIRST_DELAY),
                Effect::CurrentLoop => {
                    // A current loop begins with half of the delay; one that begins at zero ends nowhere.
                    let delay = values.get(Effect::Delay);
                    let lag = (0.5 * delay).clamp(0.3, 3.0);
                    values.set(Effect::Delay, delay - lag);
                    lag
                }
                Effect::DeadBand if known == 0.0 && values.get(Effect::Coulomb) > 0.0 => {
                    // Friction has taken its place: from none of it a search would not find it.
                    let (gain, friction) = (values.get(Effect::B), values.get(Effect::Coulomb));
                    values.set(Effect::Coulomb, (1.0 - OF_FRICTION) * friction);
                    OF_FRICTION * friction / gain
                }
                Effect::DeadBand => size.clamp(0.0, known + 0.05 * range.peak),
                Effect::LoadFriction => size.clamp(0.0, 0.2),
                Effect::GainDrift
                | Effect::GainAsymmetry
                | Effect::TorqueRippleSine
                | Effect::TorqueRippleCosine
                | Effect::InertiaSine
                | Effect::InertiaCosine => size.clamp(-0.3, 0.3),
                Effect::LowSpeed => size.max(-values.get(Effect::Coulomb)),
                _ => size,
            };
            values.set(effect, value);
        }
        match self.cause {
            Cause::LowSpeedFriction => {
                values.set(Effect::LowSpeedVelocity, setting.min(range.velocity));
                free.push(Effect::LowSpeedVelocity);
            }
            Cause::Ripple => {
                if let Some([place, _]) = self.columns[0].effect.force() {
                    values.orders[place] = setting;
                }
            }
            Cause::TorqueRipple => values.gain_order = setting,
            Cause::VaryingInertia => values.inertia_order = setting,
            _ => {}
        }
        (values, free)
    }
}

/// The effects that a cause sets free.
pub fn effects(cause: Cause) -> &'static [Effect] {
    use Effect as E;
    match cause {
        Cause::Coulomb => &[E::Coulomb],
        Cause::Load => &[E::Load],
        Cause::Delay => &[E::Delay],
        Cause::CurrentLoop => &[E::CurrentLoop],
        Cause::Asymmetry => &[E::Asymmetry],
        Cause::QuadraticFriction => &[E::Quadratic],
        Cause::DeadBand => &[E::DeadBand],
        Cause::LoadFriction => &[E::LoadFriction],
        Cause::GainDrift => &[E::GainDrift],
        Cause::FrictionDrift => &[E::FrictionDrift],
        Cause::GainAsymmetry => &[E::GainAsymmetry],
        Cause::Resonance => &[
            E::Compliance,
            E::LoadShare,
            E::ResonanceFrequency,
            E::ResonanceDamping,
            E::EncoderOnLoad,
        ],
        Cause::Backlash => &[E::Backlash],
        Cause::HiddenLimit => &[E::HiddenLimit],
        Cause::LowSpeedFriction => &[E::LowSpeed, E::LowSpeedVelocity],
        Cause::Gravity => &[E::GravitySine, E::GravityCosine],
        Cause::VaryingInertia => &[E::InertiaSine, E::InertiaCosine],
        Cause::Ripple => E::FORCES[1..].as_flattened(),
        Cause::TorqueRipple => &[E::TorqueRippleSine, E::TorqueRippleCosine],
        Cause::Eccentricity => &[E::EccentricitySine, E::EccentricityCosine],
        _ => &[],
    }
}

/// A candidate's answer.
#[derive(Debug, Clone)]
pub(super) struct Answer {
    pub(super) candidate: Candidate,
    /// Gain in −2 ln L, in independent rows, in segments that it was not fitted to.
    pub(super) held_out: f64,
    /// Mean of that gain over its standard error.
    pub(super) consistency: f64,
    /// The same in all segments.
    pub(super) gain: f64,
    /// χ² of its sizes by the segments' disagreement.
    pub(super) significance: f64,
    /// Its sizes.
    pub(super) sizes: Vec<f64>,
    /// By how much it would move the free effects.
    pub(super) shifts: Vec<f64>,
}

impl Answer {
    /// False if its size would be negative and cannot be.
    pub(super) fn is_possible(&self) -> bool {
        !self.candidate.is_positive() || self.sizes[0] > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Logged, Way};
    use super::*;

    #[test]
    fn a_hidden_limit_is_looked_for_between_the_sizes_of_a_command_and_not_below_a_single_one() {
        let range = |small: f64, large: f64| {
            let sample = |k: u32| Logged {
                position: 0.01 * f64::from(k),
                command: if k.is_multiple_of(3) { small } else { -large },
                begins: k == 0,
            };
            let samples: Vec<Logged> = (0..1000).map(sample).collect();
            let statistics = RecordStatistics {
                noise: 1.0,
                velocity: 1.0,
                command: large,
                bandwidth: 0.1,
            };
            Range::new(
                &Recording::new(&samples, Axis::new(100.0, Way::Turn(TAU))),
                &statistics,
            )
        };
        let levels = range(2.0, 5.0).levels;
        let between = levels.iter().filter(|level| (2.0..5.0).contains(*level));
        assert!(between.count() > 1, "{levels:?}");
        assert!(range(5.0, 5.0).levels.is_empty());
    }
}
