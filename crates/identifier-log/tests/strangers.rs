//! Columns as strangers log them: what is read without a question, and what a question may ask.

use std::path::Path;

use identifier_log::identify;
use identifier_log::log::{Log, Table};
use identifier_log::recognise::{LogOptions, Recognised, Unrecognised, recognise};
use identifier_log::scenario::{Column, CommandUnit};

const STEP: f64 = 2e-3;
const ROWS: usize = 3000;

/// Numbers from −1 to 1 in no order.
fn noise(k: usize) -> f64 {
    let mixed = (k as u64 ^ (k as u64 >> 7)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11;
    mixed as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Time, command, position and velocity of q̈ = 90 u − 6 q̇ − 4 sign q̇ in counts of 1 mrad; each seed has its own command.
fn servo(seed: usize) -> [Vec<f64>; 4] {
    damped(6.0, |row| 3.0 * noise(seed + row / 60))
}

/// The same with another damping, under a command by its row.
fn damped(damping: f64, command_of: impl Fn(usize) -> f64) -> [Vec<f64>; 4] {
    let [mut time, mut command, mut position, mut velocity] = [const { Vec::new() }; 4];
    let (mut q, mut v) = (0.0_f64, 0.0_f64);
    for row in 0..ROWS {
        let u = command_of(row);
        time.push(STEP * row as f64);
        command.push(u);
        position.push((1e3 * q).round() / 1e3);
        velocity.push((1e3 * v).round() / 1e3);
        for _ in 0..20 {
            v += STEP / 20.0 * (90.0 * u - damping * v - 4.0 * (v / 0.01).clamp(-1.0, 1.0));
            q += STEP / 20.0 * v;
        }
    }
    [time, command, position, velocity]
}

fn table(columns: &[(&str, &[f64])]) -> Table {
    let columns = columns.iter();
    let columns = columns.map(|(name, values)| ((*name).to_owned(), values.to_vec()));
    Table::of_columns("log", columns.collect()).expect("one length")
}

/// The same without a heading.
fn bare(columns: &[&[f64]]) -> Table {
    let rows = (0..columns[0].len()).map(|row| {
        let cells: Vec<String> = columns.iter().map(|of| of[row].to_string()).collect();
        cells.join(",") + "\n"
    });
    let text: String = rows.collect();
    Table::of_text(Path::new("log"), std::io::Cursor::new(text)).expect("a table")
}

fn found(table: &Table) -> Recognised {
    recognise(table, &LogOptions::default()).expect("a log")
}

fn of_position(name: &str) -> LogOptions {
    LogOptions {
        position: Some(name.to_owned()),
        ..LogOptions::default()
    }
}

fn is(recognised: &Recognised, position: &str, command: &str) -> bool {
    let named = |name: &str| Column::named(name);
    recognised.settings.position == named(position)
        && recognised.settings.command == Some(named(command))
}

#[test]
fn what_is_stated_is_not_asked() {
    let [time, command, position, _] = servo(0);
    // Names that speak against both.
    let table = table(&[("t", &time), ("temp", &position), ("speed", &command)]);
    let open = |stated: &LogOptions| match recognise(&table, stated) {
        Ok(_) => Vec::new(),
        Err(Unrecognised::Unknown(questions)) => questions.iter().map(|one| one.flag).collect(),
        Err(other) => panic!("{other}"),
    };
    let position = of_position("temp");
    assert_eq!(open(&LogOptions::default()), ["position", "command"]);
    assert_eq!(open(&position), ["command"]);
    let both = LogOptions {
        command: Some("speed".to_owned()),
        ..position
    };
    assert_eq!(open(&both), [""; 0]);
}

#[test]
fn a_velocity_without_a_name_is_told_by_its_motion_and_may_be_stated() {
    let [time, command, position, velocity] = servo(0);
    let by_motion = table(&[("t", &time), ("y", &velocity), ("u", &command)]);
    assert!(found(&by_motion).settings.is_velocity);
    let stated = LogOptions {
        velocity: Some("y".to_owned()),
        ..LogOptions::default()
    };
    // Even where the motion is that of a position.
    let other = table(&[("t", &time), ("y", &position), ("u", &command)]);
    assert!(!found(&other).settings.is_velocity);
    let found = recognise(&other, &stated).expect("a log");
    assert!(found.settings.is_velocity && is(&found, "y", "u"));
}

/// Much damping makes the velocity follow the command, which is no reason to take a position for a velocity.
#[test]
fn a_position_under_much_damping_is_no_velocity() {
    for damping in [20.0, 60.0, 180.0] {
        let [time, command, position, _] = damped(damping, |row| 3.0 * noise(row / 60));
        let table = table(&[("t", &time), ("y", &position), ("u", &command)]);
        assert!(!found(&table).settings.is_velocity, "{damping}");
    }
}

#[test]
fn a_time_that_begins_again_is_found_without_a_name() {
    let [time, command, position, _] = servo(0);
    let again: Vec<f64> = time.iter().map(|time| time % (STEP * 1000.0)).collect();
    let found = found(&bare(&[&again, &position, &command]));
    assert_eq!(found.settings.time, Some(Column::Number(1)));
    assert_eq!(found.settings.position, Column::Number(2));
}

#[test]
fn numbers_of_rows_are_no_time_unless_the_heading_says_so() {
    let [_, command, position, _] = servo(0);
    let rows: Vec<f64> = (0..ROWS).map(|row| row as f64).collect();
    for name in ["step", "seq", "cycle", "frame", "#", "Unnamed: 0", "sample"] {
        let numbered = table(&[(name, &rows), ("position", &position), ("u", &command)]);
        let asked = recognise(&numbered, &LogOptions::default());
        let Err(Unrecognised::Unknown(questions)) = asked else {
            panic!("{name}: {asked:?}");
        };
        assert_eq!(questions[0].flag, "sample-time", "{name}");
        let stated = LogOptions {
            sample_time: Some(STEP),
            ..LogOptions::default()
        };
        let found = recognise(&numbered, &stated).expect("a log");
        assert!(is(&found, "position", "u"), "{name}");
    }
    let timed = table(&[("t", &rows), ("position", &position), ("u", &command)]);
    assert_eq!(found(&timed).settings.time, Some(Column::named("t")));
}

/// A mass of one without friction moves as an accelerometer shows it: the name decides.
#[test]
fn an_acceleration_is_a_command_only_by_its_name() {
    let command: Vec<f64> = (0..ROWS).map(|row| 3.0 * noise(row / 60)).collect();
    let time: Vec<f64> = (0..ROWS).map(|row| STEP * row as f64).collect();
    let (mut q, mut v) = (0.0, 0.0);
    let mut position = Vec::new();
    for u in &command {
        position.push((1e5_f64 * q).round() / 1e5);
        q += STEP * (v + 0.5 * u * STEP);
        v += u * STEP;
    }
    let of = |name| table(&[("t", &time), ("q", &position), (name, &command)]);
    assert!(is(&found(&of("u")), "q", "u"));
    assert!(recognise(&of("ch2"), &LogOptions::default()).is_err());
}

#[test]
fn a_separator_behind_the_last_name_is_no_column() {
    let text = "time,position,command,\n0,0,1\n0.1,0.2,1\n0.2,0.5,-1\n";
    let table = Table::of_text(Path::new("log"), std::io::Cursor::new(text)).expect("a table");
    let names: Vec<&str> = table.columns.iter().map(|column| &*column.name).collect();
    assert_eq!(names, ["time", "position", "command"]);
}

#[test]
fn a_joint_is_driven_by_its_own_command_and_the_others_are_listed() {
    let [time, left, position_left, _] = servo(0);
    // Both are driven nearly alike.
    let own = |row: usize| left[row] + 0.2 * noise(5000 + row / 60);
    let [_, right, position_right, _] = damped(6.0, own);
    // The command of the other explains more than its own, which is measured.
    let measured: Vec<f64> = (0..ROWS)
        .map(|row| left[row] + 2.0 * noise(row + 70_000))
        .collect();
    let columns: [(&str, &[f64]); 5] = [
        ("t", &time),
        ("leftPos", &position_left),
        ("rightTorque", &right),
        ("leftTorque", &measured),
        ("rightPos", &position_right),
    ];
    let found = found(&table(&columns));
    assert!(is(&found, "leftPos", "leftTorque") || is(&found, "rightPos", "rightTorque"));
    let left = recognise(&table(&columns), &of_position("leftPos")).expect("a log");
    assert!(is(&left, "leftPos", "leftTorque"));
    let findings = &found.findings;
    let others = (findings.iter()).map(|of| of.text.matches("another servo: ").count());
    assert_eq!(others.sum::<usize>(), 1, "{findings:?}");
}

/// A logger that writes eight rows to its card after every eight: a gap that comes again is no break.
#[test]
fn a_gap_that_comes_again_and_again_is_bridged_and_one_that_does_not_is_none() {
    let [time, command, position, _] = servo(0);
    let kept = |is_kept: &dyn Fn(usize) -> bool| {
        let rows = (0..ROWS).filter(|row| is_kept(*row));
        let of = |values: &[f64]| rows.clone().map(|row| values[row]).collect::<Vec<_>>();
        let [t, q, u] = [&time, &position, &command].map(|values| of(values));
        let table = table(&[("t", &t), ("q", &q), ("u", &u)]);
        let log = Log::new(&table, &found(&table).settings, None);
        log.expect("a log").segments().len()
    };
    assert_eq!(kept(&|row| row % 14 < 8), 1);
    assert_eq!(kept(&|row| !(1000..1006).contains(&row)), 2);
}

/// A heading's unit in the reading, which table, JSON, Python, the page and the forms of gains have: it, or none, never another.
#[test]
fn a_reading_has_the_unit_of_each_heading_or_none() {
    /// Which column, its names in five languages, and units as written with what they are and the factor.
    type Family<'a> = (usize, [&'a str; 5], &'a [(&'a str, Option<(&'a str, f64)>)]);
    let families: [Family<'_>; 4] = [
        (
            0,
            ["time", "Zeit", "temps", "时间", "время"],
            &[
                ("s", Some(("s", 1.0))),
                ("ms", Some(("ms", 1e3))),
                ("µs", Some(("us", 1e6))),
                ("min", Some(("min", 1.0 / 60.0))),
                ("0.1ms", None),
            ],
        ),
        (
            1,
            ["torque", "Drehmoment", "couple", "转矩", "момент"],
            &[
                ("Nm", Some(("Nm", 1.0))),
                ("mNm", Some(("Nm", 1e-3))),
                ("mA", Some(("A", 1e-3))),
                ("kV", Some(("V", 1e3))),
                ("%", Some(("%", 1.0))),
                ("xNm", None),
            ],
        ),
        (
            2,
            ["position", "Lage", "posición", "位置", "положение"],
            &[
                ("rad", Some(("rad", 1.0))),
                ("mrad", Some(("rad", 1e-3))),
                ("mdeg", Some(("deg", 1e-3))),
                ("µm", Some(("m", 1e-6))),
                ("arcsec", Some(("deg", 1.0 / 3600.0))),
                ("furlong", None),
            ],
        ),
        (
            3,
            ["speed", "Drehzahl", "vitesse", "速度", "скорость"],
            &[
                ("rad/s", Some(("rad", 1.0))),
                ("krpm", Some(("turns", 1e3 / 60.0))),
                ("U/min", Some(("turns", 1.0 / 60.0))),
                ("deg/s", Some(("deg", 1.0))),
                ("erpm", None),
            ],
        ),
    ];
    let [time, command, position, velocity] = servo(0).map(|mut column| {
        column.truncate(1200);
        column
    });
    let mut headings = 0;
    for (place, names, units) in families {
        for (name, &(written, expected)) in names
            .iter()
            .flat_map(|name| units.iter().map(move |unit| (name, unit)))
        {
            let joined = written.replace('/', "_");
            let has_power = place == 3 && written.contains('U');
            for heading in [format!("{name} [{written}]"), format!("{name}_{joined}")] {
                if heading.contains('_') && (has_power || written.starts_with('0')) {
                    continue;
                }
                headings += 1;
                let mut own = [
                    ("t_s", time.clone()),
                    ("u", command.clone()),
                    ("q_rad", position.clone()),
                ];
                match place {
                    0 => {
                        let in_it = expected.map_or(1e4, |(_, of_a_second)| of_a_second);
                        own[0] = (&heading, time.iter().map(|time| in_it * time).collect());
                    }
                    3 => own[2] = (&heading, velocity.clone()),
                    _ => own[place].0 = &heading,
                }
                let own: Vec<(&str, &[f64])> =
                    own.iter().map(|(name, of)| (*name, &of[..])).collect();
                let read = match recognise(&table(&own), &LogOptions::default()) {
                    Ok(read) => read.reading,
                    Err(Unrecognised::Unknown(questions)) => {
                        let asked = (place, expected, questions[0].flag);
                        assert_eq!(asked, (0, None, "sample-time"), "{heading}");
                        continue;
                    }
                    Err(error) => panic!("{heading}: {error}"),
                };
                let of_command = read.command.as_ref().expect("a command");
                let of = [&read.time, &of_command.of, &read.position, &read.position][place];
                assert_eq!(of.column.as_deref(), Some(&*heading));
                assert_eq!(
                    of.unit.as_deref(),
                    expected.map(|(unit, _)| unit),
                    "{heading}"
                );
                let of_form = CommandUnit::of_reading(&read).map(CommandUnit::name);
                let is_unit = place == 1 && expected.is_some_and(|(unit, _)| unit != "%");
                assert_eq!(
                    of_form,
                    expected.map(|(unit, _)| unit).filter(|_| is_unit),
                    "{heading}"
                );
                if place > 0 {
                    let factor = expected.map_or(1.0, |(_, factor)| factor);
                    assert!(
                        (of.factor / factor - 1.0).abs() < 1e-12,
                        "{heading}: {}",
                        of.factor
                    );
                }
            }
        }
    }
    assert!(headings >= 200, "{headings}");
}

#[test]
fn a_test_a_file_says_what_the_same_tests_in_one_file_say() {
    // The second begins in motion, and the first has not shown the encoder's step.
    let tests: Vec<[Vec<f64>; 3]> = (0..4)
        .map(|test| {
            let [time, command, position, _] = servo(1000 * test);
            let from = if test == 1 { 700 } else { 0 };
            let step = if test == 0 { 2e-3 } else { 1e-3 };
            let time = time[from..].iter().map(|at| at + 10.0 * test as f64);
            let position = (position[from..].iter()).map(|at| (at / step).round() * step);
            [time.collect(), position.collect(), command[from..].to_vec()]
        })
        .collect();
    let named = |[time, position, command]: &[Vec<f64>; 3]| {
        table(&[("t", time), ("position_rad", position), ("u", command)])
    };
    let each: Vec<Table> = tests.iter().map(named).collect();
    let one = named(&[0, 1, 2].map(|of| tests.iter().flat_map(|test| test[of].clone()).collect()));
    let options = found(&one).options().expect("options");
    let estimates_of = |tables: &[Table]| {
        let read = |of: &Table| Log::new(of, &options.log_columns(), options.log_sample_time());
        let logs: Vec<Log> = tables.iter().map(|of| read(of).expect("a log")).collect();
        let found = identify(&logs, &[], &options, &|| true).expect("a servo");
        let estimates = found.summary.estimates;
        [estimates.a, estimates.b, estimates.coulomb, estimates.load]
            .map(|of| [of.value, of.std_error.expect("an error")])
    };
    let [apart, together] = [&each[..], &[one]].map(estimates_of);
    assert!((together[1][0] / 90.0 - 1.0).abs() < 0.02, "{together:?}");
    for (apart, together) in apart.as_flattened().iter().zip(together.as_flattened()) {
        assert!((apart / together - 1.0).abs() < 1e-9, "{apart} {together}");
    }
}
