use super::parameter_range::LARGEST;
use super::{SettingsError, TermSettings};
use crate::error::Allowed;
use crate::measurement::angle::AngleSettings;
use crate::number::Number;
use crate::parameters::{Term, Terms, Unknown};
use crate::units::Units;

/// The optional terms of a model as checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TermConfig {
    pub(super) demanded: Terms,
    delay: f64,
    dead_band: f64,
    low_speed_velocity: f64,
    ripple_order: f64,
    revolution: f64,
    /// Samples.
    longest_delay: f64,
}

impl TermConfig {
    /// Checks the settings of the terms for a model that has its `own`, with delays up to the longest, samples. One copy
    /// serves every model.
    #[inline(never)]
    pub(super) fn new(
        own: Terms,
        longest_delay: f64,
        given: &TermSettings,
        units: &Units,
    ) -> Result<Self, SettingsError> {
        let has = |term| own.has(term);
        for term in Term::ALL {
            if given.demanded.has(term) && !has(term) {
                return Err(SettingsError::NoSuchTerm { term });
            }
        }
        let acts = |setting| match setting {
            "delay" => has(Term::Delay),
            "dead_band" => has(Term::DeadBand),
            _ => false,
        };
        if let Some(setting) = given.of_amplifier().find(|&setting| !acts(setting)) {
            return Err(SettingsError::NoAmplifier { setting });
        }
        /// The highest order of ripple that an encoder shows, as a part of its counts.
        const MAX_RIPPLE_ORDER_PER_COUNT: f64 = 0.25;
        // The estimate needs room above the declared delay.
        let longest = longest_delay * units.sample_time();
        let delay = Allowed::Within(0.0, longest).check("delay", given.delay)?;
        let dead_band = Allowed::Within(0.0, LARGEST).check("dead_band", given.dead_band)?;
        let declared = |value: Option<f64>, term: Term, setting: &'static str| match value {
            Some(value) => Ok(Allowed::PositiveUpTo(LARGEST).check(setting, value)?),
            None if given.demanded.has(term) => Err(SettingsError::NotGiven { setting }),
            None => Ok(0.0),
        };
        Ok(Self {
            demanded: given.demanded,
            delay,
            dead_band,
            low_speed_velocity: declared(
                given.low_speed_velocity,
                Term::LowSpeed,
                "low_speed_velocity",
            )?,
            ripple_order: match given.ripple_order {
                // A period of fewer counts than four is not seen.
                Some(order) => Allowed::PositiveUpTo(
                    MAX_RIPPLE_ORDER_PER_COUNT * given.revolution.max(0.0) * units.position(),
                )
                .check("ripple_order", order)?,
                None => declared(None, Term::Ripple, "ripple_order")?,
            },
            revolution: Allowed::PositiveUpTo(LARGEST).check("revolution", given.revolution)?,
            longest_delay,
        })
    }

    /// The initial value of a term's unknown, SI.
    pub(super) fn initial(&self, unknown: Unknown) -> f64 {
        match unknown {
            Unknown::Delay => self.delay,
            Unknown::DeadBand => self.dead_band,
            _ => 0.0,
        }
    }

    /// The bounds of a term's unknown, machine units.
    pub(super) fn bounds(&self, unknown: Unknown, units: &Units) -> [f64; 2] {
        if !unknown.term().is_some_and(|term| self.demanded.has(term)) {
            return [self.initial(unknown) * unknown.scale(units); 2];
        }
        match unknown {
            Unknown::Delay => [0.0, self.longest_delay],
            Unknown::DeadBand => [0.0, LARGEST],
            _ => [-LARGEST, LARGEST],
        }
    }

    /// The angle as the model needs it.
    pub(super) fn angle<N: Number>(&self, units: &Units) -> AngleSettings<N> {
        AngleSettings::new(self.revolution * units.position(), self.ripple_order)
    }

    /// ρ/(T v_s), zero without v_s.
    pub(super) fn per_low_speed_velocity(&self, units: &Units) -> f64 {
        if self.low_speed_velocity > 0.0 {
            1.0 / (self.low_speed_velocity * units.velocity())
        } else {
            0.0
        }
    }
}
