//! `same_bits.c` in Rust, on the core itself.

use std::fmt::Write;

use commissioning::{CommissionInputs, CommissionSettings, Limits, Phase, SynchronousCommission};
use fixed::types::I16F16;
use identifier_core::Settings;
use identifier_core::constants::{Configuration, words};
use identifier_core::control::Shaped;
use identifier_core::excitation::Prbs;
use identifier_core::fixed_point::{FixedLoop, Word};
use identifier_core::identifier::{
    ExpectedMotion, GaussNewtonIdentifier, GradientIdentifier, Identify, MachineEstimates,
    PreparedServo, ServoLoop,
};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{
    IdentifiedServo, Parameter, PerParameter, ServoParameters, Unknowns,
};
use identifier_core::settings::{ControllerSettings, FromSettings, ParameterRangeSettings};
use identifier_core::tuning::Goal;

const SAMPLES: i32 = 12_000;
const TIME: f64 = 1e-3;
const RADIAN_COUNTS: f64 = 10_000.0 / core::f64::consts::TAU;

/// A number's bits.
trait Bits {
    fn bits(self) -> u32;
}

impl Bits for f32 {
    fn bits(self) -> u32 {
        self.to_bits()
    }
}

impl Bits for Word {
    fn bits(self) -> u32 {
        self.to_bits() as u32
    }
}

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

    /// The end of a run of an object with estimates.
    fn end<N: Bits + Copy>(&mut self, machine: &PerParameter<N>) {
        sum(&mut self.statuses, 0);
        sum(&mut self.statuses, 0);
        for parameter in Parameter::ALL {
            sum(&mut self.statuses, machine.get(parameter).bits().into());
        }
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
    given.identifier.parameter_range = Some(ParameterRangeSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    given.identifier.bounds.coulomb = Some([0.0, 100.0]);
    let units = given.units().expect("units");
    let reference = Prbs::<f64>::new(&units, 0.3, 0.05, 9).expect("a reference");
    let gamma = if coulomb {
        given.automatic_gamma::<LowPass<f64>, Unknowns<3>, 3>(&reference, 2000)
    } else {
        given.automatic_gamma::<LowPass<f64>, Unknowns<2>, 2>(&reference, 2000)
    };
    given.identifier.gamma = Some(gamma.expect("gamma"));
    given
}

fn friction(coulomb: bool) -> f64 {
    if coulomb { 10.0 } else { 0.0 }
}

/// An identifier that observes; a command as it takes it.
fn listen<N, I>(
    name: &str,
    coulomb: bool,
    identifier: &I,
    mut state: I::State,
    taken: impl Fn(f32) -> N,
) -> String
where
    N: Copy + Bits,
    I: MachineEstimates<N>,
{
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
    at.end(&identifier.machine_estimates(&state));
    at.line(name, identifier.estimates(&state).expect("estimates"))
}

fn close<I: MachineEstimates<f32>>(
    name: &str,
    coulomb: bool,
    own: &Closed<I>,
    start: I::State,
) -> String {
    let mut state = own.start(0);
    *state.identification_mut() = start;
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
    at.end(&own.identifier().machine_estimates(state.identification()));
    at.line(
        name,
        own.identifier()
            .estimates(state.identification())
            .expect("estimates"),
    )
}

macro_rules! close_fixed {
    ($name:expr, $coulomb:literal, $own:expr) => {{
        let own = $own;
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
            own.identifier().work(state.identification_mut(), 50);
        }
        at.end(&own.identifier().machine_estimates(state.identification()));
        at.line(
            $name,
            own.identifier()
                .estimates(state.identification())
                .expect("estimates"),
        )
    }};
}

fn commission() -> String {
    let settings = CommissionSettings {
        goal: Goal::Bandwidth(70.0),
        feed_forward: true,
        ..CommissionSettings::new(
            TIME,
            core::f64::consts::TAU / 10_000.0,
            Limits::new([-0.3, 0.3], 15.0, [-10.0, 10.0]),
        )
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
    assert!(tuning.feed_forward.is_some());
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

type Gradient = GradientIdentifier<f32, LowPass<f32>, Unknowns<2>, 2>;
type GradientCoulomb = GradientIdentifier<f32, LowPass<f32>, Unknowns<3>, 3>;
type GaussNewton = GaussNewtonIdentifier<f32, Unknowns<4>, 4>;
type Fixed = GradientIdentifier<Word, LowPass<Word>, Unknowns<2>, 2>;
type FixedCoulomb = GradientIdentifier<Word, LowPass<Word>, Unknowns<3>, 3>;
type Closed<I> = ServoLoop<f32, LowPass<f32>, I, Shaped<f32>>;
type FixedShapedLoop = FixedLoop<2, Shaped<Word>>;
type FixedCoulombLoop = FixedLoop<3, Shaped<Word>>;

/// The loop or identifier of a type.
fn built<T: FromSettings>(coulomb: bool) -> T {
    settings(coulomb).build().expect("right settings")
}

/// A servo that Gauss–Newton begins with, not quite the true one.
fn known() -> PreparedServo<f32> {
    let servo = IdentifiedServo {
        parameters: ServoParameters {
            a: 2.5,
            b: 250.0,
            coulomb: 9.0,
            load: 18.0,
        },
        delay: 0.0,
        covariance: core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                if i == j {
                    [0.1, 20.0, 0.5, 0.0, 1.0][i]
                } else {
                    0.0
                }
            })
        }),
        unexplained: 2e-4,
    };
    let motion = ExpectedMotion {
        bandwidth: 30.0,
        command: 1.0,
    };
    built::<GaussNewton>(true)
        .recorder()
        .prepare(&servo, &motion)
}

/// `constants.h`: an array for each object.
pub(crate) fn constants() -> String {
    fn array<T: Configuration>(name: &str, configuration: &T) -> String {
        let mut text = format!("static const uint32_t {name}_words[] = {{");
        words(configuration, |word| {
            write!(text, "{word}u,").expect("a string takes it")
        });
        text + "};\n"
    }
    [
        "#include <stdint.h>\n".to_owned(),
        array("gradient", &(built::<Gradient>(false), ())),
        array("gradient_coulomb", &(built::<GradientCoulomb>(true), ())),
        array("gauss_newton", &(built::<GaussNewton>(true), known())),
        array("fixed", &(built::<Fixed>(false), ())),
        array("fixed_coulomb", &(built::<FixedCoulomb>(true), ())),
        array("gradient_loop", &(built::<Closed<Gradient>>(false), ())),
        array(
            "gradient_coulomb_loop",
            &(built::<Closed<GradientCoulomb>>(true), ()),
        ),
        array(
            "gauss_newton_loop",
            &(built::<Closed<GaussNewton>>(true), known()),
        ),
        array("fixed_loop", &(built::<FixedShapedLoop>(false), ())),
        array("fixed_coulomb_loop", &(built::<FixedCoulombLoop>(true), ())),
    ]
    .concat()
}

/// All that the program prints.
pub(crate) fn lines() -> String {
    let scale = built::<Fixed>(false).command(Word::from_bits(1));
    let word = |command: f32| Word::from_bits((f64::from(command) / scale) as i32);
    let number = |command: f32| command;
    let of = |of_constants: bool| {
        let name = |own: &str| own.to_owned() + if of_constants { "_of_constants" } else { "" };
        let begun = |own: &GaussNewton| {
            if of_constants {
                own.start_from(&known())
            } else {
                own.start()
            }
        };
        macro_rules! listens {
            ($name:literal, $coulomb:literal, $identifier:ty, $taken:expr) => {{
                let own: $identifier = built($coulomb);
                listen(&name($name), $coulomb, &own, own.start(), $taken)
            }};
        }
        macro_rules! closes {
            ($name:literal, $coulomb:literal, $identifier:ty) => {{
                let own: Closed<$identifier> = built($coulomb);
                close(&name($name), $coulomb, &own, own.identifier().start())
            }};
        }
        let gauss_newton: GaussNewton = built(true);
        let gauss_newton_loop: Closed<GaussNewton> = built(true);
        let in_loop = begun(gauss_newton_loop.identifier());
        [
            listens!("gradient", false, Gradient, number),
            listens!("gradient_coulomb", true, GradientCoulomb, number),
            listen(
                &name("gauss_newton"),
                true,
                &gauss_newton,
                begun(&gauss_newton),
                number,
            ),
            listens!("fixed", false, Fixed, word),
            listens!("fixed_coulomb", true, FixedCoulomb, word),
            closes!("gradient_loop", false, Gradient),
            closes!("gradient_coulomb_loop", true, GradientCoulomb),
            close(
                &name("gauss_newton_loop"),
                true,
                &gauss_newton_loop,
                in_loop,
            ),
            close_fixed!(&name("fixed_loop"), false, built::<FixedShapedLoop>(false)),
            close_fixed!(
                &name("fixed_coulomb_loop"),
                true,
                built::<FixedCoulombLoop>(true)
            ),
        ]
        .concat()
    };
    [of(false), of(true), commission()].concat()
}
