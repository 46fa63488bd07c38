//! The verdict of each kind of evidence, beside any other.

use identifier_core::parameters::{Term, Unknown};
use identifier_log::verdict::{
    Cause, Evidence, FitEvidence, MissingEffect, Motion, Residual, Status, UnknownEvidence, Verdict,
};

use Status::{Aborted, Converged, Moving, NoInformation, Partial, Unexplained};
use Unknown::{A, B, Coulomb, Load};

/// A servo of which everything is known.
fn known() -> Evidence {
    let mut evidence = Evidence::from_motion(Motion {
        samples: 60_000,
        counts_travelled: 4e5,
    });
    for (unknown, estimate, scale, std_error) in [
        (A, 0.22, 50.0, 3e-3),
        (B, 257.7, 257.7, 0.01),
        (Coulomb, 10.0, 500.0, 0.02),
        (Load, 0.0, 500.0, 0.02),
    ] {
        evidence.add(
            unknown,
            UnknownEvidence {
                estimate,
                std_error: Some(std_error),
                refit_difference: Some(std_error),
                ..UnknownEvidence::at(scale)
            },
        );
    }
    evidence
}

/// Evidence for a sound result, changed for one unknown.
fn with(unknown: Unknown, change: impl Fn(&mut UnknownEvidence)) -> Evidence {
    let mut evidence = known();
    let mut of = *evidence
        .unknowns()
        .find(|(known, _)| *known == unknown)
        .map(|(_, of)| of)
        .expect("it is estimated");
    change(&mut of);
    evidence.add(unknown, of);
    evidence
}

fn lacking(cause: Option<Cause>, unknown: Unknown, shift: f64) -> Evidence {
    let mut evidence = with(unknown, |of| of.refit_difference = Some(shift));
    evidence.lack = Some(MissingEffect { cause, share: 0.9 });
    evidence
}

/// A fit to a whole record that nothing speaks against, changed.
fn fitted(change: impl Fn(&mut FitEvidence)) -> Evidence {
    let mut fit = FitEvidence {
        profile: [1e3; 2],
        reverses: true,
        delay_at_bound: false,
        was_stopped: false,
        is_explained: true,
    };
    change(&mut fit);
    let mut evidence = known();
    evidence.fit = Some(fit);
    evidence
}

/// Asserts the verdict of each row: on evidence, its status, code and unknown.
fn assert_verdicts(rows: impl IntoIterator<Item = (Evidence, Status, u8, Option<Unknown>)>) {
    for (evidence, status, code, unknown) in rows {
        let verdict = Verdict::on(&evidence);
        let reason = &verdict.reason;
        let found = (verdict.status, reason.code(), reason.unknown());
        assert_eq!(found, (status, code, unknown), "{verdict}");
    }
}

#[test]
fn a_fit_that_does_not_separate_gain_from_friction_is_not_converged() {
    for side in [0, 1] {
        // The errors of the fit are as wide as the valley, and b may be known all the same.
        let evidence = fitted(|fit| fit.profile[side] = 8.0);
        let mut unsure = with(B, |of| of.std_error = Some(0.2 * of.estimate));
        unsure.fit = evidence.fit;
        let verdicts = [&evidence, &unsure].map(|evidence| Verdict::on(evidence).hides_all());
        assert_eq!(verdicts, [false, true]);
        assert_verdicts([
            (evidence, Partial, 25, None),
            (unsure, NoInformation, 25, None),
        ]);
    }
    assert_verdicts([
        (fitted(|_| {}), Converged, 0, None),
        (
            fitted(|fit| fit.delay_at_bound = true),
            NoInformation,
            28,
            None,
        ),
        (fitted(|fit| fit.was_stopped = true), Moving, 31, None),
        (fitted(|fit| fit.reverses = false), Partial, 26, None),
    ]);
}

#[test]
fn a_fit_need_not_know_the_size_of_an_effect_but_the_four_parameters() {
    let unsure = |unknown: Unknown| {
        let mut evidence = fitted(|_| {});
        let of = UnknownEvidence {
            estimate: 1.0,
            std_error: Some(1.0),
            ..UnknownEvidence::at(1.0)
        };
        evidence.add(unknown, of);
        evidence
    };
    assert_verdicts([
        (unsure(Unknown::Delay), Converged, 0, None),
        (unsure(Coulomb), Partial, 23, Some(Coulomb)),
    ]);
}

#[test]
fn every_rejection_reason_has_its_status_and_code() {
    let b = Some(B);
    let changed = |change: fn(&mut Evidence)| {
        let mut evidence = known();
        change(&mut evidence);
        evidence
    };
    let moved = |samples: u64, counts_travelled: f64| {
        let mut evidence = known();
        evidence.motion = Motion {
            samples,
            counts_travelled,
        };
        evidence
    };
    let unsure = |std_error: f64| with(B, |b| b.std_error = Some(std_error));
    let moving = |movement: f64| with(B, |b| b.movement = movement);
    let refitted = |difference: f64| with(B, |b| b.refit_difference = Some(difference));
    // An unmodelled effect is accepted if it biases nothing.
    let harmless = lacking(Some(Cause::Eccentricity), B, 0.5);
    // Friction at the bound of zero is a result.
    let none = with(Coulomb, |coulomb| {
        (coulomb.estimate, coulomb.at_bound) = (0.0, true);
    });
    assert_verdicts([
        (known(), Converged, 0, None),
        (changed(|of| of.aborted = true), Aborted, 10, None),
        (with(B, |b| b.estimate = f64::NAN), NoInformation, 20, b),
        (moved(30, 4e5), NoInformation, 21, None),
        (moved(60_000, 0.0), NoInformation, 22, None),
        (moved(60_000, 15.0), NoInformation, 22, None),
        (moved(60_000, f64::NAN), NoInformation, 22, None),
        (unsure(11.0), Partial, 23, b),
        (unsure(40.0), NoInformation, 23, b),
        (unsure(f64::INFINITY), NoInformation, 23, b),
        (unsure(f64::NAN), NoInformation, 23, b),
        (with(B, |b| b.at_bound = true), NoInformation, 24, b),
        (changed(|of| of.not_a_servo = true), NoInformation, 27, None),
        (
            changed(|of| of.missing_term = Some(Term::Gravity)),
            NoInformation,
            29,
            None,
        ),
        (moving(20.0), Moving, 30, b),
        (moving(f64::INFINITY), Moving, 30, b),
        (moving(f64::NAN), Moving, 30, b),
        (lacking(Some(Cause::Delay), B, -15.0), Unexplained, 40, b),
        (lacking(None, Coulomb, 5.0), Unexplained, 41, Some(Coulomb)),
        (refitted(-10.0), Unexplained, 42, b),
        (harmless, Converged, 0, None),
        (none, Converged, 0, None),
    ]);
}

#[test]
fn unseen_data_must_be_predicted_where_the_error_exceeds_the_encoders() {
    let predicted = |error, beyond_encoder| {
        let mut evidence = known();
        evidence.prediction = Some(error);
        evidence.residual = Some(Residual {
            rms: beyond_encoder,
            resolution_rms: 1.0,
            correlation: 0.9,
        });
        evidence
    };
    assert_verdicts([
        (predicted(0.3, 20.0), Unexplained, 43, None),
        (predicted(0.02, 20.0), Converged, 0, None),
        (predicted(0.3, 1.0), Converged, 0, None),
    ]);
}

/// What a fit leaves beyond its sensor's noise is said, and not that no effect is missing.
#[test]
fn a_fit_that_leaves_more_than_noise_says_so() {
    let left = |is_explained| {
        let mut evidence = fitted(|fit| fit.is_explained = is_explained);
        evidence.innovation = Some(Residual {
            rms: 4.0,
            resolution_rms: 1.0,
            correlation: 0.9,
        });
        evidence
    };
    assert_verdicts([
        (left(true), Converged, 0, None),
        (left(false), Converged, 1, None),
    ]);
}

/// A lack is found where the data would have the estimates, and not where these are on their way.
#[test]
fn a_lack_precedes_movement() {
    let moving = || {
        with(B, |b| {
            b.movement = 12.0;
            b.refit_difference = Some(80.0);
        })
    };
    let mut lacking = moving();
    lacking.lack = Some(MissingEffect {
        cause: Some(Cause::GainDrift),
        share: 0.7,
    });
    assert_verdicts([
        (moving(), Moving, 30, Some(B)),
        (lacking, Unexplained, 40, Some(B)),
    ]);
}
