//! A drive that this program may set in motion, and what stops it.

use std::ops::{Deref, DerefMut};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Sender;
use std::time::Duration;

use commissioning::CommissionSettings;
use drive_link::{Command, Report, State, Status};

use super::{Client, DriveError, MAX_SIGN_PERIOD};

/// Signs of life within the drive's link timeout.
const SIGNS_PER_TIMEOUT: f64 = 4.0;

/// The end of a program that has set a servo in motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AtEnd {
    /// The stage is disabled.
    Stop,
    /// The servo stays driven.
    Leave,
}

/// A drive that this program may set in motion. It keeps the drive's run alive while it listens. However it is dropped,
/// it stops a drive that it has ordered to move, unless the servo is to be left driven.
#[derive(Debug)]
pub struct Driven {
    client: Client,
    /// What keeps a run alive, and how often.
    sign: (Command, Duration),
    /// It has ordered a motion that the drive did not refuse.
    has_moved: bool,
    at_end: AtEnd,
}

impl Driven {
    /// A drive with this link timeout, s; 0 for none.
    #[must_use]
    pub fn new(mut client: Client, link_timeout: f64, at_end: AtEnd) -> Self {
        let most = MAX_SIGN_PERIOD.as_secs_f64();
        let period = match link_timeout > 0.0 {
            true => (link_timeout / SIGNS_PER_TIMEOUT).min(most),
            false => most,
        };
        let sign = (Command::KeepAlive, Duration::from_secs_f64(period));
        client.sign = Some(sign);
        Self {
            client,
            sign,
            has_moved: false,
            at_end,
        }
    }

    /// Ends every wait for the drive, until it is stopped, when this is set; none ends early without it.
    pub fn end_waits_by(&mut self, interruption: Option<&'static AtomicBool>) {
        self.client.interruption = interruption;
    }

    /// Passes on every report that it hears, those that a wait is for, too.
    pub fn pass_reports_to(&mut self, reports: Sender<Report>) {
        self.client.reports = Some(reports);
    }

    /// Stops the drive from another thread just before the program ends.
    pub fn last_stop(&mut self) -> impl FnOnce() + Send + 'static {
        self.client.port.last_stop()
    }

    /// From now on the servo stays as it is when this is dropped.
    pub fn leave(&mut self) {
        self.at_end = AtEnd::Leave;
    }

    /// True if dropping this stops the drive.
    #[must_use]
    pub fn is_to_be_stopped(&self) -> bool {
        self.has_moved && self.at_end == AtEnd::Stop
    }

    /// Sends a command without waiting for the answer, which will carry the returned number.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn send(&mut self, command: Command) -> Result<u8, DriveError> {
        self.has_moved |= command.may_move();
        self.client.send(command)
    }

    /// Sends a command and waits until it is done.
    ///
    /// # Errors
    /// If it is refused, or the line breaks.
    pub fn ask(&mut self, command: Command) -> Result<(), DriveError> {
        self.guarded(command, |client| client.ask(command))
    }

    /// Starts a run, and never two: without an answer, the drive's state decides.
    ///
    /// # Errors
    /// If it is refused, the line breaks, or the run has already ended.
    pub fn start(&mut self) -> Result<(), DriveError> {
        const PATIENCE: Duration = Duration::from_millis(200);
        self.begin(Command::Start, PATIENCE, State::Running)
    }

    /// Begins a commissioning, and never two. Before it begins, the drive's flash may have to be erased.
    ///
    /// # Errors
    /// If it is refused, the line breaks, or it has already ended.
    pub fn commission(&mut self, order: &CommissionSettings) -> Result<(), DriveError> {
        const PATIENCE: Duration = Duration::from_secs(5);
        let command = Command::Commission(*order);
        self.begin(command, PATIENCE, State::Commissioning)
    }

    /// As [`Client::stop`].
    ///
    /// # Errors
    /// Those of [`Client::stop`].
    pub fn stop(&mut self) -> Result<Status, DriveError> {
        self.has_moved = false;
        self.client.stop()
    }

    /// The same for a program that goes on, some times until the drive acknowledges it. Then the next run is kept alive.
    /// Unless it does, dropping this stops the drive, too, and nothing keeps its run alive.
    ///
    /// # Errors
    /// Those of [`Client::stop`].
    pub fn stop_and_stay(&mut self) -> Result<(), DriveError> {
        const TIMES: usize = 3;
        let has_moved = self.has_moved;
        let mut stops = (0..TIMES).map(|_| self.stop());
        let is_over = |stopped: &_| !matches!(stopped, Err(DriveError::NotAcknowledged));
        let stopped = stops.find(is_over);
        let stopped = stopped.unwrap_or(Err(DriveError::NotAcknowledged));
        match stopped {
            Ok(_) => self.client.sign = Some(self.sign),
            Err(_) => self.has_moved = has_moved,
        }
        stopped.map(drop)
    }

    /// Sends a command once that must not be done twice. Without an answer, the drive's state decides whether it was
    /// done.
    fn begin(
        &mut self,
        command: Command,
        patience: Duration,
        wanted: State,
    ) -> Result<(), DriveError> {
        self.guarded(command, |client| {
            let id = client.send(command)?;
            let answer = client.next_within(patience, |report| match report {
                Report::Done { id: same } if *same == id => Some(Ok(())),
                Report::Refused { id: same, refusal } if *same == id => Some(Err(refusal.clone())),
                _ => None,
            })?;
            match answer {
                Some(done) => done.map_err(DriveError::Refused),
                None if client.status()?.state == wanted => Ok(()),
                None => Err(DriveError::Silent),
            }
        })
    }

    /// Counts a motion as ordered from before its first byte on, unless the drive refuses it.
    fn guarded(
        &mut self,
        command: Command,
        order: impl FnOnce(&mut Client) -> Result<(), DriveError>,
    ) -> Result<(), DriveError> {
        let before = self.has_moved;
        if command.may_move() {
            self.has_moved = true;
            self.client.sign = Some(self.sign);
        }
        let done = order(&mut self.client);
        if matches!(done, Err(DriveError::Refused(_))) {
            self.has_moved = before;
        }
        done
    }
}

impl Drop for Driven {
    fn drop(&mut self) {
        if self.is_to_be_stopped() {
            // Nothing is left to report it to.
            let _ = self.client.port.stop(&|_| ());
        }
    }
}

impl Deref for Driven {
    type Target = Client;

    fn deref(&self) -> &Client {
        &self.client
    }
}

impl DerefMut for Driven {
    fn deref_mut(&mut self) -> &mut Client {
        &mut self.client
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use drive_link::{Refusal, Request};

    use super::*;
    use crate::scripted_line::{Received, obedient, status};

    /// Runs a program with a drive that obeys, but for these answers, and returns what the drive has received.
    fn received(
        own: impl FnMut(&Request) -> Option<Option<Report>> + Send + 'static,
        program: impl FnOnce(&mut Driven),
    ) -> Received {
        let (port, received) = obedient(own);
        let mut drive = Driven::new(Client::new(port), 1.0, AtEnd::Stop);
        // However it ends.
        let _ = catch_unwind(AssertUnwindSafe(move || program(&mut drive)));
        received
    }

    #[test]
    fn a_panic_stops_a_drive_that_was_set_in_motion() {
        for motion in [Command::Start, Command::Target(1.0), Command::Home] {
            let received = received(
                |_| None,
                move |drive| {
                    drive.ask(motion).expect("it obeys");
                    panic!("a defect of this program");
                },
            );
            assert_eq!(received.commands(), [Command::Hello, motion, Command::Stop]);
        }
    }

    #[test]
    fn a_motion_whose_answer_is_lost_is_stopped() {
        let deaf = |request: &Request| (request.command == Command::Start).then_some(None);
        let sent = received(deaf, |drive| {
            // The guard is armed before the answer, and before the first byte.
            drive.send(Command::Start).expect("the line is whole");
        });
        let wanted = [Command::Hello, Command::Start, Command::Stop];
        assert_eq!(sent.commands(), wanted);
    }

    #[test]
    fn a_look_a_refused_motion_and_one_that_is_left_are_not_stopped() {
        let refuses = |request: &Request| {
            let (id, refusal) = (request.id, Refusal::NotConfigured);
            let is_start = request.command == Command::Start;
            is_start.then_some(Some(Report::Refused { id, refusal }))
        };
        let sent = received(refuses, |drive| {
            drive.start().expect_err("it is refused");
            drive.watch(0).expect("it obeys");
        });
        assert_eq!(sent.count(Command::Stop), 0);
        let sent = received(
            |_| None,
            |drive| {
                drive.start().expect("it obeys");
                drive.leave();
            },
        );
        assert_eq!(sent.commands(), [Command::Hello, Command::Start]);
    }

    #[test]
    fn an_order_has_the_number_after_the_last_of_any_program() {
        let mut last = 41;
        let counts = move |request: &Request| {
            let id = request.id;
            if request.command == Command::Hello {
                let status = Status {
                    order: last,
                    ..status(State::Running)
                };
                return Some(Some(Report::Status {
                    id: Some(id),
                    status,
                }));
            }
            if !request.command.may_move() {
                return None;
            }
            if request.order <= last {
                let refusal = Refusal::GivenBefore;
                return Some(Some(Report::Refused { id, refusal }));
            }
            // Another program gives one after it.
            last = request.order + 1;
            None
        };
        let sent = received(counts, |drive| {
            drive.start().expect("it obeys");
            for target in [Command::Target(1.0), Command::Home] {
                let refused = drive.ask(target);
                assert!(matches!(
                    refused,
                    Err(DriveError::Refused(Refusal::GivenBefore))
                ));
                drive.ask(target).expect("it has asked for the state");
            }
            drive.leave();
        });
        let requests = sent.all();
        let moving = requests.iter().filter(|request| request.command.may_move());
        let orders: Vec<u32> = moving.map(|request| request.order).collect();
        assert_eq!(orders, [42, 43, 44, 45, 46]);
    }

    #[test]
    fn an_interruption_ends_every_wait_but_that_for_the_stop() {
        static INTERRUPTION: AtomicBool = AtomicBool::new(true);
        let sent = received(
            |_| None,
            |drive| {
                drive.ask(Command::Start).expect("it obeys");
                drive.end_waits_by(Some(&INTERRUPTION));
                assert!(matches!(drive.status(), Err(DriveError::Interrupted)));
                drive.stop().expect("it obeys");
            },
        );
        assert_eq!(sent.count(Command::Stop), 1);
    }

    #[test]
    fn a_stop_that_is_not_acknowledged_counts_as_none_and_nothing_keeps_the_run_alive() {
        let mut has_moved = false;
        let (port, sent) = obedient(move |request| {
            has_moved |= request.command == Command::Start;
            let is_unheard = matches!(request.command, Command::Stop | Command::Hello);
            (has_moved && is_unheard).then_some(None)
        });
        let mut drive = Driven::new(Client::new(port), 1.0, AtEnd::Stop);
        drive.ask(Command::Start).expect("it obeys");
        let stopped = drive.stop_and_stay();
        assert!(matches!(stopped, Err(DriveError::NotAcknowledged)));
        assert!(drive.is_to_be_stopped() && drive.client.sign.is_none());
        let before = sent.count(Command::Stop);
        drop(drive);
        assert!(sent.count(Command::Stop) > before);
    }

    #[test]
    fn who_drives_keeps_the_run_alive_and_who_looks_does_not() {
        const TIME: Duration = Duration::from_millis(30);
        let sent = received(
            |_| None,
            |drive| {
                drive.client.sign = drive.client.sign.map(|(sign, _)| (sign, TIME / 10));
                let none = drive.next_within(TIME, |_| None::<()>);
                assert!(none.expect("the line is whole").is_none());
            },
        );
        assert!(sent.count(Command::KeepAlive) > 0);
        let (port, sent) = obedient(|_| None);
        let mut client = Client::new(port);
        client.poll();
        client.sign = client.sign.map(|(sign, _)| (sign, TIME / 10));
        let none = client.next_within(TIME, |_| None::<()>);
        assert!(none.expect("the line is whole").is_none());
        client.status().expect("it answers");
        client.settings().expect_err("the script has none");
        assert!(sent.commands().iter().all(|command| !command.keeps_alive()));
    }
}
