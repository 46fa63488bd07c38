//! b at every time scale: a first answer for any record, without a noise model, an observer or a start.
//!
//! The equation of motion is integrated twice over windows, −∬q̈ = −a ∬q̇ + b ∬(u − τ u̇) − c ∬sign q̇ + d and gravity, and
//! solved by least squares for windows from a few samples to a part of the record. A window is four boxes in a row, a cubic
//! B-spline: the second difference of positions over a box is exactly the mean acceleration over two of them. No noise is
//! differentiated. Literature: Preisig and Rippin, "Theory and application of the modulating function method", Computers &
//! Chemical Engineering 17(1), 1993.

mod solution;
mod windows;

use crate::fit::{Effect, Record, Values};
use solution::{Blocks, JUDGED, MODELS, Solution};
use windows::{Bins, Column};

/// The effects of the first columns, in their order.
const PARAMETERS: [Effect; 4] = [Effect::A, Effect::B, Effect::Coulomb, Effect::Load];

/// What a record says of its servo at a time scale, counts and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeScale {
    /// Length of its windows, samples. The deviation of their weights is its part of 1/√48.
    pub span: f64,
    /// a, b, c, d, the delay and gravity where it predicts better.
    pub values: Values,
    /// Standard errors of a, b, c and d: chance, the next scales and other models that predict as well.
    pub std_errors: Values,
    /// The force towards the middle with which it predicts best, of a count, samples⁻²; zero without.
    pub spring: f64,
    /// The part of the acceleration that it predicts of blocks that were left out, at most 1.
    pub explained: f64,
    /// The best of a servo without gravity and with it, and the part that it explains.
    pub(crate) starts: [Option<(Values, f64)>; 2],
    /// Standard error of b by chance alone.
    chance: f64,
}

/// The answers of positions, counts, under the command from each to the next, with the places at which a motion begins.
/// `radian` are the counts of a rad; zero where positions are no angles.
#[must_use]
pub fn scales_of(
    positions: &[f64],
    commands: &[f64],
    begins: &[usize],
    radian: f64,
) -> Vec<TimeScale> {
    let angles = positions.windows(2).map(|ends| {
        let (sine, cosine) = (0.5 * (ends[0] + ends[1]) / radian).sin_cos();
        [sine, cosine]
    });
    let angles: Vec<[f64; 2]> = angles.filter(|_| radian > 0.0).collect();
    let record = Record {
        begins,
        angles: &angles,
        radian,
        ..Record::of(positions, commands)
    };
    scales(&record, 0.0)
}

/// How far a position is off that is predicted over a quarter of a window's length, counts rms of blocks that are left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Length of the windows, samples.
    pub span: f64,
    /// Windows that do not overlap by more than half.
    pub windows: f64,
    /// By the command, and without it.
    pub driven: f64,
    /// See `driven`.
    pub alone: f64,
}

/// What commands predict of positions, both as of [`scales_of`], at all time scales, the shortest first.
#[must_use]
pub fn predicted(positions: &[f64], commands: &[f64], begins: &[usize]) -> Vec<Predicted> {
    let record = Record {
        begins,
        ..Record::of(positions, commands)
    };
    over_scales(&record, |bins, count| {
        let blocks = [false, true].map(|held| Blocks::new(bins, count, 0.0, held));
        let box_length = (count * bins.samples) as f64;
        let [driven, alone] = JUDGED.each_ref().map(|models| {
            let missed = models.iter().filter_map(|model| {
                let blocks = blocks[usize::from(model.is_held)].as_ref()?;
                Some(blocks.solve(model)?.missed * blocks.mean_square())
            });
            missed.fold(f64::INFINITY, f64::min).sqrt() * box_length.powi(2)
        });
        let found = Predicted {
            span: 4.0 * box_length,
            windows: bins.count() as f64 / (2 * count) as f64,
            driven,
            alone,
        };
        (driven.is_finite() && alone.is_finite()).then_some(found)
    })
}

/// The answers of a record at all time scales, the shortest first. `noise` is the deviation of a position, counts.
pub(crate) fn scales(record: &Record<'_>, noise: f64) -> Vec<TimeScale> {
    let mut found = over_scales(record, |bins, count| TimeScale::new(bins, count, noise));
    for place in 0..found.len() {
        let near = place.saturating_sub(1)..(place + 2).min(found.len());
        let [own, others] = [place..place + 1, near].map(|of| found[of].to_vec());
        for effect in PARAMETERS {
            let off = |other: &TimeScale| other.values.get(effect) - own[0].values.get(effect);
            let drift = match others.len() {
                1 => own[0].values.get(effect).abs(),
                _ => others
                    .iter()
                    .map(|other| off(other).abs())
                    .fold(0.0, f64::max),
            };
            let error = found[place].std_errors.get(effect).hypot(drift);
            found[place].std_errors.set(effect, error);
        }
    }
    found
}

/// What is found in windows of all lengths, the shortest first.
fn over_scales<T>(record: &Record<'_>, find: impl Fn(&Bins, usize) -> Option<T>) -> Vec<T> {
    /// Bins of a box, of the finest bins and of those of all others.
    const FINEST: [usize; 5] = [2, 3, 4, 6, 8];
    const COARSER: [usize; 2] = [6, 8];
    /// Windows that follow each other in a record, at least.
    const MIN_WINDOWS: usize = 6;
    let mut found = Vec::new();
    let mut bins = Bins::new(record);
    let mut boxes = &FINEST[..];
    while 4 * boxes[0] * MIN_WINDOWS < bins.count() {
        let fitting = boxes
            .iter()
            .filter(|count| 4 * **count * MIN_WINDOWS < bins.count());
        found.extend(fitting.filter_map(|&count| find(&bins, count)));
        bins = bins.halved();
        boxes = &COARSER;
    }
    found
}

/// The surest of some time scales, by b; none if none explains anything.
#[must_use]
pub fn surest(scales: &[TimeScale]) -> Option<&TimeScale> {
    /// The least part of the acceleration that is explained, and the most that one counts for the sign.
    const EXPLAINED: f64 = 0.3;
    const SURE: f64 = 5.0;
    /// The longest delay of which a first term is enough, part of a window.
    const DELAY: f64 = 0.125;
    let gain = |scale: &TimeScale| scale.values.get(Effect::B);
    let certainty = |scale: &TimeScale| gain(scale) / scale.std_errors.get(Effect::B);
    let good = scales
        .iter()
        .filter(|scale| scale.explained > EXPLAINED && gain(scale).abs() > 2.0 * scale.chance)
        .filter(|scale| scale.values.get(Effect::Delay).abs() < DELAY * scale.span);
    let sign: f64 = (good.clone())
        .map(|scale| scale.explained * certainty(scale).clamp(-SURE, SURE))
        .sum();
    let price = |scale: &&TimeScale| certainty(scale).powi(-2) + (1.0 - scale.explained).powi(2);
    good.filter(|scale| gain(scale) * sign > 0.0)
        .min_by(|one, other| price(one).total_cmp(&price(other)))
}

impl TimeScale {
    fn new(bins: &Bins, count: usize, noise: f64) -> Option<Self> {
        /// A model predicts as well as the best if it misses no more than this part and this share more.
        const AS_WELL: [f64; 2] = [1.1, 1e-4];
        /// Correlation of what is missed with a cause that is known, deviation.
        const CORRELATION: f64 = 0.25;
        let [plain, held] = [false, true].map(|held| Blocks::new(bins, count, noise, held));
        let solved = MODELS.iter().filter_map(|model| {
            let blocks = if model.is_held { &held } else { &plain };
            blocks.as_ref()?.solve(model)
        });
        let solved: Vec<Solution> = solved.collect();
        let best = |is_asked: &dyn Fn(&Solution) -> bool| {
            let asked = solved.iter().filter(|one| is_asked(one));
            asked.min_by(|one, other| one.missed.total_cmp(&other.missed))
        };
        let chosen = best(&|_| true)?;
        let most = AS_WELL[0] * chosen.missed + AS_WELL[1];
        // A spring that the motion does not tell predicts worse, and b is as open as its size.
        let is_rival = |one: &&Solution| one.missed < most || one.has(Column::Spring);
        let rivals = || solved.iter().filter(is_rival);
        let mut std_errors = Values::NONE;
        for (column, effect) in PARAMETERS.into_iter().enumerate() {
            let off = rivals().map(|rival| (rival.values[column] - chosen.values[column]).abs());
            let error = off.fold(0.0, f64::max).hypot(chosen.std_errors[column]);
            let error = error.hypot(CORRELATION * chosen.shifts[column]);
            std_errors.set(effect, error);
        }
        let start = |has_gravity: bool| {
            let is_asked = |one: &Solution| {
                one.has(Column::Direction)
                    && one.has(Column::Sine) == has_gravity
                    && !one.has(Column::Spring)
            };
            best(&is_asked).map(|one| (one.servo(), 1.0 - one.missed))
        };
        Some(Self {
            span: (4 * count * bins.samples) as f64,
            values: chosen.servo(),
            std_errors,
            spring: chosen.value(Column::Spring),
            explained: 1.0 - chosen.missed,
            starts: [false, true].map(start),
            chance: chosen.std_errors[Column::Command as usize],
        })
    }
}

impl Solution {
    fn servo(&self) -> Values {
        let mut values = Values::NONE;
        for (column, effect) in PARAMETERS.into_iter().enumerate() {
            values.set(effect, self.values[column]);
        }
        values.set(
            Effect::Delay,
            self.value(Column::CommandChange) / self.value(Column::Command),
        );
        values.set(Effect::GravitySine, self.value(Column::Sine));
        values.set(Effect::GravityCosine, self.value(Column::Cosine));
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed form of a servo without friction and damping under a held command: each sample adds ½ b u.
    fn free(samples: usize, [gain, load, sine]: [f64; 3]) -> (Vec<f64>, Vec<f64>, Vec<[f64; 2]>) {
        let (mut position, mut velocity) = (0.0, 0.0);
        let (mut positions, mut commands, mut angles) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..samples {
            let time = k as f64;
            let command = (0.05 * time).sin() + (0.013 * time).cos() * (0.031 * time).sin();
            let command = [1.0, -0.7][k / 40 % 2] * command;
            let wave = (0.02 * time).sin();
            positions.push(position);
            commands.push(command);
            angles.push([wave, 1.0]);
            let acceleration = gain * command + load + sine * wave;
            position += velocity + 0.5 * acceleration;
            velocity += acceleration;
        }
        (positions, commands, angles)
    }

    fn of(samples: usize, forces: [f64; 3], has_angles: bool) -> Vec<TimeScale> {
        let (positions, commands, angles) = free(samples, forces);
        let record = Record {
            angles: if has_angles { &angles } else { &[] },
            ..Record::of(&positions, &commands)
        };
        scales(&record, 0.0)
    }

    #[test]
    fn of_a_servo_that_only_accelerates_every_scale_has_its_gain() {
        for gain in [3.0, -3.0] {
            let found = of(4000, [gain, 0.2, 0.0], false);
            assert!(found.len() > 10);
            for scale in &found {
                let b = scale.values.get(Effect::B);
                // Farther boxes average the command within their bins.
                let allowed = if scale.span <= 32.0 { 1e-6 } else { 0.02 };
                assert!((b / gain - 1.0).abs() < allowed, "{scale:?}");
            }
            let best = surest(&found).expect("a gain");
            assert!((best.values.get(Effect::B) / gain - 1.0).abs() < 1e-6);
            assert!((best.values.get(Effect::Load) - 0.2).abs() < 1e-4);
            assert!(best.explained > 0.999);
        }
    }

    #[test]
    fn a_force_of_the_angle_is_taken_off_where_it_predicts_better() {
        let found = of(4000, [3.0, 0.0, 2.0], true);
        let best = surest(&found).expect("a gain");
        let off = best.values.get(Effect::B) / 3.0 - 1.0;
        assert!(off.abs() < 1e-3, "{best:?}");
        assert!((best.values.get(Effect::GravitySine) / 2.0 - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_force_that_is_not_known_is_in_the_error() {
        let error_of = |has_angles: bool| {
            let found = of(4000, [3.0, 0.0, 2.0], has_angles);
            let best = *surest(&found).expect("a gain");
            let error = best.std_errors.get(Effect::B);
            let off = (best.values.get(Effect::B) - 3.0).abs();
            assert!(off < 2.0 * error, "{off} {error}");
            (error / 3.0, best.explained)
        };
        let [(known, _), (unknown, explained)] = [true, false].map(error_of);
        // A quarter of what comes with the command if all that is missed does: as if it were as large as the command's part.
        let least = 0.2 * (1.0 - explained).sqrt();
        assert!(unknown > least, "{unknown} {explained}");
        assert!(known < 0.1 * unknown, "{known} {unknown}");
    }

    #[test]
    fn a_motion_without_a_cause_has_no_gain() {
        let (positions, mut commands, _) = free(4000, [3.0, 0.0, 0.0]);
        // A command that has nothing to do with the motion.
        let mut state = 1_u32;
        for command in &mut commands {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *command = f64::from(state >> 8) / f64::from(1_u32 << 23) - 1.0;
        }
        let record = Record::of(&positions, &commands);
        let found = scales(&record, 0.3);
        assert!(surest(&found).is_none(), "{:?}", surest(&found));
    }

    #[test]
    fn a_record_that_is_too_short_has_no_scale() {
        assert_eq!(of(40, [3.0, 0.0, 0.0], false), Vec::new());
    }
}
