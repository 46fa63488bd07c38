use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A page as it is now.
#[derive(Debug, Clone)]
pub struct Update {
    /// The whole page, HTML.
    pub page: Arc<str>,
    /// Its changes, JSON on one line.
    pub change: Arc<str>,
}

/// The newest page, for the server to show.
#[derive(Debug, Default)]
pub(super) struct Board {
    /// The updates are counted from 1.
    newest: Mutex<(u64, Option<Update>)>,
    changed: Condvar,
}

impl Board {
    /// Leaves an update.
    pub(super) fn put(&self, update: Update) {
        let mut newest = self.newest();
        *newest = (newest.0 + 1, Some(update));
        self.changed.notify_all();
    }

    /// The newest update, with its number, once that is another than `number`; none if there is none within
    /// `longest`.
    pub(super) fn after(&self, number: u64, longest: Duration) -> Option<(u64, Update)> {
        let is_known = |newest: &mut (u64, _)| newest.0 == number;
        let waited = self
            .changed
            .wait_timeout_while(self.newest(), longest, is_known);
        let (newest, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let (newest, update) = &*newest;
        (*newest != number).then_some((*newest, update.clone()?))
    }

    fn newest(&self) -> MutexGuard<'_, (u64, Option<Update>)> {
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
    fn a_late_reader_gets_the_newest_alone() {
        let board = Board::default();
        let wait = Duration::from_millis(1);
        assert!(board.after(0, wait).is_none());
        board.put(update("one"));
        board.put(update("two"));
        let (number, newest) = board.after(0, wait).expect("an update");
        assert_eq!((number, &*newest.change), (2, "two"));
        assert!(board.after(number, wait).is_none());
    }
}
