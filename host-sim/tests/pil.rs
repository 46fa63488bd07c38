//! Processor in the loop, the processor being a thread at the other end of a TCP port.

mod support;

use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::thread;

use drive_link::{Question, Receiver, frame};
use drive_logic::LockStep;
use host_sim::experiment::Sample;
use host_sim::pil;
use host_sim::port::Port;
use host_sim::scenario::{Purpose, Scenario};
use host_sim::simulate;
use support::{folder, servo_id, standard_error};

/// A chip that answers one host, and the address of its port. The line spoils an answer now and then.
fn chip(spoilt: &'static [u32]) -> String {
    chip_that_is_reset(u32::MAX, spoilt)
}

/// The same, reset after so many answers.
fn chip_that_is_reset(after: u32, spoilt: &'static [u32]) -> String {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
    let address = listener.local_addr().expect("it has an address");
    thread::spawn(move || {
        let (line, _) = listener.accept().expect("a host comes");
        serve(line, after, spoilt);
    });
    format!("tcp:{address}")
}

fn serve(mut line: TcpStream, reset_after: u32, spoilt: &[u32]) {
    line.set_nodelay(true).expect("a socket");
    let mut receiver = Receiver::new();
    let mut lock_step = LockStep::new();
    let mut answers = 0;
    let mut bytes = [0; 512];
    loop {
        let count = match line.read(&mut bytes) {
            Ok(0) | Err(_) => return,
            Ok(count) => count,
        };
        for &byte in &bytes[..count] {
            if let Some(Ok(question)) = receiver.take::<Question>(byte) {
                if answers == reset_after {
                    lock_step = LockStep::new();
                }
                let mut framed = frame(&lock_step.answer(&question)).expect("it fits");
                if spoilt.contains(&answers) {
                    framed[3] ^= 0x55;
                }
                answers += 1;
                if line.write_all(&framed).is_err() {
                    return;
                }
            }
        }
    }
}

fn scenario(test: &str, change: impl Fn(String) -> String) -> String {
    let paper = include_str!("../scenarios/paper.toml");
    let path = folder(test).join("scenario.toml");
    let text = change(paper.replace("duration = 60.0", "duration = 5.0"));
    std::fs::write(&path, text).expect("the scenario is written");
    path.display().to_string()
}

#[test]
fn a_commissioning_elsewhere_is_the_simulators_to_the_bit_in_spite_of_a_bad_line() {
    let text = include_str!("../scenarios/commission.toml");
    let path = folder("pil-commission").join("scenario.toml");
    std::fs::write(
        &path,
        format!("{text}\n[identifier]\narithmetic = \"f32\"\n"),
    )
    .expect("the scenario is written");
    let scenario = Scenario::load(&path, Purpose::Commission).expect("valid");
    let begun = || pil::commissioning(&scenario).expect("valid");
    let mut expected = Vec::new();
    let outcome = begun()
        .run(&mut |sample| expected.push(*sample))
        .expect("it runs");
    let mut port = Port::open(&chip(&[3, 40, 41])).expect("it is there");
    let mut found = Vec::new();
    let there = pil::commission(begun(), &mut port, &mut |sample| found.push(*sample));
    assert_eq!(there.expect("it runs"), outcome);
    assert!(found.len() > 100, "{} samples", found.len());
    assert_eq!(found, expected);
}

#[test]
fn the_loop_elsewhere_gives_the_same_bits_in_spite_of_a_bad_line() {
    for arithmetic in ["f32", "fixed"] {
        let path = scenario(&format!("pil-{arithmetic}"), |text| {
            text.replace(
                "arithmetic = \"f32\"",
                &format!("arithmetic = \"{arithmetic}\""),
            )
        });
        let scenario = Scenario::load(Path::new(&path), Purpose::Run).expect("valid");
        assert_eq!(scenario.identifier.arithmetic.name(), arithmetic);
        let mut here: Vec<Sample> = Vec::new();
        simulate::run(&scenario, &mut |sample| here.push(*sample)).expect("valid");

        let mut port = Port::open(&chip(&[0, 1000])).expect("it listens");
        let mut there = Vec::new();
        let outcome =
            pil::run(&scenario, &mut port, &mut |sample| there.push(*sample)).expect("it answers");
        assert_eq!(outcome.samples, 5000);
        assert_eq!(there.len(), 5000);
        assert!(here == there, "{arithmetic}: bit for bit");
    }
}

/// Of a and b alone, which is what the firmware has in fixed point; what friction and load stay within
/// is not stated and has to be sent.
#[test]
fn bounds_that_follow_from_the_box_are_sent() {
    let path = folder("pil-drift").join("scenario.toml");
    let drift = include_str!("../scenarios/drift.toml");
    let text = drift
        .replace("[\"a\", \"b\", \"coulomb\"]", "[\"a\", \"b\"]")
        .replace("duration = 60.0", "duration = 2.0");
    std::fs::write(&path, text).expect("the scenario is written");
    let scenario = Scenario::load(&path, Purpose::Run).expect("valid");
    assert!(scenario.stated.identifier.bounds.coulomb.is_none());
    let sent = pil::loop_settings(&scenario).expect("the firmware has it");
    let bounds = &sent.core.identifier.bounds;
    assert!(bounds.coulomb.is_some() && bounds.load.is_some());

    let mut here: Vec<Sample> = Vec::new();
    simulate::run(&scenario, &mut |sample| here.push(*sample)).expect("valid");
    let mut port = Port::open(&chip(&[])).expect("it listens");
    let mut there = Vec::new();
    pil::run(&scenario, &mut port, &mut |sample| there.push(*sample)).expect("it answers");
    assert_eq!(there.len(), 2000);
    assert!(here == there, "bit for bit");
}

/// What the chip would refuse, or worse, take no notice of.
#[test]
fn terms_and_what_is_declared_of_the_amplifier_are_refused_before_a_chip_is_asked() {
    let path = folder("pil-terms").join("scenario.toml");
    for (key, asked) in [
        ("identifier.terms", "terms = [\"delay\"]"),
        ("identifier.required_terms", "required_terms = [\"delay\"]"),
        ("amplifier.delay", "[amplifier]\ndelay = 1e-3"),
        ("amplifier.dead_band", "[amplifier]\ndead_band = 0.1"),
        ("amplifier.current_loop", "[amplifier]\ncurrent_loop = 1e-3"),
    ] {
        let text = format!(
            "[plant]\na = 0.5\nb = 250.0\n[identifier]\nlaw = \"gauss-newton\"\n\
             arithmetic = \"f32\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n{asked}\n"
        );
        std::fs::write(&path, text).expect("the scenario is written");
        let scenario = Scenario::load(&path, Purpose::Run).expect("a PC can");
        let fault = pil::loop_settings(&scenario).expect_err(key);
        assert!(fault.to_string().starts_with(key), "{fault}");
    }
}

#[test]
fn a_run_without_a_sample_is_an_error() {
    let path = scenario("pil-empty", |text| text);
    let mut scenario = Scenario::load(Path::new(&path), Purpose::Run).expect("valid");
    scenario.duration = 0.0;
    let mut port = Port::open(&chip(&[])).expect("it listens");
    let fault =
        pil::run(&scenario, &mut port, &mut |_| panic!("a sample")).expect_err("nothing to run");
    assert!(fault.to_string().contains("run.duration"), "{fault}");
}

#[test]
fn a_chip_that_is_reset_ends_the_run_and_what_was_seen_before_stands() {
    let path = scenario("pil-reset", |text| text);
    let scenario = Scenario::load(Path::new(&path), Purpose::Run).expect("valid");
    // Its first answer is to the settings.
    let address = chip_that_is_reset(101, &[]);
    let mut port = Port::open(&address).expect("it listens");
    let mut seen = Vec::new();
    let fault =
        pil::run(&scenario, &mut port, &mut |sample| seen.push(*sample)).expect_err("it was reset");
    assert!(fault.to_string().contains("reset in the middle"), "{fault}");
    assert_eq!(seen.len(), 100);
}

#[test]
fn the_verb_prints_what_run_prints() {
    let path = scenario("pil-verb", |text| text);
    let run = servo_id(&["run", &path, "--json", "-"]);
    let pil = servo_id(&["pil", &path, "--port", &chip(&[]), "--json", "-"]);
    assert_eq!(pil.status.code(), Some(0), "{}", standard_error(&pil));
    let result = |output: &std::process::Output| {
        let mut result: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let origin = result["origin"].take();
        assert_eq!(origin["scenario"]["file"], path.as_str());
        result
    };
    assert_eq!(result(&pil), result(&run));
}

#[test]
fn what_the_firmware_cannot_do_is_refused_before_anybody_is_asked() {
    let cases = [
        (
            "kind = \"low-pass\", cutoff = 500.0",
            "kind = \"difference\"",
            "velocity_filter",
        ),
        (
            "counts_per_rev = 10000",
            "counts_per_rev = 0",
            "counts_per_rev",
        ),
        ("arithmetic = \"f32\"", "arithmetic = \"f64\"", "arithmetic"),
        ("law = \"gradient\"", "law = \"window\"", "law"),
    ];
    for (k, (from, to, key)) in cases.into_iter().enumerate() {
        let path = scenario(&format!("pil-refused-{k}"), |text| {
            let changed = text.replace(from, to);
            assert_ne!(changed, text, "{from}");
            let lean = |text: String| {
                let gradients = ["gamma", "mu", "plant_box"];
                let keeps = |line: &&str| !gradients.iter().any(|key| line.starts_with(key));
                text.lines().filter(keeps).collect::<Vec<_>>().join("\n")
            };
            if key == "law" { lean(changed) } else { changed }
        });
        let output = servo_id(&["pil", &path, "--port", "tcp:127.0.0.1:1"]);
        let answer = standard_error(&output);
        assert_eq!(output.status.code(), Some(2), "{answer}");
        assert!(answer.contains(key), "{key}: {answer}");
    }
}

#[test]
fn a_port_that_is_none_is_bad_input_and_a_silent_one_is_not() {
    let path = scenario("pil-port", |text| text);
    for port in ["tcp:127.0.0.1:1", "/dev/no-such-port"] {
        let commands: [&[&str]; 2] = [
            &["pil", &path, "--port", port],
            &["drive", "--port", port, "status"],
        ];
        for arguments in commands {
            let output = servo_id(arguments);
            let answer = standard_error(&output);
            assert_eq!(output.status.code(), Some(2), "{answer}");
            assert!(
                answer.contains(port) && answer.contains("cannot be opened"),
                "{answer}"
            );
        }
    }
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
    let silent = format!("tcp:{}", listener.local_addr().expect("it has an address"));
    let output = servo_id(&["drive", "--port", &silent, "status"]);
    let answer = standard_error(&output);
    assert_eq!(output.status.code(), Some(1), "{answer}");
    assert!(answer.contains("nobody answers"), "{answer}");
}
