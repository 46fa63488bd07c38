//! A test of the chip's arithmetic by a known computation, and the cycles of its samples.

use core::hint::black_box;

use drive_link::{BoardTest, Cycles, Fault};
use identifier_core::Settings;
use identifier_core::identifier::{GradientIdentifier, Identify, ServoLoop};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{PerParameter, Unknowns};
use identifier_core::settings::{ControllerSettings, IdentifierSettings, SettingsError};

/// Samples of the known computation.
const SAMPLES: u32 = 200;

/// The bits of its result, the same on every machine.
const ANSWER: [u64; 3] = [
    0x3ff0_a2dd_2a40_0000,
    0x4069_f239_6000_0000,
    0x4013_ffbb_1300_0000,
];

/// Instructions of a sample of it on a Cortex-M4F, mean and maximum. The budget counts them: it is compiled for size, as
/// everything in the drive but the sample interrupt.
pub const BOARD_TEST_INSTRUCTIONS: [u32; 2] = [635, 786];

/// Where its motion begins: it passes the place where counts wrap.
const START: i32 = i32::MAX - 100;

type Filter = LowPass<f32>;

/// Runs controller and identifier with friction over a motion from a table of whole numbers, on a board of this name.
/// `counter` reads the chip's cycle counter; zeros where none runs. Every bit of the estimates is compared with its value
/// elsewhere: the fault is [`Fault::SelfTestFailed`].
#[inline(never)]
pub fn self_test(board: &str, counter: fn() -> u32) -> (BoardTest, Result<(), Fault>) {
    let mut test = BoardTest {
        board: board.parse().unwrap_or_default(),
        ..BoardTest::default()
    };
    let done = compute(&mut test, counter);
    let is_right = done.is_ok() && test.bits == ANSWER;
    let found = is_right.then_some(()).ok_or(Fault::SelfTestFailed);
    (test, found)
}

fn settings() -> Settings {
    Settings {
        sample_time: 1e-3,
        resolution: 6e-4,
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        identifier: IdentifierSettings {
            initial: PerParameter {
                a: Some(1.0),
                b: Some(200.0),
                coulomb: Some(5.0),
                load: None,
            },
            bounds: PerParameter {
                a: Some([0.0, 50.0]),
                b: Some([110.0, 1000.0]),
                coulomb: Some([0.0, 100.0]),
                load: None,
            },
            gamma: Some(PerParameter::new(0.2, 100.0, 1.0, 0.0)),
            ..IdentifierSettings::UNSTATED
        },
    }
}

fn compute(test: &mut BoardTest, counter: fn() -> u32) -> Result<(), SettingsError> {
    let servo_loop: ServoLoop<f32, Filter, GradientIdentifier<f32, Filter, Unknowns<3>, 3>> =
        settings().build()?;
    let mut state = servo_loop.start(START);
    let counting = taken(counter, || {});
    let (mut total, mut most) = (0_u32, 0);
    for k in 0..SAMPLES {
        // A parabola up and down again, and a setpoint that goes a quarter beyond it.
        let position = (k * (SAMPLES - k) / 32) as i32;
        let count = START.wrapping_add(position);
        let (count, beyond) = black_box((count, 0.25 * position as f32));
        let taken = taken(counter, || {
            // A sample that is refused leaves the state, and so another answer.
            let _ = black_box(servo_loop.process(&mut state, count, beyond, count));
        });
        let taken = taken.saturating_sub(counting);
        total = total.wrapping_add(taken);
        most = most.max(taken);
    }
    let mean = total / SAMPLES;
    test.cycles = (most > 0).then_some(Cycles { mean, most });
    let identifier = servo_loop.identifier();
    let found = identifier.estimates_in(&identifier.snapshot(state.identification()));
    test.bits = [found.a, found.b, found.coulomb].map(f64::to_bits);
    Ok(())
}

/// The counts from one reading to the next.
fn taken(counter: fn() -> u32, work: impl FnOnce()) -> u32 {
    let before = counter();
    work();
    counter().wrapping_sub(before)
}

#[cfg(test)]
mod tests {
    use core::sync::atomic::{AtomicU32, Ordering};

    use super::{ANSWER, self_test};

    #[test]
    fn the_answer_is_the_known_one_and_has_no_cycles_without_a_counter() {
        let (test, found) = self_test("a-board", || 0);
        assert_eq!(test.bits, ANSWER, "{:#018x?}", test.bits);
        assert_eq!((test.board.as_str(), test.cycles), ("a-board", None));
        assert_eq!(found, Ok(()));
    }

    #[test]
    fn cycles_are_those_between_two_readings_less_those_of_reading() {
        static READINGS: AtomicU32 = AtomicU32::new(0);
        // Each reading takes 7, and the sample after the hundredth 1000 more.
        let counter = || {
            let before = READINGS.fetch_add(1, Ordering::Relaxed);
            let more = if before >= 201 { 1000 } else { 0 };
            (7 * before + more).wrapping_sub(50)
        };
        let (test, _) = self_test("a-board", counter);
        let cycles = test.cycles.expect("they run");
        assert_eq!((cycles.mean, cycles.most), (5, 1000));
    }
}
