//! The verdicts on the sampled loop are those of a dense search.

use std::cell::Cell;

use crate::dense_search::DenseSearch;
use identifier_core::control::Gains;
use identifier_core::interval::Interval;
use identifier_core::measurement::{
    AveragedDifference, BackwardDifference, LowPass, Transfer, VelocityEstimate,
};
use identifier_core::stability::{Certificate, ParameterRange, SampledLoop};
use identifier_core::units::Units;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Distance from its edge within which a verdict may differ, relative in b.
const MARGIN: f64 = 1e-11;

fn between(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// A velocity filter: a low-pass with a cut-off over the sample rate in either precision, or a difference.
fn transfer(kind: u8, at: f64, units: &Units) -> Transfer {
    let cutoff = at / units.sample_time();
    let single = || LowPass::<f32>::new(units, cutoff).expect("below π/T");
    let double = || LowPass::<f64>::new(units, cutoff).expect("below π/T");
    match kind {
        0..=2 => single().transfer(),
        3..=5 => double().transfer(),
        6 => VelocityEstimate::<f64>::transfer(&BackwardDifference),
        _ => AveragedDifference::<f64>::new().transfer(),
    }
}

/// Loops of 250 Hz to 20 kHz from sluggish to unstable, damped well and hardly, with and without
/// integral action, of encoders from coarse to fine; boxes from a point to a range of 10⁴ in b.
fn case() -> impl Strategy<Value = DenseSearch> {
    let rates = (between(250.0, 20_000.0), between(50.0, 1e6));
    // Per sample: b k_d T of the smallest b; k_p over k_d and k_i over k_p, of the bandwidth and alone.
    let gains = (
        between(1e-4, 3.0),
        between(0.02, 3.0),
        prop_oneof![1 => Just(0.0), 4 => between(1e-4, 1.0)],
    );
    let a = (
        prop_oneof![Just(0.0), between(1e-5, 0.1)],
        prop_oneof![Just(0.0), between(1e-5, 1.0)],
    );
    let b = (
        between(0.1, 1e4),
        prop_oneof![1 => Just(1.0), 6 => between(1.0, 100.0), 1 => between(100.0, 1e4)],
    );
    (rates, gains, a, b, (0_u8..8, between(0.01, 3.1))).prop_map(
        |((rate, counts), (crossing, kp, ki), (a_min, a_more), (b_min, wider), (kind, at))| {
            let time = 1.0 / rate;
            let units = Units::new(time, std::f64::consts::TAU / counts).expect("in range");
            let kd = crossing / (b_min * time);
            let kp = kd * kp * crossing / time;
            let ki = kp * ki * crossing / time;
            let gains = Gains::new(kp.min(1e9), kd.min(1e9), ki.min(1e9));
            let a = Interval::new("a", a_min / time, (a_min + a_more) / time);
            let b = Interval::new("b", b_min, b_min * wider);
            let range = ParameterRange::new(a.expect("ordered"), b.expect("ordered"));
            DenseSearch {
                units,
                gains: gains.expect("in range"),
                velocity: transfer(kind, at, &units),
                gain: 1.0,
                range: range.expect("positive"),
            }
        },
    )
}

/// True if a verdict is that of the dense search, here or on one side of [`MARGIN`].
fn agrees<T>(
    search: &DenseSearch,
    dense: impl Fn(&DenseSearch) -> T,
    is_verdict: impl Fn(&T) -> bool,
) -> bool {
    [1.0, 1.0 - MARGIN, 1.0 + MARGIN].into_iter().any(|gain| {
        let moved = DenseSearch { gain, ..*search };
        is_verdict(&dense(&moved))
    })
}

/// Runs a property over random cases, always the same.
fn for_all(cases: u32, property: impl Fn(DenseSearch) -> Result<(), TestCaseError>) {
    let config = Config {
        cases,
        failure_persistence: None,
        ..Config::default()
    };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let verdicts = TestRunner::new_with_rng(config, rng).run(&case(), property);
    verdicts.expect("the verdicts agree");
}

fn count(cell: &Cell<u32>, is: bool) {
    cell.set(cell.get() + u32::from(is));
}

fn is_bits(x: f64, y: f64) -> bool {
    x.to_bits() == y.to_bits()
}

fn is_near(x: f64, y: f64) -> bool {
    (x - y).abs() <= 1e-12 * y.abs()
}

#[test]
fn every_verdict_is_that_of_the_dense_search() {
    // Ranges that are refused, inside of them, and certified; some gain margin, and an ample one; estimates that are bounded, and
    // above the range.
    let [refused, inside, certified, some, ample, bounded, above] = [const { Cell::new(0) }; 7];
    for_all(5000, |search| {
        let (sampled, range) = (search.sampled(), &search.range);

        let own = sampled.check(range).err();
        let is_same = |dense: &Option<(f64, f64)>| match (own, dense) {
            (None, None) => true,
            (Some(own), Some((a, b))) => is_near(own.a, *a) && is_near(own.b, *b),
            _ => false,
        };
        let same = agrees(&search, |search| search.check(), is_same);
        prop_assert!(same, "{own:?}, dense: {:?}", search.check());
        count(&refused, own.is_some());
        count(&inside, own.is_some_and(|own| own.b > range.b().min()));
        let certificate = Certificate::with_automatic_mu(&search.gains, range);
        count(&certified, own.is_none() && certificate.is_ok());

        let own = sampled.gain_margin(range);
        let same = agrees(
            &search,
            |search| search.gain_margin(),
            |dense| is_bits(own, *dense),
        );
        prop_assert!(same, "{own}, dense: {}", search.gain_margin());
        let much = 2.0 * SampledLoop::AMPLE_GAIN_MARGIN;
        count(&some, own > 1.0 && own < much);
        count(&ample, own > much);

        let nominal = range.b().max();
        let own = sampled.most_gain(nominal);
        let same = agrees(
            &search,
            |search| search.most_gain(nominal),
            |dense| is_bits(own, *dense),
        );
        prop_assert!(same, "{own}, dense: {}", search.most_gain(nominal));
        count(&above, own > nominal);

        let to = 30.0 * own;
        let refusal = sampled.check_estimates(nominal, to).err();
        let is_same = |dense: &Option<f64>| match (refusal, dense) {
            (None, None) => true,
            (Some(refusal), Some(stable)) => is_near(refusal.stable, *stable),
            _ => false,
        };
        let dense = |search: &DenseSearch| search.check_estimates(nominal, to);
        prop_assert!(
            agrees(&search, dense, is_same),
            "{refusal:?}, dense: {:?}",
            dense(&search)
        );
        if let Some(refusal) = refusal.filter(|refusal| refusal.stable > 0.0) {
            let mended = sampled.check_estimates(nominal, refusal.stable);
            prop_assert!(mended.is_ok(), "the bound that is named would not do");
            count(&bounded, true);
        }
        Ok(())
    });
    assert!((1250..3750).contains(&refused.get()), "{refused:?}");
    assert!(inside.get() > 500 && certified.get() > 1250);
    assert!(some.get() > 500 && ample.get() > 1250);
    assert!(bounded.get() > 1250 && above.get() > 1250);
}

/// Where nothing is refused, nothing between the points of the grid is unstable either.
#[test]
fn a_range_that_is_accepted_is_stable_between_the_points_too() {
    let accepted = Cell::new(0);
    for_all(2500, |search| {
        if search.sampled().check(&search.range).is_err() {
            return Ok(());
        }
        count(&accepted, true);
        for i in 0..=60 {
            let a = search.range.a();
            let a = a.min() + (a.max() - a.min()) * f64::from(i % 7) / 6.0;
            let b = search.range.b();
            let b = b.min() * (b.max() / b.min()).powf(f64::from(i) / 60.0);
            prop_assert!(search.is_stable(a, b), "a = {a}, b = {b}");
        }
        Ok(())
    });
    assert!(accepted.get() > 1000, "{accepted:?}");
}
