//! Units of position and command.

use std::f64::consts::TAU;

use super::super::{COUNTS, GAIN, MOTION, map, text};
use super::Expected::Gain;
use super::{Cases, map_at, noise};

impl Cases {
    pub(super) fn units(&mut self) {
        let of = &*MOTION;
        let q = &of.position;
        let placed = |name: &str, position: &[f64], decimals: usize| {
            text(&[
                ("t_s", &of.time, 4),
                (name, position, decimals),
                ("u_V", &of.command, 5),
            ])
        };
        let degrees = map(q, f64::to_degrees);
        let turns = map(q, |q| q / TAU);
        let counts = map(q, |q| (q / TAU * COUNTS).round());
        self.right("degrees by name", placed("angle_deg", &degrees, 4));
        self.right("turns by name", placed("position [rev]", &turns, 6));
        self.right("steps of 0.036", placed("angle", &degrees, 6));
        let steps = map(q, |q| (q / TAU * 4096.0).round() / 4096.0);
        self.right("steps of a 4096th", placed("angle", &steps, 9));
        self.right("steps of 2π/10000", placed("q", q, 9));
        let whole = placed("encoder", &counts, 0);
        let stated = "--counts-per-rev 10000";
        self.gain("whole numbers", whole.clone(), GAIN * COUNTS / TAU);
        self.stated("whole numbers, counts stated", whole, stated, Gain(GAIN));
        let quarter = placed("encoder", &map(&counts, |n| 4.0 * n), 0);
        let of_quarter = "--counts-per-rev 40000";
        self.stated(
            "a quarter of the counts stated",
            quarter,
            of_quarter,
            Gain(GAIN),
        );
        let smooth = placed("position", &map_at(q, |k, q| q + 2e-4 * noise(k)), 9);
        self.right("smooth, no unit", smooth.clone());
        let unit = "--position-unit rad";
        self.stated("smooth, unit stated", smooth, unit, Gain(GAIN));
        let called = placed("q_rad", &degrees, 6);
        self.gain("degrees called rad", called, GAIN.to_degrees());
        let called = placed("q_deg", q, 9);
        self.gain("rad called degrees", called, GAIN.to_radians());
        let called = placed("q_rad", &counts, 0);
        self.gain("counts called rad", called, GAIN * COUNTS / TAU);
        let called = placed("q_rad", &map(q, |q| 1e6 * q), 0);
        self.named("microradians called rad", called, "which nothing reaches");
        self.right("millimetres", placed("pos_mm", &map(q, |q| 1e3 * q), 3));
        let wrapped = |period: f64, from: f64, positions: &[f64]| {
            map(positions, |q| {
                (q + 0.998 * period - from).rem_euclid(period) + from
            })
        };
        self.right(
            "0 to 360",
            placed("angle", &wrapped(360.0, 0.0, &degrees), 6),
        );
        let half = wrapped(360.0, -180.0, &map(&degrees, |q| q + 180.0));
        self.right("-180 to 180", placed("angle", &half, 6));
        self.right("0 to 2π", placed("angle", &wrapped(TAU, 0.0, q), 9));
        let to_counts = placed("encoder", &wrapped(COUNTS, 0.0, &counts), 0);
        self.stated("0 to the counts", to_counts, stated, Gain(GAIN));
        let far = map(q, |q| q + TAU * 500.0);
        self.right("far from zero", placed("q_rad", &far, 6));
        let commanded = |name: &str, factor: f64| {
            let command = map(&of.command, |u| factor * u);
            text(&[("t_s", &of.time, 4), ("q_rad", q, 6), (name, &command, 5)])
        };
        self.gain(
            "command in per cent",
            commanded("duty [%]", 10.0),
            GAIN / 10.0,
        );
        let current = commanded("motor_current_A", 0.25);
        self.gain("command as a current", current, 4.0 * GAIN);
        let scale = "--command-scale 0.001";
        self.stated(
            "command scaled",
            commanded("pwm", 1000.0),
            scale,
            Gain(GAIN),
        );
    }
}
