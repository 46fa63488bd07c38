//! The verdicts on the sampled loop are those of a dense search.

use std::cell::Cell;

use crate::dense_search::DenseSearch;
use identifier_core::control::Gains;
use identifier_core::interval::Interval;
use identifier_core::measurement::{
    AveragedDifference, BackwardDifference, LowPass, Transfer, VelocityEstimate,
};
use identifier_core::stability::SampledLoop;
use identifier_core::stability::{Certificate, ParameterRange};
use identifier_core::units::Units;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

/// A loop and the box that it is for.
#[derive(Debug, Clone, Copy)]
struct Case {
    search: DenseSearch,
    parameter_range: ParameterRange,
}

/// Distance from its edge within which a verdict may differ, relative in b.
const MARGIN: f64 = 1e-11;

fn between(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// Velocity filter: a low-pass of every cut-off, or a difference.
#[derive(Debug, Clone, Copy)]
enum Filter {
    /// Cut-off times sample time, and whether in single precision.
    LowPass(f64, bool),
    Backward,
    Averaged,
}

fn filter() -> impl Strategy<Value = Filter> {
    prop_oneof![
        6 => (between(0.01, 3.1), any::<bool>()).prop_map(|(at, single)| Filter::LowPass(at, single)),
        1 => Just(Filter::Backward),
        1 => Just(Filter::Averaged),
    ]
}

fn transfer(filter: Filter, units: &Units) -> Transfer {
    match filter {
        Filter::LowPass(at, single) => {
            let cutoff = at / units.sample_time();
            if single {
                LowPass::<f32>::new(units, cutoff)
                    .expect("below π/T")
                    .transfer()
            } else {
                LowPass::<f64>::new(units, cutoff)
                    .expect("below π/T")
                    .transfer()
            }
        }
        Filter::Backward => VelocityEstimate::<f64>::transfer(&BackwardDifference),
        Filter::Averaged => AveragedDifference::<f64>::new().transfer(),
    }
}

/// Loops of 250 Hz to 20 kHz from sluggish to unstable, damped well and hardly, with and without
/// integral action, of encoders from coarse to fine; boxes from a point to a range of 10⁴ in b.
fn case() -> impl Strategy<Value = Case> {
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
    (rates, gains, a, b, filter()).prop_map(
        |((rate, counts), (crossing, kp, ki), (a_min, a_more), (b_min, wider), filter)| {
            let time = 1.0 / rate;
            let units = Units::new(time, std::f64::consts::TAU / counts).expect("in range");
            let kd = crossing / (b_min * time);
            let kp = kd * kp * crossing / time;
            let gains = Gains::new(
                kp.min(1e9),
                kd.min(1e9),
                (kp * ki * crossing / time).min(1e9),
            );
            let a = Interval::new("a", a_min / time, (a_min + a_more) / time);
            let b = Interval::new("b", b_min, b_min * wider);
            let parameter_range = ParameterRange::new(a.expect("ordered"), b.expect("ordered"));
            Case {
                search: DenseSearch {
                    units,
                    gains: gains.expect("in range"),
                    velocity: transfer(filter, &units),
                    gain: 1.0,
                },
                parameter_range: parameter_range.expect("positive"),
            }
        },
    )
}

impl Case {
    /// The arguments of every stability function.
    fn parts(&self) -> (&Units, &Gains, &Transfer) {
        let DenseSearch {
            units,
            gains,
            velocity,
            ..
        } = &self.search;
        (units, gains, velocity)
    }

    /// True if a verdict is that of the dense search, here or on one side of [`MARGIN`].
    fn agrees<T>(
        &self,
        dense: impl Fn(&DenseSearch) -> T,
        is_verdict: impl Fn(&T) -> bool,
    ) -> bool {
        [1.0, 1.0 - MARGIN, 1.0 + MARGIN].into_iter().any(|gain| {
            let moved = DenseSearch {
                gain,
                ..self.search
            };
            is_verdict(&dense(&moved))
        })
    }
}

/// Runs a property over random cases, always the same.
fn for_all(cases: u32, property: impl Fn(Case) -> Result<(), TestCaseError>) {
    let config = Config {
        cases,
        failure_persistence: None,
        ..Config::default()
    };
    let rng = proptest::test_runner::TestRng::deterministic_rng(
        proptest::test_runner::RngAlgorithm::ChaCha,
    );
    TestRunner::new_with_rng(config, rng)
        .run(&case(), property)
        .expect("the verdicts agree");
}

fn count(cell: &Cell<u32>, is: bool) {
    cell.set(cell.get() + u32::from(is));
}

fn is_near(x: f64, y: f64) -> bool {
    (x - y).abs() <= 1e-12 * y.abs()
}

#[test]
fn a_range_is_refused_where_the_dense_search_refuses_it_and_names_the_same_servo() {
    let [refused, inside, certified] = [const { Cell::new(0) }; 3];
    for_all(5000, |case| {
        let (units, gains, velocity) = case.parts();
        let own = SampledLoop::new(units, gains, velocity)
            .check(&case.parameter_range)
            .err();
        let same = case.agrees(
            |search| search.check(&case.parameter_range),
            |dense| match (own, dense) {
                (None, None) => true,
                (Some(own), Some((a, b))) => is_near(own.a, *a) && is_near(own.b, *b),
                _ => false,
            },
        );
        prop_assert!(
            same,
            "{own:?}, dense: {:?}",
            case.search.check(&case.parameter_range)
        );
        count(&refused, own.is_some());
        count(
            &inside,
            own.is_some_and(|own| own.b > case.parameter_range.b().min()),
        );
        let certificate = Certificate::with_automatic_mu(gains, &case.parameter_range);
        count(&certified, own.is_none() && certificate.is_ok());
        Ok(())
    });
    assert!((1250..3750).contains(&refused.get()), "{refused:?}");
    assert!(inside.get() > 500, "{inside:?}");
    assert!(certified.get() > 1250, "{certified:?}");
}

#[test]
fn the_gain_margin_is_that_of_the_dense_search() {
    let [some, ample] = [const { Cell::new(0) }; 2];
    for_all(5000, |case| {
        let (units, gains, velocity) = case.parts();
        let own = SampledLoop::new(units, gains, velocity).gain_margin(&case.parameter_range);
        let same = case.agrees(
            |search| search.gain_margin(&case.parameter_range),
            |dense| own.to_bits() == dense.to_bits(),
        );
        prop_assert!(
            same,
            "{own}, dense: {}",
            case.search.gain_margin(&case.parameter_range)
        );
        count(
            &some,
            own > 1.0 && own < 2.0 * SampledLoop::AMPLE_GAIN_MARGIN,
        );
        count(&ample, own > 2.0 * SampledLoop::AMPLE_GAIN_MARGIN);
        Ok(())
    });
    assert!(some.get() > 500 && ample.get() > 1250, "{some:?} {ample:?}");
}

#[test]
fn the_largest_estimate_is_that_of_the_dense_search() {
    let [bounded, above] = [const { Cell::new(0) }; 2];
    for_all(5000, |case| {
        let (units, gains, velocity) = case.parts();
        let nominal = case.parameter_range.b().max();
        let own = SampledLoop::new(units, gains, velocity).most_gain(nominal);
        let same = case.agrees(
            |search| search.most_gain(nominal),
            |dense| own.to_bits() == dense.to_bits(),
        );
        prop_assert!(same, "{own}, dense: {}", case.search.most_gain(nominal));
        count(&above, own > nominal);

        let from = nominal;
        let to = 30.0 * own;
        let refusal = SampledLoop::new(units, gains, velocity)
            .check_estimates(from, to)
            .err();
        let same = case.agrees(
            |search| search.check_estimates(from, to),
            |dense| match (refusal, dense) {
                (None, None) => true,
                (Some(refusal), Some(stable)) => is_near(refusal.stable, *stable),
                _ => false,
            },
        );
        prop_assert!(
            same,
            "{refusal:?}, dense: {:?}",
            case.search.check_estimates(from, to)
        );
        if let Some(refusal) = refusal.filter(|refusal| refusal.stable > 0.0) {
            let bounded_by_it =
                SampledLoop::new(units, gains, velocity).check_estimates(from, refusal.stable);
            prop_assert!(
                bounded_by_it.is_ok(),
                "the bound that is named would not do"
            );
            count(&bounded, true);
        }
        Ok(())
    });
    assert!(
        bounded.get() > 1250 && above.get() > 1250,
        "{bounded:?} {above:?}"
    );
}

/// Where nothing is refused, nothing between the points of the grid is unstable either.
#[test]
fn a_range_that_is_accepted_is_stable_between_the_points_too() {
    let accepted = Cell::new(0);
    for_all(2500, |case| {
        let (units, gains, velocity) = case.parts();
        let parameter_range = case.parameter_range;
        if SampledLoop::new(units, gains, velocity)
            .check(&parameter_range)
            .is_err()
        {
            return Ok(());
        }
        count(&accepted, true);
        for i in 0..=60 {
            let a = parameter_range.a();
            let a = a.min() + (a.max() - a.min()) * f64::from(i % 7) / 6.0;
            let b = parameter_range.b();
            let b = b.min() * (b.max() / b.min()).powf(f64::from(i) / 60.0);
            prop_assert!(case.search.is_stable(a, b), "a = {a}, b = {b}");
        }
        Ok(())
    });
    assert!(accepted.get() > 1000, "{accepted:?}");
}

/// The value at which a predicate changes between two of them, with the first's verdict just below.
fn edge(is: impl Fn(f64) -> bool, mut low: f64, mut high: f64) -> f64 {
    let first = is(low);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if is(middle) == first {
            &mut low
        } else {
            &mut high
        }) = middle;
    }
    low
}

#[test]
fn a_servo_is_unstable_from_the_same_gain_on() {
    /// Ratio of successive values between which an edge is looked for.
    const STEP: f64 = 1.3;
    let edges = Cell::new(0);
    for_all(1250, |case| {
        let (units, gains, velocity) = case.parts();
        let (a, b) = (case.parameter_range.a(), case.parameter_range.b());
        for a in [a.min(), a.max()] {
            let own = |b| SampledLoop::new(units, gains, velocity).is_stable(a, b);
            let dense = |b| case.search.is_stable(a, b);
            let mut low = 1e-6 * b.min();
            while low < 1e6 * b.min() {
                let high = STEP * low;
                prop_assert_eq!(own(low), dense(low), "a = {}, b = {}", a, low);
                if dense(low) != dense(high) {
                    let (own, dense) = (edge(own, low, high), edge(dense, low, high));
                    prop_assert!((own / dense - 1.0).abs() < MARGIN, "{own} and {dense}");
                    count(&edges, true);
                }
                low = high;
            }
        }
        Ok(())
    });
    assert!(edges.get() > 1250, "{edges:?}");
}
