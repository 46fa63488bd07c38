//! The first power-on of the firmware's manual, step by step, on a simulated axis with a hand on its
//! shaft, and everything else that a person does to a drive from the command line.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::pages::root;
use crate::support::simulated_drive::{Hand, SERVO, SimulatedDrive, built_in};
use crate::support::{Folder, number, own_folder, printed, signal, standard_error, table};
use drive_link::{Estimator, Settings};
use identifier_core::parameters::PerParameter;

#[test]
fn the_test_of_a_board_compares_its_bits_and_has_no_cycles_where_none_are_counted() {
    let drive = SimulatedDrive::start(SERVO, example());
    drive.with(|around| around.supply = true);
    let folder = own_folder();
    let test = |ports: &[&str]| {
        let script = root().join("tests/hil/run");
        let ran = Command::new(script)
            .args(ports)
            .env("SERVO_ID", env!("CARGO_BIN_EXE_servo-id"))
            .env_remove("SERVO_ID_PORT")
            .current_dir(&folder)
            .output()
            .expect("it starts");
        printed(&ran)
    };
    assert!(test(&[]).starts_with("skipped"));
    let answer = test(&[&drive.port]);
    assert!(answer.contains("not measured"), "{answer}");
    let sent = folder.read_json("board-test.json");
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
    settings.closed_loop.core.identifier.gamma = Some(PerParameter::new(20.0, 3000.0, 100.0, 0.0));
    // This machine may be busy.
    settings.protection.link_timeout = 20.0;
    settings
}

/// A person at the drive's command line.
struct Person {
    drive: SimulatedDrive,
    folder: Folder,
}

impl Person {
    /// Before a drive that was never configured, whose motor has its supply.
    fn before_a_drive() -> Self {
        let person = Self {
            drive: SimulatedDrive::start(SERVO, example()),
            folder: own_folder(),
        };
        person.drive.with(|around| around.supply = true);
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
        self.folder.write("my-servo.toml", text);
    }

    /// The words of a call that types this.
    fn words(&self, words: &str) -> String {
        format!("drive --port {} {words}", self.drive.port)
    }

    /// The command that is held.
    fn held(&self) -> Option<f32> {
        self.drive.with(|around| around.held)
    }

    /// Types a command that must succeed, and returns its output.
    fn does(&self, words: &str) -> String {
        self.folder.done(&self.words(words))
    }

    /// Types a command that must fail with this status, and reads why.
    fn fails(&self, status: i32, words: &str) -> String {
        let output = self.folder.call(&self.words(words));
        assert_eq!(output.status.code(), Some(status), "{words}");
        standard_error(&output)
    }

    /// Types commands that are refused as bad input: of each row, a command and a part of the answer.
    fn is_refused(&self, rows: &str) {
        for row in table(rows) {
            let why = self.fails(2, &row[0]);
            assert!(why.contains(&row[1]), "{row:?}: {why}");
        }
    }

    /// Asserts that the status shows this.
    fn sees(&self, part: &str) {
        let status = self.does("status");
        assert!(status.contains(part), "{part}: {status}");
    }

    /// Types a command that keeps running.
    fn begins(&self, words: &str) -> Child {
        as_from_a_terminal()
            .args(self.words(words).split(' '))
            .current_dir(&self.folder)
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
    let person = Person::before_a_drive();
    let drive = &person.drive;
    drive.with(|around| around.supply = false);

    // 1. Who is there?
    person.sees("disabled: the servo coasts");
    person.sees("not configured: it does not start");
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
    assert_eq!(person.held(), None);
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
    let pushes_back = person.held().expect("it is driven");
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
    person.is_refused(&format!("{tight} | following_error = 0.2"));
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
    person.sees("a record is stored");
    assert!(
        answer.contains(known.trim_start_matches("estimates: ")),
        "{answer}"
    );
}

#[test]
fn a_refused_setting_is_named_with_the_option_that_states_it() {
    let person = Person::before_a_drive();
    person.write(10.0, "kind = \"square\"\namplitude = 0.1\nperiod = 1.0");
    person.is_refused("configure my-servo.toml | excitation.kind");
    person.write(10.0, "kind = \"prbs\"\namplitude = 1.3\nhold = 0.05");
    person.is_refused("configure my-servo.toml | --following-error");
    person.sees("not configured");
    person.does("configure my-servo.toml --following-error 5 --travel 10");
}

#[test]
fn a_term_that_the_scenario_requires_is_estimated_and_kept_by_the_drive() {
    let person = Person::before_a_drive();
    person.write(10.0, "kind = \"prbs\"\namplitude = 0.05\nhold = 0.05");
    let text = person.folder.read("my-servo.toml");
    let law = "law = \"gauss-newton\"\n";
    let with_terms = text.replace(law, &format!("{law}required_terms = [\"asymmetry\"]\n"));
    person.folder.write("my-servo.toml", with_terms);
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
    person.sees(known);
}

#[test]
fn a_program_that_is_killed_leaves_an_axis_that_comes_to_rest() {
    let person = Person::before_a_drive();
    let drive = &person.drive;
    person.write(10.0, "kind = \"prbs\"\namplitude = 0.05\nhold = 0.05");
    person.does("configure my-servo.toml --link-timeout 4");
    let mut start = person.begins("start");
    drive.wait_until_driven();
    // Alive as long as the program runs, several times the timeout.
    drive.pass(10.0);
    assert!(person.held().is_some());
    start.kill().expect("it runs");
    start.wait().expect("it has ended");
    drive.pass(6.0);
    assert_eq!(person.held(), None);
    person.sees("fault 40:");

    // `--leave` needs a setting that permits it.
    person.is_refused("start --leave | --link-timeout 0");
    person.does("clear");
    person.does("configure my-servo.toml --link-timeout 0 --duration 4");
    person.does("start --leave");
    drive.pass(2.0);
    assert!(person.held().is_some());
    drive.pass(4.0);
    assert_eq!(person.held(), None);
    person.sees("ended when its time was over");
}

#[test]
#[cfg(unix)]
fn a_signal_and_an_error_stop_a_run_and_an_order_to_leave_it_does_not() {
    let person = Person::before_a_drive();
    let drive = &person.drive;
    // The line is silent for much less.
    person.does("configure my-servo.toml --link-timeout 60");
    for name in ["-INT", "-TERM", "-HUP"] {
        let start = person.begins("start");
        drive.wait_until_driven();
        signal(start.id(), name);
        let (status, _, why) = Person::ends(start);
        assert_eq!(status, Some(130), "{name}: {why}");
        assert!(why.contains("interrupted; the servo is disabled"), "{why}");
        assert_eq!(person.held(), None, "{name}");
        person.sees("the last run was stopped");
    }
    let why = person.fails(1, "start --home");
    assert!(why.contains("--home-seek first"), "{why}");
    assert!(why.contains("the servo is disabled"), "{why}");
    assert_eq!(person.held(), None);

    // Without a link timeout, nothing would stop it if the program were killed.
    person.does("configure my-servo.toml --link-timeout 0");
    person.is_refused(
        "start | --leave
        start --for 1 | --leave",
    );
    assert_eq!(person.held(), None);
    person.does("start --leave");
    person.fails(2, "target 1000");
    person.does("target 0.1");
    assert!(person.held().is_some(), "it is left");
    assert!(person.does("stop").contains("disabled"));
    assert_eq!(person.held(), None);
}

/// The program, with no signal ignored: the parent of these tests may ignore some.
pub(crate) fn as_from_a_terminal() -> Command {
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
fn wait_for_rows(folder: &Folder) {
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
    let person = Person::before_a_drive();
    person.does("configure my-servo.toml --link-timeout 0");
    person.does("start --leave");
    let words = "watch --every 10 --reports 1000000 --csv rows.csv";
    let recording = person.begins(words);
    wait_for_rows(&person.folder);
    let not_yet = !person.folder.join("rows.csv").exists();
    assert!(not_yet, "not before it is whole");
    signal(recording.id(), "-INT");
    let (status, answer, why) = Person::ends(recording);
    assert_eq!((status, answer.as_str()), (Some(1), ""), "{why}");
    assert!(why.contains("of 1000000 reports"), "{why}");
    let whole = |text: &str| text.lines().all(|row| row.split(',').count() == 9);
    let first = person.folder.read("rows.csv");
    assert!(first.lines().count() > 10 && whole(&first), "{first}");

    // The line breaks, here because the drive serves one host and another connects.
    let recording = person.begins(words);
    wait_for_rows(&person.folder);
    person.does("stop");
    let (status, _, why) = Person::ends(recording);
    assert_eq!(status, Some(1));
    assert!(why.contains("the connection is closed"), "{why}");
    let second = person.folder.read("rows.csv");
    assert!(second != first && whole(&second), "{second}");

    // Nothing was recorded: the earlier recording stays.
    person.fails(1, words);
    assert_eq!(person.folder.read("rows.csv"), second);
    assert_eq!(person.folder.names(), ["my-servo.toml", "rows.csv"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_is_ended_when_its_output_cannot_be_read() {
    let person = Person::before_a_drive();
    person.does("configure my-servo.toml --link-timeout 20");
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    let mut call = person.folder.program(&person.words("start --for 1.5"));
    let output = call.stdout(full.expect("there")).output();
    let output = output.expect("the program starts");
    assert_eq!(output.status.code(), Some(1));
    let why = standard_error(&output);
    assert!(why.contains("standard output cannot be written"), "{why}");
    assert_eq!(person.held(), None);
    person.sees("the last run was stopped");
}

/// The tables that a user adds to the scenario for a commissioning.
const COMMISSION: &str = "[plant]\na = 0.2\nb = 250.0\n[encoder]\ncounts_per_rev = 10000\n\
    [amplifier]\nlimit = 10.0\n\
    [commission]\ntravel = 1.5\nspeed = 40.0\nsample_time = 0.001\nbandwidth = 40.0\n";

#[test]
fn an_unknown_servo_is_commissioned_from_the_command_line() {
    let person = Person::before_a_drive();
    person.folder.write("my-servo.toml", COMMISSION);
    let output = person
        .folder
        .call(&person.words("commission my-servo.toml"));
    let progress = standard_error(&output);
    assert!(output.status.success(), "{progress}");
    let answer = String::from_utf8_lossy(&output.stdout);
    let first = answer.lines().next().unwrap_or_default();
    assert!(first.contains("moves at most from -1.5"), "{answer}");
    assert!(answer.contains("applied: "), "{answer}");
    for phase in ["probe", "fit", "frequency-response", "gains", "trial"] {
        assert!(progress.contains(phase), "{phase}: {progress}");
    }
    assert!(progress.contains("rad, command "), "{progress}");
    person.sees("as commissioned");
    person.sees("commissioning: applied");
    // After the power was off, a start closes the loop with them.
    person.drive.cycle_power();
    person.sees("as commissioned");
    assert!(person.does("start --for 0.5").contains("estimates: "));
    let state = person.folder.json(&person.words("status"));
    assert_eq!(state["status"], "disabled");
    assert_eq!(state["code"], 0);
    assert!(state["gains"]["kp"].as_f64().is_some_and(|kp| kp > 0.0));
    assert!(state["servo_change"].is_null());
    // Again, and the result as JSON.
    let json = person
        .folder
        .json(&person.words("commission my-servo.toml"));
    assert_eq!(json["status"], "applied");
    assert_eq!(json["code"], 0);
    assert_eq!(json["kept"], true);
    let b = number(&json, "/servo/b/value");
    assert!((b / SERVO.b - 1.0).abs() < 0.02, "{b}");
}

#[test]
fn an_axis_is_driven_home_and_its_targets_come_from_where_they_are_configured_to() {
    let person = Person::before_a_drive();
    let drive = &person.drive;
    let configure = "configure my-servo.toml --travel 2 --pace 1 --speed 20 --link-timeout 20";

    // Homing is not configured.
    person.is_refused(&format!("{configure} --home-approach 0.1 | --home-seek"));
    person.does(configure);
    let why = person.fails(1, "start --home");
    assert!(why.contains("--home-seek first"), "{why}");
    person.does("stop");

    // The switch closes 0.2 rad below the start.
    person.is_refused(&format!(
        "{configure} --home-seek -1 --home-offset 3 | homing.offset"
    ));
    person.does(&format!("{configure} --home-seek -1 --home-offset 0.1"));
    person.sees("homing: seeks the switch at -1 rad/s, approaches the switch at 0.1 rad/s");
    person.sees("not homed");
    let answer = person.does("start --home --for 1");
    assert!(
        answer.contains("homed: positions count from the origin"),
        "{answer}"
    );
    person.sees("\nhomed: ");
    let position = drive.with(|around| around.position);
    assert!((position + 0.2).abs() < 0.05, "{position}");

    // Options that are not given stay, and a speed of 0 takes homing away.
    person.does(&format!("{configure} --home-offset 0.2"));
    person.sees("the origin is 0.2 rad from");
    person.sees("not homed");
    person.does(&format!("{configure} --home-seek 0 --source steps:0.001"));
    assert!(!person.does("status").contains("homing: seeks"));
    person.sees("step input, 0.001 rad");
    for source in ["voltage:2.1", "pulses"] {
        person.is_refused(&format!("{configure} --source {source} | steps:RAD"));
    }

    let start = person.begins("start --for 5");
    drive.wait_until_driven();
    let refused = person.fails(1, "target 0.1");
    assert!(refused.contains("--source line"), "{refused}");
    person.does("stop");
    Person::ends(start);
}
