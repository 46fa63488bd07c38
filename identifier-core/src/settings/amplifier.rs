use super::parameter_range::LARGEST;
use super::{Settings, SettingsError, TermSettings};
use crate::error::Allowed;
use crate::model::Amplifier;
use crate::number::Number;
use crate::parameters::Term;

impl Settings {
    /// The declared amplifier, and the settings of an identifier behind it. It has no effect where none is declared.
    ///
    /// # Errors
    /// `delay`, `current_loop` or `dead_band` out of range.
    pub fn amplifier<N: Number, const L: usize>(
        &self,
    ) -> Result<(Amplifier<N, L>, Self), SettingsError> {
        let declared = Declared::new(self, Amplifier::<N, L>::MAX_DELAY)?;
        let amplifier = Amplifier::new(declared.dead_band, declared.delay, declared.current_loop);
        Ok((amplifier, declared.behind))
    }
}

/// The declared effects of an amplifier: those that act before the identifier, and those left to it.
/// Compiled once, not for every number.
struct Declared {
    dead_band: f64,
    /// Samples.
    delay: f64,
    /// Samples.
    current_loop: f64,
    /// The settings of the identifier behind it.
    behind: Settings,
}

impl Declared {
    fn new(settings: &Settings, longest_delay: f64) -> Result<Self, SettingsError> {
        /// A slower lag than this is no current loop, s.
        const SLOWEST: f64 = 0.1;
        let units = settings.units()?;
        let given = settings.identifier.terms;
        let longest = longest_delay * units.sample_time();
        Allowed::Within(0.0, longest).check("delay", given.delay)?;
        Allowed::Within(0.0, LARGEST).check("dead_band", given.dead_band)?;
        Allowed::Within(0.0, SLOWEST).check("current_loop", given.current_loop)?;
        let unless = |term: Term, declared: f64| match given.demanded.has(term) {
            true => (0.0, declared),
            false => (declared, 0.0),
        };
        let (delay, begins_delayed) = unless(Term::Delay, given.delay);
        let (dead_band, begins_dead) = unless(Term::DeadBand, given.dead_band);
        let mut behind = *settings;
        behind.identifier.terms = TermSettings {
            delay: begins_delayed,
            dead_band: begins_dead,
            current_loop: 0.0,
            ..given
        };
        let samples = |time: f64| time / units.sample_time();
        Ok(Self {
            dead_band,
            delay: samples(delay),
            current_loop: samples(given.current_loop),
            behind,
        })
    }
}
