//! The loop driven by the command that acted against the paper's (5)–(7), (9) and (11), written down
//! here once more, in absolute positions and with a PID of the model's own.

use crate::support::{Bench, Draw};
use identifier_core::GradientLoop;
use identifier_core::excitation::Excitation;
use identifier_core::identifier::Identify;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::{ControllerSettings, Settings, diagonal};
use virtual_servo::excitation::BandLimitedWhiteNoise;

/// The paper's equations, sampled: every quantity in SI and double precision.
struct Literal {
    settings: Settings,
    mu: f64,
    gamma: [f64; 2],
    /// â and b̂.
    theta: [f64; 2],
    position: f64,
    velocity: f64,
    increment: f64,
    integral: f64,
    /// u_e over the sample just passed.
    command: f64,
    /// Low-pass filters: q̇_e, u_e.
    filtered: [f64; 2],
    /// When the servo moved last, and where it was, s and rad.
    moved: (f64, f64),
    time: f64,
}

impl Literal {
    fn new(settings: &Settings, mu: f64, gamma: [f64; 2], theta: [f64; 2]) -> Self {
        Self {
            settings: *settings,
            mu,
            gamma,
            theta,
            position: 0.0,
            velocity: 0.0,
            increment: 0.0,
            integral: 0.0,
            command: 0.0,
            filtered: [0.0; 2],
            moved: (-1.0, 0.0),
            time: 0.0,
        }
    }

    /// One sample: reference, measured position and its velocity estimate. Answers with ε.
    fn sample(&mut self, reference: f64, measured: f64, measured_velocity: f64) -> f64 {
        let t = self.settings.sample_time;
        let ControllerSettings { kp, kd, ki, .. } = self.settings.controller.expect("ours");
        let decay = -(-self.settings.cutoff * t).exp_m1();
        let [velocity, command] = &mut self.filtered;
        *velocity += decay * (self.increment / t - *velocity);
        *command += decay * (self.command - *command);
        let phi = [*velocity, -*command];
        let output_error = measured - self.position;
        let y = self.mu * output_error + (measured_velocity - *velocity);
        // (11), with the guard of the sampled law.
        let b_min = self.settings.identifier.parameter_range.expect("a box").b[0];
        let strength = t * (0..2).map(|i| self.gamma[i] * phi[i] * phi[i]).sum::<f64>();
        let slowed = (0.05 * b_min * kd / strength).min(1.0);
        // A servo that has not moved for 0.1 s is at rest, and nothing is learnt from it.
        if (measured - self.moved.1).abs() > 0.5 * self.settings.resolution {
            self.moved = (self.time, measured);
        }
        let is_still = self.time - self.moved.0 > 0.1 + 0.5 * t;
        self.time += t;
        for i in (0..2).filter(|_| !is_still) {
            self.theta[i] -= slowed * t * self.gamma[i] * phi[i] * y;
        }
        self.theta[0] = self.theta[0].max(0.0);
        // (6): the same PID on e_e = q_d − q_e.
        let error = reference - self.position;
        self.command = kp * error - kd * *velocity + ki * self.integral;
        self.integral += t * error;
        // (5) over the sample, exactly.
        let [a, b] = self.theta;
        let x = a * t;
        let h2 = if x < 1e-3 {
            0.5 - x / 6.0 + x * x / 24.0 - x * x * x / 120.0
        } else {
            (x + (-x).exp_m1()) / (x * x)
        };
        let acceleration = b * self.command - a * self.velocity;
        self.increment = t * self.velocity + h2 * t * t * acceleration;
        self.velocity += (1.0 - x * h2) * t * acceleration;
        self.position += self.increment;
        output_error
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
        settings.identifier.gamma = Some(diagonal([gamma[0], gamma[1], 0.0, 0.0]));
        let servo_loop: GradientLoop<f64, 2> = settings.build().expect("certified");
        let identifier = servo_loop.identifier();

        let servo = ServoParameters::new(a, b, 0.0, load);
        let start = random.uniform(-2e9, 2e9) as i32;
        let mut bench = Bench::new(&servo, &settings, start);
        let units = settings.units().expect("valid");
        let reference = BandLimitedWhiteNoise::new(&units, 0.005, 0.1, seed).expect("valid");
        let mut wanted = Excitation::<f64>::start(&reference);
        let mut state = servo_loop.start(start);
        let mut literal = Literal::new(&settings, identifier.mu(), gamma, [0.0, guess]);
        let mut measured = 0.0;
        let mut measured_velocity = 0.0;
        let decay = -(-settings.cutoff * sample_time).exp_m1();
        for _ in 0..(60.0 / sample_time) as u64 {
            let offset: f64 = reference.process(&mut wanted);
            let count = bench.count();
            let step = servo_loop
                .process(&mut state, start, offset, count)
                .expect("in reach");
            let now = f64::from(count.wrapping_sub(start)) * settings.resolution;
            measured_velocity += decay * ((now - measured) / sample_time - measured_velocity);
            measured = now;
            let output_error =
                literal.sample(offset * settings.resolution, measured, measured_velocity);
            let own = step.seen.output_error * settings.resolution;
            furthest = furthest.max((own - output_error).abs());
            bench.plant.advance(step.control.command);
        }
        let found = identifier
            .estimates(state.identification())
            .expect("estimates");
        let apart = [found.a - literal.theta[0], found.b - literal.theta[1]];
        assert!(
            apart[0].abs() < 1e-9 * (1.0 + found.a) && apart[1].abs() < 1e-9 * found.b,
            "servo {seed}: estimates {apart:?} apart"
        );
        assert!(
            furthest < 1e-9,
            "servo {seed}: output errors {furthest:e} rad apart"
        );
        learnt += u32::from((found.b / b - 1.0).abs() < 0.5 * (guess / b - 1.0).abs());
    }
    // Agreement of two loops that learn nothing would prove nothing.
    assert!(learnt > SERVOS / 2, "{learnt} of {SERVOS} learnt");
    println!("{SERVOS} servos, 60 s: output errors at most {furthest:.1e} rad apart");
}
