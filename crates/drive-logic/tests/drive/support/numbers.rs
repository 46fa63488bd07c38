//! The numbers of settings and orders that a user may get wrong, by name.

use commissioning::CommissionSettings;
use drive_link::{Settings, TargetSource};
use identifier_core::parameters::PerParameter;

/// A number with its name: that of a refusal, and the end where there are two.
type Named<'a> = (&'static str, &'a mut f64);

/// Those of settings, as far as they are stated.
pub(crate) fn of_settings(settings: &mut Settings) -> Vec<Named<'_>> {
    let Settings {
        closed_loop,
        dither,
        protection,
        homing,
        source,
        brake,
        ..
    } = settings;
    let core = &mut closed_loop.core;
    let [low, high] = &mut protection.travel;
    let mut numbers = vec![
        ("travel.low", low),
        ("travel.high", high),
        ("sample_time", &mut core.sample_time),
        ("resolution", &mut core.resolution),
        ("cutoff", &mut core.cutoff),
        ("amplitude", &mut dither.amplitude),
        ("hold", &mut dither.hold),
        ("following_error", &mut protection.following_error),
        ("pace", &mut protection.pace),
        ("speed", &mut protection.speed),
        ("breakaway", &mut protection.breakaway),
        ("stall_time", &mut protection.stall_time),
        ("duration", &mut protection.duration),
        ("link_timeout", &mut protection.link_timeout),
        ("stop_time", &mut protection.stop_time),
    ];
    if let Some(homing) = homing {
        numbers.push(("homing.seek", &mut homing.seek));
        numbers.push(("homing.approach", &mut homing.approach));
        numbers.push(("homing.clearance", &mut homing.clearance));
        numbers.push(("homing.offset", &mut homing.offset));
    }
    if let TargetSource::Steps { step } = source {
        numbers.push(("source.step", step));
    }
    if let Some(brake) = brake {
        numbers.push(("brake.opens", &mut brake.opens));
        numbers.push(("brake.closes", &mut brake.closes));
    }
    if let Some(controller) = &mut core.controller {
        let [low, high] = &mut controller.limit;
        numbers.push(("kp", &mut controller.kp));
        numbers.push(("kd", &mut controller.kd));
        numbers.push(("ki", &mut controller.ki));
        numbers.push(("limit_low", low));
        numbers.push(("limit_high", high));
    }
    let identifier = &mut core.identifier;
    numbers.push(("delay", &mut identifier.terms.delay));
    numbers.extend(identifier.initial.b.as_mut().map(|b| ("initial.b", b)));
    numbers.extend(identifier.mu.as_mut().map(|mu| ("mu", mu)));
    for (names, ends) in [
        (["bounds.a.low", "bounds.a.high"], &mut identifier.bounds.a),
        (
            ["bounds.coulomb.low", "bounds.coulomb.high"],
            &mut identifier.bounds.coulomb,
        ),
    ] {
        numbers.extend(names.into_iter().zip(ends.iter_mut().flatten()));
    }
    if let Some(within) = &mut identifier.parameter_range {
        let names = [
            "servo_range.a.low",
            "servo_range.a.high",
            "servo_range.b.low",
            "servo_range.b.high",
        ];
        let ends = within.a.iter_mut().chain(&mut within.b);
        numbers.extend(names.into_iter().zip(ends));
    }
    if let Some(PerParameter {
        a,
        b,
        coulomb,
        load,
    }) = &mut identifier.gamma
    {
        let names = ["gamma.a", "gamma.b", "gamma.coulomb", "gamma.load"];
        numbers.extend(names.into_iter().zip([a, b, coulomb, load]));
    }
    numbers
}

/// Those of an order to commission.
pub(crate) fn of_order(order: &mut CommissionSettings) -> [Named<'_>; 12] {
    let [low, high] = &mut order.limits.travel;
    let [least, most] = &mut order.limits.command;
    [
        ("travel.low", low),
        ("travel.high", high),
        ("speed", &mut order.limits.speed),
        ("limit_low", least),
        ("limit_high", most),
        ("duration", &mut order.limits.duration),
        ("command_delay", &mut order.command_delay),
        ("noise", &mut order.noise),
        ("max_gain", order.max_gain.get_or_insert(1000.0)),
        ("max_sensitivity", &mut order.max_sensitivity),
        ("sample_time", &mut order.sample_time),
        ("resolution", &mut order.resolution),
    ]
}

/// Sets the number of a name; the value before.
pub(crate) fn set<'a>(numbers: impl IntoIterator<Item = Named<'a>>, name: &str, value: f64) -> f64 {
    let named = numbers.into_iter().find(|(own, _)| *own == name);
    let (_, number) = named.unwrap_or_else(|| panic!("there is no {name}"));
    std::mem::replace(number, value)
}
