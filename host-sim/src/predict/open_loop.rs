use super::frozen_servo::FrozenServo;
use super::squares::Squares;
use super::start::{Motion, StartFit};
use crate::log::Row;

/// Deviation of an open-loop simulation from the recorded positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenLoop {
    /// Samples that it covers.
    pub samples: u64,
    /// Root mean square of the position error, rad.
    pub rms: f64,
    /// The largest position error, rad.
    pub largest: f64,
    /// The error relative to the motion from where each segment begins.
    pub relative: f64,
}

/// Drives a servo by the recorded command alone.
///
/// **The start is fitted.** Position and velocity at the first sample of each segment minimise the error of the
/// simulation over the segment, as in published results. The first samples alone do not determine the velocity below
/// the rounding of an encoder. Its error would accumulate to more than the model's own error. Nothing else is fitted.
///
/// None where samples have no command, or the simulation leaves every bound.
pub(super) fn open_loop(servo: &FrozenServo, rows: &[Row]) -> Option<OpenLoop> {
    /// The most steps of the fit.
    const STEPS: u32 = 8;
    let mut fits = first_guesses(rows)?;
    for _ in 0..STEPS {
        let mut segment_run = None;
        rows.iter().for_each(|sample| {
            let fit = fits.get_mut(next(&mut segment_run, sample));
            if let (Some(fit), Some(command)) = (fit, sample.command) {
                fit.add(servo, sample, command);
            }
        });
        let worth = fits.iter_mut().map(StartFit::step);
        if !worth.fold(false, |any, one| any | one) {
            break;
        }
    }
    let starts: Vec<_> = fits.iter().map(StartFit::start).collect();
    simulated(servo, &starts, rows)
}

/// The number of the segment that a sample belongs to.
fn next(segment_run: &mut Option<usize>, sample: &Row) -> usize {
    let number = match *segment_run {
        None => 0,
        Some(before) => before + usize::from(sample.begins),
    };
    *segment_run = Some(number);
    number
}

/// The first position and the first step of each segment, and the usual speed.
fn first_guesses(rows: &[Row]) -> Option<Vec<StartFit>> {
    let mut segment_run = None;
    let mut starts: Vec<Motion> = Vec::new();
    let mut last = 0.0;
    let (mut squares, mut steps) = (0.0, 0.0);
    let mut is_second = false;
    let mut commanded = true;
    rows.iter().for_each(|sample| {
        commanded &= sample.command.is_some();
        let number = next(&mut segment_run, sample);
        if number == starts.len() {
            starts.push(Motion {
                position: sample.position,
                velocity: 0.0,
            });
            is_second = true;
        } else {
            let step: f64 = sample.position - last;
            if std::mem::take(&mut is_second) {
                starts[number].velocity = step;
            }
            squares += step * step;
            steps += 1.0;
        }
        last = sample.position;
    });
    let speed = f64::sqrt(squares / steps);
    let is_moved = commanded && speed > 0.0;
    let fit = |start: Motion| StartFit::new(start, speed);
    is_moved.then(|| starts.into_iter().map(fit).collect())
}

fn simulated(servo: &FrozenServo, starts: &[Motion], rows: &[Row]) -> Option<OpenLoop> {
    let mut segment_run = None;
    let (mut state, mut first) = (None, 0.0);
    let (mut squares, mut largest, mut samples) = (Squares::default(), 0.0_f64, 0);
    rows.iter().for_each(|sample| {
        let before = segment_run;
        let number = next(&mut segment_run, sample);
        let command = sample.command.unwrap_or(f64::NAN);
        if segment_run != before {
            let start = starts.get(number);
            state = start.map(|start| servo.start(start.position, start.velocity, command));
            first = sample.position;
        }
        let Some(state) = &mut state else { return };
        squares.add(sample.position - first, state.position - first);
        largest = largest.max((sample.position - state.position).abs());
        samples += 1;
        servo.advance(state, command);
    });
    let rms = (squares.error / samples as f64).sqrt();
    rms.is_finite().then(|| OpenLoop {
        samples,
        rms,
        largest,
        relative: squares.relative(),
    })
}

#[cfg(test)]
mod tests {
    use identifier_core::parameters::ServoParameters;
    use virtual_servo::Plant;

    use super::*;

    const SERVO: ServoParameters = ServoParameters {
        a: 2.0,
        b: 250.0,
        load: 15.0,
        coulomb: 10.0,
    };

    /// The motion of the simulator's servo under a command of several tones, from sample 700 on, in two segments.
    /// Positions are rounded to counts.
    fn recorded(counts: f64) -> Vec<Row> {
        let mut plant = Plant::at_rest(&SERVO, 1e-3);
        let count = std::f64::consts::TAU / counts;
        let mut samples = Vec::new();
        for k in 0..6000_u32 {
            let time = 1e-3 * f64::from(k);
            let command = 0.4 * libm::sin(9.0 * time) + 0.2 * libm::cos(31.0 * time) - 0.06;
            if k >= 700 && !(3000..3500).contains(&k) {
                samples.push(Row {
                    position: 3.0 + (plant.position / count).floor() * count,
                    command: Some(command),
                    begins: k == 700 || k == 3500,
                    ..Row::at(u64::from(k), time)
                });
            }
            plant.advance(command);
        }
        samples
    }

    fn predicted(servo: &ServoParameters, samples: &[Row]) -> Option<OpenLoop> {
        let frozen = FrozenServo::new(servo, 1e-3).expect("valid");
        open_loop(&frozen, samples)
    }

    #[test]
    fn the_true_servo_predicts_itself_from_an_unknown_start() {
        let found = predicted(&SERVO, &recorded(1e9)).expect("a prediction");
        assert_eq!(found.samples, 4800);
        assert!(found.rms < 1e-6 && found.largest < 1e-5, "{found:?}");
        // For an encoder, its quantisation is left.
        let step = std::f64::consts::TAU / 4096.0;
        let found = predicted(&SERVO, &recorded(4096.0)).expect("a prediction");
        assert!(
            (found.rms / (step / 12_f64.sqrt()) - 1.0).abs() < 0.1,
            "{found:?}"
        );
    }

    #[test]
    fn a_wrong_servo_shows_in_the_prediction() {
        let exact = recorded(1e9);
        for wrong in [
            ServoParameters { a: 2.1, ..SERVO },
            ServoParameters { b: 251.0, ..SERVO },
            ServoParameters {
                load: 15.1,
                ..SERVO
            },
            ServoParameters {
                coulomb: 10.1,
                ..SERVO
            },
        ] {
            let found = predicted(&wrong, &exact).expect("a prediction");
            assert!(found.rms > 1e-3 && found.rms < 0.2, "{wrong:?}: {found:?}");
        }
        let wild = ServoParameters {
            b: f64::NAN,
            ..SERVO
        };
        assert_eq!(predicted(&wild, &exact), None);
    }

    #[test]
    fn nothing_is_predicted_without_command_or_motion() {
        let mut samples = recorded(1e9);
        samples[9].command = None;
        assert_eq!(predicted(&SERVO, &samples), None);
        let mut still = recorded(1e9);
        still.iter_mut().for_each(|sample| sample.position = 1.0);
        assert_eq!(predicted(&SERVO, &still), None);
        assert_eq!(predicted(&SERVO, &[]), None);
    }
}
