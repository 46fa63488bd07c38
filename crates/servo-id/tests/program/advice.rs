//! The catalogues of causes, reasons and remedies, followed: each remedy is printed for a case that needs it, and
//! after it the case ends better. Remedies that need hands are marked with the reason.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use crate::predict;
use crate::support::{argument, assert_done, folder, printed, servo_id, standard_error};
use host_sim::verdict::{Cause, VerdictReason};
use identifier_core::reason::Reason;
use serde_json::Value;

/// Lines of a scenario: a table, and lines that are added to it, or that are all of it where its name begins with `=`.
type Lines = (&'static str, &'static str);

/// A remedy of a catalogue.
enum Remedy {
    /// Printed for a case: a part of the text, and the lines that follow it.
    Followed(&'static str, &'static [Lines]),
    /// Printed for a case of a commissioning: a log of its servo is recorded, and identified.
    Logged,
    /// For hands on hardware, or for a state that no simulation has.
    NotHere(&'static str),
}

use Remedy::{Followed, Logged, NotHere};

/// A case and its remedies.
struct Row {
    case: &'static [Lines],
    remedies: &'static [Remedy],
}

const NO_CASE: &[Lines] = &[];

const SERVO: [Lines; 7] = [
    ("plant", "a = 0.2174\nb = 257.7\ncoulomb = 5.0"),
    ("encoder", "counts_per_rev = 10000"),
    ("amplifier", "limit = 10.0"),
    (
        "controller",
        "kp = 9.0\nkd = 0.19\nki = 4.0\nsample_time = 0.001",
    ),
    (
        "excitation",
        "kind = \"band-limited-white-noise\"\npower = 0.05\nsample_time = 0.1\nseed = 7",
    ),
    (
        "identifier",
        "law = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]",
    ),
    ("run", "duration = 10.0"),
];

const AXIS: [Lines; 5] = [
    ("plant", "a = 0.2174\nb = 257.7"),
    ("encoder", "counts_per_rev = 10000"),
    ("amplifier", "limit = 10.0"),
    (
        "commission",
        "travel = 0.5\nspeed = 30.0\nsample_time = 0.001",
    ),
    ("[fault]", ""),
];

const FIT: &[Lines] = &[("=identifier", "law = \"fit\"")];
const FIT_SAYS: &str = "law = \"fit\"";
const ALL_FOUR: &[Lines] = &[(
    "=identifier",
    "law = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]",
)];
const STIFF: Lines = (
    "=controller",
    "kp = 200.0\nkd = 0.5\nki = 0.0\nsample_time = 0.001",
);
const LONGER: &[Lines] = &[("=run", "duration = 20.0")];
const LIVELY: &[Lines] = &[("=excitation", SERVO[4].1)];

fn cause(of: Cause) -> Row {
    let row = |case, remedies| Row { case, remedies };
    match of {
        Cause::Delay => row(
            &[("plant", "delay = 0.0015")],
            &[
                Followed("set amplifier.delay", &[("amplifier", "delay = 0.0015")]),
                Followed(
                    "required_terms = [\"delay\"]",
                    &[("identifier", "required_terms = [\"delay\"]")],
                ),
            ],
        ),
        Cause::Coulomb => row(
            &[
                ("=plant", "a = 0.2174\nb = 257.7\ncoulomb = 40.0"),
                (
                    "=identifier",
                    "law = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"load\"]",
                ),
            ],
            &[Followed("\"coulomb\" in identifier.parameters", ALL_FOUR)],
        ),
        Cause::Load => row(
            &[
                ("=plant", "a = 0.2174\nb = 257.7\nload = 40.0"),
                (
                    "=controller",
                    "kp = 9.0\nkd = 0.19\nki = 0.0\nsample_time = 0.001",
                ),
                (
                    "=excitation",
                    "kind = \"band-limited-white-noise\"\npower = 0.001\nseed = 7",
                ),
                (
                    "=identifier",
                    "law = \"gradient\"\ninitial = { a = 0.0, b = 110.0 }\ngamma = [1.0, 100.0]",
                ),
            ],
            &[Followed("\"load\" in identifier.parameters", ALL_FOUR)],
        ),
        Cause::Asymmetry => row(
            &[(
                "=plant",
                "a = 3.0\nb = 257.7\ncoulomb = 5.0\nasymmetry = 1.5",
            )],
            &[Followed(
                "required_terms = [\"asymmetry\"]",
                &[("identifier", "required_terms = [\"asymmetry\"]")],
            )],
        ),
        Cause::LowSpeedFriction => row(
            &[(
                "plant",
                "low_speed_friction = 10.0\nlow_speed_velocity = 1.0",
            )],
            &[Followed(
                "required_terms = [\"low-speed\"] and low_speed_velocity",
                &[(
                    "identifier",
                    "required_terms = [\"low-speed\"]\nlow_speed_velocity = 1.0",
                )],
            )],
        ),
        Cause::QuadraticFriction => row(
            &[("plant", "quadratic_friction = 0.05")],
            &[
                Followed(FIT_SAYS, FIT),
                Followed(
                    "identify at the speeds that matter",
                    &[(
                        "=excitation",
                        "kind = \"band-limited-white-noise\"\npower = 0.001\nseed = 7",
                    )],
                ),
            ],
        ),
        Cause::Gravity => row(
            &[("plant", "gravity = [60.0, 20.0]")],
            &[Followed(
                "required_terms = [\"gravity\"]",
                &[("identifier", "required_terms = [\"gravity\"]")],
            )],
        ),
        Cause::Ripple => row(
            &[("plant", "ripple = [15.0, 0.0]\nripple_order = 12")],
            &[Followed(
                "required_terms = [\"ripple\"] and ripple_order",
                &[(
                    "identifier",
                    "required_terms = [\"ripple\"]\nripple_order = 12",
                )],
            )],
        ),
        Cause::DeadBand => row(
            &[("plant", "dead_band = 0.06")],
            &[
                Followed(
                    "set amplifier.dead_band",
                    &[("amplifier", "dead_band = 0.06")],
                ),
                Followed(
                    "required_terms = [\"dead-band\"]",
                    &[("identifier", "required_terms = [\"dead-band\"]")],
                ),
            ],
        ),
        Cause::Resonance => row(
            &[("plant", "resonance = 300.0\ninertia_ratio = 0.6")],
            &[
                Followed(FIT_SAYS, FIT),
                Followed(
                    "with sines well below the resonance",
                    &[
                        (
                            "=excitation",
                            "kind = \"multisine\"\namplitudes = [1.0, 0.5]\nfrequencies = [3.0, 8.0]",
                        ),
                        ("=run", "duration = 20.0"),
                    ],
                ),
            ],
        ),
        Cause::Backlash => row(
            &[("plant", "backlash = 0.0075")],
            &[NotHere("the encoder is moved to the motor")],
        ),
        Cause::Eccentricity => row(
            NO_CASE,
            &[NotHere(
                "the encoder is centred; its error hardly moves the estimates, so that no verdict fails by it",
            )],
        ),
        Cause::GainDrift => row(
            &[("plant", "gain_drift = 0.02")],
            &[
                Followed(FIT_SAYS, FIT),
                Followed("steady the supply", &[("=plant", SERVO[0].1)]),
            ],
        ),
        Cause::FrictionDrift => row(
            &[("plant", "coulomb = 40.0\nfriction_drift = -0.04")],
            &[
                Followed(FIT_SAYS, FIT),
                Followed("warm up first", &[("=plant", SERVO[0].1)]),
            ],
        ),
        Cause::LoadSteps => row(
            NO_CASE,
            &[NotHere(
                "the log is cut; the load of a scenario's servo does not step",
            )],
        ),
        Cause::Jitter => row(NO_CASE, &[NotHere("the encoder is read by a timer")]),
        Cause::HiddenLimit => row(
            &[
                ("plant", "hidden_limit = 6.0"),
                (
                    "=excitation",
                    "kind = \"band-limited-white-noise\"\npower = 0.02\nseed = 8",
                ),
            ],
            &[
                Followed(FIT_SAYS, FIT),
                Followed(
                    "keep the command away from the limit",
                    &[(
                        "=excitation",
                        "kind = \"band-limited-white-noise\"\npower = 0.003\nseed = 8",
                    )],
                ),
            ],
        ),
        Cause::CurrentLoop => row(
            &[("plant", "current_loop = 0.002")],
            &[
                Followed("", FIT),
                Followed("", &[("amplifier", "current_loop = 0.002")]),
            ],
        ),
        Cause::LoadFriction => row(
            &[("plant", "load = 40.0\nload_dependent_friction = 0.3")],
            &[Followed(FIT_SAYS, FIT)],
        ),
        Cause::GainAsymmetry => row(
            &[("plant", "gain_asymmetry = 0.05")],
            &[
                Followed(FIT_SAYS, FIT),
                NotHere("the amplifier is calibrated"),
            ],
        ),
        Cause::TorqueRipple => row(
            &[(
                "plant",
                "torque_ripple = [0.05, 0.0]\ntorque_ripple_order = 6",
            )],
            &[
                Followed(FIT_SAYS, FIT),
                NotHere("the commutation is adjusted"),
            ],
        ),
        Cause::VaryingInertia => row(
            &[("plant", "inertia_variation = [0.1, 0.0]\ninertia_order = 1")],
            &[
                Followed(FIT_SAYS, FIT),
                Followed(
                    "",
                    &[(
                        "=excitation",
                        "kind = \"band-limited-white-noise\"\npower = 0.00005\nseed = 7",
                    )],
                ),
            ],
        ),
    }
}

/// The remedies of the verdict's reasons by their code; 40 has a table of its own.
const VERDICTS: [(u8, Row); 17] = [
    (
        0,
        Row {
            case: NO_CASE,
            remedies: &[NotHere("nothing is to be done")],
        },
    ),
    (
        10,
        Row {
            case: NO_CASE,
            remedies: &[NotHere(
                "the message names what ended the run: a cable, a supply",
            )],
        },
    ),
    (
        20,
        Row {
            case: NO_CASE,
            remedies: &[NotHere("identifier.law = \"gauss-newton\"")],
        },
    ),
    (
        21,
        Row {
            case: &[("=run", "duration = 0.05")],
            remedies: &[Followed("Run longer: run.duration", LONGER)],
        },
    ),
    (
        22,
        Row {
            case: &[(
                "=excitation",
                "kind = \"band-limited-white-noise\"\npower = 1e-9",
            )],
            remedies: &[
                Followed("a larger reference", LIVELY),
                NotHere("a cable is plugged in"),
            ],
        },
    ),
    (
        23,
        Row {
            case: &[
                (
                    "=excitation",
                    "kind = \"band-limited-white-noise\"\npower = 5e-6\nseed = 7",
                ),
                ("=run", "duration = 1.0"),
            ],
            remedies: &[
                Followed("move further", LIVELY),
                Followed("or longer", LONGER),
            ],
        },
    ),
    (
        24,
        Row {
            case: &[(
                "identifier",
                "bounds = { a = [0.0, 50.0], b = [300.0, 1000.0] }",
            )],
            remedies: &[
                Followed("Widen identifier.bounds", ALL_FOUR),
                Followed(FIT_SAYS, FIT),
            ],
        },
    ),
    (
        25,
        Row {
            case: &[
                ("=plant", "a = 0.2174\nb = 257.7\ncoulomb = 200.0"),
                ("=encoder", "counts_per_rev = 2000\nnoise = 0.01"),
                ("=amplifier", "limit = 0.85"),
                STIFF,
                (
                    "=excitation",
                    "kind = \"square\"\namplitude = 1.0\nperiod = 2.0",
                ),
                ("=identifier", "law = \"fit\""),
                ("=run", "duration = 2.0"),
            ],
            remedies: &[
                Followed(
                    "with commands of several sizes well above friction",
                    &[
                        ("=amplifier", SERVO[2].1),
                        ("=controller", SERVO[3].1),
                        ("=excitation", SERVO[4].1),
                    ],
                ),
                Followed("less noise of the position", &[("=encoder", SERVO[1].1)]),
            ],
        },
    ),
    (
        25,
        Row {
            case: &[
                ("=plant", "a = 0.2174\nb = 257.7\ncoulomb = 200.0"),
                ("=encoder", "counts_per_rev = 2000\nnoise = 0.01"),
                ("=amplifier", "limit = 0.85"),
                STIFF,
                (
                    "=excitation",
                    "kind = \"square\"\namplitude = 0.05\nperiod = 0.5",
                ),
                ("=identifier", "law = \"fit\""),
                ("=run", "duration = 5.0"),
            ],
            remedies: &[Followed("A longer record", LONGER)],
        },
    ),
    (
        26,
        Row {
            case: &[
                ("=plant", "a = 5.0\nb = 257.7\nload = 100.0\ncoulomb = 5.0"),
                ("=excitation", "kind = \"none\""),
                (
                    "=controller",
                    "kp = 0.01\nkd = 0.19\nki = 0.0\nsample_time = 0.001",
                ),
                ("=identifier", "law = \"fit\""),
            ],
            remedies: &[Followed(
                "Record a motion that turns back",
                &[("=excitation", SERVO[4].1), ("=controller", SERVO[3].1)],
            )],
        },
    ),
    (
        27,
        Row {
            case: &[
                ("=encoder", "counts_per_rev = 200"),
                (
                    "=excitation",
                    "kind = \"band-limited-white-noise\"\npower = 1e-4\nseed = 7",
                ),
                ("=identifier", "law = \"fit\""),
                ("=run", "duration = 2.0"),
            ],
            remedies: &[
                Followed("Move further, with turns", LIVELY),
                NotHere(
                    "columns of another axis are refused by the scan, which has tests of its own",
                ),
            ],
        },
    ),
    (
        28,
        Row {
            case: &[("plant", "delay = 0.02"), ("=identifier", "law = \"fit\"")],
            remedies: &[Followed("have the same clock", &[("=plant", SERVO[0].1)])],
        },
    ),
    (
        29,
        Row {
            case: &[
                ("identifier", "required_terms = [\"gravity\"]"),
                ("=run", "duration = 1.0"),
            ],
            remedies: &[
                Followed("or longer", LONGER),
                Followed("out of identifier.required_terms", ALL_FOUR),
            ],
        },
    ),
    (
        30,
        Row {
            case: &[
                ("encoder", "noise = 0.02"),
                (
                    "=identifier",
                    "law = \"gradient\"\ninitial = { a = 0.0, b = 110.0 }\ngamma = [0.1, 10.0]",
                ),
                ("=run", "duration = 2.0"),
            ],
            remedies: &[
                Followed("Run longer: run.duration", &[("=run", "duration = 60.0")]),
                Followed(FIT_SAYS, FIT),
            ],
        },
    ),
    (
        41,
        Row {
            case: &[
                ("plant", "delay = 0.0005\ndead_band = 0.03"),
                (
                    "=excitation",
                    "kind = \"multisine\"\namplitudes = [1.0, 0.5]\nfrequencies = [5.0, 20.0]",
                ),
            ],
            remedies: &[
                Followed(
                    "declare what you know of the amplifier",
                    &[("amplifier", "delay = 0.0005\ndead_band = 0.03")],
                ),
                Followed(FIT_SAYS, FIT),
            ],
        },
    ),
    (
        42,
        Row {
            case: &[
                ("=plant", "a = 0.2174\nb = 257.7\nload = 40.0"),
                (
                    "=controller",
                    "kp = 9.0\nkd = 0.19\nki = 0.0\nsample_time = 0.001",
                ),
                (
                    "=identifier",
                    "law = \"gradient\"\nparameters = [\"a\", \"b\", \"load\"]\n\
                     initial = { a = 0.0, b = 110.0 }\ngamma = [1.0, 100.0, 1.0]",
                ),
            ],
            remedies: &[Followed(FIT_SAYS, FIT)],
        },
    ),
    (
        43,
        Row {
            case: NO_CASE,
            remedies: &[NotHere("of two logs: followed by a test of its own, below")],
        },
    ),
];

/// The remedies of the core's reasons: those that a commissioning can follow.
const COMMISSIONED: [(Reason, Row); 27] = [
    (
        Reason::TravelLeft,
        Row {
            case: &[
                ("plant", "load = 2000.0"),
                (
                    "=commission",
                    "travel = 0.02\nspeed = 30.0\nsample_time = 0.001",
                ),
            ],
            remedies: &[Followed("allow more travel", &[("=commission", AXIS[3].1)])],
        },
    ),
    (
        Reason::SpeedExceeded,
        Row {
            case: &[(
                "=commission",
                "travel = 0.5\nspeed = 2.0\nsample_time = 0.001",
            )],
            remedies: &[Followed("allow more speed", &[("=commission", AXIS[3].1)])],
        },
    ),
    (
        Reason::DoesNotMove,
        Row {
            case: &[("plant", "coulomb = 300.0"), ("=amplifier", "limit = 1.0")],
            remedies: &[Followed(
                "allow a larger command",
                &[("=amplifier", "limit = 10.0")],
            )],
        },
    ),
    (
        Reason::OneDirectionOnly,
        Row {
            case: &[
                ("plant", "load = 1500.0\ncoulomb = 1300.0"),
                (
                    "=commission",
                    "travel = 5.0\nspeed = 30.0\nsample_time = 0.001",
                ),
            ],
            remedies: &[Followed(
                "free the axis",
                &[("plant", "load = 50.0\ncoulomb = 13.0")],
            )],
        },
    ),
    (
        Reason::TooLittleEvidence,
        Row {
            case: &[
                ("plant", "coulomb = 5.0"),
                ("=encoder", "counts_per_rev = 500"),
                (
                    "=commission",
                    "travel = 0.25\nspeed = 30.0\nsample_time = 0.001",
                ),
            ],
            remedies: &[Followed(
                "use a finer encoder",
                &[("=encoder", "counts_per_rev = 10000")],
            )],
        },
    ),
    (
        Reason::LacksResonance,
        Row {
            case: &[("plant", "resonance = 90.0\ninertia_ratio = 0.78")],
            remedies: &[
                Followed("stiffen the coupling", &[("plant", "resonance = 2000.0")]),
                Logged,
            ],
        },
    ),
    (
        Reason::LacksGravity,
        Row {
            case: &[("plant", "gravity = [600.0, 180.0]")],
            remedies: &[Followed(
                "commission it within less travel",
                &[(
                    "=commission",
                    "travel = 0.03\nspeed = 30.0\nsample_time = 0.001",
                )],
            )],
        },
    ),
    (
        Reason::NoGains,
        Row {
            case: &[("commission", "response_time = 0.012")],
            remedies: &[Followed(
                "ask for a slower response",
                &[("commission", "response_time = 0.03")],
            )],
        },
    ),
    (
        Reason::LacksDeadBand,
        Row {
            case: &[("plant", "dead_band = 0.5")],
            remedies: &[Followed(
                "compensate the amplifier's dead band",
                &[("=plant", AXIS[0].1)],
            )],
        },
    ),
    (
        Reason::TooLittleEvidence,
        Row {
            case: &[("commission", "duration = 0.05")],
            remedies: &[Followed("or duration", &[("commission", "duration = 0.3")])],
        },
    ),
    (
        Reason::PartlyExplained,
        Row {
            case: &[("plant", "coulomb = 20.0\nhidden_limit = 1.2")],
            remedies: &[Logged],
        },
    ),
    (
        Reason::NotPredicted,
        Row {
            case: &[("plant", "load = 200.0\nload_dependent_friction = 0.2")],
            remedies: &[Logged],
        },
    ),
    (
        Reason::LacksBacklash,
        Row {
            case: &[("plant", "coulomb = 30.0\nbacklash = 0.015")],
            remedies: &[Followed("remove the play", &[("plant", "backlash = 0.0")])],
        },
    ),
    (
        // In the coupling: small lines find the motor alone.
        Reason::LacksBacklash,
        Row {
            case: &[(
                "plant",
                "coulomb = 100.0\nresonance = 300.0\ninertia_ratio = 0.5\nbacklash = 0.006",
            )],
            remedies: &[Followed("remove the play", &[("plant", "backlash = 0.0")])],
        },
    ),
    (
        Reason::LacksLowSpeedFriction,
        Row {
            case: &[
                (
                    "=plant",
                    "a = 0.39\nb = 81.0\ncoulomb = 26.0\nlow_speed_friction = 130.0\nlow_speed_velocity = 1.0",
                ),
                (
                    "=commission",
                    "travel = 2.0\nspeed = 100.0\nsample_time = 0.001\nresponse_time = 0.1",
                ),
            ],
            remedies: &[
                Followed(
                    "lubricate",
                    &[("=plant", "a = 0.39\nb = 81.0\ncoulomb = 26.0")],
                ),
                Logged,
            ],
        },
    ),
    (
        Reason::LacksRipple,
        Row {
            case: &[("plant", "ripple = [80.0, 0.0]\nripple_order = 12")],
            remedies: &[
                Logged,
                Followed("reduce the cogging", &[("plant", "ripple = [20.0, 0.0]")]),
            ],
        },
    ),
    (
        Reason::ResponseTimeMissed,
        Row {
            case: &[
                (
                    "=plant",
                    "a = 0.663\nb = 58.4\ncoulomb = 29.9\nlow_speed_friction = 85.3\nlow_speed_velocity = 0.17",
                ),
                ("=encoder", "counts_per_rev = 2000"),
                (
                    "=commission",
                    "travel = 0.606\nspeed = 23.2\nsample_time = 0.001",
                ),
            ],
            remedies: &[
                Followed(
                    "check for stiction",
                    &[("=plant", "a = 0.663\nb = 58.4\ncoulomb = 29.9")],
                ),
                NotHere(
                    "play: 250 drawn axes with play ended with reason 122 or kept their promise",
                ),
            ],
        },
    ),
    (
        Reason::ResponseTimeMissed,
        Row {
            case: &[(
                "[fault]",
                "kind = \"load-step\"\ntime = 4.45\nsize = 1000.0",
            )],
            remedies: &[Followed("a changed load", &[("=[fault]", "")])],
        },
    ),
    (
        Reason::OvershootExceeded,
        Row {
            case: &[
                (
                    "=plant",
                    "a = 0.405\nb = 29.7\ncoulomb = 25.1\nlow_speed_friction = 28.7\nlow_speed_velocity = 0.265",
                ),
                ("=encoder", "counts_per_rev = 4096"),
                (
                    "=commission",
                    "travel = 0.218\nspeed = 26.5\nsample_time = 0.001",
                ),
            ],
            remedies: &[Followed(
                "check for stiction",
                &[("=plant", "a = 0.405\nb = 29.7\ncoulomb = 25.1")],
            )],
        },
    ),
    (
        Reason::OvershootExceeded,
        Row {
            case: &[("[fault]", "kind = \"load-step\"\ntime = 4.56\nsize = 300.0")],
            remedies: &[Followed("a changed load", &[("=[fault]", "")])],
        },
    ),
    (
        Reason::OvershootExceeded,
        Row {
            case: &[(
                "[fault]",
                // After the step, and before the one back.
                "kind = \"actuator-weak\"\ntime = 4.66\nsize = 0.5",
            )],
            remedies: &[Followed(
                "a gain of the amplifier that changes",
                &[("=[fault]", "")],
            )],
        },
    ),
    (
        Reason::DisturbanceExceeded,
        Row {
            case: &[
                (
                    "=plant",
                    "a = 1.773\nb = 210.1\ncoulomb = 204.7\nlow_speed_friction = 379.5\nlow_speed_velocity = 0.03",
                ),
                ("=encoder", "counts_per_rev = 2000"),
                (
                    "=commission",
                    "travel = 1.044\nspeed = 49.7\nsample_time = 0.001",
                ),
            ],
            remedies: &[Followed(
                "check for stiction",
                &[("=plant", "a = 1.773\nb = 210.1\ncoulomb = 204.7")],
            )],
        },
    ),
    (
        Reason::DisturbanceExceeded,
        Row {
            case: &[(
                "[fault]",
                "kind = \"load-step\"\ntime = 4.76\nsize = 1000.0",
            )],
            remedies: &[Followed("a changed load", &[("=[fault]", "")])],
        },
    ),
    (
        Reason::NeverAtRest,
        Row {
            case: &[
                (
                    "=plant",
                    "a = 0.316\nb = 112.1\nresonance = 44.8\ninertia_ratio = 0.73",
                ),
                ("=encoder", "counts_per_rev = 65536"),
                ("=amplifier", "limit = 5.0"),
                (
                    "=commission",
                    "travel = 1.045\nspeed = 61.55\nsample_time = 0.001",
                ),
            ],
            remedies: &[Followed(
                "a compliant coupling",
                &[("=plant", "a = 0.316\nb = 112.1")],
            )],
        },
    ),
    (
        Reason::Reversed,
        Row {
            case: &[("plant", "delay = 0.01")],
            remedies: &[
                Followed("declare its delay", &[("amplifier", "delay = 0.01")]),
                NotHere("phases or tracks are exchanged"),
            ],
        },
    ),
    (
        Reason::Oscillating,
        Row {
            case: &[("plant", "current_loop = 0.0165")],
            remedies: &[
                Followed(
                    "quicken the current loop",
                    &[("plant", "current_loop = 0.002")],
                ),
                // The loop gives way to delays of 6 ms that nothing declares.
                NotHere("declare or shorten the delay"),
            ],
        },
    ),
    (
        Reason::TimeOver,
        Row {
            case: &[
                ("=plant", "a = 0.2174\nb = 20.0"),
                ("commission", "duration = 0.03"),
            ],
            remedies: &[Followed(
                "allow more time",
                &[("commission", "duration = 0.5")],
            )],
        },
    ),
];

/// The remedies of the reasons why a first fit does not succeed: those that a motion can follow.
const OBSTACLES: [(Reason, Row); 5] = [
    (
        Reason::TooLittleMotion,
        Row {
            case: &[(
                "=excitation",
                "kind = \"multisine\"\namplitudes = [0.003]\nfrequencies = [3.0]",
            )],
            remedies: &[Followed("let it move further", LIVELY)],
        },
    ),
    (
        Reason::OneWayMotion,
        Row {
            case: &[
                ("=plant", "a = 5.0\nb = 257.7\nload = 100.0\ncoulomb = 5.0"),
                (
                    "=controller",
                    "kp = 0.01\nkd = 0.19\nki = 0.0\nsample_time = 0.001",
                ),
                ("=excitation", "kind = \"none\""),
                ("identifier", "noise = 0.05"),
            ],
            remedies: &[Followed(
                "let it turn back",
                &[("=controller", SERVO[3].1), ("=excitation", SERVO[4].1)],
            )],
        },
    ),
    (
        Reason::ConstantCommand,
        Row {
            case: &[
                ("=plant", "a = 5.0\nb = 257.7\nload = 100.0\ncoulomb = 5.0"),
                ("=amplifier", "limit = 0.05"),
                STIFF,
                ("=excitation", "kind = \"none\""),
            ],
            remedies: &[Followed(
                "let the servo accelerate and brake",
                &[
                    ("=amplifier", SERVO[2].1),
                    ("=controller", SERVO[3].1),
                    ("=excitation", SERVO[4].1),
                ],
            )],
        },
    ),
    (
        Reason::EarlyCommand,
        Row {
            case: &[("amplifier", "delay = 0.003")],
            remedies: &[
                Followed("declare no longer delay", &[("amplifier", "delay = 0.0")]),
                NotHere("record the command that acts"),
            ],
        },
    ),
    (
        Reason::PartlyExplained,
        Row {
            case: &[("plant", "gravity = [1000.0, 500.0]")],
            remedies: &[Followed("identify it with the law fit", FIT)],
        },
    ),
];

/// Why the remedy of any other reason is not followed here.
fn needs_hands(reason: Reason) -> Option<&'static str> {
    use Reason as R;
    Some(match reason {
        R::ClockNotStable | R::SelfTestFailed | R::ImageDamaged => {
            "the chip or its program is replaced"
        }
        R::ResetByWatchdog | R::Overrun => "of a chip: tested on the emulated one",
        R::AmplifierFault
        | R::SupplyLow
        | R::ActuatorFailed
        | R::ActuatorDead
        | R::ActuatorWeak => "amplifier, supply or wires are mended",
        R::LimitSwitch
        | R::LimitSwitchesStuck
        | R::HomeSwitchStuck
        | R::HomeNotFound
        | R::IndexNotFound => "a switch or its wire is mended",
        R::EncoderLost
        | R::EncoderSilent
        | R::EncoderStuck
        | R::EncoderNoise
        | R::EncoderJumped
        | R::OutOfReach => "the encoder or its wires are mended",
        R::FollowingError => "phases or tracks are exchanged",
        R::LinkLost => "the line is mended",
        R::StepsTooFast | R::StepsUnclear | R::TargetOutside => {
            "the source of the target is changed"
        }
        R::DoesNotFollow => "amplifier or log are those of another axis",
        R::InertiaChanged
        | R::ViscousFrictionChanged
        | R::CoulombFrictionChanged
        | R::LoadChanged => "the axis is changed back or commissioned again",
        R::Stopped | R::ModeChanged | R::PowerLost => "it is ordered again",
        R::EstimateAtBound => "units and counts of a simulated axis are those that are stated",
        _ => return None,
    })
}

/// A scenario: `base` with the lines of each list, one after the other.
fn scenario(base: &[Lines], changes: [&[Lines]; 2]) -> String {
    let mut tables: Vec<(&str, String)> = base
        .iter()
        .map(|(name, text)| (*name, (*text).to_owned()))
        .collect();
    for (name, text) in changes.into_iter().flatten() {
        let (name, replaces) = name
            .strip_prefix('=')
            .map_or((*name, false), |name| (name, true));
        let place = tables
            .iter()
            .position(|(known, _)| *known == name)
            .expect("a table of the base");
        let table = &mut tables[place].1;
        if replaces {
            table.clear();
        }
        // A key that is stated again is stated anew.
        let keys: BTreeSet<&str> = text
            .lines()
            .filter_map(|line| line.split(" =").next())
            .collect();
        let kept = table
            .lines()
            .filter(|line| !keys.contains(line.split(" =").next().unwrap_or_default()));
        *table = kept
            .chain(text.lines())
            .fold(String::new(), |table, line| table + line + "\n");
    }
    let stated = tables.iter().filter(|(_, text)| !text.is_empty());
    stated.fold(String::new(), |mut all, (name, text)| {
        let _ = writeln!(all, "[{name}]\n{text}");
        all
    })
}

/// A run of a scenario: its result, and all that was printed.
fn identified(folder: &Path, text: &str) -> (Value, String) {
    let [file, json] = ["scenario.toml", "result.json"].map(|name| folder.join(name));
    std::fs::write(&file, text).expect("written");
    let [file, json] = [&file, &json].map(|path| argument(path));
    let output = servo_id(&["run", &file, "--json", &json, "--force"]);
    assert!(
        output.status.success(),
        "{text}\n{}",
        standard_error(&output)
    );
    let result = std::fs::read_to_string(&json).expect("a result");
    (
        serde_json::from_str(&result).expect("JSON"),
        printed(&output),
    )
}

/// Asserts that the remedies of a row are printed for its case, and that the servo is identified after each.
fn assert_followed(folder: &Path, row: &Row, check: impl Fn(&Value)) {
    let (before, text) = identified(folder, &scenario(&SERVO, [row.case, &[]]));
    check(&before);
    assert_ne!(before["status"], "converged", "{text}");
    for remedy in row.remedies {
        let Followed(says, lines) = remedy else {
            continue;
        };
        assert!(text.contains(says), "{says:?} is not in\n{text}");
        let (after, text) = identified(folder, &scenario(&SERVO, [row.case, lines]));
        assert_eq!(after["status"], "converged", "{says}: {text}");
    }
}

/// True if a remedy of the row is followed; any other is marked with a reason.
fn is_followed(row: &Row) -> bool {
    let mut followed = 0;
    for remedy in row.remedies {
        match remedy {
            Followed(..) | Logged => followed += 1,
            NotHere(why) => assert!(!why.is_empty()),
        }
    }
    followed > 0
}

#[test]
fn a_servo_whose_effect_is_named_is_identified_once_the_remedy_is_followed() {
    let folder = folder("advice-causes");
    let mut followed = 0;
    for &of in Cause::ALL {
        let row = cause(of);
        if !is_followed(&row) {
            continue;
        }
        followed += 1;
        assert_followed(&folder, &row, |before| {
            // Of a model without a delay a current loop is one.
            if of != Cause::CurrentLoop {
                assert_eq!(before["cause"]["name"], of.name(), "{of:?}");
                assert_eq!(before["code"], 40, "{of:?}: {}", before["reason"]);
            }
        });
        for remedy in row.remedies {
            if let Followed(says, _) = remedy {
                assert!(of.remedy().contains(says), "{of:?}: {says}");
            }
        }
    }
    assert!(followed >= 18, "{followed}");
}

#[test]
fn a_verdict_becomes_converged_once_its_remedy_is_followed() {
    let folder = folder("advice-verdicts");
    let of_table = VERDICTS.iter().map(|(code, _)| *code);
    let codes: BTreeSet<u8> = of_table.chain([40]).collect();
    assert_eq!(codes, BTreeSet::from(VerdictReason::CODES));
    for (code, row) in VERDICTS.iter().filter(|(_, row)| is_followed(row)) {
        assert_followed(&folder, row, |before| {
            assert_eq!(before["code"], *code, "{}", before["reason"]);
        });
    }
}

#[test]
fn a_first_fit_succeeds_once_the_remedy_of_its_obstacle_is_followed() {
    let folder = folder("advice-obstacles");
    for (reason, row) in &OBSTACLES {
        assert_followed(&folder, row, |before| {
            assert_eq!(before["code"], 20, "{}", before["reason"]);
            assert_eq!(before["obstacle"]["name"], reason.name());
        });
        for remedy in row.remedies {
            if let Followed(says, _) = remedy {
                assert!(reason.remedy().contains(says), "{reason:?}: {says}");
            }
        }
    }
}

/// Scenarios in a row, each with a gain and an instant of its fault that are larger by so much than those of the last.
const NEIGHBOURS: u32 = 26;
const NEXT: f64 = 0.002;

/// The neighbour of a scenario so many steps away.
fn neighbour(text: &str, step: u32) -> String {
    let factor = 1.0 + NEXT * f64::from(step);
    let line = |line: &str| match line.split_once(" = ") {
        Some((name @ ("b" | "time"), value)) => {
            let value: f64 = value.parse().expect("a number");
            format!("{name} = {}\n", factor * value)
        }
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

fn commissioned(folder: &Path, text: &str) -> Output {
    let file = folder.join("scenario.toml");
    std::fs::write(&file, text).expect("written");
    servo_id(&["commission", &argument(&file)])
}

#[test]
fn a_commissioning_succeeds_once_the_remedy_of_its_reason_is_followed() {
    let folder = folder("advice-reasons");
    let mut wrong = Vec::new();
    for (reason, row) in &COMMISSIONED {
        // Some reasons are rare, and any change of a motion moves them to a neighbour.
        let ends_by_it = |&step: &u32| {
            let case = neighbour(&scenario(&AXIS, [row.case, &[]]), step);
            let output = commissioned(&folder, &case);
            !output.status.success() && standard_error(&output).contains(&reason.to_string())
        };
        let Some(step) = (0..NEIGHBOURS).find(ends_by_it) else {
            wrong.push(format!("{reason:?}: none ends by it"));
            continue;
        };
        for remedy in row.remedies {
            match remedy {
                Followed(says, lines) => {
                    assert!(reason.remedy().contains(says), "{reason:?}: {says}");
                    let case = neighbour(&scenario(&AXIS, [row.case, lines]), step);
                    let output = commissioned(&folder, &case);
                    let said = standard_error(&output);
                    if !output.status.success() {
                        wrong.push(format!("{reason:?}: {says}: {said}"));
                    }
                }
                Logged => {
                    let says = "record a log and identify it with the law fit";
                    assert!(reason.remedy().contains(says), "{reason:?}");
                    assert_logged(&folder, row);
                }
                NotHere(_) => {}
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Asserts that the servo of a commissioning's case is identified from a log of it.
fn assert_logged(folder: &Path, row: &Row) {
    const LOGGED: &[Lines] = &[("=run", "duration = 5.0")];
    let servo: Vec<Lines> = row
        .case
        .iter()
        .filter(|(name, _)| name.trim_start_matches('=') == "plant")
        .copied()
        .collect();
    let mut base = SERVO;
    base[0] = AXIS[0];
    let [file, log] = ["logged.toml", "log.csv"].map(|name| folder.join(name));
    std::fs::write(&file, scenario(&base, [&servo, LOGGED])).expect("written");
    let [file, log] = [&file, &log].map(|path| argument(path));
    assert_done(&servo_id(&["run", &file, "--csv", &log, "--force"]));
    let output = servo_id(&["identify", &log, "--require", "converged"]);
    assert!(
        output.status.success(),
        "{servo:?}: {}",
        standard_error(&output)
    );
}

#[test]
fn a_log_is_predicted_once_the_estimates_come_from_motions_like_it() {
    let folder = folder("advice-predicted");
    let brake = "low_speed_friction = 25.0\nlow_speed_velocity = 100.0\n";
    let [free, like, other] = [(1, ""), (2, brake), (3, brake)]
        .map(|(seed, effects)| predict::log_of(&folder, seed, 1e-3, effects));
    let scenario = argument(&predict::scenario(
        &folder,
        predict::ALL,
        predict::CONTROLLER,
    ));
    let json = folder.join("result.json");
    let verdict = |learnt: &Path| {
        let [learnt, other, json] = [learnt, other.as_path(), json.as_path()].map(argument);
        let output = servo_id(&[
            "identify",
            &learnt,
            "--scenario",
            &scenario,
            "--predict",
            &other,
            "--json",
            &json,
            "--force",
        ]);
        let text = std::fs::read_to_string(&json).unwrap_or_default();
        let result: Value = serde_json::from_str(&text).expect("a result");
        (result["code"].as_u64(), printed(&output))
    };
    let (code, text) = verdict(&free);
    assert_eq!(code, Some(43), "{text}");
    let says = "Learn from motions like those that are to be predicted";
    assert!(text.contains(says), "{text}");
    assert_eq!(verdict(&like).0, Some(0));
}

#[test]
fn every_reason_has_a_remedy_that_is_followed_or_needs_hands() {
    for &reason in Reason::ALL {
        let mut rows = COMMISSIONED.iter().chain(&OBSTACLES);
        let is_followed = rows.any(|(followed, _)| *followed == reason);
        let hands = needs_hands(reason);
        assert!(is_followed != hands.is_some(), "{reason:?}: {hands:?}");
    }
}
