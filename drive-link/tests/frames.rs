//! The line may do to the bytes what it likes.

use drive_link::{
    Answer, Command, Estimates, FrameError, LONGEST_FRAME, LoopSettings, Protection, Reading,
    Receiver, Request, Settings, Shaking, frame,
};
use proptest::prelude::*;

fn settings() -> impl Strategy<Value = Settings> {
    let number = any::<f64>().prop_filter("numbers", |number| !number.is_nan());
    (
        prop::array::uniform32(number),
        any::<(bool, bool, bool, u8)>(),
    )
        .prop_map(|(n, (boxed, mu, friction, overruns))| Settings {
            closed_loop: LoopSettings {
                sample_time: n[0],
                counts_per_rev: n[1],
                gains: [n[2], n[3], n[4]],
                limit: [n[5], n[6]],
                cutoff: n[7],
                plant_box: boxed.then_some([[n[8], n[9]], [n[10], n[11]]]),
                initial: [n[12], n[13], n[14], n[15]],
                bounds: [
                    [n[16], n[17]],
                    [n[18], n[19]],
                    [n[20], n[21]],
                    [n[22], n[23]],
                ],
                gamma: [n[24], n[25], n[26]],
                mu: mu.then_some(n[27]),
                friction,
                format: if friction {
                    drive_link::Format::Single
                } else {
                    drive_link::Format::Fixed
                },
            },
            shaking: Shaking {
                amplitude: n[28],
                hold: n[29],
            },
            protection: Protection {
                following_error: n[30],
                travel: n[31],
                speed: n[1],
                silence: n[0],
                overruns,
            },
        })
}

fn request() -> impl Strategy<Value = Request> {
    let command = prop_oneof![
        Just(Command::Hello),
        settings().prop_map(Command::Configure),
        Just(Command::Start),
        any::<u16>().prop_map(Command::Watch),
        (-1e3_f64..1e3).prop_map(Command::Aim),
        Just(Command::Save),
    ];
    (any::<u8>(), command).prop_map(|(id, command)| Request { id, command })
}

fn received(receiver: &mut Receiver, bytes: &[u8]) -> Vec<Result<Request, FrameError>> {
    bytes
        .iter()
        .filter_map(|&byte| receiver.take(byte))
        .collect()
}

proptest! {
    #[test]
    fn what_is_said_is_heard(requests in prop::collection::vec(request(), 1..8)) {
        let mut line = Vec::new();
        for request in &requests {
            let framed = frame(request).expect("it fits");
            prop_assert!(framed.len() <= LONGEST_FRAME);
            prop_assert_eq!(framed.iter().position(|&byte| byte == 0), Some(framed.len() - 1));
            line.extend_from_slice(&framed);
        }
        let heard = received(&mut Receiver::new(), &line);
        prop_assert_eq!(heard, requests.into_iter().map(Ok).collect::<Vec<_>>());
    }

    #[test]
    fn after_any_garbage_the_next_frame_but_one_is_heard(
        garbage in prop::collection::vec(any::<u8>(), 0..3 * LONGEST_FRAME),
        first in request(),
        second in request(),
    ) {
        let mut receiver = Receiver::new();
        let heard = received(&mut receiver, &garbage);
        prop_assert!(heard.iter().all(Result::is_err), "{heard:?}");
        // The first may be spoilt by what the garbage left, and not even that after a zero.
        received(&mut receiver, &frame(&first).expect("it fits"));
        let heard = received(&mut receiver, &frame(&second).expect("it fits"));
        prop_assert_eq!(heard, vec![Ok(second)]);
    }

    #[test]
    fn a_lost_a_doubled_and_a_changed_byte_cost_one_frame(
        spoilt in request(),
        next in request(),
        place: prop::sample::Index,
        bit in 0_u8..8,
        kind in 0..3,
    ) {
        let mut line = frame(&spoilt).expect("it fits").to_vec();
        let place = place.index(line.len() - 1);
        match kind {
            0 => { line.remove(place); }
            1 => line.insert(place, line[place]),
            _ => line[place] ^= 1 << bit,
        }
        line.extend_from_slice(&frame(&next).expect("it fits"));
        let heard = received(&mut Receiver::new(), &line);
        prop_assert_eq!(heard.last(), Some(&Ok(next)));
        let misheard = heard[..heard.len() - 1].iter().filter(|heard| heard.is_ok()).count();
        prop_assert_eq!(misheard, 0, "{:?} became {:?}", spoilt, heard);
    }

    #[test]
    fn answers_come_through_too(
        number: u32,
        command in -1e6_f64..1e6,
        output_error in -1e9_f64..1e9,
        flags: (bool, bool),
    ) {
        let answer = Answer::Command {
            number,
            reading: Reading {
                command,
                output_error,
                estimates: Estimates { a: command, b: 2.0, coulomb: 0.0, load: output_error },
                slowed: flags.0,
                restarted: flags.1,
            },
        };
        let mut receiver = Receiver::new();
        let heard = frame(&answer)
            .expect("it fits")
            .iter()
            .find_map(|&byte| receiver.take::<Answer>(byte));
        prop_assert_eq!(heard, Some(Ok(answer)));
    }
}

#[test]
fn a_frame_without_end_is_refused_and_forgotten() {
    let mut receiver = Receiver::new();
    for _ in 0..10 * LONGEST_FRAME {
        assert_eq!(receiver.take::<Request>(7), None);
    }
    assert_eq!(receiver.take::<Request>(0), Some(Err(FrameError::TooLong)));
    let hello = Request {
        id: 3,
        command: Command::Hello,
    };
    let heard = received(&mut receiver, &frame(&hello).expect("it fits"));
    assert_eq!(heard, vec![Ok(hello)]);
}
