use super::model::{DAMPING, FRICTION, LAG, RATIO, ResponseModel, UNKNOWNS, Unknowns};
use identifier_core::number::Complex;
use identifier_core::replay::NormalEquations;
use identifier_core::tuning::MeasuredLine;

/// A pass over the measured lines with unknowns and their derivatives. It computes one response of one model at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponsePass {
    pub(super) unknowns: Unknowns,
    models: [ResponseModel; UNKNOWNS],
    own: ResponseModel,
    /// The unknowns that are fitted.
    pub(super) free: [bool; UNKNOWNS],
    line: usize,
    /// The unknown whose derivative comes next; none before the response itself.
    next: Option<usize>,
    gain: Complex,
    derivatives: [Complex; UNKNOWNS],
    pub(super) equations: NormalEquations<f64, UNKNOWNS>,
}

impl ResponsePass {
    /// Steps of the derivatives: small beside an unknown's standard error, large beside the digits of its response. Delay
    /// and lag are in samples, ζ and the share of the load are logarithms.
    const STEPS: Unknowns = [
        1e-5,
        Self::STEP,
        Self::STEP,
        1e-3,
        1e-6,
        Self::STEP,
        Self::STEP,
    ];
    const STEP: f64 = 1e-4;

    /// The least relative error of any model's response. Friction and speed are not as constant as in the model.
    const FLOOR: f64 = 0.03;

    /// The part of a measured response below which a smaller model response does not lower that error further.
    const NEARLY_NOTHING: f64 = 0.2;

    /// The error of a line, in deviations, above which it counts with its root.
    const OUTLIER: f64 = 4.0;

    /// The expected mean and deviation of an unknown: a current loop faster than the sampling, steel, any share.
    const EXPECTED: [(usize, f64, f64); 3] = [
        (LAG, 0.0, 6.0),
        // ln 0.02.
        (DAMPING, -3.912, 1.5),
        (RATIO, 0.0, 3.0),
    ];

    /// A pass at unknowns, with the expected viscous friction as its mean and deviation, 1/s. The deviation is zero
    /// if it is declared.
    pub(super) fn at(
        unknowns: &Unknowns,
        [friction, uncertain]: [f64; 2],
        two_masses: bool,
        sample_time: f64,
    ) -> Self {
        let model = |at: &Unknowns| ResponseModel::new(at, two_masses, sample_time);
        let mut equations = NormalEquations::EMPTY;
        let free = Self::free(two_masses, uncertain > 0.0);
        let viscous = [(FRICTION, friction, uncertain)];
        for (expected, mean, deviation) in Self::EXPECTED.into_iter().chain(viscous) {
            if free.get(expected) == Some(&true)
                && let Some(value) = unknowns.get(expected)
            {
                equations.expect(expected, 1.0 / deviation, mean - value);
            }
        }
        let own = model(unknowns);
        Self {
            unknowns: *unknowns,
            models: core::array::from_fn(|place| {
                let mut beside = *unknowns;
                if let (Some(value), Some(step)) = (beside.get_mut(place), Self::STEPS.get(place)) {
                    *value += step;
                }
                model(&beside)
            }),
            own,
            free,
            line: 0,
            next: None,
            gain: Complex::ONE,
            derivatives: [Complex { re: 0.0, im: 0.0 }; UNKNOWNS],
            equations,
        }
    }

    fn free(two_masses: bool, slowed: bool) -> [bool; UNKNOWNS] {
        core::array::from_fn(|place| match place {
            FRICTION => two_masses && slowed,
            _ => two_masses || place < FRICTION,
        })
    }

    /// One response; true once all lines are done.
    pub(super) fn work(&mut self, lines: &[MeasuredLine], sample_time: f64) -> bool {
        let Some(line) = lines.get(self.line) else {
            return true;
        };
        let angle = line.frequency * sample_time;
        let Some(place) = self.next else {
            self.gain = self.own.at(angle);
            self.next = Some(0);
            return false;
        };
        let is_free = |place: &usize| self.free.get(*place) == Some(&true);
        let place = (place..UNKNOWNS).find(is_free).unwrap_or(UNKNOWNS);
        if let (Some(model), Some(derivative), Some(step)) = (
            self.models.get(place),
            self.derivatives.get_mut(place),
            Self::STEPS.get(place),
        ) {
            *derivative = (model.at(angle) - self.gain).scaled(1.0 / step);
            self.next = Some(place + 1);
            return false;
        }
        self.add(line);
        self.line += 1;
        self.next = None;
        false
    }

    fn add(&mut self, line: &MeasuredLine) {
        let error = line.gain - self.gain;
        let size = line.gain.power();
        let between = libm::sqrt(size * self.gain.power());
        let floor = between.max(Self::NEARLY_NOTHING * Self::NEARLY_NOTHING * size);
        let variance = line.deviation * line.deviation + Self::FLOOR * Self::FLOOR * floor;
        let mut weight = 1.0 / libm::sqrt(variance);
        let outlying = libm::sqrt(error.power()) * weight;
        if outlying > Self::OUTLIER {
            weight *= libm::sqrt(Self::OUTLIER / outlying);
        }
        let real = self.derivatives.map(|derivative| weight * derivative.re);
        let imaginary = self.derivatives.map(|derivative| weight * derivative.im);
        self.equations.add(&real, weight * error.re);
        self.equations.add(&imaginary, weight * error.im);
    }
}
