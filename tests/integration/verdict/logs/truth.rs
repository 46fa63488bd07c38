//! The true parameters of a drawn log.

use identifier_core::parameters::Parameter;
use integration_tests::logs::RecordedLog;

/// The range of a parameter of the true servo in its log, from the lowest to the highest value.
///
/// It is one value, the servo's own, except where the log has several, each of which is right:
/// - what drifts and steps has those from the beginning to the end of the record;
/// - of an inertia, a gain and a load that vary with the angle, or a gain with the sign of the command, the record
///   shows the mean over the angles and commands that are in it, which on small travel no identification can tell from
///   the servo's own; where the size of the command changes little, as a relay's, a gain that differs with its sign is
///   a load to any of them.
pub(super) fn truth(parameter: Parameter, log: &RecordedLog) -> [f64; 2] {
    let setup = &log.setup;
    let own = setup.servo.get(parameter);
    let samples = [setup.skipped, setup.skipped + setup.samples];
    let drifting = |rate: f64| samples.map(|sample| 1.0 + rate * sample as f64 * setup.sample_time);
    let in_time = match parameter {
        Parameter::A | Parameter::Coulomb => drifting(setup.effects.friction_drift),
        Parameter::B => drifting(setup.effects.gain_drift),
        Parameter::Load => [1.0, 1.0],
    };
    let shown = Shown::of(log);
    let means = match parameter {
        Parameter::B => shown.gains,
        Parameter::A | Parameter::Coulomb | Parameter::Load => shown.mobilities,
    };
    let factors = in_time
        .iter()
        .flat_map(|in_time| means.iter().map(move |mean| in_time * mean));
    let values: Vec<f64> = if parameter == Parameter::Load {
        let steps = setup.load_steps.iter().map(|step| own + step.load);
        let levels: Vec<f64> = steps
            .chain([own, own + shown.load, own + shown.load + shown.load_by_sign])
            .collect();
        let all = levels
            .iter()
            .flat_map(|level| means.map(|mean| mean * level));
        all.collect()
    } else {
        factors.map(|factor| own * factor).collect()
    };
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    [low, high]
}

/// Quantities that vary with angle and command, as a record shows them: the servo's own, the mean over the record, and
/// the mean over the record by the square of the command, which excites.
struct Shown {
    /// Gain over its own.
    gains: [f64; 3],
    /// Mean inertia over inertia.
    mobilities: [f64; 3],
    /// Mean load by the angle, rad/s².
    load: f64,
    /// Load that a gain by the command's sign is where the command has one size, rad/s²; else zero.
    load_by_sign: f64,
}

impl Shown {
    fn of(log: &RecordedLog) -> Self {
        let effects = &log.setup.effects;
        let (mut gains, mut mobilities) = (Mean::default(), Mean::default());
        /// Deviation of the command's size, of its mean, below which it has one.
        const ONE_SIZE: f64 = 0.2;
        let mut load = 0.0;
        let size = log
            .commands
            .iter()
            .map(|command| command.abs())
            .sum::<f64>()
            / log.commands.len() as f64;
        let squares = log
            .commands
            .iter()
            .map(|command| command * command)
            .sum::<f64>()
            / log.commands.len() as f64;
        let has_one_size = squares - size * size < (ONE_SIZE * size).powi(2);
        for (sample, command) in log.commands.iter().enumerate() {
            let angle = log.position(sample);
            let wave = |[sine, cosine]: [f64; 2], order: u32| {
                if sine == 0.0 && cosine == 0.0 {
                    return 0.0;
                }
                let (sin, cos) = (f64::from(order) * angle).sin_cos();
                sine * sin + cosine * cos
            };
            let mobility = 1.0 / (1.0 + wave(effects.inertia_variation, effects.inertia_order));
            let ripple = 1.0 + wave(effects.torque_ripple, effects.torque_ripple_order);
            let by_direction = 1.0 + effects.gain_asymmetry * command.signum();
            gains.add(mobility * ripple * by_direction, command * command);
            mobilities.add(mobility, command * command);
            load += wave(effects.gravity, 1) + wave(effects.ripple, effects.ripple_order);
        }
        Self {
            gains: gains.values(),
            mobilities: mobilities.values(),
            load: load / log.commands.len() as f64,
            load_by_sign: if has_one_size {
                log.setup.servo.b * effects.gain_asymmetry * size
            } else {
                0.0
            },
        }
    }
}

/// Means of a factor, plain and weighted.
#[derive(Default)]
struct Mean {
    count: f64,
    sum: f64,
    weight: f64,
    weighted: f64,
}

impl Mean {
    fn add(&mut self, factor: f64, weight: f64) {
        self.count += 1.0;
        // Deviations from one add up to nothing where there are none, without rounding.
        self.sum += factor - 1.0;
        self.weight += weight;
        self.weighted += weight * (factor - 1.0);
    }

    fn values(&self) -> [f64; 3] {
        let weighted = self.weighted / self.weight.max(f64::MIN_POSITIVE);
        [1.0, 1.0 + self.sum / self.count, 1.0 + weighted]
    }
}
