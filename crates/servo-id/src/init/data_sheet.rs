//! From a motor's data sheet to a servo, q̈ = −a q̇ + b u − c sign q̇ on the motor's shaft.

/// The quantity of the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// The current, A, of an amplifier with a current loop.
    Current {
        /// The largest current, A.
        peak: f64,
    },
    /// The voltage at the motor, V.
    Voltage {
        /// The largest voltage, V.
        supply: f64,
        /// Resistance of the winding, Ω.
        resistance: f64,
    },
}

/// The figures of a data sheet, SI, on the motor's shaft unless stated otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataSheet {
    /// The quantity of the command.
    pub drive: Drive,
    /// k_t, N m/A; the back-EMF constant k_e, V s/rad, is the same number.
    pub torque_constant: f64,
    /// kg m².
    pub rotor_inertia: f64,
    /// Behind the gear, kg m².
    pub load_inertia: f64,
    /// Turns of the motor for one of the load.
    pub gear: f64,
    /// Counts of the encoder for a turn of the motor.
    pub counts: f64,
    /// Viscous friction, N m s/rad.
    pub viscous: f64,
    /// Coulomb friction, N m.
    pub coulomb: f64,
    /// Sample time, s.
    pub sample_time: f64,
}

/// The servo of a data sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSheet {
    /// J, kg m².
    pub inertia: f64,
    /// 1/s.
    pub a: f64,
    /// rad/s² per command unit.
    pub b: f64,
    /// rad/s².
    pub coulomb: f64,
    /// |u| is at most this, command units.
    pub limit: f64,
    /// The speed that the largest command holds, rad/s; none without friction.
    pub top_speed: Option<f64>,
}

/// A number that no motor has.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("--{name} {value} is not allowed: it must be {allowed}")]
pub struct SheetError {
    /// Its option.
    pub name: &'static str,
    /// The stated value.
    pub value: f64,
    /// The allowed numbers.
    pub allowed: &'static str,
}

impl DataSheet {
    /// The servo with J = J_rotor + J_load/n². Driven by current, b = k_t/J and a = B/J. Driven by voltage, b = k_t/(R
    /// J) and a = (B + k_t k_e/R)/J.
    ///
    /// # Errors
    /// The number that no motor has.
    pub fn servo(&self) -> Result<ServoSheet, SheetError> {
        self.check()?;
        let inertia = self.rotor_inertia + self.load_inertia / (self.gear * self.gear);
        let per_ampere = self.torque_constant / inertia;
        let (a, b, limit) = match self.drive {
            Drive::Current { peak } => (self.viscous / inertia, per_ampere, peak),
            Drive::Voltage { supply, resistance } => {
                let braking = self.torque_constant * self.torque_constant / resistance;
                let a = (self.viscous + braking) / inertia;
                (a, per_ampere / resistance, supply)
            }
        };
        let coulomb = self.coulomb / inertia;
        let speed = (b * limit - coulomb) / a;
        Ok(ServoSheet {
            inertia,
            a,
            b,
            coulomb,
            limit,
            top_speed: (a > 0.0).then_some(speed.max(0.0)),
        })
    }

    fn check(&self) -> Result<(), SheetError> {
        let stated = match self.drive {
            Drive::Current { peak } => vec![("peak-current", peak)],
            Drive::Voltage { supply, resistance } => {
                vec![("voltage", supply), ("resistance", resistance)]
            }
        };
        let numbers = [
            ("torque-constant", self.torque_constant),
            ("rotor-inertia", self.rotor_inertia),
            ("gear", self.gear),
            ("counts", self.counts),
            ("sample-time", self.sample_time),
            ("load-inertia", self.load_inertia),
            ("viscous", self.viscous),
            ("coulomb", self.coulomb),
        ];
        let mut all = numbers.into_iter().chain(stated);
        all.try_for_each(|(name, value)| check(name, value))
    }
}

/// Checks a number of a data sheet by the name of its option.
///
/// # Errors
/// A number that no motor has.
pub(crate) fn check(name: &'static str, value: f64) -> Result<(), SheetError> {
    /// Numbers between which a motor's are, in SI.
    const MAX: f64 = 1e9;
    const MIN_POSITIVE: f64 = 1e-12;
    let (least, allowed) = match name {
        "load-inertia" | "viscous" | "coulomb" => (0.0, "a number of at least 0, in SI units"),
        _ => (MIN_POSITIVE, "a number above 0, in SI units"),
    };
    match (least..=MAX).contains(&value) {
        true => Ok(()),
        false => Err(SheetError {
            name,
            value,
            allowed,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor of 24 V and about 70 W, with a load behind a gear of 5.
    pub(in super::super) const SHEET: DataSheet = DataSheet {
        drive: Drive::Voltage {
            supply: 24.0,
            resistance: 0.6,
        },
        torque_constant: 0.05,
        rotor_inertia: 3e-5,
        load_inertia: 5e-4,
        gear: 5.0,
        counts: 4096.0,
        viscous: 1e-5,
        coulomb: 5e-3,
        sample_time: 1e-3,
    };

    #[test]
    fn a_voltage_driven_motor_runs_up_to_its_no_load_speed_in_its_mechanical_time_constant() {
        let free = DataSheet {
            viscous: 0.0,
            coulomb: 0.0,
            ..SHEET
        };
        let servo = free.servo().expect("a motor");
        let inertia = 3e-5 + 5e-4 / 25.0;
        assert!((servo.inertia / inertia - 1.0).abs() < 1e-12);
        // The two figures that every catalogue has: U/k_e and R J/(k_t k_e).
        let speed = servo.top_speed.expect("back EMF brakes it");
        assert!((speed - 24.0 / 0.05).abs() < 1e-9);
        assert!((1.0 / servo.a - 0.6 * inertia / (0.05 * 0.05)).abs() < 1e-12);
        // Standing still, the torque is k_t U/R.
        assert!((servo.b * 24.0 - 0.05 * 24.0 / 0.6 / inertia).abs() < 1e-6);
    }

    #[test]
    fn a_current_driven_motor_turns_torque_into_acceleration() {
        let sheet = DataSheet {
            drive: Drive::Current { peak: 10.0 },
            ..SHEET
        };
        let servo = sheet.servo().expect("a motor");
        assert!((servo.b * 10.0 * servo.inertia - 0.5).abs() < 1e-12);
        assert!((servo.a * servo.inertia - 1e-5).abs() < 1e-15);
        assert!((servo.coulomb * servo.inertia - 5e-3).abs() < 1e-12);
        assert!((servo.limit - 10.0).abs() < 1e-12);
    }

    #[test]
    fn a_figure_that_no_motor_has_is_refused_by_name() {
        let wrong = |sheet: DataSheet| sheet.servo().expect_err("refused").name;
        let of = |resistance| DataSheet {
            drive: Drive::Voltage {
                supply: 24.0,
                resistance,
            },
            ..SHEET
        };
        assert_eq!(wrong(of(0.0)), "resistance");
        assert_eq!(wrong(of(f64::NAN)), "resistance");
        assert_eq!(
            wrong(DataSheet {
                gear: -1.0,
                ..SHEET
            }),
            "gear"
        );
        assert_eq!(
            wrong(DataSheet {
                coulomb: -1.0,
                ..SHEET
            }),
            "coulomb"
        );
    }
}
