//! Identification continues while the new gains are in force: by the economical recursion, from the
//! next sample on and without a first fit.

use commissioning::{CommissionInputs, Phase, SynchronousCommission};
use identifier_core::identifier::{ExpectedMotion, GaussNewtonRecursion, Identify};
use identifier_core::parameters::Unknowns;
use identifier_core::settings::Settings;
use virtual_servo::{Encoder, Servo};

use crate::rig::ordinary;

type Recursion = GaussNewtonRecursion<f32, Unknowns<4>, 4>;

#[test]
fn after_the_trial_has_begun_the_estimates_are_those_of_the_fit_and_follow_the_servo() {
    let bench = ordinary();
    let time = bench.settings.sample_time;
    let mut servo = Servo::at_rest(&bench.servo, &bench.effects, time, 1).expect("allowed");
    let encoder = Encoder::new(bench.counts);
    let recursion: Recursion = Settings::new(time, bench.counts).build().expect("allowed");
    let mut commission =
        SynchronousCommission::<f32>::new(&bench.settings, None, None).expect("allowed");
    let (mut learning, mut begun) = (None, None);
    let (mut last, mut acted) = (0, 0.0);
    loop {
        let count = encoder.read(servo.position()) as i32;
        let increment = (count - last) as f32;
        last = count;
        if let Some(state) = &mut learning {
            recursion.check(increment, acted).expect("within reach");
            let _ = recursion.update(state, increment, acted);
        }
        let done = commission.sample(&CommissionInputs {
            count: Some(count),
            late: false,
            stop: None,
        });
        if done.phase == Phase::Trial && learning.is_none() {
            let state = commission.state().expect("it began");
            let found = state.servo().expect("it is known");
            let tuning = state.tuning().expect("it was tuned");
            let state = recursion.start_from_known(
                found,
                &ExpectedMotion {
                    bandwidth: tuning.bandwidth,
                    command: tuning.kp * tuning.predicted_response.step,
                },
            );
            begun = Some((*found, recursion.estimates_in(&recursion.snapshot(&state))));
            learning = Some(state);
        }
        if done.phase.is_end() {
            assert_eq!(done.phase, Phase::Applied);
            break;
        }
        acted = done.command.unwrap_or(0.0) as f32;
        servo.advance(f64::from(acted));
    }
    let state = learning.expect("there was a trial");
    let (fitted, at_first) = begun.expect("there was a trial");
    assert!((at_first.b / fitted.parameters.b - 1.0).abs() < 1e-6);
    assert!(recursion.is_running(&state));
    let learnt = recursion.estimates_in(&recursion.snapshot(&state));
    println!("{:?}\n{fitted:?}\n{learnt:?}", bench.servo);
    let errors = recursion
        .report(&state)
        .errors_of_parameters()
        .expect("it runs");
    println!("{errors:?}");
    assert!((learnt.b / bench.servo.b - 1.0).abs() < 0.002, "{learnt:?}");
    let off = (learnt.coulomb - bench.servo.coulomb).abs();
    assert!(off < 3.0 * errors.coulomb, "{learnt:?}");
}
