//! Time: units, stamps, gaps.

use super::super::{GAIN, cells, text};
use super::Expected::{Gain, Named};
use super::{Cases, lines, map, noise};

impl Cases {
    pub(super) fn times(&mut self) {
        let of = self.motion.clone();
        let [seconds, position, command] = self.usual();
        let timed = |name: &'static str, time: &[String]| {
            text(
                ",",
                &[(name, time), ("q_rad", &position), ("u_V", &command)],
            )
        };
        let scaled = |by: f64| cells(&map(&of.time, |t| by * t), 0);
        self.add("ms by name", timed("t_ms", &scaled(1e3)), Gain(GAIN));
        self.add("ms without unit", timed("t", &scaled(1e3)), Gain(GAIN));
        self.add(
            "µs without unit",
            timed("timestamp", &scaled(1e6)),
            Gain(GAIN),
        );
        self.add(
            "ns without unit",
            timed("timestamp", &scaled(1e9)),
            Gain(GAIN),
        );
        self.add("seconds called ms", timed("t_ms", &seconds), Gain(GAIN));
        self.add("ms called seconds", timed("t_s", &scaled(1e3)), Gain(GAIN));
        self.add(
            "since 1970",
            timed("t_s", &cells(&map(&of.time, |t| t + 1.795e9), 4)),
            Gain(GAIN),
        );
        let stamp = |t: &f64| {
            let of_second = (t * 1e3).round() as u64;
            format!(
                "2026-11-22T06:25:{:02}.{:03}Z",
                of_second / 1000,
                of_second % 1000
            )
        };
        let stamps: Vec<_> = of.time.iter().map(stamp).collect();
        self.add("ISO 8601", timed("timestamp", &stamps), Gain(GAIN));
        let clock: Vec<_> = stamps
            .iter()
            .map(|stamp| stamp[11..23].to_owned())
            .collect();
        self.add("time of day", timed("clock", &clock), Gain(GAIN));
        self.add(
            "counter",
            timed("sample", &scaled(1e3)),
            Named("--sample-time"),
        );
        self.with(
            "counter, sample time stated",
            timed("sample", &scaled(1e3)),
            &["--sample-time", "0.001"],
            Gain(GAIN),
        );
        let untimed = text(",", &[("q_rad", &position), ("u_V", &command)]);
        self.add("no time", untimed.clone(), Named("--sample-time"));
        self.with(
            "no time, sample time stated",
            untimed,
            &["--sample-time", "0.001"],
            Gain(GAIN),
        );
        self.with(
            "wrong rate stated",
            of.text(),
            &["--sample-time", "0.002"],
            Named("--sample-time is 0.002 s"),
        );
        let jitter: Vec<f64> = of
            .time
            .iter()
            .zip(0..)
            .map(|(t, k)| t + 2e-4 * noise(k))
            .collect();
        self.add("jitter", timed("t_s", &cells(&jitter, 6)), Gain(GAIN));
        self.add(
            "coarse stamps",
            timed(
                "t_s",
                &cells(&map(&of.time, |t| (t * 200.0).floor() / 200.0), 4),
            ),
            Gain(GAIN),
        );
        let without = |missing: std::ops::Range<usize>| {
            lines(&of.text(), |k, line| {
                (!missing.contains(&k)).then(|| line.to_owned())
            })
        };
        self.add("a short gap", without(1000..1002), Gain(GAIN));
        self.add("a long gap", without(1000..1400), Gain(GAIN));
        self.add(
            "every tenth row lost",
            lines(&of.text(), |k, line| (k % 10 != 7).then(|| line.to_owned())),
            Gain(GAIN),
        );
        let twice = lines(&of.text(), |k, line| {
            Some(if k == 1500 {
                format!("{line}\n{line}")
            } else {
                line.to_owned()
            })
        });
        self.add("a row twice", twice, Gain(GAIN));
        let mut rows: Vec<_> = of.text().lines().map(str::to_owned).collect();
        rows[1..].reverse();
        self.add("last row first", rows.join("\n"), Named("sort the rows"));
        rows[1..].reverse();
        rows.swap(1500, 1501);
        self.add("two rows exchanged", rows.join("\n"), Gain(GAIN));
        let overflowing = map(&of.time, |t| (1e3 * t + 64_000.0) % 65_536.0);
        self.add(
            "stamps that overflow",
            timed("t_ms", &cells(&overflowing, 0)),
            Gain(GAIN),
        );
        self.add(
            "time constant",
            timed("t_s", &vec!["0.5".to_owned(); of.time.len()]),
            Named("the time is the same in all rows"),
        );
    }
}
