use super::model::{Place, ResponseModel, Unknowns};
use identifier_core::replay::NormalEquations;
use identifier_core::tuning::{MeasuredLine, Mode, PossibleServo};

/// A scan of the frequencies at which a second mass may resonate. With frequency, damping and delay given, the response
/// is linear in b and β b. One mass gives x, and two with β = 1 give y: b = x + y, β b = y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scan {
    a: f64,
    delay: f64,
    /// The lowest frequency, rad/s, and the ratio of successive ones.
    lowest: f64,
    ratio: f64,
    place: u32,
    /// The frequency of that place, rad/s.
    frequency: f64,
    line: usize,
    /// The models of one mass, and of two at the place.
    one: Option<ResponseModel>,
    two: Option<ResponseModel>,
    equations: NormalEquations<f64, 2>,
    starts: Starts,
}

/// Unknowns from which two masses are fitted, those of the smallest cost first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Starts {
    all: [Option<Start>; Self::MOST],
    next: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Start {
    place: u32,
    cost: f64,
    frequency: f64,
    gain: f64,
    ratio: f64,
}

impl Scan {
    /// The frequencies.
    const FREQUENCIES: u32 = 48;

    /// The range, over the lowest and the highest line. A resonance beyond the lines shows in their phase. It may also
    /// show as an image below half of the sampling frequency.
    const RANGE: [f64; 2] = [0.9, 1.3];

    /// The damping ratio of them all: a resonance as wide as the lines are apart.
    const DAMPING: f64 = 0.03;

    /// The relative error with which each line counts: the response of a scan is rough.
    const ROUGH: f64 = 0.1;

    pub(super) fn begin(lines: &[MeasuredLine], a: f64, delay: f64) -> Self {
        let [below, beyond] = Self::RANGE;
        let lowest = below * lines.first().map_or(1.0, |line| line.frequency);
        let highest = beyond * lines.last().map_or(2.0, |line| line.frequency);
        let ratio = libm::exp(libm::log(highest / lowest) / f64::from(Self::FREQUENCIES - 1));
        Self {
            a,
            delay,
            lowest,
            ratio,
            place: 0,
            frequency: lowest,
            line: 0,
            one: None,
            two: None,
            equations: NormalEquations::default(),
            starts: Starts {
                all: [None; Starts::MOST],
                next: 0,
            },
        }
    }

    /// One model, or the responses of one line; the starts once all frequencies are done.
    pub(super) fn work(&mut self, lines: &[MeasuredLine], sample_time: f64) -> Option<Starts> {
        if self.place >= Self::FREQUENCIES {
            return Some(self.starts);
        }
        let [delay, lag] = delay_and_lag(self.delay);
        let servo = PossibleServo {
            a: self.a,
            b: 1.0,
            delay: delay * sample_time,
        };
        let Some(one) = &self.one else {
            self.one = Some(ResponseModel::of(&servo, lag, sample_time));
            return None;
        };
        let Some(two) = &self.two else {
            let mode = Mode {
                frequency: self.frequency,
                damping: Self::DAMPING,
                ratio: 1.0,
            };
            self.two = Some(one.with_mode(servo.delay, &mode, sample_time));
            self.equations = NormalEquations::default();
            self.line = 0;
            return None;
        };
        if let Some(line) = lines.get(self.line) {
            let place = Place::of(line, sample_time);
            let [one, two] = [one, two].map(|model| model.at(&place).to::<f64>());
            let rough = Self::ROUGH * Self::ROUGH * line.gain.power();
            let weight = 1.0 / libm::sqrt(line.deviation * line.deviation + rough);
            let row = |one: f64, two: f64| [weight * one, weight * two];
            self.equations
                .add(&row(one.re, two.re), weight * line.gain.re);
            self.equations
                .add(&row(one.im, two.im), weight * line.gain.im);
            self.line += 1;
            return None;
        }
        let free = [true; 2];
        let [one, two] = self.equations.solve(0.0, &free);
        let (gain, ratio) = (one + two, two / (one + two));
        if gain > 0.0 && ratio > 0.0 {
            let cost = self.equations.cost() - self.equations.explained_by(&free);
            self.starts.take(Start {
                place: self.place,
                cost,
                frequency: self.frequency,
                gain,
                ratio,
            });
        }
        self.place += 1;
        self.frequency *= self.ratio;
        self.two = None;
        None
    }
}

impl Starts {
    /// Starts that are kept.
    const MOST: usize = 3;

    /// Frequencies between two of them, at least.
    const APART: u32 = 3;

    /// Keeps a start if it is among the best, and of near ones the best alone.
    fn take(&mut self, start: Start) {
        let is_near = |other: &Start| other.place.abs_diff(start.place) < Self::APART;
        let cost = |place: &Option<Start>| place.map_or(f64::INFINITY, |start| start.cost);
        let near = self
            .all
            .iter_mut()
            .find(|place| place.as_ref().is_some_and(is_near));
        let worst = match near {
            Some(near) => Some(near),
            None => self
                .all
                .iter_mut()
                .max_by(|one, other| cost(one).total_cmp(&cost(other))),
        };
        if let Some(worst) = worst.filter(|worst| start.cost < cost(worst)) {
            *worst = Some(start);
        }
        let by_cost =
            |one: &Option<Start>, other: &Option<Start>| cost(one).total_cmp(&cost(other));
        self.all.sort_unstable_by(by_cost);
    }

    /// The unknowns of the next start, of a servo with this friction, 1/s, and delay, samples.
    pub(super) fn next(&mut self, a: f64, delay: f64) -> Option<Unknowns> {
        let start = self.all.get(self.next).copied().flatten();
        self.next += 1;
        let [delay, lag] = delay_and_lag(delay);
        start.map(|start| {
            [
                libm::log(start.gain),
                delay,
                lag,
                a,
                libm::log(start.frequency),
                libm::log(Scan::DAMPING),
                libm::log(start.ratio),
            ]
        })
    }
}

/// A delay (samples) in parts from which a fit begins: delay and lag. Without lag it would stay so, as a small one changes the
/// response as a delay does.
pub(super) fn delay_and_lag(delay: f64) -> [f64; 2] {
    let lag = (0.5 * delay).clamp(0.1, 1.0);
    [(delay - lag).max(0.0), lag]
}
