//! Ctrl-C, and whatever else asks the program to end: no file is left half written.

use std::io;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The exit status of a program that SIGINT ended, as shells have it.
const INTERRUPTED: i32 = 130;

/// The temporary files of this process. The lock is held while one is made, so that an interruption
/// finds all there are.
static TEMPORARIES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Whether the verb ends by itself when it is asked to, and whether it is.
static ENDS_BY_ITSELF: AtomicBool = AtomicBool::new(false);
static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on, an interruption removes the temporary files before it ends the program.
///
/// Where one of the signals is ignored from the start, as `nohup` has it, all of them are left as they
/// are: a handler would undo what the user asked for.
pub(super) fn handle() {
    // The only other error is that this process has a handler already.
    let _ = ctrlc::try_set_handler(end);
}

/// From now on, the first interruption only sets the flag that is answered with: what is done so far is
/// worth keeping. The second one ends the program.
pub(super) fn asks_first() -> &'static AtomicBool {
    ENDS_BY_ITSELF.store(true, Ordering::Relaxed);
    &ASKED
}

/// Makes a temporary file that an interruption removes; `make` answers with it and its path.
pub(super) fn removing<T>(
    make: impl FnOnce() -> io::Result<T>,
    path: impl FnOnce(&T) -> &Path,
) -> io::Result<T> {
    let mut temporaries = temporaries();
    let made = make()?;
    temporaries.push(path(&made).to_owned());
    Ok(made)
}

fn end() {
    if ENDS_BY_ITSELF.load(Ordering::Relaxed) && !ASKED.swap(true, Ordering::Relaxed) {
        return;
    }
    // The lock is never let go: nothing new appears between the removal and the end.
    let temporaries = temporaries();
    for path in temporaries.iter() {
        // Most are gone: they were renamed or removed when they were done.
        let _ = std::fs::remove_file(path);
    }
    process::exit(INTERRUPTED);
}

fn temporaries() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}
