use super::gain::Diffuse;
use super::*;

/// Numbers uniform in −1 to 1.
fn dice(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        let next = state.wrapping_mul(6_364_136_223_846_793_005);
        state = next.wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Values with these effects.
fn valued<const N: usize>(sizes: [(Effect, f64); N]) -> Values {
    let mut values = Values::NONE;
    for (effect, value) in sizes {
        values.set(effect, value);
    }
    values
}

/// A horizon without a load that wanders.
fn horizon(white: f64) -> Horizon {
    Horizon { white, walk: None }
}

#[derive(Default)]
struct Motion {
    positions: Vec<f64>,
    commands: Vec<f64>,
    angles: Vec<[f64; 2]>,
}

/// A servo in fine steps under a random command and a weak loop.
fn motion(samples: usize, a: f64, b: f64, c: f64, noise: f64) -> Motion {
    const STEPS: usize = 20;
    let mut roll = dice(7);
    let (mut q, mut v, mut u) = (0.0_f64, 0.0_f64, 0.0);
    let mut made = Motion::default();
    let dt = 1.0 / STEPS as f64;
    for k in 0..samples {
        if k % 17 == 0 {
            u = roll();
        }
        let command = (u - 2e-4 * q - 1e-3 * v).clamp(-1.0, 1.0);
        made.positions.push((q + noise * 1.7 * roll()).round());
        made.commands.push(command);
        let angle = q / 300.0;
        made.angles.push([libm::sin(angle), libm::cos(angle)]);
        for _ in 0..STEPS {
            let push = b * command;
            if v == 0.0 && push.abs() <= c {
                continue;
            }
            let direction = if v == 0.0 { push.signum() } else { v.signum() };
            let next = v + dt * (push - c * direction - a * v);
            q += 0.5 * dt * (v + next);
            v = if next * direction < 0.0 { 0.0 } else { next };
        }
    }
    made
}

impl Motion {
    fn record(&self) -> Record<'_> {
        Record {
            positions: &self.positions,
            commands: &self.commands,
            angles: &self.angles,
            radian: 300.0,
            begins: &[0],
            stride: 1,
            recorded: &[],
        }
    }
}

#[test]
fn every_tangent_is_the_derivative() {
    let made = motion(1500, 0.01, 3.0, 0.6, 0.0);
    let record = Record {
        begins: &[0, 700],
        ..made.record()
    };
    let pass = ModelPass {
        record: &record,
        horizon: Horizon {
            white: 12.0,
            walk: Some(40.0),
        },
        damping: 0.01,
        diffuse: Diffuse {
            velocity: 100.0,
            load: 1.0,
        },
        starts: None,
    };
    let mut failed = false;
    for (delay, lag, share, on_load) in [
        (0.0, 0.0, 0.3, 0.0),
        (0.3, 0.0, 0.0, 0.0),
        (-1.2, 0.0, 0.6, 1.0),
        (1.4, 0.8, 0.0, 0.0),
        (0.2, 1.7, 0.3, 1.0),
    ] {
        let mut values = valued([
            (Effect::A, 0.012),
            (Effect::B, 2.9),
            (Effect::Coulomb, 0.5),
            (Effect::Load, 0.05),
            (Effect::Delay, delay),
        ]);
        // A servo without further effects has a pass of its own.
        for effect in Effect::BASE {
            failed |= !is_the_derivative(&pass, &values, effect);
        }
        for (effect, value) in [
            (Effect::CurrentLoop, lag),
            (Effect::Asymmetry, 0.001),
            (Effect::Quadratic, 1e-4),
            (Effect::LowSpeed, 0.2),
            (Effect::LowSpeedVelocity, 9.0),
            (Effect::GravitySine, 0.1),
            (Effect::RippleCosine, 0.05),
            (Effect::RippleSine3, 0.03),
            (Effect::DeadBand, 0.02),
            (Effect::LoadFriction, 0.02),
            (Effect::GainDrift, 0.1),
            (Effect::FrictionDrift, 0.1),
            (Effect::HiddenLimit, 0.8),
            (Effect::LimitSlope, 0.5),
            (Effect::GainAsymmetry, 0.03),
            (Effect::TorqueRippleSine, 0.02),
            (Effect::InertiaCosine, 0.05),
            (Effect::LoadShare, share),
            (Effect::ResonanceFrequency, 0.7),
            (Effect::ResonanceDamping, 0.2),
            (Effect::EncoderOnLoad, on_load),
            (Effect::Backlash, 3.0),
            (Effect::EccentricitySine, 2.0),
        ] {
            values.set(effect, value);
        }
        values.orders[1] = 3.0;
        values.orders[3] = 5.0;
        values.gain_order = 3.0;
        values.inertia_order = 2.0;
        // A shaft that follows at once is no second mass.
        let is_there = |effect| match effect {
            Effect::CurrentLoop => lag > 0.0,
            Effect::ResonanceFrequency | Effect::ResonanceDamping | Effect::LoadShare => {
                share > 0.0
            }
            Effect::Compliance => share == 0.0,
            // One or the other.
            Effect::EncoderOnLoad => false,
            _ => true,
        };
        for effect in Effect::ALL {
            if is_there(effect) {
                failed |= !is_the_derivative(&pass, &values, effect);
            }
        }
    }
    assert!(!failed);
}

fn is_the_derivative(pass: &ModelPass<'_>, values: &Values, effect: Effect) -> bool {
    let step = 1e-6 * (1.0 + values.get(effect).abs());
    let mut innovations = [Vec::new(), Vec::new()];
    for (sign, found) in [-1.0, 1.0].into_iter().zip(&mut innovations) {
        let moved = values.with(effect, values.get(effect) + sign * step);
        assert!(pass.run(&moved, &[], &mut |row| found.push(row.innovation)));
    }
    let (mut off, mut size) = (0.0, 0.0);
    let mut place = 0;
    assert!(pass.run(values, &[effect.into()], &mut |row| {
        let slope = -(innovations[1][place] - innovations[0][place]) / (2.0 * step);
        let error = row.regressor[0] - slope;
        // Where a step of the difference passes an event there is no derivative.
        if error.abs() < 1e3 * (1.0 + slope.abs()) {
            off += error * error;
            size += slope * slope;
        }
        place += 1;
    }));
    let relative = (off / size).sqrt();
    let [delay, lag] = [Effect::Delay, Effect::CurrentLoop].map(|effect| values.get(effect));
    std::println!(
        "{effect:?} delay {delay} lag {lag}: {relative:.2e} of {:.2e}",
        size.sqrt()
    );
    let most = match effect {
        Effect::Compliance => 0.2,
        Effect::Quadratic | Effect::LowSpeed | Effect::LowSpeedVelocity => 0.1,
        // A whole delay has two derivatives; behind a current loop its mean over a part is passed on.
        Effect::Delay if delay == 0.0 => 0.2,
        Effect::Delay if lag > 0.0 => 0.08,
        // A spring moves on in pieces, which begin at the steps of the command.
        Effect::Delay if values.get(Effect::LoadShare) > 0.0 => 0.05,
        _ => 0.02,
    };
    relative < most
}

/// A fit from values that are a third off.
fn fitted(record: &Record<'_>, [a, b, c]: [f64; 3]) -> (Fitted, Lateness) {
    let mut fitter = RecordFitter::new(record).expect("a motion");
    let [a, b, c] = [0.7 * a, 1.3 * b, 0.7 * c];
    let mut values = valued([(Effect::A, a), (Effect::B, b), (Effect::Coulomb, c)]);
    let coarse = Search {
        steps: 6,
        tolerance: 1e-5,
    };
    for white in [20.0, 100.0] {
        let found = fitter.search(&values, &Effect::BASE, horizon(white), coarse);
        values = found.expect("a start").0;
    }
    let late = fitter.lateness(&values).expect("a long horizon");
    fitter.earliest = 0.0;
    if late.is_certain() {
        fitter.earliest = -late.samples.round();
        values = late.values;
    }
    let search = Search {
        steps: 6,
        tolerance: 1e-8,
    };
    let fits = (fitter.horizons())
        .filter_map(|horizon| fitter.fit(&values, &Effect::BASE, horizon, search));
    let fitted = fitter.best_horizon(fits, &Effect::BASE);
    (fitted.expect("a fit"), late)
}

/// Each effect is found within a part of the truth.
#[track_caller]
fn assert_found<const N: usize>(values: &Values, truths: [(Effect, f64, f64); N]) {
    for (effect, truth, most) in truths {
        let found = values.get(effect);
        assert!(
            (found / truth - 1.0).abs() < most,
            "{effect:?}: {found} for {truth}"
        );
    }
}

#[test]
fn a_fit_from_afar_finds_the_servo_whatever_the_noise() {
    let (a, b, c) = (0.004, 1.5, 0.12);
    for noise in [0.0, 0.5, 1.0, 2.0, 5.0, 10.0] {
        let made = motion(6000, a, b, c, noise);
        let record = made.record();
        let (fitted, late) = fitted(&record, [a, b, c]);
        assert!(!late.is_certain(), "{noise}: {late:?}");
        assert_found(
            &fitted.values,
            [
                (Effect::B, b, 2e-3),
                (Effect::Coulomb, c, 0.01),
                (Effect::A, a, 0.02),
            ],
        );
        // Rounding is noise too.
        let truth = noise.hypot(QUANTISATION_SIGMA);
        let found = RecordStatistics::new(&record).expect("a motion").noise;
        // The noise of the dice is of this deviation to a hundredth.
        assert!((found / truth - 1.0).abs() < 0.05, "{noise}: {found}");
    }
}

/// A motor with friction and a load on a spring, in fine steps under a random command. The encoder is on the motor.
fn two_masses(samples: usize, [b, c]: [f64; 2], [frequency, damping, share]: [f64; 3]) -> Motion {
    const STEPS: usize = 200;
    let mut roll = dice(11);
    let [mut motor, mut load] = [[0.0_f64; 2]; 2];
    let mut made = Motion::default();
    let dt = 1.0 / STEPS as f64;
    let mut u = 0.0;
    for k in 0..samples {
        if k % 17 == 0 {
            u = roll();
        }
        let command = (u - 2e-4 * motor[0] - 1e-3 * motor[1]).clamp(-1.0, 1.0);
        made.positions.push(motor[0].round());
        made.commands.push(command);
        for _ in 0..STEPS {
            let twist = [0, 1].map(|i| motor[i] - load[i]);
            let pull = frequency * twist[0] + 2.0 * damping * twist[1];
            let spring = share * (1.0 - share) * frequency * pull;
            load[1] += dt * spring / share;
            load[0] += dt * load[1];
            let push = b * command - spring;
            if motor[1] == 0.0 && push.abs() <= c {
                continue;
            }
            let direction = if motor[1] == 0.0 { push } else { motor[1] }.signum();
            let next = motor[1] + dt * (push - c * direction) / (1.0 - share);
            motor[1] = if next * direction < 0.0 { 0.0 } else { next };
            motor[0] += dt * motor[1];
        }
    }
    made
}

#[test]
fn a_load_on_a_spring_is_found_with_friction_at_the_motor() {
    for (frequency, damping, share, c) in [
        (0.25, 0.03, 0.3, 0.2),
        (0.6, 0.05, 0.6, 0.5),
        (1.0, 0.02, 0.5, 0.1),
    ] {
        let b = 1.5;
        let made = two_masses(6000, [b, c], [frequency, damping, share]);
        let record = Record::of(&made.positions, &made.commands);
        let mut fitter = RecordFitter::new(&record).expect("a motion");
        fitter.earliest = 0.0;
        let own = [
            (Effect::ResonanceFrequency, 1.1 * frequency),
            (Effect::ResonanceDamping, Values::USUAL_DAMPING),
            (Effect::LoadShare, 0.4),
        ];
        let free = [&Effect::BASE[..], &own.map(|(effect, _)| effect)].concat();
        let values = valued(own)
            .with(Effect::B, 0.8 * b)
            .with(Effect::Coulomb, 0.5 * c);
        let search = Search {
            steps: 30,
            tolerance: 1e-9,
        };
        let found = fitter.fit(&values, &free, horizon(100.0), search);
        let found = found.expect("a fit").values;
        // At low frequency a stiff shaft of that twist moves as much.
        let twist = share / (1.0 - share) / frequency.powi(2);
        assert!((found.twist() / twist - 1.0).abs() < 0.02);
        assert_found(
            &found,
            [
                (Effect::B, b, 2e-3),
                (Effect::Coulomb, c, 0.01),
                (Effect::ResonanceFrequency, frequency, 3e-3),
                (Effect::ResonanceDamping, damping, 0.1),
                (Effect::LoadShare, share, 0.01),
            ],
        );
    }
}

#[test]
fn a_command_that_was_recorded_late_or_early_is_shifted_back() {
    let made = motion(6000, 0.004, 1.5, 0.12, 0.0);
    for late in [-3_i64, -1, 0, 1, 2] {
        let last = made.commands.len() as i64 - 1;
        let commands: Vec<f64> = (0..=last)
            .map(|row| made.commands[(row - late).clamp(0, last) as usize])
            .collect();
        let record = Record {
            commands: &commands,
            ..made.record()
        };
        let (fitted, lateness) = fitted(&record, [0.004, 1.5, 0.12]);
        let found = -fitted.values.get(Effect::Delay);
        assert_eq!(lateness.is_certain(), late > 0, "{late}: {lateness:?}");
        assert!((found - late as f64).abs() < 0.05, "{late}: {found}");
        let coulomb = fitted.values.get(Effect::Coulomb);
        assert!((coulomb / 0.12 - 1.0).abs() < 0.05, "{late}: {coulomb}");
    }
}

const BLOCK: usize = 4;

/// Positions and commands of the halves of blocks, and the number of samples in them.
fn in_blocks(made: &Motion) -> (Vec<f64>, Vec<f64>, usize) {
    let (mut positions, mut commands) = (Vec::new(), Vec::new());
    let starts: Vec<usize> = (0..made.positions.len() - BLOCK).step_by(BLOCK).collect();
    for &start in &starts {
        let (mut mean, mut moment) = (0.0, 0.0);
        for k in 0..BLOCK {
            let place = (k as f64 + 0.5) / BLOCK as f64 - 0.5;
            mean += made.commands[start + k] / BLOCK as f64;
            moment += made.commands[start + k] * place / BLOCK as f64;
        }
        let [first, next] = [start, start + BLOCK].map(|sample| made.positions[sample]);
        positions.extend([first, 0.5 * (first + next)]);
        commands.extend([mean - 4.0 * moment, mean + 4.0 * moment]);
    }
    (positions, commands, starts.len() * BLOCK)
}

/// The record of halves of blocks, with the commands of all samples.
fn of_blocks<'a>(positions: &'a [f64], commands: &'a [f64], recorded: &'a [f64]) -> Record<'a> {
    Record {
        stride: 2,
        recorded,
        ..Record::of(positions, commands)
    }
}

#[test]
fn blocks_of_samples_are_as_good_as_samples() {
    let made = motion(24_000, 0.001, 0.1, 0.01, 0.0);
    let (positions, commands, samples) = in_blocks(&made);
    let record = of_blocks(&positions, &commands, &made.commands[..samples]);
    let (fitted, _) = fitted(&record, [0.002, 0.4, 0.04]);
    // A sample of the record is half a block: two samples.
    let gain = fitted.values.get(Effect::B) / 4.0;
    assert!((gain / 0.1 - 1.0).abs() < 2e-3, "{gain}");
    let friction = fitted.values.get(Effect::Coulomb) / 4.0;
    assert!((friction / 0.01 - 1.0).abs() < 0.01, "{friction}");
}

/// Under a command of one size a dead band equals a smaller gain, and load-dependent friction equals Coulomb friction.
/// The mean of a block in which the command changes its sign has other sizes all the same.
#[test]
fn blocks_of_a_command_of_one_size_do_not_tell_a_dead_band_from_a_smaller_gain() {
    let mut made = motion(8000, 0.001, 0.1, 0.01, 0.0);
    for command in &mut made.commands {
        *command = 0.5 * command.signum();
    }
    let (positions, commands, samples) = in_blocks(&made);
    let record = of_blocks(&positions, &commands, &made.commands[..samples]);
    assert!(commands.iter().any(|command| command.abs() < 0.4));
    let fitter = RecordFitter::new(&record).expect("a motion");
    for (seen, hidden, size) in [
        (Effect::B, Effect::DeadBand, 0.02),
        (Effect::Coulomb, Effect::LoadFriction, 0.1),
    ] {
        let values = valued([(Effect::B, 0.4), (Effect::Coulomb, 0.04), (hidden, size)]);
        let pass = fitter.pass(&values, horizon(30.0));
        let sums = Sums::new(&pass, &values, &[seen, hidden]).expect("a pass");
        let condition = sums.covariances(&[false; MAX_UNKNOWNS]).condition;
        assert!(condition > 1e10, "{hidden:?} {condition}");
    }
}

#[test]
fn no_motion_and_no_command_are_no_record() {
    let still = [0.0; 400];
    let moving: Vec<f64> = (0..400).map(|k| f64::from(k) * 3.0).collect();
    assert!(RecordFitter::new(&Record::of(&still, &still)).is_none());
    assert!(RecordFitter::new(&Record::of(&moving, &still)).is_none());
}

/// Velocity bends within the sample in which a strongly damped servo turns round.
#[test]
fn a_strongly_damped_servo_that_turns_round_is_its_model() {
    let (a, b, c) = (0.14, 2.0, 0.1);
    let (mut q, mut v) = (0.0_f64, 0.0_f64);
    let (mut positions, mut commands) = (Vec::new(), Vec::new());
    for k in 0..2000 {
        let command: f64 = if (k / 37) % 2 == 0 { 1.0 } else { -0.8 };
        positions.push(q);
        commands.push(command);
        let mut left = 1.0;
        while left > 0.0 {
            // q̇ = w + (v − w) e^(−a t) up to the time at which it is zero.
            let direction = if v == 0.0 { command } else { v }.signum();
            let end = (b * command - c * direction) / a;
            let turns = v * end < 0.0;
            let stops = if turns {
                libm::log(1.0 - v / end) / a
            } else {
                left
            };
            let time = stops.min(left);
            let kept = libm::exp(-a * time);
            q += end * time + (v - end) * (1.0 - kept) / a;
            v = if stops < left {
                0.0
            } else {
                end + (v - end) * kept
            };
            left -= time;
        }
    }
    let record = Record::of(&positions, &commands);
    let fitter = RecordFitter::new(&record).expect("a motion");
    let values = valued([(Effect::A, a), (Effect::B, b), (Effect::Coulomb, c)]);
    let mut largest = 0.0_f64;
    let mut see = |row: &Row<'_>| largest = largest.max(row.innovation.abs());
    let pass = fitter.pass(&values, horizon(1000.0));
    assert!(pass.run(&values, &[], &mut see));
    assert!(largest < 1e-3, "{largest} counts");
}
