use core::marker::PhantomData;

use super::fitting::{Listening, MAX_BANDWIDTH_PER_SAMPLE};
use super::{FromSettings, Settings, SettingsError};
use crate::fit::{Blocking, Fitter, place_of};
use crate::model::{FrictionStep, IdentifiableSet, KnownInputs};
use crate::number::Number;
use crate::parameters::{Parameter, Unknown};
use crate::recursive::{
    GaussNewton, GaussNewtonConfig, GaussNewtonFitter, GaussNewtonIdentifier, GaussNewtonRecursion,
    LoadStepTest,
};

impl<N, S, const P: usize, const W: usize> FromSettings for GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// # Errors
    /// See [`SettingsError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let config = Listening::new(settings)?;
        let units = config.units;
        let sample_time = units.sample_time();
        let fitter = config.fitter(&S::UNKNOWNS, W, Self::START_TIME)?;
        let terms = config.terms(S::TERMS, S::Inputs::<N>::MAX_DELAY)?;
        let samples = |time: f64| libm::ceil(time / sample_time).max(2.0) as u16;
        let block_time = f64::from(GaussNewton::<N, P>::BLOCK) * sample_time;
        let blocks = |time: f64| libm::ceil(time / block_time);
        // Bounds, initial value, and whether it is free: looked up without a panic, also where the loop is not
        // unrolled.
        let fitted = |i: usize| {
            let initial = fitter.initial.get(i)?.unwrap_or(0.0);
            let is_free = *fitter.free.get(i)?;
            let bounds = match is_free {
                true => [*fitter.low.get(i)?, *fitter.high.get(i)?],
                false => [initial; 2],
            };
            Some((bounds, initial, is_free))
        };
        let unknowns = S::UNKNOWNS.map(|unknown| {
            place_of(unknown).and_then(fitted).unwrap_or_else(|| {
                (
                    terms.bounds(unknown, &units),
                    terms.initial(unknown) * unknown.scale(&units),
                    unknown.term().is_some_and(|term| terms.demanded.has(term)),
                )
            })
        });
        let bounds = unknowns.map(|(bounds, ..)| bounds);
        let initial = unknowns.map(|(_, initial, _)| initial);
        let law = GaussNewton::new(&GaussNewtonConfig {
            sample_time,
            noise: fitter.noise,
            dead_zone: Self::DEAD_ZONE,
            memory: config.memory(),
            low: bounds.map(|[low, _]| low),
            high: bounds.map(|[_, high]| high),
        })?;
        let per_sample = |omega: f64, most: f64| N::from_f64((omega * sample_time).min(most));
        Ok(Self {
            law,
            blocking: Blocking::new(fitter.block),
            step: FrictionStep::new(),
            load_step: LoadStepTest::new(sample_time, fitter.noise),
            angle: terms.angle(&units),
            per_low_speed_velocity: N::from_f64(terms.per_low_speed_velocity(&units)),
            demanded: terms.demanded,
            max_delay_deviation: N::from_f64((Self::MAX_DELAY_DEVIATION / sample_time).max(4.0)),
            min_motion_blocks: blocks(Self::MIN_MOTION_TIME) as u16,
            units,
            longest: config.longest_increment()?,
            bandwidth: fitter.bandwidth.map(N::from_f64),
            min_omega: per_sample(Self::MIN_BANDWIDTH, Self::MAX_OMEGA),
            max_omega: N::from_f64(Self::MAX_OMEGA),
            joining_omega: per_sample(Self::JOINING_BANDWIDTH, MAX_BANDWIDTH_PER_SAMPLE),
            narrowing: N::from_f64(Self::NARROWING_PER_SAMPLE),
            block_narrowing: N::from_f64(
                f64::from(GaussNewton::<N, P>::BLOCK) * Self::NARROWING_PER_SAMPLE,
            ),
            joining_samples: samples(Self::JOINING_TIME),
            search_samples: samples(Self::SEARCH_TIME),
            standstill_samples: samples(Self::STANDSTILL_TIME),
            search_standstill_samples: samples(0.7 * Self::SEARCH_TIME),
            max_held_samples: samples(Self::MAX_HELD_TIME),
            alarm_blocks: blocks(Self::ALARM_TIME) as u16,
            waiting_samples: samples(Self::WAITING_TIME),
            reversal_blocks: blocks(Self::REVERSAL_TIME) as u8,
            widening: N::from_f64(block_time / Self::WIDENING_TIME),
            unexplained_variance: N::from_f64(4.0 * fitter.noise),
            explained_variance: N::from_f64(1.5 * fitter.noise),
            max_square: N::from_f64(12.0 * fitter.noise),
            max_unexplained_omega: N::from_f64(Self::MAX_UNEXPLAINED_OMEGA),
            mean_square_weight: N::from_f64(block_time.min(0.1)),
            has_friction: S::HAS_COULOMB && fitter.free[Parameter::Coulomb as usize],
            friction: S::UNKNOWNS
                .iter()
                .position(|&own| own == Unknown::Coulomb)
                .unwrap_or(0),
            has_load: S::UNKNOWNS.last() == Some(&Unknown::Load)
                && fitter.free[Parameter::Load as usize],
            free: unknowns.map(|(.., is_free)| is_free),
            initial,
            set: PhantomData,
        })
    }
}

impl<N, S, const P: usize, const W: usize> FromSettings for GaussNewtonFitter<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// # Errors
    /// See [`SettingsError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        const { assert!(W >= 32, "fewer blocks do not determine a servo") };
        let time = GaussNewtonRecursion::<N, S, P, W>::START_TIME;
        let listening = Listening::new(settings)?;
        let config = listening.fitter(&S::UNKNOWNS, W, time)?;
        Ok(Self {
            fitter: Fitter::new(&config),
            patience: listening.patience(config.block, W),
            free: Parameter::ALL.map(|parameter| {
                S::UNKNOWNS.contains(&parameter.into()) && config.free[parameter as usize]
            }),
            set: PhantomData,
        })
    }
}

impl<N, S, const P: usize, const W: usize> FromSettings for GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// # Errors
    /// See [`SettingsError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        Ok(Self {
            recorder: settings.build()?,
            fitter: settings.build()?,
        })
    }
}
