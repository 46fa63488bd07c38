//! The known state of a drive.

use std::time::{Duration, Instant};

use commissioning::Phase;
use drive_link::{Refusal, Report, Settings, State as Does, Status};

use super::frame::Frame;
use super::history::{History, Point};
use super::telemetry::Telemetry;

/// Delay of a frame after which telemetry is requested again.
const PATIENCE: Duration = Duration::from_secs(2);

/// The known state of a drive.
#[derive(Debug)]
pub struct State {
    /// Its port.
    pub(super) port: String,
    settings: Settings,
    status: Status,
    telemetry: Telemetry,
    /// Frames that the drive had dropped before.
    dropped_before: u32,
    /// Time of the last frame, or of the last request for frames.
    last_frame: Instant,
    pub(super) history: History,
    note: Option<Note>,
}

/// A message about a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Note {
    /// It was done.
    Done(String),
    /// It was not.
    Failed(String),
}

impl State {
    /// For a drive with these settings and this status, which sends a frame every `every` samples.
    #[must_use]
    pub fn new(port: &str, settings: Settings, status: Status, every: u16, now: Instant) -> Self {
        Self {
            port: port.to_owned(),
            settings,
            status,
            telemetry: Telemetry::every(every),
            dropped_before: status.dropped,
            last_frame: now,
            history: History::default(),
            note: None,
        }
    }

    /// Takes in a report; returns the frame in it.
    pub fn take(&mut self, report: &Report, now: Instant) -> Option<Frame> {
        match report {
            Report::Status { status, .. } => self.status = *status,
            Report::Settings { settings, .. } => self.settings = *settings,
            Report::Fault(fault) => self.status.state = Does::Faulted(*fault),
            _ => {}
        }
        let frame = Frame::from_report(report)?;
        self.last_frame = now;
        self.show(&frame);
        Some(frame)
    }

    fn show(&mut self, frame: &Frame) {
        if self.telemetry.take(frame) {
            self.history.begin();
        }
        if let Frame::Running(snapshot) = frame {
            // Before the first fit there is none.
            self.status.estimates = Some(snapshot.estimates).filter(|known| known.servo.b > 0.0);
        }
        let time = f64::from(frame.sample()) * self.sample_time();
        self.history.add(Point {
            time,
            frame: *frame,
        });
    }

    /// The drive should send telemetry and does not: it is to be requested again.
    pub fn is_telemetry_overdue(&mut self, now: Instant) -> bool {
        if !self.is_driven() {
            self.last_frame = now;
            return false;
        }
        let apart = f64::from(self.telemetry.samples_apart()) * self.sample_time();
        let silent =
            now.duration_since(self.last_frame) > PATIENCE + Duration::from_secs_f64(apart);
        if silent {
            self.last_frame = now;
            self.telemetry.resynchronise();
        }
        silent
    }

    /// Sets the message.
    pub fn set_note(&mut self, note: Note) {
        self.note = Some(note);
    }

    /// Clears the message.
    pub fn clear_note(&mut self) {
        self.note = None;
    }

    /// The last message.
    #[must_use]
    pub fn note(&self) -> Option<&Note> {
        self.note.as_ref()
    }

    /// The drive refused a command.
    pub fn was_refused(&mut self, refusal: &Refusal) {
        self.set_note(Note::Failed(format!("the drive refuses: {refusal}")));
    }

    /// The servo is driven.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        matches!(self.status.state, Does::Running | Does::Commissioning)
    }

    /// The settings, with the gains in force.
    #[must_use]
    pub fn settings(&self) -> Settings {
        let mut settings = self.settings;
        if let Some(gains) = self.status.gains {
            let core = &mut settings.closed_loop.core;
            (core.controller, core.cutoff) = (Some(gains.controller), gains.cutoff);
        }
        settings
    }

    /// Its status, with the newest estimates.
    #[must_use]
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// Frames that the drive dropped for want of room on its line, since the monitor began.
    pub(super) fn dropped(&self) -> u32 {
        self.status.dropped.wrapping_sub(self.dropped_before)
    }

    /// The received and lost frames.
    #[must_use]
    pub fn telemetry(&self) -> &Telemetry {
        &self.telemetry
    }

    /// s.
    #[must_use]
    pub fn sample_time(&self) -> f64 {
        self.settings.closed_loop.core.sample_time
    }

    /// Lowest and highest command, command units.
    pub(super) fn command_limit(&self) -> Option<[f64; 2]> {
        let controller = self.settings().closed_loop.core.controller?;
        Some(controller.limit).filter(|limit| limit.iter().all(|end| end.is_finite()))
    }

    /// The newest frame, and its time since the motion began, s.
    pub(super) fn newest(&self) -> Option<(f64, &Frame)> {
        self.history
            .newest()
            .map(|point| (point.time, &point.frame))
    }

    /// The phase of the commissioning, or of the last one.
    pub(super) fn phase(&self) -> Option<Phase> {
        match self.newest() {
            Some((_, Frame::Commissioning(progress)))
                if self.status.state == Does::Commissioning =>
            {
                Some(progress.phase)
            }
            _ => self.status.commissioning.map(|stands| stands.phase),
        }
    }

    /// The state of the servo and its reason, in words.
    #[must_use]
    pub fn reason(&self) -> String {
        let status = &self.status;
        match status.state {
            Does::Faulted(_) => self.status.state.to_string(),
            Does::Running => "the loop is closed, and the drive identifies".to_owned(),
            Does::Commissioning => match self.phase() {
                Some(phase) => format!("commissioning: {}", phase.name()),
                None => "the servo moves by itself".to_owned(),
            },
            Does::Disabled if !status.configured => {
                "the servo is disabled; the drive is not configured: `drive configure`".to_owned()
            }
            Does::Disabled => {
                let commissioned = status
                    .commissioning
                    .filter(|_| matches!(self.newest(), Some((_, Frame::Commissioning(_)))));
                match (commissioned, status.ended) {
                    (Some(stands), _) => format!("the servo is disabled; commissioning: {stands}"),
                    (None, Some(ended)) => format!("the servo is disabled; {ended}"),
                    (None, None) => "the servo is disabled, and the drive is ready".to_owned(),
                }
            }
        }
    }
}
