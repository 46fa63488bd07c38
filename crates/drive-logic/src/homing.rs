//! The motion to the home position: to a switch, off it slowly, and to the switch's edge or the index pulse behind it.

use drive_link::{Fault, NotAllowed, Settings};
use identifier_core::error::Allowed;
use identifier_core::number::Number;
use identifier_core::units::Units;

use crate::chip::Chip;
use crate::index_watch::Revolutions;
use crate::limits::AllowedRange;
use crate::reference::{Dither, Reference};
use crate::time::samples;

/// The time for which the switch must keep a level, s: contacts bounce.
const DEBOUNCE: f64 = 2e-3;

/// Clearances within which the switch closes again when the axis has just driven off it.
const CLEARANCES_OF_APPROACH: i32 = 2;

/// Part of a revolution in which an index pulse must come: one revolution, and a little for the filters.
const REVOLUTIONS_TO_INDEX: f64 = 1.05;

/// The way home of one axis, with its progress. Speeds are in counts per sample, distances in counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Homing {
    /// Towards the switch, 1 or −1.
    direction: i32,
    seek: f32,
    approach: f32,
    clearance: i32,
    /// Where targets may be, from the origin.
    reach: [i32; 2],
    /// The largest distance to the index pulse, if that is the home position.
    to_index: Option<i32>,
    revolutions: Revolutions,
    /// The distance of the index pulse from the switch's edge.
    from_edge: Option<i32>,
    offset: i32,
    phase: Phase,
    switch: Switch,
    /// Suspended on the way.
    dither: Option<Dither>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Not on its way.
    Idle,
    /// Towards the switch.
    Seek,
    /// Off the switch, slowly.
    Leave,
    /// Back to the switch's edge, slowly.
    Approach,
    /// On to the index pulse, slowly.
    Index {
        /// The count of the switch's edge.
        edge: i32,
    },
    /// To the home position.
    Settle {
        /// Its count.
        home: i32,
    },
}

/// The home switch without its bounces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Switch {
    is_closed: bool,
    /// Samples for which it has had the other level, and those that make it change.
    changed: u32,
    needed: u32,
    /// The count at which the other level began.
    edge: i32,
}

impl Homing {
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(settings: &Settings, units: &Units) -> Result<Option<Self>, NotAllowed> {
        let Some(given) = &settings.homing else {
            return Ok(None);
        };
        let (reach, most) = (
            AllowedRange::of_targets(settings),
            settings.protection.speed,
        );
        let [low, high] = reach.ends();
        let (seek, half) = (given.seek.abs(), reach.width() / 2.0);
        Allowed::PositiveUpTo(most).check("homing.seek", seek)?;
        Allowed::PositiveUpTo(seek).check("homing.approach", given.approach)?;
        Allowed::PositiveUpTo(half).check("homing.clearance", given.clearance)?;
        // The home position is within the travel, as seen from the origin.
        Allowed::Within(-high, -low).check("homing.offset", given.offset)?;
        // Distances are within the travel, which is within what 32 bits hold.
        let counts = |radians: f64| (radians * units.position()) as i32;
        let speed = |speed: f64| f32::from_f64(speed * units.velocity());
        let revolution = core::f64::consts::TAU * REVOLUTIONS_TO_INDEX;
        Ok(Some(Self {
            direction: if given.seek > 0.0 { 1 } else { -1 },
            seek: speed(given.seek.abs()),
            approach: speed(given.approach),
            clearance: counts(given.clearance).max(1),
            reach: reach.counts(units),
            to_index: given.index.then(|| counts(revolution)),
            revolutions: Revolutions::new(units),
            from_edge: None,
            offset: counts(given.offset),
            phase: Phase::Idle,
            switch: Switch {
                is_closed: false,
                changed: 0,
                needed: samples(DEBOUNCE, units),
                edge: 0,
            },
            dither: None,
        }))
    }

    /// The distance of the index pulse from the edge of the home switch, counts, if this run has found both.
    pub(crate) fn index_from_edge(&self) -> Option<i32> {
        self.from_edge
    }

    /// True if the home position is an index pulse.
    pub(crate) fn has_index(&self) -> bool {
        self.to_index.is_some()
    }

    /// Checks a pulse of an axis with this origin.
    ///
    /// # Errors
    /// [`Fault::IndexShifted`].
    pub(crate) fn check_pulse(&self, pulse: i32, origin: i32) -> Result<(), Fault> {
        let home = origin.wrapping_sub(self.offset);
        self.revolutions.check_pulse(pulse, home)
    }

    /// True on the way.
    pub(crate) fn is_under_way(&self) -> bool {
        self.phase != Phase::Idle
    }

    /// Begins with the switch in its present state.
    pub(crate) fn begin(
        &mut self,
        is_closed: bool,
        count: i32,
        origin: i32,
        reference: &mut Reference,
    ) {
        self.dither = reference.take_dither();
        self.switch = Switch {
            is_closed,
            changed: 0,
            ..self.switch
        };
        if is_closed {
            self.leave(count, origin, reference);
        } else {
            self.phase = Phase::Seek;
            let [low, high] = self.reach;
            let end = if self.direction > 0 { high } else { low };
            reference.send_at(origin.wrapping_add(end), self.seek);
        }
    }

    /// A sample that ended at a count; the origin that was found, if it is the last one.
    ///
    /// # Errors
    /// The fault by which it ends.
    pub(crate) fn step<C: Chip>(
        &mut self,
        chip: &mut C,
        count: i32,
        origin: i32,
        reference: &mut Reference,
    ) -> Result<Option<i32>, Fault> {
        let edge = self.switch.edge(chip.home_switch_is_closed(), count);
        let arrived = reference.has_arrived();
        let is_closed = self.switch.is_closed;
        match self.phase {
            Phase::Idle => {}
            Phase::Seek if is_closed => self.leave(count, origin, reference),
            Phase::Leave if !is_closed => {
                let here = edge.unwrap_or(count);
                if let Some(to_index) = self.to_index {
                    // One on the switch does not count.
                    let _ = chip.index();
                    self.phase = Phase::Index { edge: here };
                    self.send(here, -self.direction * to_index, origin, reference);
                } else {
                    self.phase = Phase::Approach;
                    let way = self.clearance.saturating_mul(CLEARANCES_OF_APPROACH);
                    self.send(here, self.direction * way, origin, reference);
                }
            }
            Phase::Approach if is_closed => self.settle(edge.unwrap_or(count), reference),
            Phase::Index { edge } => match chip.index() {
                Some(home) => {
                    let from_edge = home.wrapping_sub(edge);
                    self.from_edge = Some(from_edge);
                    self.revolutions.check_home(from_edge)?;
                    self.settle(home, reference);
                }
                None if arrived => return Err(Fault::IndexNotFound),
                None => {}
            },
            Phase::Settle { home } if arrived => {
                self.phase = Phase::Idle;
                reference.resume_dither(self.dither.take());
                return Ok(Some(home.wrapping_add(self.offset)));
            }
            Phase::Seek | Phase::Approach if arrived => return Err(Fault::HomeNotFound),
            Phase::Leave if arrived => return Err(Fault::HomeSwitchStuck),
            Phase::Seek | Phase::Leave | Phase::Approach | Phase::Settle { .. } => {}
        }
        Ok(None)
    }

    fn leave(&mut self, count: i32, origin: i32, reference: &mut Reference) {
        self.phase = Phase::Leave;
        self.send(count, -self.direction * self.clearance, origin, reference);
    }

    fn settle(&mut self, home: i32, reference: &mut Reference) {
        self.phase = Phase::Settle { home };
        reference.send_at(home, self.approach);
    }

    /// Sends the axis slowly by a way from a count, within the travel.
    fn send(&self, count: i32, way: i32, origin: i32, reference: &mut Reference) {
        let from_origin = count.wrapping_sub(origin).saturating_add(way);
        // Not `clamp`, which panics on a range that is none.
        let [low, high] = self.reach;
        let target = from_origin.min(high).max(low);
        reference.send_at(origin.wrapping_add(target), self.approach);
    }
}

impl Switch {
    /// A sample at a count: the count of the edge, if the switch has changed.
    fn edge(&mut self, is_closed: bool, count: i32) -> Option<i32> {
        if is_closed == self.is_closed {
            self.changed = 0;
            return None;
        }
        if self.changed == 0 {
            self.edge = count;
        }
        self.changed += 1;
        if self.changed < self.needed {
            return None;
        }
        (self.is_closed, self.changed) = (is_closed, 0);
        Some(self.edge)
    }
}
