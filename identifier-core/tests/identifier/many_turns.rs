//! Counters that wrap after many turns.

use crate::support::{Bench, certified};
use identifier_core::GradientLoop;
use identifier_core::excitation::Excitation;
use identifier_core::measurement::Counter;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::diagonal;
use virtual_servo::excitation::BandLimitedWhiteNoise;

/// The bits of the estimates of a drive that travels for a minute: at a constant speed of whole counts per sample, with
/// the paper's noise on top. The register is 16 bits wide; the count of the drive begins at `start`.
fn travel(start: i32, speed: i32) -> [u64; 3] {
    let mut settings = certified();
    let learning = &mut settings.identifier;
    learning.initial.b = Some(50.0);
    learning.bounds.a = Some([0.0, 100.0]);
    learning.bounds.b = Some([5.0, 5000.0]);
    learning.gamma = Some(diagonal([0.2, 110.0, 0.0, 0.0]));
    learning.mu = Some(10.0);
    let units = settings.units().expect("valid");
    let servo_loop: GradientLoop<f32, 2> = settings.build().expect("certified");
    let noise = BandLimitedWhiteNoise::new(&units, 0.005, 0.1, 1_212_121).expect("valid");
    let mut noise_state = Excitation::<f64>::start(&noise);
    let servo = ServoParameters::new(0.2174, 257.7, 0.0, 20.0);
    // The plant's own position is relative to the start, or the rounding of double precision would show.
    let mut bench = Bench::new(&servo, &settings, start);
    let mut register = Counter::new(start as u16);
    let mut setpoint = start;
    let mut state = servo_loop.start(start);
    for _ in 0..60_000 {
        // As after many turns: a count of 32 bits, through however many wraps.
        let count = start.wrapping_add(register.read(bench.count() as u16));
        setpoint = setpoint.wrapping_add(speed);
        let probe: f64 = noise.process(&mut noise_state);
        let step = servo_loop
            .process(&mut state, setpoint, probe as f32, count)
            .expect("within reach");
        bench.plant.advance(f64::from(step.control.command));
    }
    let found = servo_loop.estimates(&state).expect("estimates");
    [found.a, found.b, found.load].map(f64::to_bits)
}

#[test]
fn a_counter_that_wraps_on_the_way_costs_nothing() {
    // 120 turns of travel through the end of 32 bits.
    let edge = i32::MAX - 600_000;
    let at_home = travel(0, 20);
    for start in [edge, edge + 500_000] {
        assert_eq!(travel(start, 20), at_home, "{start}");
    }
}
