//! The sources of a run's reference besides the targets of the host: homing, and commands from outside.

use drive_link::{Fault, Home, NotAllowed, Settings};
use identifier_core::units::Units;

use crate::chip::Chip;
use crate::homing::Homing;
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

    /// The same once the run has ended.
    pub(crate) fn after_run(self) -> Self {
        match self {
            Self::Found(_) => self,
            Self::Start | Self::Sought => Self::Start,
        }
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
        })
    }

    /// The origin.
    pub(crate) fn origin(&self) -> Origin {
        self.origin
    }

    /// Continues with the origin of a run before.
    pub(crate) fn set_origin(&mut self, origin: Origin) {
        self.origin = origin.after_run();
    }

    /// Begins a run at a count.
    pub(crate) fn begin(&mut self, count: i32) {
        if let Some(outside) = &mut self.outside {
            outside.begin(count);
        }
    }

    /// True if the host may send targets.
    pub(crate) fn takes_targets(&self) -> bool {
        !self.is_active
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
            if core::mem::replace(&mut self.begins_homing, false) {
                homing.begin(chip.home_switch_is_closed(), count, origin, reference);
                return Ok(None);
            }
            let Some(found) = homing.step(chip, count, origin, reference)? else {
                return Ok(None);
            };
            self.origin = Origin::Found(found);
            self.is_active = self.outside.is_some();
            reference.resume_pace();
            if let Some(outside) = &mut self.outside {
                outside.begin(reference.target());
            }
            return Ok(Some(found));
        }
        if let Some(outside) = &mut self.outside {
            outside.follow(chip, origin, reference)?;
        }
        Ok(None)
    }
}
