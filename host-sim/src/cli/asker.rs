//! Questions at a terminal.

use std::io::{self, BufRead, IsTerminal, Write};

use super::fault::Fault;
use super::terminal::folded_error;
use crate::init::data_sheet;

/// Asks for missing options, where there is a terminal.
pub(super) struct Asker {
    pub(super) is_there: bool,
}

impl Asker {
    pub(super) fn at_terminal() -> Self {
        Self {
            is_there: io::stdin().is_terminal() && io::stderr().is_terminal(),
        }
    }

    /// A number of a data sheet: stated, asked for, or the usual one. One that no motor has is refused if it was
    /// stated, and asked for again.
    pub(super) fn number(
        &self,
        stated: Option<f64>,
        name: &'static str,
        meaning: &str,
        usual: Option<f64>,
    ) -> Result<f64, Fault> {
        if let Some(stated) = stated {
            let checked = data_sheet::check(name, stated);
            return checked
                .map(|()| stated)
                .map_err(|error| Fault::Input(error.to_string()));
        }
        if !self.is_there {
            return usual.ok_or_else(|| Fault::Input(format!("--{name} is missing: {meaning}")));
        }
        let usual_shown = usual.map_or(String::new(), |usual| format!(" [{usual}]"));
        loop {
            let answer = ask(&format!("{meaning}{usual_shown}: "))?;
            let number = match (answer.trim().parse(), usual) {
                (Ok(number), _) if f64::is_finite(number) => number,
                (Err(_), Some(usual)) if answer.trim().is_empty() => return Ok(usual),
                _ => {
                    prompt("a number, as 0.05 or 5e-2\n")?;
                    continue;
                }
            };
            match data_sheet::check(name, number) {
                Ok(()) => return Ok(number),
                Err(error) => prompt(&format!("{error}\n"))?,
            }
        }
    }
}

pub(super) fn ask(question: &str) -> Result<String, Fault> {
    prompt(question)?;
    let mut answer = String::new();
    let read = io::stdin().lock().read_line(&mut answer);
    match read {
        Ok(0) | Err(_) => Err(Fault::Input("no answer: nothing is written".to_owned())),
        Ok(_) => Ok(answer),
    }
}

pub(super) fn prompt(text: &str) -> Result<(), Fault> {
    let mut terminal = io::stderr();
    terminal
        .write_all(folded_error(text).as_bytes())
        .and_then(|()| terminal.flush())
        .map_err(|error| Fault::unwritable("the terminal", &error))
}
