//! MCAP logs, of a run and of other programs, are replayed like the same log in CSV.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use crate::support::{
    argument, assert_done, folder, printed_json, refusal_message, servo_id, standard_error,
};
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use serde_json::Value;

const SCENARIO: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/friction.toml");

/// A log whose columns are stated, of a servo that nothing is known of.
fn columns(log: &str) -> String {
    format!(
        "[encoder]\ncounts_per_rev = 10000\n[identifier]\nlaw = \"gauss-newton\"\n\
         parameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n[log]\n{log}\n"
    )
}

/// The result of a replay, without the keys that describe the log's file.
fn replayed(log: &Path, scenario: &Path) -> Value {
    let answer = servo_id(&[
        "replay",
        &argument(log),
        "--scenario",
        &argument(scenario),
        "--json",
        "-",
    ]);
    let mut result = printed_json(&answer);
    let object = result.as_object_mut().expect("an object");
    object.remove("origin");
    object.remove("agreement");
    object.remove("logs");
    result
}

/// Message about a log that is refused.
fn refused(log: &Path, scenario: &Path) -> String {
    let answer = servo_id(&["replay", &argument(log), "--scenario", &argument(scenario)]);
    refusal_message(&answer)
}

/// A trace in CSV and in MCAP.
fn traces(test: &str) -> (PathBuf, PathBuf, PathBuf) {
    let folder = folder(test);
    let (csv, mcap) = (folder.join("trace.csv"), folder.join("trace.mcap"));
    let answer = servo_id(&[
        "run",
        SCENARIO,
        "--csv",
        &argument(&csv),
        "--mcap",
        &argument(&mcap),
    ]);
    assert_done(&answer);
    (folder, csv, mcap)
}

#[test]
fn a_trace_in_mcap_is_replayed_to_the_same_bits_as_in_csv() {
    let (folder, csv, mcap) = traces("mcap-trace");
    let own = Path::new(SCENARIO);
    let result = replayed(&csv, own);
    assert_eq!(result["status"], "converged");
    assert_eq!(result, replayed(&mcap, own));
    // With a sample time from the log alone.
    let stated = folder.join("stated.toml");
    let bare = "time = \"time_s\"\nposition = \"position_rad\"\ncommand = \"command\"";
    std::fs::write(&stated, columns(bare)).expect("written");
    let result = replayed(&csv, &stated);
    assert_eq!(result["status"], "converged");
    assert_eq!(result, replayed(&mcap, &stated));
    // By topic, and by the joint's state.
    let by_topic = "time = \"servo.time_s\"\nposition = \"/servo.position_rad\"\n\
                    command = \"servo.command\"";
    std::fs::write(&stated, columns(by_topic)).expect("written");
    assert_eq!(result, replayed(&mcap, &stated));
    let joint = "time = \"log_time\"\nposition = \"/joint_states.position[0]\"\n\
                 command = \"joint_states.effort[0]\"";
    std::fs::write(&stated, columns(joint)).expect("written");
    let of_joint = replayed(&mcap, &stated);
    let b = |result: &Value| {
        result["estimates"]["b"]["value"]
            .as_f64()
            .expect("a number")
    };
    assert!((b(&of_joint) / b(&result) - 1.0).abs() < 1e-6, "{of_joint}");
}

/// The samples of a trace: time, position, command.
fn samples(csv: &Path) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(csv).expect("a trace");
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        [0, 2, 3].map(|place| fields[place].parse().expect("a number"))
    };
    text.lines().skip(1).map(row).collect()
}

/// An MCAP file with a chunk for all and no summary, packed by `pack`.
fn packed(compression: &str, plain: &[u8], pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut records = vec![];
    let mut reader = mcap::sans_io::LinearReader::new();
    let mut source = Cursor::new(plain);
    while let Some(event) = reader.next_event() {
        match event.expect("a whole file") {
            mcap::sans_io::LinearReadEvent::ReadRequest(wanted) => {
                let read = std::io::Read::read(&mut source, reader.insert(wanted)).expect("bytes");
                reader.notify_read(read);
            }
            mcap::sans_io::LinearReadEvent::Record { data, opcode } => {
                if (0x03..=0x05).contains(&opcode) {
                    records.push(opcode);
                    records.extend((data.len() as u64).to_le_bytes());
                    records.extend(data);
                } else if opcode == 0x0f {
                    break;
                }
            }
        }
    }
    let inside = pack(&records);
    let mut chunk = vec![];
    chunk.extend([0; 16]);
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend(crc32fast::hash(&records).to_le_bytes());
    chunk.extend((compression.len() as u32).to_le_bytes());
    chunk.extend(compression.as_bytes());
    chunk.extend((inside.len() as u64).to_le_bytes());
    chunk.extend(inside);
    let mut file = mcap::MAGIC.to_vec();
    for (opcode, body) in [
        (0x01, vec![0; 8]),
        (0x06, chunk),
        (0x0f, vec![0; 4]),
        (0x02, vec![0; 20]),
    ] {
        file.push(opcode);
        file.extend((body.len() as u64).to_le_bytes());
        file.extend(body);
    }
    file.extend(mcap::MAGIC);
    file
}

/// A log as a robot's computer writes it: encoder and drive on topics of their own, nested, at times of the
/// day, the command written first for every other sample.
fn of_a_robot(samples: &[[f64; 3]], encoding: &str) -> Vec<u8> {
    let mut file = Vec::new();
    let mut writer: Writer<_> = WriteOptions::new()
        .compression(None)
        .create(Cursor::new(&mut file))
        .expect("a writer");
    let mut channel = |topic, encoding| {
        writer
            .add_channel(0, topic, encoding, &BTreeMap::new())
            .expect("a channel")
    };
    let ids = [
        channel("/axis/encoder", "json"),
        channel("/axis/drive", encoding),
    ];
    for (number, [time, position, command]) in samples.iter().enumerate() {
        let now = 1_700_000_000_000_000_000 + (time * 1e9).round() as u64;
        let messages = [
            format!(r#"{{"stamp":"x","angle":{{"value":{position}}},"ok":true}}"#),
            format!(r#"{{"phase":[0,{{"demand":{command}}}]}}"#),
        ];
        let order = if number % 2 == 0 { [0, 1] } else { [1, 0] };
        for place in order {
            let header = MessageHeader {
                channel_id: ids[place],
                sequence: number as u32,
                log_time: now,
                publish_time: now,
            };
            let data = messages[place].as_bytes();
            writer
                .write_to_known_channel(&header, data)
                .expect("written");
        }
    }
    writer.finish().expect("finished");
    drop(writer);
    file
}

const ROBOT: &str = "time = \"log_time\"\nposition = \"axis/encoder.angle.value\"\n\
                     command = \"/axis/drive.phase[1].demand\"";

#[test]
fn separate_topics_are_joined_packed_or_not() {
    let (folder, csv, _) = traces("mcap-robot");
    let samples = samples(&csv);
    let stated = folder.join("stated.toml");
    let bare = "time = \"time_s\"\nposition = \"position_rad\"\ncommand = \"command\"";
    std::fs::write(&stated, columns(bare)).expect("written");
    let expected = replayed(&csv, &stated);
    std::fs::write(&stated, columns(ROBOT)).expect("written");
    let plain = of_a_robot(&samples, "json");
    let lz4 = |bytes: &[u8]| {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(bytes).expect("packed");
        encoder.finish().expect("packed")
    };
    let zstd = |bytes: &[u8]| {
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        ruzstd::encoding::compress_to_vec(bytes, level)
    };
    for (name, bytes) in [
        ("plain", plain.clone()),
        ("one-chunk", packed("", &plain, <[u8]>::to_vec)),
        ("lz4", packed("lz4", &plain, lz4)),
        ("zstd", packed("zstd", &plain, zstd)),
    ] {
        let log = folder.join(format!("{name}.mcap"));
        std::fs::write(&log, &bytes).expect("written");
        let result = replayed(&log, &stated);
        for unknown in ["a", "b", "coulomb", "load"] {
            let of = |result: &Value| {
                let estimate = &result["estimates"][unknown];
                ["value", "std_error"].map(|key| estimate[key].as_f64().expect("a number"))
            };
            let ([value, _], [expected, error]) = (of(&result), of(&expected));
            // The mean time of a sample differs in its last digits.
            assert!(
                (value - expected).abs() < 0.01 * error,
                "{name} {unknown}: {value}, {expected}"
            );
        }
    }
    // An unknown compression, and a checksum that does not match.
    let log = folder.join("unknown.mcap");
    std::fs::write(&log, packed("brotli", &plain, <[u8]>::to_vec)).expect("written");
    let answer = refused(&log, &stated);
    assert!(
        answer.contains("packed with \"brotli\"") && answer.contains("lz4 or zstd"),
        "{answer}"
    );
    let mut bytes = packed("", &plain, <[u8]>::to_vec);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&log, bytes).expect("written");
    let answer = refused(&log, &stated);
    assert!(answer.contains("damaged"), "{answer}");
}

#[test]
fn unreadable_files_are_refused_with_a_remedy() {
    let (folder, csv, mcap) = traces("mcap-refused");
    let stated = folder.join("stated.toml");
    let log = folder.join("log.mcap");
    let whole = std::fs::read(&mcap).expect("a trace");
    let own = Path::new(SCENARIO);

    for cut in [9, 100, whole.len() / 2, whole.len() - 3] {
        std::fs::write(&log, &whole[..cut]).expect("written");
        let answer = refused(&log, own);
        assert!(
            answer.contains("log.mcap: the MCAP file ends too early"),
            "{cut}: {answer}"
        );
    }
    for other in [&b""[..], b"t,q\n1,2\n", &whole[1..]] {
        std::fs::write(&log, other).expect("written");
        let answer = refused(&log, own);
        assert!(answer.contains("this is not an MCAP file"), "{answer}");
    }
    // An MCAP file is one under any name.
    let disguised = folder.join("disguised.csv");
    std::fs::write(&disguised, &whole).expect("written");
    assert_eq!(replayed(&disguised, own), replayed(&csv, own));

    for (column, expected) in [
        ("servo.positon_rad", "did you mean servo.position_rad?"),
        ("sevro.position_rad", "did you mean servo.position_rad?"),
        ("anything", "no such field, but"),
        ("servo.", "no such field"),
        ("joint_states.position[7]", "no such field"),
    ] {
        let bare = format!("time = \"time_s\"\nposition = \"{column}\"\ncommand = \"command\"");
        std::fs::write(&stated, columns(&bare)).expect("written");
        let answer = refused(&mcap, &stated);
        assert!(answer.contains(&format!("column {column}: ")), "{answer}");
        assert!(answer.contains(expected), "{answer}");
    }
    let by_number = "time = 1\nposition = 3\ncommand = 4";
    std::fs::write(&stated, columns(by_number)).expect("written");
    assert!(refused(&mcap, &stated).contains("go by name, topic.field"));
    let in_milliseconds = "time = \"log_time\"\ntime_unit = \"ms\"\nposition = \"position_rad\"\n\
                           command = \"command\"";
    std::fs::write(&stated, columns(in_milliseconds)).expect("written");
    assert!(refused(&mcap, &stated).contains("leave log.time_unit out"));

    let robot = of_a_robot(&samples(&csv), "cdr");
    std::fs::write(&log, robot).expect("written");
    std::fs::write(&stated, columns(ROBOT)).expect("written");
    let answer = refused(&log, &stated);
    assert!(
        answer.contains("/axis/drive are written as \"cdr\": only \"json\""),
        "{answer}"
    );
}

#[test]
fn a_missing_number_is_reported_with_its_message() {
    let folder = folder("mcap-missing");
    let (log, stated) = (folder.join("log.mcap"), folder.join("stated.toml"));
    let mut file = Vec::new();
    let mut writer = WriteOptions::new()
        .compression(None)
        .create(Cursor::new(&mut file))
        .expect("a writer");
    let id = writer
        .add_channel(0, "s", "json", &BTreeMap::new())
        .expect("a channel");
    for number in 0..100_u32 {
        let mut data = format!("{{\"q\":{}", f64::from(number).sin());
        if number != 41 {
            let _ = write!(data, ",\"u\":{number}");
        }
        data += "}";
        let now = u64::from(number) * 1_000_000;
        let header = MessageHeader {
            channel_id: id,
            sequence: number,
            log_time: now,
            publish_time: now,
        };
        writer
            .write_to_known_channel(&header, data.as_bytes())
            .expect("written");
    }
    writer.finish().expect("finished");
    drop(writer);
    std::fs::write(&log, file).expect("written");
    let plain = "time = \"log_time\"\nposition = \"s.q\"\ncommand = \"s.u\"";
    std::fs::write(&stated, columns(plain)).expect("written");
    let answer = refused(&log, &stated);
    assert!(
        answer.contains("log.mcap:42: column s.u: the message has no number there"),
        "{answer}"
    );
    let cut = format!("{plain}\ncut = [[0.0405, 0.0415]]\nscan = \"warn\"");
    std::fs::write(&stated, columns(&cut)).expect("written");
    let answer = servo_id(&["replay", &argument(&log), "--scenario", &argument(&stated)]);
    assert!(!standard_error(&answer).contains("no number"), "{answer:?}");
    assert!(
        String::from_utf8_lossy(&answer.stdout).contains("1 rows were left out"),
        "{answer:?}"
    );
}
