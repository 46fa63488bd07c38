//! Signs and columns.

use super::super::{GAIN, cells, text};
use super::Expected::{Gain, Named};
use super::{Cases, lines, map, noise};

impl Cases {
    pub(super) fn signs_and_columns(&mut self) {
        let of = self.motion.clone();
        let [time, position, command] = self.usual();
        let reference = cells(&of.reference, 6);
        let negative = |of: &[f64]| cells(&map(of, |x| -x), 6);
        let named =
            |q: &[String], u: &[String]| text(",", &[("t_s", &time), ("q_rad", q), ("u_V", u)]);
        self.add(
            "command reversed",
            named(&position, &negative(&of.command)),
            Gain(GAIN),
        );
        self.add(
            "encoder reversed",
            named(&negative(&of.position), &command),
            Gain(GAIN),
        );
        self.with(
            "command reversed, sign stated",
            named(&position, &negative(&of.command)),
            &["--command-scale", "-1"],
            Gain(GAIN),
        );
        self.add(
            "position and command exchanged",
            named(&command, &position),
            Named("the names for"),
        );
        let with_reference = |r: &[String], q: &[String], u: &[String]| {
            text(
                ",",
                &[("t_s", &time), ("q_ref_rad", r), ("q_rad", q), ("u_V", u)],
            )
        };
        self.add(
            "with its reference",
            with_reference(&reference, &position, &command),
            Gain(GAIN),
        );
        self.add(
            "position and reference exchanged",
            with_reference(&position, &reference, &command),
            Named("the names for"),
        );
        self.add(
            "reference as command",
            named(&position, &reference),
            Named("a gain that differs"),
        );
        let in_degrees = cells(&map(&of.reference, f64::to_degrees), 6);
        self.add(
            "reference in degrees",
            with_reference(&in_degrees, &position, &command),
            Gain(GAIN),
        );
        let speed: Vec<f64> = std::iter::once(0.0)
            .chain(of.position.windows(2).map(|q| 1e3 * (q[1] - q[0])))
            .collect();
        self.add(
            "velocity as position",
            named(&cells(&speed, 5), &command),
            Gain(GAIN),
        );
        self.add(
            "velocity alone",
            text(
                ",",
                &[
                    ("t_s", &time),
                    ("speed", &cells(&speed, 5)),
                    ("u_V", &command),
                ],
            ),
            Gain(GAIN),
        );
        self.add(
            "time as position",
            named(&cells(&map(&of.time, |t| 7.0 * t), 6), &command),
            Named("a gain that differs"),
        );
        self.add(
            "position as command",
            named(&position, &position),
            Named("not be copies"),
        );
        let none = vec!["0".to_owned(); of.time.len()];
        self.add(
            "no command",
            named(&position, &none),
            Named("only these columns"),
        );
        self.add(
            "constant position",
            named(&none, &command),
            Named("only these columns"),
        );
        self.add(
            "no column of a command",
            text(",", &[("t_s", &time), ("q_rad", &position)]),
            Named("only these columns"),
        );
        let other: Vec<f64> = (0..of.time.len()).map(|k| 4.0 * noise(k / 40)).collect();
        self.add(
            "another command",
            named(&position, &cells(&other, 5)),
            Named("explains the log nearly as well"),
        );
        let hiss: Vec<f64> = (0..of.time.len()).map(|k| 1e-2 * noise(k)).collect();
        self.add(
            "noise as position",
            named(&cells(&hiss, 6), &command),
            Named("no servo"),
        );
        let mut late = of.command.clone();
        late.rotate_right(3);
        self.add(
            "command recorded 3 samples late",
            named(&position, &cells(&late, 5)),
            Gain(GAIN),
        );
        let mut early = of.command.clone();
        early.rotate_left(3);
        self.add(
            "command recorded 3 samples early",
            named(&position, &cells(&early, 5)),
            Gain(GAIN),
        );
        let mut far = of.command.clone();
        far.rotate_left(400);
        self.add(
            "command shifted by 0.4 s",
            named(&position, &cells(&far, 5)),
            Named("command"),
        );
        let one_way: Vec<f64> = of
            .position
            .iter()
            .zip(&of.time)
            .map(|(q, t)| q + 40.0 * t)
            .collect();
        self.add(
            "one direction",
            named(&cells(&one_way, 6), &command),
            Named("one direction"),
        );
        for (name, every, expected) in [
            ("spikes", 97, Named("spikes")),
            ("an occasional spike", 411, Gain(GAIN)),
        ] {
            let spike = |k: usize| if k % every == 5 { 0.5 } else { 0.0 };
            let positions = of.position.iter().zip(0..);
            let spiked: Vec<f64> = positions.map(|(q, k)| q + spike(k)).collect();
            self.add(name, named(&cells(&spiked, 6), &command), expected);
        }
        self.add(
            "half a second",
            lines(&of.text(), |k, line| (k < 500).then(|| line.to_owned())),
            Named("one direction"),
        );
        self.add(
            "a twentieth of a second",
            lines(&of.text(), |k, line| (k < 51).then(|| line.to_owned())),
            Named("50 samples"),
        );
    }
}
