//! The host's own estimates, from the telemetry. The core's Gauss–Newton in double precision runs beside the drive, for
//! any estimator of the drive. It gives standard errors while the servo moves.

use drive_link::{Estimates, Settings};
use identifier_core::identifier::{GaussNewtonIdentifier, Identify};
use identifier_core::parameters::Unknowns;

use super::frame::Frame;
use super::telemetry::Order;

type Identifier = GaussNewtonIdentifier<f64, Unknowns<4>, 4>;
type State = <Identifier as Identify<f64>>::State;

/// An identifier that receives every sample.
#[derive(Debug)]
pub(super) struct HostIdentifier {
    identifier: Identifier,
    state: State,
    /// A count, rad.
    resolution: f64,
    /// The last count.
    count: i32,
    /// It joins the motion with the next sample.
    joins: bool,
}

impl HostIdentifier {
    /// For a loop with these settings; `None` if nothing can be identified with its sample time and encoder.
    pub(super) fn to(settings: &Settings) -> Option<Self> {
        let core = settings.closed_loop.core;
        // The drive's initial values do not enter.
        let core = identifier_core::Settings {
            resolution: core.resolution,
            ..identifier_core::Settings::new(core.sample_time, 1.0)
        };
        let identifier: Identifier = core.build().ok()?;
        Some(Self {
            state: identifier.start(),
            identifier,
            resolution: core.resolution,
            count: 0,
            joins: false,
        })
    }

    /// Takes the frame of every sample. A motion that is not received from its beginning, or with a gap, is joined as
    /// soon as two samples give its velocity. The estimates are kept.
    pub(super) fn take(&mut self, frame: &Frame, order: Order) {
        // Exact as long as single precision distinguishes one count from the next.
        let count = (frame.position() / self.resolution).round() as i32;
        let before = std::mem::replace(&mut self.count, count);
        let moved = match order {
            Order::Follows => count.wrapping_sub(before),
            // A motion begins where its position is zero.
            Order::Begins if frame.sample() == 1 => count,
            Order::Begins | Order::FollowsLost(_) => {
                self.joins = true;
                return;
            }
        };
        if order == Order::Begins || self.joins {
            self.joins = false;
            self.identifier
                .resume_moving(&mut self.state, f64::from(moved));
        }
        let command = frame.command().unwrap_or(0.0);
        if self
            .identifier
            .process(&mut self.state, moved, command)
            .is_err()
        {
            self.joins = true;
        }
        self.identifier.work(&mut self.state, u32::MAX);
    }

    /// The estimates with their standard errors, once there is a fit.
    pub(super) fn estimates(&self) -> Option<Estimates> {
        let standard_errors = self.identifier.report(&self.state).errors_of_parameters()?;
        let found = self.identifier.estimates(&self.state)?;
        (found.b > 0.0).then(|| Estimates {
            servo: found,
            at_bounds: self
                .identifier
                .at_bounds_in(&self.identifier.snapshot(&self.state)),
            standard_errors: Some(standard_errors),
            terms: None,
        })
    }
}
