//! The keys of a commissioning, and the core's settings from them.

use commissioning::{CommissionError, CommissionSettings, HoldingGains, Limits};
use identifier_core::error::OutOfRange;
use identifier_core::tuning::Goal;

use super::{Fault, Key, Scenario, Velocity, key_of_loop};

/// A commissioning as it is stated, SI; none for a value that is derived.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, documented there"
)]
pub struct CommissionOrder {
    /// All that is not derived.
    pub settings: CommissionSettings,
    pub command: Option<[f64; 2]>,
    pub response_time: Option<f64>,
    pub bandwidth: Option<f64>,
    pub command_delay: Option<f64>,
    pub sample_time: Option<f64>,
    /// The amplifier's own limit, which the command keeps in any case.
    pub(super) amplifier: Option<[f64; 2]>,
}

impl CommissionOrder {
    /// Before its keys are read.
    pub(super) fn blank(amplifier: Option<[f64; 2]>) -> Self {
        Self {
            settings: CommissionSettings::new(0.0, 0.0, Limits::new([0.0; 2], 0.0, [0.0; 2])),
            command: None,
            response_time: None,
            bandwidth: None,
            command_delay: None,
            sample_time: None,
            amplifier,
        }
    }

    /// The lowest and highest command.
    fn command_limit(&self) -> Result<[f64; 2], Fault> {
        const KEY: &str = "commission.command";
        match (self.command, self.amplifier) {
            (Some([low, high]), Some([least, most])) if low < least || high > most => {
                let fault = format!("[{low}, {high}] exceeds amplifier.limit, [{least}, {most}]");
                Err(Fault::new(KEY, fault))
            }
            (Some(command), _) | (None, Some(command)) => Ok(command),
            (None, None) => Err(Fault::new(
                KEY,
                "without amplifier.limit this key is required",
            )),
        }
    }

    /// Checks that there is travel to either side.
    fn check_ways(&self) -> Result<(), Fault> {
        let [low, high] = self.settings.limits.travel;
        if low < 0.0 && high > 0.0 {
            return Ok(());
        }
        Err(Fault::new(
            "commission.travel",
            format!(
                "the servo is at an end of its travel, [{low}, {high}]: allow travel to either side; for an axis \
                 that must not reverse, identify a and b from a log, with identifier.parameters = [\"a\", \"b\", \
                 \"load\"]"
            ),
        ))
    }

    /// Whether to look for a feed-forward, which a goal of a response time leaves no room for.
    fn leads(&self) -> Result<bool, Fault> {
        match self.response_time {
            Some(_) if self.settings.feed_forward => Err(Fault::new(
                "commission.feed_forward",
                "with a reference model a slower loop would meet commission.response_time: state bandwidth, or neither",
            )),
            _ => Ok(self.settings.feed_forward),
        }
    }

    /// The goal of the tuning.
    fn goal(&self) -> Result<Goal, Fault> {
        match (self.response_time, self.bandwidth) {
            (Some(time), None) => Ok(Goal::ResponseTime(time)),
            (None, Some(bandwidth)) => Ok(Goal::Bandwidth(bandwidth)),
            (None, None) => Ok(Goal::Stiffest),
            (Some(_), Some(_)) => Err(Fault::new(
                "commission.bandwidth",
                "there is a second goal: state one of response_time and bandwidth",
            )),
        }
    }
}

impl Scenario {
    /// The stated noise of the encoder beside its rounding, rad; 0 where none is stated.
    fn stated_noise(&self) -> f64 {
        let stated = self.stated.identifier.noise.unwrap_or(0.0);
        let rounding = self.stated.resolution / 12.0_f64.sqrt();
        (stated * stated - rounding * rounding).max(0.0).sqrt()
    }

    /// The core's settings of a commissioning.
    ///
    /// # Errors
    /// The key that is missing or contradicts another.
    pub fn commission_settings(&self) -> Result<CommissionSettings, Fault> {
        let order = self.commission.as_ref().ok_or_else(|| {
            let about = Key::<Self>::at("commission").map_or("", |key| key.about);
            Fault::new("commission", format!("this table is missing: {about}"))
        })?;
        order.check_ways()?;
        let parameter_range = self.stated.identifier.parameter_range;
        let stated = order.settings;
        Ok(CommissionSettings {
            sample_time: self.sample_time(),
            resolution: self.stated.resolution,
            limits: Limits {
                command: order.command_limit()?,
                ..stated.limits
            },
            command_delay: order
                .command_delay
                .unwrap_or(self.stated.identifier.terms.delay),
            max_gain: stated.max_gain.or(parameter_range.map(|range| range.b[1])),
            noise: self.stated_noise(),
            goal: order.goal()?,
            feed_forward: order.leads()?,
            ..stated
        })
    }

    /// The gains that hold the servo before a commissioning, if there is a controller.
    ///
    /// # Errors
    /// It has no low-pass: a commissioning can go back to no other.
    pub fn gains_before(&self) -> Result<Option<HoldingGains>, Fault> {
        if self.stated.controller.is_some() && self.velocity != Velocity::LowPass {
            return Err(Fault::new(
                "controller.velocity_filter.kind",
                "a commissioning can return only to gains with a \"low-pass\"",
            ));
        }
        Ok(HoldingGains::of(&self.stated))
    }

    /// The rejection of a commissioning, at the key that remedies it.
    #[must_use]
    pub fn fault_of_commission(&self, error: &CommissionError) -> Fault {
        let asked = self.commission.and_then(|order| order.response_time);
        match (error, asked) {
            (CommissionError::TooFast { bandwidth, most }, Some(time)) => {
                // The response takes the longer the lower the bandwidth.
                let needed = time * bandwidth / most;
                let fault = format!(
                    "a response within {time} s is faster than sampling and delay permit: ask for {needed:.4} s or more"
                );
                Fault::new("commission.response_time", fault)
            }
            (CommissionError::TooFast { .. }, None) => Fault::new("commission.bandwidth", error),
            (CommissionError::TravelTooSmall { travel, needed }, _) => {
                let each = needed / 2.0;
                let fault = format!(
                    "a travel of {travel:.4} rad from end to end is too small to identify the servo with this \
                     encoder: allow {needed:.4} rad, {each:.4} rad to either side"
                );
                Fault::new("commission.travel", fault)
            }
            (CommissionError::TooStrong { .. }, _) => {
                let own = self.commission.and_then(|order| order.sample_time);
                let table = if own.is_some() {
                    "commission"
                } else {
                    "controller"
                };
                Fault::new(format!("{table}.sample_time"), error)
            }
            (CommissionError::SpeedTooSmall { .. }, _) => Fault::new("commission.speed", error),
            (
                CommissionError::Range(OutOfRange {
                    parameter: "command_delay",
                    value,
                    allowed,
                }),
                _,
            ) => {
                let fault = format!(
                    "a delay of {value} s is too long for a commissioning: at this sample time it must be \
                     {allowed}; shorten the delay, or record a log and identify it with servo-id"
                );
                let own = self.commission.and_then(|order| order.command_delay);
                let table = if own.is_some() {
                    "commission.command_delay"
                } else {
                    "amplifier.delay"
                };
                Fault::new(table, fault)
            }
            (
                CommissionError::Range(OutOfRange {
                    parameter: setting, ..
                }),
                _,
            ) => {
                let own = || format!("commission.{setting}");
                let of_loop = key_of_loop(setting).filter(|_| *setting != "sample_time");
                Fault::new(of_loop.unwrap_or_else(own), error)
            }
        }
    }
}

/// The sample time of a commissioning: the controller's, or its own where there is none.
pub(super) fn adopt_sample_time(scenario: &mut Scenario) -> Result<(), Fault> {
    let Some(own) = scenario.commission.and_then(|order| order.sample_time) else {
        return Ok(());
    };
    let running = scenario.stated.sample_time;
    if scenario.stated.controller.is_some() && own.to_bits() != running.to_bits() {
        let fault = format!("{own} s contradicts controller.sample_time, {running} s");
        return Err(Fault::new("commission.sample_time", fault));
    }
    scenario.stated.sample_time = own;
    Ok(())
}
