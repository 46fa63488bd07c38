//! `same_bits.c` in Rust, on the core itself.

use std::fmt::Write;

use fixed::types::I16F16;
use identifier_core::commission::{
    CommissionInputs, CommissionSettings, Limits, Phase, SynchronousCommission,
};
use identifier_core::excitation::Prbs;
use identifier_core::fixed_point::{FixedGradientIdentifier, FixedServoLoop, Word};
use identifier_core::identifier::{
    DiagonalGradientIdentifier, GaussNewtonIdentifier, Identify, ServoLoop,
};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{Ab, AbCoulomb, AbCoulombLoad, ServoParameters};
use identifier_core::settings::BoxSettings;
use identifier_core::tuning::Goal;
use identifier_core::{ControllerSettings, Settings};

const SAMPLES: i32 = 12_000;
const TIME: f64 = 1e-3;
const RADIAN_COUNTS: f64 = 10_000.0 / core::f64::consts::TAU;

struct World {
    position: f64,
    velocity: f64,
    load: f64,
    noise: u32,
    setpoint: i32,
    commands: u64,
    statuses: u64,
}

fn sum(to: &mut u64, next: u64) {
    *to = (*to ^ next).wrapping_mul(1_099_511_628_211);
}

impl World {
    fn new() -> Self {
        Self {
            position: 0.0,
            velocity: 0.0,
            load: 20.0,
            noise: 1,
            setpoint: 0,
            commands: 0,
            statuses: 0,
        }
    }

    fn count(&self) -> i32 {
        (self.position * RADIAN_COUNTS + 65536.0) as i32 - 65536
    }

    fn begin(&mut self, sample: i32) {
        if sample % 60 == 0 {
            self.noise = self
                .noise
                .wrapping_mul(1_664_525)
                .wrapping_add(1_013_904_223);
            self.setpoint = (self.noise >> 22) as i32 - 512;
        }
    }

    fn advance(&mut self, command: f64, coulomb: f64) {
        let push = 257.7 * command - 2.0 * self.velocity + self.load;
        let free = self.velocity + TIME * push;
        let rub = TIME * coulomb;
        let velocity = if free > rub {
            free - rub
        } else if free < -rub {
            free + rub
        } else {
            0.0
        };
        self.position += 0.5 * TIME * (self.velocity + velocity);
        self.velocity = velocity;
    }

    fn take(&mut self, status: i32, command: f32) {
        sum(&mut self.commands, command.to_bits().into());
        sum(&mut self.statuses, (status as u32).into());
    }

    fn own_command(&self, now: i32) -> f32 {
        let error = (self.setpoint - now) as f32;
        let command = 0.0055_f32 * error - 0.19_f32 * self.velocity as f32;
        command.clamp(-4.0, 4.0)
    }

    fn line(&self, name: &str, found: ServoParameters) -> String {
        let values = [found.a, found.b, found.coulomb, found.load].map(f64::to_bits);
        let mut line = name.to_owned();
        for bits in values.into_iter().chain([self.commands, self.statuses]) {
            write!(line, " {bits:016x}").expect("a string takes it");
        }
        line + "\n"
    }
}

fn settings(coulomb: bool) -> Settings {
    let mut given = Settings {
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(TIME, 10_000.0)
    };
    given.identifier.plant_box = Some(BoxSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    given.identifier.bounds.coulomb = Some([0.0, 100.0]);
    let units = given.units().expect("units");
    let reference = Prbs::<f64>::new(&units, 0.3, 0.05, 9).expect("a reference");
    let gamma = if coulomb {
        given.automatic_gamma::<LowPass<f64>, AbCoulomb, 3>(&reference, 2000)
    } else {
        given.automatic_gamma::<LowPass<f64>, Ab, 2>(&reference, 2000)
    };
    given.identifier.gamma = Some(gamma.expect("gamma"));
    given
}

fn friction(coulomb: bool) -> f64 {
    if coulomb { 10.0 } else { 0.0 }
}

/// An identifier that observes; a command as it takes it.
fn listen<N, I>(name: &str, coulomb: bool, identifier: &I, taken: impl Fn(f32) -> N) -> String
where
    N: Copy,
    I: Identify<N>,
{
    let mut state = identifier.start();
    let mut at = World::new();
    let mut last = at.count();
    sum(&mut at.statuses, 0);
    for sample in 0..SAMPLES {
        at.begin(sample);
        let now = at.count();
        let command = at.own_command(now);
        at.advance(command.into(), friction(coulomb));
        let update = identifier.process(&mut state, now - last, taken(command));
        at.take(update.expect("a right sample").event as i32, command);
        identifier.work(&mut state, 50);
        last = now;
    }
    sum(&mut at.statuses, 0);
    at.line(name, identifier.estimates(&state))
}

fn close<I: Identify<f32>>(name: &str, coulomb: bool) -> String
where
    ServoLoop<f32, LowPass<f32>, I>: identifier_core::settings::FromSettings,
{
    let own: ServoLoop<f32, LowPass<f32>, I> = settings(coulomb).build().expect("a loop");
    let mut state = own.start(0);
    let mut at = World::new();
    sum(&mut at.statuses, 0);
    for sample in 0..SAMPLES {
        at.begin(sample);
        let step = own.process(&mut state, at.setpoint, 0.25, at.count());
        let step = step.expect("a right sample");
        let command = step.control.command;
        at.advance(command.into(), friction(coulomb));
        at.take(step.seen.event as i32, command);
        own.identifier().work(state.identification_mut(), 50);
    }
    sum(&mut at.statuses, 0);
    at.line(name, own.identifier().estimates(state.identification()))
}

macro_rules! close_fixed {
    ($name:literal, $coulomb:literal, $set:ty, $parameters:literal) => {{
        let own: FixedServoLoop<LowPass<Word>, $set, $parameters> =
            settings($coulomb).build().expect("a loop");
        let mut state = own.start(0);
        let mut at = World::new();
        sum(&mut at.statuses, 0);
        for sample in 0..SAMPLES {
            at.begin(sample);
            let offset = I16F16::from_num(0.25);
            let step = own.process(&mut state, at.setpoint, offset, at.count());
            let step = step.expect("a right sample");
            let command = own.identifier().command(step.control.command);
            at.advance(command, friction($coulomb));
            at.take(step.seen.event as i32, command as f32);
        }
        sum(&mut at.statuses, 0);
        at.line($name, own.identifier().estimates(state.identification()))
    }};
}

fn commission() -> String {
    let settings = CommissionSettings {
        sample_time: TIME,
        resolution: core::f64::consts::TAU / 10_000.0,
        limits: Limits {
            travel: [-0.3, 0.3],
            speed: 15.0,
            command: [-10.0, 10.0],
            duration: 1.0,
            one_way: false,
        },
        command_delay: 0.0,
        max_gain: None,
        goal: Goal::ResponseTime(0.03),
        max_sensitivity: 1.6,
        trial_step: None,
    };
    let mut own = SynchronousCommission::<f32>::new(&settings, None, None).expect("right limits");
    let mut at = World::new();
    at.load = 0.0;
    sum(&mut at.statuses, 0);
    let mut phase = Phase::Idle;
    while !phase.is_end() {
        let step = own.sample(&CommissionInputs {
            count: Some(at.count()),
            late: false,
            stop: None,
        });
        phase = step.phase;
        let command = step.command.unwrap_or(0.0);
        at.advance(command, friction(true));
        at.take(phase as i32, command as f32);
    }
    sum(&mut at.statuses, 0);
    assert_eq!(phase, Phase::Applied);
    let state = own.state().expect("it began");
    let servo = state.servo().expect("it was identified").parameters;
    let tuning = state.tuning().expect("it was tuned");
    let gains = ServoParameters {
        a: tuning.kp,
        b: tuning.kd,
        coulomb: tuning.ki,
        load: state
            .trial()
            .and_then(|trial| trial.rise_time)
            .expect("it was tried"),
    };
    at.line("commission", servo) + &at.line("commission_gains", gains)
}

/// All that the program prints.
pub(crate) fn lines() -> String {
    type Gradient = DiagonalGradientIdentifier<f32, LowPass<f32>, Ab, 2>;
    type GradientCoulomb = DiagonalGradientIdentifier<f32, LowPass<f32>, AbCoulomb, 3>;
    type GaussNewton = GaussNewtonIdentifier<f32, AbCoulombLoad, 4>;
    let gradient: Gradient = settings(false).build().expect("an identifier");
    let gradient_coulomb: GradientCoulomb = settings(true).build().expect("an identifier");
    let gauss_newton: GaussNewton = settings(true).build().expect("an identifier");
    let fixed: FixedGradientIdentifier<LowPass<Word>, Ab, 2> =
        settings(false).build().expect("an identifier");
    let fixed_coulomb: FixedGradientIdentifier<LowPass<Word>, AbCoulomb, 3> =
        settings(true).build().expect("an identifier");
    let scale = fixed.command(Word::from_bits(1));
    let word = |command: f32| Word::from_bits((f64::from(command) / scale) as i32);
    [
        listen("gradient", false, &gradient, |command| command),
        listen("gradient_coulomb", true, &gradient_coulomb, |command| {
            command
        }),
        listen("gauss_newton", true, &gauss_newton, |command| command),
        listen("fixed", false, &fixed, word),
        listen("fixed_coulomb", true, &fixed_coulomb, word),
        close::<Gradient>("gradient_loop", false),
        close::<GradientCoulomb>("gradient_coulomb_loop", true),
        close::<GaussNewton>("gauss_newton_loop", true),
        close_fixed!("fixed_loop", false, Ab, 2),
        close_fixed!("fixed_coulomb_loop", true, AbCoulomb, 3),
        commission(),
    ]
    .concat()
}
