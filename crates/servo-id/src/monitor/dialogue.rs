//! From keys to actions. Nothing moves the servo without being confirmed; a stop needs no confirmation.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

/// An action of the user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Do this, which moves the servo.
    Move(Motion),
    /// Release the servo.
    Stop,
    /// Move the servo to a position, rad from where it started.
    Target(f64),
    /// Clear a fault.
    Clear,
    /// Keep settings and estimates.
    Save,
    /// Begin a recording, or end it.
    Record,
    /// End the monitor.
    Quit,
}

/// A motion without a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Closing the loop.
    Start,
    /// A commissioning.
    Commission,
}

/// An open question to the user.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Dialogue {
    /// Nothing.
    #[default]
    Idle,
    /// Confirmation of a motion.
    Confirm(Motion),
    /// A target position: the text typed so far.
    Target(String),
    /// Confirmation of leaving while the servo is driven.
    Quit,
}

/// Characters of a target.
const MAX_TARGET_LENGTH: usize = 16;

impl Dialogue {
    /// Takes a key.
    pub fn press(&mut self, key: KeyEvent, is_driven: bool) -> Option<Action> {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        match key.code {
            KeyCode::Char('c') if control => return Some(Action::Quit),
            _ if control => return None,
            KeyCode::Char(' ') => {
                *self = Self::Idle;
                return Some(Action::Stop);
            }
            _ => {}
        }
        match self {
            Self::Idle => self.begin(key.code, is_driven),
            Self::Confirm(motion) => {
                let confirmed = Action::Move(*motion);
                *self = Self::Idle;
                is_yes(key.code).then_some(confirmed)
            }
            Self::Quit => {
                *self = Self::Idle;
                (is_yes(key.code) || key.code == KeyCode::Char('q')).then_some(Action::Quit)
            }
            Self::Target(typed) => match key.code {
                KeyCode::Enter => {
                    let target = number(typed)?;
                    *self = Self::Idle;
                    Some(Action::Target(target))
                }
                KeyCode::Esc => {
                    *self = Self::Idle;
                    None
                }
                KeyCode::Backspace => {
                    typed.pop();
                    None
                }
                KeyCode::Char(letter)
                    if typed.len() < MAX_TARGET_LENGTH && letter.is_ascii_graphic() =>
                {
                    typed.push(letter);
                    None
                }
                _ => None,
            },
        }
    }

    fn begin(&mut self, code: KeyCode, is_driven: bool) -> Option<Action> {
        match code {
            KeyCode::Char('s') => *self = Self::Confirm(Motion::Start),
            KeyCode::Char('c') => *self = Self::Confirm(Motion::Commission),
            KeyCode::Char('t') => *self = Self::Target(String::new()),
            KeyCode::Char('a') => return Some(Action::Stop),
            KeyCode::Char('f') => return Some(Action::Clear),
            KeyCode::Char('k') => return Some(Action::Save),
            KeyCode::Char('r') => return Some(Action::Record),
            KeyCode::Char('q') if is_driven => *self = Self::Quit,
            KeyCode::Char('q') => return Some(Action::Quit),
            _ => {}
        }
        None
    }
}

fn is_yes(code: KeyCode) -> bool {
    matches!(code, KeyCode::Char('y' | 'Y'))
}

/// The typed text as a finite number.
pub(super) fn number(typed: &str) -> Option<f64> {
    typed.parse().ok().filter(|place: &f64| place.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(keys: &str, is_driven: bool) -> (Dialogue, Vec<Action>) {
        let mut dialogue = Dialogue::default();
        let actions = keys
            .chars()
            .filter_map(|letter| {
                let code = match letter {
                    '\n' => KeyCode::Enter,
                    '\x1b' => KeyCode::Esc,
                    '\x08' => KeyCode::Backspace,
                    other => KeyCode::Char(other),
                };
                dialogue.press(KeyEvent::from(code), is_driven)
            })
            .collect();
        (dialogue, actions)
    }

    #[test]
    fn an_action_that_moves_the_servo_is_confirmed() {
        for (keys, motion) in [("sy", Motion::Start), ("cy", Motion::Commission)] {
            assert_eq!(typed(keys, false).1, [Action::Move(motion)]);
        }
        for keys in [
            "s", "sn", "s\x1b", "s\n", "sq", "c", "cn", "t", "t0.5", "t0.5\x1b", "t\n",
        ] {
            assert_eq!(typed(keys, false).1, [], "{keys:?}");
        }
    }

    #[test]
    fn a_target_is_a_number_and_is_sent_by_enter() {
        assert_eq!(typed("t-0.25\n", true).1, [Action::Target(-0.25)]);
        assert_eq!(typed("t1\x082e-1\n", true).1, [Action::Target(0.2)]);
        let (dialogue, actions) = typed("t0.5.1\n", true);
        assert_eq!(actions, []);
        assert_eq!(dialogue, Dialogue::Target("0.5.1".to_owned()));
        for refused in ["tinf\n", "tNaN\n", "tq\n"] {
            assert_eq!(typed(refused, true).1, [], "{refused:?}");
        }
    }

    #[test]
    fn a_stop_is_never_asked_about() {
        for before in ["", "s", "c", "t0.", "q"] {
            let (dialogue, actions) = typed(&format!("{before} "), true);
            assert_eq!((dialogue, actions), (Dialogue::Idle, vec![Action::Stop]));
        }
        assert_eq!(typed("a", true).1, [Action::Stop]);
    }

    #[test]
    fn who_leaves_a_driven_servo_is_asked() {
        assert_eq!(typed("q", false).1, [Action::Quit]);
        assert_eq!(typed("q", true), (Dialogue::Quit, vec![]));
        assert_eq!(typed("qx", true), (Dialogue::Idle, vec![]));
        for yes in ["qq", "qy"] {
            assert_eq!(typed(yes, true).1, [Action::Quit]);
        }
        let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        let mut dialogue = Dialogue::Target("1".to_owned());
        assert_eq!(dialogue.press(interrupt, true), Some(Action::Quit));
    }
}
