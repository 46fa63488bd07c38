use super::model::{
    DAMPING, DELAY, FREQUENCY, FRICTION, LAG, Place, RATIO, ResponseModel, UNKNOWNS, Unknowns, mode,
};
use identifier_core::number::Complex;
use identifier_core::replay::NormalEquations;
use identifier_core::tuning::{MeasuredLine, Mode};

/// A pass over the measured lines with unknowns and their derivatives. It computes one response of one model at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponsePass {
    pub(super) unknowns: Unknowns,
    /// The model of the unknowns, those beside it by a step of each, and how many of all are built.
    own: ResponseModel,
    models: [ResponseModel; UNKNOWNS],
    built: usize,
    /// The mode of the unknowns, and that of all beside it by a step.
    modes: [Mode; 2],
    /// The unknowns that are fitted.
    pub(super) free: [bool; UNKNOWNS],
    line: usize,
    /// The place of the line and the unknown whose derivative comes next; none before the response itself.
    next: Option<(Place, usize)>,
    gain: Complex<f32>,
    derivatives: [Complex<f32>; UNKNOWNS],
    pub(super) equations: NormalEquations<f64, UNKNOWNS>,
}

impl ResponsePass {
    /// Steps of the derivatives: small beside an unknown's standard error, large beside the digits of its response in
    /// single precision. Delay and lag are in samples, friction in 1/s, the others are logarithms. That of ω is far
    /// below the least ζ.
    const STEPS: Unknowns = [
        Self::STEP,
        Self::STEP,
        Self::STEP,
        0.1,
        3e-5,
        Self::STEP,
        Self::STEP,
    ];
    const STEP: f64 = 1e-3;

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
        friction: [f64; 2],
        two_masses: bool,
        sample_time: f64,
    ) -> Self {
        let own = ResponseModel::new(unknowns, two_masses, sample_time);
        let mut pass = Self {
            unknowns: *unknowns,
            own,
            models: [own; UNKNOWNS],
            built: 0,
            modes: [mode(unknowns); 2],
            free: [false; UNKNOWNS],
            line: 0,
            next: None,
            gain: Complex::ONE,
            derivatives: [Complex::ZERO; UNKNOWNS],
            equations: NormalEquations::default(),
        };
        pass.begin(unknowns, friction);
        pass.built = 1;
        pass
    }

    /// Begins another pass over the same masses.
    pub(super) fn begin(&mut self, unknowns: &Unknowns, [friction, uncertain]: [f64; 2]) {
        self.unknowns = *unknowns;
        self.free = Self::free(self.own.has_two_masses(), uncertain > 0.0);
        self.equations = NormalEquations::default();
        let viscous = [(FRICTION, friction, uncertain)];
        for (expected, mean, deviation) in Self::EXPECTED.into_iter().chain(viscous) {
            if self.free.get(expected) == Some(&true)
                && let Some(value) = unknowns.get(expected)
            {
                (self.equations).expect(expected, 1.0 / deviation, mean - value);
            }
        }
        (self.built, self.line, self.next) = (0, 0, None);
    }

    /// Builds the next model; false if all that are needed are built.
    fn builds(&mut self, sample_time: f64) -> bool {
        let two_masses = self.own.has_two_masses();
        let mut beside = self.unknowns;
        if self.built == 0 {
            self.own = ResponseModel::new(&beside, two_masses, sample_time);
            self.built = 1;
            return true;
        }
        let place = self.next_free(self.built - 1);
        self.built = place + 2;
        if let (Some(model), Some(value), Some(step)) = (
            self.models.get_mut(place),
            beside.get_mut(place),
            Self::STEPS.get(place),
        ) {
            *value += step;
            // What the unknown changes, and no more: a whole model of two masses takes a chip long.
            let [at, next] = self.modes;
            let with = |mode| {
                let delay = beside[DELAY] * sample_time;
                self.own.with_mode(delay, &mode, sample_time)
            };
            *model = match place {
                LAG => {
                    // With the little work of a lag, so that no model of a mode has it.
                    let next = core::array::from_fn(|i| self.unknowns[i] + Self::STEPS[i]);
                    self.modes = [&self.unknowns, &next].map(mode);
                    self.own.with_lag(beside[LAG])
                }
                FREQUENCY => with(Mode {
                    frequency: next.frequency,
                    ..at
                }),
                DAMPING => with(Mode {
                    damping: next.damping,
                    ..at
                }),
                RATIO => with(Mode {
                    ratio: next.ratio,
                    ..at
                }),
                _ => ResponseModel::new(&beside, two_masses, sample_time),
            };
            return true;
        }
        false
    }

    /// The next unknown that is fitted, from a place on.
    fn next_free(&self, place: usize) -> usize {
        let is_free = |place: &usize| self.free.get(*place) == Some(&true);
        (place..UNKNOWNS).find(is_free).unwrap_or(UNKNOWNS)
    }

    fn free(two_masses: bool, slowed: bool) -> [bool; UNKNOWNS] {
        core::array::from_fn(|place| match place {
            FRICTION => two_masses && slowed,
            _ => two_masses || place < FRICTION,
        })
    }

    /// One model, or one response; true once all lines are done.
    pub(super) fn work(&mut self, lines: &[MeasuredLine], sample_time: f64) -> bool {
        if self.built <= UNKNOWNS && self.builds(sample_time) {
            return false;
        }
        let Some(line) = lines.get(self.line) else {
            return true;
        };
        let Some((at, place)) = self.next else {
            let at = Place::of(line, sample_time);
            self.gain = self.own.at(&at);
            self.next = Some((at, 0));
            return false;
        };
        let place = self.next_free(place);
        if let (Some(model), Some(derivative), Some(step)) = (
            self.models.get(place),
            self.derivatives.get_mut(place),
            Self::STEPS.get(place),
        ) {
            *derivative = (model.at(&at) - self.gain).scaled(1.0 / *step as f32);
            self.next = Some((at, place + 1));
            return false;
        }
        self.add(line);
        self.line += 1;
        self.next = None;
        false
    }

    fn add(&mut self, line: &MeasuredLine) {
        let gain = self.gain.to();
        let error = line.gain - gain;
        let size = line.gain.power();
        let between = libm::sqrt(size * gain.power());
        let floor = between.max(Self::NEARLY_NOTHING * Self::NEARLY_NOTHING * size);
        let variance = line.deviation * line.deviation + Self::FLOOR * Self::FLOOR * floor;
        let mut weight = 1.0 / libm::sqrt(variance);
        let outlying = libm::sqrt(error.power()) * weight;
        if outlying > Self::OUTLIER {
            weight *= libm::sqrt(Self::OUTLIER / outlying);
        }
        let derivatives = self.derivatives.map(Complex::to::<f64>);
        let real = derivatives.map(|derivative| weight * derivative.re);
        let imaginary = derivatives.map(|derivative| weight * derivative.im);
        self.equations.add(&real, weight * error.re);
        self.equations.add(&imaginary, weight * error.im);
    }
}
