//! What the background reports.

use drive_link::{PROTOCOL, Progress, Report, Snapshot, Status};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::commission::IdentifiedServo;

use super::Supervisor;
use crate::closed_loop::Learnt;
use crate::messages::{Event, Moved, Returned, Shown, Standing};
use crate::run::Run;
use crate::spare::Spare;

impl<F: NorFlash> Supervisor<'_, F> {
    /// Takes note of a sample that was told and found no room on the line.
    pub fn unsaid(&mut self) {
        self.unsaid = self.unsaid.saturating_add(1);
    }

    /// Takes note of a frame that was not understood.
    pub fn garbled(&mut self) {
        self.garbled = self.garbled.saturating_add(1);
    }

    /// The next thing that the interrupt tells, as a report.
    pub fn news(&mut self) -> Option<Report> {
        Some(match self.channel.event()? {
            Event::Shown(shown) => Report::Snapshot(self.snapshot(&shown)),
            Event::Moved(moved) => Report::Progress(self.progress(&moved)),
            Event::Standing(standing) => {
                let fault = standing.fault;
                self.take_note(standing);
                match fault {
                    Some(fault) => Report::Fault(fault),
                    None => self.status(None),
                }
            }
        })
    }

    fn take_note(&mut self, standing: Standing) {
        self.counts = standing.counts;
        self.fault = standing.fault;
        self.ended = standing.ended;
        self.stops = standing.stops;
        self.phase = standing.phase.unwrap_or(self.phase);
        self.waits = standing.waits;
        match standing.returned {
            Some(Returned::Run(run)) => {
                if run.has_run() {
                    self.take_in_all(run);
                }
                self.spare = Some(Spare::Used(run));
                self.keep_what_is_due();
            }
            Some(Returned::Commissioning(over)) => self.conclude(over),
            None => {}
        }
    }

    pub(super) fn status(&self, id: Option<u8>) -> Report {
        let status = Status {
            protocol: PROTOCOL,
            state: self.state(),
            kept: self.kept,
            configured: self.configured,
            ended: self.ended,
            commissioning: self.commissioning_stands(),
            gains: self.gains(),
            command_delay: self.stage.command_delay as f32,
            estimates: self.estimates,
            noticed: self.counts.noticed,
            overruns: self.counts.overruns,
            dropped: self.counts.dropped.saturating_add(self.unsaid),
            garbled: self.garbled,
        };
        Report::Status { id, status }
    }

    fn snapshot(&mut self, shown: &Shown) -> Snapshot {
        let resolution = self.settings.closed_loop.core.resolution;
        let radians = |counts: f64| (counts * resolution) as f32;
        self.take_in(&shown.learnt);
        self.counts = shown.counts;
        Snapshot {
            sample: shown.sample,
            reference: radians(f64::from(shown.count) + f64::from(shown.error)),
            position: radians(f64::from(shown.count)),
            command: shown.command,
            output_error: radians(f64::from(shown.output_error)),
            estimates: self.estimates.unwrap_or_default(),
        }
    }

    fn take_in(&mut self, learnt: &Learnt) {
        let closed_loop = self.closed_loop.as_ref();
        let found = closed_loop.and_then(|closed_loop| closed_loop.estimates(learnt));
        self.estimates = found.or(self.estimates);
    }
    /// What a run that has ended has learnt, with its standard errors.
    fn take_in_all(&mut self, run: &Run) {
        self.take_in(&run.closed_loop().learnt());
        if let Some(estimates) = &mut self.estimates {
            estimates.standard_errors = run.closed_loop().standard_errors();
        }
    }

    fn progress(&self, moved: &Moved) -> Progress {
        let resolution = self.settings.closed_loop.core.resolution;
        let gain = |servo: &IdentifiedServo| {
            let error = servo.standard_error(IdentifiedServo::B);
            [servo.parameters.b as f32, error as f32]
        };
        Progress {
            phase: moved.phase,
            sample: moved.sample,
            position: (f64::from(moved.count) * resolution) as f32,
            command: moved.command,
            recorded: moved.recorded,
            gain: self.studying.servo().map(gain),
        }
    }
}
