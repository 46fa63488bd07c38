//! A run or a log as the fit takes it: counts, commands, angles.

use std::borrow::Cow;
use std::f64::consts::TAU;

use crate::fit::{Effect, Matrix, Record, RecordFitter, RecordStatistics, Values};
use crate::scales::{TimeScale, scales};

use super::between::Between;

/// A recorded motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording<'a> {
    samples: &'a [Logged],
    axis: Axis,
    positions: Vec<f64>,
    commands: Vec<f64>,
    /// The recorded commands of the log, for blocks.
    recorded: Vec<f64>,
    /// Sine and cosine of the angle from the middle of the motion.
    angles: Vec<[f64; 2]>,
    begins: Vec<usize>,
    /// The samples of the log that those are.
    rows: Vec<usize>,
    /// Samples of the log to one of the record.
    pub block: f64,
    stride: usize,
    /// Distance between the ends of the motion, rad of the angle.
    span: f64,
    /// Counts to a rad of the angle.
    radian: f64,
    /// The mean angle, rad, from which angles count. Around it sin varies with the angle and cos barely. Over a short
    /// distance a wave is then one unknown and a constant.
    middle: f64,
}

/// A sample of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logged {
    /// Rad.
    pub position: f64,
    /// The command from there on.
    pub command: f64,
    /// A motion begins here.
    pub begins: bool,
}

impl Logged {
    /// The two halves of a block from one position to another, rad. Their commands have its mean, and its first moment
    /// about the middle. The position there is interpolated.
    #[must_use]
    pub fn halves([first, next]: [f64; 2], command: f64, moment: f64) -> [Self; 2] {
        let half = |position, command| Self {
            position,
            command,
            begins: false,
        };
        [
            half(first, command - 4.0 * moment),
            half(0.5 * (first + next), command + 4.0 * moment),
        ]
    }
}

/// How forces go with the position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way {
    /// They repeat after a distance, rad.
    Turn(f64),
    /// Nothing is known of an angle: they change over such a motion as over a quarter of a turn.
    Path {
        /// From end to end, rad.
        length: f64,
    },
}

impl Way {
    /// Angle to a rad.
    fn angle(self) -> f64 {
        /// The angle that a path is taken for: a wave is nearly a line over it, and its other part a parabola.
        const PATH: f64 = 1.5;
        match self {
            Self::Turn(after) => TAU / after,
            Self::Path { length } => PATH / length.max(f64::MIN_POSITIVE),
        }
    }
}

/// What is known of the rows of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Counts to a rad.
    pub per_rad: f64,
    /// How forces go with the position.
    pub way: Way,
    /// What acted between two rows.
    pub between: Between,
}

impl Axis {
    /// One whose commands are held.
    #[must_use]
    pub const fn new(per_rad: f64, way: Way) -> Self {
        let between = Between::Held;
        Self {
            per_rad,
            way,
            between,
        }
    }
}

/// The most samples of a record: those of a longer log are taken together in blocks.
pub const MAX_SAMPLES: usize = 1 << 15;

/// The most samples of a log that are taken together in blocks, and on which errors are judged. A longer log gives pieces of
/// this length from its beginning to its end.
const MAX_TAKEN: usize = 1 << 17;
const MAX_JUDGED: usize = 1 << 16;
const PIECE: usize = 1 << 13;

impl<'a> Recording<'a> {
    /// A recording from the samples of a log.
    #[must_use]
    pub fn new(samples: &'a [Logged], axis: Axis) -> Self {
        let block = match samples.len().min(MAX_TAKEN) {
            count if count <= MAX_SAMPLES => 1,
            // Two samples of the record to a block.
            count => (2 * count).div_ceil(MAX_SAMPLES).max(2),
        };
        let most = if block > 1 { MAX_TAKEN } else { usize::MAX };
        Self::of(samples, block, most, axis, None)
    }

    /// The same of every sample, however long the log is.
    #[must_use]
    pub fn of_every_sample(samples: &'a [Logged], axis: Axis) -> Self {
        Self::of(samples, 1, usize::MAX, axis, None)
    }

    /// A recording from the [halves](Logged::halves) of blocks: only the first half of each has a measured position.
    #[must_use]
    pub fn of_halves(halves: &'a [Logged], axis: Axis) -> Self {
        let mut recording = Self::new(halves, axis);
        recording.stride = 2;
        recording.recorded = recording.commands.clone();
        recording
    }

    /// Every sample of a log of which this has blocks.
    pub(super) fn every_sample(&self) -> Option<Self> {
        self.in_samples(usize::MAX)
    }

    /// The samples on which the errors of a log are judged of which this has blocks.
    pub(super) fn judged_samples(&self) -> Option<Self> {
        self.in_samples(MAX_JUDGED)
    }

    fn in_samples(&self, most: usize) -> Option<Self> {
        let of = || Self::of(self.samples, 1, most, self.axis, Some(self.middle));
        (self.block > 1.0).then(of)
    }

    /// In blocks of samples, or of every sample, of pieces of a log that has more than the most samples. The angles are from a
    /// middle, rad; without one the mean.
    fn of(
        samples: &'a [Logged],
        block: usize,
        most: usize,
        axis: Axis,
        middle: Option<f64>,
    ) -> Self {
        let per_travel = axis.way.angle();
        let mut recording = Self {
            samples,
            axis,
            positions: Vec::new(),
            commands: Vec::new(),
            recorded: Vec::new(),
            angles: Vec::new(),
            begins: Vec::new(),
            rows: Vec::new(),
            block: if block > 1 { 0.5 * block as f64 } else { 1.0 },
            stride: if block > 1 { 2 } else { 1 },
            span: 0.0,
            radian: axis.per_rad / per_travel,
            middle: middle.unwrap_or_else(|| {
                let sum: f64 = samples.iter().map(|one| one.position).sum();
                per_travel * sum / samples.len().max(1) as f64
            }),
        };
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for (row, motion) in motions(samples, most) {
            let motion = &acted(motion, axis.between)[..];
            if block == 1 {
                recording.add(row, motion, &mut ends);
            } else {
                let halves = in_blocks(motion, block);
                recording.add(row, &halves, &mut ends);
                let whole = motion.iter().take(halves.len() / 2 * block);
                (recording.recorded).extend(whole.map(|sample| sample.command));
            }
        }
        recording.span = per_travel * (ends[1] - ends[0]).max(0.0);
        recording
    }

    /// Adds a motion that begins at a sample of the log.
    fn add(&mut self, row: usize, motion: &[Logged], ends: &mut [f64; 2]) {
        // Differences count alone: a far origin would cost digits.
        let Some(origin) = motion.first().map(|first| first.position) else {
            return;
        };
        self.begins.push(self.positions.len());
        self.rows.push(row);
        let (per_rad, per_travel) = (self.axis.per_rad, self.axis.way.angle());
        for (k, sample) in motion.iter().enumerate() {
            let position = sample.position;
            self.positions.push((position - origin) * per_rad);
            self.commands.push(sample.command);
            *ends = [ends[0].min(position), ends[1].max(position)];
            let next = motion.get(k + 1).map_or(position, |next| next.position);
            let angle = 0.5 * (position + next) * per_travel - self.middle;
            let (sine, cosine) = angle.sin_cos();
            self.angles.push([sine, cosine]);
        }
    }

    /// What it says of its servo at every time scale, the shortest first; nothing without motion.
    #[must_use]
    pub fn scales(&self) -> Vec<TimeScale> {
        let record = self.record();
        let statistics = RecordStatistics::new(&record);
        statistics.map_or_else(Vec::new, |found| scales(&record, found.noise))
    }

    /// The sample of the log that one of the record is, samples of the record.
    pub(super) fn place(&self, sample: usize) -> f64 {
        let motion = self.begins.partition_point(|&first| first <= sample);
        let [first, row] = [&self.begins, &self.rows]
            .map(|of| of.get(motion.saturating_sub(1)).copied().unwrap_or(0));
        row as f64 / self.block + (sample - first) as f64
    }

    /// As a record.
    pub fn record(&self) -> Record<'_> {
        Record {
            positions: &self.positions,
            commands: &self.commands,
            angles: &self.angles,
            radian: self.radian,
            begins: &self.begins,
            stride: self.stride,
            recorded: &self.recorded,
        }
    }

    /// Distance between the ends of the motion, rad of the angle.
    pub(super) fn span(&self) -> f64 {
        self.span
    }

    /// Counts to a rad of the angle.
    pub(super) const fn radian(&self) -> f64 {
        self.radian
    }

    /// What is known of its rows.
    pub(super) const fn axis(&self) -> Axis {
        self.axis
    }

    /// The same rows with other knowledge of them; none of the halves of blocks, whose commands acted.
    pub(super) fn with(&self, axis: Axis) -> Option<Self> {
        let has_rows = self.block > 1.0 || self.stride == 1;
        has_rows.then(|| Self::new(self.samples, axis))
    }

    /// The same with what acted between the rows, where another than a held command explains the positions clearly better.
    pub(super) fn between_rows(&self, values: &Values) -> Option<Self> {
        /// The increase of −2 ln L in independent rows by which another than a held command must be better.
        const CLEARLY: f64 = 20.0;
        let lateness = |recording: &Self| {
            let record = recording.record();
            RecordFitter::new(&record)?.lateness(values)
        };
        let held = lateness(self)?;
        let others = [Between::Sampled, Between::Averaged].map(|between| {
            let axis = Axis {
                between,
                ..self.axis
            };
            let other = self.with(axis)?;
            Some((lateness(&other)?.unexplained, other))
        });
        let best = (others.into_iter().flatten()).min_by(|one, other| one.0.total_cmp(&other.0));
        best.filter(|(of, _)| held.unexplained - of > CLEARLY * held.rows_per_row)
            .map(|(_, other)| other)
    }

    /// True if forces may repeat with the angle.
    pub(super) fn turns(&self) -> bool {
        matches!(self.axis.way, Way::Turn(_))
    }

    /// The means of sin Nq and cos Nq over the motion, for a whole N.
    pub(super) fn mean_wave(&self, order: f64) -> [f64; 2] {
        let per_sample = 1.0 / self.angles.len().max(1) as f64;
        let mut mean = [0.0; 2];
        for [sine, cosine] in &self.angles {
            let (sine, cosine) = (order * sine.atan2(*cosine)).sin_cos();
            mean[0] += sine * per_sample;
            mean[1] += cosine * per_sample;
        }
        mean
    }

    /// The waves of values, and the orders in which they go with the angle.
    fn waves(values: &Values) -> impl Iterator<Item = ([Effect; 2], f64)> {
        use Effect as E;
        let others = [
            (
                [E::TorqueRippleSine, E::TorqueRippleCosine],
                values.gain_order,
            ),
            ([E::InertiaSine, E::InertiaCosine], values.inertia_order),
            ([E::EccentricitySine, E::EccentricityCosine], 1.0),
        ];
        let forces = E::FORCES.into_iter().zip(values.orders);
        forces.chain(others)
    }

    /// Values whose waves count from another angle, farther by `angle`, rad.
    fn turned(values: &Values, angle: f64) -> Values {
        let mut turned = *values;
        for (wave, order) in Self::waves(values) {
            let (sin, cos) = (order * angle).sin_cos();
            let [sine, cosine] = wave.map(|effect| values.get(effect));
            turned.set(wave[0], sine * cos - cosine * sin);
            turned.set(wave[1], cosine * cos + sine * sin);
        }
        turned
    }

    /// Values whose waves count from the middle of the motion, of some that count from angle zero.
    pub(super) fn about_middle(&self, values: &Values) -> Values {
        Self::turned(values, self.middle)
    }

    /// Values whose waves count from angle zero, and of the `free` effects the standard errors and the covariance with
    /// them. A wave with one estimated part has both.
    pub(super) fn about_zero(
        &self,
        values: &Values,
        free: &[Effect],
        covariance: &Matrix,
    ) -> (Values, Vec<(Effect, f64)>, Vec<Vec<f64>>) {
        // Each with its parts in the errors from the middle.
        let mut found: Vec<(Effect, [(usize, f64); 2])> = (free.iter().enumerate())
            .map(|(place, &effect)| (effect, [(place, 1.0), (place, 0.0)]))
            .collect();
        for (wave, order) in Self::waves(values) {
            let (sin, cos) = (order * self.middle).sin_cos();
            let places = wave.map(|effect| free.iter().position(|one| *one == effect));
            let Some(any) = places[0].or(places[1]) else {
                continue;
            };
            found.retain(|(one, _)| !wave.contains(one));
            for (effect, parts) in wave.into_iter().zip([[cos, sin], [-sin, cos]]) {
                let part = |i: usize| places[i].map_or((any, 0.0), |place| (place, parts[i]));
                found.push((effect, [part(0), part(1)]));
            }
        }
        let product = |one: &[(usize, f64); 2], other: &[(usize, f64); 2]| -> f64 {
            let all = one
                .iter()
                .flat_map(|one| other.iter().map(move |other| (one, other)));
            // Nothing of an infinite error is none.
            let all = all.map(|(one, other)| (one.1 * other.1, covariance[one.0][other.0]));
            all.filter(|(part, _)| *part != 0.0)
                .map(|(part, entry)| part * entry)
                .sum()
        };
        let rows = found.iter().map(|(effect, one)| {
            let row = found.iter().map(|(other_effect, other)| {
                let entry = product(one, other);
                // Two of which nothing is known are not told to be related.
                if effect == other_effect || entry.is_finite() {
                    entry
                } else {
                    0.0
                }
            });
            row.collect()
        });
        let errors = found
            .iter()
            .map(|(effect, one)| (*effect, product(one, one).sqrt()));
        (
            Self::turned(values, -self.middle),
            errors.collect(),
            rows.collect(),
        )
    }

    /// The direction in which the servo moved. None if it moved in both by more than its encoder's noise.
    pub(super) fn direction(&self) -> Option<f64> {
        /// Part of the way to either side.
        const SHARE: f64 = 0.02;
        let [mut ahead, mut back] = [0.0; 2];
        for pair in self.positions.windows(2) {
            let step = pair[1] - pair[0];
            ahead += step.max(0.0);
            back -= step.min(0.0);
        }
        (ahead.min(back) <= SHARE * (ahead + back)).then_some(f64::signum(ahead - back))
    }

    /// The magnitude of the command below which a part of it lies, for each of some parts.
    pub(super) fn levels<const L: usize>(&self, parts: [f64; L]) -> [f64; L] {
        let commands = if self.recorded.is_empty() {
            &self.commands
        } else {
            &self.recorded
        };
        let mut sizes: Vec<f64> = commands.iter().map(|command| command.abs()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let last = sizes.len().saturating_sub(1);
        parts.map(|part| {
            let level = sizes.get((part * last as f64) as usize);
            level.copied().unwrap_or(0.0)
        })
    }
}

/// A motion with the commands that acted.
fn acted(motion: &[Logged], between: Between) -> Cow<'_, [Logged]> {
    if between == Between::Held {
        return motion.into();
    }
    let commands: Vec<f64> = motion.iter().map(|sample| sample.command).collect();
    let acted = between.acted(&commands).into_iter();
    let rows = motion.iter().zip(acted);
    rows.map(|(sample, command)| Logged { command, ..*sample })
        .collect()
}

/// The motions of a log, each with its first sample. For a log of more than the most samples they are those of some pieces.
fn motions(samples: &[Logged], most: usize) -> impl Iterator<Item = (usize, &[Logged])> {
    let count = samples.len();
    let (pieces, length) = if count > most {
        (most / PIECE, PIECE)
    } else {
        (1, count)
    };
    let piece = move |k: usize| {
        let first = k * (count - length) / (pieces - 1).max(1);
        (first, &samples[first..first + length])
    };
    (0..pieces).map(piece).flat_map(|(first, piece)| {
        let motions = piece.chunk_by(|_, next| !next.begins);
        motions.scan(first, |row, motion| {
            let own = *row;
            *row += motion.len();
            Some((own, motion))
        })
    })
}

/// A motion in whole blocks of samples, each as two samples.
fn in_blocks(motion: &[Logged], block: usize) -> Vec<Logged> {
    let mut blocks = Vec::new();
    let positions = motion.iter().step_by(block).map(|first| first.position);
    let ends = positions.clone().skip(1);
    for ((samples, first), next) in motion.chunks_exact(block).zip(positions).zip(ends) {
        let count = block as f64;
        let [mut mean, mut moment] = [0.0; 2];
        for (k, sample) in samples.iter().enumerate() {
            let place = (k as f64 + 0.5) / count - 0.5;
            mean += sample.command / count;
            moment += sample.command * place / count;
        }
        blocks.extend(Logged::halves([first, next], mean, moment));
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::MAX_UNKNOWNS;

    fn matrix<const N: usize>(rows: &[[f64; N]; N]) -> Matrix {
        let mut matrix = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
        for (entries, row) in matrix.iter_mut().zip(rows) {
            entries[..N].copy_from_slice(row);
        }
        matrix
    }

    /// A steady motion from a position.
    fn moved(first: f64, speed: f64) -> Vec<Logged> {
        let sample = |k: i32| Logged {
            position: first + speed * f64::from(k),
            command: 0.0,
            begins: k == 0,
        };
        (0..100).map(sample).collect()
    }

    #[test]
    fn a_force_that_goes_with_the_way_of_a_linear_axis_repeats_after_its_pole_pitch() {
        const PITCH: f64 = 0.03;
        let [samples, further] = [moved(0.0, 1e-4), moved(PITCH / 3.0, 1e-4)];
        let [recording, further] = [&samples, &further]
            .map(|samples| Recording::new(samples, Axis::new(1e6, Way::Turn(PITCH))));
        assert!((recording.span() - TAU * 0.0099 / PITCH).abs() < 1e-9);
        // A third of the pitch on, a wave about zero is a third of a turn on.
        let values = Values::NONE.with(Effect::GravitySine, 1.0);
        let wave = |recording: &Recording<'_>| {
            let (found, ..) = recording.about_zero(&values, &[], &matrix(&[]));
            let sine = found.get(Effect::GravitySine);
            found.get(Effect::GravityCosine).atan2(sine)
        };
        let turned = (wave(&recording) - wave(&further)).rem_euclid(TAU);
        assert!((turned - TAU / 3.0).abs() < 1e-9, "{turned}");
    }

    #[test]
    fn waves_about_zero_are_those_from_the_middle() {
        let samples = moved(0.9, 0.004);
        let recording = Recording::new(&samples, Axis::new(100.0, Way::Turn(TAU)));
        let waves = [
            ([Effect::GravitySine, Effect::GravityCosine], 1.0),
            ([Effect::TorqueRippleSine, Effect::TorqueRippleCosine], 3.0),
        ];
        let mut values = Values::NONE;
        values.gain_order = 3.0;
        for (wave, _) in waves {
            values.set(wave[0], 0.7);
            values.set(wave[1], -0.2);
        }
        let one = [Effect::GravitySine, Effect::B];
        let by_chance = [[0.01, 0.003], [0.003, 0.09]];
        let (found, errors, covariance) = recording.about_zero(&values, &one, &matrix(&by_chance));
        for ([sine, cosine], order) in waves {
            for angle in [0.9, 1.1] {
                let at = |values: &Values, angle: f64| {
                    let (sin, cos) = (order * angle).sin_cos();
                    values.get(sine) * sin + values.get(cosine) * cos
                };
                let off = at(&found, angle) - at(&values, angle - recording.middle);
                assert!(off.abs() < 1e-12, "{order} {angle}: {off}");
            }
        }
        // With an odd part only, both parts are as certain as it.
        let place = |effect| errors.iter().position(|(one, _)| *one == effect);
        let error = |effect| place(effect).map(|place| errors[place].1);
        let [sine, cosine] = [Effect::GravitySine, Effect::GravityCosine].map(error);
        let both = sine.unwrap_or(0.0).hypot(cosine.unwrap_or(0.0));
        assert!((both - 0.1).abs() < 1e-12, "{errors:?}");
        assert_eq!(error(Effect::B), Some(0.3));
        assert_eq!(error(Effect::InertiaSine), None);
        let of = |one, other| covariance[place(one).expect("known")][place(other).expect("known")];
        let [sine, cosine] = [Effect::GravitySine, Effect::GravityCosine];
        let (sin, cos) = recording.middle.sin_cos();
        for (found, wanted) in [
            (of(sine, cosine), -0.01 * sin * cos),
            (of(sine, Effect::B), 0.003 * cos),
            (of(cosine, Effect::B), -0.003 * sin),
            (of(Effect::B, Effect::B), 0.09),
        ] {
            assert!((found - wanted).abs() < 1e-12, "{covariance:?}");
        }
    }
}
