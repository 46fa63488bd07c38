//! Reconstructs the command of the servo's inner loop from its position goals. It is u = kp (goal − q) − kd q̇ within
//! its limit, at each sample of that loop. A row of the log may have many such samples. The position between two rows
//! is their cubic Hermite interpolation. The goal acts from its row to the next, and so does the row's command, the
//! mean over them.

use super::row::Row;
use crate::scenario::{InnerLoop, Integrator};

/// The inner loop on its way through a motion without a break.
pub(super) struct Inner<'a> {
    settings: InnerLoop,
    /// Its samples to a row of the log.
    ticks: u32,
    /// Time from row to row, s.
    sample_time: f64,
    rows: &'a [Row],
    place: usize,
    /// The filtered velocity, rad/s, once the motion has begun.
    velocity: Option<f64>,
}

impl<'a> Inner<'a> {
    /// The commands of a loop, each the mean over a row of a motion.
    ///
    /// # Errors
    /// A sample time of the loop that is no part of the log's.
    pub(super) fn commands(
        settings: InnerLoop,
        rows: &'a [Row],
        sample_time: f64,
    ) -> Result<Vec<f64>, String> {
        let mut inner = Self {
            settings,
            ticks: settings.samples_per_row(sample_time)?,
            sample_time,
            rows,
            place: 0,
            velocity: None,
        };
        let command = |(place, row)| {
            inner.place = place;
            inner.command(row)
        };
        Ok(rows.iter().enumerate().map(command).collect())
    }

    fn command(&mut self, row: &Row) -> f64 {
        let goal = row.reference.unwrap_or(row.position);
        let ticks = f64::from(self.ticks);
        let mut sum = 0.0;
        for tick in 0..self.ticks {
            let command = self.at(f64::from(tick) / ticks, goal);
            sum += command;
            // A semi-implicit step turns with its command the motion around its beginning: half of it acts before.
            if tick == 0 && self.settings.integrator != Integrator::None {
                sum -= 0.5 * command;
            }
        }
        if self.settings.integrator != Integrator::None {
            let next = self.rows.get(self.place + 1);
            let goal = next.and_then(|next| next.reference).unwrap_or(goal);
            sum += 0.5 * self.at(1.0, goal);
        }
        sum / ticks
    }

    /// The command of the loop at a time behind the row, rows.
    fn at(&mut self, time: f64, goal: f64) -> f64 {
        let InnerLoop {
            kp,
            kd,
            limit: [low, high],
            ..
        } = self.settings;
        let damping = if kd > 0.0 {
            kd * self.velocity(time)
        } else {
            0.0
        };
        (kp * (goal - self.position(time)) - damping).clamp(low, high)
    }

    /// The velocity that the loop takes, rad/s.
    fn velocity(&mut self, time: f64) -> f64 {
        let step = 1.0 / f64::from(self.ticks);
        let rate = f64::from(self.ticks) / self.sample_time;
        let moved = |from: f64, to: f64| rate * (self.position(to) - self.position(from));
        match self.settings.integrator {
            Integrator::Euler => moved(time - step, time),
            Integrator::Implicit => moved(time, time + step),
            Integrator::None => {
                if let Some(measured) = self.measured_velocity(time) {
                    return measured;
                }
                let difference = moved(time - step, time);
                let Some(cutoff) = self.settings.cutoff else {
                    return difference;
                };
                let before = self
                    .velocity
                    .unwrap_or(self.slope(self.place) / self.sample_time);
                let kept = (-cutoff / rate).exp();
                let velocity = kept * before + (1.0 - kept) * difference;
                self.velocity = Some(velocity);
                velocity
            }
        }
    }

    /// The log's own velocity, where it has one.
    fn measured_velocity(&self, time: f64) -> Option<f64> {
        let velocity = |place: usize| self.rows.get(place)?.velocity;
        let now = velocity(self.place)?;
        let next = velocity(self.place + 1).unwrap_or(now);
        Some(now + time * (next - now))
    }

    /// The position at a time behind the row, rows; at the ends of a segment it continues straight.
    fn position(&self, time: f64) -> f64 {
        let last = self.rows.len() - 1;
        let place = self.place as f64 + time;
        if place <= 0.0 {
            return self.rows[0].position + place * self.slope(0);
        }
        if place >= last as f64 {
            return self.rows[last].position + (place - last as f64) * self.slope(last);
        }
        let from = place.floor() as usize;
        let x = place - place.floor();
        let [p, q] = [from, from + 1].map(|place| self.rows[place].position);
        if x <= 0.0 {
            return p;
        }
        let [v, w] = [from, from + 1].map(|place| self.slope(place));
        let step = q - p;
        p + x * (v + x * (3.0 * step - 2.0 * v - w + x * (v + w - 2.0 * step)))
    }

    /// The velocity at a row, rad per row.
    fn slope(&self, place: usize) -> f64 {
        let row = &self.rows[place];
        if let Some(velocity) = row.velocity {
            return velocity * self.sample_time;
        }
        let before = place.checked_sub(1).and_then(|place| self.rows.get(place));
        let next = self.rows.get(place + 1);
        let [to_here, from_here] = [
            before.map(|before| row.position - before.position),
            next.map(|next| next.position - row.position),
        ];
        match (to_here, from_here) {
            (Some(to_here), Some(from_here)) => 0.5 * (to_here + from_here),
            (one, other) => one.or(other).unwrap_or(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Inner, Row};
    use crate::log::{Log, Table};
    use crate::scenario::{Column, InnerLoop, Integrator, LogSettings};

    /// A joint q̈ = −a q̇ + b u with its position loop. It uses the integrator of a simulator or, with many steps to a
    /// sample of the loop, that of a drive. Every `rows`-th sample of the loop is a row: goal, position and the mean
    /// command.
    fn simulated(inner: &InnerLoop, rows: usize, velocity: bool) -> (LogSettings, Table, Vec<f64>) {
        const STEPS: usize = 200;
        let [a, b] = [4.0, 20.0];
        let loop_time = inner.sample_time.expect("stated");
        let [mut q, mut w, mut filtered, mut last] = [0.3, 0.0, 0.0, 0.3];
        let [mut goals, mut positions, mut velocities] = [const { Vec::new() }; 3];
        let mut commands = vec![0.0; 400];
        for sample in 0..400 * rows {
            let time = loop_time * (sample - sample % rows) as f64;
            let goal = (3.0 * time).sin() + 0.3 * (17.0 * time).sin();
            let difference = (q - last) / loop_time;
            last = q;
            filtered = match inner.cutoff {
                Some(cutoff) => {
                    let kept = (-cutoff * loop_time).exp();
                    kept * filtered + (1.0 - kept) * difference
                }
                None if velocity => w,
                None => difference,
            };
            if sample % rows == 0 {
                goals.push(goal);
                positions.push(q);
                velocities.push(w);
            }
            let spring = inner.kp * (goal - q);
            let [low, high] = inner.limit;
            let mut command = (spring - inner.kd * filtered).clamp(low, high);
            match inner.integrator {
                Integrator::None => {
                    let step = loop_time / STEPS as f64;
                    for _ in 0..STEPS {
                        let middle = w + 0.5 * step * (b * command - a * w);
                        q += step * middle;
                        w += step * (b * command - a * middle);
                    }
                }
                Integrator::Euler => {
                    command = (spring - inner.kd * w).clamp(low, high);
                    w = (w + loop_time * b * command) / (1.0 + loop_time * a);
                    q += loop_time * w;
                }
                Integrator::Implicit => {
                    let braked = 1.0 + loop_time * (a + b * inner.kd);
                    w = (w + loop_time * b * spring) / braked;
                    command = spring - inner.kd * w;
                    q += loop_time * w;
                }
            }
            commands[sample / rows] += command / rows as f64;
        }
        let mut settings = LogSettings::with_position(Column::named("position"));
        settings.reference = Some(Column::named("goal"));
        settings.velocity = velocity.then(|| Column::named("velocity"));
        settings.sample_time = Some(loop_time * rows as f64);
        settings.inner = Some(*inner);
        let columns = [goals, positions, velocities];
        let names = ["goal", "position", "velocity"].map(str::to_owned);
        let columns = Table::of_columns("log", names.into_iter().zip(columns).collect());
        (settings, columns.expect("one length"), commands)
    }

    /// The largest difference between the log's commands and the true ones of a simulation, as a part of the largest of
    /// these.
    fn difference(inner: &InnerLoop, rows: usize, velocity: bool) -> f64 {
        let (settings, columns, truth) = simulated(inner, rows, velocity);
        let log = Log::new(&columns, &settings, settings.sample_time);
        let log = log.expect("it is sound");
        let found = log.rows();
        assert_eq!(found.len(), truth.len());
        let size = truth.iter().fold(0.0, |most, u| f64::max(most, u.abs()));
        // The motion before the first row and behind the last is not known.
        let off = (2..truth.len() - 3).map(|place| {
            // A semi-implicit step's command acts from half a step before it.
            let own = truth[place];
            let expected = match inner.integrator {
                Integrator::Euler | Integrator::Implicit if rows == 1 => {
                    0.5 * (own + truth[place + 1])
                }
                _ => own,
            };
            (found[place].command.expect("computed") - expected).abs()
        });
        off.fold(0.0, f64::max) / size
    }

    fn inner(integrator: Integrator) -> InnerLoop {
        InnerLoop {
            kd: 0.4,
            sample_time: Some(1e-3),
            integrator,
            ..InnerLoop::proportional(8.0)
        }
    }

    #[test]
    fn a_loop_at_the_rows_is_computed_to_the_last_digits() {
        let drive = inner(Integrator::None);
        let limited = InnerLoop {
            limit: [-2.0, 1.5],
            ..drive
        };
        let filtered = InnerLoop {
            cutoff: Some(300.0),
            ..drive
        };
        for (loop_, velocity, most) in [
            (drive, false, 1e-12),
            (drive, true, 1e-12),
            (limited, false, 1e-12),
            // The filter's state at the first row is taken from its slope.
            (filtered, false, 0.05),
            (inner(Integrator::Euler), false, 1e-12),
            (inner(Integrator::Implicit), false, 1e-12),
        ] {
            let off = difference(&loop_, 1, velocity);
            assert!(off < most, "{loop_:?} {velocity}: {off:e}");
        }
    }

    #[test]
    fn a_loop_between_the_rows_is_computed_from_the_motion_there() {
        for (integrator, allowed) in [
            (Integrator::None, 2e-3),
            // The edge of a goal lies half a step of the loop away from that of the row.
            (Integrator::Euler, 0.02),
            (Integrator::Implicit, 0.02),
        ] {
            for velocity in [false, true] {
                let off = difference(&inner(integrator), 5, velocity);
                assert!(off < allowed, "{integrator:?} {velocity}: {off:e}");
            }
        }
    }

    #[test]
    fn between_rows_a_steady_acceleration_is_followed_exactly() {
        let place = 2;
        let at = |time: f64| 0.5 + 0.2 * time - 3.0 * time * time;
        let row = |number: u64| Row {
            position: at(number as f64),
            ..Row::at(number, number as f64)
        };
        let moving = Inner {
            settings: inner(Integrator::Euler),
            ticks: 5,
            sample_time: 1.0,
            rows: &(0..6).map(row).collect::<Vec<_>>(),
            place,
            velocity: None,
        };
        for tick in -5..=10 {
            let time = 0.2 * f64::from(tick);
            let off = moving.position(time) - at(place as f64 + time);
            assert!(off.abs() < 1e-12, "{time}: {off:e}");
        }
    }

    #[test]
    fn a_break_in_the_log_begins_the_loop_again() {
        let (mut settings, columns, truth) = simulated(&inner(Integrator::None), 1, false);
        settings.cut = vec![[0.0995, 0.1995]];
        let log = Log::new(&columns, &settings, settings.sample_time);
        let log = log.expect("it is sound");
        let rows = log.rows();
        assert_eq!(rows.len(), 300);
        for (place, sample) in [(99, 99), (101, 201), (299, 399)] {
            let off = rows[place].command.expect("computed") - truth[sample];
            assert!(off.abs() < 1e-9, "{place}: {off}");
        }
        assert!(rows[100].begins);
    }

    #[test]
    fn a_sample_time_that_does_not_divide_the_logs_is_refused() {
        let (mut settings, columns, _) = simulated(&inner(Integrator::None), 1, false);
        for wrong in [7e-4, 2e-3, 1e-7] {
            settings.inner = Some(InnerLoop {
                sample_time: Some(wrong),
                ..inner(Integrator::None)
            });
            let log = Log::new(&columns, &settings, settings.sample_time);
            let refused = log.expect_err("it is refused").to_string();
            assert!(refused.contains("inner.sample_time"), "{refused}");
        }
    }
}
