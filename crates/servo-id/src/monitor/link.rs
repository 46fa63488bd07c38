//! The line to the drive, in a thread of its own. However long a screen or a disk takes, reports are read and the link
//! is kept alive.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use drive_link::{Command, Refusal, Report};

use crate::drive::{AtEnd, DriveError, Driven, Silence, is_driven};

/// Longest wait of a command.
const MAX_COMMAND_WAIT: Duration = Duration::from_millis(5);

/// Longest time to a sign of life of a drive that has not answered: it is asked for one every second.
const MAX_SIGN_WAIT: Duration = Duration::from_secs(2);

/// The line to a drive, served by a thread. However it is dropped, the servo is left as [`AtEnd`] orders.
#[derive(Debug)]
pub struct Link {
    /// Each with the number of the last stop before it.
    orders: Option<Sender<(Command, u32)>>,
    stops: &'static Stops,
    reports: Receiver<Report>,
    answers: Receiver<LinkEvent>,
    thread: Option<JoinHandle<Result<bool, LinkError>>>,
}

/// The stops that were ordered.
#[derive(Debug, Default)]
struct Stops {
    /// The number of the last one: no command from before it is sent.
    last: AtomicU32,
    /// One is not sent yet: that ends every wait for an answer.
    wait: AtomicBool,
}

/// An event of the line.
#[derive(Debug)]
pub enum LinkEvent {
    /// A report; those that answer an order, too.
    Report(Report),
    /// An order was done.
    Done(Command),
    /// An order was refused.
    Refused(Refusal),
    /// No answer came: unknown whether the command was done.
    Unanswered(Command),
    /// The drive is lost.
    Lost(LinkError),
}

/// Why a drive is lost.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The line broke.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// The line works, and the drive is silent.
    #[error(
        "the drive has been silent for {} s: is it switched on and connected?",
        Silence::MAX.as_secs()
    )]
    Silent,
    /// The thread of the line has ended by a defect of this program.
    #[error("the thread of the serial line has ended")]
    Ended,
}

impl Link {
    /// Serves a drive.
    #[must_use]
    pub fn open(mut drive: Driven, at_end: AtEnd) -> Self {
        let (orders, ordered) = mpsc::channel();
        let (report, reports) = mpsc::channel();
        let (answer, answers) = mpsc::channel();
        // A program has one link.
        let stops: &Stops = Box::leak(Box::default());
        drive.pass_reports_to(report);
        drive.end_waits_by(Some(&stops.wait));
        let thread = thread::spawn(move || {
            serve(&mut drive, &ordered, &answer, stops)?;
            // What ended the commands may be set only now, and the end has waits of its own.
            drive.end_waits_by(None);
            end(&mut drive, at_end)
        });
        Self {
            orders: Some(orders),
            stops,
            reports,
            answers,
            thread: Some(thread),
        }
    }

    /// Sends a command; its answer is an event. A stop goes before all commands that are not answered yet, and ends them.
    pub fn order(&self, command: Command) {
        if let Some(orders) = &self.orders {
            let Stops { last, wait } = self.stops;
            if command == Command::Stop {
                last.fetch_add(1, Ordering::Relaxed);
                wait.store(true, Ordering::Relaxed);
            }
            // The loss of the line is an event of its own.
            let _ = orders.send((command, last.load(Ordering::Relaxed)));
        }
    }

    /// The next event, if there is one.
    pub fn next_event(&mut self) -> Option<LinkEvent> {
        // What a drive reports of a command precedes its answer.
        if let Ok(report) = self.reports.try_recv() {
            return Some(LinkEvent::Report(report));
        }
        match self.answers.try_recv() {
            Ok(answer) => Some(answer),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => self.end().err().map(LinkEvent::Lost),
        }
    }

    /// Ends it; true if the servo stays driven.
    ///
    /// # Errors
    /// If the drive is lost, or does not release its servo.
    pub fn close(mut self) -> Result<bool, LinkError> {
        self.end()
    }

    fn end(&mut self) -> Result<bool, LinkError> {
        self.orders = None;
        // What is not answered ends, and what is not sent.
        self.stops.wait.store(true, Ordering::Relaxed);
        let ended = self.thread.take().and_then(|thread| thread.join().ok());
        ended.unwrap_or(Err(LinkError::Ended))
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        if self.thread.is_some() {
            // Nothing is left to report it to.
            let _ = self.end();
        }
    }
}

/// Obeys and listens until the commands end.
fn serve(
    drive: &mut Driven,
    orders: &Receiver<(Command, u32)>,
    answers: &Sender<LinkEvent>,
    stops: &'static Stops,
) -> Result<(), LinkError> {
    let mut silence = Silence::begin();
    loop {
        match orders.try_recv() {
            Ok(order) => {
                if let Some(answer) = obey(drive, order, stops)? {
                    // A session that ends closes the commands, too.
                    let _ = answers.send(answer);
                }
                silence.end();
            }
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return Ok(()),
        }
        match drive.next_within(MAX_COMMAND_WAIT, |_| Some(())) {
            Ok(Some(())) => silence.end(),
            Ok(None) if silence.is_too_long() => return Err(LinkError::Silent),
            // The stop is the next command.
            Ok(None) | Err(DriveError::Interrupted) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

/// The answer to a command; none to one that a stop has ended.
fn obey(
    drive: &mut Driven,
    (command, stop): (Command, u32),
    stops: &'static Stops,
) -> Result<Option<LinkEvent>, LinkError> {
    let done = match command {
        Command::Stop => {
            stops.wait.store(false, Ordering::Relaxed);
            let stopped = drive.stop_and_stay();
            drive.end_waits_by(Some(&stops.wait));
            stopped
        }
        _ if stop != stops.last.load(Ordering::Relaxed) => return Ok(None),
        Command::Start => drive.start(),
        Command::Commission(order) => drive.commission(&order),
        command => drive.ask(command),
    };
    Ok(Some(match done {
        Ok(()) => LinkEvent::Done(command),
        Err(DriveError::Refused(refusal)) => LinkEvent::Refused(refusal),
        Err(DriveError::Interrupted) => return Ok(None),
        Err(
            DriveError::Unanswered(_)
            | DriveError::Silent
            | DriveError::NotStopped
            | DriveError::NotAcknowledged,
        ) => match drive.next_within(MAX_SIGN_WAIT, |_| Some(())) {
            Ok(None) => return Err(LinkError::Silent),
            Ok(Some(())) | Err(DriveError::Interrupted) => LinkEvent::Unanswered(command),
            Err(error) => return Err(error.into()),
        },
        Err(error) => return Err(error.into()),
    }))
}

/// Leaves the servo as ordered; true if it stays driven.
fn end(drive: &mut Driven, at_end: AtEnd) -> Result<bool, LinkError> {
    let stays = match at_end {
        AtEnd::Stop => {
            // Whatever it does: nothing comes before a stop.
            drive.stop()?;
            false
        }
        AtEnd::Leave => is_driven(drive.status()?.state),
    };
    drive.watch(0)?;
    Ok(stays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Client;
    use crate::scripted_line::{self, Received};
    use std::time::Instant;

    const PATIENCE: Duration = Duration::from_secs(10);

    /// A link to a drive that obeys, but for some commands, which it does not answer.
    fn link(unanswered: fn(Command) -> bool) -> (Link, Received) {
        let (port, received) =
            scripted_line::obedient(move |request| unanswered(request.command).then_some(None));
        let drive = Driven::new(Client::new(port), 1.0, AtEnd::Leave);
        (Link::open(drive, AtEnd::Leave), received)
    }

    /// Waits until the drive has received a command so often.
    fn arrives(received: &Received, command: Command, times: usize) {
        let begun = Instant::now();
        while received.count(command) < times {
            assert!(begun.elapsed() < PATIENCE, "{command:?}");
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// The answers up to that to a command.
    fn answers(link: &mut Link, last: Command) -> Vec<LinkEvent> {
        let (mut all, begun) = (Vec::new(), Instant::now());
        loop {
            assert!(begun.elapsed() < PATIENCE, "{all:?}");
            match link.next_event() {
                None => thread::sleep(Duration::from_millis(1)),
                Some(LinkEvent::Report(_)) => {}
                Some(answer) => {
                    let is_last = matches!(answer, LinkEvent::Done(done) if done == last);
                    all.push(answer);
                    if is_last {
                        return all;
                    }
                }
            }
        }
    }

    #[test]
    fn a_stop_ends_what_is_not_answered_and_the_next_run_has_none_of_it() {
        const TARGET: Command = Command::Target(0.5);
        let (mut link, received) = link(|command| matches!(command, TARGET | Command::Save));
        for waits in [TARGET, Command::Save] {
            let before = received.count(waits);
            link.order(waits);
            arrives(&received, waits, before + 1);
            // It waits behind the other, and is not sent at all.
            link.order(Command::Home);
            let begun = Instant::now();
            link.order(Command::Stop);
            let told = answers(&mut link, Command::Stop);
            assert_eq!(told.len(), 1, "{told:?}");
            assert!(begun.elapsed() < Duration::from_secs(1));
            link.order(Command::Start);
            assert_eq!(answers(&mut link, Command::Start).len(), 1);
            assert_eq!(received.count(Command::Home), 0);
            assert_eq!(received.count(waits), before + 1);
        }
        assert_eq!(received.count(Command::Start), 2);
    }

    #[test]
    fn nothing_of_before_the_last_of_several_stops_is_sent() {
        let (mut link, received) = link(|_| false);
        for _ in 0..20 {
            for command in [Command::Stop, Command::Start, Command::Stop] {
                link.order(command);
            }
            answers(&mut link, Command::Stop);
            answers(&mut link, Command::Stop);
        }
        assert_eq!(
            (
                received.count(Command::Start),
                received.count(Command::Stop)
            ),
            (0, 40)
        );
        // One that comes after it is.
        link.order(Command::Start);
        assert_eq!(answers(&mut link, Command::Start).len(), 1);
    }

    #[test]
    fn nothing_ends_the_last_wait_for_a_drive_that_is_left_running() {
        let mut asked = 0;
        let (port, received) = scripted_line::obedient(move |request| {
            let is_first = request.command == Command::Hello && asked == 0;
            asked += usize::from(request.command == Command::Hello);
            is_first.then_some(None)
        });
        let drive = Driven::new(Client::new(port), 1.0, AtEnd::Leave);
        let mut link = Link::open(drive, AtEnd::Leave);
        link.orders = None;
        arrives(&received, Command::Hello, 1);
        link.close().expect("it is asked once more");
        assert_eq!(received.count(Command::Hello), 2);
    }

    #[test]
    fn a_run_after_a_stop_is_kept_alive_and_can_be_stopped_again() {
        let (mut link, received) = link(|_| false);
        for run in 1..3 {
            for command in [Command::Start, Command::Stop] {
                link.order(command);
                assert_eq!(answers(&mut link, command).len(), 1);
                assert_eq!(received.count(command), run);
            }
            arrives(
                &received,
                Command::KeepAlive,
                received.count(Command::KeepAlive) + 1,
            );
        }
    }
}
