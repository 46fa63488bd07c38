use super::ServoChange;

/// Examinations of a servo in succession, by which a change is told from a transient. By default there were none yet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ServoChangeState {
    /// The change that is reported.
    reported: Option<ServoChange>,
    /// The last examination's, and the number of those in a row that agree.
    last: Option<ServoChange>,
    agreeing: u8,
}

impl ServoChangeState {
    /// The examinations in a row that must agree before a change is reported, or is no longer.
    pub const AGREEING: u8 = 8;

    /// The time from one examination to the next, s.
    pub const INTERVAL: f64 = 0.25;

    /// Takes a check: the change that it shows, if any. An identifier that has not settled is not checked. That
    /// restarts the count of agreeing checks, and so does every [event](identifier_core::identifier::Event)
    /// ([`ServoChangeState::interrupt`]): wrong estimates soon look like load steps.
    pub fn take(&mut self, change: Option<ServoChange>) {
        /// The part of its distance from the commissioned value by which a value may change from one check to the
        /// next.
        const MAX_MOVE: f64 = 0.2;
        let agrees = match (&self.last, &change) {
            (None, None) => true,
            // At rest nothing is learnt.
            (Some(last), Some(now)) if last == now => return,
            (Some(last), Some(now)) => {
                let moved = (now.found - last.found).abs();
                last.reason == now.reason && moved <= MAX_MOVE * (now.found - now.predicted).abs()
            }
            _ => false,
        };
        self.agreeing = if agrees {
            self.agreeing.saturating_add(1)
        } else {
            1
        };
        self.last = change;
        if self.agreeing >= Self::AGREEING {
            self.reported = change;
        }
    }

    /// The identifier has not settled, or has reported an event: the row of examinations begins anew.
    pub fn interrupt(&mut self) {
        self.agreeing = 0;
    }

    /// The change that is certain; none while the servo is the commissioned one.
    #[must_use]
    pub fn reported(&self) -> Option<&ServoChange> {
        self.reported.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identifier_core::reason::Reason;

    #[test]
    fn a_change_is_reported_after_a_row_that_agrees_and_moves() {
        let change = |found: f64| {
            Some(ServoChange {
                reason: Reason::InertiaChanged,
                predicted: 1.0,
                found,
                standard_errors: 10.0,
            })
        };
        let mut state = ServoChangeState::default();
        // At rest the same estimate comes again and again.
        for _ in 0..100 {
            state.take(change(2.0));
        }
        assert_eq!(state.reported(), None);
        for k in 1..ServoChangeState::AGREEING {
            assert_eq!(state.reported(), None);
            state.take(change(2.0 + 0.01 * f64::from(k)));
        }
        assert!(state.reported().is_some());
        // It stays until as many examinations show none.
        for _ in 1..ServoChangeState::AGREEING {
            state.take(None);
            assert!(state.reported().is_some());
        }
        state.take(None);
        assert_eq!(state.reported(), None);
        // An estimate on its way, and a row that is interrupted.
        for k in 0..100 {
            state.take(change(f64::from(1 << (k % 20))));
            assert_eq!(state.reported(), None);
        }
        for k in 0..100 {
            state.take(change(2.0 + 1e-3 * f64::from(k)));
            if k % 5 == 0 {
                state.interrupt();
            }
            assert_eq!(state.reported(), None);
        }
    }
}
