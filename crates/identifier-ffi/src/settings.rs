//! Settings: a structure whose fields are zero where nothing is stated.

use identifier_core::Settings as CoreSettings;
use identifier_core::control::FeedForwardSettings as FeedForward;
use identifier_core::excitation::Prbs;
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{PerParameter as Each, Unknowns};
use identifier_core::settings::{
    ControllerSettings, ParameterRangeSettings as ServoRange, RangeSettings as SignalRanges,
    SettingsError,
};

use crate::object::{answered, check};
use crate::status::{self, Error};

/// Lowest and highest: `servo_id_range` in the header.
pub type Range = [f64; 2];

/// Gains: `servo_id_gains` in the header.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Gains {
    /// Command units per rad.
    pub kp: f64,
    /// Command units per rad/s.
    pub kd: f64,
    /// Command units per rad s.
    pub ki: f64,
}

/// `servo_id_settings` in the header, which documents the fields.
#[allow(missing_docs, reason = "the header has them")]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Settings {
    pub sample_time: f64,
    pub counts_per_revolution: f64,
    pub resolution: f64,
    pub cutoff: f64,
    pub kp: f64,
    pub kd: f64,
    pub ki: f64,
    pub limit: Range,
    pub reference_filter: f64,
    pub notch: f64,
    pub feed_forward: FeedForward,
    pub initial: Each<f64>,
    pub bounds: Each<Range>,
    pub uncertainty: Each<f64>,
    pub gamma: Each<f64>,
    pub correction: Gains,
    pub servo_range: ServoRange,
    pub mu: f64,
    pub bandwidth: f64,
    pub start_time: f64,
    pub memory: f64,
    pub noise: f64,
    pub max_speed: f64,
    pub ranges: SignalRanges,
    pub command: f64,
    pub command_delay: f64,
    pub response_time: f64,
    pub loop_bandwidth: f64,
    pub max_sensitivity: f64,
    pub max_noise: f64,
    pub step: f64,
    pub resonance: f64,
    pub travel: Range,
    pub speed: f64,
    pub duration: f64,
    pub max_gain: f64,
    pub trial_step: f64,
    pub known: Each<i32>,
    pub with_feed_forward: i32,
    pub unused: i32,
}

/// A value that was stated.
pub(crate) fn stated(value: f64) -> Option<f64> {
    (value != 0.0).then_some(value)
}

/// The range that was stated.
fn range(of: Range) -> Option<[f64; 2]> {
    of.iter().any(|&end| end != 0.0).then_some(of)
}

/// A range that must be stated.
pub(crate) fn needed_range(name: &str, of: Range) -> Result<[f64; 2], Error> {
    range(of).ok_or(Error::not_given(name))
}

/// A value that must be stated.
pub(crate) fn needed(name: &str, value: f64) -> Result<f64, Error> {
    stated(value).ok_or(Error::not_given(name))
}

impl Settings {
    /// A count, rad.
    pub(crate) fn count(&self) -> f64 {
        match stated(self.resolution) {
            Some(resolution) => resolution,
            None => core::f64::consts::TAU / self.counts_per_revolution,
        }
    }

    /// The settings of the core.
    pub(crate) fn settings(&self) -> CoreSettings {
        let mut settings = CoreSettings::new(self.sample_time, 1.0);
        settings.resolution = self.count();
        settings.cutoff = stated(self.cutoff).unwrap_or(settings.cutoff);
        if [self.kp, self.kd, self.ki].iter().any(|&gain| gain != 0.0) {
            let pid = ControllerSettings::pid(self.kp, self.kd, self.ki);
            settings.controller = Some(ControllerSettings {
                limit: range(self.limit).unwrap_or(pid.limit),
                reference_filter: self.reference_filter,
                notch: self.notch,
                feed_forward: stated(self.feed_forward.bandwidth).map(|_| self.feed_forward),
                ..pid
            });
        }
        let own = &mut settings.identifier;
        own.known = Each::from_fn(|one| self.known.get(one) != 0);
        let known = own.known;
        // It may be known to be zero.
        own.initial = Each::from_fn(|one| {
            let zero = known.get(one).then_some(0.0);
            stated(self.initial.get(one)).or(zero)
        });
        own.bounds = Each::from_fn(|one| range(self.bounds.get(one)));
        own.uncertainty = Each::from_fn(|one| stated(self.uncertainty.get(one)));
        own.gamma = (self.gamma != Each::default()).then_some(self.gamma);
        let correction = &self.correction;
        if *correction != Gains::default() {
            own.correction = Some([correction.kp, correction.kd, correction.ki]);
        }
        let within = self.servo_range;
        own.parameter_range = (within != ServoRange::default()).then_some(within);
        own.mu = stated(self.mu);
        own.bandwidth = stated(self.bandwidth);
        own.start_time = stated(self.start_time);
        own.memory = stated(self.memory);
        own.noise = stated(self.noise);
        own.max_speed = stated(self.max_speed);
        own.ranges = (self.ranges != SignalRanges::default()).then_some(self.ranges);
        settings
    }

    /// Sample time and resolution are stated; of the parameter range and the ranges of signals all or nothing.
    fn complete(&self) -> Result<(), Error> {
        let ranges = &self.ranges;
        let [a, b] = [self.servo_range.a, self.servo_range.b].map(range);
        let has_ranges = *ranges != SignalRanges::default();
        let has_box = a.is_some() || b.is_some();
        for (name, is_needed, is_stated) in [
            ("sample_time", true, self.sample_time != 0.0),
            (
                "counts_per_revolution",
                true,
                self.counts_per_revolution != 0.0 || self.resolution != 0.0,
            ),
            ("servo_range.a", has_box, a.is_some()),
            ("servo_range.b", has_box, b.is_some()),
            ("ranges.error", has_ranges, ranges.error != 0.0),
            ("ranges.velocity", has_ranges, ranges.velocity != 0.0),
            ("ranges.command", has_ranges, ranges.command != 0.0),
        ] {
            if is_needed && !is_stated {
                return Err(Error::not_given(name));
            }
        }
        Ok(())
    }

    /// Builds a part of the core.
    pub(crate) fn build<T: identifier_core::settings::FromSettings>(&self) -> Result<T, Error> {
        let built = self.settings().build();
        built.map_err(|error| Error::settings(&error))
    }
}

/// Settings that are complete.
///
/// # Safety
/// As the header says.
pub(crate) unsafe fn given<'a>(settings: *const Settings) -> Result<&'a Settings, Error> {
    check(settings)?;
    // SAFETY: guaranteed by the caller.
    let settings = unsafe { &*settings };
    settings.complete()?;
    Ok(settings)
}

/// # Safety
/// As the header says.
unsafe fn choose_gamma(
    settings: *mut Settings,
    amplitude: f64,
    hold: f64,
    samples: u32,
    with_coulomb: bool,
) -> Result<i32, Error> {
    // SAFETY: guaranteed by the caller.
    let own = unsafe { given(settings) }?;
    let chosen = if with_coulomb {
        gamma::<Unknowns<3>, 3>(own, amplitude, hold, samples)
    } else {
        gamma::<Unknowns<2>, 2>(own, amplitude, hold, samples)
    };
    let chosen = Each {
        load: 0.0,
        ..chosen.map_err(|refused| Error::settings(&refused))?
    };
    // SAFETY: guaranteed by the caller; it was checked.
    unsafe { (&raw mut (*settings).gamma).write(chosen) };
    Ok(status::OK)
}

/// Γ for a model of P parameters.
fn gamma<S, const P: usize>(
    given: &Settings,
    amplitude: f64,
    hold: f64,
    samples: u32,
) -> Result<Each<f64>, SettingsError>
where
    S: identifier_core::parameters::ParameterSet<P>,
{
    /// Bits of the sequence's shift register.
    const ORDER: u32 = 9;
    let settings = given.settings();
    let reference = Prbs::<f64>::new(&settings.units()?, amplitude, hold, ORDER)?;
    settings.automatic_gamma::<LowPass<f64>, S, P>(&reference, samples)
}

face! {
    /// Γ for a reference of an amplitude (rad) that changes after `hold` s at the soonest.
    fn servo_id_settings_choose_gamma(
        settings: *mut Settings,
        amplitude: f64,
        hold: f64,
        samples: u32,
        coulomb: i32,
        error: *mut Error,
    ) {
        // SAFETY: the header's conditions.
        unsafe { answered(error, choose_gamma(settings, amplitude, hold, samples, coulomb != 0)) }
    }
}
