//! A servo and the settings of its drive.

use std::cell::{Cell, RefCell};
use std::f64::consts::TAU;

use commissioning::{CommissionSettings, Limits};
use drive_link::{
    Dither, Estimator, LoopSettings, Protection, ServoChanges, Settings, TargetSource,
};
use drive_logic::{Chip, Lines, OutputStage};
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::Goal;
use virtual_servo::{Encoder, Plant};

const COUNTS: f64 = 10_000.0;

const SERVO: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 15.0,
    load: 0.0,
};

pub(super) const STAGE: OutputStage = OutputStage {
    full_scale: 10.0,
    period: 5e-5,
    command_delay: 1.25e-5,
    board: "bench",
    is_simulated: false,
};

/// Settings of a drive at a rate, Hz.
pub(super) fn settings(rate: u32) -> Settings {
    let core = identifier_core::Settings {
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..identifier_core::Settings::new(1.0 / f64::from(rate), COUNTS)
    };
    Settings {
        closed_loop: LoopSettings {
            core,
            law: Estimator::GaussNewton,
        },
        dither: Dither {
            amplitude: 0.05,
            hold: 0.05,
        },
        protection: Protection {
            following_error: 3.0,
            travel: [-51.0, 51.0],
            pace: 5.0,
            speed: 100.0,
            breakaway: 0.3,
            stall_time: 1.0,
            overruns: 3,
            duration: 0.0,
            link_timeout: 0.0,
            stop_time: 0.5,
        },
        homing: None,
        source: TargetSource::Line,
        servo_changes: ServoChanges::Ignored,
        brake: None,
    }
}

/// A commissioning of it.
pub(super) fn order(settings: &Settings) -> CommissionSettings {
    CommissionSettings {
        goal: Goal::Bandwidth(40.0),
        ..CommissionSettings::new(
            settings.closed_loop.core.sample_time,
            TAU / COUNTS,
            Limits {
                duration: 2.0,
                ..Limits::new([-2.0, 2.0], 60.0, [-10.0, 10.0])
            },
        )
    }
}

/// The servo at the output of a drive.
pub(super) struct Servo {
    plant: RefCell<Plant>,
    encoder: Encoder,
    held: Cell<Option<f32>>,
}

impl Servo {
    pub(super) fn new(sample_time: f64) -> Self {
        Self {
            plant: RefCell::new(Plant::at_rest(&SERVO, sample_time)),
            encoder: Encoder::new(COUNTS),
            held: Cell::new(None),
        }
    }

    pub(super) fn is_driven(&self) -> bool {
        self.held.get().is_some()
    }

    /// Moves for a sample.
    pub(super) fn advance(&self) {
        let command = self.held.get().unwrap_or(0.0);
        self.plant.borrow_mut().advance(command.into());
    }
}

/// The servo as the sample interrupt has it.
pub(super) struct Pins<'a> {
    sensor: &'a Servo,
    output: &'a Servo,
}

impl<'a> Pins<'a> {
    pub(super) fn of(servo: &'a Servo) -> Self {
        Self {
            sensor: servo,
            output: servo,
        }
    }
}

impl<'a> Chip for Pins<'a> {
    type Sensor = &'a Servo;
    type Output = &'a Servo;

    fn lines(&self) -> Lines {
        Lines {
            supply: true,
            amplifier: true,
            low_switch: true,
            high_switch: true,
        }
    }

    fn servo(&mut self) -> (&mut Self::Sensor, &mut Self::Output) {
        (&mut self.sensor, &mut self.output)
    }

    fn home_switch_is_closed(&self) -> bool {
        false
    }

    fn index(&mut self) -> Option<i32> {
        None
    }

    fn steps(&mut self) -> Option<i16> {
        Some(0)
    }

    fn next_is_due(&self) -> bool {
        false
    }

    fn feed_watchdog(&mut self) {}
}

impl PositionSensor for &Servo {
    type Error = ();

    fn count(&mut self) -> Result<i32, ()> {
        let position = self.plant.borrow().position;
        // 32 bits wrap.
        Ok(self.encoder.read(position) as i32)
    }
}

impl Actuator<f32> for &Servo {
    type Error = ();

    fn hold(&mut self, command: f32) -> Result<(), ()> {
        self.held.set(Some(command));
        Ok(())
    }

    fn release(&mut self) -> Result<(), ()> {
        self.held.set(None);
        Ok(())
    }
}
