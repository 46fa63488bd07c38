//! The scenario as a text, every number with its derivation.

use super::chosen::{SHARE, UNSURE};
use super::{Chosen, DataSheet, Drive, ServoSheet};

/// The scenario of a data sheet.
#[must_use]
pub fn scenario(sheet: &DataSheet, servo: &ServoSheet, chosen: &Chosen) -> String {
    let (unit, of_a, of_b, of_limit) = match sheet.drive {
        Drive::Current { .. } => ("A", "B/J", "k_t/J", "the peak current"),
        Drive::Voltage { .. } => ("V", "(B + k_t k_e/R)/J", "k_t/(R J)", "the supply voltage"),
    };
    let n = short;
    let resistance = match sheet.drive {
        Drive::Voltage { resistance, .. } => format!(", R = {} ohm", n(resistance)),
        Drive::Current { .. } => String::new(),
    };
    format!(
        "# A servo from its data sheet: the command is in {unit}, the position is the motor's, in rad.
#   k_t = k_e = {k_t} N m/A{resistance}, B = {viscous} N m s/rad, Coulomb friction {torque} N m
#   J = J_rotor + J_load/n^2 = {rotor} + {load}/{gear}^2 = {inertia} kg m^2
# The simulated servo is a guess: replace [plant] by the identified one.

[plant]                         # q'' = -a q' + b u + load - coulomb sign q'
a = {a}    # 1/s: {of_a}
b = {b}    # rad/s^2 per {unit}: {of_b}
coulomb = {coulomb}    # rad/s^2: Coulomb friction/J
load = 0.0                      # rad/s^2: torque of a hanging or spring load/J

[encoder]
counts_per_rev = {counts}    # per motor revolution, after x4 quadrature

[amplifier]
limit = {limit}    # {unit}: {of_limit}

[controller]                    # poles at omega = {omega} rad/s: {omega_from}
kp = {kp}    # {unit}/rad: 3 omega^2/b
kd = {kd}    # {unit} s/rad: (3 omega - a)/b, and omega/b at least
ki = {ki}    # {unit}/(rad s): omega^3/(2 b), or less, so that the range is certified
sample_time = {sample_time}    # s
velocity_filter = {{ kind = \"low-pass\", cutoff = {cutoff} }}    # rad/s: 10 omega

[excitation]                    # the reference: steps at random
kind = \"prbs\"
amplitude = {amplitude}    # rad: a step takes kp 2 amplitude = {share} of the limit
hold = {hold}    # s: 4/omega, so that the servo arrives
order = 10

[identifier]
law = \"gauss-newton\"
parameters = [\"a\", \"b\", \"coulomb\", \"load\"]
# Where the estimates are kept: inertia and gain off by a factor of {unsure}, friction up to 2 a + omega/10. As
# plant_box, law = \"gradient\" certifies these gains for all of it.
bounds = {{ a = [{a_low}, {a_high}], b = [{b_low}, {b_high}] }}

[commission]                    # what `commission` may do
travel = {travel}    # rad to either side: one motor revolution
speed = {speed}    # rad/s: {of_speed}

[run]
duration = 20.0                 # s
",
        k_t = n(sheet.torque_constant),
        viscous = n(sheet.viscous),
        torque = n(sheet.coulomb),
        rotor = n(sheet.rotor_inertia),
        load = n(sheet.load_inertia),
        gear = n(sheet.gear),
        inertia = n(servo.inertia),
        a = n(servo.a),
        b = n(servo.b),
        coulomb = n(servo.coulomb),
        counts = n(sheet.counts),
        limit = n(servo.limit),
        omega = n(chosen.omega),
        omega_from = chosen.omega_from,
        kp = n(chosen.kp),
        kd = n(chosen.kd),
        ki = n(chosen.ki),
        sample_time = n(sheet.sample_time),
        cutoff = n(chosen.cutoff),
        amplitude = n(chosen.amplitude),
        share = SHARE,
        hold = n(chosen.hold),
        unsure = UNSURE,
        a_low = n(chosen.a_range[0]),
        a_high = n(chosen.a_range[1]),
        b_low = n(chosen.b_range[0]),
        b_high = n(chosen.b_range[1]),
        travel = n(chosen.travel),
        speed = n(chosen.speed),
        of_speed = "0.3 of the speed that the largest command reaches over that travel, at most the top speed",
    )
}

/// A number of six digits, as TOML has it: `0.05`, `1.2e-7`, `300.0`.
fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.5e}").parse().unwrap_or(number);
    format!("{rounded:?}")
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short_and_stay_numbers() {
        for (number, text) in [
            (0.05, "0.05"),
            (300.0, "300.0"),
            (1.0 / 3.0, "0.333333"),
            (1.23456789e-7, "1.23457e-7"),
            (0.0, "0.0"),
        ] {
            assert_eq!(short(number), text);
        }
    }
}
