//! Which column holds which quantity: by its name, and where names do not decide by its content.

use super::name::{Named, Quantity, Unit, of_column};
use super::{Question, Stated};
use crate::log::{Table, TableColumn};
use crate::scan::explained_by;
use crate::scenario::{Column, CommandUnit, LogUnits, PositionUnit};

/// A column of the table that holds a quantity.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chosen {
    pub(super) index: usize,
    /// As `[log]` states it.
    pub(super) column: Column,
    /// The evidence: `stated`, `by its name`.
    pub(super) evidence: &'static str,
    pub(super) named: Named,
}

/// The columns of a log.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Columns {
    pub(super) time: Option<Chosen>,
    pub(super) position: Chosen,
    /// None of a servo that takes goals.
    pub(super) command: Option<Chosen>,
    pub(super) reference: Option<Chosen>,
    /// That of a servo that takes goals, where its loop acts on it.
    pub(super) velocity: Option<Chosen>,
}

/// The columns of a table by their names.
struct Candidates<'a> {
    table: &'a Table,
    named: Vec<Named>,
}

impl Columns {
    /// Finds them.
    ///
    /// # Errors
    /// The quantities whose columns are not known.
    pub(super) fn find(table: &Table, stated: &Stated) -> Result<Self, Vec<Question>> {
        let all = Candidates {
            table,
            named: (table.columns.iter())
                .map(|column| of_column(&column.name, &column.unit))
                .collect(),
        };
        let time = all.time(stated);
        let taken = |index: usize| time.as_ref().is_some_and(|time| time.index == index);
        if let Some(goal) = &stated.goal {
            return all.with_goal(goal, stated, time.clone());
        }
        let [positions, commands] = [
            (&stated.position, Quantity::Position),
            (&stated.command, Quantity::Command),
        ]
        .map(|(column, quantity)| match column {
            Some(column) => all.stated(column).map(|chosen| vec![chosen]),
            None => Some(all.of(quantity, &taken)),
        });
        let missing = |flag, column: &Option<String>| all.missing(flag, column);
        let positions = positions.ok_or_else(|| vec![missing("position", &stated.position)])?;
        let commands = commands.ok_or_else(|| vec![missing("command", &stated.command)])?;
        let (position, command) = all.pair(positions, commands)?;
        let reference = match stated.reference.as_deref() {
            Some("none") => None,
            Some(column) => Some(
                all.stated(column)
                    .ok_or_else(|| vec![missing("reference", &stated.reference)])?,
            ),
            None => {
                let others = all.of_name(Quantity::Reference, &taken).into_iter();
                let mut others =
                    others.filter(|of| of.index != position.index && of.index != command.index);
                others.find(|of| all.table.columns[of.index].is_moving())
            }
        };
        Ok(Self {
            time,
            position,
            command: Some(command),
            reference,
            velocity: None,
        })
    }
}

impl Columns {
    /// The unit of the command by the name of its column, where the command is not scaled and no inertia or torque is
    /// stated that another unit would have.
    pub(super) fn command_unit(&self, units: &LogUnits, stated: &Stated) -> Option<CommandUnit> {
        let Some(Unit::Command(unit)) = self.command.as_ref()?.named.unit else {
            return None;
        };
        let is_linear = matches!(
            units.position,
            PositionUnit::Metre | PositionUnit::Millimetre
        );
        let is_torque_stated = stated.torque_constant.is_some() || stated.inertia.is_some();
        let found = match unit {
            "V" => CommandUnit::Volt,
            "A" => CommandUnit::Ampere,
            "N m" if !is_linear && !is_torque_stated => CommandUnit::NewtonMetre,
            "N" if is_linear && !is_torque_stated => CommandUnit::Newton,
            _ => return None,
        };
        let is_scaled = (units.command_scale - 1.0).abs() > 0.0;
        (!is_scaled).then_some(found)
    }
}

impl Candidates<'_> {
    /// Part of a motion from which a command explains it.
    const EXPLAINED: f64 = 0.8;
    /// Columns that are tried as position or command.
    const MAX_TRIED: usize = 12;

    /// The columns of a servo whose goal is in this column.
    fn with_goal(
        &self,
        goal: &str,
        stated: &Stated,
        time: Option<Chosen>,
    ) -> Result<Columns, Vec<Question>> {
        let goal = (self.stated(goal)).ok_or_else(|| vec![self.missing("goal", &stated.goal)])?;
        let is_taken = |index: usize| {
            index == goal.index || time.as_ref().is_some_and(|time| time.index == index)
        };
        let position = match &stated.position {
            Some(column) => (self.stated(column))
                .ok_or_else(|| vec![self.missing("position", &stated.position)])?,
            None => match &self.of_name(Quantity::Position, &is_taken)[..] {
                [only] => only.clone(),
                _ => {
                    return Err(vec![Question {
                        flag: "position",
                        text: format!(
                            "which column is the measured position is not known, of {}",
                            self.names()
                        ),
                    }]);
                }
            },
        };
        let velocity = match &stated.velocity {
            Some(column) => Some(
                (self.stated(column))
                    .ok_or_else(|| vec![self.missing("velocity", &stated.velocity)])?,
            ),
            None => None,
        };
        Ok(Columns {
            time,
            position,
            command: None,
            reference: Some(goal),
            velocity,
        })
    }

    /// A column that is stated and missing.
    fn missing(&self, flag: &'static str, column: &Option<String>) -> Question {
        Question {
            flag,
            text: format!(
                "the log has no column {}, but {}",
                column.as_deref().unwrap_or_default(),
                self.names()
            ),
        }
    }

    fn chosen(&self, index: usize, evidence: &'static str) -> Chosen {
        let name = &self.table.columns[index].name;
        let is_alone = self
            .table
            .columns
            .iter()
            .filter(|of| of.name == *name)
            .count()
            == 1;
        let by_name = self.table.has_heading && !name.is_empty() && is_alone;
        let number = u32::try_from(index + 1).unwrap_or(u32::MAX);
        Chosen {
            index,
            column: match by_name {
                true => Column::named(name),
                false => Column::Number(number),
            },
            evidence,
            named: self.named[index],
        }
    }

    /// The column of a name, or else of a number from 1.
    fn stated(&self, stated: &str) -> Option<Chosen> {
        let columns = &self.table.columns;
        let by_number = || {
            let number: usize = stated.parse().ok()?;
            (1..=columns.len()).contains(&number).then(|| number - 1)
        };
        let index = (columns.iter().position(|of| of.name == stated)).or_else(by_number)?;
        Some(self.chosen(index, "as stated"))
    }

    /// Their names, or numbers.
    fn names(&self) -> String {
        let names =
            self.table
                .columns
                .iter()
                .zip(1..)
                .map(|(of, number)| match of.name.is_empty() {
                    true => number.to_string(),
                    false => of.name.clone(),
                });
        crate::nearest::shortened(&names.collect::<Vec<_>>().join(", "), 120)
    }

    /// The columns that have the name of a quantity, with numbers.
    fn of_name(&self, quantity: Quantity, taken: &dyn Fn(usize) -> bool) -> Vec<Chosen> {
        let all = self.named.iter().enumerate();
        all.filter(|(index, named)| named.quantity == quantity && !taken(*index))
            .filter(|(index, _)| self.table.columns[*index].numbers > 0)
            .map(|(index, _)| self.chosen(index, "by its name"))
            .collect()
    }

    /// The columns that may hold a quantity: by their names, or else those whose names say nothing.
    fn of(&self, quantity: Quantity, taken: &dyn Fn(usize) -> bool) -> Vec<Chosen> {
        let named = self.of_name(quantity, taken);
        if !named.is_empty() {
            return named;
        }
        let mut unknown = self.of_name(Quantity::Unknown, taken);
        unknown.retain(|of| self.table.columns[of.index].is_moving());
        unknown.truncate(Self::MAX_TRIED);
        for of in &mut unknown {
            of.evidence = "by its content";
        }
        unknown
    }

    /// The column of the time: stated, by its name, or stamps or even steps.
    fn time(&self, stated: &Stated) -> Option<Chosen> {
        match stated.time.as_deref() {
            Some("none") => return None,
            Some(column) => return self.stated(column),
            None => {}
        }
        let is_known = |chosen: &Chosen| {
            [&stated.position, &stated.command, &stated.reference]
                .into_iter()
                .flatten()
                .any(|column| {
                    self.stated(column)
                        .is_some_and(|of| of.index == chosen.index)
                })
        };
        let [times, counters] = [Quantity::Time, Quantity::Counter].map(|quantity| {
            let all = self.named.iter().enumerate();
            let mut all: Vec<_> = all
                .filter(|(_, named)| named.quantity == quantity)
                .filter(|(index, _)| self.table.columns[*index].has_values())
                .map(|(index, _)| self.chosen(index, "by its name"))
                .filter(|chosen| !is_known(chosen))
                .collect();
            // Of several, one that advances, and one whose unit is known.
            all.sort_by_key(|of| {
                let column = &self.table.columns[of.index];
                (!column.advances(), of.named.unit.is_none())
            });
            all
        });
        let by_content = || {
            let all = self.named.iter().enumerate();
            all.filter(|(_, named)| named.quantity == Quantity::Unknown)
                .find(|(index, _)| self.table.columns[*index].is_even())
                .map(|(index, _)| self.chosen(index, "by its even steps"))
                .filter(|chosen| !is_known(chosen))
        };
        (times.into_iter().chain(counters).next()).or_else(by_content)
    }

    /// The position and the command that moves it most clearly.
    fn pair(
        &self,
        positions: Vec<Chosen>,
        commands: Vec<Chosen>,
    ) -> Result<(Chosen, Chosen), Vec<Question>> {
        /// Where the second pair leaves less than this many times what the first leaves, both would do.
        const CLEARLY: f64 = 1.5;
        if let ([position], [command]) = (&positions[..], &commands[..])
            && position.index != command.index
            && [position, command]
                .iter()
                .all(|of| of.evidence != "by its content")
        {
            return Ok((position.clone(), command.clone()));
        }
        let mut pairs = Vec::new();
        for position in &positions {
            let motion = self.table.columns[position.index].continued();
            for command in commands.iter().filter(|of| of.index != position.index) {
                let input = self.table.columns[command.index].held();
                pairs.push((explained_by(&motion, &input), position, command));
            }
        }
        pairs.sort_by(|one, other| other.0.total_cmp(&one.0));
        let clear = pairs.first().filter(|best| best.0 > Self::EXPLAINED);
        let is_alone = clear.is_some_and(|best| {
            let left = 1.0 - best.0;
            pairs[1..]
                .iter()
                .all(|other| 1.0 - other.0 > CLEARLY * left)
        });
        // Names alone decide between a set-point and its measurement, or two encoders: the clearest is taken.
        let all_named = (positions.iter().chain(&commands)).all(|of| of.evidence == "by its name");
        if let Some((_, position, command)) = clear.filter(|_| is_alone || all_named) {
            let of = |chosen: &Chosen, count: usize| Chosen {
                evidence: match chosen.evidence {
                    "by its name" if count > 1 => "by its name, the clearest of several",
                    other => other,
                },
                ..chosen.clone()
            };
            return Ok((of(position, positions.len()), of(command, commands.len())));
        }
        let question = |flag, quantity: &str, found: &[Chosen]| {
            let unknown = match found {
                [only] => only.evidence == "by its content",
                _ => true,
            };
            unknown.then(|| Question {
                flag,
                text: format!(
                    "which column is the {quantity} is not known, of {}",
                    self.names()
                ),
            })
        };
        let mut of_command = question("command", "command that acted", &commands);
        let is_moving = |of: &Chosen| self.table.columns[of.index].is_moving();
        if let Some(question) = &mut of_command
            && let Some(goal) =
                (self.of_name(Quantity::Reference, &|_| false).into_iter()).find(is_moving)
        {
            question.text += &format!(
                "; if the servo has a position loop of its own, {} is its goal: state --goal {0} and --kp, its gain",
                goal.column
            );
        }
        let questions: Vec<_> = [
            question("position", "measured position", &positions),
            of_command,
        ]
        .into_iter()
        .flatten()
        .collect();
        match (&positions[..], &commands[..]) {
            ([position], [command]) if questions.is_empty() => {
                Ok((position.clone(), command.clone()))
            }
            _ => Err(questions),
        }
    }
}

impl TableColumn {
    fn has_values(&self) -> bool {
        self.numbers + self.stamps > 0
    }

    /// True if its numbers differ.
    pub(super) fn is_moving(&self) -> bool {
        let (low, high) = crate::log::extremes(&self.values);
        low < high
    }

    fn steps(&self) -> impl Iterator<Item = f64> + '_ {
        self.values.windows(2).map(|pair| pair[1] - pair[0])
    }

    /// True if no number is before the last.
    pub(super) fn advances(&self) -> bool {
        self.is_moving() && self.steps().all(|step| step >= 0.0)
    }

    /// True if it advances by nearly even steps.
    fn is_even(&self) -> bool {
        /// Largest step, usual ones, and part of the steps within it.
        const MAX_STEP: f64 = 3.0;
        const MIN_SHARE: f64 = 0.95;
        /// Fewest steps.
        const MIN_STEPS: usize = 9;
        let mut steps: Vec<_> = self.steps().collect();
        if steps.len() < MIN_STEPS || !self.advances() {
            return false;
        }
        steps.sort_unstable_by(f64::total_cmp);
        let usual = steps[steps.len() / 2];
        let within =
            (steps.iter()).filter(|step| **step < MAX_STEP * usual && **step > usual / MAX_STEP);
        usual > 0.0 && within.count() as f64 > MIN_SHARE * steps.len() as f64
    }

    /// Its numbers, the one before where there is none.
    pub(super) fn held(&self) -> Vec<f64> {
        let first = self.values.iter().copied().find(|value| value.is_finite());
        let mut last = first.unwrap_or(0.0);
        let held = |value: &f64| {
            if value.is_finite() {
                last = *value;
            }
            last
        };
        self.values.iter().map(held).collect()
    }

    /// Its numbers as positions, continued where they begin again.
    pub(super) fn continued(&self) -> Vec<f64> {
        /// Part of the range from which a step begins again.
        const JUMP: f64 = 0.7;
        let mut positions = self.held();
        let (low, high) = crate::log::extremes(&positions);
        let range = high - low;
        let mut offset = 0.0;
        let mut last = positions.first().copied().unwrap_or(0.0);
        for position in &mut positions {
            let step = *position - last;
            last = *position;
            if step.abs() > JUMP * range {
                offset -= step.signum() * range;
            }
            *position += offset;
        }
        positions
    }
}
