//! The servo that an identification found, with all of its effects.

use identifier_core::parameters::ServoParameters;
use log_fit::fit::{Effect, Values};
use log_fit::{Logged, Recording, free_run};

use crate::experiment::TermEstimate;
use crate::scaled_recording::Scale;
use crate::scenario::Options;

/// A servo with everything that was found of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundServo {
    /// SI.
    values: Values,
}

impl FoundServo {
    /// Numbers that are one.
    pub const NUMBERS: usize = Effect::COUNT + Effect::FORCES.len() + 2;

    /// From a fit, in the units of its recording.
    pub(crate) fn of_fit(values: &Values, scale: &Scale) -> Self {
        Self {
            values: values.scaled(|effect| scale.of(effect)),
        }
    }

    /// From an online estimator: its estimates, its terms and what the scenario declares.
    #[must_use]
    pub fn of_estimates(
        scenario: &Options,
        estimates: &ServoParameters,
        terms: &[TermEstimate],
    ) -> Self {
        Self {
            values: Scale::SI.model(scenario, estimates, terms),
        }
    }

    /// As numbers, to keep it.
    #[must_use]
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let of = &self.values;
        let mut numbers = (Effect::ALL.iter().map(|effect| of.get(*effect)))
            .chain(of.orders)
            .chain([of.gain_order, of.inertia_order]);
        std::array::from_fn(|_| numbers.next().unwrap_or_default())
    }

    /// Of its [`numbers`](Self::numbers).
    #[must_use]
    pub fn of_numbers(numbers: &[f64; Self::NUMBERS]) -> Self {
        let mut values = Values::NONE;
        for (effect, &number) in Effect::ALL.into_iter().zip(numbers) {
            values.set(effect, number);
        }
        let [.., gain_order, inertia_order] = *numbers;
        (values.gain_order, values.inertia_order) = (gain_order, inertia_order);
        values
            .orders
            .copy_from_slice(&numbers[Effect::COUNT..Self::NUMBERS - 2]);
        Self { values }
    }

    /// The measured position minus that of this servo for every sample, rad. The commands alone drive it. See [`free_run`].
    pub(crate) fn free_run(&self, scenario: &Options, samples: &[Logged]) -> Option<Vec<f64>> {
        let units = scenario.units();
        let recording = Recording::of_every_sample(samples, scenario.axis());
        let scale = Scale {
            unit: scenario.motion_unit(),
            time: units.sample_time(),
            position: units.position_unit(),
        };
        let values = self.values.scaled(|effect| 1.0 / scale.of(effect));
        let errors = free_run(&recording, &values)?;
        let in_rad = errors.into_iter().map(|error| scale.position * error);
        Some(in_rad.collect())
    }

    /// Everything that was found, SI.
    pub(crate) fn values(&self) -> &Values {
        &self.values
    }
}
