//! The certificate: Lyapunov's function never rises, refusals name a value that would do, and the verdict
//! on the sampled loop agrees with runs of it.

use identifier_core::control::{ControlState, Controller, Gains};
use identifier_core::interval::Interval;
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::{PerParameter, ServoParameters};
use identifier_core::settings::{ControllerSettings, SettingsError};
use identifier_core::stability::{Certificate, CertificateError, ParameterRange, SampledLoop};
use identifier_core::{GradientLoop, Settings};
use virtual_servo::Plant;
use virtual_servo::excitation::NormalSource;

/// A seeded stream of random numbers.
struct Random(NormalSource);

impl Random {
    fn new(seed: u32) -> Self {
        Self(NormalSource::new(seed))
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.next_uniform()
    }

    fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.0.next_uniform())
    }
}

/// A random box of servos.
fn random_range(random: &mut Random) -> ParameterRange {
    let a_min = random.uniform(0.0, 10.0);
    let a_max = a_min + random.log_uniform(0.1, 50.0);
    let b_min = random.log_uniform(1.0, 500.0);
    let b_max = b_min * random.log_uniform(1.0, 10.0);
    range([a_min, a_max], [b_min, b_max])
}

fn range([a_min, a_max]: [f64; 2], [b_min, b_max]: [f64; 2]) -> ParameterRange {
    let a = Interval::new("a", a_min, a_max).expect("ordered");
    let b = Interval::new("b", b_min, b_max).expect("ordered");
    ParameterRange::new(a, b).expect("positive")
}

fn random_gains(random: &mut Random) -> Gains {
    Gains::new(
        random.log_uniform(0.5, 50.0),
        random.log_uniform(0.01, 2.0),
        random.log_uniform(0.1, 50.0),
    )
    .expect("positive")
}

/// A random servo of a box.
fn random_servo(random: &mut Random, parameter_range: &ParameterRange) -> (f64, f64) {
    let (a, b) = (parameter_range.a(), parameter_range.b());
    let a = random.uniform(a.min(), a.max());
    (a, random.log_uniform(b.min(), b.max()))
}

/// The continuous-time loop (4), (7), (11): [q, q̇, z̄, q_e, q̇_e, z_e, â, b̂], where z̄ = ∫e.
struct Continuous {
    a: f64,
    b: f64,
    load: f64,
    gains: Gains,
    mu: f64,
    gamma: [f64; 2],
}

type State = [f64; 8];

impl Continuous {
    fn derivative(&self, x: &State, reference: f64) -> State {
        let [q, v, z, q_e, v_e, z_e, a_hat, b_hat] = *x;
        let (kp, kd, ki) = (self.gains.kp(), self.gains.kd(), self.gains.ki());
        let u = kp * (reference - q) - kd * v + ki * z;
        let u_e = kp * (reference - q_e) - kd * v_e + ki * z_e;
        let y = self.mu * (q - q_e) + (v - v_e);
        [
            v,
            -self.a * v + self.b * u + self.load,
            reference - q,
            v_e,
            -a_hat * v_e + b_hat * u_e,
            reference - q_e,
            -self.gamma[0] * v_e * y,
            self.gamma[1] * u_e * y,
        ]
    }

    /// Classical Runge–Kutta step.
    fn step(&self, x: &State, reference: f64, h: f64) -> State {
        let shifted = |k: &State, h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
        let k1 = self.derivative(x, reference);
        let k2 = self.derivative(&shifted(&k1, h / 2.0), reference);
        let k3 = self.derivative(&shifted(&k2, h / 2.0), reference);
        let k4 = self.derivative(&shifted(&k3, h), reference);
        std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    /// V₁ = H₁ + H₂ of (10) and (12).
    fn storage(&self, x: &State) -> f64 {
        let [q, v, z, q_e, v_e, z_e, a_hat, b_hat] = *x;
        let (e, r) = (q - q_e, v - v_e);
        let omega = z_e - z - self.load / (self.b * self.gains.ki());
        let (bkp, bki) = (self.b * self.gains.kp(), self.b * self.gains.ki());
        let h1 = bkp * e * e
            + r * r
            + self.mu * bki * omega * omega
            + 2.0 * self.mu * e * r
            + 2.0 * bki * e * omega;
        let (a_error, b_error) = (a_hat - self.a, b_hat - self.b);
        let h2 = a_error * a_error / self.gamma[0] + b_error * b_error / self.gamma[1];
        (h1 + h2) / 2.0
    }
}

#[test]
fn no_certified_case_ever_raises_lyapunovs_function() {
    let mut random = Random::new(14);
    let mut certified = 0;
    while certified < 200 {
        let parameter_range = random_range(&mut random);
        let gains = random_gains(&mut random);
        let mu = random.log_uniform(0.1, 50.0);
        if Certificate::new(&gains, &parameter_range, mu).is_err() {
            continue;
        }
        certified += 1;
        let (a, b) = random_servo(&mut random, &parameter_range);
        let system = Continuous {
            a,
            b,
            load: random.uniform(-40.0, 40.0),
            gains,
            mu,
            gamma: [(0.01, 100.0), (1.0, 1e4)].map(|(low, high)| random.log_uniform(low, high)),
        };
        let mut x: State = [0.0; 8];
        x[6] = random.uniform(0.0, 50.0);
        x[7] = random.log_uniform(b / 10.0, 10.0 * b);
        let largest = x[7].max(b);
        let h = 0.02 / (a + 50.0 + largest * (gains.kd() + gains.kp().sqrt()));
        let mut storage = system.storage(&x);
        let start = storage;
        for k in 0..20_000 {
            let reference = if (k / 2000) % 2 == 0 { 0.1 } else { -0.1 };
            x = system.step(&x, reference, h);
            let next = system.storage(&x);
            let rises = next - storage;
            assert!(
                rises <= 1e-7 * start,
                "{rises} at step {k} for {gains:?}, a = {a}, b = {b}"
            );
            storage = next;
        }
        assert!(storage.is_finite());
    }
}

#[test]
fn the_errors_name_values_that_are_accepted() {
    let mut random = Random::new(41);
    let (mut damping, mut proportional) = (0, 0);
    let is_damped = |certificate: Result<Certificate, CertificateError>| {
        !matches!(certificate, Err(CertificateError::DampingTooSmall { .. }))
    };
    for _ in 0..2000 {
        let parameter_range = random_range(&mut random);
        let gains = random_gains(&mut random);
        let mu = random.log_uniform(0.1, 50.0);
        match Certificate::new(&gains, &parameter_range, mu) {
            Err(CertificateError::DampingTooSmall {
                mu_below, kd_above, ..
            }) => {
                damping += 1;
                let smaller = Certificate::new(&gains, &parameter_range, 0.999 * mu_below);
                let damped = Gains::new(gains.kp(), 1.001 * kd_above, gains.ki()).expect("valid");
                let mended = Certificate::new(&damped, &parameter_range, mu);
                assert!(is_damped(smaller) && is_damped(mended));
            }
            Err(CertificateError::ProportionalGainTooSmall { kp_above, .. }) => {
                proportional += 1;
                let stiff = Gains::new(1.001 * kp_above, gains.kd(), gains.ki()).expect("valid");
                assert!(Certificate::new(&stiff, &parameter_range, mu).is_ok());
            }
            Err(other) => panic!("{other}"),
            Ok(_) => {}
        }
    }
    assert!(damping > 100 && proportional > 100, "the search meets both");
}

#[test]
fn the_automatic_mu_certifies_every_range_that_some_mu_certifies() {
    let mut random = Random::new(7);
    for _ in 0..2000 {
        let parameter_range = random_range(&mut random);
        let gains = random_gains(&mut random);
        let any = (0..200).any(|k| {
            let mu = 0.01 * 1.06_f64.powi(k);
            // The automatic μ keeps a tenth of distance from the first limit.
            mu < 0.45 * parameter_range.slowest_decay(gains.kd())
                && Certificate::new(&gains, &parameter_range, mu).is_ok()
        });
        let automatic = Certificate::with_automatic_mu(&gains, &parameter_range).is_ok();
        assert!(automatic || !any, "{gains:?} {parameter_range:?}");
    }
}

#[test]
fn a_loop_that_sampling_makes_unstable_is_refused_although_its_range_is_certified() {
    let mut settings = Settings {
        cutoff: 100.0,
        ..Settings::new(0.02, 10_000.0)
            .with_pid(9.0, 0.19, 4.0, 10.0)
            .with_servo_range([0.0, 50.0], [110.0, 1000.0])
    };
    let learning = &mut settings.identifier;
    learning.initial.b = Some(50.0);
    learning.bounds.a = Some([0.0, 25.0]);
    learning.bounds.b = Some([5.0, 5000.0]);
    learning.gamma = Some(PerParameter::new(0.2, 110.0, 0.0, 0.0));
    learning.mu = Some(10.0);
    let parameter_range = range([0.0, 50.0], [110.0, 1000.0]);
    let gains = Gains::new(9.0, 0.19, 4.0).expect("positive");
    assert!(Certificate::new(&gains, &parameter_range, 10.0).is_ok());
    let refused = settings.build::<GradientLoop<f32, 2>>().err();
    assert!(matches!(refused, Some(SettingsError::SampledLoop(_))));
    // The paper's own rate and filter.
    settings.sample_time = 1e-3;
    settings.cutoff = 500.0;
    assert!(settings.build::<GradientLoop<f32, 2>>().is_ok());
}

#[test]
fn the_sampled_test_agrees_with_running_the_loop() {
    let mut random = Random::new(99);
    let (mut stable, mut unstable) = (0, 0);
    for _ in 0..350 {
        let sample_time = random.log_uniform(2e-4, 2e-2);
        let gains = random_gains(&mut random);
        let (a, b) = (random.uniform(0.0, 20.0), random.log_uniform(1.0, 5000.0));
        let cutoff = random.log_uniform(20.0, 1000.0);
        let settings = Settings {
            resolution: 1.0,
            cutoff,
            controller: Some(ControllerSettings::pid(gains.kp(), gains.kd(), gains.ki())),
            ..Settings::new(sample_time, 1.0)
        };
        let units = settings.units().expect("valid");
        let Ok(controller) = settings.build::<Controller<f64, LowPass<f64>>>() else {
            continue;
        };
        let transfer = VelocityEstimate::<f64>::transfer(&controller.velocity);
        let predicted = SampledLoop::new(&units, &gains, &transfer).is_stable(a, b);
        let servo = ServoParameters::new(a, b, 0.0, 0.0);
        let mut plant = Plant::at_rest(&servo, units.sample_time());
        let mut control = ControlState::default();
        let mut last = 0.0;
        let mut transient = [0.0_f64; 2];
        for k in 0..200_000 {
            let reference = if k == 0 { 1.0 } else { 0.0 };
            let (error, increment) = (reference - plant.position, plant.position - last);
            last = plant.position;
            let Ok(sample) = controller.process(&mut control, error, increment) else {
                transient[1] = f64::INFINITY;
                break;
            };
            plant.advance(sample.command);
            if (100_000..150_000).contains(&k) {
                transient[0] = transient[0].max(plant.position.abs());
            } else if k >= 150_000 {
                transient[1] = transient[1].max(plant.position.abs());
            }
        }
        let decays = transient[1] < transient[0] || transient[1] < 1e-9;
        if !decays && transient[1] < 1.01 * transient[0] {
            // On the edge: no run of any length decides.
            continue;
        }
        assert_eq!(
            predicted, decays,
            "T = {sample_time}, {gains:?}, a = {a}, b = {b}"
        );
        stable += u32::from(predicted);
        unstable += u32::from(!predicted);
    }
    assert!(stable > 35 && unstable > 35, "{stable}, {unstable}");
}
