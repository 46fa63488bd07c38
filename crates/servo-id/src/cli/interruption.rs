//! Ctrl-C, and every other request to end the program: no file is left half written, and no drive driven.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{io, process};

/// The exit status of a program that SIGINT ended, as shells have it.
pub(super) const INTERRUPTED: u8 = 130;

/// The temporary files of this process. The lock is held while one is made, so that an interruption
/// finds all there are.
static TEMPORARIES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The verb ends by itself when an end is requested.
static ENDS_BY_ITSELF: AtomicBool = AtomicBool::new(false);
/// An end was requested.
static END_REQUESTED: AtomicBool = AtomicBool::new(false);

/// What the interruption that ends the program does first.
static LAST_ACT: Mutex<Option<Box<dyn FnOnce() + Send>>> = Mutex::new(None);

/// From now on, an interruption removes the temporary files before it ends the program.
pub(super) fn handle() {
    // Without a handler the program ends as any other does.
    let _ = install();
}

/// From now on, the first interruption only sets the flag that is returned: the work done so far is
/// worth keeping. The second one ends the program.
pub(super) fn end_requested() -> &'static AtomicBool {
    ENDS_BY_ITSELF.store(true, Ordering::Relaxed);
    &END_REQUESTED
}

/// From now on, the interruption that ends the program does this first.
#[cfg(feature = "operation")]
pub(super) fn before_end(act: impl FnOnce() + Send + 'static) {
    *locked(&LAST_ACT) = Some(Box::new(act));
}

/// Makes a temporary file that an interruption removes; `make` returns it, `path` its path.
pub(super) fn removing<T>(
    make: impl FnOnce() -> io::Result<T>,
    path: impl FnOnce(&T) -> &Path,
) -> io::Result<T> {
    let mut temporaries = locked(&TEMPORARIES);
    let made = make()?;
    temporaries.push(path(&made).to_owned());
    Ok(made)
}

/// Handles SIGINT, SIGTERM and SIGHUP, each on its own. One that was ignored at the start stays so:
/// `nohup` ignores SIGHUP, and a shell's background job SIGINT.
#[cfg(unix)]
fn install() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

    let handled = [SIGINT, SIGTERM, SIGHUP].into_iter();
    let handled = handled.filter(|signal| !is_ignored(*signal));
    let mut signals = signal_hook::iterator::Signals::new(handled)?;
    let wait = move || signals.forever().for_each(|_| interrupt());
    std::thread::Builder::new().spawn(wait).map(drop)
}

#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: without a new action the call only writes the present one, for which there is room; all of
    // whose fields may be zero.
    let action = unsafe {
        libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr());
        action.assume_init()
    };
    action.sa_sigaction == libc::SIG_IGN
}

#[cfg(not(unix))]
fn install() -> io::Result<()> {
    ctrlc::try_set_handler(interrupt).map_err(io::Error::other)
}

fn interrupt() {
    if ENDS_BY_ITSELF.load(Ordering::Relaxed) && !END_REQUESTED.swap(true, Ordering::Relaxed) {
        return;
    }
    if let Some(act) = locked(&LAST_ACT).take() {
        act();
    }
    // The lock is never released: nothing new appears between the removal and the end.
    let temporaries = locked(&TEMPORARIES);
    for path in temporaries.iter() {
        // Most are gone: they were renamed or removed when they were complete.
        let _ = std::fs::remove_file(path);
    }
    process::exit(INTERRUPTED.into());
}

fn locked<T>(shared: &'static Mutex<T>) -> MutexGuard<'static, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
