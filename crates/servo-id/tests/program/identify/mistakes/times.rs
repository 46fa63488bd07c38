//! Time: units, stamps, gaps.

use super::super::{MOTION, cells, map, text, text_of_cells};
use super::Expected::{Gain, Named};
use super::{Cases, kept, map_at, noise};
use crate::identify::GAIN;

impl Cases {
    pub(super) fn times(&mut self) {
        let of = &*MOTION;
        let (position, command) = (&of.position, &of.command);
        let timed = |name: &str, time: &[f64], decimals: usize| {
            text(&[
                (name, time, decimals),
                ("q_rad", position, 6),
                ("u_V", command, 5),
            ])
        };
        let stamped = |name: &'static str, stamps: Vec<String>| {
            let [position, command] = [cells(position, 6), cells(command, 5)];
            text_of_cells(&[(name, stamps), ("q_rad", position), ("u_V", command)])
        };
        let scaled = |name: &str, by: f64| timed(name, &map(&of.time, |t| by * t), 0);
        self.right("ms by name", scaled("t_ms", 1e3));
        self.named("numbers without unit", scaled("t", 1e3), "--time-unit");
        let in_ms = (scaled("t", 1e3), "--time-unit ms");
        self.stated("ms, unit stated", in_ms.0, in_ms.1, Gain(GAIN));
        self.right("µs without unit", scaled("timestamp", 1e6));
        self.right("ns without unit", scaled("timestamp", 1e9));
        self.right("seconds called ms", timed("t_ms", &of.time, 4));
        self.named("ms called seconds", scaled("t_s", 1e3), "--time-unit");
        let since_1970 = map(&of.time, |t| t + 1.795e9);
        self.right("since 1970", timed("t_s", &since_1970, 4));
        let clock = of.time.iter().map(|t| format!("06:25:{t:06.3}"));
        let date = |clock: String| format!("2026-11-22T{clock}Z");
        let dates = clock.clone().map(date).collect();
        self.right("ISO 8601", stamped("timestamp", dates));
        self.right("time of day", stamped("clock", clock.collect()));
        let counter = scaled("sample", 1e3);
        let time = "--sample-time 0.001";
        self.named("counter", counter.clone(), "--sample-time");
        self.stated("counter, sample time stated", counter, time, Gain(GAIN));
        let untimed = text(&[("q_rad", position, 6), ("u_V", command, 5)]);
        self.named("no time", untimed.clone(), "--sample-time");
        self.stated("no time, sample time stated", untimed, time, Gain(GAIN));
        let wrong = Named("--sample-time is 0.002 s");
        self.stated("wrong rate stated", of.text(), "--sample-time 0.002", wrong);
        let jitter = map_at(&of.time, |k, t| t + 2e-4 * noise(k));
        self.right("jitter", timed("t_s", &jitter, 6));
        let coarse = map(&of.time, |t| (t * 200.0).floor() / 200.0);
        self.right("coarse stamps", timed("t_s", &coarse, 4));
        let without = |is_lost: fn(usize) -> bool| kept(&of.text(), |k| !is_lost(k));
        self.right("a short gap", without(|k| (1000..1002).contains(&k)));
        self.right("a long gap", without(|k| (1000..1400).contains(&k)));
        self.right("every tenth row lost", without(|k| k % 10 == 7));
        let mut rows: Vec<_> = of.text().lines().map(str::to_owned).collect();
        rows.insert(1500, rows[1500].clone());
        self.right("a row twice", rows.join("\n"));
        rows.remove(1500);
        rows[1..].reverse();
        self.named("last row first", rows.join("\n"), "sort the rows");
        rows[1..].reverse();
        rows.swap(1500, 1501);
        self.right("two rows exchanged", rows.join("\n"));
        let overflowing = map(&of.time, |t| (1e3 * t + 64_000.0) % 65_536.0);
        self.right("stamps that overflow", timed("t_ms", &overflowing, 0));
        let constant = timed("t_s", &vec![0.5; of.time.len()], 1);
        self.named(
            "time constant",
            constant,
            "the time is the same in all rows",
        );
    }
}
