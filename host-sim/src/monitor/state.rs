//! What is known of a drive.

use std::time::{Duration, Instant};

use drive_link::{Estimates, Refusal, Report, Settings, State as Does, Status};
use identifier_core::commission::Phase;

use super::frame::{Frame, Kind};
use super::history::{History, Point};
use super::listening::Listening;
use super::telemetry::{Order, Telemetry};

/// How late a frame may be before the drive is asked for them anew.
const PATIENCE: Duration = Duration::from_secs(2);

/// What is known of a drive.
#[derive(Debug)]
pub struct State {
    /// Where it is.
    pub(super) port: String,
    settings: Settings,
    status: Status,
    telemetry: Telemetry,
    /// Frames that found no room on the line before.
    dropped_before: u32,
    /// When the drive was last asked for telemetry, or sent some.
    told: Instant,
    pub(super) history: History,
    listening: Option<Listening>,
    note: Option<Note>,
}

/// Something to be said about what happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Note {
    /// It was done.
    Done(String),
    /// It was not.
    Failed(String),
}

impl State {
    /// Of a drive with these settings that stands so, and that sends a frame every so many samples.
    #[must_use]
    pub fn new(port: &str, settings: Settings, status: Status, every: u16, now: Instant) -> Self {
        Self {
            port: port.to_owned(),
            settings,
            status,
            telemetry: Telemetry::every(every),
            dropped_before: status.dropped,
            told: now,
            history: History::default(),
            listening: Listening::to(&settings).filter(|_| every == 1),
            note: None,
        }
    }

    /// Takes in a report; a frame in it is the answer.
    pub fn take(&mut self, report: &Report, now: Instant) -> Option<Frame> {
        match report {
            Report::Status { status, .. } => self.status = *status,
            Report::Settings { settings, .. } => self.is_set(*settings),
            Report::Fault(fault) => self.status.state = Does::Faulted(*fault),
            _ => {}
        }
        let frame = Frame::of(report)?;
        self.told = now;
        self.show(&frame);
        Some(frame)
    }

    fn is_set(&mut self, settings: Settings) {
        let hears = |settings: &Settings| {
            let core = &settings.closed_loop.core;
            [core.sample_time, core.resolution].map(f64::to_bits)
        };
        if hears(&settings) != hears(&self.settings) {
            let hears_all = self.telemetry.samples_apart() == 1;
            self.listening = Listening::to(&settings).filter(|_| hears_all);
        }
        self.settings = settings;
    }

    fn show(&mut self, frame: &Frame) {
        let order = self.telemetry.take(frame);
        if order == Order::Begins {
            self.history.begin();
        }
        if let Some(listening) = &mut self.listening {
            listening.hear(frame, order);
        }
        if let Frame::Running(snapshot) = frame {
            // Before the first fit there is none.
            self.status.estimates = Some(snapshot.estimates).filter(|known| known.b > 0.0);
        }
        let time = f64::from(frame.sample()) * self.sample_time();
        self.history.add(Point {
            time,
            frame: *frame,
        });
    }

    /// Whether the drive should send telemetry and does not, and is to be asked anew.
    pub fn is_to_be_asked_again(&mut self, now: Instant) -> bool {
        if !self.is_driven() {
            self.told = now;
            return false;
        }
        let apart = f64::from(self.telemetry.samples_apart()) * self.sample_time();
        let silent = now.duration_since(self.told) > PATIENCE + Duration::from_secs_f64(apart);
        if silent {
            self.told = now;
            self.telemetry.begin_anew();
        }
        silent
    }

    /// What is to be said.
    pub fn say(&mut self, note: Note) {
        self.note = Some(note);
    }

    /// What was said is over.
    pub fn say_no_more(&mut self) {
        self.note = None;
    }

    /// What was said last.
    #[must_use]
    pub fn note(&self) -> Option<&Note> {
        self.note.as_ref()
    }

    /// The drive did not do what it was asked.
    pub fn was_refused(&mut self, refusal: &Refusal) {
        self.say(Note::Failed(format!("the drive refuses: {refusal}")));
    }

    /// Whether something drives the servo.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        matches!(self.status.state, Does::Running | Does::Commissioning)
    }

    /// The settings that hold.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// How it stands, with the newest estimates.
    #[must_use]
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// Frames for which the drive found no room on its line since somebody looks on.
    pub(super) fn unsaid(&self) -> u32 {
        self.status.dropped.wrapping_sub(self.dropped_before)
    }

    /// The frames that came.
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
        let held = self.status.gains.map(|gains| gains.controller);
        let controller = held.or(self.settings.closed_loop.core.controller)?;
        Some(controller.limit).filter(|limit| limit.iter().all(|end| end.is_finite()))
    }

    /// The newest frame, and when in its motion it was, s.
    pub(super) fn newest(&self) -> Option<(f64, &Frame)> {
        self.history
            .newest()
            .map(|point| (point.time, &point.frame))
    }

    /// What the host found by itself.
    pub(super) fn estimates_here(&self) -> Option<Estimates> {
        self.listening.as_ref().and_then(Listening::estimates)
    }

    /// Whether every sample is heard, so that the host can learn, too.
    pub(super) fn hears_all(&self) -> bool {
        self.listening.is_some()
    }

    /// Where a commissioning stands, or stood.
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

    /// What the servo does, and why, in words.
    #[must_use]
    pub fn reason(&self) -> String {
        let status = &self.status;
        match status.state {
            Does::Faulted(fault) => fault.to_string(),
            Does::Running => "the loop is closed, and the drive learns".to_owned(),
            Does::Commissioning => match self.phase() {
                Some(phase) => format!("commissioning: {}", phase.name()),
                None => "it moves on its own".to_owned(),
            },
            Does::Released if !status.configured => {
                "the servo is let go; nobody has told the drive yet what it is: `drive configure`"
                    .to_owned()
            }
            Does::Released => {
                let commissioned = status.commissioning.filter(|_| {
                    matches!(self.newest(), Some((_, frame)) if frame.kind() == Kind::Commissioning)
                });
                match (commissioned, status.ended) {
                    (Some(stands), _) => format!("the servo is let go; commissioning: {stands}"),
                    (None, Some(ended)) => format!("the servo is let go; {ended}"),
                    (None, None) => "the servo is let go, and everything is ready".to_owned(),
                }
            }
        }
    }
}
