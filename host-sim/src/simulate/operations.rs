//! The arithmetic operations of an estimator per sample, counted by a number type.

use std::cell::Cell;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use identifier_core::error::StepError;
use identifier_core::number::{Compensated, Number};
use identifier_core::parameters::ServoParameters;

use super::build::{Method, method};
use crate::loops::{DynIdentifier, Innovation, RelayMethod};
use crate::scenario::{Fault, Scenario};

/// Samples of the mean, enough for rare ones to count as in a long run, and samples of the start before them.
const SAMPLES: u64 = 4000;
const STARTING: u64 = 1000;

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The additions, multiplications and comparisons of an estimator in a sample, the mean over a run of the scenario.
/// They are counted for single precision with its compensated sums. None for a computation after the experiment. The
/// controller and the simulated servo are not counted.
///
/// # Errors
/// The key that something cannot be built from.
pub fn operations(scenario: &Scenario) -> Result<Option<f64>, Fault> {
    if scenario.identifier.law.takes_whole_record() {
        return Ok(None);
    }
    let mut scenario = scenario.clone();
    scenario.duration = (STARTING + SAMPLES) as f64 * scenario.sample_time();
    let settings = scenario
        .settings()
        .map_err(|error| scenario.fault(&error))?;
    let meter = Arc::new(Meter::default());
    let metered = match method::<Counted>(&scenario, &settings)? {
        Method::Identifier(law) => Method::Identifier(Box::new(Metered::new(law, &meter))),
        Method::Relay(method) => Method::Relay(Box::new(Metered::new(method, &meter))),
    };
    let simulation = metered.simulation::<Counted>(&scenario, &settings)?;
    simulation.run(&mut |_| ());
    Ok(Some(meter.mean()))
}

/// Adds up the operations of the samples that count.
#[derive(Debug, Default)]
struct Meter {
    samples: AtomicU64,
    operations: AtomicU64,
}

impl Meter {
    fn measure<T>(&self, work: impl FnOnce() -> T) -> T {
        take();
        let result = work();
        if self.samples.fetch_add(1, Relaxed) >= STARTING {
            self.operations.fetch_add(take(), Relaxed);
        }
        result
    }

    fn mean(&self) -> f64 {
        self.operations.load(Relaxed) as f64 / SAMPLES as f64
    }
}

/// The operations since the last call.
fn take() -> u64 {
    OPERATIONS.replace(0)
}

#[inline]
fn count<T>(result: T) -> T {
    OPERATIONS.set(OPERATIONS.get() + 1);
    result
}

/// An estimator whose samples are counted.
struct Metered<T: ?Sized> {
    meter: Arc<Meter>,
    law: Box<T>,
}

impl<T: ?Sized> Metered<T> {
    fn new(law: Box<T>, meter: &Arc<Meter>) -> Self {
        Self {
            meter: Arc::clone(meter),
            law,
        }
    }
}

impl DynIdentifier for Metered<dyn DynIdentifier + Send> {
    fn update(&mut self, increment: f64, command: f64) -> Result<Innovation, StepError> {
        let law = &mut self.law;
        self.meter.measure(|| law.update(increment, command))
    }

    fn estimates(&self) -> ServoParameters {
        self.law.estimates()
    }
}

impl RelayMethod for Metered<dyn RelayMethod> {
    fn process(&mut self, increment: f64, error: f64) -> f64 {
        let law = &mut self.law;
        self.meter.measure(|| law.process(increment, error))
    }

    fn estimates(&self) -> Option<ServoParameters> {
        self.law.estimates()
    }
}

/// A double that counts its operations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Counted(f64);

impl PartialOrd for Counted {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        count(self.0.partial_cmp(&other.0))
    }
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        count(Self(self.0 + other.0))
    }
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        count(Self(self.0 - other.0))
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        count(Self(self.0 * other.0))
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        // A sign is free: it goes into the addition.
        Self(-self.0)
    }
}

impl AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Number for Counted {
    type Sum = Compensated<Self>;

    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);
    const LARGEST_EXACT_COUNT: i64 = <f64 as Number>::LARGEST_EXACT_COUNT;
    const REACH: Self = Self(<f64 as Number>::REACH);
    const EPSILON: f64 = <f64 as Number>::EPSILON;
    const SERIES_TERMS: usize = <f32 as Number>::SERIES_TERMS;

    fn from_f64(value: f64) -> Self {
        Self(value)
    }

    fn to_f64(self) -> f64 {
        self.0
    }

    fn from_count(count: i32) -> Self {
        Self(f64::from(count))
    }

    fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    fn magnitude(self) -> Self {
        OPERATIONS.set(OPERATIONS.get() + 1);
        Self(self.0.abs())
    }

    /// Three Newton steps of three operations, as in single precision.
    fn reciprocal(self) -> Self {
        OPERATIONS.set(OPERATIONS.get() + 9);
        Self(1.0 / self.0)
    }

    fn reciprocal_root(self) -> Self {
        OPERATIONS.set(OPERATIONS.get() + 2);
        Self(1.0 / self.0.sqrt())
    }

    fn whole(self) -> i32 {
        OPERATIONS.set(OPERATIONS.get() + 1);
        self.0 as i32
    }

    /// About what the polynomials of single precision take.
    fn sine_cosine(self) -> (Self, Self) {
        OPERATIONS.set(OPERATIONS.get() + 20);
        let (sine, cosine) = self.0.sin_cos();
        (Self(sine), Self(cosine))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_are_counted_and_taken() {
        take();
        let x = Counted(2.0);
        let y = x * x + Counted::ONE;
        assert_eq!(y, Counted(5.0));
        assert!(y > x);
        assert_eq!(take(), 3);
        assert_eq!(take(), 0);
    }
}
