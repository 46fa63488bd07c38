//! The record that survives a loss of power.

use drive_link::{Estimates, Law, NotAllowed, Settings};
use identifier_core::ControllerSettings;
use identifier_core::commission::TrialResult;
use identifier_core::identifier::ExpectedMotion;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::IdentifierSettings;
use identifier_core::tuning::Tuning;
use serde::{Deserialize, Serialize};

use crate::chip::OutputStage;
use crate::closed_loop::FORMAT;
use crate::run::Run;

/// The version of the [`Record`]: another one is another meaning of the bytes.
pub(super) const VERSION: u16 = 7;

/// All of it, so that nothing of one record ever holds beside something of another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// The configuration; the gains are those that hold.
    pub(super) settings: Settings,
    /// Estimates of the last run that was saved.
    pub(super) estimates: Option<Estimates>,
    /// The commissioning that the gains come from, unless they were given.
    pub(super) commissioned: Option<Commissioned>,
    /// A commissioning has begun since, and its end was not kept.
    pub(super) under_way: bool,
}

/// The validated result of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Commissioned {
    parameters: ServoParameters,
    delay: f64,
    /// The covariance is symmetric: row by row up to the diagonal.
    covariance: [f64; ENTRIES],
    unexplained: f64,
    pub(super) tuning: Tuning,
    pub(super) trial: Option<TrialResult>,
}

/// Entries of a covariance of five unknowns that are not there twice.
const ENTRIES: usize = 15;

/// The law that needs no box of servos.
const LAW_WITHOUT_BOX: Law = if cfg!(feature = "fixed-point") {
    Law::Gradient { friction: false }
} else {
    Law::GaussNewton
};

impl Commissioned {
    pub(super) fn new(servo: &IdentifiedServo, tuning: Tuning, trial: Option<TrialResult>) -> Self {
        let mut covariance = [0.0; ENTRIES];
        let lower = servo
            .covariance
            .iter()
            .zip(1..)
            .flat_map(|(row, columns)| row.iter().take(columns));
        for (place, &entry) in covariance.iter_mut().zip(lower) {
            *place = entry;
        }
        Self {
            parameters: servo.parameters,
            delay: servo.delay,
            covariance,
            unexplained: servo.unexplained,
            tuning,
            trial,
        }
    }

    /// The servo that was found.
    pub(super) fn servo(&self) -> IdentifiedServo {
        let entry = |i: usize, j: usize| {
            let (row, column) = (i.max(j), i.min(j));
            let place = row * (row + 1) / 2 + column;
            self.covariance.get(place).copied().unwrap_or_default()
        };
        IdentifiedServo {
            parameters: self.parameters,
            delay: self.delay,
            covariance: core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))),
            unexplained: self.unexplained,
        }
    }

    /// The motion that its gains give to the servo.
    pub(super) fn motion(&self) -> ExpectedMotion {
        ExpectedMotion {
            bandwidth: self.tuning.bandwidth,
            command: self.tuning.kp * self.tuning.promise.step,
        }
    }

    /// Settings with its gains, within the limits of the command that were given, or else these. A law
    /// that is refused with its gains, as with a box that was given for others, is replaced by the one that needs no
    /// box.
    ///
    /// # Errors
    /// The setting that is not allowed all the same.
    pub(super) fn settings(
        &self,
        given: &Settings,
        limit: [f64; 2],
        stage: &OutputStage,
    ) -> Result<Settings, NotAllowed> {
        let Tuning {
            kp, kd, ki, cutoff, ..
        } = self.tuning;
        let mut settings = *given;
        let closed_loop = &mut settings.closed_loop;
        let limit = closed_loop.core.controller.map_or(limit, |own| own.limit);
        closed_loop.core.cutoff = cutoff;
        closed_loop.core.controller = Some(ControllerSettings { kp, kd, ki, limit });
        if Run::check(&settings, stage).is_err() {
            let closed_loop = &mut settings.closed_loop;
            closed_loop.core.identifier = IdentifierSettings::UNSTATED;
            closed_loop.law = LAW_WITHOUT_BOX;
            closed_loop.format = FORMAT;
            Run::check(&settings, stage)?;
        }
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use drive_link::{Dither, Homing, LoopSettings, Protection, TargetSource, TermSizes};
    use identifier_core::parameters::PerParameter;
    use identifier_core::settings::{BoxSettings, RangeSettings, TermSettings};
    use identifier_core::tuning::{Cap, Promise};

    use super::*;
    use crate::store::MAX_RECORD_BYTES;

    const ANY: f64 = 1.0;

    /// With nothing left out.
    fn settings() -> Settings {
        let identifier = IdentifierSettings {
            initial: PerParameter::from_fn(|_| Some(ANY)),
            known: PerParameter::from_fn(|_| true),
            bounds: PerParameter::from_fn(|_| Some([ANY; 2])),
            uncertainty: PerParameter::from_fn(|_| Some(ANY)),
            noise: Some(ANY),
            plant_box: Some(BoxSettings {
                a: [ANY; 2],
                b: [ANY; 2],
            }),
            gamma: Some([[ANY; 4]; 4]),
            mu: Some(ANY),
            correction: Some([ANY; 3]),
            bandwidth: Some(ANY),
            start_time: Some(ANY),
            memory: Some(ANY),
            terms: TermSettings {
                low_speed_velocity: Some(ANY),
                ripple_order: Some(ANY),
                ..TermSettings::NONE
            },
            max_speed: Some(ANY),
            ranges: Some(RangeSettings {
                error: ANY,
                velocity: ANY,
                command: ANY,
            }),
        };
        Settings {
            closed_loop: LoopSettings {
                core: identifier_core::Settings {
                    controller: Some(ControllerSettings::pid(ANY, ANY, ANY)),
                    identifier,
                    ..identifier_core::Settings::new(ANY, ANY)
                },
                law: Law::Gradient { friction: true },
                format: FORMAT,
            },
            dither: Dither {
                amplitude: ANY,
                hold: ANY,
            },
            protection: Protection {
                following_error: ANY,
                travel: ANY,
                pace: ANY,
                speed: ANY,
                breakaway: ANY,
                stall_time: ANY,
                overruns: 1,
                duration: ANY,
                link_timeout: ANY,
                stop_time: ANY,
            },
            homing: Some(Homing {
                seek: ANY,
                approach: ANY,
                clearance: ANY,
                index: true,
                offset: ANY,
            }),
            source: TargetSource::Steps { step: ANY },
        }
    }

    const SERVO: ServoParameters = ServoParameters {
        a: ANY,
        b: ANY,
        coulomb: ANY,
        load: ANY,
    };

    const TUNING: Tuning = Tuning {
        kp: ANY,
        kd: ANY,
        ki: ANY,
        cutoff: ANY,
        bandwidth: ANY,
        cap: Some(Cap::Delay),
        promise: Promise {
            step: ANY,
            rise_time: ANY,
            quickest_rise_time: ANY,
            slowest_rise_time: ANY,
            overshoot: ANY,
            settling_time: ANY,
            sensitivity: ANY,
            gain_margins: [ANY; 2],
            command_share: ANY,
            noise: ANY,
            compliance: ANY,
        },
    };

    const TRIAL: TrialResult = TrialResult {
        step: ANY,
        rise_time: Some(ANY),
        overshoot: ANY,
        disturbance: ANY,
        excursion: ANY,
    };

    fn servo() -> IdentifiedServo {
        IdentifiedServo {
            parameters: SERVO,
            delay: ANY,
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| (i * j) as f64 + 1.0 / (i + j + 1) as f64)
            }),
            unexplained: ANY,
        }
    }

    #[test]
    fn a_record_with_nothing_left_out_fits_a_slot() {
        let record = Record {
            settings: settings(),
            estimates: Some(Estimates {
                servo: SERVO,
                at_bounds: PerParameter::from_fn(|_| true),
                standard_errors: Some(SERVO),
                terms: TermSizes::where_known(|_| Some(1.0))
                    .map(|sizes| sizes.with_errors(|_| Some(1.0))),
            }),
            commissioned: Some(Commissioned::new(&servo(), TUNING, Some(TRIAL))),
            under_way: true,
        };
        let mut bytes = [0; MAX_RECORD_BYTES];
        let written = postcard::to_slice(&record, &mut bytes).expect("it fits");
        assert!(written.len() > MAX_RECORD_BYTES / 2, "{}", written.len());
    }

    #[test]
    fn the_servo_that_was_found_is_kept_whole() {
        assert_eq!(Commissioned::new(&servo(), TUNING, None).servo(), servo());
    }
}
