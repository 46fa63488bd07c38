//! The drive firmware on an emulated chip, which has no pins and no flash to write, and whose encoder
//! counts the clock: what is left is the whole way of a request and a fault.

use drive_link::{
    Command, Fault, Kept, PROTOCOL, Refusal, Report, Request, Settings, Snapshot, State, Status,
};
use host_sim::pil::Port;

use crate::{emulator, firmware};

/// Talks to the drive as a host would, and as a broken line does.
pub(crate) fn check() -> Result<(), String> {
    firmware::build(&["emulator"])?;
    let (_running, port) = emulator::Running::start(&firmware::path("drive"))?;
    let mut host = Host { port, id: 0 };

    let status = host.status()?;
    expect("protocol", status.protocol, PROTOCOL)?;
    expect("state after the boot", status.state, State::Released)?;
    // An emulated flash reads as zeros, which are no record, and takes nothing.
    expect("what the store held", status.kept, Kept::Damaged)?;
    expect(
        "a record for a worn flash",
        host.ask(Command::Save)?,
        Err(Refusal::NotKept),
    )?;

    // Garbage of every kind: the drive answers the next request.
    let mut garbage = 0x2545_f491_u32;
    for length in [1_u32, 7, 300, 2000, 5000] {
        let bytes: Vec<u8> = (0..length)
            .map(|_| {
                garbage ^= garbage << 13;
                garbage ^= garbage >> 17;
                garbage ^= garbage << 5;
                garbage as u8
            })
            .chain([0])
            .collect();
        host.port.say(&bytes).map_err(|error| error.to_string())?;
        expect("state after garbage", host.status()?.state, State::Released)?;
    }
    if host.status()?.garbled == 0 {
        return Err("garbage was taken for frames".to_owned());
    }
    println!("the drive boots, and garbage on its line costs nothing but itself");

    let settings = host.settings()?;
    let mut wrong = settings;
    wrong.closed_loop.gains[0] = 1.0;
    match host.ask(Command::Configure(wrong))? {
        Err(Refusal::Setting(refused)) => println!("refused as it should be: {refused}"),
        other => return Err(format!("kp = 1 was answered with {other:?}")),
    }
    expect("the settings after that", host.settings()?, settings)?;

    // An encoder that counts the clock runs away from any reference: let it, and look on.
    let mut wanted = settings;
    wanted.protection.following_error = 1e9;
    expect("configure", host.ask(Command::Configure(wanted))?, Ok(()))?;
    expect("watch", host.ask(Command::Watch(20))?, Ok(()))?;
    expect("start", host.ask(Command::Start)?, Ok(()))?;
    expect("the samples shown", host.next(shown)?.sample, 1)?;
    expect("the next of them", host.next(shown)?.sample, 21)?;
    expect(
        "a record in motion",
        host.ask(Command::Save)?,
        Err(Refusal::Running),
    )?;
    expect("stop", host.ask(Command::Stop)?, Ok(()))?;
    host.until(State::Released)?;
    println!("started, watched and stopped");

    expect("configure", host.ask(Command::Configure(settings))?, Ok(()))?;
    expect("start", host.ask(Command::Start)?, Ok(()))?;
    let fault = host.next(struck)?;
    expect("the fault of a mad encoder", fault, Fault::FollowingError)?;
    expect(
        "the state then",
        host.status()?.state,
        State::Faulted(Fault::FollowingError),
    )?;
    expect(
        "a start in spite of it",
        host.ask(Command::Start)?,
        Err(Refusal::Faulted(Fault::FollowingError)),
    )?;
    println!("{fault}");
    expect("clear", host.ask(Command::Clear)?, Ok(()))?;
    host.until(State::Released)?;
    println!("cleared, and ready again");
    Ok(())
}

fn shown(report: &Report) -> Option<Snapshot> {
    match report {
        Report::Snapshot(snapshot) => Some(*snapshot),
        _ => None,
    }
}

fn struck(report: &Report) -> Option<Fault> {
    match report {
        Report::Fault(fault) => Some(*fault),
        _ => None,
    }
}

/// The host's end of the conversation.
struct Host {
    port: Port,
    id: u8,
}

impl Host {
    fn report(&mut self, command: Command) -> Result<Report, String> {
        self.id = self.id.wrapping_add(1);
        let id = self.id;
        let fits = |report: &Report| match (&command, report) {
            (Command::Hello, Report::Status(_)) | (Command::Show, Report::Settings(_)) => true,
            (_, Report::Done { id: same } | Report::Refused { id: same, .. }) => *same == id,
            _ => false,
        };
        self.port
            .ask(&Request { id, command }, fits)
            .map_err(|error| error.to_string())
    }

    fn ask(&mut self, command: Command) -> Result<Result<(), Refusal>, String> {
        match self.report(command)? {
            Report::Refused { refusal, .. } => Ok(Err(refusal)),
            _ => Ok(Ok(())),
        }
    }

    fn status(&mut self) -> Result<Status, String> {
        match self.report(Command::Hello)? {
            Report::Status(status) => Ok(status),
            other => Err(format!("{other:?} is no status")),
        }
    }

    fn settings(&mut self) -> Result<Settings, String> {
        match self.report(Command::Show)? {
            Report::Settings(settings) => Ok(settings),
            other => Err(format!("{other:?} are no settings")),
        }
    }

    /// What a report that is waited for says.
    fn next<T>(&mut self, says: fn(&Report) -> Option<T>) -> Result<T, String> {
        for _ in 0..20 {
            let heard = self
                .port
                .listen(&|report: &Report| says(report).is_some())
                .map_err(|error| error.to_string())?;
            if let Some(said) = heard.as_ref().and_then(says) {
                return Ok(said);
            }
        }
        Err("the drive does not report what was waited for".to_owned())
    }

    fn until(&mut self, wanted: State) -> Result<(), String> {
        for _ in 0..100 {
            if self.status()?.state == wanted {
                return Ok(());
            }
        }
        Err(format!("the drive does not become {wanted:?}"))
    }
}

fn expect<T: PartialEq + std::fmt::Debug>(what: &str, found: T, wanted: T) -> Result<(), String> {
    if found == wanted {
        Ok(())
    } else {
        Err(format!("{what}: {found:?} instead of {wanted:?}"))
    }
}
