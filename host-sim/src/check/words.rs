//! What is told of a scenario at a terminal.

use std::fmt;

use super::document::Check;

/// A check in words.
#[derive(Debug, Clone, Copy)]
pub struct Words<'a>(pub &'a Check);

impl fmt::Display for Words<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let check = self.0;
        let servo = &check.servo;
        write!(
            f,
            "servo        a = {:.6} 1/s, b = {:.6} rad/s² per command unit",
            servo.a, servo.b
        )?;
        if let Some(time) = servo.time_constant {
            write!(f, "; time constant {time:.4} s")?;
        }
        if let Some(speed) = servo.top_speed {
            write!(f, "; top speed {speed:.4} rad/s")?;
        }
        if servo.breakaway > 0.0 {
            write!(
                f,
                "; friction and load take {:.4} of the command",
                servo.breakaway
            )?;
        }
        writeln!(f)?;
        self.of_the_loop(f)?;
        let certificate = &check.certificate;
        write!(f, "certificate  ")?;
        match certificate.gain_margin {
            Some(margin) if certificate.certified => writeln!(
                f,
                "every servo of the box is stable; the gain may rise by {margin:.1} at least"
            )?,
            _ if certificate.certified => writeln!(f, "every servo of the box is stable")?,
            _ => writeln!(
                f,
                "none: no identifier.plant_box is stated, or the law needs none"
            )?,
        }
        let encoder = &check.encoder;
        write!(
            f,
            "encoder      {:.3e} rad a count; the servo moves by {:.0} counts rms",
            encoder.resolution, encoder.motion
        )?;
        if let Some(step) = encoder.command_per_count {
            write!(f, "; a count moves the command by {step:.4}")?;
        }
        writeln!(f)?;
        for (place, known) in check.known.iter().enumerate() {
            let heading = if place == 0 {
                "identified   "
            } else {
                "             "
            };
            write!(f, "{heading}{:<8}", known.unknown)?;
            match (known.std_error, known.from) {
                (Some(error), Some(from)) => writeln!(
                    f,
                    "known to {:.2e} {} after about {from:.3} s; at the end to {error:.1e} at best",
                    known.needed, known.unit
                )?,
                (Some(error), None) => writeln!(
                    f,
                    "not to {:.2e} {} when the run breaks off; to {error:.1e} at best",
                    known.needed, known.unit
                )?,
                (None, _) => writeln!(f, "not: the motion says nothing of it")?,
            }
        }
        if check.warnings.is_empty() {
            return write!(f, "nothing speaks against it");
        }
        let lines: Vec<String> = check
            .warnings
            .iter()
            .map(|text| format!("warning: {text}"))
            .collect();
        f.write_str(&lines.join("\n"))
    }
}

impl Words<'_> {
    fn of_the_loop(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "loop         ")?;
        let Some(found) = self.0.closed_loop else {
            return writeln!(f, "not a PID's: the law closes one of its own");
        };
        if !found.stable {
            return writeln!(f, "unstable");
        }
        let shown = |value: Option<f64>, digits: usize| {
            value.map_or("–".to_owned(), |value| format!("{value:.digits$}"))
        };
        let [fall, rise] = found.gain_margins;
        writeln!(
            f,
            "bandwidth {} rad/s, crossover {} rad/s; phase margin {}°, gain may fall to {} and rise to {} \
             times, modulus margin {}",
            shown(found.bandwidth, 1),
            shown(found.crossover, 1),
            shown(found.phase_margin, 0),
            fall.map_or("any".to_owned(), |fall| format!("{fall:.2}")),
            shown(rise, 1),
            shown(found.modulus_margin, 2)
        )
    }
}
