//! From tables to validated settings.

use identifier_core::control::{CommandLimit, Gains};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::excitation::Tone;
use identifier_core::fixed_point::Ranges;
use identifier_core::identifier::{Bounds, Uncertainty};
use identifier_core::interval::Interval;
use identifier_core::model::ServoParameters;
use identifier_core::parameters::Parameter;
use identifier_core::stability::PlantBox;
use identifier_core::units::Units;

use super::error::Fault;
use super::tables::{self, ExcitationKind, LawName, NumberOrRow, Tables, VelocityKind};
use super::{
    Arithmetic, Baseline, BaselineSettings, CompareSettings, ControllerSettings,
    ExcitationSettings, GradientSettings, IdentifierSettings, Law, LogSettings, Purpose, Scenario,
    VelocitySettings, WindowSettings,
};

/// Sines that a multisine and levels that a staircase may have.
pub(crate) const MOST_ENTRIES: usize = 16;

/// The longest run, control samples.
const MOST_SAMPLES: f64 = 1e10;

/// The position unit of an ideal sensor, rad: as of an encoder that is finer than any effect.
const IDEAL_UNIT: f64 = 1e-5;

pub(super) fn scenario(tables: &Tables, purpose: Purpose) -> Result<Scenario, Fault> {
    let counts_per_rev = match (&tables.encoder, purpose) {
        (Some(encoder), _) => counts_per_rev(encoder)?,
        (None, Purpose::Run) => counts_per_rev(&tables::Encoder::default())?,
        (None, Purpose::Replay) => None,
    };
    let controller = controller(&tables.controller, counts_per_rev)?;
    let sample_time = controller.units.sample_time();
    let duration = Allowed::Within(sample_time, MOST_SAMPLES * sample_time)
        .check("duration", tables.run.duration)
        .map_err(under("run"))?;
    let plant = tables.plant.as_ref().map(plant).transpose()?;
    match purpose {
        Purpose::Run if plant.is_none() => {
            return Err(Fault::new("plant", "a run needs the true servo"));
        }
        Purpose::Replay if tables.log.is_none() => {
            return Err(Fault::new(
                "log",
                "a replay needs to know the columns of the log",
            ));
        }
        _ => {}
    }
    let limit = limit(&tables.amplifier)?;
    let command = limit.high().min(-limit.low()).min(controller.gains.kp());
    let scenario = Scenario {
        plant,
        counts_per_rev,
        limit,
        controller,
        excitation: excitation(&tables.excitation)?,
        identifier: identifier(&tables.identifier, sample_time, command)?,
        duration,
        log: tables.log.as_ref().map(log),
        compare: compare(&tables.compare)?,
    };
    // A replay knows its units and its reference only once the log is read.
    match purpose {
        Purpose::Run => {
            let scenario = scenario.in_own_loop();
            scenario.try_parts()?;
            Ok(scenario)
        }
        Purpose::Replay if !scenario.identifier.law.is_replayable() => Err(Fault::new(
            "identifier.law",
            format!(
                "\"{}\" works in a loop of its own and cannot take a log: {} can",
                scenario.identifier.law.name(),
                Law::REPLAYABLE
            ),
        )),
        Purpose::Replay if scenario.identifier.arithmetic == Arithmetic::Fixed => Err(Fault::new(
            "identifier.arithmetic",
            "a log is replayed in \"f32\" or \"f64\"; `drift` shows what fixed point makes of a run",
        )),
        Purpose::Replay => Ok(scenario),
    }
}

fn log(table: &tables::Log) -> LogSettings {
    LogSettings {
        time: table.time.clone(),
        reference: table.reference.clone(),
        position: table.position.clone(),
        command: table.command.clone(),
        injection: table.injection.clone(),
        bridge: table.bridge_gaps,
    }
}

fn compare(table: &tables::Compare) -> Result<CompareSettings, Fault> {
    /// Counts of an encoder that counts as coarse.
    const COARSE: f64 = 2000.0;
    let counts_per_rev = table.counts_per_rev.unwrap_or(COARSE);
    let positive = |name, value: Option<f64>| {
        value
            .map(|value| Allowed::Above(0.0).check(name, value))
            .transpose()
    };
    let checked = || {
        Ok(CompareSettings {
            load: table
                .load
                .map(|load| Allowed::Finite.check("load", load))
                .transpose()?,
            coulomb: table
                .coulomb
                .map(|coulomb| Allowed::AtLeast(0.0).check("coulomb", coulomb))
                .transpose()?,
            counts_per_rev: Allowed::Above(0.0).check("counts_per_rev", counts_per_rev)?,
            limit: positive("limit", table.limit)?,
        })
    };
    checked().map_err(under("compare"))
}

/// Puts the table before the name of a parameter of the core.
fn under(table: &str) -> impl Fn(OutOfRange) -> Fault {
    move |error| Fault::new(format!("{table}.{}", error.parameter), error)
}

fn plant(table: &tables::Plant) -> Result<ServoParameters, Fault> {
    let checked = || {
        Ok(ServoParameters {
            a: Allowed::AtLeast(0.0).check("a", table.a)?,
            b: Allowed::Above(0.0).check("b", table.b)?,
            coulomb: Allowed::AtLeast(0.0).check("coulomb", table.coulomb)?,
            load: Allowed::Finite.check("load", table.load)?,
        })
    };
    checked().map_err(under("plant"))
}

fn counts_per_rev(table: &tables::Encoder) -> Result<Option<f64>, Fault> {
    let counts = Allowed::AtLeast(0.0)
        .check("counts_per_rev", table.counts_per_rev)
        .map_err(under("encoder"))?;
    Ok((counts > 0.0).then_some(counts))
}

fn limit(table: &tables::Amplifier) -> Result<CommandLimit, Fault> {
    let fault = |error: OutOfRange| Fault::new("amplifier.limit", error);
    match &table.limit {
        None => Ok(CommandLimit::NONE),
        Some(NumberOrRow::Number(limit)) => CommandLimit::symmetric(*limit).map_err(fault),
        Some(NumberOrRow::Row(row)) => match row[..] {
            [low, high] => CommandLimit::asymmetric(low, high).map_err(fault),
            _ => Err(Fault::new(
                "amplifier.limit",
                format!("{} numbers where two belong", row.len()),
            )),
        },
    }
}

fn controller(
    table: &tables::Controller,
    counts_per_rev: Option<f64>,
) -> Result<ControllerSettings, Fault> {
    let position_unit = counts_per_rev.map_or(IDEAL_UNIT, |counts| std::f64::consts::TAU / counts);
    let units = Units::new(table.sample_time, position_unit).map_err(under("controller"))?;
    let gains = Gains::new(table.kp, table.kd, table.ki).map_err(under("controller"))?;
    let filter = &table.velocity_filter;
    let velocity = match (filter.kind, filter.cutoff) {
        (VelocityKind::LowPass, cutoff) => VelocitySettings::LowPass(cutoff.unwrap_or(500.0)),
        (VelocityKind::Difference, None) => VelocitySettings::Difference,
        (VelocityKind::AveragedDifference, None) => VelocitySettings::AveragedDifference,
        (_, Some(_)) => {
            return Err(Fault::new(
                "controller.velocity_filter.cutoff",
                "this kind of velocity filter has no cut-off",
            ));
        }
    };
    Ok(ControllerSettings {
        gains,
        units,
        velocity,
    })
}

fn excitation(table: &tables::Excitation) -> Result<ExcitationSettings, Fault> {
    use ExcitationKind as Kind;

    let (name, takes): (&str, &[&str]) = match table.kind {
        Kind::BandLimitedWhiteNoise => (
            "band-limited-white-noise",
            &["power", "sample_time", "seed"],
        ),
        Kind::Prbs => ("prbs", &["amplitude", "hold", "order"]),
        Kind::Multisine => ("multisine", &["amplitudes", "frequencies"]),
        Kind::Chirp => ("chirp", &["amplitude", "from", "to", "duration"]),
        Kind::Square => ("square", &["amplitude", "period"]),
        Kind::Steps => ("steps", &["levels", "hold"]),
        Kind::None => ("none", &[]),
    };
    let given = [
        ("power", table.power.is_some()),
        ("sample_time", table.sample_time.is_some()),
        ("seed", table.seed.is_some()),
        ("amplitude", table.amplitude.is_some()),
        ("hold", table.hold.is_some()),
        ("order", table.order.is_some()),
        ("amplitudes", table.amplitudes.is_some()),
        ("frequencies", table.frequencies.is_some()),
        ("from", table.from.is_some()),
        ("to", table.to.is_some()),
        ("duration", table.duration.is_some()),
        ("period", table.period.is_some()),
        ("levels", table.levels.is_some()),
    ];
    refuse_strangers("excitation", name, takes, &given)?;

    let required = |key: &str, value: Option<f64>| {
        value.ok_or_else(|| missing(&format!("excitation.{key}"), name))
    };
    Ok(match table.kind {
        Kind::BandLimitedWhiteNoise => ExcitationSettings::BandLimitedWhiteNoise {
            power: table.power.unwrap_or(0.005),
            sample_time: table.sample_time.unwrap_or(0.1),
            seed: table.seed.unwrap_or(1_212_121),
        },
        Kind::Prbs => ExcitationSettings::Prbs {
            amplitude: required("amplitude", table.amplitude)?,
            hold: required("hold", table.hold)?,
            order: table.order.unwrap_or(9),
        },
        Kind::Multisine => ExcitationSettings::Multisine(tones(table, name)?),
        Kind::Chirp => ExcitationSettings::Chirp {
            amplitude: required("amplitude", table.amplitude)?,
            from: required("from", table.from)?,
            to: required("to", table.to)?,
            duration: required("duration", table.duration)?,
        },
        Kind::Square => ExcitationSettings::Square {
            amplitude: required("amplitude", table.amplitude)?,
            period: required("period", table.period)?,
        },
        Kind::Steps => ExcitationSettings::Steps {
            levels: table
                .levels
                .clone()
                .ok_or_else(|| missing("excitation.levels", name))?,
            hold: required("hold", table.hold)?,
        },
        Kind::None => ExcitationSettings::None,
    })
}

fn tones(table: &tables::Excitation, name: &str) -> Result<Vec<Tone>, Fault> {
    let list = |key: &str, values: &Option<Vec<f64>>| {
        values
            .clone()
            .ok_or_else(|| missing(&format!("excitation.{key}"), name))
    };
    let amplitudes = list("amplitudes", &table.amplitudes)?;
    let frequencies = list("frequencies", &table.frequencies)?;
    if amplitudes.len() != frequencies.len() {
        return Err(Fault::new(
            "excitation.frequencies",
            format!(
                "{} frequencies for {} amplitudes",
                frequencies.len(),
                amplitudes.len()
            ),
        ));
    }
    Ok(amplitudes
        .into_iter()
        .zip(frequencies)
        .map(|(amplitude, frequency)| Tone {
            amplitude,
            frequency,
        })
        .collect())
}

fn identifier(
    table: &tables::Identifier,
    sample_time: f64,
    command: f64,
) -> Result<IdentifierSettings, Fault> {
    let (name, takes): (&str, &[&str]) = match table.law {
        LawName::Gradient => ("gradient", &["gamma", "mu", "bounds", "plant_box"]),
        LawName::GaussNewton => (
            "gauss-newton",
            &[
                "bounds",
                "plant_box",
                "uncertainty",
                "noise",
                "window",
                "fit_every",
            ],
        ),
        LawName::Window => ("window", &["bounds", "plant_box", "window", "fit_every"]),
        LawName::PdGradient => ("pd-gradient", &["gamma", "mu", "bounds", "plant_box"]),
        other => other.baseline().map_or(("", &[]), |b| (b.name(), b.keys())),
    };
    let given = [
        ("gamma", table.gamma.is_some()),
        ("mu", table.mu.is_some()),
        ("bounds", table.bounds.is_some()),
        ("plant_box", table.plant_box.is_some()),
        ("uncertainty", table.uncertainty.is_some()),
        ("noise", table.noise.is_some()),
        ("window", table.window.is_some()),
        ("fit_every", table.fit_every.is_some()),
        ("relay", table.relay.is_some()),
        ("forgetting", table.forgetting.is_some()),
        ("filter_cutoff", table.filter_cutoff.is_some()),
        ("relay_delay", table.relay_delay.is_some()),
        ("proportional_gain", table.proportional_gain.is_some()),
        ("block", table.block.is_some()),
    ];
    refuse_strangers("identifier", name, takes, &given)?;
    let parameters = parameters(table)?;
    let gradient = || -> Result<GradientSettings, Fault> {
        Ok(GradientSettings {
            gamma: table
                .gamma
                .as_deref()
                .map(|entries| gamma(entries, parameters.len()))
                .transpose()?,
            mu: table.mu,
        })
    };
    let law = match (table.law, table.law.baseline()) {
        (_, Some(baseline)) => Law::Baseline(baseline, baseline_settings(table, baseline)?),
        (LawName::GaussNewton, None) => Law::GaussNewton(uncertainty(table)?, window(table)?),
        (LawName::Window, None) => Law::Window(window(table)?),
        (LawName::PdGradient, None) => Law::PdGradient(gradient()?),
        (_, None) => Law::Gradient(gradient()?),
    };
    let tables::Initial {
        a,
        b,
        coulomb,
        load,
    } = table.initial;
    Ok(IdentifierSettings {
        law,
        parameters,
        initial: ServoParameters {
            a,
            b: Allowed::Above(0.0)
                .check("initial.b", b)
                .map_err(under("identifier"))?,
            coulomb,
            load,
        },
        bounds: bounds(table, sample_time, command)?,
        plant_box: table.plant_box.as_ref().map(plant_box).transpose()?,
        arithmetic: match table.arithmetic {
            tables::Arithmetic::F32 => Arithmetic::F32,
            tables::Arithmetic::F64 => Arithmetic::F64,
            tables::Arithmetic::Fixed => Arithmetic::Fixed,
        },
        ranges: ranges(table)?,
    })
}

fn parameters(table: &tables::Identifier) -> Result<Vec<Parameter>, Fault> {
    let key = "identifier.parameters";
    let fixed = table.law.baseline().map(Baseline::parameters);
    let Some(names) = &table.parameters else {
        let default: &[Parameter] = &[Parameter::A, Parameter::B];
        return Ok(fixed.unwrap_or(default).to_vec());
    };
    let parameters: Vec<Parameter> = names
        .iter()
        .map(|name| match name {
            tables::Parameter::A => Parameter::A,
            tables::Parameter::B => Parameter::B,
            tables::Parameter::Coulomb => Parameter::Coulomb,
            tables::Parameter::Load => Parameter::Load,
        })
        .collect();
    if parameters.is_empty() {
        return Err(Fault::new(key, "there is nothing to estimate"));
    }
    if let Some(twice) = (1..parameters.len()).find(|&i| parameters[..i].contains(&parameters[i])) {
        let name = parameters[twice].name();
        return Err(Fault::new(key, format!("\"{name}\" stands there twice")));
    }
    let only = match (table.law, table.law.baseline()) {
        (_, Some(baseline)) => Some((baseline.name(), baseline.parameters())),
        (LawName::PdGradient, None) => Some(("pd-gradient", PD_GRADIENT)),
        _ => None,
    };
    if let Some((law, own)) = only
        && let Some(foreign) = parameters.iter().find(|parameter| !own.contains(parameter))
    {
        let names: Vec<_> = own
            .iter()
            .map(|own| format!("\"{}\"", own.name()))
            .collect();
        return Err(Fault::new(
            key,
            format!(
                "\"{law}\" cannot estimate \"{}\": it estimates [{}] and nothing else",
                foreign.name(),
                names.join(", ")
            ),
        ));
    }
    if let Some(own) = fixed
        && let Some(missing) = own.iter().find(|own| !parameters.contains(own))
        && *missing != Parameter::Coulomb
        && *missing != Parameter::Load
    {
        return Err(Fault::new(
            key,
            format!("this law always estimates \"{}\"", missing.name()),
        ));
    }
    Ok(parameters)
}

/// What the gradient's ancestor estimates: in a loop without integral a load is an error to it, and
/// friction was none of its concern.
const PD_GRADIENT: &[Parameter] = &[Parameter::A, Parameter::B];

fn baseline_settings(
    table: &tables::Identifier,
    baseline: Baseline,
) -> Result<BaselineSettings, Fault> {
    let default = BaselineSettings::of(baseline);
    let settings = BaselineSettings {
        relay: table.relay.unwrap_or(default.relay),
        relay_delay: table.relay_delay.unwrap_or(default.relay_delay),
        forgetting: table.forgetting.unwrap_or(default.forgetting),
        filter_cutoff: table.filter_cutoff.unwrap_or(default.filter_cutoff),
        proportional_gain: table.proportional_gain,
        block: table.block.unwrap_or(default.block),
    };
    let positive = |name, value: Option<f64>| match value {
        Some(value) => Allowed::Above(0.0).check(name, value).map(|_| ()),
        None => Ok(()),
    };
    positive("relay", Some(settings.relay))
        .and_then(|()| {
            Allowed::Within(0.0, 10.0)
                .check("relay_delay", settings.relay_delay)
                .map(|_| ())
        })
        .and_then(|()| {
            Allowed::PositiveUpTo(1.0)
                .check("forgetting", settings.forgetting)
                .map(|_| ())
        })
        .and_then(|()| positive("proportional_gain", settings.proportional_gain))
        .and_then(|()| positive("block", Some(settings.block)))
        .map_err(under("identifier"))?;
    Ok(settings)
}

fn uncertainty(table: &tables::Identifier) -> Result<Uncertainty, Fault> {
    let tables::Uncertainty {
        a,
        b,
        coulomb,
        load,
    } = table.uncertainty.unwrap_or_default();
    for (name, value) in [
        ("uncertainty.a", a),
        ("uncertainty.b", b),
        ("uncertainty.coulomb", coulomb),
        ("uncertainty.load", load),
        ("noise", table.noise),
    ] {
        if let Some(value) = value {
            Allowed::Above(0.0)
                .check(name, value)
                .map_err(under("identifier"))?;
        }
    }
    Ok(Uncertainty {
        initial: [a, b, coulomb, load],
        noise: table.noise,
    })
}

/// The fewest samples of a window: below, there are hardly more samples than unknowns.
const SHORTEST_WINDOW: f64 = 32.0;

fn window(table: &tables::Identifier) -> Result<WindowSettings, Fault> {
    let default = WindowSettings::default();
    let WindowSettings { length, fit_every } = WindowSettings {
        length: table
            .window
            .map_or(default.length, |length| length as usize),
        fit_every: table.fit_every.unwrap_or(default.fit_every),
    };
    Allowed::Within(SHORTEST_WINDOW, WindowSettings::LONGEST as f64)
        .check("window", length as f64)
        .and_then(|_| Allowed::AtLeast(1.0).check("fit_every", f64::from(fit_every)))
        .map_err(under("identifier"))?;
    Ok(WindowSettings { length, fit_every })
}

/// What fixed point needs: a law that has it, and ranges.
fn ranges(table: &tables::Identifier) -> Result<Option<Ranges>, Fault> {
    if table.arithmetic != tables::Arithmetic::Fixed {
        return match table.ranges {
            Some(_) => Err(Fault::new(
                "identifier.ranges",
                "floating point needs no ranges: this key belongs to arithmetic = \"fixed\"",
            )),
            None => Ok(None),
        };
    }
    if !matches!(table.law, LawName::Gradient | LawName::PdGradient) {
        return Err(Fault::new(
            "identifier.arithmetic",
            "\"gradient\" and \"pd-gradient\" alone are there in fixed point",
        ));
    }
    Ok(table.ranges.map(|ranges| Ranges {
        error: ranges.error,
        velocity: ranges.velocity,
        command: ranges.command,
    }))
}

/// The matrix of a diagonal or of rows, for so many parameters.
fn gamma(entries: &[NumberOrRow], parameters: usize) -> Result<Vec<Vec<f64>>, Fault> {
    let fault = |fault: String| Fault::new("identifier.gamma", fault);
    if entries.len() != parameters {
        return Err(fault(format!(
            "{} entries for {parameters} parameters",
            entries.len()
        )));
    }
    entries
        .iter()
        .enumerate()
        .map(|(i, entry)| match entry {
            NumberOrRow::Number(value) => {
                let mut row = vec![0.0; parameters];
                row[i] = *value;
                Ok(row)
            }
            NumberOrRow::Row(row) if row.len() == parameters => Ok(row.clone()),
            NumberOrRow::Row(row) => Err(fault(format!(
                "row {i} has {} entries for {parameters} parameters",
                row.len()
            ))),
        })
        .collect()
}

fn bounds(table: &tables::Identifier, sample_time: f64, command: f64) -> Result<Bounds, Fault> {
    let given = table.bounds.unwrap_or_default();
    let initial = table.initial.b;
    let b = given.b.unwrap_or([0.1 * initial, 100.0 * initial]);
    let most = b[1] * command;
    Ok(Bounds {
        a: interval("bounds.a", given.a.unwrap_or([0.0, 0.1 / sample_time]))?,
        b: interval("bounds.b", b)?,
        coulomb: interval("bounds.coulomb", given.coulomb.unwrap_or([0.0, most]))?,
        load: interval("bounds.load", given.load.unwrap_or([-most, most]))?,
    })
}

fn plant_box(table: &tables::PlantBox) -> Result<PlantBox, Fault> {
    let a = interval("plant_box.a", table.a)?;
    let b = interval("plant_box.b", table.b)?;
    PlantBox::new(a, b).map_err(|error| {
        let side = if error.parameter == "a_min" { "a" } else { "b" };
        Fault::new(format!("identifier.plant_box.{side}"), error)
    })
}

fn interval(parameter: &'static str, [min, max]: [f64; 2]) -> Result<Interval, Fault> {
    Interval::new(parameter, min, max).map_err(under("identifier"))
}

fn missing(key: &str, name: &str) -> Fault {
    Fault::new(key, format!("this value is missing: \"{name}\" needs it"))
}

/// Refuses keys that exist but mean nothing to the chosen kind: a silent one would be a setting
/// that the user believes in and that does nothing.
fn refuse_strangers(
    table: &str,
    name: &str,
    takes: &[&str],
    given: &[(&str, bool)],
) -> Result<(), Fault> {
    let stranger = given
        .iter()
        .find(|(key, present)| *present && !takes.contains(key));
    match stranger {
        None => Ok(()),
        Some((key, _)) => Err(Fault::new(
            format!("{table}.{key}"),
            if takes.is_empty() {
                format!("\"{name}\" takes no further keys")
            } else {
                format!(
                    "\"{name}\" does not take this key, but {}",
                    takes.join(", ")
                )
            },
        )),
    }
}
