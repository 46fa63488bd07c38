//! The settings of the page, the scenario that they are, and its text for the command line.

use std::fmt::Write;

use host_sim::scenario::{
    Arithmetic, Estimator, ExcitationKind, ExcitationSettings, Fault, Purpose, Scenario,
};
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::settings::ControllerSettings;
use virtual_servo::faults::{FaultKind, InjectedFault};

/// The settings of the page, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The servo.
    pub servo: ServoParameters,
    /// Load that is added in the middle of the run, rad/s²; zero for none.
    pub load_step: f64,
    /// Time until a command acts, s.
    pub delay: f64,
    /// Resonance of motor and load on the shaft between them, rad/s; zero for a rigid one.
    pub resonance: f64,
    /// The load's share of the inertia, where there is a resonance.
    pub inertia_ratio: f64,
    /// Counts of the encoder per revolution.
    pub counts_per_rev: f64,
    /// The largest command, command units.
    pub limit: f64,
    /// kp, ki, kd.
    pub gains: [f64; 3],
    /// Sample time, s.
    pub sample_time: f64,
    /// Cut-off of the velocity estimate, rad/s.
    pub cutoff: f64,
    /// The reference.
    pub reference: PageReference,
    /// Its amplitude, rad: of noise the standard deviation.
    pub amplitude: f64,
    /// Its time, s: for which noise holds a value, of the slower sine and of a square wave the period.
    pub period: f64,
    /// Length of the run, s.
    pub duration: f64,
    /// Seed of the noise.
    pub seed: f64,
}

/// The references that the page offers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PageReference {
    /// Band-limited white noise.
    Noise,
    /// Two sines.
    Sines,
    /// A square wave.
    Square,
}

/// The ratio of the two sines' frequencies, which have no common period within a run.
const SECOND_SINE: f64 = 3.3;

impl Settings {
    /// The number of values that [`from_values`](Self::from_values) takes.
    pub const COUNT: usize = 20;

    /// From values in the order of the fields; none for another number of them or an unknown reference.
    #[must_use]
    pub fn from_values(values: &[f64]) -> Option<Self> {
        const REFERENCES: [PageReference; 3] = [
            PageReference::Noise,
            PageReference::Sines,
            PageReference::Square,
        ];
        if values.len() != Self::COUNT {
            return None;
        }
        let mut rest = values.iter().copied();
        let mut next = || rest.next();
        Some(Self {
            servo: ServoParameters::new(next()?, next()?, next()?, next()?),
            load_step: next()?,
            delay: next()?,
            resonance: next()?,
            inertia_ratio: next()?,
            counts_per_rev: next()?,
            limit: next()?,
            gains: [next()?, next()?, next()?],
            sample_time: next()?,
            cutoff: next()?,
            reference: *REFERENCES.get(next()? as usize)?,
            amplitude: next()?,
            period: next()?,
            duration: next()?,
            seed: next()?,
        })
    }

    fn excitation(&self) -> ExcitationSettings {
        let none = ExcitationSettings::default();
        match self.reference {
            PageReference::Noise => ExcitationSettings {
                kind: ExcitationKind::BandLimitedWhiteNoise,
                power: self.amplitude * self.amplitude * self.period,
                sample_time: self.period,
                seed: self.seed as u32,
                ..none
            },
            PageReference::Sines => {
                let slow = std::f64::consts::TAU / self.period;
                ExcitationSettings {
                    kind: ExcitationKind::Multisine,
                    amplitudes: vec![self.amplitude, 0.5 * self.amplitude],
                    frequencies: vec![slow, SECOND_SINE * slow],
                    ..none
                }
            }
            PageReference::Square => ExcitationSettings {
                kind: ExcitationKind::Square,
                amplitude: self.amplitude,
                period: self.period,
                ..none
            },
        }
    }

    /// The scenario of these settings.
    ///
    /// # Errors
    /// The key that is not allowed.
    pub fn scenario(&self) -> Result<Scenario, Fault> {
        let mut scenario = Scenario::blank(Purpose::Run);
        scenario.plant = Some(self.servo);
        scenario.effects.delay = self.delay;
        if self.resonance > 0.0 {
            scenario.effects.resonance = self.resonance;
            scenario.effects.inertia_ratio = self.inertia_ratio;
        }
        scenario.set_encoder(self.counts_per_rev);
        let [kp, ki, kd] = self.gains;
        let mut controller = ControllerSettings::pid(kp, kd, ki);
        controller.limit = [-self.limit, self.limit];
        scenario.stated.controller = Some(controller);
        scenario.stated.sample_time = self.sample_time;
        scenario.stated.cutoff = self.cutoff;
        scenario.excitation = self.excitation();
        scenario.identifier.set_estimator(Estimator::GaussNewton);
        scenario.identifier.parameters = Parameter::ALL.to_vec();
        scenario.identifier.arithmetic = Arithmetic::F32;
        scenario.duration = self.duration;
        if self.load_step != 0.0 {
            let step =
                InjectedFault::lasting(FaultKind::LoadStep, 0.5 * self.duration, self.load_step);
            scenario.faults.push(step);
        }
        scenario.checked(Purpose::Run)
    }

    /// The text of the scenario, for the command line. It is written here because a page without the table of keys is
    /// smaller.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = "# From the playground.\n#\n#   servo-id run THIS.toml       the same run, the same bits\n".to_owned();
        let mut table = |name: &str, values: &[(&str, String)]| {
            let _ = writeln!(text, "\n[{name}]");
            for (key, value) in values {
                let _ = writeln!(text, "{key} = {value}");
            }
        };
        let number = |value: f64| format!("{value:?}");
        let value = |one: Parameter| (one.name(), number(self.servo.get(one)));
        let mut plant = Parameter::ALL.map(value).to_vec();
        if self.delay > 0.0 {
            plant.push(("delay", number(self.delay)));
        }
        if self.resonance > 0.0 {
            plant.push(("resonance", number(self.resonance)));
            plant.push(("inertia_ratio", number(self.inertia_ratio)));
        }
        table("plant", &plant);
        table(
            "encoder",
            &[("counts_per_rev", number(self.counts_per_rev))],
        );
        table("amplifier", &[("limit", number(self.limit))]);
        let [kp, ki, kd] = self.gains;
        let filter = format!("{{ kind = \"low-pass\", cutoff = {:?} }}", self.cutoff);
        table(
            "controller",
            &[
                ("kp", number(kp)),
                ("ki", number(ki)),
                ("kd", number(kd)),
                ("sample_time", number(self.sample_time)),
                ("velocity_filter", filter),
            ],
        );
        let excitation = self.excitation();
        let kind = ("kind", format!("\"{}\"", excitation.kind.name()));
        let own = match self.reference {
            PageReference::Noise => vec![
                kind,
                ("power", number(excitation.power)),
                ("sample_time", number(excitation.sample_time)),
                ("seed", excitation.seed.to_string()),
            ],
            PageReference::Sines => vec![
                kind,
                ("amplitudes", format!("{:?}", excitation.amplitudes)),
                ("frequencies", format!("{:?}", excitation.frequencies)),
            ],
            PageReference::Square => vec![
                kind,
                ("amplitude", number(excitation.amplitude)),
                ("period", number(excitation.period)),
            ],
        };
        table("excitation", &own);
        table(
            "identifier",
            &[
                ("law", "\"gauss-newton\"".to_owned()),
                (
                    "parameters",
                    "[\"a\", \"b\", \"coulomb\", \"load\"]".to_owned(),
                ),
                ("arithmetic", "\"f32\"".to_owned()),
            ],
        );
        table("run", &[("duration", number(self.duration))]);
        if self.load_step != 0.0 {
            table(
                "[fault]",
                &[
                    ("kind", "\"load-step\"".to_owned()),
                    ("time", number(0.5 * self.duration)),
                    ("size", number(self.load_step)),
                ],
            );
        }
        text
    }
}
