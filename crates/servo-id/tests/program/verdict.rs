//! The verdict of each kind of evidence, beside any other.

use identifier_core::parameters::{Term, Unknown};
use identifier_log::verdict::Residual;
use identifier_log::verdict::{
    Cause, Evidence, FitEvidence, MissingEffect, Motion, Status, UnknownEvidence, Verdict,
};

const MOTION: Motion = Motion {
    samples: 60_000,
    counts_travelled: 4e5,
};

/// A servo of which everything is known.
fn known() -> Evidence {
    let mut evidence = Evidence::from_motion(MOTION);
    for (unknown, estimate, scale, std_error) in [
        (Unknown::A, 0.22, 50.0, 3e-3),
        (Unknown::B, 257.7, 257.7, 0.01),
        (Unknown::Coulomb, 10.0, 500.0, 0.02),
        (Unknown::Load, 0.0, 500.0, 0.02),
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

fn moved(motion: Motion) -> Evidence {
    let mut evidence = known();
    evidence.motion = motion;
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
    };
    change(&mut fit);
    let mut evidence = known();
    evidence.fit = Some(fit);
    evidence
}

fn assert_verdict(evidence: &Evidence, status: Status, code: u8, unknown: Option<Unknown>) {
    let verdict = Verdict::on(evidence);
    let found = (
        verdict.status,
        verdict.reason.code(),
        verdict.reason.unknown(),
    );
    assert_eq!(found, (status, code, unknown), "{verdict}");
}

#[test]
fn a_fully_identified_servo_is_converged() {
    assert_verdict(&known(), Status::Converged, 0, None);
    assert_verdict(&fitted(|_| {}), Status::Converged, 0, None);
}

#[test]
fn a_fit_that_does_not_separate_gain_from_friction_is_not_converged() {
    for side in [0, 1] {
        // The errors of the fit are as wide as the valley, and b may be known all the same.
        let evidence = fitted(|fit| fit.profile[side] = 8.0);
        assert_verdict(&evidence, Status::Partial, 25, None);
        let mut unsure = with(Unknown::B, |of| of.std_error = Some(0.2 * of.estimate));
        unsure.fit = evidence.fit;
        assert_verdict(&unsure, Status::NoInformation, 25, None);
        let verdicts = [&evidence, &unsure].map(|evidence| Verdict::on(evidence).hides_all());
        assert_eq!(verdicts, [false, true]);
    }
    let late = fitted(|fit| fit.delay_at_bound = true);
    assert_verdict(&late, Status::NoInformation, 28, None);
    let stopped = fitted(|fit| fit.was_stopped = true);
    assert_verdict(&stopped, Status::Moving, 31, None);
    let one_way = fitted(|fit| fit.reverses = false);
    assert_verdict(&one_way, Status::Partial, 26, None);
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
    assert_verdict(&unsure(Unknown::Delay), Status::Converged, 0, None);
    let coulomb = unsure(Unknown::Coulomb);
    assert_verdict(&coulomb, Status::Partial, 23, Some(Unknown::Coulomb));
}

#[test]
fn every_rejection_reason_has_its_status_and_code() {
    let b = Some(Unknown::B);
    let none = Status::NoInformation;
    let mut aborted = known();
    aborted.aborted = true;
    assert_verdict(&aborted, Status::Aborted, 10, None);
    let short = Motion {
        samples: 30,
        ..MOTION
    };
    assert_verdict(&moved(short), none, 21, None);
    for counts_travelled in [0.0, 15.0, f64::NAN] {
        let motion = Motion {
            counts_travelled,
            ..MOTION
        };
        assert_verdict(&moved(motion), none, 22, None);
    }
    assert_verdict(&with(Unknown::B, |b| b.estimate = f64::NAN), none, 20, b);
    assert_verdict(&with(Unknown::B, |b| b.at_bound = true), none, 24, b);
    let roughly = with(Unknown::B, |b| b.std_error = Some(11.0));
    assert_verdict(&roughly, Status::Partial, 23, b);
    for std_error in [40.0, f64::INFINITY, f64::NAN] {
        let unexcited = with(Unknown::B, |b| b.std_error = Some(std_error));
        assert_verdict(&unexcited, none, 23, b);
    }
    for movement in [20.0, f64::INFINITY, f64::NAN] {
        let moving = with(Unknown::B, |b| b.movement = movement);
        assert_verdict(&moving, Status::Moving, 30, b);
    }
    let named = lacking(Some(Cause::Delay), Unknown::B, -15.0);
    assert_verdict(&named, Status::Unexplained, 40, b);
    let nameless = lacking(None, Unknown::Coulomb, 5.0);
    assert_verdict(&nameless, Status::Unexplained, 41, Some(Unknown::Coulomb));
    let elsewhere = with(Unknown::B, |b| b.refit_difference = Some(-10.0));
    assert_verdict(&elsewhere, Status::Unexplained, 42, b);
}

#[test]
fn a_record_that_no_servo_explains_is_code_27() {
    let mut foreign = known();
    foreign.not_a_servo = true;
    assert_verdict(&foreign, Status::NoInformation, 27, None);
}

#[test]
fn a_required_term_that_did_not_enter_is_code_29() {
    let mut without = known();
    without.missing_term = Some(Term::Gravity);
    assert_verdict(&without, Status::NoInformation, 29, None);
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
    assert_verdict(&predicted(0.3, 20.0), Status::Unexplained, 43, None);
    assert_verdict(&predicted(0.02, 20.0), Status::Converged, 0, None);
    assert_verdict(&predicted(0.3, 1.0), Status::Converged, 0, None);
}

#[test]
fn an_unmodelled_effect_is_accepted_if_it_biases_nothing() {
    let harmless = lacking(Some(Cause::Eccentricity), Unknown::B, 0.5);
    assert_verdict(&harmless, Status::Converged, 0, None);
}

#[test]
fn friction_at_the_bound_of_zero_is_a_result() {
    let none = with(Unknown::Coulomb, |coulomb| {
        coulomb.estimate = 0.0;
        coulomb.at_bound = true;
    });
    assert_verdict(&none, Status::Converged, 0, None);
}

/// A lack is found where the data would have the estimates, and not where these are on their way.
#[test]
fn a_lack_precedes_movement() {
    let mut moving = with(Unknown::B, |b| {
        b.movement = 12.0;
        b.refit_difference = Some(80.0);
    });
    assert_verdict(&moving, Status::Moving, 30, Some(Unknown::B));
    moving.lack = Some(MissingEffect {
        cause: Some(Cause::GainDrift),
        share: 0.7,
    });
    assert_verdict(&moving, Status::Unexplained, 40, Some(Unknown::B));
}
