//! Units of position and command.

use std::f64::consts::TAU;

use super::super::{COUNTS, GAIN, cells, text};
use super::Expected::Gain;
use super::{Cases, map, noise};

impl Cases {
    pub(super) fn units(&mut self) {
        let of = self.motion.clone();
        let [time, _, command] = self.usual();
        let placed = |name: &'static str, position: &[f64], decimals: usize| {
            text(
                ",",
                &[
                    ("t_s", &time),
                    (name, &cells(position, decimals)),
                    ("u_V", &command),
                ],
            )
        };
        let degrees = map(&of.position, f64::to_degrees);
        let turns = map(&of.position, |q| q / TAU);
        let counts = map(&of.position, |q| (q / TAU * COUNTS).round());
        self.add(
            "degrees by name",
            placed("angle_deg", &degrees, 4),
            Gain(GAIN),
        );
        self.add(
            "turns by name",
            placed("position [rev]", &turns, 6),
            Gain(GAIN),
        );
        self.add("steps of 0.036", placed("angle", &degrees, 6), Gain(GAIN));
        self.add(
            "steps of a 4096th",
            placed(
                "angle",
                &map(&of.position, |q| (q / TAU * 4096.0).round() / 4096.0),
                9,
            ),
            Gain(GAIN),
        );
        self.add(
            "steps of 2π/10000",
            placed("q", &of.position, 9),
            Gain(GAIN),
        );
        self.add(
            "whole numbers",
            placed("encoder", &counts, 0),
            Gain(GAIN * COUNTS / TAU),
        );
        self.with(
            "whole numbers, counts stated",
            placed("encoder", &counts, 0),
            &["--counts-per-rev", "10000"],
            Gain(GAIN),
        );
        self.with(
            "a quarter of the counts stated",
            placed("encoder", &map(&counts, |n| 4.0 * n), 0),
            &["--counts-per-rev", "40000"],
            Gain(GAIN),
        );
        let smooth: Vec<f64> = of
            .position
            .iter()
            .zip(0..)
            .map(|(q, k)| q + 2e-4 * noise(k))
            .collect();
        self.add(
            "smooth, no unit",
            placed("position", &smooth, 9),
            Gain(GAIN),
        );
        self.with(
            "smooth, unit stated",
            placed("position", &smooth, 9),
            &["--position-unit", "rad"],
            Gain(GAIN),
        );
        self.add(
            "degrees called rad",
            placed("q_rad", &degrees, 6),
            Gain(GAIN.to_degrees()),
        );
        self.add(
            "rad called degrees",
            placed("q_deg", &of.position, 9),
            Gain(GAIN.to_radians()),
        );
        self.add(
            "counts called rad",
            placed("q_rad", &counts, 0),
            Gain(GAIN * COUNTS / TAU),
        );
        self.add(
            "millimetres",
            placed("pos_mm", &map(&of.position, |q| 1e3 * q), 3),
            Gain(GAIN),
        );
        let wrapped = |period: f64, from: f64, positions: &[f64]| {
            map(positions, |q| {
                (q + 0.998 * period - from).rem_euclid(period) + from
            })
        };
        self.add(
            "0 to 360",
            placed("angle", &wrapped(360.0, 0.0, &degrees), 6),
            Gain(GAIN),
        );
        self.add(
            "-180 to 180",
            placed(
                "angle",
                &wrapped(360.0, -180.0, &map(&degrees, |q| q + 180.0)),
                6,
            ),
            Gain(GAIN),
        );
        self.add(
            "0 to 2π",
            placed("angle", &wrapped(TAU, 0.0, &of.position), 9),
            Gain(GAIN),
        );
        self.with(
            "0 to the counts",
            placed("encoder", &wrapped(COUNTS, 0.0, &counts), 0),
            &["--counts-per-rev", "10000"],
            Gain(GAIN),
        );
        self.add(
            "far from zero",
            placed("q_rad", &map(&of.position, |q| q + TAU * 500.0), 6),
            Gain(GAIN),
        );
        let commanded = |name: &'static str, command: &[f64]| {
            let position = cells(&of.position, 6);
            text(
                ",",
                &[
                    ("t_s", &time),
                    ("q_rad", &position),
                    (name, &cells(command, 5)),
                ],
            )
        };
        self.add(
            "command in per cent",
            commanded("duty [%]", &map(&of.command, |u| 10.0 * u)),
            Gain(GAIN / 10.0),
        );
        self.add(
            "command as a current",
            commanded("motor_current_A", &map(&of.command, |u| u / 4.0)),
            Gain(4.0 * GAIN),
        );
        self.with(
            "command scaled",
            commanded("pwm", &map(&of.command, |u| 1000.0 * u)),
            &["--command-scale", "0.001"],
            Gain(GAIN),
        );
    }
}
