//! Finds the quantity of each column. Readings of the columns compete, and names weigh against them.

use super::name::{Named, Quantity, is_role, of_column, words};
use super::position;
use super::unit::Unit;
use super::{log_options::LogOptions, question::Question};
use crate::log::{Table, TableColumn, extremes, usual_steps};
use crate::readings::{Contest, HEARD, Kin, Order, Reading, Signals, Trial, held};
use crate::scenario::{Column, CommandUnit, LogUnits, PositionUnit, TimeUnit};

/// A column of the table that holds a quantity.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chosen {
    pub(super) index: usize,
    /// As `[log]` states it.
    pub(super) column: Column,
    /// The evidence: `as stated`, `by its name`.
    pub(super) evidence: String,
    pub(super) named: Named,
}

/// The columns of a log.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Columns {
    pub(super) time: Option<Chosen>,
    pub(super) position: Chosen,
    /// True if that is a velocity.
    pub(super) is_velocity: bool,
    /// None of a servo that takes goals.
    pub(super) command: Option<Chosen>,
    /// True if the command goes against the motion.
    pub(super) is_reversed: bool,
    pub(super) reference: Option<Chosen>,
    /// That of a servo that takes goals, where its loop acts on it.
    pub(super) velocity: Option<Chosen>,
    pub(super) known_torque: Option<Chosen>,
    /// The reading that explains nearly as much, and further servos.
    pub(super) next: Option<String>,
}

/// The columns of a table by their names.
pub(super) struct Candidates<'a> {
    table: &'a Table,
    named: Vec<Named>,
}

/// The time of the rows of a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Clock {
    pub(super) chosen: Option<Chosen>,
    pub(super) unit: TimeUnit,
    pub(super) evidence: &'static str,
    /// True if nothing shows the unit.
    pub(super) is_assumed: bool,
}

impl Columns {
    /// Units of the command for one of its column's, by the column's name unless another unit is stated.
    pub(super) fn command_part(&self, stated: Option<CommandUnit>) -> f64 {
        let is_it = |unit: &str| {
            stated.is_none_or(|stated| {
                stated == CommandUnit::Other || stated.name() == unit.replace(' ', "")
            })
        };
        match self.command.as_ref().and_then(|command| command.named.unit) {
            Some(Unit::Command(unit, part)) if is_it(unit) => part,
            _ => 1.0,
        }
    }

    /// The unit of the command by the name of its column, if this is the scale that the name implies.
    pub(super) fn named_unit(&self, scale: f64) -> Option<&'static str> {
        match self.command.as_ref()?.named.unit {
            Some(Unit::Command(unit, part)) if (scale.abs() / part - 1.0).abs() < 1e-9 => {
                Some(unit)
            }
            _ => None,
        }
    }

    /// The same as a unit of torques. It applies if no stated inertia or torque implies another.
    pub(super) fn command_unit(
        &self,
        units: &LogUnits,
        stated: &LogOptions,
    ) -> Option<CommandUnit> {
        let unit = self.named_unit(units.command_scale)?;
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
        Some(found)
    }
}

/// Doubts up to which names decide, and the fit judges.
const NAMED: i32 = 1;

/// The evidence of names against a column that is measured, and against one that commands.
const fn against_measured(quantity: Quantity) -> i32 {
    match quantity {
        Quantity::Position | Quantity::Velocity => 0,
        Quantity::Unknown => 1,
        Quantity::Reference | Quantity::Command => 3,
        Quantity::Other | Quantity::Time | Quantity::Counter => 4,
    }
}

const fn against_command(quantity: Quantity) -> i32 {
    match quantity {
        Quantity::Command | Quantity::Reference => 0,
        Quantity::Unknown => 1,
        Quantity::Position | Quantity::Velocity | Quantity::Other => 3,
        Quantity::Time | Quantity::Counter => 4,
    }
}

impl<'a> Candidates<'a> {
    pub(super) fn of(table: &'a Table) -> Self {
        let named = table.columns.iter();
        Self {
            table,
            named: named
                .map(|column| of_column(&column.name, &column.unit))
                .collect(),
        }
    }

    /// The columns that are measured and command.
    ///
    /// # Errors
    /// The quantities whose columns are not known.
    pub(super) fn find(
        &self,
        stated: &LogOptions,
        clock: &Clock,
    ) -> Result<Columns, Vec<Question>> {
        let find = |flag, column: &Option<String>| match column.as_deref() {
            None | Some("none") => Ok(None),
            Some(name) => match self.stated(name) {
                Some(chosen) => Ok(Some(chosen)),
                None => Err(vec![self.missing(flag, name)]),
            },
        };
        let goal = find("goal", &stated.goal)?;
        let command = find("command", &stated.command)?;
        let velocity = find("velocity", &stated.velocity)?;
        let (position, velocity) = match stated.measures_velocity() {
            true => (velocity, None),
            false => (find("position", &stated.position)?, velocity),
        };
        let reference = find("reference", &stated.reference)?;
        let known_torque = find("known-torque", &stated.known_torque)?;
        let pushes = goal.as_ref().or(command.as_ref());
        let aside = known_torque.as_ref();
        let found = self.contest(clock, position.as_ref(), pushes, aside, stated)?;
        let of = |index: usize, is_stated: bool| {
            let evidence = match self.named[index].quantity {
                _ if is_stated => "as stated",
                Quantity::Unknown | Quantity::Other => "by content",
                _ => "by name",
            };
            self.chosen(index, evidence)
        };
        let measured = of(found.reading.trial.measured, position.is_some());
        let pusher = of(found.reading.trial.command, pushes.is_some());
        let is_goal =
            goal.is_some() || (command.is_none() && pusher.named.quantity == Quantity::Reference);
        // The sign that is stated of the position is not in its column yet.
        let is_turned = stated.position_scale.is_some_and(|scale| scale < 0.0);
        let is_against = found.is_reversed != is_turned;
        Ok(Columns {
            time: clock.chosen.clone(),
            is_velocity: found.reading.trial.order == Order::Velocity,
            is_reversed: !is_goal && is_against && stated.command_scale.is_none(),
            position: measured,
            command: (!is_goal).then(|| pusher.clone()),
            reference: if is_goal { Some(pusher) } else { reference },
            velocity,
            known_torque,
            next: found.next,
        })
    }

    /// A column that is stated and missing.
    fn missing(&self, flag: &'static str, column: &str) -> Question {
        Question {
            flag,
            text: format!("the log has no column {column}, but {}", self.names()),
        }
    }

    fn chosen(&self, index: usize, evidence: &str) -> Chosen {
        let name = &self.table.columns[index].name;
        let same = self.table.columns.iter().filter(|of| of.name == *name);
        let by_name = self.table.has_heading && !name.is_empty() && same.count() == 1;
        let number = u32::try_from(index + 1).unwrap_or(u32::MAX);
        Chosen {
            index,
            column: match by_name {
                true => Column::named(name),
                false => Column::Number(number),
            },
            evidence: evidence.to_owned(),
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
            (self.table.columns.iter().zip(1..)).map(|(of, number)| match of.name.is_empty() {
                true => number.to_string(),
                false => of.name.clone(),
            });
        crate::nearest::shortened(&names.collect::<Vec<_>>().join(", "), 120)
    }

    fn name(&self, index: usize) -> String {
        self.chosen(index, "").column.to_string()
    }

    /// The columns that have the name of a quantity, with numbers.
    fn of_name(&self, quantity: Quantity) -> Vec<Chosen> {
        let all = self.named.iter().enumerate();
        all.filter(|(index, named)| {
            named.quantity == quantity && self.table.columns[*index].has_values()
        })
        .map(|(index, _)| self.chosen(index, "by name"))
        .collect()
    }

    /// The time of the rows: the stated column, one by its name, or one of even steps.
    ///
    /// # Errors
    /// A stated column that is missing.
    pub(super) fn clock(&self, stated: &LogOptions) -> Result<Clock, Question> {
        let chosen = match stated.time.as_deref() {
            Some("none") => None,
            Some(column) => {
                Some((self.stated(column)).ok_or_else(|| self.missing("time", column))?)
            }
            None => self.time(stated),
        };
        let Some(time) = &chosen else {
            return Ok(Clock {
                chosen,
                unit: TimeUnit::Second,
                evidence: "",
                is_assumed: false,
            });
        };
        let column = &self.table.columns[time.index];
        let is_stamped = 2 * column.stamps > column.values.len();
        let is_open = stated.time_unit.is_none() && stated.sample_time.is_none();
        if is_open && time.named.unit == Some(Unit::Doubtful) {
            let doubt = "a unit that is not known";
            return Err(Self::unknown_step(&time.column, doubt));
        }
        if stated.sample_time.is_none() && column.stands_still() {
            let doubt =
                "stamps that hold for so many rows that they do not tell how far two are apart";
            return Err(Self::unknown_step(&time.column, doubt));
        }
        let named = match time.named.unit {
            Some(Unit::Time(unit)) => Some(unit),
            _ => None,
        };
        let (unit, evidence, is_assumed) = match (stated.time_unit, named) {
            (Some(unit), _) => (unit, "as stated", false),
            _ if is_stamped => (TimeUnit::Stamp, "by time stamps", false),
            (_, Some(unit)) if self.is_possible(time, unit) => (unit, "by name", false),
            (_, named) => {
                let (unit, is_only) = self.by_steps(time);
                let evidence = match (named, is_only) {
                    (Some(_), _) => "the unit in the name gives no plausible sample time",
                    (None, true) => "the only one in which its rows and their number are plausible",
                    (None, false) => "assumed: the sample time is then plausible",
                };
                (unit, evidence, !is_only)
            }
        };
        Ok(Clock {
            chosen,
            unit,
            evidence,
            is_assumed: is_assumed && is_open && unit != TimeUnit::Sample,
        })
    }

    /// The time from row to row, of a column whose own time has a doubt.
    fn unknown_step(column: &Column, doubt: &str) -> Question {
        Question {
            flag: "sample-time",
            text: format!("{column} has {doubt}: state the time from one row to the next, in s"),
        }
    }

    /// The usual step of a time.
    fn step(&self, time: &Chosen) -> f64 {
        let times = held(&self.table.columns[time.index].values);
        usual_steps(times.iter().copied()).map_or(f64::NAN, |[median, _]| median)
    }

    /// True for a unit in which rows are as far apart as those of a log may be.
    fn is_possible(&self, time: &Chosen, unit: TimeUnit) -> bool {
        /// Times from row to row, s.
        const POSSIBLE: std::ops::RangeInclusive<f64> = 4e-6..=0.6;
        let step = self.step(time);
        let is_known = |unit: TimeUnit| {
            unit.seconds()
                .is_some_and(|of| POSSIBLE.contains(&(of * step)))
        };
        is_known(unit) || step.is_nan() || !TimeUnit::ALL.iter().any(|unit| is_known(*unit))
    }

    /// The unit of a time that neither name nor statement has, by the size of its steps. True if no other is possible.
    fn by_steps(&self, time: &Chosen) -> (TimeUnit, bool) {
        /// Times from row to row, the usual one, and the least from the first to the last, s.
        const ROWS: std::ops::RangeInclusive<f64> = 2e-5..=0.6;
        const USUAL: f64 = 5e-3;
        const LEAST: f64 = 0.5;
        const UNITS: [TimeUnit; 4] = [
            TimeUnit::Second,
            TimeUnit::Millisecond,
            TimeUnit::Microsecond,
            TimeUnit::Nanosecond,
        ];
        let step = self.step(time);
        // Rows that are numbered are no time, unless the heading says so.
        let (is_numbered, is_named) = (
            (step - 1.0).abs() < 1e-6,
            time.named.quantity == Quantity::Time,
        );
        if is_numbered && !is_named {
            return (TimeUnit::Sample, false);
        }
        let of = |unit: &TimeUnit| unit.seconds().unwrap_or(f64::NAN) * step;
        let is_long = |unit: &TimeUnit| of(unit) * self.table.rows() as f64 > LEAST;
        let only = |mut units: Vec<TimeUnit>| units.pop().filter(|_| units.is_empty());
        let mut of_rows = UNITS.to_vec();
        of_rows.retain(|unit| ROWS.contains(&of(unit)));
        let long = of_rows.iter().copied().filter(is_long).collect();
        if let Some(unit) = only(of_rows).or_else(|| only(long)) {
            let is_counter = time.named.quantity == Quantity::Counter;
            return (unit, !is_numbered && !is_counter);
        }
        let off = |unit: &TimeUnit| (of(unit) / USUAL).ln().abs();
        let likeliest = (UNITS.into_iter()).min_by(|one, other| off(one).total_cmp(&off(other)));
        (likeliest.unwrap_or(TimeUnit::Second), false)
    }

    fn time(&self, stated: &LogOptions) -> Option<Chosen> {
        let is_known = |chosen: &Chosen| {
            let others = [&stated.position, &stated.command, &stated.reference];
            let mut others = others.into_iter().flatten();
            others.any(|column| {
                self.stated(column)
                    .is_some_and(|of| of.index == chosen.index)
            })
        };
        let named = |quantity: Quantity| {
            let all = self.of_name(quantity).into_iter();
            let all = all.filter(|of| !is_known(of) && self.table.columns[of.index].runs_on());
            // Of several, one that advances, in all rows, and whose unit is known.
            all.min_by_key(|of| {
                let column = &self.table.columns[of.index];
                let blank = column.values.iter().filter(|value| value.is_nan()).count();
                (!column.advances(), blank, of.named.unit.is_none())
            })
        };
        let by_content = || {
            let all = self.named.iter().enumerate();
            all.filter(|(_, named)| named.quantity == Quantity::Unknown)
                .find(|(index, _)| self.table.columns[*index].is_even())
                .map(|(index, _)| self.chosen(index, "by even steps"))
                .filter(|chosen| !is_known(chosen))
        };
        named(Quantity::Time)
            .or_else(|| named(Quantity::Counter))
            .or_else(by_content)
    }

    /// The signals of all columns, at the times of a clock.
    fn signals(&self, clock: &Clock, sample_time: Option<f64>) -> Signals {
        /// Steps from which a motion begins anew.
        const GAP: f64 = 20.0;
        let rows = self.table.rows();
        let scale = clock.unit.seconds().or(sample_time).unwrap_or(1.0);
        let times: Vec<f64> = match &clock.chosen {
            Some(time) => {
                let times = held(&self.table.columns[time.index].values);
                times.iter().map(|time| scale * time).collect()
            }
            None => (0..rows)
                .map(|row| row as f64 * sample_time.unwrap_or(1.0))
                .collect(),
        };
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let usual = usual_steps(times.iter().copied()).map_or(1.0, |[median, _]| median);
        let is_break = |step: &f64| *step < 0.0 || *step > GAP * usual;
        let mut begins: Vec<bool> = std::iter::once(true)
            .chain(steps.iter().map(is_break))
            .collect();
        for begin in &self.table.begins {
            begins[*begin] = true;
        }
        for step in &mut steps {
            *step = if is_break(step) {
                usual
            } else {
                step.max(1e-3 * usual)
            };
        }
        steps.push(usual);
        let columns = self.table.columns.iter();
        let positions: Vec<Vec<f64>> = columns.clone().map(TableColumn::continued).collect();
        let commands = columns.map(|column| column.values.clone()).collect();
        let cells = positions.iter().map(|column| cell(column)).collect();
        Signals::new(steps, begins, [positions, commands], cells)
    }

    /// Lets the readings of the columns but one `aside` compete, with a stated `position` and a stated command that
    /// `pushes`.
    fn contest(
        &self,
        clock: &Clock,
        position: Option<&Chosen>,
        pushes: Option<&Chosen>,
        aside: Option<&Chosen>,
        stated: &LogOptions,
    ) -> Result<Found, Vec<Question>> {
        let signals = self.signals(clock, stated.sample_time);
        let kin = Kin::of(&signals);
        let Kin { copies, rates, .. } = &kin;
        let is_time = |index: usize| {
            let is_clock = clock
                .chosen
                .as_ref()
                .is_some_and(|time| time.index == index);
            is_clock
                || matches!(
                    self.named[index].quantity,
                    Quantity::Time | Quantity::Counter
                )
        };
        let moving: Vec<usize> = (0..self.table.columns.len())
            .filter(|index| aside.is_none_or(|aside| aside.index != *index))
            .filter(|index| !is_time(*index) && self.table.columns[*index].is_moving())
            .collect();
        let quantity = |index: usize| self.named[index].quantity;
        let has_command = moving
            .iter()
            .any(|index| quantity(*index) == Quantity::Command);
        // What a loop of the current does lags behind what it should, and is noisy.
        let has_wanted = moving
            .iter()
            .any(|index| quantity(*index) == Quantity::Command && self.named[*index].is_wanted);
        let is_one = |stated: Option<&Chosen>, index: usize| {
            stated.map_or_else(|| moving.contains(&index), |of| of.index == index)
        };
        let mut trials = Vec::new();
        let all = 0..self.table.columns.len();
        for measured in all.clone().filter(|index| is_one(position, *index)) {
            for command in all.clone().filter(|index| is_one(pushes, *index)) {
                let are = |of: &[Option<usize>]| Kin::are(of, measured, command);
                // What is called a command may accelerate by one: of a mass without friction.
                let is_kin = are(copies)
                    || are(rates)
                    || (are(&kin.accelerations) && quantity(command) != Quantity::Command);
                let is_stated = position.is_some() && pushes.is_some();
                if measured == command || (is_kin && !is_stated) {
                    continue;
                }
                // If two columns are identical, the one with the clearer name is used.
                let is_copy = |index: usize| {
                    copies[index].is_some_and(|other| !is_time(other))
                        && quantity(index) == Quantity::Unknown
                };
                if (is_copy(measured) && position.is_none())
                    || (is_copy(command) && pushes.is_none())
                {
                    continue;
                }
                // A position that follows its goal, or its command behind a lag, looks like a velocity under a command.
                let is_position = stated.goal.is_some()
                    || position.is_some()
                    || quantity(measured) == Quantity::Position;
                let orders = match stated.measures_velocity() {
                    true => &[Order::Velocity][..],
                    false if is_position => &[Order::Position],
                    false => &[Order::Position, Order::Velocity],
                };
                for &order in orders {
                    let is_rate = quantity(measured) == Quantity::Velocity;
                    let is_other_order = match quantity(measured) {
                        Quantity::Position | Quantity::Velocity => {
                            is_rate != (order == Order::Velocity)
                        }
                        _ => false,
                    };
                    let of_position = if position.is_some() {
                        0
                    } else {
                        against_measured(quantity(measured))
                    };
                    let of_command = if pushes.is_some() {
                        0
                    } else {
                        against_command(quantity(command))
                    };
                    // The loop of a goal would have a gain that nobody states.
                    let of_goal = match quantity(command) {
                        Quantity::Reference if pushes.is_none() => 1 + i32::from(has_command),
                        _ => 0,
                    };
                    let of_pair = self.named[command];
                    let is_answer = pushes.is_none() && of_pair.is_measured && has_wanted;
                    let reservation = of_position
                        + of_command
                        + 2 * i32::from(!is_stated && self.are_of_other_joints(measured, command))
                        + 3 * i32::from(is_other_order)
                        + of_goal
                        + i32::from(is_answer);
                    trials.push(Trial {
                        measured,
                        command,
                        order,
                        reservation,
                    });
                }
            }
        }
        if trials.is_empty() {
            let own = moving.iter().filter(|index| copies[**index].is_none());
            let changing: Vec<_> = own.map(|index| self.name(*index)).collect();
            return Err(vec![Question {
                flag: "command",
                text: format!(
                    "position and command must both change and not be copies or rates of each other, but only these columns \
                     change and are no copies: {}; record the command that acts",
                    match changing.len() {
                        0 => "none".to_owned(),
                        _ => crate::nearest::shortened(&changing.join(", "), 120),
                    }
                ),
            }]);
        }
        let contest = Contest::of(&signals, trials);
        let none = || {
            let open = [
                (
                    position,
                    "position",
                    "measured position, or with --velocity the velocity",
                ),
                (pushes, "command", "command that acted"),
            ];
            let open = open.into_iter().filter(|(stated, ..)| stated.is_none());
            let questions = open.map(|(_, flag, quantity)| self.question(flag, quantity));
            questions.collect::<Vec<_>>()
        };
        let best = self.chosen_reading(&contest).ok_or_else(none)?;
        let is_reversed = signals.is_reversed(&best.trial, self.radian(&best.trial, stated));
        if pushes.is_none() {
            self.must_push(&best.trial, is_reversed, stated)?;
        }
        // Two columns that are nearly one explain alike and give nearly the same servo, and so do a position and its rate.
        let same = |one: usize, other: usize| {
            one == other
                || signals.are_alike(one, other)
                || [rates[one], rates[other]] == [Some(other), None]
                || [rates[one], rates[other]] == [None, Some(one)]
        };
        let rival = contest.0.iter().find(|rival| {
            let is_other = !same(rival.trial.measured, best.trial.measured)
                || !same(rival.trial.command, best.trial.command);
            let of_rate = self.is_rate_of(rival.trial.measured, best.trial.measured);
            is_other
                && !of_rate
                && rival.trial.reservation <= best.trial.reservation
                && best.is_rivalled_by(rival, best.trial.reservation <= NAMED)
        });
        if let Some(rival) = rival {
            let [one, other] = [best.trial, rival.trial];
            let open = [
                (
                    "position",
                    "measured position",
                    one.measured,
                    other.measured,
                ),
                ("command", "command that acted", one.command, other.command),
            ];
            let open = open.into_iter().filter(|(_, _, one, other)| one != other);
            return Err(open
                .map(|(flag, what, one, other)| self.either(flag, what, one, other))
                .collect());
        }
        let open = none();
        if best.trial.reservation > NAMED && best.is_ambiguous() && !open.is_empty() {
            return Err(open);
        }
        let other = contest.0.iter().find(|other| other.trial != best.trial);
        let next = other
            .filter(|other| other.score() > 0.1 * best.score())
            .map(|other| {
                let order = match other.trial.order == best.trial.order {
                    true => "",
                    false if other.trial.order == Order::Velocity => " as a velocity",
                    false => " as a position",
                };
                format!(
                    "alternative: {}{order} driven by {}, evidence {:.0} bits instead of {:.0}",
                    self.name(other.trial.measured),
                    self.name(other.trial.command),
                    other.score(),
                    best.score()
                )
            });
        let mut taken = vec![best.trial.measured, best.trial.command];
        let others = contest.0.iter().filter(|other| {
            let own = [other.trial.measured, other.trial.command];
            let is_free = !own.iter().any(|column| taken.contains(column));
            let is_servo = is_free && other.trial.reservation <= NAMED && !other.is_ambiguous();
            if is_servo {
                taken.extend(own);
            }
            is_servo
        });
        let further = others.map(|other| {
            let [position, command] =
                [other.trial.measured, other.trial.command].map(|column| self.name(column));
            format!("another servo: --position {position} --command {command}")
        });
        let said: Vec<String> = next.into_iter().chain(further).collect();
        Ok(Found {
            reading: best,
            is_reversed,
            next: (!said.is_empty()).then(|| said.join("; ")),
        })
    }

    /// The units of a trial's measured column to a rad; zero where it is no angle.
    fn radian(&self, trial: &Trial, stated: &LogOptions) -> f64 {
        let is_velocity = trial.order == Order::Velocity;
        let column = &self.table.columns[trial.measured];
        let read = position::read(column, &self.named[trial.measured], is_velocity, stated);
        let units = LogUnits {
            counts_per_rev: read.counts_per_rev,
            ..LogUnits::SI
        };
        let is_angle = match read.unit {
            PositionUnit::Radian | PositionUnit::Degree | PositionUnit::Turn => true,
            PositionUnit::Count => read.counts_per_rev.is_some(),
            PositionUnit::Metre | PositionUnit::Millimetre | PositionUnit::Own => false,
        };
        let per_rad = 1.0 / (units.radians(read.unit) * read.scale);
        if is_angle { per_rad } else { 0.0 }
    }

    /// A command by its name that cannot have acted, beside a goal, or one without a name whose sign is that of a goal.
    fn must_push(
        &self,
        trial: &Trial,
        is_reversed: bool,
        stated: &LogOptions,
    ) -> Result<(), Vec<Question>> {
        let own = self.name(trial.command);
        let text = match self.named[trial.command].quantity {
            Quantity::Reference => {
                let mut all = self.named.iter().zip(&self.table.columns).zip(0..);
                let still = all.find(|((named, column), _)| {
                    named.quantity == Quantity::Command && !column.is_moving()
                });
                still.map(|((_, column), index)| {
                    let fault = match column.has_values() {
                        true => "does not change",
                        false => "is empty",
                    };
                    format!(
                        "{} is a command by its name, but {fault}: record the command that acts, or state the loop of \
                         the servo by --goal {own} and --kp",
                        self.name(index)
                    )
                })
            }
            Quantity::Unknown if is_reversed && stated.command_scale.is_none() => Some(format!(
                "{own} goes against the motion, as a command of the other sign does, or a goal: state it with --command \
                 and --command-scale -1, or with --goal"
            )),
            _ => None,
        };
        let flag = "command";
        text.map_or(Ok(()), |text| Err(vec![Question { flag, text }]))
    }

    /// The reading that the fit judges: the best of those that names favour, or else the best of all. A position
    /// precedes a velocity, and the order in a name precedes the other, unless the motion clearly favours it.
    fn chosen_reading(&self, contest: &Contest) -> Option<Reading> {
        /// Bits for a reading over those of one that goes before it.
        const CLEARLY: f64 = 3.0;
        let least = contest
            .0
            .iter()
            .map(|reading| reading.trial.reservation)
            .min()?;
        let strongest = *contest.0.first()?;
        let is_named = |reading: &&Reading| {
            least > NAMED || reading.trial.reservation == least || **reading == strongest
        };
        let best = *contest
            .0
            .iter()
            .find(|reading| least > NAMED || reading.trial.reservation == least)?;
        // Names help, and evidence decides.
        let best = match strongest.score() > CLEARLY * best.score().max(HEARD) {
            true => strongest,
            false => best,
        };
        let before = contest.0.iter().filter(is_named).find(|reading| {
            best.trial.order == Order::Velocity
                && reading.trial.order == Order::Position
                && reading.trial.command == best.trial.command
        });
        let best = before
            .filter(|before| best.bits < CLEARLY * before.bits.max(HEARD))
            .copied()
            .unwrap_or(best);
        let pair = |of: &Reading| [of.trial.measured, of.trial.command];
        let other_order = contest
            .0
            .iter()
            .find(|other| pair(other) == pair(&best) && other.trial.order != best.trial.order);
        let clearer =
            other_order.filter(|other| other.score() > CLEARLY * best.score().max(0.5 * HEARD));
        Some(clearer.copied().unwrap_or(best))
    }

    /// True for a velocity beside a position by their names, either way.
    fn is_rate_of(&self, one: usize, other: usize) -> bool {
        let of = [one, other].map(|index| self.named[index].quantity);
        of.contains(&Quantity::Velocity) && of.contains(&Quantity::Position)
    }

    /// True for a command of another joint: its name ends in another number, or another column of its name but for one word
    /// has the word of the measured one there.
    fn are_of_other_joints(&self, measured: usize, command: usize) -> bool {
        let words = |index: usize| words(&self.table.columns[index].name);
        let [of, by] = [measured, command].map(words);
        let number = |words: &[String]| {
            let is_number = |word: &&String| word.starts_with(|c: char| c.is_ascii_digit());
            words.iter().rfind(is_number).cloned()
        };
        if let [Some(one), Some(other)] = [number(&of), number(&by)] {
            return one != other;
        }
        let mut others = (0..self.table.columns.len()).filter(|other| *other != measured);
        others.any(|other| {
            let other = words(other);
            let mut differing = other.iter().zip(&by).filter(|(one, own)| one != own);
            let first = differing
                .next()
                .filter(|(one, own)| !is_role(one) && !is_role(own));
            other.len() == by.len()
                && differing.next().is_none()
                && first.is_some_and(|(one, own)| of.contains(one) && !of.contains(own))
        })
    }

    fn question(&self, flag: &'static str, quantity: &str) -> Question {
        Question {
            flag,
            text: format!(
                "which column is the {quantity}? The columns are {}",
                self.names()
            ),
        }
    }

    fn either(&self, flag: &'static str, quantity: &str, best: usize, rival: usize) -> Question {
        Question {
            flag,
            text: format!(
                "{} and {} explain the motion equally well: state which is the {quantity}",
                self.name(best),
                self.name(rival)
            ),
        }
    }
}

/// The winner of a contest, and what came next.
struct Found {
    reading: Reading,
    /// True if the command goes against the motion.
    is_reversed: bool,
    next: Option<String>,
}

/// The smallest step of a column of which most of its changes are multiples, or else the usual distance of its values.
fn cell(column: &[f64]) -> f64 {
    const SAMPLED: usize = 4000;
    let mut values: Vec<f64> = column
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .collect();
    values.truncate(SAMPLED);
    if let Some(step) =
        crate::readings::Positions::of(values.iter().copied()).and_then(|of| of.step())
    {
        return step;
    }
    values.sort_unstable_by(f64::total_cmp);
    let (low, high) = (
        values.first().copied().unwrap_or(0.0),
        values.last().copied().unwrap_or(0.0),
    );
    values.dedup_by(|next, before| *next - *before <= 1e-9 * (high - low));
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_unstable_by(f64::total_cmp);
    // Values that were rounded in other units leave a few distances that are far too small.
    steps.get(steps.len() / 50).copied().unwrap_or(1.0)
}

impl TableColumn {
    fn finite(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        (self.values.iter().copied()).filter(|value| value.is_finite())
    }

    fn has_values(&self) -> bool {
        self.finite().next().is_some()
    }

    /// True if its numbers differ.
    pub(super) fn is_moving(&self) -> bool {
        let (low, high) = extremes(self.finite());
        low < high
    }

    fn steps(&self) -> impl Iterator<Item = f64> + '_ {
        let next = self.finite().skip(1);
        (next.zip(self.finite())).map(|(next, before)| next - before)
    }

    /// True if no number is before the last.
    fn advances(&self) -> bool {
        self.is_moving() && self.steps().all(|step| step >= 0.0)
    }

    /// True if it holds each of a few values for many rows: the time from row to row is then known to worse than a thousandth.
    fn stands_still(&self) -> bool {
        /// Steps that tell the time from row to row.
        const ENOUGH: usize = 40;
        let changes = self.steps().filter(|step| *step != 0.0).count();
        (1..ENOUGH).contains(&changes) && self.values.len() > 3 * (changes + 1)
    }

    /// True if it advances as a time does, which may begin again a few times.
    fn runs_on(&self) -> bool {
        /// Late stamps go back in a quarter of the rows, a column in no order in half of them.
        const MAX_BACK: f64 = 0.35;
        let (mut back, mut all) = (0.0, 0.0);
        for step in self.steps() {
            all += 1.0;
            back += f64::from(u8::from(step < 0.0));
        }
        // One that goes back row by row, or stands still, is refused as a time by what it is.
        back <= MAX_BACK * all || back >= (1.0 - MAX_BACK) * all
    }

    /// True if it advances by nearly even steps, and begins again now and then.
    fn is_even(&self) -> bool {
        /// Largest step, usual ones, and part of the steps within it.
        const MAX_STEP: f64 = 3.0;
        const MIN_SHARE: f64 = 0.95;
        /// Part of the steps that begin again.
        const MAX_BACK: f64 = 0.01;
        /// Fewest steps.
        const MIN_STEPS: usize = 9;
        let mut steps: Vec<_> = self.steps().collect();
        let back = steps.iter().filter(|step| **step < 0.0).count() as f64;
        if steps.len() < MIN_STEPS || back > MAX_BACK * steps.len() as f64 {
            return false;
        }
        steps.sort_unstable_by(f64::total_cmp);
        let usual = steps[steps.len() / 2];
        let within =
            (steps.iter()).filter(|step| **step < MAX_STEP * usual && **step > usual / MAX_STEP);
        usual > 0.0 && within.count() as f64 > MIN_SHARE * steps.len() as f64
    }

    /// Its numbers as positions, continued where they begin again.
    pub(super) fn continued(&self) -> Vec<f64> {
        /// Part of the range from which a step begins again, and part of the steps that may.
        const JUMP: f64 = 0.7;
        const MAX_SHARE: f64 = 0.05;
        let (low, high) = extremes(self.finite());
        let range = high - low;
        let is_jump = |step: f64| step.abs() > JUMP * range;
        let jumps = self.steps().filter(|step| is_jump(*step)).count();
        if jumps as f64 > MAX_SHARE * self.values.len() as f64 || self.distinct_is_few() {
            return self.values.clone();
        }
        let (mut offset, mut last) = (0.0, f64::NAN);
        let continue_it = |value: &f64| {
            let step = *value - last;
            if value.is_finite() {
                last = *value;
            }
            if is_jump(step) {
                offset -= step.signum() * range;
            }
            value + offset
        };
        self.values.iter().map(continue_it).collect()
    }

    /// True for a switch, or a command of few sizes.
    fn distinct_is_few(&self) -> bool {
        const FEW: usize = 8;
        let mut seen: Vec<f64> = Vec::new();
        for value in self.finite() {
            if !seen.contains(&value) {
                seen.push(value);
            }
            if seen.len() > FEW {
                return false;
            }
        }
        true
    }
}
