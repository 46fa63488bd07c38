use super::super::CommissionSettings;
use super::super::frequency_response::{FrictionBalance, LineRotations, LineSums, Lines};
use super::ResponseFit;
use identifier_core::number::{Complex, Number};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::MeasuredLine;

/// A place without a line.
const NO_LINE: MeasuredLine = MeasuredLine {
    frequency: 0.0,
    gain: Complex::ZERO,
    deviation: 0.0,
};

/// The response that a round of motions measures. It has the sums of every line, and from these lines with their
/// deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::commission) struct MeasuredResponse<N> {
    sample_time: f64,
    resolution: f64,
    /// The lines of the present or last motions, whether they stand beside those of earlier motions, and their sums.
    first_pass: Lines,
    beside: bool,
    sums: [ResponseSums<N>; Lines::MAX],
    lines: [MeasuredLine; MOST],
    count: usize,
    /// The motions beneath them, backwards and forwards.
    balances: [BalanceSums<N>; 2],
}

/// The sum of what motions in a direction showed of their balance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct BalanceSums<N> {
    response_motions: u8,
    velocity: N,
    acceleration: N,
    command: N,
}

/// The most lines: those of three rounds.
const MOST: usize = 3 * Lines::MAX;

/// Lines on either side of one that enter its deviation. A deviation of four motions is itself uncertain.
const NEIGHBOURS: usize = 2;

/// The sums of a line over motions. Those of an inverted injection count with the opposite sign, which cancels the transient
/// of a turn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct ResponseSums<N> {
    response_motions: u8,
    /// ∑ ±Y and ∑ ±U.
    position: [N; 2],
    command: [N; 2],
    /// ∑ |Y|², ∑ |U|², ∑ Y U*.
    powers: [N; 2],
    cross: [N; 2],
}

/// The measurement of the lines after the motions, a line in a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::commission) struct LineMeasurement {
    rotations: LineRotations,
    /// Lines of earlier motions.
    earlier: usize,
    /// Lines whose sums were taken.
    sums: usize,
    /// The deviations that they have by themselves, and those that were smoothed.
    deviations: [f64; Lines::MAX],
    smoothed: usize,
}

impl<N: Number> MeasuredResponse<N> {
    /// The part of its own deviation that a line has at least.
    const OWN: f64 = 0.7;

    /// Of no axis yet.
    pub(in crate::commission) fn none() -> Self {
        Self {
            sample_time: 0.0,
            resolution: 0.0,
            first_pass: Lines::default(),
            beside: false,
            sums: Default::default(),
            lines: [NO_LINE; MOST],
            count: 0,
            balances: Default::default(),
        }
    }

    /// Nothing is measured of an axis with these settings.
    pub(in crate::commission) fn restart(&mut self, settings: &CommissionSettings) {
        (self.sample_time, self.resolution) = (settings.sample_time, settings.resolution);
        self.count = 0;
        self.begin(&Lines::default(), false);
    }

    /// Begins to measure lines. If motions show them, they stand beside those before, or take the place of all up to their
    /// highest.
    pub(in crate::commission) fn begin(&mut self, lines: &Lines, beside: bool) {
        self.first_pass = *lines;
        self.beside = beside;
        self.sums = Default::default();
        self.balances = Default::default();
    }

    /// True if motions have shown the lines under way.
    pub(in crate::commission) fn has_lines(&self) -> bool {
        let [first, ..] = &self.sums;
        first.response_motions > 1
    }

    /// Drops the lines of earlier motions up to the highest of these.
    fn drop_earlier(&mut self) {
        let highest = self.first_pass.frequencies().last().unwrap_or(0.0);
        let is_lower = |line: &MeasuredLine| line.frequency <= highest;
        let dropped = self.lines().partition_point(is_lower);
        let kept = self.lines.get_mut(..self.count).unwrap_or_default();
        kept.rotate_left(dropped.min(kept.len()));
        self.count -= dropped;
    }

    /// Takes the sums of a line over the window of a motion.
    pub(in crate::commission) fn take(&mut self, sums: &LineSums<N>) {
        if let Some(line) = self.sums.get_mut(usize::from(sums.line)) {
            line.take(sums);
        }
    }

    /// Takes the balance of a motion.
    pub(in crate::commission) fn take_balance(&mut self, balance: &FrictionBalance<N>) {
        let [backwards, forwards] = &mut self.balances;
        if balance.velocity > N::ZERO {
            forwards.take(balance);
        } else {
            backwards.take(balance);
        }
    }

    /// Coulomb friction c and load d, rad/s², of a servo with this gain b and viscous friction a. They follow from b u
    /// = v̇ + a v ± c − d. None unless it has moved both ways.
    pub(in crate::commission) fn friction(&self, servo: &ServoParameters) -> Option<[f64; 2]> {
        let ServoParameters { a, b, .. } = *servo;
        let per_time = self.resolution / self.sample_time;
        let needed = |sums: &BalanceSums<N>| {
            let [velocity, acceleration, command] = sums.mean()?;
            let acceleration = acceleration * per_time / self.sample_time;
            Some(b * command - acceleration - a * velocity * per_time)
        };
        let [backwards, forwards] = &self.balances;
        let [backwards, forwards] = [needed(backwards)?, needed(forwards)?];
        let coulomb = 0.5 * (forwards - backwards).max(0.0);
        Some([coulomb, -0.5 * (forwards + backwards)])
    }

    /// Begins to fit masses to the measured lines; none if there are too few.
    pub(in crate::commission) fn fit(
        &self,
        servo: &IdentifiedServo,
        is_uncertain: bool,
    ) -> Option<ResponseFit> {
        ResponseFit::begin(self.lines(), servo, is_uncertain, self.sample_time)
    }

    /// The measured lines, by frequency: those that at least two motions have shown.
    pub(in crate::commission) fn lines(&self) -> &[MeasuredLine] {
        self.lines.get(..self.count).unwrap_or_default()
    }

    /// Begins to measure the lines, of which the sums of all motions were taken.
    pub(in crate::commission) fn begin_lines(&mut self) -> LineMeasurement {
        if self.has_lines() && !self.beside {
            self.drop_earlier();
        }
        self.count = self.count.min(MOST - Lines::MAX);
        LineMeasurement {
            rotations: self.first_pass.rotations(),
            earlier: self.count,
            sums: 0,
            deviations: [0.0; Lines::MAX],
            smoothed: 0,
        }
    }

    /// Measures the next line, or smooths the deviation of the next; true once all are measured.
    pub(in crate::commission) fn measure(&mut self, measuring: &mut LineMeasurement) -> bool {
        let next = (self.first_pass.frequency(measuring.sums)).zip(measuring.rotations.next());
        let measured = self.count - measuring.earlier;
        if let (Some((frequency, turn)), Some(sums)) = (next, self.sums.get(measuring.sums)) {
            measuring.sums += 1;
            let line = sums.line(frequency, turn, self.resolution);
            let places =
                (self.lines.get_mut(self.count)).zip(measuring.deviations.get_mut(measured));
            if let (Some(line), Some((place, deviation))) = (line, places) {
                (*place, *deviation) = (line, line.deviation);
                self.count += 1;
            }
            return false;
        }
        if measuring.smoothed < measured {
            self.smooth(measuring);
            measuring.smoothed += 1;
            return false;
        }
        (measuring.earlier..self.count).for_each(|place| self.sort_in(place));
        true
    }

    /// Sorts a line into those before it, which are ordered by frequency.
    fn sort_in(&mut self, place: usize) {
        let Some(mut carried) = self.lines.get(place).copied() else {
            return;
        };
        let before = self.lines.get(..place).unwrap_or_default();
        let first = before.partition_point(|line| line.frequency <= carried.frequency);
        for line in self.lines.iter_mut().take(place + 1).skip(first) {
            core::mem::swap(line, &mut carried);
        }
    }

    /// The deviation of a line by its own and those of its neighbours.
    fn smooth(&mut self, measuring: &LineMeasurement) {
        let i = measuring.smoothed;
        let own = &measuring.deviations;
        let measured = self.lines.get_mut(measuring.earlier..self.count);
        let measured = measured.unwrap_or_default();
        let first = i.saturating_sub(NEIGHBOURS);
        let near = first..measured.len().min(i + 1 + NEIGHBOURS);
        let Some(&MeasuredLine { frequency, .. }) = measured.get(i) else {
            return;
        };
        // Noise of the increments that is white is one of 1/ω in the position.
        let mut deviations = [0.0; 2 * NEIGHBOURS + 1];
        let mut found = 0;
        let lines = measured.get(near.clone()).unwrap_or_default();
        let near = lines.iter().zip(own.get(near).unwrap_or_default());
        for (place, (other, deviation)) in deviations.iter_mut().zip(near) {
            *place = deviation * other.frequency / frequency;
            found += 1;
        }
        let median = median(deviations.get(..found).unwrap_or_default());
        if let Some(line) = measured.get_mut(i) {
            line.deviation = median.max(Self::OWN * line.deviation);
        }
    }
}

/// The middle one of a few; zero of none. A sort would have a panic for some targets.
fn median(values: &[f64]) -> f64 {
    let middle = values.len() / 2;
    let is_low = |one: &f64| {
        let below = values.iter().filter(|other| other.total_cmp(one).is_lt());
        below.count() <= middle
    };
    let low = values.iter().copied().filter(is_low);
    low.max_by(f64::total_cmp).unwrap_or(0.0)
}

impl<N: Number> BalanceSums<N> {
    fn take(&mut self, balance: &FrictionBalance<N>) {
        self.response_motions = self.response_motions.saturating_add(1);
        self.velocity += balance.velocity;
        self.acceleration += balance.acceleration;
        self.command += balance.command;
    }

    /// Mean velocity, acceleration and command; none of no motion.
    fn mean(&self) -> Option<[f64; 3]> {
        let sums = [self.velocity, self.acceleration, self.command];
        let response_motions = f64::from(self.response_motions);
        (self.response_motions > 0).then(|| sums.map(|sum| sum.to_f64() / response_motions))
    }
}

impl<N: Number> ResponseSums<N> {
    fn take(&mut self, sums: &LineSums<N>) {
        let [y, v] = sums.position;
        let [u, w] = sums.command;
        let sign = if sums.inverted { -N::ONE } else { N::ONE };
        self.response_motions = self.response_motions.saturating_add(1);
        self.position[0] += sign * y;
        self.position[1] += sign * v;
        self.command[0] += sign * u;
        self.command[1] += sign * w;
        self.powers[0] += y * y + v * v;
        self.powers[1] += u * u + w * w;
        self.cross[0] += y * u + v * w;
        self.cross[1] += v * u - y * w;
    }

    /// The response at a frequency, rad/s, whose phasor turns by `turn` in a sample. It is in rad per command unit,
    /// with its deviation.
    fn line(&self, frequency: f64, turn: Complex, resolution: f64) -> Option<MeasuredLine> {
        let complex = |[re, im]: [N; 2]| Complex {
            re: re.to_f64(),
            im: im.to_f64(),
        };
        let command = complex(self.command);
        if self.response_motions < 2 || command.power() == 0.0 {
            return None;
        }
        let gain = complex(self.position) / command;
        // ∑ |Y − G U|² over the motions: what the command does not explain.
        let [positions, commands] = self.powers.map(N::to_f64);
        let explained = 2.0 * (gain.conjugate() * complex(self.cross)).re - gain.power() * commands;
        let left = (positions - explained).max(0.0);
        let response_motions = f64::from(self.response_motions);
        let variance = left / (response_motions - 1.0) * response_motions / command.power();
        // Increments are (1 − z⁻¹) of positions.
        let increments = Complex::ONE - turn.conjugate();
        let gain = gain.scaled(resolution) / increments;
        let deviation = resolution * libm::sqrt(variance / increments.power());
        let known = gain.power().is_finite() && gain.power() > 0.0 && deviation.is_finite();
        known.then_some(MeasuredLine {
            frequency,
            gain,
            deviation,
        })
    }
}
