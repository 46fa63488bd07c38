use log_fit::Logged;

use super::squares::Squares;
use crate::found_servo::FoundServo;
use crate::log::Row;
use crate::scenario::Options;

/// Deviation of an open-loop simulation from the recorded positions.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenLoop {
    /// Root mean square of the position error, rad.
    pub rms: f64,
    /// The largest position error, rad.
    pub largest: f64,
    /// The error relative to the motion from where each segment begins.
    pub relative: f64,
    /// The recorded position minus the simulated one for every sample, rad.
    pub errors: Vec<f64>,
}

/// Drives a servo by the recorded command alone, from starts that are fitted.
///
/// None where samples have no command, or the simulation leaves every bound.
pub(super) fn open_loop(scenario: &Options, servo: &FoundServo, rows: &[Row]) -> Option<OpenLoop> {
    let samples = rows.iter().map(|row| {
        Some(Logged {
            position: row.position,
            command: row.command?,
            begins: row.begins,
        })
    });
    let errors = servo.free_run(scenario, &samples.collect::<Option<Vec<_>>>()?)?;
    let (mut squares, mut largest, mut first) = (Squares::default(), 0.0_f64, 0.0);
    for (row, error) in rows.iter().zip(&errors) {
        if row.begins {
            first = row.position;
        }
        squares.add(row.position - first, row.position - error - first);
        largest = largest.max(error.abs());
    }
    let rms = (squares.error / rows.len() as f64).sqrt();
    rms.is_finite().then(|| OpenLoop {
        rms,
        largest,
        relative: squares.relative(),
        errors,
    })
}

#[cfg(test)]
mod tests {
    use identifier_core::parameters::{ServoParameters, Unknown};
    use virtual_servo::{Effects, Servo};

    use super::*;
    use crate::experiment::TermEstimate;
    use crate::predict::FrozenServo;

    const SERVO: ServoParameters = ServoParameters::new(2.0, 250.0, 10.0, 15.0);

    /// The motion of a servo of the simulator under a command.
    fn simulated(mut servo: Servo, samples: u32, command: impl Fn(f64) -> f64) -> Vec<Row> {
        let rows = (0..samples).map(|k| {
            let time = 1e-3 * f64::from(k);
            let row = Row {
                position: servo.position(),
                command: Some(command(time)),
                begins: k == 0,
                ..Row::at(u64::from(k), time)
            };
            servo.advance(command(time));
            row
        });
        rows.collect()
    }

    /// The motion under a command of several tones, from sample 700 on, in two segments. Positions are rounded to counts.
    fn recorded(counts: f64) -> Vec<Row> {
        let servo = Servo::at_rest(&SERVO, &Effects::NONE, 1e-3, 1).expect("valid");
        let tones = |t| 0.4 * libm::sin(9.0 * t) + 0.2 * libm::cos(31.0 * t) - 0.06;
        let mut samples = simulated(servo, 6000, tones);
        samples.drain(3000..3500);
        samples.drain(..700);
        let count = std::f64::consts::TAU / counts;
        for (place, sample) in samples.iter_mut().enumerate() {
            sample.position = 3.0 + (sample.position / count).floor() * count;
            sample.begins = place == 0 || place == 2300;
        }
        samples
    }

    fn scenario(counts: f64) -> Options {
        let mut options = Options::blank();
        options.set_encoder(counts);
        options
    }

    fn predicted(servo: &ServoParameters, counts: f64, samples: &[Row]) -> Option<OpenLoop> {
        let scenario = scenario(counts);
        let found = FoundServo::of_estimates(&scenario, servo, &[]);
        open_loop(&scenario, &found, samples)
    }

    #[test]
    fn the_true_servo_predicts_itself_from_an_unknown_start() {
        let found = predicted(&SERVO, 1e9, &recorded(1e9)).expect("a prediction");
        assert_eq!(found.errors.len(), 4800);
        let [rms, largest] = [found.rms, found.largest];
        assert!(rms < 1e-6 && largest < 1e-5, "{rms} {largest}");
        // For an encoder, its quantisation is left.
        let step = std::f64::consts::TAU / 4096.0;
        let found = predicted(&SERVO, 4096.0, &recorded(4096.0)).expect("a prediction");
        let rms = found.rms / (step / 12_f64.sqrt());
        assert!((rms - 1.0).abs() < 0.1, "{rms}");
    }

    #[test]
    fn a_wrong_servo_shows_in_the_prediction() {
        let exact = recorded(1e9);
        for wrong in [
            ServoParameters { a: 2.1, ..SERVO },
            ServoParameters { b: 251.0, ..SERVO },
            ServoParameters::new(SERVO.a, SERVO.b, SERVO.coulomb, 15.1),
            ServoParameters::new(SERVO.a, SERVO.b, 10.1, SERVO.load),
        ] {
            let rms = predicted(&wrong, 1e9, &exact).expect("a prediction").rms;
            assert!(rms > 1e-3 && rms < 0.2, "{wrong:?}: {rms}");
        }
        let wild = ServoParameters::new(SERVO.a, f64::NAN, 0.0, 0.0);
        assert_eq!(predicted(&wild, 1e9, &exact), None);
    }

    #[test]
    fn nothing_is_predicted_without_command_or_motion() {
        let mut samples = recorded(1e9);
        samples[9].command = None;
        assert_eq!(predicted(&SERVO, 1e9, &samples), None);
        let mut still = recorded(1e9);
        still.iter_mut().for_each(|sample| sample.position = 1.0);
        assert_eq!(predicted(&SERVO, 1e9, &still), None);
        assert_eq!(predicted(&SERVO, 1e9, &[]), None);
    }

    /// A pendulum from another angle: its force is that of the angle where the model is, which is far from the record.
    #[test]
    fn gravity_acts_where_the_model_is() {
        let scenario = scenario(1e7);
        let servo = ServoParameters { load: 0.0, ..SERVO };
        let gravity = |size: f64| TermEstimate {
            unknown: Unknown::GravitySine,
            value: size,
            std_error: 0.0,
            since: 0,
        };
        let effects = Effects {
            gravity: [-30.0, 0.0],
            ..Effects::NONE
        };
        let plant = Servo::at_rest(&servo, &effects, 1e-3, 1).expect("valid");
        let tones = |t| 0.1 * libm::sin(3.0 * t) + 0.05 * libm::cos(11.0 * t);
        let samples = simulated(plant, 4000, tones);
        let error = |size: f64| {
            let found = FoundServo::of_estimates(&scenario, &servo, &[gravity(size)]);
            open_loop(&scenario, &found, &samples).expect("a prediction")
        };
        let exact = error(-30.0).rms;
        assert!(exact < 1e-5, "{exact}");
        // The pendulum of a fifth less is simulated alone, and is elsewhere by what the core's own model says.
        let weak = error(-24.0);
        let found = FoundServo::of_estimates(&scenario, &servo, &[gravity(-24.0)]);
        let frozen = FrozenServo::of(&found, &scenario).expect("valid");
        let [first, second] = [0, 1].map(|k| samples[k].position - weak.errors[k]);
        let command = samples[0].command.expect("recorded");
        // Velocity at the first sample, by the mean of the first.
        let velocity = second - first - 0.5e-6 * servo.b * command;
        let mut state = frozen.start(first, velocity, command);
        let mut apart: f64 = 0.0;
        for (sample, error) in samples.iter().zip(&weak.errors) {
            apart = apart.max((state.position - (sample.position - error)).abs());
            frozen.advance(&mut state, sample.command.expect("recorded"));
        }
        assert!(weak.rms > 1e-2, "{}", weak.rms);
        assert!(apart < 0.05 * weak.rms, "{apart} {}", weak.rms);
    }
}
