//! Moves with dwells longer than the window: the information of a move outlasts the dwell.

use core::f64::consts::TAU;

use identifier_core::Settings;
use identifier_core::identifier::{Event, Identify, WindowIdentifier};
use identifier_core::parameters::{AbCoulombLoad, ServoParameters};
use virtual_servo::{Effects, Encoder, Servo as TrueServo};

use crate::support::{Controller, Draw, Kind, Servo, on_all_cores};

type Window = WindowIdentifier<f64, AbCoulombLoad, 4, 512>;

/// A servo with friction and load that steps to and fro with dwells of two seconds.
struct Moves {
    servo: Servo,
    plant: TrueServo,
    encoder: Encoder,
    controller: Controller,
    draw: Draw,
    target: f64,
    value: f64,
    count: i64,
    samples: u32,
}

impl Moves {
    const DWELL: u32 = 2000;

    fn new(seed: u32) -> Self {
        let mut draw = Draw::new(seed);
        let servo = Servo {
            parameters: ServoParameters {
                a: draw.uniform(0.2, 5.0),
                b: draw.between(80.0, 600.0),
                coulomb: draw.uniform(5.0, 40.0),
                load: draw.uniform(-20.0, 20.0),
            },
            counts_per_rev: 10_000.0,
            sample_time: 1e-3,
            limit: 10.0,
            bandwidth: draw.uniform(15.0, 40.0),
            offset: 0.0,
            seed,
        };
        let plant = TrueServo::at_rest(&servo.parameters, &Effects::NONE, 1e-3, seed);
        Self {
            plant: plant.expect("sound"),
            encoder: Encoder::new(servo.counts_per_rev),
            controller: Controller::new(Kind::Pid, &servo),
            servo,
            draw,
            target: 0.0,
            value: 0.0,
            count: 0,
            samples: 0,
        }
    }

    /// A sample: the counts moved, and the command that acts from now on.
    fn sample(&mut self) -> (i32, f64) {
        if self.samples % Self::DWELL == 200 {
            self.target = self.draw.uniform(-1.5, 1.5);
        }
        self.samples += 1;
        self.value += 0.05 * (self.target - self.value);
        let now = self.encoder.read(self.plant.position());
        let moved = (now - self.count) as i32;
        self.count = now;
        let position = now as f64 * TAU / self.servo.counts_per_rev;
        let command = self.controller.command(self.value, position);
        self.plant.advance(command);
        (moved, command)
    }
}

#[test]
fn b_stays_right_through_dwells_longer_than_the_window() {
    let runs = on_all_cores(20, |seed| {
        let mut moves = Moves::new(seed);
        let window: Window = Settings::new(1e-3, 10_000.0).build().expect("sound");
        let mut state = window.start();
        let (mut worst, mut since, mut fits) = (0.0_f64, f64::NAN, 0);
        for k in 0..40_000 {
            let (moved, command) = moves.sample();
            let seen = window
                .process(&mut state, moved, command)
                .expect("ordinary");
            window.work(&mut state, u32::MAX);
            if seen.event == Event::Started {
                fits += 1;
            }
            let error = window
                .standard_errors(&state)
                .map_or(f64::INFINITY, |errors| errors.b);
            // Counted from the first standard error below 0.5 % on.
            if !since.is_nan() || error < 0.005 * window.estimates(&state).b {
                if since.is_nan() {
                    since = f64::from(k) * 1e-3;
                }
                let off = window.estimates(&state).b / moves.servo.parameters.b - 1.0;
                worst = worst.max(off.abs());
            }
        }
        (
            worst,
            since,
            fits,
            window.estimates(&state),
            moves.servo.parameters,
        )
    });
    for (seed, (worst, since, fits, found, truth)) in runs.iter().enumerate() {
        println!(
            "{seed}: b within {:.2} % since {since} s, {fits} fits, {found:.3?} {truth:.3?}",
            100.0 * worst
        );
    }
    for (seed, (worst, since, ..)) in runs.iter().enumerate() {
        assert!(*since < 10.0, "seed {seed}: no result");
        assert!(*worst < 0.02, "seed {seed}: {worst}");
    }
}
