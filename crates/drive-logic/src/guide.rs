//! The sources of a run's reference besides the targets of the host: homing, and commands from outside.

use drive_link::{Fault, Home, NotAllowed, Refusal, Settings};
use identifier_core::units::Units;

use crate::chip::Chip;
use crate::homing::Homing;
use crate::limits::AllowedRange;
use crate::outside::Outside;
use crate::reference::Reference;

/// The origin of targets and travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Origin {
    /// Where the run started.
    Start,
    /// The axis is on its way home.
    Sought,
    /// Homing has found it at this count.
    Found(i32),
}

impl Origin {
    /// The same for the host.
    pub(crate) fn home(self) -> Home {
        match self {
            Self::Start => Home::Unknown,
            Self::Sought => Home::Sought,
            Self::Found(_) => Home::Known,
        }
    }

    /// The place from which targets of the host count, of a run that began at this count. Targets from home exist only
    /// once it is known, on an axis that has one.
    ///
    /// # Errors
    /// [`Refusal::Homing`] or [`Refusal::NotHomed`].
    pub(crate) fn base(self, from: TargetsFrom, start: i32) -> Result<TargetBase, Refusal> {
        let offset = match (self, from) {
            (Self::Sought, _) => return Err(Refusal::Homing),
            (Self::Start, TargetsFrom::Home) => return Err(Refusal::NotHomed),
            // The origin is where the run started.
            (Self::Start, TargetsFrom::Start) | (Self::Found(_), TargetsFrom::Home) => 0,
            (Self::Found(home), TargetsFrom::Start) => start.wrapping_sub(home),
        };
        Ok(TargetBase { offset })
    }

    /// The same once the run has ended.
    pub(crate) fn after_run(self) -> Self {
        match self {
            Self::Found(_) => self,
            Self::Start | Self::Sought => Self::Start,
        }
    }
}

/// What the targets of the host count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TargetsFrom {
    /// The origin behind the home position.
    Home,
    /// The place where the run started.
    Start,
}

/// A place from which targets count, in a run. Only [`Origin::base`] makes one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TargetBase {
    /// Counts from the origin.
    offset: i32,
}

impl TargetBase {
    /// A target at a distance, rad, of positions of this resolution, within a range, rad from the origin.
    ///
    /// # Errors
    /// [`Refusal::TooFar`].
    pub(crate) fn target(
        self,
        radians: f64,
        resolution: f64,
        reach: AllowedRange,
    ) -> Result<Target, Refusal> {
        let reach = reach.seen_from(f64::from(self.offset) * resolution);
        if !reach.contains(radians) {
            return Err(Refusal::TooFar {
                within: reach.ends(),
            });
        }
        // Within what 32 bits hold, as the travel is.
        let counts = (radians / resolution) as i32;
        Ok(Target {
            from_origin: self.offset.wrapping_add(counts),
        })
    }
}

/// A target within the travel, from a place that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Target {
    /// Counts from the origin of the run.
    from_origin: i32,
}

impl Target {
    /// Counts from the origin of the run.
    pub(crate) fn counts(self) -> i32 {
        self.from_origin
    }
}

/// Guides the reference of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Guide {
    homing: Option<Homing>,
    outside: Option<Outside>,
    origin: Origin,
    /// Homing was ordered, and begins with the next sample.
    begins_homing: bool,
    /// There is something to do in a sample.
    is_active: bool,
    /// The last index pulse may be older than the run.
    is_fresh: bool,
}

impl Guide {
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(settings: &Settings, units: &Units) -> Result<Self, NotAllowed> {
        let outside = Outside::new(settings, units)?;
        Ok(Self {
            homing: Homing::new(settings, units)?,
            origin: Origin::Start,
            begins_homing: false,
            is_active: outside.is_some(),
            outside,
            is_fresh: true,
        })
    }

    /// The origin.
    pub(crate) fn origin(&self) -> Origin {
        self.origin
    }

    /// Continues with the origin of a run before.
    pub(crate) fn set_origin(&mut self, origin: Origin) {
        self.origin = origin.after_run();
        self.is_active |= self.watches_index();
    }

    /// True if index pulses are to be compared with home.
    fn watches_index(&self) -> bool {
        let has_index = self.homing.as_ref().is_some_and(Homing::has_index);
        has_index && matches!(self.origin, Origin::Found(_))
    }

    /// The distance of the index pulse from the edge of the home switch, counts, if this run has found both.
    pub(crate) fn index_from_edge(&self) -> Option<i32> {
        self.homing.as_ref()?.index_from_edge()
    }

    /// Begins a run at a count.
    pub(crate) fn begin(&mut self, count: i32) {
        self.is_fresh = true;
        if let Some(outside) = &mut self.outside {
            outside.begin(count);
        }
    }

    /// Continues a run at a count; `missed` steps came meanwhile.
    pub(crate) fn resume(&mut self, count: i32, missed: bool) {
        if let Some(outside) = &mut self.outside {
            outside.resume(count, missed);
        }
    }

    /// True if the host may send targets.
    pub(crate) fn takes_targets(&self) -> bool {
        self.outside.is_none() && self.origin != Origin::Sought
    }

    /// Begins the way home with the next sample, if there is one.
    pub(crate) fn home(&mut self) {
        if let Some(homing) = &self.homing
            && !homing.is_under_way()
        {
            self.origin = Origin::Sought;
            (self.begins_homing, self.is_active) = (true, true);
        }
    }

    /// Has the next sample be no idle one.
    pub(crate) fn activate(&mut self) {
        self.is_active = true;
    }

    /// True if there is nothing to do.
    #[inline]
    pub(crate) fn is_idle(&self) -> bool {
        !self.is_active
    }

    /// A sample that ended at a count, after which the reference may change. The result is the count of the origin, if
    /// it was found.
    ///
    /// # Errors
    /// The fault by which the run ends.
    #[cold]
    #[inline(never)]
    pub(crate) fn step<C: Chip>(
        &mut self,
        chip: &mut C,
        count: i32,
        origin: i32,
        reference: &mut Reference,
    ) -> Result<Option<i32>, Fault> {
        if reference.stays() {
            return Ok(None);
        }
        if let Some(homing) = &mut self.homing
            && self.origin == Origin::Sought
        {
            if reference.waits() {
                return Ok(None);
            }
            if core::mem::replace(&mut self.begins_homing, false) {
                homing.begin(chip.home_switch_is_closed(), count, origin, reference);
                return Ok(None);
            }
            let Some(found) = homing.step(chip, count, origin, reference)? else {
                return Ok(None);
            };
            self.origin = Origin::Found(found);
            self.is_active = self.outside.is_some() || self.watches_index();
            reference.resume_pace();
            if let Some(outside) = &mut self.outside {
                outside.begin(reference.target());
            }
            return Ok(Some(found));
        }
        if let Some(homing) = &self.homing
            && self.watches_index()
            && let Some(pulse) = chip.index()
            // One from before the run may be of another turn of the counter.
            && !core::mem::replace(&mut self.is_fresh, false)
        {
            homing.check_pulse(pulse, origin)?;
        }
        self.is_fresh = false;
        if let Some(outside) = &mut self.outside {
            outside.follow(chip, origin, reference)?;
        }
        Ok(None)
    }
}
