//! Headings, columns and separators of a text.

use super::super::{MOTION, cells, map, text, text_of_cells};
use super::Expected::{Gain, Named};
use super::{Cases, kept, map_at};
use crate::identify::GAIN;

fn utf16(text: &str) -> Vec<u8> {
    let units = std::iter::once(0xfeff).chain(text.encode_utf16());
    units.flat_map(u16::to_le_bytes).collect()
}

impl Cases {
    pub(super) fn dialects(&mut self) {
        let of = &*MOTION;
        let plain = of.text();
        let columns = |names: &str| plain.replacen("t_s,q_rad,u_V", names, 1);
        self.right("plain", plain.clone());
        self.right("spaces", plain.replace(',', "   "));
        let commas = |by: &str| plain.replace(',', by).replace('.', ",");
        self.right("decimal commas, semicolons", commas(";"));
        self.right("decimal commas, tabs", commas("\t"));
        self.right("decimal commas, spaces", commas(" "));
        self.named("UTF-16", utf16(&plain), "UTF-16");
        self.right("row of units", columns("t,q,u\ns,rad,V"));
        let bare = kept(&plain, |k| k > 0);
        let unit = "--position-unit rad";
        self.right("no heading", bare.clone());
        self.stated("no heading, unit stated", bare, unit, Gain(GAIN));
        self.right("empty lines", plain.replace('\n', "\n\n"));
        let german = columns("Zeit [s],Winkel [rad],Spannung [V]");
        self.right("German names", german.replace(',', ";").replace('.', ","));
        let capitals = columns("TIME (S),ENCODER POSITION (RAD),MOTOR VOLTAGE");
        self.right("names in capitals", capitals);
        self.stated(
            "names that say nothing",
            columns("A1,B1,C1"),
            unit,
            Gain(GAIN),
        );
        let which = Named("which column is the command");
        self.stated("one name for two columns", columns("t,x,x"), unit, which);
        let position = &of.position;
        let speed = map_at(position, |k, q| 1e3 * (q - position[k.saturating_sub(1)]));
        let error = map_at(position, |k, q| of.reference[k] - q);
        let many = text_of_cells(&[
            ("state", vec!["RUN".to_owned(); of.time.len()]),
            ("temperature", cells(&map(&of.time, |t| 30.0 + t), 2)),
            ("u_V", cells(&of.command, 5)),
            ("speed_rpm", cells(&speed, 3)),
            ("error_rad", cells(&error, 6)),
            ("q_ref_rad", cells(&of.reference, 6)),
            ("q_rad", cells(position, 6)),
            ("time_s", cells(&of.time, 4)),
        ]);
        self.right("more columns, in another order", many);
        let load = map(position, |q| q + 0.3 * (3.0 * q).sin() + 1.0);
        let two = text(&[
            ("t_s", &of.time, 4),
            ("load_angle_rad", &load, 6),
            ("motor_angle_rad", position, 6),
            ("u_V", &of.command, 5),
        ]);
        self.right("two positions", two);
        self.named(
            "a name too many",
            columns("t_s,q_rad,u_V,x"),
            "log.csv:1: this",
        );
        let numbered = |(k, line): (usize, &str)| match k {
            0 => format!("{line}\n"),
            _ => format!("\"{k}\",{line}\n"),
        };
        let row_names = plain.lines().enumerate().map(numbered);
        self.right("row names of R", row_names.collect::<String>());
        let list = |line: &str| match line.split(',').collect::<Vec<_>>()[..] {
            [t, q, u] => format!("{t},\"[{q}, 0.5]\",\"[{u}, 0.1]\"\n"),
            _ => String::new(),
        };
        let lists: String = plain.lines().skip(1).map(list).collect();
        self.right("lists in cells", format!("t_s,q [rad],u [V]\n{lists}"));
        let signal = |name: &str, values: &[f64]| {
            let values: String = values.iter().map(|value| format!(",{value:.6}")).collect();
            format!("{name}{values}\n")
        };
        let signals = [("t_s", &of.time), ("q_rad", position), ("u_V", &of.command)];
        let signals = signals.map(|(name, values)| signal(name, values));
        self.right("a signal a line", signals.concat());
        self.right("preamble", format!("Drive 7\nrecorded by hand\n{plain}"));
    }
}
