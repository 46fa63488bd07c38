//! Encoders whose noise exceeds a count.
//!
//! `SERVOS=100 SEED=7 cargo test -p commissioning --test commission noise -- --ignored --nocapture` draws other servos.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use commissioning::{CommissionInputs, CommissionSettings, Limits, Phase, SynchronousCommission};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use virtual_servo::{Effects, Encoder, Servo, SplitMix64};

const LIMIT: f64 = 10.0;

/// A servo, and an axis that its user knows by its strength to half a decade.
struct Drawn {
    servo: ServoParameters,
    counts: f64,
    settings: CommissionSettings,
    seed: u32,
}

/// Ends of commissionings with one noise.
#[derive(Debug, Default)]
struct Ends {
    applied: u32,
    noise: u32,
    /// Others, by name.
    misnamed: BTreeMap<&'static str, u32>,
    /// Servos that left their travel by more than a fiftieth of it.
    left: u32,
}

fn drawn(seed: u32, place: u32) -> Drawn {
    let mut random = SplitMix64::new(u64::from(seed) << 32 | u64::from(place));
    let sample_time = [1e-3, 2.5e-4, 1e-4][place as usize % 3];
    let decades = random.uniform(0.0, 2.0);
    let b = 50.0 * 10.0_f64.powf(decades);
    let counts = [4096.0, 16_384.0, 65_536.0][place as usize / 3 % 3];
    let servo = ServoParameters::new(
        random.uniform(0.0, 2.0),
        b,
        b * LIMIT * random.uniform(0.0, 0.2),
        b * LIMIT * random.uniform(-0.2, 0.2),
    );
    let scale = 10.0_f64.powf(0.25 * (2.0 * decades).floor());
    let (travel, speed) = (0.5 * scale, 15.0 * scale);
    let limits = Limits::new([-travel, travel], speed, [-LIMIT, LIMIT]);
    Drawn {
        servo,
        counts,
        settings: CommissionSettings::new(sample_time, TAU / counts, limits),
        seed: seed.wrapping_add(place),
    }
}

impl Drawn {
    /// Commissions it with white noise of so many counts: the reason of its end, and the farthest that it was, over its
    /// travel.
    fn commission(&self, noise: f64) -> (Option<Reason>, f64) {
        const MAX_DURATION: f64 = 60.0;
        let CommissionSettings {
            sample_time,
            resolution,
            limits,
            ..
        } = self.settings;
        let mut random = SplitMix64::new(u64::from(self.seed));
        let mut commission =
            SynchronousCommission::<f32>::new(&self.settings, None, None).expect("allowed");
        let mut plant =
            Servo::at_rest(&self.servo, &Effects::NONE, sample_time, self.seed).expect("allowed");
        let encoder = Encoder::new(self.counts);
        let mut farthest = 0.0_f64;
        for _ in 0..(MAX_DURATION / sample_time) as u64 {
            let gaussian = (0..12).map(|_| random.next_uniform()).sum::<f64>() - 6.0;
            let position = plant.position() + noise * gaussian * resolution;
            let done = commission.sample(&CommissionInputs {
                count: Some(encoder.read(position) as i32),
                late: false,
                stop: None,
            });
            plant.advance(done.command.unwrap_or(0.0));
            farthest = farthest.max(plant.position().abs() / limits.travel[1]);
            if done.phase.is_end() {
                let is_applied = done.phase == Phase::Applied;
                assert_eq!(is_applied, done.reason.is_none());
                return (done.reason, farthest);
            }
        }
        panic!("it neither ends nor fails");
    }
}

fn ends(noise: f64, seed: u32, servos: u32) -> Ends {
    let mut ends = Ends::default();
    for place in 0..servos {
        let (reason, farthest) = drawn(seed, place).commission(noise);
        match reason {
            None => ends.applied += 1,
            Some(Reason::EncoderNoise) => ends.noise += 1,
            Some(other) => *ends.misnamed.entry(other.name()).or_default() += 1,
        }
        ends.left += u32::from(farthest > 1.02);
    }
    println!("{noise} counts: {ends:?}");
    ends
}

#[test]
fn noise_of_counts_commissions_or_is_named() {
    const SERVOS: u32 = 18;
    let mut others = 0;
    for (noise, least) in [(0.5, 16), (2.0, 11), (5.0, 9)] {
        let ends = ends(noise, 1, SERVOS);
        assert!(ends.applied >= least, "{noise}: {ends:?}");
        others += SERVOS - ends.applied - ends.noise;
    }
    assert!(others * 9 <= SERVOS * 3, "{others}");
}

#[test]
#[ignore = "minutes: SERVOS=100 SEED=n"]
fn noise_of_counts_on_drawn_servos() {
    let given = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let (seed, servos) = (given("SEED").unwrap_or(1), given("SERVOS").unwrap_or(100));
    for noise in [0.0, 0.1, 0.3, 0.5, 1.0, 2.0, 5.0] {
        let _ = ends(noise, seed, servos);
    }
}

#[test]
fn noise_that_is_declared_is_not_measured_first_and_one_that_grew_is() {
    let mut axis = drawn(1, 0);
    let sound = axis.commission(2.0);
    assert_eq!(sound.0, None);
    for declared in [2.0, 0.5] {
        axis.settings.noise = declared * axis.settings.resolution;
        assert_eq!(axis.commission(2.0).0, None, "{declared}");
    }
}

#[test]
fn noise_that_leaves_no_room_for_a_motion_is_the_reason() {
    let mut axis = drawn(1, 0);
    let travel = 40.0 * axis.settings.resolution;
    axis.settings.limits.travel = [-travel, travel];
    let (reason, farthest) = axis.commission(2.0);
    assert_eq!(reason, Some(Reason::EncoderNoise));
    assert!(farthest < 1.0, "{farthest}");
}
