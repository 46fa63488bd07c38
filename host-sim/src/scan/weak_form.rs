//! The response of a motion to an input, by regression in weak form: no model is run, no estimate is needed.
//!
//! With a smooth window g of half-width h that is zero at its ends, integration by parts makes of
//! q̈ = −a q̇ + b u(t − τ) − c sign q̇ + d
//!
//! ∫g̈ q = a ∫ġ q + b ∫g u − b τ ∫ġ u − c ∫g sign q̇ + d ∫g,
//!
//! which is linear in a, b, bτ, c and d and has no derivative of a measurement. Forces that go with the position are
//! taken up by its powers and by its sine and cosine. The window is (1 − x²)³, as in the modulating-function method
//! (M. Shinbrot, 1957; H. Preisig and D. Rippin, 1993).

/// A motion and the input that is to explain it, of a range without a break.
#[derive(Debug, Clone, Copy)]
pub(super) struct Signals<'a> {
    /// The motion.
    pub(super) output: &'a [f64],
    /// The input, each value of which acts until the next.
    pub(super) input: &'a [f64],
}

/// The derivative of the motion that the input is to explain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// The output is a velocity.
    First,
    /// The output is a position.
    Second,
}

/// The terms beside friction and a constant that may explain the motion, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beside {
    /// None.
    Nothing,
    /// Forces that go with the position: gravity, springs, cogging of one period per revolution.
    Place,
}

/// The response to an input at one width of the window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Response {
    /// Half the width of the window, samples.
    pub(super) half_width: usize,
    /// The gain of the input, output units per sample to the order, for an input of one.
    pub(super) gain: f64,
    /// The gain over its standard error, which is from the scatter between groups of windows.
    pub(super) significance: f64,
    /// The part that the input explains of what the other terms leave.
    pub(super) explained: f64,
    /// The part of the derivative's variance that all terms explain.
    pub(super) total: f64,
    /// The delay of the input, samples.
    pub(super) delay: f64,
}

/// The widths of the window: the ratio from one to the next.
const RATIO: f64 = 1.6;
/// Half the smallest width, samples.
const MIN_HALF_WIDTH: f64 = 4.0;
/// Half the largest width: of a segment, this part, and samples.
const MAX_HALF_WIDTHS: (f64, f64) = (0.05, 1500.0);
/// Windows to half a width.
const WINDOWS_PER_HALF_WIDTH: usize = 3;
/// The most windows of one width, and the fewest that count.
const MAX_WINDOWS: usize = 12_000;
const MIN_WINDOWS: usize = 60;
/// Groups of windows, between which a gain scatters.
const GROUPS: usize = 20;

/// The responses at all widths for which there is enough motion; `noise` is the output's, rms.
pub(super) fn responses(
    segments: &[Signals<'_>],
    noise: f64,
    order: Order,
    beside: Beside,
) -> Vec<Response> {
    let longest = (segments.iter().map(|of| of.output.len())).max();
    let longest = longest.unwrap_or(0) as f64;
    let widest = (MAX_HALF_WIDTHS.0 * longest).min(MAX_HALF_WIDTHS.1);
    let widths = std::iter::successors(Some(MIN_HALF_WIDTH), |width| Some(width * RATIO));
    let widths: Vec<f64> = widths.take_while(|width| *width <= widest).collect();
    let responses = log_fit::parallel::map(&widths, |&width| {
        let mut equations = Equations::new(order, beside);
        let window = Window::new(width as usize);
        equations.fill(segments, &window, noise);
        equations.solve(&window)
    });
    responses.flatten().collect()
}

/// The window and its derivatives at the samples, per sample.
struct Window {
    half_width: usize,
    /// g, −ġ and g̈ at a position sample.
    at: Vec<[f64; 3]>,
    /// g and −ġ in the middle between two samples, for the input, which is held.
    between: Vec<[f64; 2]>,
}

impl Window {
    fn new(half_width: usize) -> Self {
        let h = half_width as f64;
        let derivatives = |place: f64| {
            let x = place / h;
            let rest = 1.0 - x * x;
            [
                rest.powi(3),
                6.0 * x * rest * rest / h,
                (-6.0 * rest * rest + 24.0 * x * x * rest) / (h * h),
            ]
        };
        let places = 0..=2 * half_width;
        let at = places.map(|k| derivatives(k as f64 - h));
        let between = (0..2 * half_width).map(|k| {
            let [g, slope, _] = derivatives(k as f64 + 0.5 - h);
            [g, slope]
        });
        Self {
            half_width,
            at: at.collect(),
            between: between.collect(),
        }
    }
}

/// The equations of all windows of one width.
struct Equations {
    order: Order,
    beside: Beside,
    /// The columns of the terms beside the input, of the input and its derivative, and of what they explain.
    beside_columns: Vec<Vec<f64>>,
    input: Vec<f64>,
    input_slope: Vec<f64>,
    explained: Vec<f64>,
}

impl Equations {
    fn new(order: Order, beside: Beside) -> Self {
        let count = match beside {
            Beside::Nothing => 3,
            Beside::Place => 8,
        };
        Self {
            order,
            beside,
            beside_columns: vec![Vec::new(); count],
            input: Vec::new(),
            input_slope: Vec::new(),
            explained: Vec::new(),
        }
    }

    fn fill(&mut self, segments: &[Signals<'_>], window: &Window, noise: f64) {
        let samples: usize = segments.iter().map(|of| of.output.len()).sum();
        let half = window.half_width;
        let stride = (half / WINDOWS_PER_HALF_WIDTH)
            .max(samples / MAX_WINDOWS)
            .max(1);
        let (low, high) = (segments.iter()).fold(crate::log::extremes(&[]), |(low, high), of| {
            let (lowest, highest) = crate::log::extremes(of.output);
            (low.min(lowest), high.max(highest))
        });
        let (middle, reach) = (0.5 * (low + high), 0.5 * (high - low));
        for of in segments {
            let last = of.output.len().saturating_sub(half + 1);
            for centre in (half..last).step_by(stride) {
                self.add(of, centre, window, noise);
                if self.beside == Beside::Place {
                    let position = of.output[centre];
                    let place = (position - middle) / reach;
                    let powers = [place, place * place, place * place * place];
                    let (sine, cosine) = position.sin_cos();
                    let terms = powers.into_iter().chain([sine, cosine]);
                    for (column, term) in self.beside_columns[3..].iter_mut().zip(terms) {
                        column.push(term);
                    }
                }
            }
        }
    }

    /// The equation of a window about a centre.
    fn add(&mut self, of: &Signals<'_>, centre: usize, window: &Window, noise: f64) {
        /// Speeds below this many standard deviations of their noise have no sign.
        const MIN_SPEED: f64 = 3.0;
        let half = window.half_width;
        let outputs = &of.output[centre - half..=centre + half];
        let origin = of.output[centre];
        let (mut mean, mut slope, mut bend, mut weight) = (0.0, 0.0, 0.0, 0.0);
        for (output, [g, g1, g2]) in outputs.iter().zip(&window.at) {
            let output = output - origin;
            mean += g * output;
            slope += g1 * output;
            bend += g2 * output;
            weight += g;
        }
        // Signs of the speed between samples a quarter of the window apart.
        let reach = (half / 4).max(1);
        let threshold = MIN_SPEED * std::f64::consts::SQRT_2 * noise;
        // Without a branch, whose prediction fails at the turns of the motion.
        let sign = |output: f64| {
            f64::from(u8::from(output > threshold)) - f64::from(u8::from(output < -threshold))
        };
        let inputs = &of.input[centre - half..centre + half];
        let (mut push, mut push_slope, mut signs) = (0.0, 0.0, 0.0);
        for (k, (input, [g, g1])) in inputs.iter().zip(&window.between).enumerate() {
            push += g * input;
            push_slope += g1 * input;
            signs += g * match self.order {
                Order::First => sign(outputs[k]),
                Order::Second => {
                    let (from, to) = (k.saturating_sub(reach), (k + 1 + reach).min(2 * half));
                    sign(outputs[to] - outputs[from])
                }
            };
        }
        let (explained, drag) = match self.order {
            Order::First => (slope, mean / weight + origin),
            Order::Second => (bend, slope / weight),
        };
        self.explained.push(explained / weight);
        self.input.push(push / weight);
        self.input_slope.push(push_slope / weight);
        let terms = [1.0, drag, signs / weight];
        for (column, term) in self.beside_columns.iter_mut().zip(terms) {
            column.push(term);
        }
    }

    /// The response to the input beside all other terms; none from too few windows, or where the input does not
    /// differ from them.
    fn solve(self, window: &Window) -> Option<Response> {
        /// Part of a column that must be left when the others are taken out of it.
        const MIN_LEFT: f64 = 1e-7;
        /// Longest delay, part of half the window.
        const MAX_DELAY: f64 = 0.5;
        let count = self.explained.len();
        if count < MIN_WINDOWS {
            return None;
        }
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let add = |basis: &mut Vec<Vec<f64>>, mut column: Vec<f64>| {
            let before = norm(&column);
            remove(&mut column, basis);
            let left = norm(&column);
            let is_new = left > MIN_LEFT * before && left.is_normal();
            if is_new {
                column.iter_mut().for_each(|x| *x /= left);
                basis.push(column);
            }
        };
        let mut columns = self.beside_columns.into_iter();
        add(&mut basis, columns.next()?);
        let mut all = self.explained.clone();
        remove(&mut all, &basis);
        let variance = norm(&all).powi(2);
        columns.for_each(|column| add(&mut basis, column));
        let mut slope = self.input_slope;
        let mut input = self.input;
        let whole = norm(&input);
        remove(&mut slope, &basis);
        remove(&mut input, &basis);
        let mut explained = self.explained;
        remove(&mut explained, &basis);
        let before = norm(&explained).powi(2);
        // Gain and slope together; their product is the delay.
        let [uu, us, ss] = [
            dot(&input, &input),
            dot(&input, &slope),
            dot(&slope, &slope),
        ];
        let determinant = uu * ss - us * us;
        if norm(&input) <= MIN_LEFT * whole || determinant <= 1e-12 * uu * ss {
            return None;
        }
        let [uy, sy] = [dot(&input, &explained), dot(&slope, &explained)];
        let gain = (ss * uy - us * sy) / determinant;
        let slope_gain = (uu * sy - us * uy) / determinant;
        let delay = -slope_gain / gain;
        // A slope is a delay where it is short beside the window.
        let is_delay = delay.abs() < MAX_DELAY * window.half_width as f64;
        let [gain, slope_gain, delay, shared] = match is_delay {
            true => [gain, slope_gain, delay, us / ss],
            false => [uy / uu, 0.0, 0.0, 0.0],
        };
        // The input less what its slope says of it.
        let own: Vec<f64> = (input.iter().zip(&slope))
            .map(|(u, s)| u - shared * s)
            .collect();
        let left: Vec<f64> = (explained.iter().zip(&input).zip(&slope))
            .map(|((y, u), s)| y - gain * u - slope_gain * s)
            .collect();
        let group = count.div_ceil(GROUPS);
        let scores: f64 = (own.chunks(group).zip(left.chunks(group)))
            .map(|(own, left)| dot(own, left).powi(2))
            .sum();
        let groups = count.div_ceil(group) as f64;
        let std_error = (scores * groups / (groups - 1.0)).sqrt() / dot(&own, &own);
        let after = norm(&left).powi(2);
        Some(Response {
            half_width: window.half_width,
            gain,
            significance: gain / std_error.max(f64::MIN_POSITIVE),
            explained: 1.0 - after / before.max(f64::MIN_POSITIVE),
            total: 1.0 - after / variance.max(f64::MIN_POSITIVE),
            delay,
        })
    }
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

fn norm(column: &[f64]) -> f64 {
    dot(column, column).sqrt()
}

/// Takes the part of a column that lies in an orthonormal basis out of it, twice for the sake of rounding.
fn remove(column: &mut [f64], basis: &[Vec<f64>]) {
    for of in basis.iter().chain(basis) {
        let part = dot(column, of);
        for (x, of) in column.iter_mut().zip(of) {
            *x -= part * of;
        }
    }
}
