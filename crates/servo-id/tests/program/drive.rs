//! The first power-on of the firmware's manual, step by step, on a simulated axis with a hand on its
//! shaft, and everything else that a person does to a drive from the command line.

use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::support::pages::root;
use crate::support::simulated_drive::{Hand, SERVO, SimulatedDrive, built_in};
use crate::support::{folder, servo_id, standard_error};
use drive_link::{Estimator, Receiver, Settings};
use identifier_core::settings::diagonal;
use servo_id::drive::{AtEnd, Client, Driven};
use servo_id::port::Port;

#[test]
fn the_test_of_a_board_compares_its_bits_and_has_no_cycles_where_none_are_counted() {
    let drive = SimulatedDrive::start(SERVO, example());
    drive.with(|around| around.supply = true);
    let folder = folder("board_test");
    let test = |ports: &[&str]| {
        let script = root().join("tests/hil/run");
        let ran = Command::new(script)
            .args(ports)
            .env("SERVO_ID", env!("CARGO_BIN_EXE_servo-id"))
            .env_remove("SERVO_ID_PORT")
            .current_dir(&folder)
            .output()
            .expect("it starts");
        assert!(ran.status.success(), "{}", standard_error(&ran));
        String::from_utf8_lossy(&ran.stdout).into_owned()
    };
    assert!(test(&[]).starts_with("skipped"));
    let printed = test(&[&drive.port]);
    assert!(printed.contains("not measured"), "{printed}");
    let sent = std::fs::read_to_string(folder.join("board-test.json")).expect("a file to send");
    let sent: serde_json::Value = serde_json::from_str(&sent).expect("JSON");
    assert_eq!(sent["board"], "simulated");
    assert_eq!(sent["same_bits"], true);
    assert_eq!(sent["bits"][0], "3ff0a2dd2a400000");
    assert_eq!(sent["protocol"], drive_link::PROTOCOL);
    assert!(sent["sample_cycles"].is_null() && sent["interrupt_cycles"].is_null());
    assert!(sent["sample_instructions"]["mean"].as_u64() > Some(100));
}

/// The settings of a drive that was never configured, with the gradient estimator.
fn example() -> Settings {
    let mut settings = built_in(Estimator::Gradient { friction: true });
    settings.closed_loop.core.identifier.gamma = Some(diagonal([20.0, 3000.0, 100.0, 0.0]));
    // This machine may be busy.
    settings.protection.link_timeout = 20.0;
    settings
}

/// A person at the drive's command line.
struct Person {
    drive: SimulatedDrive,
    scenario: String,
}

impl Person {
    fn before_a_drive(test: &str) -> Self {
        let scenario = folder(test).join("my-servo.toml").display().to_string();
        let person = Self {
            drive: SimulatedDrive::start(SERVO, example()),
            scenario,
        };
        person.write(10.0, "kind = \"none\"");
        person
    }

    /// Writes the scenario.
    fn write(&self, limit: f64, excitation: &str) {
        let text = format!(
            "[plant]\na = 0.2\nb = 250.0\n[encoder]\ncounts_per_rev = 10000\n\
             [amplifier]\nlimit = {limit}\n\
             [controller]\nkp = 9.0\nkd = 0.19\nki = 4.0\nsample_time = 0.001\n\
             velocity_filter = {{ kind = \"low-pass\", cutoff = 500.0 }}\n\
             [excitation]\n{excitation}\n\
             [identifier]\nlaw = \"gauss-newton\"\n\
             parameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n\
             [run]\nduration = 10.0\n"
        );
        std::fs::write(&self.scenario, text).expect("the scenario is written");
    }

    fn arguments<'a>(&'a self, words: &'a str) -> Vec<&'a str> {
        let mut arguments = vec!["drive", "--port", &self.drive.port];
        arguments.extend(words.split_whitespace().map(|word| {
            if word == "my-servo.toml" {
                self.scenario.as_str()
            } else {
                word
            }
        }));
        arguments
    }

    /// Types a command that must succeed, and returns its output.
    fn does(&self, words: &str) -> String {
        let output = servo_id(&self.arguments(words));
        assert!(
            output.status.success(),
            "{words}: {}",
            standard_error(&output)
        );
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Types a command that must fail with this status, and reads why.
    fn fails(&self, status: i32, words: &str) -> String {
        let output = servo_id(&self.arguments(words));
        assert_eq!(output.status.code(), Some(status), "{words}");
        standard_error(&output)
    }

    /// Types a command that keeps running.
    fn begins(&self, words: &str) -> Child {
        as_from_a_terminal()
            .args(self.arguments(words))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts")
    }

    /// Waits for a running command: exit status, standard output and standard error.
    fn ends(child: Child) -> (Option<i32>, String, String) {
        let output = child.wait_with_output().expect("it ends");
        let answer = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code(), answer, standard_error(&output))
    }
}

#[test]
fn the_first_power_on_of_the_manual_works_step_by_step() {
    let person = Person::before_a_drive("first_power_on");
    let drive = &person.drive;

    // 1. Who is there?
    let answer = person.does("status");
    assert!(answer.contains("disabled: the servo coasts"), "{answer}");
    assert!(
        answer.contains("not configured: it does not start"),
        "{answer}"
    );
    let refused = person.fails(1, "start");
    assert!(refused.contains("configure it first"), "{refused}");

    // 2. Declare the servo, with tight protections.
    // The manual's words, and a longer link timeout: this machine may be busy.
    let tight = "configure my-servo.toml --following-error 0.2 --travel 0.5 --pace 0.5 --speed 20 \
                 --link-timeout 20";
    person.does(tight);
    assert!(!person.does("status").contains("not configured"));

    // 3. The encoder: no supply, a hand turns the axis by up to 0.1 rad, then beyond 0.2.
    let start = person.begins("start");
    drive.wait_until_driven();
    drive.pass(0.5);
    for position in [0.02, 0.05, 0.1] {
        drive.with(|around| around.hand = Hand::Holds(position));
        drive.pass(2.0);
    }
    drive.with(|around| around.hand = Hand::Holds(0.21));
    let (status, answer, why) = Person::ends(start);
    // 159 counts of 10 000.
    assert!(
        answer.contains("position 0.0999"),
        "it counts upwards: {answer}"
    );
    assert_eq!(status, Some(1));
    assert!(why.contains("fault 22:"), "not {why}");
    assert_eq!(drive.with(|around| around.held), None);
    person.does("clear");
    drive.with(|around| around.hand = Hand::Off);

    // 4. A tenth of the command.
    person.write(1.0, "kind = \"none\"");
    person.does(tight);

    // 5. Supply on, but with the motor's leads swapped: it runs away, by 0.2 rad and no further.
    drive.with(|around| (around.supply, around.leads) = (true, -1.0));
    let from = drive.with(|around| around.position);
    let start = person.begins("start");
    drive.wait_until_driven();
    drive.pass(0.5);
    // A touch is enough to make it run.
    drive.with(|around| around.hand = Hand::Holds(from + 0.01));
    drive.pass(0.05);
    drive.with(|around| around.hand = Hand::Off);
    let (status, _, why) = Person::ends(start);
    assert_eq!(status, Some(1));
    assert!(why.contains("fault 22:"), "not {why}");
    person.does("clear");
    drive.pass(3.0);

    // Leads right: it holds its place against the hand.
    drive.with(|around| around.leads = 1.0);
    let from = drive.with(|around| around.position);
    let start = person.begins("start --for 6");
    drive.wait_until_driven();
    drive.pass(1.0);
    drive.with(|around| around.hand = Hand::Holds(from + 0.1));
    drive.pass(1.0);
    let pushes_back = drive.with(|around| around.held).expect("it is driven");
    assert!(pushes_back < -0.5, "{pushes_back}");
    drive.with(|around| around.hand = Hand::Off);
    drive.pass(2.0);
    let back = drive.with(|around| around.position);
    assert!((back - from).abs() < 0.01, "{back} from {from}");
    let (status, answer, why) = Person::ends(start);
    assert_eq!(status, Some(0), "{why}");
    assert!(answer.contains("the last run was stopped"), "{answer}");

    // 6. The whole command, and a dither: too large a one for the protections is refused.
    person.write(10.0, "kind = \"prbs\"\namplitude = 0.1\nhold = 0.05");
    let refused = person.fails(2, tight);
    assert!(
        refused.contains("following_error = 0.2 is too small"),
        "{refused}"
    );
    person.write(10.0, "kind = \"prbs\"\namplitude = 0.05\nhold = 0.05");
    person.does(tight);
    let answer = person.does("start --for 3");
    let mut lines = answer.lines();
    let known = lines
        .find(|line| line.starts_with("estimates: "))
        .expect("it says what it knows");
    let b: f64 = known
        .split("b ")
        .nth(1)
        .and_then(|rest| rest.split_whitespace().next())
        .and_then(|number| number.parse().ok())
        .expect("a number");
    assert!((b / SERVO.b - 1.0).abs() < 0.05, "{known}");

    // 7. Kept through a loss of power.
    person.does("save");
    drive.cycle_power();
    let answer = person.does("status");
    assert!(answer.contains("a record is stored"), "{answer}");
    assert!(
        answer.contains(known.trim_start_matches("estimates: ")),
        "{answer}"
    );
}

#[test]
fn an_excitation_that_the_drive_lacks_is_refused_by_name() {
    let person = Person::before_a_drive("unknown_excitation");
    person.write(10.0, "kind = \"square\"\namplitude = 0.1\nperiod = 1.0");
    let refused = person.fails(2, "configure my-servo.toml");
    assert!(
        refused.contains("excitation.kind: the drive has \"prbs\" and \"none\""),
        "{refused}"
    );
    assert!(person.does("status").contains("not configured"));
}

#[test]
fn a_refused_setting_names_the_option_that_states_it() {
    let person = Person::before_a_drive("refused_setting");
    person.write(10.0, "kind = \"prbs\"\namplitude = 1.3\nhold = 0.05");
    let refused = person.fails(2, "configure my-servo.toml");
    assert!(refused.contains("--following-error states it"), "{refused}");
    person.does("configure my-servo.toml --following-error 5 --travel 10");
}

#[test]
fn a_term_that_the_scenario_requires_is_estimated_and_kept_by_the_drive() {
    let person = Person::before_a_drive("drive_terms");
    person.drive.with(|around| around.supply = true);
    person.write(10.0, "kind = \"prbs\"\namplitude = 0.05\nhold = 0.05");
    let text = std::fs::read_to_string(&person.scenario).expect("just written");
    let law = "law = \"gauss-newton\"\n";
    let with_terms = text.replace(law, &format!("{law}required_terms = [\"asymmetry\"]\n"));
    std::fs::write(&person.scenario, with_terms).expect("the scenario is written");
    person.does("configure my-servo.toml --following-error 0.2 --link-timeout 20");
    let answer = person.does("start --for 10");
    let known = answer
        .lines()
        .find(|line| line.starts_with("estimates: "))
        .expect("it says what it knows");
    assert!(
        known.contains(", asymmetry ") && known.contains(" ± "),
        "{known}"
    );
    person.does("save");
    person.drive.cycle_power();
    let status = person.does("status");
    assert!(status.contains(known), "{status}");
}

#[test]
fn a_program_that_is_killed_leaves_an_axis_that_comes_to_rest() {
    let person = Person::before_a_drive("killed");
    let drive = &person.drive;
    drive.with(|around| around.supply = true);
    person.write(10.0, "kind = \"prbs\"\namplitude = 0.05\nhold = 0.05");
    person.does("configure my-servo.toml --link-timeout 4");
    let mut start = person.begins("start");
    drive.wait_until_driven();
    // Alive as long as the program runs, several times the timeout.
    drive.pass(10.0);
    assert!(drive.with(|around| around.held).is_some());
    start.kill().expect("it runs");
    start.wait().expect("it has ended");
    drive.pass(6.0);
    assert_eq!(drive.with(|around| around.held), None);
    let answer = person.does("status");
    assert!(answer.contains("fault 40:"), "{answer}");

    // `--leave` needs a setting that permits it.
    let refused = person.fails(2, "start --leave");
    assert!(refused.contains("--link-timeout 0"), "{refused}");
    person.does("clear");
    person.does("configure my-servo.toml --link-timeout 0 --duration 4");
    person.does("start --leave");
    drive.pass(2.0);
    assert!(drive.with(|around| around.held).is_some());
    drive.pass(4.0);
    assert_eq!(drive.with(|around| around.held), None);
    let answer = person.does("status");
    assert!(answer.contains("ended when its time was over"), "{answer}");
}

#[test]
fn who_drives_keeps_a_run_alive_and_who_looks_does_not() {
    let person = Person::before_a_drive("looking_on");
    let drive = &person.drive;
    drive.with(|around| around.supply = true);
    person.does("configure my-servo.toml --link-timeout 4");
    let client = Client::new(Port::open(&drive.port).expect("it listens"));
    let mut driven = Driven::new(client, 4.0 / 2.0, AtEnd::Stop);
    driven.start().expect("started");
    let none = driven.next_within(Duration::from_secs(4), |_| None::<()>);
    assert!(none.expect("the line is whole").is_none());
    assert!(drive.with(|around| around.held).is_some());
    driven.leave();
    drop(driven);
    for _ in 0..8 {
        person.does("status");
        drive.pass(1.0);
    }
    assert_eq!(drive.with(|around| around.held), None);
    let answer = person.does("status");
    assert!(answer.contains("fault 40:"), "{answer}");
}

/// Sends a signal to a program.
#[cfg(unix)]
fn signal(to: &Child, name: &str) {
    let sent = Command::new("kill")
        .args([name, &to.id().to_string()])
        .status();
    assert!(sent.is_ok_and(|status| status.success()));
}

#[test]
#[cfg(unix)]
fn a_signal_and_an_error_stop_a_run_and_an_order_to_leave_it_does_not() {
    let person = Person::before_a_drive("start_ended");
    let drive = &person.drive;
    drive.with(|around| around.supply = true);
    // The line is silent for much less.
    person.does("configure my-servo.toml --link-timeout 60");
    for name in ["-INT", "-TERM", "-HUP"] {
        let start = person.begins("start");
        drive.wait_until_driven();
        signal(&start, name);
        let (status, _, why) = Person::ends(start);
        assert_eq!(status, Some(130), "{name}: {why}");
        assert!(why.contains("interrupted; the servo is disabled"), "{why}");
        assert_eq!(drive.with(|around| around.held), None, "{name}");
        let answer = person.does("status");
        assert!(answer.contains("the last run was stopped"), "{answer}");
    }
    let why = person.fails(1, "start --home");
    assert!(why.contains("--home-seek first"), "{why}");
    assert!(why.contains("the servo is disabled"), "{why}");
    assert_eq!(drive.with(|around| around.held), None);

    // Without a link timeout, nothing would stop it if the program were killed.
    person.does("configure my-servo.toml --link-timeout 0");
    for words in ["start", "start --for 1"] {
        let refused = person.fails(2, words);
        assert!(refused.contains("--leave"), "{refused}");
    }
    assert_eq!(drive.with(|around| around.held), None);
    person.does("start --leave");
    person.fails(2, "target 1000");
    person.does("target 0.1");
    assert!(drive.with(|around| around.held).is_some(), "it is left");
    assert!(person.does("stop").contains("disabled"));
    assert_eq!(drive.with(|around| around.held), None);
}

/// A line to a drive from which nothing comes back once this is set, and the numbers of the stops on it.
#[cfg(unix)]
fn half_a_line(to: &str) -> (String, Arc<AtomicBool>, Arc<Mutex<BTreeSet<u8>>>) {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
    let port = format!("tcp:{}", listener.local_addr().expect("it has an address"));
    let to = TcpStream::connect(to.trim_start_matches("tcp:")).expect("the drive listens");
    let (is_deaf, stops) = (Arc::<AtomicBool>::default(), Arc::default());
    let (cut, heard) = (
        Arc::clone(&is_deaf),
        Arc::<Mutex<BTreeSet<u8>>>::clone(&stops),
    );
    std::thread::spawn(move || {
        let (mut program, _) = listener.accept().expect("the program connects");
        let mut back = program.try_clone().expect("a socket");
        let mut drive = to.try_clone().expect("a socket");
        std::thread::spawn(move || {
            let mut bytes = [0; 1024];
            while let Ok(read @ 1..) = drive.read(&mut bytes) {
                if !cut.load(Ordering::Relaxed) && back.write_all(&bytes[..read]).is_err() {
                    return;
                }
            }
        });
        let (mut drive, mut receiver) = (to, Receiver::new());
        let mut bytes = [0; 1024];
        while let Ok(read @ 1..) = program.read(&mut bytes) {
            for &byte in &bytes[..read] {
                if let Some(Ok(request)) = receiver.take_request(byte)
                    && request.command == drive_link::Command::Stop
                {
                    heard.lock().expect("no panic").insert(request.id);
                }
            }
            drive.write_all(&bytes[..read]).expect("the drive listens");
        }
    });
    (port, is_deaf, stops)
}

#[test]
#[cfg(unix)]
fn a_second_signal_sends_the_stop_again_and_ends_the_program() {
    let person = Person::before_a_drive("start_twice_interrupted");
    let drive = &person.drive;
    drive.with(|around| around.supply = true);
    person.does("configure my-servo.toml --link-timeout 60");
    let (port, is_deaf, stops) = half_a_line(&drive.port);
    let start = as_from_a_terminal()
        .args(["drive", "--port", &port, "start"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drive.wait_until_driven();
    is_deaf.store(true, Ordering::Relaxed);
    signal(&start, "-INT");
    let begin = Instant::now();
    while stops.lock().expect("no panic").is_empty() {
        assert!(begin.elapsed() < Duration::from_secs(60), "no stop");
        std::thread::sleep(Duration::from_millis(2));
    }
    signal(&start, "-INT");
    let (status, _, why) = Person::ends(start);
    assert_eq!((status, why.as_str()), (Some(130), ""));
    assert_eq!(stops.lock().expect("no panic").len(), 2);
    drive.pass(0.1);
    assert_eq!(drive.with(|around| around.held), None);
}

/// The program, with no signal ignored: the parent of these tests may ignore some.
fn as_from_a_terminal() -> Command {
    let program = env!("CARGO_BIN_EXE_servo-id");
    if cfg!(target_os = "linux") {
        let mut command = Command::new("env");
        command.args(["--default-signal=INT,TERM,HUP", program]);
        command
    } else {
        Command::new(program)
    }
}

/// Waits until a recording has some rows.
fn wait_for_rows(folder: &Path) {
    /// Of some dozens of rows.
    const SIZE: u64 = 4096;
    let begin = Instant::now();
    let has_rows = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.expect("an entry");
        let name = entry.file_name().to_string_lossy().into_owned();
        name.starts_with(".servo-id-") && entry.metadata().is_ok_and(|file| file.len() > SIZE)
    };
    while !std::fs::read_dir(folder).expect("a folder").any(has_rows) {
        assert!(begin.elapsed() < Duration::from_secs(60), "no rows");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_recording_is_kept_however_it_ends() {
    let person = Person::before_a_drive("recording");
    let drive = &person.drive;
    drive.with(|around| around.supply = true);
    person.write(10.0, "kind = \"none\"");
    person.does("configure my-servo.toml --link-timeout 0");
    person.does("start --leave");
    let folder = folder("recording_rows");
    let file = folder.join("rows.csv");
    let words = format!(
        "watch --every 10 --reports 1000000 --csv {}",
        file.display()
    );
    let recording = person.begins(&words);
    wait_for_rows(&folder);
    assert!(!file.exists(), "not before it is whole");
    let script = format!("kill -INT {}", recording.id());
    let sent = Command::new("sh").args(["-c", &script]).status();
    assert!(sent.expect("a shell").success());
    let (status, answer, why) = Person::ends(recording);
    assert_eq!((status, answer.as_str()), (Some(1), ""), "{why}");
    assert!(why.contains("of 1000000 reports"), "{why}");
    let whole = |text: &str| text.lines().all(|row| row.split(',').count() == 9);
    let first = std::fs::read_to_string(&file).expect("kept");
    assert!(first.lines().count() > 10 && whole(&first), "{first}");

    let refused = person.fails(2, &words);
    assert!(refused.contains("--force"), "{refused}");

    // The line breaks, here because the drive serves one host and another connects.
    let recording = person.begins(&format!("{words} --force"));
    wait_for_rows(&folder);
    person.does("stop");
    let (status, _, why) = Person::ends(recording);
    assert_eq!(status, Some(1));
    assert!(why.contains("the connection is closed"), "{why}");
    let second = std::fs::read_to_string(&file).expect("kept");
    assert!(second != first && whole(&second), "{second}");

    // Nothing was recorded: the earlier recording stays.
    person.fails(1, &format!("{words} --force"));
    assert_eq!(std::fs::read_to_string(&file).expect("kept"), second);
    assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 1);
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_is_ended_when_its_output_cannot_be_read() {
    let person = Person::before_a_drive("full_output");
    let drive = &person.drive;
    drive.with(|around| around.supply = true);
    person.does("configure my-servo.toml --link-timeout 20");
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    let output = Command::new(env!("CARGO_BIN_EXE_servo-id"))
        .args(person.arguments("start --for 1.5"))
        .stdout(full.expect("there"))
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(1));
    let why = standard_error(&output);
    assert!(why.contains("standard output cannot be written"), "{why}");
    assert_eq!(drive.with(|around| around.held), None);
    let answer = person.does("status");
    assert!(answer.contains("the last run was stopped"), "{answer}");
}

/// The tables that a user adds to the scenario for a commissioning.
const COMMISSION: &str = "[plant]\na = 0.2\nb = 250.0\n[encoder]\ncounts_per_rev = 10000\n\
    [amplifier]\nlimit = 10.0\n\
    [commission]\ntravel = 1.5\nspeed = 40.0\nsample_time = 0.001\nbandwidth = 40.0\n";

#[test]
fn an_unknown_servo_is_commissioned_from_the_command_line() {
    let person = Person::before_a_drive("commission_drive");
    std::fs::write(&person.scenario, COMMISSION).expect("the scenario is written");
    person.drive.with(|around| around.supply = true);
    let output = servo_id(&person.arguments("commission my-servo.toml"));
    let progress = standard_error(&output);
    assert!(output.status.success(), "{progress}");
    let answer = String::from_utf8_lossy(&output.stdout);
    let first = answer.lines().next().unwrap_or_default();
    assert!(first.contains("moves at most from -1.5"), "{answer}");
    assert!(
        answer.contains(
            "applied: the new gains are in force, and stored in flash; the servo is disabled"
        ),
        "{answer}"
    );
    for phase in ["probe", "fit", "frequency-response", "gains", "trial"] {
        assert!(progress.contains(phase), "{phase}: {progress}");
    }
    assert!(progress.contains("rad, command "), "{progress}");
    let status = person.does("status");
    assert!(status.contains("as commissioned"), "{status}");
    assert!(status.contains("commissioning: applied"), "{status}");
    // After the power was off, a start closes the loop with them.
    person.drive.cycle_power();
    assert!(person.does("status").contains("as commissioned"));
    assert!(person.does("start --for 0.5").contains("estimates: "));
    let state: serde_json::Value =
        serde_json::from_str(&person.does("status --json -")).expect("JSON");
    assert_eq!(
        (&state["status"], &state["code"]),
        (&"disabled".into(), &0.into())
    );
    assert!(state["gains"]["kp"].as_f64().is_some_and(|kp| kp > 0.0));
    assert!(state["servo_change"].is_null());
    // Again, and the result as JSON.
    let again = person.does("commission my-servo.toml --json -");
    let json: serde_json::Value = serde_json::from_str(&again).expect("JSON");
    assert_eq!(
        (&json["status"], &json["code"]),
        (&"applied".into(), &0.into())
    );
    assert_eq!(json["kept"], true);
    let b = json["servo"]["b"]["value"].as_f64().expect("a number");
    assert!((b / SERVO.b - 1.0).abs() < 0.02, "{b}");
}

#[test]
fn a_commissioning_that_is_refused_or_fails_names_reason_and_remedy() {
    let person = Person::before_a_drive("commission_fails");
    let write = |text: &str| std::fs::write(&person.scenario, text).expect("it is written");
    write(&COMMISSION.replace("travel = 1.5", "travel = 0.0001"));
    let why = person.fails(2, "commission my-servo.toml");
    assert!(why.contains("commission.travel"), "{why}");
    assert!(person.drive.with(|around| around.held).is_none());
    // Without the motor's supply nothing moves.
    write(COMMISSION);
    let why = person.fails(1, "commission my-servo.toml");
    assert!(why.contains("reason 101:"), "{why}");
    // A demand beyond the servo is refused with a possible figure.
    person.drive.with(|around| around.supply = true);
    write(&COMMISSION.replace("bandwidth = 40.0", "bandwidth = 150.0"));
    let why = person.fails(1, "commission my-servo.toml");
    let would_do = "a bandwidth of 150.0 rad/s is too high for the servo: the encoder's noise in the command allows 1";
    assert!(
        why.contains("reason 130:") && why.contains(would_do),
        "{why}"
    );
    let output = servo_id(&person.arguments("commission my-servo.toml --json -"));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let most = json["no_gains"]["most"].as_f64().expect("a figure");
    assert!((100.0..150.0).contains(&most), "{most}");
    assert_eq!(json["no_gains"]["cap"], "encoder-noise");
    // Another sample time than that of the configured drive.
    write(&COMMISSION.replace("sample_time = 0.001", "sample_time = 0.0005"));
    let why = person.fails(2, "commission my-servo.toml");
    assert!(why.contains("sample_time"), "{why}");
}

#[test]
fn a_running_loop_is_commissioned_and_continues() {
    let person = Person::before_a_drive("commission_beside");
    person.drive.with(|around| around.supply = true);
    person.does("configure my-servo.toml --link-timeout 0 --travel 50 --speed 100");
    person.does("start --leave");
    std::fs::write(&person.scenario, COMMISSION).expect("the scenario is written");
    let answer = person.does("commission my-servo.toml");
    let runs_on = "applied: the new gains are in force, and stored in flash as soon as the servo is disabled; the \
                   loop keeps running";
    assert!(answer.contains(runs_on), "{answer}");
    let status = person.does("status");
    assert!(status.starts_with("running"), "{status}");
    assert!(status.contains("as commissioned"), "{status}");
    person.does("stop");
    person.drive.pass(0.1);
    assert!(person.does("status").contains("disabled"));
    person.drive.cycle_power();
    assert!(person.does("status").contains("as commissioned"));
}

#[test]
#[cfg(unix)]
fn an_interruption_stops_a_commissioning() {
    let person = Person::before_a_drive("commission_interrupted");
    std::fs::write(&person.scenario, COMMISSION).expect("the scenario is written");
    person.drive.with(|around| around.supply = true);
    let begun = person.begins("commission my-servo.toml");
    person.drive.wait_until_driven();
    person.drive.pass(0.02);
    let killed = Command::new("kill")
        .args(["-INT", &begun.id().to_string()])
        .status();
    assert!(killed.is_ok_and(|status| status.success()));
    let (status, _, why) = Person::ends(begun);
    assert_eq!(status, Some(1), "{why}");
    assert!(why.contains("reason 170:"), "{why}");
    assert!(person.drive.with(|around| around.held).is_none());
}

#[test]
fn an_axis_is_driven_home_and_its_targets_come_from_where_they_are_configured_to() {
    let person = Person::before_a_drive("homing");
    let drive = &person.drive;
    drive.with(|around| around.supply = true);
    let configure = "configure my-servo.toml --travel 2 --pace 1 --speed 20 --link-timeout 20";

    // Without a way home.
    let refused = person.fails(2, &format!("{configure} --home-approach 0.1"));
    assert!(refused.contains("--home-seek"), "{refused}");
    person.does(configure);
    let start = person.begins("start --home");
    let (status, _, why) = Person::ends(start);
    assert_eq!(status, Some(1), "{why}");
    assert!(why.contains("--home-seek first"), "{why}");
    person.does("stop");

    // The switch closes 0.2 rad below the start.
    let refused = person.fails(2, &format!("{configure} --home-seek -1 --home-offset 3"));
    assert!(refused.contains("homing.offset"), "{refused}");
    person.does(&format!("{configure} --home-seek -1 --home-offset 0.1"));
    let answer = person.does("status");
    assert!(
        answer.contains("homing: seeks the switch at -1 rad/s, approaches the switch at 0.1 rad/s"),
        "{answer}"
    );
    assert!(answer.contains("not homed"), "{answer}");
    let answer = person.does("start --home --for 1");
    assert!(
        answer.contains("homed: positions count from the origin"),
        "{answer}"
    );
    assert!(person.does("status").contains("\nhomed: "));
    let position = drive.with(|around| around.position);
    assert!((position + 0.2).abs() < 0.05, "{position}");

    // Options that are not given stay, and a speed of 0 takes the way home away.
    person.does(&format!("{configure} --home-offset 0.2"));
    let answer = person.does("status");
    assert!(answer.contains("the origin is 0.2 rad from"), "{answer}");
    assert!(answer.contains("not homed"), "{answer}");
    person.does(&format!("{configure} --home-seek 0 --source steps:0.001"));
    let answer = person.does("status");
    assert!(!answer.contains("homing: seeks"), "{answer}");
    assert!(answer.contains("step input, 0.001 rad"), "{answer}");
    let refused = person.fails(2, &format!("{configure} --source voltage:2.1"));
    assert!(refused.contains("steps:RAD"), "{refused}");
    let refused = person.fails(2, &format!("{configure} --source pulses"));
    assert!(refused.contains("steps:RAD"), "{refused}");

    let start = person.begins("start --for 5");
    drive.wait_until_driven();
    let refused = person.fails(1, "target 0.1");
    assert!(refused.contains("--source line"), "{refused}");
    person.does("stop");
    Person::ends(start);
}
