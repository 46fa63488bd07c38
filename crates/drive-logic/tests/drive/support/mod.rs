//! Support of the drive's tests, and of the stops in `tests`: settings, a flash that can lose its power, a servo.

pub(crate) mod commission;
pub(crate) mod drive;
pub(crate) mod harms;
pub(crate) mod line;
pub(crate) mod numbers;

use core::f64::consts::TAU;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use drive_link::{Estimator, Homing, LoopSettings, Protection, Settings};
use drive_logic::{Chip, Lines, OutputStage};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::parameters::{PerParameter, ServoParameters};
use identifier_core::settings::{ControllerSettings, IdentifierSettings, ParameterRangeSettings};
use virtual_servo::{Encoder, Plant, VirtualBrake};

pub(crate) const SAMPLE_TIME: f64 = 1e-3;
pub(crate) const COUNTS: f64 = 10_000.0;

/// A switch at the lower end, and the origin in the middle of the travel.
pub(crate) const HOMING: Homing = Homing {
    seek: -3.0,
    approach: 0.2,
    clearance: 0.5,
    index: false,
    offset: 2.0,
};

pub(crate) fn settings() -> Settings {
    let mut core = identifier_core::Settings {
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..identifier_core::Settings::new(SAMPLE_TIME, COUNTS)
    };
    let identifier = &mut core.identifier;
    identifier.parameter_range = Some(ParameterRangeSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    identifier.initial.b = Some(150.0);
    identifier.bounds.a = Some([0.0, 100.0]);
    identifier.bounds.coulomb = Some([0.0, 200.0]);
    identifier.gamma = Some(PerParameter::new(20.0, 3000.0, 20.0, 20.0));
    let law = Estimator::Gradient { friction: false };
    Settings {
        protection: Protection {
            following_error: 3.0,
            travel: [-51.0, 51.0],
            pace: 5.0,
            speed: 100.0,
            breakaway: 0.3,
            stall_time: 0.1,
            overruns: 3,
            duration: 0.0,
            link_timeout: 0.0,
            stop_time: 0.5,
        },
        ..Settings::example(LoopSettings { core, law })
    }
}

/// The same without a dither.
pub(crate) fn still() -> Settings {
    let mut still = settings();
    still.dither.amplitude = 0.0;
    still
}

/// Settings without knowledge of the servo, for the estimator that needs none.
pub(crate) fn first_contact() -> Settings {
    let mut wanted = settings();
    wanted.closed_loop.law = Estimator::GaussNewton;
    wanted.closed_loop.core.identifier = IdentifierSettings::UNSTATED;
    wanted
}

pub(crate) const SECTOR: usize = 4096;

#[derive(Debug, Clone, Copy)]
pub(crate) struct PowerGone;

impl NorFlashError for PowerGone {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// A flash of two sectors. Writing clears bits, erasing sets them; the power may go after any
/// number of steps, a step being a word written or a word of a sector erased.
#[derive(Debug, Clone)]
pub(crate) struct Flash {
    pub(crate) bytes: Rc<RefCell<Vec<u8>>>,
    pub(crate) steps_left: Rc<Cell<usize>>,
    pub(crate) steps: Rc<Cell<usize>>,
    /// Steps that were refused.
    pub(crate) refused: Rc<Cell<u32>>,
    /// Sectors that were erased.
    pub(crate) erased: Rc<Cell<u32>>,
    /// A byte that can no longer be written.
    pub(crate) worn: Rc<Cell<Option<usize>>>,
}

impl Flash {
    pub(crate) fn blank() -> Self {
        Self {
            bytes: Rc::new(RefCell::new(vec![0xff; 2 * SECTOR])),
            steps_left: Rc::new(Cell::new(usize::MAX)),
            steps: Rc::new(Cell::new(0)),
            refused: Rc::default(),
            erased: Rc::default(),
            worn: Rc::default(),
        }
    }

    pub(crate) fn with(bytes: Vec<u8>) -> Self {
        let flash = Self::blank();
        *flash.bytes.borrow_mut() = bytes;
        flash
    }

    /// Its content, with power.
    pub(crate) fn powered_again(&self) -> Self {
        Self::with(self.bytes.borrow().clone())
    }

    fn step(&self) -> Result<(), PowerGone> {
        let Some(left) = self.steps_left.get().checked_sub(1) else {
            self.refused.set(self.refused.get() + 1);
            return Err(PowerGone);
        };
        self.steps_left.set(left);
        self.steps.set(self.steps.get() + 1);
        Ok(())
    }
}

impl ErrorType for Flash {
    type Error = PowerGone;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerGone> {
        let offset = offset as usize;
        bytes.copy_from_slice(&self.bytes.borrow()[offset..offset + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerGone> {
        assert!(from.is_multiple_of(SECTOR as u32) && to - from == SECTOR as u32);
        self.erased.set(self.erased.get() + 1);
        // Not in order: half-way, a sector holds words of both kinds anywhere.
        let words = SECTOR / 4;
        for k in 0..words {
            self.step()?;
            let word = from as usize + 4 * ((k * 613) % words);
            self.bytes.borrow_mut()[word..word + 4].fill(0xff);
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerGone> {
        for (k, word) in bytes.chunks(4).enumerate() {
            self.step()?;
            for (i, byte) in word.iter().enumerate() {
                let place = offset as usize + 4 * k + i;
                if self.worn.get() != Some(place) {
                    self.bytes.borrow_mut()[place] &= byte;
                }
            }
        }
        Ok(())
    }
}

/// Output stage of the bench.
pub(crate) const STAGE: OutputStage = OutputStage {
    full_scale: 10.0,
    period: 5e-5,
    command_delay: 1.25e-5,
    board: "bench",
    is_simulated: false,
};

/// A servo on the bench: the command that is held, its encoder and its output stage. It lives as long as the program, and so
/// does what a drive on it needs.
pub(crate) struct Bench {
    pub(crate) plant: RefCell<Plant>,
    pub(crate) encoder: Encoder,
    pub(crate) sample_time: Cell<f64>,
    pub(crate) connected: Cell<bool>,
    /// Counts of an encoder that is not connected.
    pub(crate) flicker: Cell<i32>,
    /// The count at the servo's start.
    pub(crate) first: Cell<i32>,
    pub(crate) sensor_works: Cell<bool>,
    pub(crate) stage_works: Cell<bool>,
    /// False for a stage that cannot be disabled.
    pub(crate) releases: Cell<bool>,
    pub(crate) held: Cell<Option<f32>>,
    pub(crate) lines: Cell<Lines>,
    pub(crate) late: Cell<bool>,
    /// Where the home switch is closed, rad.
    pub(crate) home_switch: RefCell<std::ops::Range<f64>>,
    /// Place of an index pulse, rad; there is one in every revolution.
    pub(crate) index_at: Cell<Option<f64>>,
    /// Count of the last one.
    pub(crate) index: Cell<Option<i32>>,
    /// Steps that were not read yet; none if they are unclear.
    pub(crate) steps: Cell<Option<i16>>,
    /// Number of times that the watchdog was fed.
    pub(crate) fed: Cell<u32>,
    /// The cycle counter, and what every part between two readings takes.
    pub(crate) cycles: Cell<[u32; 2]>,
    /// The holding brake of the axis, and whether it has power.
    pub(crate) brake: Cell<Option<VirtualBrake>>,
    pub(crate) brake_power: Cell<bool>,
    /// Commands that have not acted yet.
    waiting: RefCell<VecDeque<f32>>,
}

impl Bench {
    pub(crate) fn new(servo: &ServoParameters) -> &'static Self {
        Self::counting_from(0, servo)
    }

    pub(crate) fn counting_from(first: i32, servo: &ServoParameters) -> &'static Self {
        Self::counting(first, COUNTS, servo)
    }

    /// A servo with an encoder of so many counts a revolution, from this one on.
    pub(crate) fn counting(first: i32, counts: f64, servo: &ServoParameters) -> &'static Self {
        Box::leak(Box::new(Self {
            first: Cell::new(first),
            plant: RefCell::new(Plant::at_rest(servo, SAMPLE_TIME)),
            encoder: Encoder::new(counts),
            sample_time: Cell::new(SAMPLE_TIME),
            connected: Cell::new(true),
            flicker: Cell::new(0),
            sensor_works: Cell::new(true),
            stage_works: Cell::new(true),
            releases: Cell::new(true),
            held: Cell::new(None),
            lines: Cell::new(Lines::HEALTHY),
            late: Cell::new(false),
            home_switch: RefCell::new(0.0..0.0),
            index_at: Cell::new(None),
            index: Cell::new(None),
            steps: Cell::new(Some(0)),
            fed: Cell::new(0),
            cycles: Cell::new([0, 0]),
            brake: Cell::new(None),
            brake_power: Cell::new(false),
            waiting: RefCell::default(),
        }))
    }

    /// A servo that is sampled at other times, s.
    pub(crate) fn sampled(servo: &ServoParameters, sample_time: f64) -> &'static Self {
        let bench = Self::new(servo);
        bench.sample_time.set(sample_time);
        *bench.plant.borrow_mut() = Plant::at_rest(servo, sample_time);
        bench
    }

    /// The samples of a time, s.
    pub(crate) fn samples(&self, time: f64) -> u32 {
        (time / self.sample_time.get()).round() as u32
    }

    /// The angle of the axis, rad.
    pub(crate) fn position(&self) -> f64 {
        self.plant.borrow().position
    }

    /// From now on a command acts some samples after it was held.
    pub(crate) fn delay_commands(&self, samples: usize) {
        *self.waiting.borrow_mut() = vec![0.0; samples].into();
    }

    /// From now on another servo, at the same place and speed.
    pub(crate) fn change(&self, servo: &ServoParameters) {
        let mut other = Plant::at_rest(servo, self.sample_time.get());
        let mut plant = self.plant.borrow_mut();
        (other.position, other.velocity) = (plant.position, plant.velocity);
        *plant = other;
    }

    /// From now on the encoder shows this count.
    pub(crate) fn stick(&self) {
        let count = self.encoder.read(self.plant.borrow().position) as i32;
        self.flicker.set(count);
        self.connected.set(false);
    }

    /// Puts the axis at a place, rad, at rest.
    pub(crate) fn hold_at(&self, position: f64) {
        let mut plant = self.plant.borrow_mut();
        (plant.position, plant.velocity) = (position, 0.0);
    }

    /// Advances by a sample.
    pub(crate) fn pass(&self) {
        let mut waiting = self.waiting.borrow_mut();
        waiting.push_back(self.held.get().unwrap_or(0.0));
        let command = waiting.pop_front().unwrap_or(0.0);
        let mut plant = self.plant.borrow_mut();
        let before = plant.position;
        let mut brake = self.brake.get();
        let is_braked = brake
            .as_mut()
            .is_some_and(|brake| brake.holds(self.brake_power.get(), self.sample_time.get()));
        self.brake.set(brake);
        if is_braked {
            plant.velocity = 0.0;
        } else {
            plant.advance(f64::from(command));
        }
        if let Some(index_at) = self.index_at.get() {
            let turns = |position: f64| ((position - index_at) / TAU).floor();
            let last = turns(before.max(plant.position));
            if last > turns(before.min(plant.position)) {
                let count = self.encoder.read(index_at + TAU * last) as i32;
                self.index.set(Some(self.first.get().wrapping_add(count)));
            }
        }
    }
}

/// The bench as the sample interrupt finds it.
pub(crate) struct Pins<'a> {
    bench: &'a Bench,
    sensor: &'a Bench,
    actuator: &'a Bench,
}

impl Bench {
    pub(crate) fn pins(&self) -> Pins<'_> {
        Pins {
            bench: self,
            sensor: self,
            actuator: self,
        }
    }
}

impl<'a> Chip for Pins<'a> {
    type Sensor = &'a Bench;
    type Output = &'a Bench;

    fn lines(&self) -> Lines {
        self.bench.lines.get()
    }

    fn servo(&mut self) -> (&mut Self::Sensor, &mut Self::Output) {
        (&mut self.sensor, &mut self.actuator)
    }

    fn home_switch_is_closed(&self) -> bool {
        let place = self.bench.plant.borrow().position;
        self.bench.home_switch.borrow().contains(&place)
    }

    fn index(&mut self) -> Option<i32> {
        self.bench.index.take()
    }

    fn steps(&mut self) -> Option<i16> {
        self.bench.steps.replace(Some(0))
    }

    fn set_brake(&mut self, open: bool) {
        let is_held = self.bench.held.get().is_some();
        assert!(is_held || !open, "nothing holds the axis");
        self.bench.brake_power.set(open);
    }

    fn next_is_due(&self) -> bool {
        self.bench.late.get()
    }

    fn feed_watchdog(&mut self) {
        self.bench.fed.set(self.bench.fed.get() + 1);
    }

    fn cycles(&self) -> u32 {
        let [now, taken] = self.bench.cycles.get();
        self.bench.cycles.set([now.wrapping_add(taken), taken]);
        now
    }
}

impl PositionSensor for &Bench {
    type Error = ();

    fn count(&mut self) -> Result<i32, ()> {
        if !self.sensor_works.get() {
            return Err(());
        }
        let moved = if self.connected.get() {
            self.encoder.read(self.plant.borrow().position) as i32
        } else {
            self.flicker.get()
        };
        Ok(self.first.get().wrapping_add(moved))
    }
}

impl Actuator<f32> for &Bench {
    type Error = ();

    fn hold(&mut self, command: f32) -> Result<(), ()> {
        self.held.set(Some(command));
        if self.stage_works.get() {
            Ok(())
        } else {
            Err(())
        }
    }

    fn release(&mut self) -> Result<(), ()> {
        self.held.set(None);
        self.brake_power.set(false);
        if self.releases.get() { Ok(()) } else { Err(()) }
    }
}
