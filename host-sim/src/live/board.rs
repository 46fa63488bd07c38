use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A page as it is now.
#[derive(Debug, Clone)]
pub struct Update {
    /// The whole page, HTML.
    pub page: Arc<str>,
    /// What has changed in it, JSON on one line.
    pub change: Arc<str>,
}

/// Where the newest page is left for whoever shows it.
#[derive(Debug, Default)]
pub(super) struct Board {
    newest: Mutex<Newest>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Newest {
    /// Counts the updates from 1.
    number: u64,
    update: Option<Update>,
}

impl Board {
    /// Leaves an update.
    pub(super) fn put(&self, update: Update) {
        let mut newest = self.newest();
        newest.number += 1;
        newest.update = Some(update);
        self.changed.notify_all();
    }

    /// The newest update, with its number.
    pub(super) fn get(&self) -> Option<(u64, Update)> {
        let newest = self.newest();
        Some((newest.number, newest.update.clone()?))
    }

    /// The newest update that is not of this number, or none if there was none for so long.
    pub(super) fn after(&self, number: u64, longest: Duration) -> Option<(u64, Update)> {
        let is_known = |newest: &mut Newest| newest.number == number;
        let waited = self
            .changed
            .wait_timeout_while(self.newest(), longest, is_known);
        let (newest, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let update = newest.update.clone()?;
        (newest.number != number).then_some((newest.number, update))
    }

    fn newest(&self) -> MutexGuard<'_, Newest> {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn update(text: &str) -> Update {
        Update {
            page: text.into(),
            change: text.into(),
        }
    }

    #[test]
    fn whoever_is_late_gets_the_newest_alone() {
        let board = Board::default();
        let wait = Duration::from_millis(1);
        assert!(board.get().is_none() && board.after(0, wait).is_none());
        board.put(update("one"));
        board.put(update("two"));
        let (number, newest) = board.after(0, wait).expect("an update");
        assert_eq!((number, &*newest.change), (2, "two"));
        assert!(board.after(number, wait).is_none());
    }
}
