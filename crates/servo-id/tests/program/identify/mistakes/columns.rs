//! Signs and columns.

use super::super::{MOTION, map, text};
use super::Expected::Gain;
use super::{Cases, kept, map_at, noise};
use crate::identify::GAIN;

impl Cases {
    pub(super) fn signs_and_columns(&mut self) {
        let of = &*MOTION;
        let (time, position, command) = (&of.time, &of.position, &of.command);
        let named =
            |q: &[f64], u: &[f64]| text(&[("t_s", time, 4), ("q_rad", q, 6), ("u_V", u, 5)]);
        let with_position = |q: &[f64]| named(q, command);
        let with_command = |u: &[f64]| named(position, u);
        let negative = |of: &[f64]| map(of, |x| -x);
        self.right("command reversed", with_command(&negative(command)));
        self.right("encoder reversed", with_position(&negative(position)));
        let reversed = with_command(&negative(command));
        let stated = "--command-scale -1";
        self.stated(
            "command reversed, sign stated",
            reversed,
            stated,
            Gain(GAIN),
        );
        let exchanged = named(command, position);
        self.named("position and command exchanged", exchanged, "the names for");
        let with_reference = |r: &[f64], q: &[f64]| {
            text(&[
                ("t_s", time, 4),
                ("q_ref_rad", r, 6),
                ("q_rad", q, 6),
                ("u_V", command, 5),
            ])
        };
        self.right(
            "with its reference",
            with_reference(&of.reference, position),
        );
        let exchanged = with_reference(position, &of.reference);
        self.named(
            "position and reference exchanged",
            exchanged,
            "the names for",
        );
        let reference = with_command(&of.reference);
        self.named("reference as command", reference, "a gain that differs");
        let in_degrees = map(&of.reference, f64::to_degrees);
        self.right(
            "reference in degrees",
            with_reference(&in_degrees, position),
        );
        let speed = map_at(position, |k, q| 1e3 * (q - position[k.saturating_sub(1)]));
        self.right("velocity as position", with_position(&speed));
        let alone = text(&[("t_s", time, 4), ("speed", &speed, 5), ("u_V", command, 5)]);
        self.right("velocity alone", alone);
        let times = with_position(&map(time, |t| 7.0 * t));
        self.named("time as position", times, "a gain that differs");
        self.named(
            "position as command",
            with_command(position),
            "not be copies",
        );
        let none = vec![0.0; time.len()];
        self.named("no command", with_command(&none), "only these columns");
        self.named(
            "constant position",
            with_position(&none),
            "only these columns",
        );
        let without = text(&[("t_s", time, 4), ("q_rad", position, 6)]);
        self.named("no column of a command", without, "only these columns");
        let other = with_command(&map_at(time, |k, _| 4.0 * noise(k / 40)));
        self.named("another command", other, "explains the log nearly as well");
        let hiss = with_position(&map_at(time, |k, _| 1e-2 * noise(k)));
        self.named("noise as position", hiss, "no servo");
        let later = |samples: usize| {
            let mut late = command.clone();
            late.rotate_right(samples);
            with_command(&late)
        };
        self.right("command recorded 3 samples late", later(3));
        self.right("command recorded 3 samples early", later(time.len() - 3));
        self.named(
            "command shifted by 0.4 s",
            later(time.len() - 400),
            "command",
        );
        let one_way = with_position(&map_at(position, |k, q| q + 40.0 * time[k]));
        self.named("one direction", one_way, "one direction");
        let spiked = |every: usize| {
            let spike = |k: usize| if k % every == 5 { 0.5 } else { 0.0 };
            with_position(&map_at(position, |k, q| q + spike(k)))
        };
        self.named("spikes", spiked(97), "spikes");
        self.right("an occasional spike", spiked(411));
        let begin = |rows: usize| kept(&of.text(), |k| k < rows);
        self.named("half a second", begin(500), "one direction");
        self.named("a twentieth of a second", begin(51), "50 samples");
    }
}
