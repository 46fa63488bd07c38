//! Gains that follow the inertia of a commissioned servo in a run.

use core::fmt;

use drive_link::{ServoChanges, Settings, State};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::ControllerSettings;
use identifier_core::commission::Reason;
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::{
    FollowedGains, GainFollowing, GainFollowingState, NotFollowed, ServoChange, ServoChangeState,
};

use super::Supervisor;
use crate::messages::Order;
use crate::run::Run;

/// Gains on their way to a run.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap here, and a drive holds one"
)]
pub(super) enum Certificate {
    /// They are being certified.
    Begun(GainFollowing, GainFollowingState),
    /// They hold, and wait for room.
    Done(FollowedGains),
}

/// Gains that follow the inertia, and those on their way.
pub(super) struct Following {
    certificate: &'static mut Option<Certificate>,
    followed: Option<FollowedGains>,
    refused: Option<NotFollowed>,
    /// Examinations until the gains may change again.
    waits: u16,
    has_news: bool,
}

impl fmt::Debug for Following {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Following")
            .field("refused", &self.refused)
            .finish_non_exhaustive()
    }
}

impl Following {
    pub(super) fn in_memory(certificate: &'static mut Option<Certificate>) -> Self {
        Self {
            certificate,
            followed: None,
            refused: None,
            waits: 0,
            has_news: false,
        }
    }

    /// The gains of the run are as commissioned.
    pub(super) fn reset(&mut self) {
        *self.certificate = None;
        (self.followed, self.refused, self.waits) = (None, None, 0);
    }

    /// The gains of the run, if they are not as commissioned.
    pub(super) fn followed(&self) -> Option<&FollowedGains> {
        self.followed.as_ref()
    }

    /// Why they do not follow the change that is certain.
    pub(super) fn refused(&self) -> Option<NotFollowed> {
        self.refused
    }

    /// True once after the gains have followed, or could not.
    pub(super) fn has_news(&mut self) -> bool {
        core::mem::take(&mut self.has_news)
    }

    fn refuse(&mut self, reason: NotFollowed) {
        self.has_news |= self.refused != Some(reason);
        self.refused = Some(reason);
        *self.certificate = None;
        self.wait(0.0);
    }

    /// Leaves the gains alone for as long as a transient lasts, s.
    fn wait(&mut self, transient: f64) {
        // A cast saturates.
        let examinations = transient.max(GainFollowing::SETTLING) / ServoChangeState::INTERVAL;
        self.waits = examinations as u16;
    }
}

impl<F: NorFlash> Supervisor<'_, F> {
    /// Has the gains follow an inertia that this examination shows, where that is asked for and the change is certain.
    pub(super) fn follow(&mut self, shown: Option<&ServoChange>, found: &[ServoParameters; 2]) {
        let following = &mut self.following;
        following.waits = following.waits.saturating_sub(1);
        let is_free = following.waits == 0 && following.certificate.is_none();
        let is_inertia = |change: &ServoChange| change.reason == Reason::InertiaChanged;
        let is_shown = shown.is_some_and(is_inertia) && self.changes.steady().is_some();
        if !self.changes.reported().is_some_and(is_inertia) {
            self.following.refused = None;
        } else if is_shown && is_free && self.settings.servo_changes == ServoChanges::Followed {
            self.begin_certificate(found);
        }
    }

    #[cold]
    #[inline(never)]
    fn begin_certificate(&mut self, found: &[ServoParameters; 2]) {
        let (Some(promised), Some(limit)) = (self.commissioned, self.command_limit()) else {
            return;
        };
        let core = &self.settings.closed_loop.core;
        let begun = core
            .units()
            .map_err(|_| NotFollowed::NotKnown)
            .and_then(|units| {
                GainFollowing::new(&promised.servo(), &promised.tuning, found, &units, limit)
            });
        match begun {
            Ok(gains) => {
                let state = gains.start();
                *self.following.certificate = Some(Certificate::Begun(gains, state));
            }
            Err(reason) => self.following.refuse(reason),
        }
    }

    /// A slice of the certificate, and at its end the gains for the run. True if there is more to do.
    #[inline(never)]
    pub(super) fn certify(&mut self) -> bool {
        match self.following.certificate {
            None => false,
            Some(Certificate::Begun(gains, state)) => {
                match gains.work(state) {
                    None => {}
                    Some(Ok(gains)) => *self.following.certificate = Some(Certificate::Done(gains)),
                    Some(Err(reason)) => self.following.refuse(reason),
                }
                true
            }
            Some(Certificate::Done(gains)) => {
                let gains = *gains;
                self.exchange_gains(gains);
                false
            }
        }
    }

    /// Orders the run to go on with other gains. One that finds no room is tried again in the next turn.
    fn exchange_gains(&mut self, gains: FollowedGains) {
        if self.state() != State::Running || self.is_stopping() {
            return *self.following.certificate = None;
        }
        let settings = with_gains(&self.settings, &gains);
        let Some(new) = Run::gains_for(&settings, &gains.servo) else {
            return self.following.refuse(NotFollowed::NotKnown);
        };
        if self.order(Order::ExchangeGains(new)).is_ok() {
            let following = &mut self.following;
            *following.certificate = None;
            following.refused = None;
            following.has_news = true;
            following.wait(gains.tuning.promise.settling_time);
            following.followed = Some(gains);
            self.changes = ServoChangeState::START;
        }
    }

    /// The gains of the run over those that were commissioned, if they are not these.
    #[must_use]
    pub fn gain_factor(&self) -> Option<f32> {
        let gains = self.following.followed();
        gains.map(|gains| gains.factor as f32)
    }

    /// The settings, with the gains of the run that is under way.
    pub(super) fn settings_in_force(&self) -> Settings {
        match self.following.followed() {
            Some(gains) => with_gains(&self.settings, gains),
            None => self.settings,
        }
    }
}

fn with_gains(settings: &Settings, gains: &FollowedGains) -> Settings {
    let mut settings = *settings;
    if let Some(controller) = &mut settings.closed_loop.core.controller {
        *controller = ControllerSettings::tuned(&gains.tuning, controller.limit);
    }
    settings
}
