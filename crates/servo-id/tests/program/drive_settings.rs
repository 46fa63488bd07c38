//! The settings that a scenario sends to a drive, and refusals before anything is sent.

use host_sim::scenario::{Fault, Purpose, Scenario};
use identifier_core::parameters::{Term, Terms};
use servo_id::drive::{loop_settings, tables_of};

use crate::support::table;

/// The settings for a scenario of this text.
fn settings_of(text: &str) -> Result<drive_link::LoopSettings, Fault> {
    loop_settings(&Scenario::parse("s.toml", text, Purpose::Run).expect("a PC can"))
}

#[test]
fn required_terms_and_a_declared_amplifier_are_sent() {
    let text = "[plant]\na = 0.5\nb = 250.0\n[identifier]\nlaw = \"gauss-newton\"\n\
                arithmetic = \"f32\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n";
    let asked = format!("{text}required_terms = [\"delay\", \"gravity\"]\n");
    let sent = settings_of(&asked).expect("the firmware has them");
    let demanded = Terms::NONE.with(Term::Delay).with(Term::Gravity);
    assert_eq!(sent.core.identifier.terms.demanded, demanded);
    let amplifier = "[amplifier]\ndelay = 1e-3\ndead_band = 0.1\ncurrent_loop = 2e-3\n";
    let sent = settings_of(&format!("{text}{amplifier}")).expect("the firmware has it");
    let terms = &sent.core.identifier.terms;
    let declared = [terms.delay, terms.dead_band, terms.current_loop].map(f64::to_bits);
    assert_eq!(declared, [1e-3, 0.1, 2e-3_f64].map(f64::to_bits));
}

/// What is changed in the paper's scenario, to what, and the key that the answer names.
const LACKING: &str = r#"
kind = "low-pass", cutoff = 500.0 | kind = "difference" | controller.velocity_filter
counts_per_rev = 10000 | counts_per_rev = 0 | encoder.counts_per_rev
arithmetic = "f32" | arithmetic = "f64" | identifier.arithmetic
law = "gradient" | law = "pd-gradient" | identifier.law
arithmetic = "f32" | arithmetic = "fixed" | identifier.arithmetic
"#;

#[test]
fn the_status_shows_the_tables_that_send_the_same_settings() {
    let plant = "[plant]\na = 0.5\nb = 250.0\n";
    let certified = "[encoder]\ncounts_per_rev = 4096\n[amplifier]\nlimit = [-2.0, 3.0]\n\
                     [controller]\nkp = 8.0\nkd = 0.2\nki = 3.0\nsample_time = 5e-4\nnotch = 300.0\n\
                     reference_filter = 0.01\nfeed_forward = { bandwidth = 60.0, acceleration = 0.005 }\n\
                     velocity_filter = { kind = \"low-pass\", cutoff = 400.0 }\n\
                     [identifier]\nlaw = \"gradient\"\nparameters = [\"a\", \"b\", \"coulomb\"]\nmu = 3.0\n\
                     initial = { a = 1.0, b = 200.0, coulomb = 2.0 }\nbounds = { b = [90.0, 1100.0] }\n\
                     servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }\ngamma = [2.0, 3e3, 4.0]\n\
                     correction = { kp = 7.0, kd = 0.3, ki = 2.0 }\nmax_speed = 90.0\n";
    let fitting = "[amplifier]\ndelay = 1e-3\n[identifier]\nlaw = \"gauss-newton\"\nmemory = 5.0\n\
                   parameters = [\"a\", \"b\", \"coulomb\", \"load\"]\nrequired_terms = [\"delay\"]\n\
                   noise = 1e-3\nstart_time = 0.5\nbandwidth = 20.0\n";
    for text in ["", certified, fitting] {
        let sent = settings_of(&format!("{plant}{text}")).expect("the firmware has it");
        let shown = tables_of(&sent);
        assert_eq!(settings_of(&format!("{plant}{shown}")), Ok(sent), "{shown}");
    }
}

#[test]
fn a_loop_that_the_firmware_lacks_is_refused() {
    let paper = include_str!("../../../../host-sim/scenarios/paper.toml");
    let paper = paper.replace("law = \"paper\"", "law = \"gradient\"");
    for row in table(LACKING) {
        let changed = paper.replace(&row[0], &row[1]);
        assert_ne!(changed, paper, "{row:?}");
        let fault = settings_of(&changed).expect_err(&row[2]);
        assert!(fault.to_string().starts_with(&row[2]), "{fault}");
    }
}
