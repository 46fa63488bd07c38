//! `drive stop` before it knows anything about the drive.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener};
use std::process::{Output, Stdio};
use std::sync::mpsc::channel;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use drive_link::{Command, Estimator, PROTOCOL, Receiver, Refusal, Report, Request, State, frame};

use crate::drive::as_from_a_terminal;
use crate::support::simulated_drive::built_in;
use crate::support::status::status;
use crate::support::{servo_id, signal, standard_error};

/// A drive that answers so: its port, and what it receives until its line is closed.
fn answering(
    answer: impl Fn(usize, &Request) -> Option<Report> + Send + 'static,
) -> (String, JoinHandle<Vec<Command>>) {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
    let port = format!("tcp:{}", listener.local_addr().expect("it has an address"));
    let drive = thread::spawn(move || {
        let (mut line, _) = listener.accept().expect("the program connects");
        let (mut receiver, mut received) = (Receiver::new(), Vec::new());
        let mut bytes = [0; 64];
        while let Ok(read @ 1..) = line.read(&mut bytes) {
            for &byte in &bytes[..read] {
                let Some(request) = receiver.take_request(byte) else {
                    continue;
                };
                let request = request.expect("a whole request");
                if let Some(report) = answer(received.len(), &request) {
                    let framed = frame(&report).expect("it fits");
                    let _ = line.write_all(&framed);
                }
                received.push(request.command);
            }
        }
        received
    });
    (port, drive)
}

/// Runs `drive stop` at a drive that answers so, and returns what the drive has received.
fn stop(
    answer: impl Fn(usize, &Request) -> Option<Report> + Send + 'static,
) -> (Output, Vec<Command>) {
    let (port, drive) = answering(answer);
    let output = servo_id(&["drive", "--port", &port, "stop"]);
    (output, drive.join().expect("no panic"))
}

#[test]
#[cfg(unix)]
fn a_second_signal_sends_the_stop_again_and_ends_the_program() {
    const WAIT: Duration = Duration::from_secs(60);
    let (heard, requests) = channel();
    let (port, drive) = answering(move |_, &Request { id, command, .. }| {
        if matches!(command, Command::Start | Command::Stop) {
            heard.send((command, id)).expect("the test listens");
        }
        let id = (command != Command::Stop).then_some(id)?;
        Some(match command {
            Command::Show => Report::Settings {
                id,
                settings: built_in(Estimator::GaussNewton),
            },
            Command::Hello | Command::KeepAlive => Report::Status {
                id: Some(id),
                status: status(State::Running),
            },
            _ => Report::Done { id },
        })
    });
    let start = as_from_a_terminal()
        .args(["drive", "--port", &port, "start"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let begun = requests.recv_timeout(WAIT).expect("a start");
    assert_eq!(begun.0, Command::Start);
    signal(start.id(), "-INT");
    let (_, first) = requests.recv_timeout(WAIT).expect("a stop");
    signal(start.id(), "-INT");
    let output = start.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130));
    assert_eq!(standard_error(&output), "");
    drive.join().expect("no panic");
    let again = requests.try_iter().find(|(_, id)| *id != first);
    assert_eq!(again.map(|(command, _)| command), Some(Command::Stop));
}

fn is_stop(command: &Command) -> bool {
    *command == Command::Stop
}

#[test]
fn a_drive_that_cannot_be_heard_receives_stops_before_any_question() {
    let (output, received) = stop(|_, _| None);
    assert_eq!(output.status.code(), Some(1));
    let why = standard_error(&output);
    assert!(why.contains("none was acknowledged"), "{why}");
    let first = received.iter().position(|command| !is_stop(command));
    let stops = first.expect("then it asks");
    assert!((2..=51).contains(&stops), "{received:?}");
}

#[test]
fn a_drive_of_another_version_is_stopped() {
    let (output, received) = stop(|place, &Request { id, command, .. }| match command {
        // The first is damaged.
        Command::Stop => (place > 0).then_some(Report::Done { id }),
        _ => Some(Report::Refused {
            id,
            refusal: Refusal::NotUnderstood {
                spoken: PROTOCOL + 1,
                given: PROTOCOL,
                bytes: 3,
            },
        }),
    });
    let why = standard_error(&output);
    assert_eq!(output.status.code(), Some(0), "{why}");
    let answer = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(answer.contains("has acknowledged the stop"), "{answer}");
    let version = format!("version {}", PROTOCOL + 1);
    assert!(answer.contains(&version), "{answer}");
    assert!(received.len() > 2 && received[..2].iter().all(is_stop));
}

/// The port is a terminal's, which can be locked as any other.
#[test]
#[cfg(unix)]
fn a_port_that_another_program_holds_is_said_with_the_way_that_stops_the_drive() {
    let pair = portable_pty::native_pty_system().openpty(portable_pty::PtySize::default());
    let pair = pair.expect("a pseudo-terminal");
    let name = pair.master.tty_name().expect("it has a name");
    let name = name.display().to_string();
    let _held = servo_id::port::Port::open(&name).expect("it is free");
    let output = servo_id(&["drive", "--port", &name, "stop"]);
    let why = standard_error(&output);
    assert_eq!(output.status.code(), Some(2), "{why}");
    for said in [name.as_str(), "another program holds", "Ctrl-C", "enable"] {
        assert!(why.contains(said), "{said}: {why}");
    }
}

/// Nothing is accepted at this address, and no more than one connection may wait.
#[test]
#[cfg(target_os = "linux")]
fn a_connection_that_nobody_answers_is_given_up() {
    use std::os::fd::AsRawFd;

    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
    // SAFETY: the descriptor is that of a listening socket; the call changes its queue only.
    let shortened = unsafe { libc::listen(listener.as_raw_fd(), 0) };
    assert_eq!(shortened, 0);
    let address = listener.local_addr().expect("it has an address");
    let _waits = std::net::TcpStream::connect(address).expect("one finds room");
    let begun = Instant::now();
    let output = servo_id(&["drive", "--port", &format!("tcp:{address}"), "stop"]);
    let why = standard_error(&output);
    assert_eq!(output.status.code(), Some(2), "{why}");
    assert!(why.contains("nothing answers within 5 s"), "{why}");
    // The system gives up after two minutes.
    assert!(begun.elapsed() < Duration::from_secs(60));
}
