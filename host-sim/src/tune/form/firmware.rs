//! The table of firmwares: structure, rate, filter, units, names and rounding of each. docs/tuning.md has the source of
//! every row.

use std::f64::consts::{PI, TAU};

use super::firmware_loop::{AlphaBeta, Law, Position};

/// A firmware and its controller.
#[derive(Debug)]
pub(super) struct Firmware {
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    /// Period of its loop, s; none where the program that it is built into decides.
    pub(super) sample_time: Option<f64>,
    /// From the reading to the output, samples.
    pub(super) delay: f64,
    pub(super) filter: Filter,
    /// Its usual filter, rad/s; none for one that is chosen with the gains.
    pub(super) cutoff: Option<f64>,
    pub(super) law: Law,
    pub(super) position: Position,
    /// Share of the newest error in the integral.
    pub(super) newest: f64,
    pub(super) takes: Takes,
    /// Its unit of position, rad; none for the result's own, rad or m.
    pub(super) angle: Option<f64>,
    pub(super) parameters: &'static [Parameter],
    /// Its usual limit of the velocity, rad/s, with its name.
    pub(super) velocity_limit: Option<(f64, &'static str)>,
    pub(super) remarks: &'static [&'static str],
}

/// What a controller puts out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Takes {
    /// The command of the result.
    Same,
    /// Torque, N·m.
    Torque,
    /// A share of the largest current.
    ShareOfCurrent,
    /// Volts.
    Voltage,
    /// A share of the supply voltage.
    ShareOfVoltage,
    /// Acceleration over 2π: the gain of the velocity is then its bandwidth in Hz.
    Acceleration,
}

/// A parameter.
#[derive(Debug)]
pub(super) struct Parameter {
    pub(super) name: &'static str,
    /// Its unit; $ stands for the unit of the command.
    pub(super) unit: &'static str,
    pub(super) of: Of,
    pub(super) factor: f64,
    pub(super) rounding: Rounding,
}

/// The quantity that a parameter is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Of {
    /// A gain of the law, by its place.
    Gain(usize),
    /// Kv/Kvi of a cascade, s.
    ResetTime,
    /// The filter's own number.
    Filter,
    /// 1/b, the feed-forward of the acceleration.
    Acceleration,
    /// a/b, the feed-forward of the velocity.
    Velocity,
    /// c/b, the command against Coulomb friction.
    Friction,
    /// The largest command.
    Limit,
}

/// The numbers that a firmware can store.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rounding {
    /// Six digits.
    Digits,
    /// Decimal places.
    Places(usize),
    /// Whole numbers from 0 to 16383, rounded down: a larger gain would have smaller margins.
    Register,
}

/// A velocity filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Filter {
    /// The difference of two positions.
    Difference,
    /// Low-pass filter of the difference, its number the cut-off, rad/s.
    LowPass,
    /// The same by its time constant, s, with the pole Tf/(Tf + T).
    TimeConstant,
    /// The same by the share of the newest difference.
    NewestShare,
    /// Phase-locked loop whose velocity is its integral: bw²/(s + bw)², its number bw, rad/s.
    Observer,
    /// Phase-locked loop (2ωs + ω²)/(s + ω)², its number 2.48 ω/2π, Hz.
    LockedLoop,
}

impl Filter {
    const BANDWIDTH_OVER_FREQUENCY: f64 = 2.48;

    /// Its number for a frequency, rad/s, and a sample time, s.
    pub(super) fn number(self, frequency: f64, time: f64) -> f64 {
        match self {
            Self::Difference => 0.0,
            Self::LowPass | Self::Observer => frequency,
            Self::TimeConstant => 1.0 / frequency,
            Self::NewestShare => -(-frequency * time).exp_m1(),
            Self::LockedLoop => Self::BANDWIDTH_OVER_FREQUENCY * frequency / TAU,
        }
    }

    /// The filter of a number.
    pub(super) fn with(self, number: f64, time: f64, position: Position) -> AlphaBeta {
        let low_pass = |beta: f64| AlphaBeta {
            alpha: 1.0,
            beta,
            direct: 0.0,
            position,
        };
        let locked = |frequency: f64, direct: f64| AlphaBeta {
            alpha: 2.0 * frequency * time,
            beta: (frequency * time).powi(2),
            direct,
            position,
        };
        match self {
            Self::Difference => low_pass(1.0),
            Self::LowPass => low_pass(-(-number * time).exp_m1()),
            Self::TimeConstant => low_pass(time / (number + time)),
            Self::NewestShare => low_pass(number),
            Self::Observer => locked(number, 0.0),
            Self::LockedLoop => locked(TAU * number / Self::BANDWIDTH_OVER_FREQUENCY, 1.0),
        }
    }

    /// The cut-off, rad/s, of the low-pass filter that gains are designed with in its place: of the same pole, of the
    /// same lag, or where it has none, of the same noise.
    pub(super) fn cutoff(self, frequency: f64, time: f64) -> f64 {
        let highest = 0.99 * PI / time;
        let cutoff = match self {
            Self::Difference => highest,
            Self::LowPass | Self::NewestShare => frequency,
            Self::TimeConstant => (frequency * time).ln_1p() / time,
            Self::Observer => 0.5 * frequency,
            Self::LockedLoop => 2.5 * frequency,
        };
        cutoff.min(highest)
    }
}

impl Rounding {
    /// The nearest number that can be stored.
    pub(super) fn of(self, value: f64) -> f64 {
        match self {
            Self::Digits => format!("{value:.5e}").parse().unwrap_or(value),
            Self::Places(places) => format!("{value:.places$}").parse().unwrap_or(value),
            Self::Register => value.floor().clamp(0.0, 16383.0),
        }
    }
}

/// A parameter with six digits.
const fn float(name: &'static str, unit: &'static str, of: Of) -> Parameter {
    times(1.0, name, unit, of)
}

/// The same times a factor.
const fn times(factor: f64, name: &'static str, unit: &'static str, of: Of) -> Parameter {
    Parameter {
        name,
        unit,
        of,
        factor,
        rounding: Rounding::Digits,
    }
}

/// A controller in the program's own terms.
const PLAIN: Firmware = Firmware {
    name: "pid",
    title: "u = kp e + ki ∑ e T − kd v, v the low-pass filtered difference of the position",
    sample_time: None,
    delay: 0.0,
    filter: Filter::LowPass,
    cutoff: None,
    law: Law::Pid,
    position: Position::Measured,
    newest: 1.0,
    takes: Takes::Same,
    angle: None,
    parameters: &[
        float("kp", "$/rad", Of::Gain(0)),
        float("ki", "$/(rad s)", Of::Gain(1)),
        float("kd", "$ s/rad", Of::Gain(2)),
        float("cutoff", "rad/s", Of::Filter),
    ],
    velocity_limit: None,
    remarks: &[],
};

const CASCADE: Firmware = Firmware {
    name: "cascade",
    title: "w = Kx e, u = Kv (w − v) + Kvi ∑ (w − v) T, v the low-pass filtered difference of the position",
    law: Law::Cascade,
    parameters: &[
        float("Kx", "1/s", Of::Gain(0)),
        float("Kv", "$ s/rad", Of::Gain(1)),
        float("Kvi", "$/rad", Of::Gain(2)),
        times(1e3, "Tn = Kv/Kvi", "ms", Of::ResetTime),
        float("cutoff", "rad/s", Of::Filter),
    ],
    remarks: &["The loop is linear only while |e| is below the limit of the velocity over Kx."],
    ..PLAIN
};

/// All of them.
pub(super) static FIRMWARES: &[Firmware] = &[
    PLAIN,
    CASCADE,
    Firmware {
        name: "simplefoc",
        title: "SimpleFOC 2.4.0, motion control `angle`",
        // move() follows loopFOC() in the loop of the examples.
        delay: 1.0,
        filter: Filter::TimeConstant,
        cutoff: Some(200.0),
        newest: 0.5,
        angle: Some(1.0),
        parameters: &[
            float("motor.P_angle.P", "1/s", Of::Gain(0)),
            float("motor.PID_velocity.P", "$ s/rad", Of::Gain(1)),
            float("motor.PID_velocity.I", "$/rad", Of::Gain(2)),
            float("motor.LPF_velocity.Tf", "s", Of::Filter),
            float("motor.PID_velocity.limit", "$", Of::Limit),
        ],
        velocity_limit: Some((20.0, "motor.velocity_limit")),
        remarks: &[
            "PID_velocity.D stays 0, and LPF_angle off.",
            "The gains hold for the sample time below: state the period of your loop, times motion_downsample, by \
             --sample-time.",
            "The unit of the command is that of motor.torque_controller: V for `voltage`, A for the currents. Before 2.4.0, \
             `voltage` with a phase_resistance took A.",
            "Commander shows three decimals: set small gains in the program.",
        ],
        ..CASCADE
    },
    Firmware {
        name: "odrive",
        title: "ODrive v3, firmware 0.5.6, position control",
        sample_time: Some(125e-6),
        filter: Filter::Observer,
        cutoff: Some(1000.0),
        position: Position::Filtered,
        newest: 0.0,
        takes: Takes::Torque,
        angle: Some(TAU),
        parameters: &[
            float("controller.config.pos_gain", "1/s", Of::Gain(0)),
            float("controller.config.vel_gain", "Nm/(turn/s)", Of::Gain(1)),
            float(
                "controller.config.vel_integrator_gain",
                "Nm/turn",
                Of::Gain(2),
            ),
            float("encoder.config.bandwidth", "rad/s", Of::Filter),
            float(
                "controller.config.inertia",
                "Nm/(turn/s²)",
                Of::Acceleration,
            ),
        ],
        velocity_limit: Some((2.0 * TAU, "controller.config.vel_limit")),
        remarks: &[
            "Position and velocity are those of the encoder's shaft.",
            "A saturated integral decays within 12.5 ms. Velocities below half of 125 µs times bandwidth² counts/s \
             read as zero.",
        ],
        ..CASCADE
    },
    Firmware {
        name: "moteus",
        title: "moteus, firmware of 2026-06, position mode",
        sample_time: Some(1.0 / 30e3),
        filter: Filter::LockedLoop,
        cutoff: Some(TAU * 400.0 / 2.48),
        position: Position::Predicted,
        takes: Takes::Torque,
        angle: Some(TAU),
        parameters: &[
            float("servo.pid_position.kp", "Nm/rev", Of::Gain(0)),
            float("servo.pid_position.ki", "Nm/(rev s)", Of::Gain(1)),
            float("servo.pid_position.kd", "Nm/(rev/s)", Of::Gain(2)),
            float("servo.pid_position.ilimit", "Nm", Of::Limit),
            float("motor_position.sources.0.pll_filter_hz", "Hz", Of::Filter),
            times(1.0 / TAU, "inertia_feedforward", "kg m²", Of::Acceleration),
        ],
        remarks: &[
            "ilimit is 0 by default, which turns the integral off: leave at least 1.2 times the torque that holds the load.",
            "The error of the position is rounded to 1/65536 of a turn. default_accel_limit shapes a step of the target.",
            "Position and torque are those of the output.",
        ],
        ..PLAIN
    },
    Firmware {
        name: "vesc",
        title: "VESC, firmware 7.01, FOC, position control",
        sample_time: Some(1e-3),
        filter: Filter::NewestShare,
        // The default of p_pid_kd_filter, 0.2 of a sample of 1 ms.
        cutoff: Some(223.143_551_314_21),
        takes: Takes::ShareOfCurrent,
        angle: Some(PI / 180.0),
        parameters: &[
            float("p_pid_kp", "1/deg", Of::Gain(0)),
            float("p_pid_ki", "1/(deg s)", Of::Gain(1)),
            float("p_pid_kd_proc", "s/deg", Of::Gain(2)),
            Parameter {
                rounding: Rounding::Places(4),
                ..float("p_pid_kd_filter", "", Of::Filter)
            },
        ],
        remarks: &[
            "p_pid_kd and p_pid_gain_dec_angle stay 0, p_pid_ang_div 1. The gains hold for the l_current_max that was stated.",
            "Targets are within one turn, 0 to 360°. There is no feed-forward.",
            "Below a count per sample the damping fades: 88 °/s with 4096 counts, 22 °/s with 16384.",
            "The thread sleeps 1/sp_pid_loop_rate and then runs: the true period is a little longer.",
        ],
        ..PLAIN
    },
    Firmware {
        name: "dynamixel",
        title: "Dynamixel X, position control (mode 3 or 4)",
        sample_time: Some(1e-3),
        law: Law::Proportional,
        filter: Filter::Difference,
        takes: Takes::ShareOfVoltage,
        // A count.
        angle: Some(TAU / 4096.0),
        parameters: &[Parameter {
            rounding: Rounding::Register,
            // 885 steps of PWM are all of it, and the manual divides the register by 128.
            ..times(
                885.0 * 128.0,
                "Position P Gain (84)",
                "register",
                Of::Gain(0),
            )
        }],
        remarks: &[
            "Position D Gain (80) and Position I Gain (82) are 0: their SI values depend on a period that is not published. \
             Computed with 1 ms.",
            "The scale of P is the manual's, P/128. On an XL330 twice that divisor was measured: hold the horn, compare \
             Present PWM with the error, and double the register if it is half.",
            "Gains are lost when the power goes. Goal PWM limits the output.",
        ],
        ..PLAIN
    },
    Firmware {
        name: "wpilib",
        title: "WPILib PIDController and SimpleMotorFeedforward",
        sample_time: Some(20e-3),
        law: Law::PidOnError,
        filter: Filter::Difference,
        takes: Takes::Voltage,
        parameters: &[
            float("kP", "V/rad", Of::Gain(0)),
            float("kI", "V/(rad s)", Of::Gain(1)),
            float("kD", "V s/rad", Of::Gain(2)),
            float("setIntegratorRange, ±", "V", Of::Limit),
            float("kS", "V", Of::Friction),
            float("kV", "V s/rad", Of::Velocity),
            float("kA", "V s²/rad", Of::Acceleration),
        ],
        remarks: &[
            "The period is a constant of the constructor: call calculate() at that rate.",
            "kD acts on the error: a step of the target kicks. ProfiledPIDController or a smoothed target avoids that.",
            "The integral gives at most ±1 V unless setIntegratorRange is called; the output is not limited.",
        ],
        ..PLAIN
    },
    Firmware {
        name: "sparkmax",
        title: "REV SPARK MAX, position control",
        sample_time: Some(1e-3),
        law: Law::PidOnError,
        filter: Filter::Difference,
        takes: Takes::ShareOfVoltage,
        angle: Some(TAU),
        parameters: &[
            float("kP", "1/rotation", Of::Gain(0)),
            times(1e-3, "kI", "1/(rotation ms)", Of::Gain(1)),
            times(1e3, "kD", "ms/rotation", Of::Gain(2)),
        ],
        remarks: &[
            "kI and kD are per millisecond. Divide all by the position conversion factor.",
            "The gain follows the battery unless voltage compensation is on. The integral is not limited: state IMaxAccum.",
        ],
        ..PLAIN
    },
    Firmware {
        name: "linuxcnc",
        title: "LinuxCNC 2.10 pid, servo thread of 1 ms",
        sample_time: Some(1e-3),
        law: Law::PidOnError,
        filter: Filter::Difference,
        parameters: &[
            float("Pgain", "$/unit", Of::Gain(0)),
            float("Igain", "$/(unit s)", Of::Gain(1)),
            float("Dgain", "$ s/unit", Of::Gain(2)),
            float("FF1", "$ s/unit", Of::Velocity),
            float("FF2", "$ s²/unit", Of::Acceleration),
            float("maxoutput", "$", Of::Limit),
        ],
        remarks: &[
            "A unit is a rad of the motor (m of a linear axis): times 2π/p for a screw of pitch p, times π/180 for degrees.",
            "Without maxoutput the integral winds up. Dgain acts on the error: wire the encoder's velocity to \
             feedback-deriv against the noise of a count per thread.",
        ],
        ..PLAIN
    },
    Firmware {
        name: "cia402",
        title: "P-PI drive with normalised gains",
        takes: Takes::Acceleration,
        parameters: &[
            float("position gain", "1/s", Of::Gain(0)),
            float("speed gain", "Hz", Of::Gain(1)),
            times(1e3, "speed integral time", "ms", Of::ResetTime),
        ],
        remarks: &[
            "The speed gain is in Hz where the inertia ratio of the drive is set right.",
            "Round the position gain down and the integral time up to the steps of your drive.",
            "Filter and period of the drive are not known: --cutoff and --sample-time state them.",
            "The loop is linear only while |e| is below the limit of the speed over the position gain.",
        ],
        ..CASCADE
    },
];
