//! The reports of the background.

use drive_link::{Estimates, Fault, Progress, Report, Snapshot, Status};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;

use super::Supervisor;
use crate::closed_loop::Learnt;
use crate::guide::Origin;
use crate::messages::{Event, InterruptState, Mode};
use crate::run::Run;
use crate::telemetry::{CommissionSample, RunSample};

impl<F: NorFlash> Supervisor<'_, F> {
    /// Counts a sample that found no room on the line.
    pub fn count_dropped(&mut self) {
        self.reports_dropped = self.reports_dropped.saturating_add(1);
    }

    /// Counts a frame that could not be decoded.
    pub fn count_garbled(&mut self) {
        self.garbled = self.garbled.saturating_add(1);
    }

    /// The next event of the interrupt or of the first fit, as a report.
    pub fn next_report(&mut self) -> Option<Report> {
        loop {
            let Some(event) = self.channel.event() else {
                let rejection_reason = self.solver.rejection_reason();
                let before = core::mem::replace(&mut self.rejection_reason, rejection_reason);
                return (rejection_reason != before).then(|| self.status(None));
            };
            return Some(match event {
                Event::Run(sample) => Report::Snapshot(self.snapshot(&sample)),
                Event::Commissioning(sample) => Report::Progress(self.progress(&sample)),
                Event::Examined(examination) if self.take_in_examination(&examination) => {
                    self.status(None)
                }
                Event::Examined(_) => continue,
                Event::State(state) => {
                    let fault = state.fault;
                    self.take_in_state(state);
                    match fault {
                        Some(fault) => Report::Fault(fault),
                        None => self.status(None),
                    }
                }
            });
        }
    }

    #[inline(never)]
    fn take_in_state(&mut self, state: InterruptState) {
        self.counts = state.counts;
        self.fault = state.fault;
        self.ended = state.ended;
        self.stops = state.stops;
        self.closes_brake = state.closes_brake;
        self.phase = state.phase.unwrap_or(self.phase);
        self.awaits_resume = state.awaits_resume;
        self.origin = state.origin.unwrap_or(self.origin);
        self.index_from_edge = state.index_from_edge.or(self.index_from_edge);
        let has_returned = state.returned.is_some();
        match state.returned {
            Some(Mode::Run(run)) => {
                if run.has_run() {
                    self.take_in_all(run, state.fault);
                }
                self.origin = run.origin().after_run();
                self.index_from_edge = run.index_from_edge().or(self.index_from_edge);
                self.free(Mode::Run(run));
            }
            Some(Mode::Commissioning(over)) => self.conclude(over),
            None => {}
        }
        self.invalidate_position_after(state.fault);
        self.save_pending |= has_returned && self.has_unsaved_gains();
        self.save_if_pending();
    }

    /// The home position is unknown after a reason that loses the position.
    pub(super) fn invalidate_position_after(&mut self, reason: Option<Reason>) {
        if reason.is_some_and(Reason::loses_position) {
            self.origin = Origin::Start;
        }
    }

    #[inline(never)]
    pub(super) fn status(&self, id: Option<u8>) -> Report {
        let status = Status {
            state: self.state(),
            kept: self.kept,
            simulated: self.stage.is_simulated,
            configured: self.configured,
            order: self.orders.last(),
            ended: self.ended,
            commissioning: self.last_commissioning(),
            gains: self.gains(),
            command_delay: self.stage.command_delay as f32,
            home: self.origin.home(),
            index_from_edge: self
                .index_from_edge
                .map(|counts| (f64::from(counts) * self.resolution()) as f32),
            estimates: self.estimates,
            rejection_reason: self.solver.rejection_reason(),
            noise: self.solver.noise().map(|counts| counts as f32),
            servo_change: self.changes.reported().copied(),
            noticed: self.counts.noticed,
            overruns: self.channel.overruns(),
            dropped: self.counts.dropped.saturating_add(self.reports_dropped),
            garbled: self.garbled,
            boot: self.boot,
            disturbed: self.channel.disturbances(),
            interrupt_cycles: self.channel.interrupt_cycles(),
        };
        Report::Status { id, status }
    }

    fn snapshot(&mut self, sample: &RunSample) -> Snapshot {
        let resolution = self.settings.closed_loop.core.resolution;
        let radians = |counts: f64| (counts * resolution) as f32;
        self.take_in(&sample.learnt);
        self.counts = sample.counts;
        Snapshot {
            sample: sample.sample,
            reference: radians(f64::from(sample.count) + f64::from(sample.error)),
            position: radians(f64::from(sample.count)),
            command: sample.command,
            output_error: radians(f64::from(sample.output_error)),
            estimates: self.estimates.unwrap_or_default(),
        }
    }

    fn take_in(&mut self, learnt: &Learnt) {
        let identifier = self.identifier.as_ref();
        let found = identifier.and_then(|identifier| identifier.estimates(learnt));
        self.estimates = found
            .map(|found| self.with_errors(found))
            .or(self.estimates);
    }

    /// Estimates with the standard errors of the gradient's memory, if it is that of the run.
    fn with_errors(&self, found: Estimates) -> Estimates {
        let of_memory = || self.solver.standard_errors();
        Estimates {
            standard_errors: found.standard_errors.or_else(of_memory),
            ..found
        }
    }

    /// Takes in the estimates of a run that has ended, with their standard errors. What a run has learnt that ended by a
    /// fault is no knowledge: it may be of a jam.
    fn take_in_all(&mut self, run: &Run, fault: Option<Fault>) {
        self.estimates = match fault {
            None => {
                let found = run.closed_loop().all_estimates();
                found
                    .map(|found| self.with_errors(found))
                    .or(self.estimates)
            }
            Some(_) => self.known_before,
        };
    }

    fn progress(&self, sample: &CommissionSample) -> Progress {
        let resolution = self.settings.closed_loop.core.resolution;
        let gain = |servo: &IdentifiedServo| {
            let error = servo.standard_error(IdentifiedServo::B);
            [servo.parameters.b as f32, error as f32]
        };
        Progress {
            phase: sample.phase,
            sample: sample.sample,
            position: (f64::from(sample.count) * resolution) as f32,
            command: sample.command,
            recorded: sample.recorded,
            gain: self.solver.servo().map(gain),
        }
    }
}
