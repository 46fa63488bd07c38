//! Instructions of a whole sample of what others use or would write, beside ours: from the register of the encoder's
//! counter, with a setpoint and an offset, to the command. Ours are among the samples. All have the paper's gains and
//! limit, in `f32`.

use dsp_process::SplitProcess;
use firmware_stm32::instructions::Counter as Instructions;
use firmware_stm32::measured::{counted, measure, split};
use firmware_stm32::paper;
use identifier_core::measurement::Counter;
use identifier_core::settings::{Settings, SettingsError};
use idsp::Build;
use idsp::iir::{BiquadClamp, DirectForm1, pid::Units};

/// The paper's gains for an error in counts: proportional, derivative per count a sample, integral per count and sample.
#[derive(Clone, Copy)]
struct Gains {
    proportional: f32,
    derivative: f32,
    integral: f32,
    limit: f32,
}

/// A sample of a loop, without anything that identifies unless it says so.
trait Sample {
    fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32;

    /// False if it has identified another servo than the paper's.
    fn is_right(&self) -> bool {
        true
    }
}

pub(crate) fn run() -> Result<(), &'static str> {
    all(&Instructions::start()).map_err(|_| "a rival could not be built")
}

fn all(instructions: &Instructions) -> Result<(), SettingsError> {
    let settings = paper::settings();
    let gains = gains(&settings)?;
    count(instructions, "pid-idsp-biquad", Idsp::new(gains))?;
    count(instructions, "pid-crate-pid", CratePid::new(gains))?;
    count(instructions, "pid-hand-written", HandPid::new(gains))?;
    count(
        instructions,
        "gradient-hand-written",
        HandGradient::new(gains),
    )
}

fn count(
    instructions: &Instructions,
    name: &str,
    mut own: impl Sample,
) -> Result<(), SettingsError> {
    let tally = measure(0.0, |reference, register| {
        let (setpoint, offset, register) = core::hint::black_box(split((reference, register)));
        let sample = || own.sample(setpoint, offset, register);
        let (command, taken) = counted(instructions, sample);
        (f64::from(command), taken)
    })?;
    tally.print(name, 0);
    if own.is_right() {
        Ok(())
    } else {
        Err(SettingsError::NotGiven { setting: "b" })
    }
}

fn gains(settings: &Settings) -> Result<Gains, SettingsError> {
    let units = settings.units()?;
    let (count, time) = (1.0 / units.position(), units.sample_time());
    let pid = settings.controller.ok_or(SettingsError::NotGiven {
        setting: "controller",
    })?;
    Ok(Gains {
        proportional: (pid.kp * count) as f32,
        derivative: (pid.kd * count / time) as f32,
        integral: (pid.ki * count * time) as f32,
        limit: pid.limit[1] as f32,
    })
}

/// The error through a biquad with a clamp: its derivative is that of the error.
struct Idsp {
    counter: Counter<u16>,
    filter: BiquadClamp<f32, f32>,
    state: DirectForm1<f32>,
}

impl Idsp {
    fn new(gains: Gains) -> Self {
        let units = Units {
            t: 1.0,
            x: 1.0,
            y: 1.0,
        };
        let pid = idsp::iir::pid::Pid::<f32>::default()
            .kp(gains.proportional)
            .ki(gains.integral)
            .kd(gains.derivative)
            .output_limits(-gains.limit, gains.limit);
        Self {
            counter: Counter::new(0),
            filter: pid.build(&units),
            state: DirectForm1::default(),
        }
    }
}

impl Sample for Idsp {
    #[inline(never)]
    fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        let count = self.counter.read(register);
        let error = setpoint.wrapping_sub(count) as f32 + offset;
        self.filter.process(&mut self.state, error)
    }
}

struct CratePid {
    counter: Counter<u16>,
    pid: pid::Pid<f32>,
}

impl CratePid {
    fn new(gains: Gains) -> Self {
        let mut pid = pid::Pid::new(0.0, gains.limit);
        pid.p(gains.proportional, gains.limit)
            .i(gains.integral, gains.limit)
            .d(gains.derivative, gains.limit);
        Self {
            counter: Counter::new(0),
            pid,
        }
    }
}

impl Sample for CratePid {
    #[inline(never)]
    fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        let count = self.counter.read(register);
        self.pid.setpoint(setpoint as f32 + offset);
        self.pid.next_control_output(count as f32).output
    }
}

/// A PID as one would write it down: low-pass of the velocity, clamp, conditional integration.
struct HandPid {
    gains: Gains,
    last_register: u16,
    position: f32,
    velocity: f32,
    integral: f32,
}

/// The pole of the low-pass, the paper's 500 rad/s at 1 kHz.
const POLE: f32 = 0.606_53;

impl HandPid {
    fn new(gains: Gains) -> Self {
        Self {
            gains,
            last_register: 0,
            position: 0.0,
            velocity: 0.0,
            integral: 0.0,
        }
    }

    #[inline(always)]
    fn control(&mut self, setpoint: i32, offset: f32, register: u16) -> (f32, f32) {
        let moved = f32::from(register.wrapping_sub(self.last_register).cast_signed());
        self.last_register = register;
        self.position += moved;
        self.velocity = POLE * self.velocity + (1.0 - POLE) * moved;
        let error = setpoint as f32 + offset - self.position;
        let gains = &self.gains;
        let wanted = gains.proportional * error - gains.derivative * self.velocity + self.integral;
        let command = if wanted > gains.limit {
            gains.limit
        } else if wanted < -gains.limit {
            -gains.limit
        } else {
            wanted
        };
        if (wanted - command) * error <= 0.0 {
            self.integral += gains.integral * error;
        }
        (moved, command)
    }
}

impl Sample for HandPid {
    #[inline(never)]
    fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        self.control(setpoint, offset, register).1
    }
}

/// The same with a model of one sample's step and the gradient of a and b: no guard, no certificate, no compensated sum,
/// no check of a number. Units: counts and samples.
struct HandGradient {
    pid: HandPid,
    /// Output error, the model's increment and velocity, rate of the error, filtered regressor, sum of the correction.
    error: f32,
    increment: f32,
    velocity: f32,
    rate: f32,
    regressor: [f32; 2],
    integral: f32,
    acted: f32,
    estimates: [f32; 2],
}

impl HandGradient {
    fn new(gains: Gains) -> Self {
        Self {
            pid: HandPid::new(gains),
            error: 0.0,
            increment: 0.0,
            velocity: 0.0,
            rate: 0.0,
            regressor: [0.0; 2],
            integral: 0.0,
            acted: 0.0,
            estimates: [0.0, 0.08],
        }
    }
}

impl Sample for HandGradient {
    #[inline(never)]
    fn sample(&mut self, setpoint: i32, offset: f32, register: u16) -> f32 {
        /// The paper's Γ and μ T in these units.
        const GAMMA: [f32; 2] = [7.9e-8, 1.1e-4];
        const MU: f32 = 0.01;
        let (moved, command) = self.pid.control(setpoint, offset, register);
        let change = moved - self.increment;
        self.error += change;
        self.rate = POLE * self.rate + (1.0 - POLE) * change;
        let [of_velocity, of_command] = &mut self.regressor;
        *of_velocity = POLE * *of_velocity - (1.0 - POLE) * self.increment;
        *of_command = POLE * *of_command + (1.0 - POLE) * self.acted;
        let output = MU * self.error + self.rate;
        let [a, b] = &mut self.estimates;
        *a = (*a + GAMMA[0] * *of_velocity * output).clamp(0.0, 0.1);
        *b = (*b + GAMMA[1] * *of_command * output).clamp(0.01, 1.0);
        let gains = &self.pid.gains;
        self.integral += gains.integral * self.error;
        self.acted = command
            + gains.proportional * self.error
            + gains.derivative * self.rate
            + self.integral;
        let acceleration = *b * self.acted - *a * self.velocity;
        self.increment = self.velocity + 0.5 * acceleration;
        self.velocity += acceleration;
        command
    }

    fn is_right(&self) -> bool {
        /// The paper's b, 257.7 rad/s² per command unit.
        const B: f32 = 0.410_1;
        (self.estimates[1] / B - 1.0).abs() < 0.02
    }
}
