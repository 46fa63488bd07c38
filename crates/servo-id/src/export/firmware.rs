//! A loop as constants for a firmware: certified and built here, so that the firmware links the samples alone.
//!
//! scenario with the estimates of a result → settings → the core's loop → words → sources.

use std::fmt::Write as _;

use host_sim::scenario::{Arithmetic, Estimator, Fault, ModelSet, Scenario, Velocity};
use host_sim::with_types;
use identifier_core::Settings;
use identifier_core::constants::{Configuration, words};
use identifier_core::control::{Shaped, Unshaped};
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{
    ExpectedMotion, GaussNewtonIdentifier, GaussNewtonRecursion, GradientIdentifier,
    IdentifiableSet, MachineEstimates, ServoLoop,
};
use identifier_core::measurement::VelocityEstimate;
use identifier_core::parameters::{AbLoad, Parameter, ParameterSet, PerParameter, Unknowns};
use identifier_core::settings::SettingsError;
use identifier_log::tune::IdentifiedResult;

use super::number;

/// The language of a firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Language {
    /// For `include!` beside the crate `identifier-core`.
    Rust,
    /// A header beside `servo_id.h`.
    C,
}

/// A configuration for a firmware.
#[derive(Debug, Clone, PartialEq)]
pub struct Firmware {
    language: Language,
    words: Vec<u32>,
    /// The SI values of machine estimates of one, in the order of [`Parameter::ALL`].
    si: [f64; 4],
    /// The type of the configuration in Rust.
    rust: String,
    /// The object of C, without the prefix.
    c: String,
    /// The words hold the servo that Gauss–Newton starts from too.
    has_servo: bool,
    has_loop: bool,
    /// The longest that the holding brake takes to open and to close, samples.
    brake: Option<[u32; 2]>,
    /// Sentences for a reader.
    remarks: Vec<String>,
}

/// What the constant of the brake means, in a firmware.
const BRAKE: &str = "The longest that the holding brake takes to open and to close, samples: hold the axis meanwhile.";

/// The words of a configuration, and the units of its estimates.
type Built = Result<(Vec<u32>, [f64; 4]), SettingsError>;

impl Firmware {
    /// The loop of a scenario, or its identifier alone if no controller is declared. It begins at the estimates of a
    /// result.
    ///
    /// # Errors
    /// The key of the scenario for which there is no such loop, with the remedy.
    pub fn new(
        mut scenario: Scenario,
        result: &IdentifiedResult,
        language: Language,
    ) -> Result<Self, Fault> {
        let law = scenario.identifier.law;
        refuse_what_has_no_form(&scenario, language)?;
        begin_at(&mut scenario, result);
        let settings = scenario.settings()?;
        let has_loop = settings.controller.is_some();
        let built = if law == Estimator::GaussNewton {
            let motion = expected_motion(&scenario, &settings, result)?;
            let start = Start {
                settings: &settings,
                servo: result,
                motion,
                language,
            };
            with_types!(scenario, f32 => gauss_newton(&start, has_loop))
        } else {
            match scenario.identifier.arithmetic {
                Arithmetic::Fixed => {
                    with_types!(scenario, Word => gradient::<Word>(&settings, has_loop, language))
                }
                _ => with_types!(scenario, f32 => gradient::<f32>(&settings, has_loop, language)),
            }
        };
        let (words, si) = built.map_err(|error| scenario.fault(&error))?;
        Ok(Self {
            language,
            words,
            si,
            rust: rust_type(&scenario, &settings),
            c: c_object(&scenario, has_loop),
            has_servo: law == Estimator::GaussNewton,
            has_loop,
            brake: scenario.brake.map(|brake| {
                // A cast saturates.
                brake.map(|time| (time / settings.sample_time).ceil() as u32)
            }),
            remarks: remarks(&scenario, &settings, result),
        })
    }

    /// The sources; in C the arrays are named after `name`, and `origin` is a sentence on where all is from.
    #[must_use]
    pub fn source(&self, name: &str, origin: &str) -> String {
        let mut lines = vec![origin.to_owned()];
        lines.extend(self.remarks.iter().cloned());
        lines.push(
            "Do not change a word here, it is refused: change the scenario and export again."
                .to_owned(),
        );
        match self.language {
            Language::Rust => self.rust_source(&lines),
            Language::C => self.c_source(name, &lines),
        }
    }

    fn rust_source(&self, lines: &[String]) -> String {
        let mut text = String::new();
        for line in lines {
            let _ = writeln!(text, "// {line}");
        }
        let own = if self.has_loop { "Loop" } else { "Identifier" };
        let name = own.to_uppercase();
        let built = if self.has_servo {
            format!("({own}, ::identifier_core::identifier::PreparedServo<f32>)")
        } else {
            own.to_owned()
        };
        let contents = match (self.has_loop, self.has_servo) {
            (true, false) => "The loop",
            (false, false) => "The identifier",
            (true, true) => "The loop, and the servo that its identifier starts from",
            (false, true) => "The identifier, and the servo that it starts from",
        };
        let [a, b, coulomb, load] = self.si.map(|unit| unit as f32);
        let _ = write!(
            text,
            "\n/// The type of the configuration.\npub type {own} = {};\n\n/// {contents}.\npub const {name}: \
             ::identifier_core::constants::Constants<{built}> =\n    \
             match ::identifier_core::constants::Constants::new(&[\n{}    ]) {{\n        \
             Ok(constants) => constants,\n        Err(error) => panic!(\"{{}}\", error.remedy()),\n    }};\n\n\
             /// SI values of machine estimates of one.\n\
             pub const SI: ::identifier_core::parameters::PerParameter<f32> =\n    \
             ::identifier_core::parameters::PerParameter {{\n        a: {a:?},\n        b: {b:?},\n        \
             coulomb: {coulomb:?},\n        load: {load:?},\n    }};\n",
            self.rust,
            rows(&self.words, "        ", ""),
        );
        if let Some(brake) = self.brake {
            let _ = write!(
                text,
                "\n/// {BRAKE}\npub const BRAKE: [u32; 2] = {brake:?};\n"
            );
        }
        text
    }

    fn c_source(&self, name: &str, lines: &[String]) -> String {
        let guard = format!("{}_WORDS_H", name.to_uppercase());
        let lines: Vec<String> = lines.iter().map(|line| line.replace("*/", "* /")).collect();
        // A word is an integer in C, of 30 fraction bits.
        let bit = if self.c.starts_with("fixed") {
            2.0_f64.powi(-30)
        } else {
            1.0
        };
        let si = self.si.map(|unit| format!("{:?}f", (unit * bit) as f32));
        let brake = self.brake.map_or_else(String::new, |[opens, closes]| {
            format!("/* {BRAKE} */\nstatic const uint32_t {name}_brake[2] = {{{opens}u, {closes}u}};\n\n")
        });
        format!(
            "/* {} */\n#ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n\n\
             /* For servo_id_{}_init_from_constants. */\nstatic const uint32_t {name}_words[{}] = {{\n{}}};\n\n\
             /* SI values of machine estimates of one: a, b, Coulomb friction, load. */\n\
             static const float {name}_si[4] = {{{}}};\n\n{brake}#endif\n",
            lines.join("\n * "),
            self.c,
            self.words.len(),
            rows(&self.words, "    ", "u"),
            si.join(", "),
        )
    }
}

/// Words in rows.
fn rows(words: &[u32], indent: &str, suffix: &str) -> String {
    /// Words in a row.
    const ROW: usize = 8;
    let row = |row: &[u32]| {
        let row: Vec<String> = row
            .iter()
            .map(|word| format!("{word:#010x}{suffix},"))
            .collect();
        format!("{indent}{}\n", row.join(" "))
    };
    words.chunks(ROW).map(row).collect()
}

/// True for the gradient, which is the paper's where nothing calls its memory.
fn is_gradient(law: Estimator) -> bool {
    matches!(law, Estimator::Gradient | Estimator::Paper)
}

/// Refuses what a loop of constants cannot be.
fn refuse_what_has_no_form(scenario: &Scenario, language: Language) -> Result<(), Fault> {
    let law = scenario.identifier.law;
    let is_gradient = is_gradient(law);
    if !is_gradient && law != Estimator::GaussNewton {
        let fault = format!(
            "\"{}\" does not run in a firmware: state \"gradient\" or \"gauss-newton\", here or in the firmware's \
             scenario, --scenario FIRMWARE.toml",
            law.name()
        );
        return Err(Fault::new("identifier.law", fault));
    }
    match scenario.identifier.arithmetic {
        Arithmetic::F64 => {
            let fault = "\"f64\" does not run in a firmware: state \"f32\", or \"fixed\" for a chip without an FPU";
            return Err(Fault::new("identifier.arithmetic", fault));
        }
        Arithmetic::Fixed if !is_gradient => {
            let fault = "\"fixed\" works only with law = \"gradient\": state \"f32\"";
            return Err(Fault::new("identifier.arithmetic", fault));
        }
        _ => {}
    }
    if is_gradient && scenario.stated.identifier.parameter_range.is_none() {
        let fault = "without a parameter range nothing is certified: state the lowest and highest a and b of the \
                     servo, such as servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }";
        return Err(Fault::new("identifier.servo_range", fault));
    }
    if scenario.has_terms() {
        let fault = "an exported loop has no optional terms: leave them out, or build the loop in the firmware";
        return Err(Fault::new("identifier.required_terms", fault));
    }
    if scenario.stated.identifier.terms.declares_amplifier() {
        let fault =
            "an exported loop has no declared amplifier: build it in the firmware, as Amplifier";
        return Err(Fault::new("amplifier", fault));
    }
    if language == Language::C {
        if scenario.velocity != Velocity::LowPass {
            let fault = "the library for C has only the velocity estimate \"low-pass\": state it, or export for Rust";
            return Err(Fault::new("controller.velocity_filter.kind", fault));
        }
        let allowed: &[ModelSet] = if is_gradient {
            &[ModelSet::Ab, ModelSet::AbCoulomb]
        } else {
            &[ModelSet::AbCoulombLoad]
        };
        if !allowed.contains(&scenario.model_set()) {
            let has = if is_gradient {
                "[\"a\", \"b\"] or [\"a\", \"b\", \"coulomb\"]"
            } else {
                "[\"a\", \"b\", \"coulomb\", \"load\"]"
            };
            let fault = format!(
                "the library for C has {has} for this estimator: state one of them, or export for Rust"
            );
            return Err(Fault::new("identifier.parameters", fault));
        }
    }
    Ok(())
}

/// The parameters of a scenario's model.
fn parameters(scenario: &Scenario) -> &'static [Parameter] {
    match scenario.model_set() {
        ModelSet::Ab => &Unknowns::<2>::PARAMETERS,
        ModelSet::AbCoulomb => &Unknowns::<3>::PARAMETERS,
        ModelSet::AbLoad => &AbLoad::PARAMETERS,
        ModelSet::AbCoulombLoad => &Unknowns::<4>::PARAMETERS,
    }
}

/// The estimates of a result as initial ones of those that the model has.
fn begin_at(scenario: &mut Scenario, result: &IdentifiedResult) {
    let parameters = parameters(scenario);
    let found = &result.model.servo.parameters;
    let initial = &mut scenario.stated.identifier.initial;
    let stated = *initial;
    *initial = PerParameter::from_fn(|parameter| match parameters.contains(&parameter) {
        true => Some(found.get(parameter)),
        false => stated.get(parameter),
    });
}

/// The motion in which Gauss–Newton continues: the bandwidth that is stated or that of the PID, and the command of a
/// step.
fn expected_motion(
    scenario: &Scenario,
    settings: &Settings,
    result: &IdentifiedResult,
) -> Result<ExpectedMotion, Fault> {
    /// The step of a usual command, rad: as that of a predicted response.
    const STEP: f64 = 0.1;
    let b = result.model.servo.parameters.b;
    let pid = settings.controller;
    let bandwidth = scenario.stated.identifier.bandwidth;
    let bandwidth = bandwidth.or(pid.map(|pid| (b * pid.kp).sqrt()));
    let Some(bandwidth) = bandwidth.filter(|bandwidth| bandwidth.is_finite()) else {
        let fault = "without a controller it is unknown: state the bandwidth of the position loop, rad/s, to within \
                     a factor of four";
        return Err(Fault::new("identifier.bandwidth", fault));
    };
    let asked = bandwidth * bandwidth * STEP / b;
    let most = pid.map_or(f64::INFINITY, |pid| pid.limit[1].max(-pid.limit[0]));
    Ok(ExpectedMotion {
        bandwidth,
        command: asked.min(most),
    })
}

/// A configuration with the machine units of its identifier, for a language.
fn written<T: Configuration, N: Copy>(
    configuration: &T,
    identifier: &impl MachineEstimates<N>,
    language: Language,
) -> (Vec<u32>, [f64; 4]) {
    let mut all = Vec::new();
    match language {
        Language::Rust => words(configuration, |word| all.push(word)),
        // Objects of C have room for what some of them know at their start.
        Language::C => words(&(*configuration, ()), |word| all.push(word)),
    }
    let si = Parameter::ALL.map(|parameter| identifier.machine_unit(parameter));
    (all, si)
}

/// True if the controller has more than a PID. An object of C has room for it.
fn is_shaped(settings: &Settings, language: Language) -> bool {
    let shaping = settings.controller.and_then(|pid| pid.shaping_setting());
    language == Language::C || shaping.is_some()
}

fn gradient<N, V, S, const P: usize>(
    settings: &Settings,
    has_loop: bool,
    language: Language,
) -> Built
where
    N: identifier_core::number::Arithmetic,
    V: VelocityEstimate<N> + Configuration,
    S: ParameterSet<P>,
    GradientIdentifier<N, V, S, P>: Configuration,
    ServoLoop<N, V, GradientIdentifier<N, V, S, P>>: Configuration,
    ServoLoop<N, V, GradientIdentifier<N, V, S, P>, Shaped<N>>: Configuration,
{
    if has_loop && is_shaped(settings, language) {
        let own: ServoLoop<N, V, GradientIdentifier<N, V, S, P>, Shaped<N>> = settings.build()?;
        return Ok(written(&own, own.identifier(), language));
    }
    if has_loop {
        let own: ServoLoop<N, V, GradientIdentifier<N, V, S, P>> = settings.build()?;
        return Ok(written(&own, own.identifier(), language));
    }
    let own: GradientIdentifier<N, V, S, P> = settings.build()?;
    Ok(written(&own, &own, language))
}

/// How Gauss–Newton starts.
struct Start<'a> {
    settings: &'a Settings,
    servo: &'a IdentifiedResult,
    motion: ExpectedMotion,
    language: Language,
}

fn gauss_newton<V, S, const P: usize>(start: &Start<'_>, has_loop: bool) -> Built
where
    V: VelocityEstimate<f32> + Configuration,
    S: IdentifiableSet<P> + ParameterSet<P>,
{
    type Loop<V, I, H> = ServoLoop<f32, V, I, H>;
    type Whole<S, const P: usize> = GaussNewtonIdentifier<f32, S, P>;
    let settings = start.settings;
    let own: GaussNewtonRecursion<f32, S, P> = settings.build()?;
    let known = own.prepare(&start.servo.model.servo, &start.motion);
    let mut all = Vec::new();
    let take = |word| all.push(word);
    // The object of C has room for a first fit too.
    match (start.language, has_loop) {
        (Language::Rust, false) => words(&(own, known), take),
        (Language::Rust, true) if is_shaped(settings, Language::Rust) => {
            let own: Loop<V, GaussNewtonRecursion<f32, S, P>, Shaped<f32>> = settings.build()?;
            words(&(own, known), take);
        }
        (Language::Rust, true) => {
            let own: Loop<V, GaussNewtonRecursion<f32, S, P>, Unshaped> = settings.build()?;
            words(&(own, known), take);
        }
        (Language::C, false) => words(&(settings.build::<Whole<S, P>>()?, known), take),
        (Language::C, true) => {
            let own: Loop<V, Whole<S, P>, Shaped<f32>> = settings.build()?;
            words(&(own, known), take);
        }
    }
    Ok((
        all,
        Parameter::ALL.map(|parameter| own.machine_unit(parameter)),
    ))
}

/// The type that the words are of in Rust.
fn rust_type(scenario: &Scenario, settings: &Settings) -> String {
    let is_fixed_point = scenario.identifier.arithmetic == Arithmetic::Fixed;
    let number = if is_fixed_point {
        "::identifier_core::fixed_point::Word"
    } else {
        "f32"
    };
    let measurement = "::identifier_core::measurement";
    let velocity = match scenario.velocity {
        Velocity::LowPass => format!("{measurement}::LowPass<{number}>"),
        Velocity::Difference => format!("{measurement}::BackwardDifference"),
        Velocity::AveragedDifference => format!("{measurement}::AveragedDifference<{number}>"),
    };
    let (set, parameters) = match scenario.model_set() {
        ModelSet::Ab => ("Unknowns<2>", 2),
        ModelSet::AbCoulomb => ("Unknowns<3>", 3),
        ModelSet::AbLoad => ("AbLoad", 3),
        ModelSet::AbCoulombLoad => ("Unknowns<4>", 4),
    };
    let set = format!("::identifier_core::parameters::{set}, {parameters}");
    let of = "::identifier_core::identifier";
    let identifier = match scenario.identifier.law {
        Estimator::GaussNewton => format!("{of}::GaussNewtonRecursion<{number}, {set}>"),
        _ => format!("{of}::GradientIdentifier<{number}, {velocity}, {set}>"),
    };
    let shaping = if is_shaped(settings, Language::Rust) {
        format!(", ::identifier_core::control::Shaped<{number}>")
    } else {
        String::new()
    };
    match settings.controller {
        Some(_) => format!("{of}::ServoLoop<{number}, {velocity}, {identifier}{shaping}>"),
        None => identifier,
    }
}

/// The object that the words are of in C.
fn c_object(scenario: &Scenario, has_loop: bool) -> String {
    let law = match (scenario.identifier.law, scenario.identifier.arithmetic) {
        (Estimator::GaussNewton, _) => "gauss_newton",
        (_, Arithmetic::Fixed) => "fixed",
        _ => "gradient",
    };
    let with_friction = law != "gauss_newton" && scenario.model_set() == ModelSet::AbCoulomb;
    let coulomb = if with_friction { "_coulomb" } else { "" };
    let closed = if has_loop { "_loop" } else { "" };
    format!("{law}{coulomb}{closed}")
}

/// Sentences on a loop for a reader.
fn remarks(scenario: &Scenario, settings: &Settings, result: &IdentifiedResult) -> Vec<String> {
    let found = &result.model.servo.parameters;
    let begins: Vec<String> = parameters(scenario)
        .iter()
        .map(|parameter| format!("{} = {}", parameter.name(), number(found.get(*parameter))))
        .collect();
    let mut lines = vec![format!(
        "Estimator {}, {}, a sample every {} s; it starts at {} (SI).",
        scenario.identifier.law.name(),
        scenario.identifier.arithmetic.name(),
        settings.sample_time,
        begins.join(", ")
    )];
    if let Some(pid) = settings.controller {
        let [low, high] = pid.limit;
        let filter = match pid.reference_filter {
            none if none <= 0.0 => String::new(),
            time_constant => format!(", filter of the reference {time_constant} s"),
        };
        let notch = match pid.notch {
            none if none <= 0.0 => String::new(),
            frequency => format!(", notch of the command at {frequency} rad/s"),
        };
        let led = pid.feed_forward.map_or_else(String::new, |led| {
            format!(", feed-forward at {} rad/s", led.bandwidth)
        });
        lines.push(format!(
            "PID: kp = {}, kd = {}, ki = {}, command {low} to {high}{filter}{notch}{led}.",
            pid.kp, pid.kd, pid.ki
        ));
    }
    if let Some(parameter_range) = settings.identifier.parameter_range
        && is_gradient(scenario.identifier.law)
    {
        let ([a_low, a_high], [b_low, b_high]) = (parameter_range.a, parameter_range.b);
        lines.push(format!(
            "Certified stable for every servo with a from {a_low} to {a_high} 1/s and b from {b_low} to {b_high}."
        ));
    }
    lines
}
