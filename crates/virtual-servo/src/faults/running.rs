use identifier_core::error::{Allowed, OutOfRange};

use super::{FaultKind, InjectedFault};
use crate::Servo;

/// Faults as they come and go, from sample to sample.
#[derive(Debug, Clone)]
pub struct Faults {
    faults: [Option<InjectedFault>; Self::MAX_FAULTS],
    sample_time: f64,
    /// Position of a count, rad.
    resolution: f64,
    samples: u64,
    now: Condition,
    encoder: Encoder,
    /// The command that acted last.
    last: f64,
}

/// The failures in force in a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// The sample before ended too late.
    pub late: bool,
    /// A limit switch is open.
    pub limit_switch: bool,
    /// The amplifier reports a fault.
    pub amplifier_fault: bool,
    /// The share of the command that acts.
    command: f64,
    /// The load that is there in addition, rad/s².
    load: f64,
    /// The Coulomb friction that is there in addition, rad/s².
    coulomb: f64,
    /// The encoder can be read.
    readable: bool,
    /// The motion that the encoder shows: all, none, or its opposite.
    turn: f64,
    /// The counts that it jumps.
    jump: f64,
}

/// An encoder that may count wrongly: it shows `turn` times the position, and `offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Encoder {
    turn: f64,
    /// Rad.
    offset: f64,
    /// The position before, rad.
    position: f64,
}

impl Condition {
    /// Nothing is wrong.
    pub const SOUND: Self = Self {
        late: false,
        limit_switch: false,
        amplifier_fault: false,
        command: 1.0,
        load: 0.0,
        coulomb: 0.0,
        readable: true,
        turn: 1.0,
        jump: 0.0,
    };

    fn suffer(&mut self, fault: &InjectedFault, begins: bool) {
        let size = fault.size;
        match fault.kind {
            FaultKind::EncoderStuck => self.turn = 0.0,
            FaultKind::EncoderLost => self.readable = false,
            FaultKind::EncoderJump if begins => self.jump += size,
            FaultKind::EncoderJump => {}
            FaultKind::EncoderReversed => self.turn = -self.turn,
            FaultKind::ActuatorDead => self.command = 0.0,
            FaultKind::ActuatorWeak => self.command *= size,
            FaultKind::ActuatorReversed => self.command = -self.command,
            FaultKind::LoadStep => self.load += size,
            FaultKind::FrictionRise => self.coulomb += size,
            FaultKind::Overrun => self.late = true,
            FaultKind::LimitSwitch => self.limit_switch = true,
            FaultKind::AmplifierFault => {
                self.amplifier_fault = true;
                self.command = 0.0;
            }
        }
    }
}

impl Faults {
    /// The most that there can be.
    pub const MAX_FAULTS: usize = 16;

    /// The faults of a servo that moves in steps of `sample_time` (s). A count of its encoder is `resolution` (rad).
    ///
    /// # Errors
    /// The value that is not allowed; of more than [`Faults::MAX_FAULTS`] faults, their number.
    pub fn new(
        faults: &[InjectedFault],
        sample_time: f64,
        resolution: f64,
    ) -> Result<Self, OutOfRange> {
        let mut kept = [None; Self::MAX_FAULTS];
        Allowed::AtMost(Self::MAX_FAULTS as f64).check("faults", faults.len() as f64)?;
        for (place, fault) in kept.iter_mut().zip(faults) {
            fault.check()?;
            *place = Some(*fault);
        }
        Ok(Self {
            faults: kept,
            sample_time,
            resolution,
            samples: 0,
            now: Condition::SOUND,
            encoder: Encoder {
                turn: 1.0,
                offset: 0.0,
                position: 0.0,
            },
            last: 0.0,
        })
    }

    /// The failures of the sample that begins. A load and a friction begin to act on the servo.
    pub fn begin_sample(&mut self, servo: &mut Servo) -> Condition {
        let mut now = Condition::SOUND;
        for fault in self.faults.iter().flatten() {
            let begins = self.sample_at(fault.time);
            let ends = self.sample_at(fault.time + fault.duration);
            if self.samples >= begins && self.samples < ends {
                now.suffer(fault, self.samples == begins);
            }
        }
        self.samples += 1;
        if (now.load, now.coulomb) != (self.now.load, self.now.coulomb) {
            servo.disturb(now.load, now.coulomb);
        }
        self.now = now;
        now
    }

    /// The first sample that is not before a time, s.
    fn sample_at(&self, time: f64) -> u64 {
        /// Rounding of a time, samples.
        const WHOLE_TOLERANCE: f64 = 1e-6;
        libm::ceil(time / self.sample_time - WHOLE_TOLERANCE) as u64
    }

    /// The position (rad) that the encoder shows of another; none if it cannot be read.
    pub fn seen(&mut self, position: f64) -> Option<f64> {
        let Condition { turn, jump, .. } = self.now;
        self.encoder.turn(turn);
        if jump != 0.0 {
            self.encoder.offset += jump * self.resolution;
        }
        self.encoder.position = position;
        self.now.readable.then(|| self.encoder.shown())
    }

    /// The command that acts if this one is given in this sample.
    pub fn acting(&mut self, command: f64) -> f64 {
        let given = if self.now.late { self.last } else { command };
        self.last = command;
        given * self.now.command
    }
}

impl Encoder {
    fn shown(&self) -> f64 {
        self.turn * self.position + self.offset
    }

    /// Shows the motion differently from its present position on.
    fn turn(&mut self, turn: f64) {
        if turn.to_bits() != self.turn.to_bits() {
            self.offset = self.shown() - turn * self.position;
            self.turn = turn;
        }
    }
}
