//! From keys to commands, and from reports to the screen.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use drive_link::{Command, Report, Settings, State as Does, Status};

use super::recordings::Recordings;
use super::screen::Screen;
use crate::cli::drive::plan::DrivePlan;
use crate::cli::fault::Fault;
use crate::drive::AtEnd;
use crate::monitor::{Action, Dialogue, Link, LinkError, LinkEvent, Motion, Note, Shown, State};
use crate::present::largest_motion;

/// Time between two drawings of the screen.
const REDRAW: Duration = Duration::from_millis(50);

/// A running monitor.
pub(super) struct Session {
    pub(super) state: State,
    pub(super) link: Link,
    pub(super) recordings: Recordings,
    dialogue: Dialogue,
    plan: Option<DrivePlan>,
    /// The largest motion of a commissioning, in words.
    largest_motion: Option<String>,
}

/// Why it ended without being asked to.
pub(super) enum End {
    /// The drive is lost.
    Lost(LinkError),
    /// The terminal is lost.
    Screen(io::Error),
}

impl From<io::Error> for End {
    fn from(error: io::Error) -> Self {
        Self::Screen(error)
    }
}

impl Session {
    pub(super) fn new(
        port: &str,
        settings: Settings,
        status: Status,
        every: u16,
        link: Link,
        recordings: Recordings,
        plan: Option<DrivePlan>,
    ) -> Self {
        link.order(Command::Watch(every));
        Self {
            state: State::new(port, settings, status, every, Instant::now()),
            link,
            recordings,
            dialogue: Dialogue::default(),
            largest_motion: (plan.as_ref()).map(|plan| largest_motion(&plan.largest_motion)),
            plan,
        }
    }

    /// Shows the drive and takes keys until an end is requested.
    pub(super) fn run(
        &mut self,
        screen: &mut Screen,
        end_requested: &AtomicBool,
        at_end: AtEnd,
    ) -> Result<(), End> {
        loop {
            self.take_events()?;
            screen.show(&Shown {
                state: &self.state,
                dialogue: &self.dialogue,
                recording: self.recordings.under_way(),
                commission: self.largest_motion.as_deref(),
                leaves: at_end == AtEnd::Leave,
            })?;
            let until = Instant::now() + REDRAW;
            loop {
                if end_requested.load(Ordering::Relaxed) {
                    return Ok(());
                }
                let left = until.saturating_duration_since(Instant::now());
                let Some(key) = screen.key(left)? else { break };
                match self.dialogue.press(key, self.state.is_driven()) {
                    Some(Action::Quit) => return Ok(()),
                    Some(action) => self.act(action),
                    None => {}
                }
                if left.is_zero() {
                    break;
                }
            }
        }
    }

    /// Takes in the reports and answers.
    fn take_events(&mut self) -> Result<(), End> {
        let now = Instant::now();
        while let Some(event) = self.link.next_event() {
            match event {
                LinkEvent::Report(report) => self.take(&report, now),
                LinkEvent::Done(command) => self.was_done(&command),
                LinkEvent::Refused(refusal) => self.state.was_refused(&refusal),
                LinkEvent::Unanswered(command) => self.state.set_note(Note::Failed(format!(
                    "the drive does not answer; it may or may not have done this: {}",
                    name(&command)
                ))),
                LinkEvent::Lost(error) => return Err(End::Lost(error)),
            }
        }
        if self.state.is_telemetry_overdue(now) {
            let every = self.state.telemetry().samples_apart();
            self.link.order(Command::Watch(every));
        }
        Ok(())
    }

    fn take(&mut self, report: &Report, now: Instant) {
        let before = self.state.status().state;
        if let Some(frame) = self.state.take(report, now) {
            let added = self.recordings.add(&frame);
            self.note(added);
        }
        let after = self.state.status().state;
        if before == after {
            return;
        }
        if !self.state.is_driven() {
            self.state.clear_note();
        }
        if before == Does::Commissioning {
            let is_over = !matches!(after, Does::Faulted(_));
            if let Some(stands) = self.state.status().commissioning.filter(|_| is_over) {
                let message = format!("commissioning: {stands}");
                self.state.set_note(match stands.reason {
                    None => Note::Done(message),
                    Some(_) => Note::Failed(message),
                });
            }
            // It may have found gains.
            self.link.order(Command::Show);
        }
        if !self.state.is_driven() {
            // A recording is of one motion.
            self.end_recording();
        }
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Move(Motion::Start) => self.link.order(Command::Start),
            Action::Move(Motion::Commission) => self.commission(),
            Action::Stop => self.link.order(Command::Stop),
            Action::Target(radians) => self.link.order(Command::Target(radians)),
            Action::Clear => self.link.order(Command::Clear),
            Action::Save => self.link.order(Command::Save),
            Action::Record if self.recordings.under_way().is_some() => self.end_recording(),
            Action::Record => {
                let every = self.state.telemetry().samples_apart();
                let begun = self.recordings.begin(&self.state.settings(), every);
                self.note(begun.map(|()| Some("recording".to_owned())));
            }
            // The caller ends the session.
            Action::Quit => {}
        }
    }

    fn commission(&mut self) {
        let Some(plan) = &self.plan else {
            return self.state.set_note(Note::Failed(
                "not commissioned: start the monitor with --scenario, whose [commission] limits the motion"
                    .to_owned(),
            ));
        };
        if let Some(settings) = plan.configure.filter(|_| !self.state.status().configured) {
            self.link.order(Command::Configure(settings));
        }
        self.link.order(Command::Commission(plan.order));
    }

    fn was_done(&mut self, command: &Command) {
        let message = match command {
            Command::Start => match self.state.settings().protection.link_timeout {
                0.0 => "started; it keeps running without the monitor".to_owned(),
                timeout => {
                    format!("started; it stops when the line is silent for {timeout} s")
                }
            },
            // The report came first, and said so; a recording that it has ended is named.
            Command::Stop if !self.state.is_driven() => return,
            Command::Stop => "stopped: the servo is disabled".to_owned(),
            Command::Target(radians) | Command::RelativeTarget(radians) => {
                format!("moving to {radians} rad")
            }
            Command::Home => "homing".to_owned(),
            Command::Clear => "the fault is cleared, if its cause is gone".to_owned(),
            Command::Save => "settings and estimates are stored in flash".to_owned(),
            Command::Commission(_) => "commissioning; Space or a stops it".to_owned(),
            Command::Configure(_) => {
                self.link.order(Command::Show);
                return;
            }
            // The rest changes nothing at the servo.
            _ => return,
        };
        self.state.set_note(Note::Done(message));
    }

    fn end_recording(&mut self) {
        let ended = self.recordings.end();
        self.note(ended);
    }

    fn note(&mut self, done: Result<Option<String>, Fault>) {
        match done {
            Ok(Some(message)) => self.state.set_note(Note::Done(message)),
            Ok(None) => {}
            Err(fault) => self.state.set_note(Note::Failed(fault.to_string())),
        }
    }
}

/// The word of a command, without its values.
fn name(command: &Command) -> String {
    match command {
        Command::Save => "keep".to_owned(),
        Command::Watch(_) | Command::Show => "report".to_owned(),
        _ => {
            let whole = format!("{command:?}");
            whole.split('(').next().unwrap_or_default().to_lowercase()
        }
    }
}
