//! The loop driven by the command that acted against the paper's (5)–(7), (9) and (11), written down
//! here once more, in absolute positions and with a PID of the model's own.

use crate::support::{Bench, Draw, paper_noise};
use identifier_core::GradientLoop;
use identifier_core::parameters::{PerParameter, ServoParameters};
use identifier_core::settings::{ControllerSettings, Settings};

/// The paper's equations, sampled: every quantity in SI and double precision. A sample takes reference, measured position and
/// its velocity estimate, and gives ε, â and b̂.
fn literal(
    settings: Settings,
    mu: f64,
    gamma: [f64; 2],
    mut theta: [f64; 2],
) -> impl FnMut(f64, f64, f64) -> [f64; 3] {
    let t = settings.sample_time;
    let ControllerSettings { kp, kd, ki, .. } = settings.controller.expect("ours");
    let decay = -(-settings.cutoff * t).exp_m1();
    let b_min = settings.identifier.parameter_range.expect("a box").b[0];
    // q_e, q̇_e, the last increment and ∫e_e.
    let [mut position, mut velocity, mut increment, mut integral] = [0.0; 4];
    // u_e over the sample just passed, and low-pass filters of q̇_e and u_e.
    let (mut command, mut filtered) = (0.0, [0.0; 2]);
    // When the servo moved last, and where it was, s and rad.
    let (mut moved, mut time) = ((-1.0, 0.0_f64), 0.0);
    move |reference, measured, measured_velocity| {
        filtered[0] += decay * (increment / t - filtered[0]);
        filtered[1] += decay * (command - filtered[1]);
        let phi = [filtered[0], -filtered[1]];
        let output_error = measured - position;
        let y = mu * output_error + (measured_velocity - filtered[0]);
        // (11), with the guard of the sampled law.
        let strength = t * (0..2).map(|i| gamma[i] * phi[i] * phi[i]).sum::<f64>();
        let slowed = (0.05 * b_min * kd / strength).min(1.0);
        // A servo that has not moved for 0.1 s is at rest, and nothing is learnt from it.
        if (measured - moved.1).abs() > 0.5 * settings.resolution {
            moved = (time, measured);
        }
        let is_still = time - moved.0 > 0.1 + 0.5 * t;
        time += t;
        for i in (0..2).filter(|_| !is_still) {
            theta[i] -= slowed * t * gamma[i] * phi[i] * y;
        }
        theta[0] = theta[0].max(0.0);
        // (6): the same PID on e_e = q_d − q_e.
        let error = reference - position;
        command = kp * error - kd * filtered[0] + ki * integral;
        integral += t * error;
        // (5) over the sample, exactly.
        let [a, b] = theta;
        let x = a * t;
        let h2 = if x < 1e-3 {
            0.5 - x / 6.0 + x * x / 24.0 - x * x * x / 120.0
        } else {
            (x + (-x).exp_m1()) / (x * x)
        };
        let acceleration = b * command - a * velocity;
        increment = t * velocity + h2 * t * t * acceleration;
        velocity += (1.0 - x * h2) * t * acceleration;
        position += increment;
        [output_error, a, b]
    }
}

#[test]
fn where_no_limit_acts_it_is_the_papers_loop() {
    const SERVOS: u32 = 100;
    let mut furthest = 0.0_f64;
    let mut learnt = 0;
    for seed in 1..=SERVOS {
        let mut random = Draw::new(7919 * seed);
        let b = random.between(50.0, 2000.0);
        let a = random.uniform(0.0, 20.0);
        let bandwidth = random.between(10.0, 60.0);
        let counts = random.between(2000.0, 65_536.0).round();
        let load = random.uniform(-40.0, 40.0);
        let sample_time = random.one_of(&[2.5e-4, 5e-4, 1e-3]);
        let (kp, kd) = (bandwidth * bandwidth / b, 2.0 * bandwidth / b);
        let ki = 0.1 * bandwidth * kp;
        let guess = b * random.between(0.7, 1.4);
        let gamma = [random.between(0.5, 15.0), b * random.between(0.5, 10.0)];
        let mut settings = Settings::new(sample_time, counts)
            .with_pid(kp, kd, ki, f64::INFINITY)
            .with_servo_range([0.0, 20.0], [b / 1.5, b * 1.5]);
        settings.identifier.initial.b = Some(guess);
        settings.identifier.gamma = Some(PerParameter::new(gamma[0], gamma[1], 0.0, 0.0));
        let servo_loop: GradientLoop<f64, 2> = settings.build().expect("certified");
        let identifier = servo_loop.identifier();

        let servo = ServoParameters::new(a, b, 0.0, load);
        let start = random.uniform(-2e9, 2e9) as i32;
        let mut bench = Bench::new(&servo, &settings, start);
        let mut wanted = paper_noise(&settings, seed);
        let mut state = servo_loop.start(start);
        let mut literal = literal(settings, identifier.mu(), gamma, [0.0, guess]);
        let (mut measured, mut measured_velocity, mut theta) = (0.0, 0.0, [0.0; 2]);
        let decay = -(-settings.cutoff * sample_time).exp_m1();
        for _ in 0..(60.0 / sample_time) as u64 {
            let (offset, count) = (wanted(), bench.count());
            let step = servo_loop.process(&mut state, start, offset, count);
            let step = step.expect("in reach");
            let now = f64::from(count.wrapping_sub(start)) * settings.resolution;
            measured_velocity += decay * ((now - measured) / sample_time - measured_velocity);
            measured = now;
            let [output_error, a, b] =
                literal(offset * settings.resolution, measured, measured_velocity);
            theta = [a, b];
            let own = step.seen.output_error * settings.resolution;
            furthest = furthest.max((own - output_error).abs());
            bench.plant.advance(step.control.command);
        }
        let found = servo_loop.estimates(&state).expect("estimates");
        let apart = [found.a - theta[0], found.b - theta[1]].map(f64::abs);
        let alike = apart[0] < 1e-9 * (1.0 + found.a) && apart[1] < 1e-9 * found.b;
        assert!(
            alike && furthest < 1e-9,
            "servo {seed}: {apart:?}, {furthest:e}"
        );
        learnt += u32::from((found.b / b - 1.0).abs() < 0.5 * (guess / b - 1.0).abs());
    }
    // Agreement of two loops that learn nothing would prove nothing.
    assert!(learnt > SERVOS / 2, "{learnt} of {SERVOS} learnt");
    println!("{SERVOS} servos, 60 s: output errors at most {furthest:.1e} rad apart");
}
