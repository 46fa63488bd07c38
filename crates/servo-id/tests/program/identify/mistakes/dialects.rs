//! Separators, marks, headings and columns of a text.

use super::super::{GAIN, cells, text};
use super::Expected::{Gain, Named};
use super::{Cases, lines, map, utf16};

impl Cases {
    pub(super) fn dialects(&mut self) {
        let plain = self.motion.text();
        let [time, position, command] = self.usual();
        let columns = |names: [&'static str; 3], separator| {
            text(
                separator,
                &[
                    (names[0], &time),
                    (names[1], &position),
                    (names[2], &command),
                ],
            )
        };
        self.add("plain", plain.clone(), Gain(GAIN));
        self.add(
            "decimal commas",
            plain.replace(',', ";").replace('.', ","),
            Gain(GAIN),
        );
        self.add("tabs", plain.replace(',', "\t"), Gain(GAIN));
        self.add("spaces", plain.replace(',', "   "), Gain(GAIN));
        self.add(
            "decimal commas, spaces",
            plain.replace(',', " ").replace('.', ","),
            Gain(GAIN),
        );
        self.add("byte order mark", format!("\u{feff}{plain}"), Gain(GAIN));
        self.add("UTF-16", utf16(&plain), Named("UTF-16"));
        self.add("carriage returns", plain.replace('\n', "\r\n"), Gain(GAIN));
        self.add(
            "comments",
            format!("# drive 7\n% gains\n{plain}"),
            Gain(GAIN),
        );
        self.add(
            "quoted cells",
            lines(&plain, |_, line| {
                Some(format!("\"{}\"", line.replace(',', "\",\"")))
            }),
            Gain(GAIN),
        );
        self.add(
            "row of units",
            columns(["t", "q", "u"], ",").replacen('\n', "\ns,rad,V\n", 1),
            Gain(GAIN),
        );
        self.add(
            "no heading",
            lines(&plain, |k, line| (k > 0).then(|| line.to_owned())),
            Gain(GAIN),
        );
        self.with(
            "no heading, unit stated",
            lines(&plain, |k, line| (k > 0).then(|| line.to_owned())),
            &["--position-unit", "rad"],
            Gain(GAIN),
        );
        self.add("empty lines", plain.replace('\n', "\n\n"), Gain(GAIN));
        self.add(
            "separator at the end",
            plain.replace('\n', ",\n"),
            Gain(GAIN),
        );
        self.add(
            "German names",
            columns(["Zeit [s]", "Winkel [rad]", "Spannung [V]"], ";").replace('.', ","),
            Gain(GAIN),
        );
        self.add(
            "names in capitals",
            columns(["TIME (S)", "ENCODER POSITION (RAD)", "MOTOR VOLTAGE"], ","),
            Gain(GAIN),
        );
        self.with(
            "names that say nothing",
            columns(["A1", "B1", "C1"], ","),
            &["--position-unit", "rad"],
            Gain(GAIN),
        );
        self.with(
            "one name for two columns",
            columns(["t", "x", "x"], ","),
            &["--position-unit", "rad"],
            Named("which column is the command"),
        );
        let of = self.motion.clone();
        let (reference, states) = (
            cells(&of.reference, 6),
            vec!["RUN".to_owned(); of.time.len()],
        );
        let speed: Vec<f64> = std::iter::once(0.0)
            .chain(of.position.windows(2).map(|q| 1e3 * (q[1] - q[0])))
            .collect();
        let error: Vec<f64> = of
            .reference
            .iter()
            .zip(&of.position)
            .map(|(r, q)| r - q)
            .collect();
        let warm = map(&of.time, |t| 30.0 + t);
        let (speed, error, warm) = (cells(&speed, 3), cells(&error, 6), cells(&warm, 2));
        let many = text(
            ",",
            &[
                ("state", &states),
                ("temperature", &warm),
                ("u_V", &command),
                ("speed_rpm", &speed),
                ("error_rad", &error),
                ("q_ref_rad", &reference),
                ("q_rad", &position),
                ("time_s", &time),
            ],
        );
        self.add("more columns, in another order", many, Gain(GAIN));
        let positions = cells(&map(&of.position, |q| q + 0.3 * (3.0 * q).sin() + 1.0), 6);
        let two = text(
            ",",
            &[
                ("t_s", &time),
                ("load_angle_rad", &positions),
                ("motor_angle_rad", &position),
                ("u_V", &command),
            ],
        );
        self.add("two positions", two, Gain(GAIN));
        self.add(
            "preamble",
            format!("Drive 7\nrecorded by hand\n{plain}"),
            Gain(GAIN),
        );
    }
}
