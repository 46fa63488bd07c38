//! From tables to validated settings.

use identifier_core::ControllerSettings;
use identifier_core::control::{CommandLimit, Gains};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::excitation::Tone;
use identifier_core::interval::Interval;
use identifier_core::model::ServoParameters;
use identifier_core::parameters::Parameter;
use identifier_core::settings::{
    BoxSettings, IdentifierSettings, PerParameter, RangeSettings, Settings,
};
use identifier_core::stability::PlantBox;
use identifier_core::units::Units;

use super::error::Fault;
use super::parts::{identity, place};
use super::tables::{self, ExcitationKind, LawName, NumberOrRow, Tables, VelocityKind};
use super::{
    Arithmetic, Baseline, BaselineSettings, Closing, CompareSettings, ExcitationSettings,
    Identification, Law, LogSettings, Purpose, Scenario, Velocity,
};

/// Sines that a multisine and levels that a staircase may have.
pub(crate) const MOST_ENTRIES: usize = 16;

/// The longest run, control samples.
const MOST_SAMPLES: f64 = 1e10;

/// The position unit of an ideal sensor, rad: as of an encoder that is finer than any effect.
const IDEAL_UNIT: f64 = 1e-5;

/// The paper's cut-off of the velocity filter, rad/s.
const CUTOFF: f64 = 500.0;

pub(super) fn scenario(tables: &Tables, purpose: Purpose) -> Result<Scenario, Fault> {
    // What a run takes for granted holds for its own log too.
    let own = purpose == Purpose::Run || tables.plant.is_some();
    let counts_per_rev = match &tables.encoder {
        Some(encoder) => counts_per_rev(encoder)?,
        None if own => counts_per_rev(&tables::Encoder::default())?,
        None => None,
    };
    let limit = limit(&tables.amplifier)?;
    let declared = match &tables.controller {
        Some(table) => Some(table.clone()),
        None => own.then(tables::Controller::default),
    };
    let position_unit = counts_per_rev.map_or(IDEAL_UNIT, |counts| std::f64::consts::TAU / counts);
    let (velocity, mut stated) = closed_loop(declared.as_ref(), limit, position_unit)?;
    let sample_time = stated.sample_time;
    let duration = Allowed::Within(sample_time, MOST_SAMPLES * sample_time)
        .check("duration", tables.run.duration)
        .map_err(under("run"))?;
    let plant = tables.plant.as_ref().map(plant).transpose()?;
    if purpose == Purpose::Run && plant.is_none() {
        return Err(Fault::new("plant", "a run needs the true servo"));
    }
    let identifier = identification(&tables.identifier)?;
    stated.identifier = learning(&tables.identifier, &identifier)?;
    let log = tables
        .log
        .as_ref()
        .map_or_else(|| Ok(LogSettings::own()), log)?;
    let scenario = Scenario {
        plant,
        counts_per_rev,
        stated,
        velocity,
        excitation: excitation(&tables.excitation)?,
        identifier,
        duration,
        log,
        compare: compare(&tables.compare)?,
    };
    let law = &scenario.identifier.law;
    let takes_log = law.is_replayable() || own && law.closing() == Closing::Pd;
    // A replay knows its units and its reference only once the log is read.
    match purpose {
        Purpose::Run => {
            let scenario = scenario.in_own_loop();
            scenario.try_parts()?;
            Ok(scenario)
        }
        Purpose::Replay if !takes_log => Err(Fault::new(
            "identifier.law",
            format!(
                "\"{}\" works in a loop of its own and cannot take a log: {} can",
                scenario.identifier.law.name(),
                Law::REPLAYABLE
            ),
        )),
        Purpose::Replay if own => {
            let scenario = scenario.in_own_loop();
            scenario.try_parts()?;
            Ok(scenario)
        }
        Purpose::Replay => {
            replayable(&scenario)?;
            Ok(scenario)
        }
    }
}

/// What a replay cannot do without, apart from the log itself.
fn replayable(scenario: &Scenario) -> Result<(), Fault> {
    if scenario.identifier.arithmetic == Arithmetic::Fixed && scenario.counts_per_rev.is_none() {
        return Err(Fault::new(
            "identifier.arithmetic",
            "\"fixed\" counts: encoder.counts_per_rev has to say what a count of the log's position is; \
             \"f32\" and \"f64\" do without",
        ));
    }
    let (given, identifier) = (&scenario.stated, &scenario.stated.identifier);
    let log = &scenario.log;
    if given.controller.is_none() {
        if log.command.is_none() {
            return Err(Fault::new(
                "controller",
                "without log.command the controller that ran has to be declared, so that its command \
                 can be computed again",
            ));
        }
        let follows = identifier.correction.is_some() || identifier.plant_box.is_some();
        if scenario.identifier.law.is_gradient() && !follows {
            return Err(Fault::new(
                "identifier.correction",
                "without a [controller] this law has to be told the gains of its correction, or a \
                 plant_box that they follow from",
            ));
        }
    }
    if log.reference.is_none()
        && scenario.identifier.law.is_gradient()
        && identifier.gamma.is_none()
    {
        return Err(Fault::new(
            "identifier.gamma",
            "without log.reference no gamma can be chosen: it has to be stated",
        ));
    }
    Ok(())
}

fn log(table: &tables::Log) -> Result<LogSettings, Fault> {
    if table.command.is_none() && table.reference.is_none() {
        return Err(Fault::new(
            "log.command",
            "the log must have the command, or the reference that the declared controller computes it \
             from",
        ));
    }
    Ok(LogSettings {
        time: table.time.clone(),
        reference: table.reference.clone(),
        position: table.position.clone(),
        command: table.command.clone(),
        injection: table.injection.clone(),
        bridge: table.bridge_gaps,
    })
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

fn limit(table: &tables::Amplifier) -> Result<[f64; 2], Fault> {
    let fault = |error: OutOfRange| Fault::new("amplifier.limit", error);
    let limit = match &table.limit {
        None => Ok(CommandLimit::NONE),
        Some(NumberOrRow::Number(limit)) => CommandLimit::symmetric(*limit).map_err(fault),
        Some(NumberOrRow::Row(row)) => match row[..] {
            [low, high] => CommandLimit::asymmetric(low, high).map_err(fault),
            _ => Err(Fault::new(
                "amplifier.limit",
                format!("{} numbers where two belong", row.len()),
            )),
        },
    }?;
    Ok([limit.low(), limit.high()])
}

/// The loop that a controller closes; without one, what an identifier that only listens is told.
fn closed_loop(
    table: Option<&tables::Controller>,
    limit: [f64; 2],
    resolution: f64,
) -> Result<(Velocity, Settings), Fault> {
    let Some(table) = table else {
        // Its sample time is the log's.
        let stated = Settings {
            resolution,
            ..Settings::new(tables::Controller::default().sample_time, 1.0)
        };
        return Ok((Velocity::LowPass, stated));
    };
    let units = Units::new(table.sample_time, resolution).map_err(under("controller"))?;
    let gains = Gains::new(table.kp, table.kd, table.ki).map_err(under("controller"))?;
    let filter = &table.velocity_filter;
    let velocity = match (filter.kind, filter.cutoff) {
        (VelocityKind::LowPass, _) => Velocity::LowPass,
        (VelocityKind::Difference, None) => Velocity::Difference,
        (VelocityKind::AveragedDifference, None) => Velocity::AveragedDifference,
        (_, Some(_)) => {
            return Err(Fault::new(
                "controller.velocity_filter.cutoff",
                "this kind of velocity filter has no cut-off",
            ));
        }
    };
    let stated = Settings {
        sample_time: units.sample_time(),
        resolution,
        cutoff: filter.cutoff.unwrap_or(CUTOFF),
        controller: Some(ControllerSettings {
            limit,
            ..ControllerSettings::pid(gains.kp(), gains.kd(), gains.ki())
        }),
        identifier: IdentifierSettings::UNSTATED,
    };
    Ok((velocity, stated))
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

/// What the gradient laws take besides what every law does.
const GRADIENT_KEYS: &[&str] = &[
    "gamma",
    "mu",
    "bounds",
    "plant_box",
    "correction",
    "bandwidth",
    "max_speed",
];

/// What the window takes besides what every law does.
const WINDOW_KEYS: &[&str] = &[
    "bounds",
    "uncertainty",
    "noise",
    "bandwidth",
    "max_speed",
    "start_time",
];

/// What recursive Gauss–Newton takes: what the window does, and a memory.
const GAUSS_NEWTON_KEYS: &[&str] = &[
    "bounds",
    "uncertainty",
    "noise",
    "bandwidth",
    "max_speed",
    "start_time",
    "memory",
];

fn identification(table: &tables::Identifier) -> Result<Identification, Fault> {
    let (name, takes): (&str, &[&str]) = match table.law {
        LawName::Gradient => ("gradient", GRADIENT_KEYS),
        LawName::PdGradient => ("pd-gradient", GRADIENT_KEYS),
        LawName::GaussNewton => ("gauss-newton", GAUSS_NEWTON_KEYS),
        LawName::Window => ("window", WINDOW_KEYS),
        other => other.baseline().map_or(("", &[]), |b| (b.name(), b.keys())),
    };
    let given = [
        ("gamma", table.gamma.is_some()),
        ("mu", table.mu.is_some()),
        ("bounds", table.bounds.is_some()),
        ("plant_box", table.plant_box.is_some()),
        ("correction", table.correction.is_some()),
        ("bandwidth", table.bandwidth.is_some()),
        ("max_speed", table.max_speed.is_some()),
        ("uncertainty", table.uncertainty.is_some()),
        ("noise", table.noise.is_some()),
        ("start_time", table.start_time.is_some()),
        ("memory", table.memory.is_some()),
        ("relay", table.relay.is_some()),
        ("forgetting", table.forgetting.is_some()),
        ("filter_cutoff", table.filter_cutoff.is_some()),
        ("relay_delay", table.relay_delay.is_some()),
        ("proportional_gain", table.proportional_gain.is_some()),
        ("block", table.block.is_some()),
    ];
    refuse_strangers("identifier", name, takes, &given)?;
    let law = match (table.law, table.law.baseline()) {
        (_, Some(baseline)) => Law::Baseline(baseline, baseline_settings(table, baseline)?),
        (LawName::GaussNewton, None) => Law::GaussNewton,
        (LawName::Window, None) => Law::Window,
        (LawName::PdGradient, None) => Law::PdGradient,
        (_, None) => Law::Gradient,
    };
    let arithmetic = match table.arithmetic {
        tables::Arithmetic::F32 => Arithmetic::F32,
        tables::Arithmetic::F64 => Arithmetic::F64,
        tables::Arithmetic::Fixed => Arithmetic::Fixed,
    };
    Ok(Identification {
        law,
        parameters: parameters(table)?,
        arithmetic,
    })
}

/// What the core is told of the identifier, as far as the file states it.
fn learning(
    table: &tables::Identifier,
    chosen: &Identification,
) -> Result<IdentifierSettings, Fault> {
    let positive = |name, value: Option<f64>| {
        value
            .map(|value| Allowed::Above(0.0).check(name, value))
            .transpose()
            .map_err(under("identifier"))
    };
    let uncertainty = table.uncertainty.unwrap_or_default();
    Ok(IdentifierSettings {
        initial: initial(table, &chosen.law)?,
        bounds: bounds(table)?,
        uncertainty: PerParameter {
            a: positive("uncertainty.a", uncertainty.a)?,
            b: positive("uncertainty.b", uncertainty.b)?,
            coulomb: positive("uncertainty.coulomb", uncertainty.coulomb)?,
            load: positive("uncertainty.load", uncertainty.load)?,
        },
        noise: positive("noise", table.noise)?,
        plant_box: table.plant_box.as_ref().map(plant_box).transpose()?,
        gamma: table
            .gamma
            .as_deref()
            .map(|entries| gamma(entries, &chosen.parameters))
            .transpose()?,
        mu: table.mu,
        correction: table.correction.as_ref().map(correction).transpose()?,
        bandwidth: positive("bandwidth", table.bandwidth)?,
        start_time: positive("start_time", table.start_time)?,
        memory: positive("memory", table.memory)?,
        max_speed: positive("max_speed", table.max_speed)?,
        ranges: ranges(table)?,
        ..IdentifierSettings::UNSTATED
    })
}

/// The initial estimates: the laws that fit need none, the others begin with the default.
fn initial(table: &tables::Identifier, law: &Law) -> Result<PerParameter<Option<f64>>, Fault> {
    let tables::Initial {
        a,
        b,
        coulomb,
        load,
    } = table.initial;
    if let Some(b) = b {
        Allowed::Above(0.0)
            .check("initial.b", b)
            .map_err(under("identifier"))?;
    }
    let fits = matches!(law, Law::GaussNewton | Law::Window);
    let or = |given: Option<f64>, default| given.or((!fits).then_some(default));
    Ok(PerParameter {
        a: or(a, 0.0),
        b: or(b, 50.0),
        coulomb: or(coulomb, 0.0),
        load: or(load, 0.0),
    })
}

fn correction(table: &tables::Correction) -> Result<[f64; 3], Fault> {
    let tables::Correction { kp, kd, ki } = *table;
    Gains::new(kp, kd, ki).map_err(under("identifier.correction"))?;
    Ok([kp, kd, ki])
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

/// What fixed point needs: a law that has it, and ranges.
fn ranges(table: &tables::Identifier) -> Result<Option<RangeSettings>, Fault> {
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
    Ok(table.ranges.map(|ranges| RangeSettings {
        error: ranges.error,
        velocity: ranges.velocity,
        command: ranges.command,
    }))
}

/// The matrix over all parameters of a diagonal or of rows for some of them.
fn gamma(entries: &[NumberOrRow], parameters: &[Parameter]) -> Result<[[f64; 4]; 4], Fault> {
    let count = parameters.len();
    let fault = |fault: String| Fault::new("identifier.gamma", fault);
    if entries.len() != count {
        return Err(fault(format!(
            "{} entries for {count} parameters",
            entries.len()
        )));
    }
    let mut matrix = identity();
    for (i, entry) in entries.iter().enumerate() {
        let row = &mut matrix[place(parameters[i])];
        match entry {
            NumberOrRow::Number(value) => row[place(parameters[i])] = *value,
            NumberOrRow::Row(values) if values.len() == count => {
                for (parameter, value) in parameters.iter().zip(values) {
                    row[place(*parameter)] = *value;
                }
            }
            NumberOrRow::Row(values) => {
                return Err(fault(format!(
                    "row {i} has {} entries for {count} parameters",
                    values.len()
                )));
            }
        }
    }
    Ok(matrix)
}

fn bounds(table: &tables::Identifier) -> Result<PerParameter<Option<[f64; 2]>>, Fault> {
    let given = table.bounds.unwrap_or_default();
    let ordered = |name, pair: Option<[f64; 2]>| {
        if let Some(pair) = pair {
            interval(name, pair)?;
        }
        Ok(pair)
    };
    Ok(PerParameter {
        a: ordered("bounds.a", given.a)?,
        b: ordered("bounds.b", given.b)?,
        coulomb: ordered("bounds.coulomb", given.coulomb)?,
        load: ordered("bounds.load", given.load)?,
    })
}

fn plant_box(table: &tables::PlantBox) -> Result<BoxSettings, Fault> {
    let a = interval("plant_box.a", table.a)?;
    let b = interval("plant_box.b", table.b)?;
    PlantBox::new(a, b).map_err(|error| {
        let side = if error.parameter == "a_min" { "a" } else { "b" };
        Fault::new(format!("identifier.plant_box.{side}"), error)
    })?;
    Ok(BoxSettings {
        a: table.a,
        b: table.b,
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
