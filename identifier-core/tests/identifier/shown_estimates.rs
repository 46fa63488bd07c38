//! The interrupt copies a few words of a sample, and the background computes that sample's estimates from
//! them later.

use crate::support::{Kind, Loop, Servo, paper};
use identifier_core::Settings;
use identifier_core::identifier::{GaussNewtonIdentifier, GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{PerParameter, ServoParameters, Unknowns};
use identifier_core::settings::FromSettings;

const SERVO: Servo = paper(ServoParameters::new(0.5, 250.0, 0.0, 20.0), 40.0, 5);

fn settings() -> Settings {
    let mut settings = (SERVO.settings()).with_servo_range([0.0, 50.0], [110.0, 1000.0]);
    let identifier = &mut settings.identifier;
    identifier.initial.a = Some(5.0);
    identifier.initial.b = Some(150.0);
    // More than the servo has.
    identifier.bounds.a = Some([5.0, 100.0]);
    identifier.correction = Some([9.0, 0.19, 4.0]);
    identifier.gamma = Some(PerParameter::new(200.0, 1000.0, 100.0, 100.0));
    settings
}

/// Six seconds beside a relay. Every so often the estimates are shown, and looked at only when the
/// servo has gone on for half a second. They have often moved by then, and â was often at a bound.
fn shown_later<N: Copy, I: Identify<N>>(identifier: &I, command_of: impl Fn(f64) -> N) {
    let mut state = identifier.start();
    let mut run = Loop::new(Kind::Relay, &SERVO, 0.5);
    let mut waiting = None;
    let (mut moved, mut at_bound) = (0, 0);
    for k in 0..6000 {
        let (increment, command) = run.sample();
        let seen = identifier.process(&mut state, increment as i32, command_of(command));
        seen.expect("within reach");
        identifier.work(&mut state, u32::MAX);
        if k % 500 != 499 {
            continue;
        }
        let of = |shown: &_| {
            (
                identifier.estimates_in(shown),
                identifier.at_bounds_in(shown),
            )
        };
        let snapshot = identifier.snapshot(&state);
        let now = of(&snapshot);
        if let Some((shown, then)) = waiting.replace((snapshot, now)) {
            let later = of(&shown);
            assert_eq!(later, then);
            moved += u32::from(later.0 != now.0);
            at_bound += u32::from(later.1.a);
        }
    }
    assert!(moved > 3, "the estimates moved on {moved} times");
    assert!(at_bound > 2, "â stood at its bound {at_bound} times");
}

fn of_numbers<I: Identify<f32> + FromSettings>(settings: &Settings) {
    assert!(size_of::<I::Snapshot>() <= 6 * size_of::<u32>());
    let identifier: I = settings.build().expect("valid");
    shown_later(&identifier, |command| command as f32);
}

#[test]
fn a_snapshot_gives_the_sample_s_estimates() {
    of_numbers::<GradientIdentifier<f32, LowPass<f32>, Unknowns<2>, 2>>(&settings());
    of_numbers::<GaussNewtonIdentifier<f32, Unknowns<4>, 4>>(&settings());
}

#[cfg(feature = "fixed")]
#[test]
fn a_fixed_point_snapshot_gives_the_sample_s_estimates() {
    use identifier_core::fixed_point::Word;
    use identifier_core::settings::RangeSettings;
    type Identifier = GradientIdentifier<Word, LowPass<Word>, Unknowns<2>, 2>;
    assert!(size_of::<<Identifier as Identify<_>>::Snapshot>() <= 6 * size_of::<u32>());
    let mut settings = settings();
    settings.identifier.ranges = Some(RangeSettings {
        error: 10.0,
        velocity: 200.0,
        command: 12.0,
    });
    let identifier: Identifier = settings.build().expect("it fits");
    shown_later(&identifier, |command| identifier.command_word(command));
}
