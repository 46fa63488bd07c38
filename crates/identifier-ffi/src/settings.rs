//! Settings: a structure whose fields are zero where nothing is stated.

use core::ffi::c_char;
use core::ptr;

use commissioning::{CommissionSettings, Limits};
use identifier_core::Settings as CoreSettings;
use identifier_core::control::FeedForwardSettings as FeedForward;
use identifier_core::parameters::PerParameter as Each;
use identifier_core::settings::{
    ControllerSettings, FromSettings, ParameterRangeSettings as ServoRange,
    RangeSettings as SignalRanges, SettingsError,
};
use identifier_core::tuning::{Goal, TuningSettings};

/// Lowest and highest: `servo_id_range` in the header.
pub type Range = [f64; 2];

/// kp, kd and ki: `servo_id_gains` in the header.
pub type Gains = [f64; 3];

/// Declares a structure, and the names of its fields.
macro_rules! named {
    (
        $(#[$meta:meta])*
        pub struct $type:ident {
            $(pub $field:ident: $of:ty $({ $($part:ident)* })?,)*
        }
    ) => {
        $(#[$meta])*
        pub struct $type {
            $(pub $field: $of,)*
        }

        /// The names of the fields for refusals, each with a zero behind it. A name of a group is that of all of its fields.
        pub const NAMES: &str = concat!($(
            stringify!($field), "\0",
            $($(stringify!($field), ".", stringify!($part), "\0",)*)?
        )*);
    };
}

named! {
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
        pub feed_forward: FeedForward { bandwidth acceleration velocity coulomb coulomb_speed },
        pub initial: Each<f64> { a b coulomb load },
        pub bounds: Each<Range> { a b coulomb load },
        pub uncertainty: Each<f64> { a b coulomb load },
        pub gamma: Each<f64> { a b coulomb load },
        pub correction: Gains { kp kd ki },
        pub servo_range: ServoRange { a b },
        pub mu: f64,
        pub bandwidth: f64,
        pub start_time: f64,
        pub memory: f64,
        pub noise: f64,
        pub max_speed: f64,
        pub ranges: SignalRanges { error velocity command },
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
}

/// The field of a parameter of the core; null for none.
pub(crate) fn field(name: &str) -> *const c_char {
    let name = match name {
        "controller" => "kp",
        "limit_low" | "limit_high" => "limit",
        name => name,
    };
    let mut names = NAMES.split_inclusive('\0');
    let found = names.find(|own| own.strip_suffix('\0') == Some(name));
    found.map_or(ptr::null(), |own| own.as_ptr().cast())
}

/// What was stated: something that is not zero.
fn stated<T: Default + PartialEq>(value: T) -> Option<T> {
    (value != T::default()).then_some(value)
}

/// What must be stated.
fn needed<T: Default + PartialEq>(setting: &'static str, value: T) -> Result<T, SettingsError> {
    stated(value).ok_or(SettingsError::NotGiven { setting })
}

impl Settings {
    /// A count, rad.
    pub(crate) fn count(&self) -> f64 {
        stated(self.resolution).unwrap_or(core::f64::consts::TAU / self.counts_per_revolution)
    }

    /// The settings of the core.
    pub(crate) fn settings(&self) -> CoreSettings {
        let mut settings = CoreSettings::new(self.sample_time, 1.0);
        settings.resolution = self.count();
        settings.cutoff = stated(self.cutoff).unwrap_or(settings.cutoff);
        settings.controller = stated([self.kp, self.kd, self.ki]).map(|[kp, kd, ki]| {
            let pid = ControllerSettings::pid(kp, kd, ki);
            ControllerSettings {
                limit: stated(self.limit).unwrap_or(pid.limit),
                reference_filter: self.reference_filter,
                notch: self.notch,
                feed_forward: stated(self.feed_forward.bandwidth).map(|_| self.feed_forward),
                ..pid
            }
        });
        let own = &mut settings.identifier;
        own.known = Each::from_fn(|one| self.known.get(one) != 0);
        let known = own.known;
        // It may be known to be zero.
        own.initial = Each::from_fn(|one| {
            let zero = known.get(one).then_some(0.0);
            stated(self.initial.get(one)).or(zero)
        });
        own.bounds = Each::from_fn(|one| stated(self.bounds.get(one)));
        own.uncertainty = Each::from_fn(|one| stated(self.uncertainty.get(one)));
        own.gamma = stated(self.gamma);
        own.correction = stated(self.correction);
        own.parameter_range = stated(self.servo_range);
        own.mu = stated(self.mu);
        own.bandwidth = stated(self.bandwidth);
        own.start_time = stated(self.start_time);
        own.memory = stated(self.memory);
        own.noise = stated(self.noise);
        own.max_speed = stated(self.max_speed);
        own.ranges = stated(self.ranges);
        settings
    }

    /// Sample time and resolution are stated; of the parameter range and the ranges of signals all or nothing.
    pub(crate) fn complete(&self) -> Result<(), SettingsError> {
        needed("sample_time", self.sample_time)?;
        if stated(self.resolution).is_none() {
            needed("counts_per_revolution", self.counts_per_revolution)?;
        }
        if let Some(ServoRange { a, b }) = stated(self.servo_range) {
            needed("servo_range.a", a)?;
            needed("servo_range.b", b)?;
        }
        if let Some(ranges) = stated(self.ranges) {
            needed("ranges.error", ranges.error)?;
            needed("ranges.velocity", ranges.velocity)?;
            needed("ranges.command", ranges.command)?;
        }
        Ok(())
    }

    /// The goal of gains: as stiff as the servo permits, unless another was given.
    fn goal(&self) -> Goal {
        match (stated(self.response_time), stated(self.loop_bandwidth)) {
            (Some(time), _) => Goal::ResponseTime(time),
            (None, Some(bandwidth)) => Goal::Bandwidth(bandwidth),
            (None, None) => Goal::Stiffest,
        }
    }

    /// The settings of a tuning.
    pub(crate) fn tuning(&self) -> TuningSettings {
        let command = stated(self.command).unwrap_or(f64::INFINITY);
        let usual = TuningSettings::new(self.sample_time, self.count(), command, self.step);
        TuningSettings {
            noise: self.noise,
            cutoff: stated(self.cutoff),
            command_delay: self.command_delay,
            goal: self.goal(),
            max_sensitivity: stated(self.max_sensitivity).unwrap_or(usual.max_sensitivity),
            max_noise: stated(self.max_noise).unwrap_or(usual.max_noise),
            resonance: stated(self.resonance),
            feed_forward: self.with_feed_forward != 0,
            ..usual
        }
    }

    /// The settings of a commissioning.
    pub(crate) fn commission(&self) -> Result<CommissionSettings, SettingsError> {
        let limits = Limits {
            travel: needed("travel", self.travel)?,
            speed: needed("speed", self.speed)?,
            command: needed("limit", self.limit)?,
            duration: needed("duration", self.duration)?,
        };
        let usual = CommissionSettings::new(self.sample_time, self.count(), limits);
        Ok(CommissionSettings {
            command_delay: self.command_delay,
            max_gain: stated(self.max_gain),
            noise: self.noise,
            goal: self.goal(),
            max_sensitivity: stated(self.max_sensitivity).unwrap_or(usual.max_sensitivity),
            trial_step: stated(self.trial_step),
            feed_forward: self.with_feed_forward != 0,
            ..usual
        })
    }

    /// Builds a part of the core.
    pub(crate) fn build<T: FromSettings>(&self) -> Result<T, SettingsError> {
        self.settings().build()
    }
}
