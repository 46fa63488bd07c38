//! Settings: parameters by number.

use identifier_core::Settings as CoreSettings;
use identifier_core::control::FeedForwardSettings;
use identifier_core::error::Allowed;
use identifier_core::excitation::Prbs;
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{PerParameter, Unknowns};
use identifier_core::settings::{
    ControllerSettings, ParameterRangeSettings, RangeSettings, SettingsError, diagonal,
};

use crate::object::{Content, Object, answered, content, fill, shared, storage};
use crate::parameter::{self, Kind, PLACES, row};
use crate::status::{self, Error};

/// The parameters that were given.
#[derive(Debug, Clone, Copy)]
pub struct Given {
    /// A bit each.
    given: u64,
    /// A value, or lowest and highest.
    values: [[f64; 2]; PLACES],
}

/// `servo_id_settings` in the header.
pub type Settings = Object<Given>;

impl Content for Given {
    const MARK: u32 = 0x5e1d_0001;
    const WORDS: usize = 144;
}

impl Given {
    pub(crate) fn has(&self, number: i32) -> bool {
        (0..PLACES as i32).contains(&number) && self.given >> number & 1 == 1
    }

    fn take(&mut self, number: i32, values: [f64; 2]) -> Result<i32, i32> {
        let place = self.values.get_mut(number as usize);
        *place.ok_or(status::NO_SUCH_NUMBER)? = values;
        self.given |= 1 << number;
        Ok(status::OK)
    }

    pub(crate) fn range(&self, number: i32) -> Option<[f64; 2]> {
        let values = self.values.get(number as usize).copied();
        values.filter(|_| self.has(number))
    }

    pub(crate) fn value(&self, number: i32) -> Option<f64> {
        self.range(number).map(|[value, _]| value)
    }

    /// True for a choice that was given and is not zero.
    pub(crate) fn is_set(&self, number: i32) -> bool {
        self.value(number).is_some_and(|value| value != 0.0)
    }

    /// The values of four parameters with adjacent numbers, for a, b, Coulomb friction and load.
    fn per_parameter(&self, first: i32) -> PerParameter<Option<f64>> {
        PerParameter {
            a: self.value(first),
            b: self.value(first + 1),
            coulomb: self.value(first + 2),
            load: self.value(first + 3),
        }
    }

    /// The settings of the core.
    pub(crate) fn settings(&self) -> CoreSettings {
        use parameter as p;
        let or_zero = |number| self.value(number).unwrap_or(0.0);
        // Stated when it was initialised.
        let mut settings = CoreSettings::new(or_zero(p::SAMPLE_TIME), 1.0);
        settings.resolution = or_zero(p::RESOLUTION);
        settings.cutoff = self.value(p::CUTOFF).unwrap_or(settings.cutoff);
        if [p::KP, p::KD, p::KI].into_iter().any(|gain| self.has(gain)) {
            let pid = ControllerSettings::pid(or_zero(p::KP), or_zero(p::KD), or_zero(p::KI));
            settings.controller = Some(ControllerSettings {
                limit: self.range(p::LIMIT).unwrap_or(pid.limit),
                reference_filter: or_zero(p::REFERENCE_FILTER),
                notch: or_zero(p::NOTCH),
                feed_forward: self.value(p::FEED_FORWARD_BANDWIDTH).map(|bandwidth| {
                    FeedForwardSettings {
                        bandwidth,
                        acceleration: or_zero(p::FEED_FORWARD_ACCELERATION),
                        velocity: or_zero(p::FEED_FORWARD_VELOCITY),
                        coulomb: or_zero(p::FEED_FORWARD_COULOMB),
                        coulomb_speed: or_zero(p::FEED_FORWARD_COULOMB_SPEED),
                    }
                }),
                ..pid
            });
        }
        let own = &mut settings.identifier;
        own.initial = self.per_parameter(p::INITIAL_A);
        let known = self.per_parameter(p::KNOWN_A);
        own.known = PerParameter::from_fn(|parameter| {
            known.get(parameter).is_some_and(|known| known != 0.0)
        });
        own.bounds = PerParameter {
            a: self.range(p::BOUNDS_A),
            b: self.range(p::BOUNDS_B),
            coulomb: self.range(p::BOUNDS_COULOMB),
            load: self.range(p::BOUNDS_LOAD),
        };
        own.uncertainty = self.per_parameter(p::UNCERTAINTY_A);
        let gamma = self.per_parameter(p::GAMMA_A);
        if self.has(p::GAMMA_A) || self.has(p::GAMMA_B) {
            // A parameter that the model does not have needs none.
            let entry = |given: Option<f64>| given.unwrap_or(0.0);
            own.gamma = Some(diagonal([
                entry(gamma.a),
                entry(gamma.b),
                entry(gamma.coulomb),
                entry(gamma.load),
            ]));
        }
        let correction = [p::CORRECTION_KP, p::CORRECTION_KD, p::CORRECTION_KI];
        if correction.into_iter().any(|gain| self.has(gain)) {
            own.correction = Some(correction.map(or_zero));
        }
        if let (Some(a), Some(b)) = (self.range(p::PLANT_BOX_A), self.range(p::PLANT_BOX_B)) {
            own.parameter_range = Some(ParameterRangeSettings { a, b });
        }
        own.mu = self.value(p::MU);
        own.bandwidth = self.value(p::BANDWIDTH);
        own.start_time = self.value(p::START_TIME);
        own.memory = self.value(p::MEMORY);
        own.noise = self.value(p::NOISE);
        own.max_speed = self.value(p::MAX_SPEED);
        let ranges = [p::RANGES_ERROR, p::RANGES_VELOCITY, p::RANGES_COMMAND];
        if let [Some(error), Some(velocity), Some(command)] = ranges.map(|range| self.value(range))
        {
            own.ranges = Some(RangeSettings {
                error,
                velocity,
                command,
            });
        }
        settings
    }

    /// Both sides of the parameter range and all three ranges are given, or none of them.
    fn incomplete(&self) -> Option<i32> {
        use parameter as p;
        let groups: [&[i32]; 2] = [
            &[p::PLANT_BOX_A, p::PLANT_BOX_B],
            &[p::RANGES_ERROR, p::RANGES_VELOCITY, p::RANGES_COMMAND],
        ];
        let partly = groups
            .into_iter()
            .filter(|group| group.iter().any(|&number| self.has(number)));
        let mut missing = partly.flatten().filter(|&&number| !self.has(number));
        missing.next().copied()
    }

    /// Builds a part of the core.
    pub(crate) fn build<T: identifier_core::settings::FromSettings>(&self) -> Result<T, Error> {
        if let Some(missing) = self.incomplete() {
            return Err(Error {
                parameter: missing,
                ..Error::of(status::NOT_GIVEN)
            });
        }
        let built = self.settings().build();
        built.map_err(|error| Error::settings(&error, |number| self.has(number)))
    }
}

/// Settings that were initialised.
///
/// # Safety
/// As the header says.
pub(crate) unsafe fn given<'a>(settings: *const Settings) -> Result<&'a Given, Error> {
    // SAFETY: guaranteed by the caller.
    Ok(unsafe { shared(settings) }?)
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
    let given = unsafe { content(settings) }?;
    let chosen = if with_coulomb {
        gamma::<Unknowns<3>, 3>(given, amplitude, hold, samples)
    } else {
        gamma::<Unknowns<2>, 2>(given, amplitude, hold, samples)
    };
    let chosen = chosen.map_err(|refused| Error::settings(&refused, |number| given.has(number)))?;
    let numbers = [
        parameter::GAMMA_A,
        parameter::GAMMA_B,
        parameter::GAMMA_COULOMB,
    ];
    for (place, (number, row)) in numbers.into_iter().zip(chosen).enumerate() {
        given.take(number, [row.get(place).copied().unwrap_or(0.0), 0.0])?;
    }
    Ok(status::OK)
}

/// The diagonal of Γ for a model of P parameters.
fn gamma<S, const P: usize>(
    given: &Given,
    amplitude: f64,
    hold: f64,
    samples: u32,
) -> Result<[[f64; 4]; 4], SettingsError>
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
    /// Nothing stated but sample time (s) and counts of a revolution.
    fn servo_id_settings_init(
        settings: *mut Settings,
        size: u32,
        sample_time: f64,
        counts_per_revolution: f64,
    ) {
        // SAFETY: the header's conditions.
        let settings = unsafe { storage(settings, size) }?;
        let positive = |value| Allowed::Above(0.0).holds(value);
        if !positive(sample_time) || !positive(counts_per_revolution) {
            return Err(status::OUT_OF_RANGE);
        }
        let mut given = Given {
            given: 0,
            values: [[0.0; 2]; PLACES],
        };
        let resolution = core::f64::consts::TAU / counts_per_revolution;
        given.take(parameter::SAMPLE_TIME, [sample_time, 0.0])?;
        given.take(parameter::RESOLUTION, [resolution, 0.0])?;
        // SAFETY: it is of `storage`.
        unsafe { fill(settings, given) };
        Ok(status::OK)
    }

    /// A parameter that takes one value.
    fn servo_id_settings_set(settings: *mut Settings, parameter: i32, value: f64) {
        // SAFETY: the header's conditions.
        let given = unsafe { content(settings) }?;
        match row(parameter) {
            None => Err(status::NO_SUCH_NUMBER),
            Some(row) if row.kind != Kind::Value => Err(status::NOT_A_VALUE),
            Some(_) if value.is_nan() => Err(status::OUT_OF_RANGE),
            Some(_) => given.take(parameter, [value, 0.0]),
        }
    }

    /// A parameter that takes lowest and highest.
    fn servo_id_settings_set_range(settings: *mut Settings, parameter: i32, low: f64, high: f64) {
        // SAFETY: the header's conditions.
        let given = unsafe { content(settings) }?;
        match row(parameter) {
            None => Err(status::NO_SUCH_NUMBER),
            Some(row) if row.kind != Kind::Range => Err(status::NOT_A_RANGE),
            Some(_) if low.is_nan() || high.is_nan() => Err(status::OUT_OF_RANGE),
            Some(_) => given.take(parameter, [low, high]),
        }
    }

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
