//! Calls of all kinds, right and wrong: each has a status, and nothing is touched that was not passed.

use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr::null_mut;

use identifier_core::identifier::GradientIdentifier;
use identifier_core::measurement::LowPass;
use identifier_core::parameters::Unknowns;
use identifier_ffi::commission::*;
use identifier_ffi::identifier::{Estimates, fixed, gauss_newton, gradient};
use identifier_ffi::judge::{Verdict, servo_id_judge};
use identifier_ffi::object::{Object, Storage};
use identifier_ffi::servo_loop;
use identifier_ffi::settings::*;
use identifier_ffi::status::{self, Error};
use identifier_ffi::tuner::*;

use fixed::{
    servo_id_fixed_estimates, servo_id_fixed_init, servo_id_fixed_resume, servo_id_fixed_sample,
};
use gauss_newton::{
    servo_id_gauss_newton_estimates, servo_id_gauss_newton_init, servo_id_gauss_newton_resume,
    servo_id_gauss_newton_sample, servo_id_gauss_newton_work,
};
use gradient::{
    Gradient, servo_id_gradient_estimates, servo_id_gradient_init,
    servo_id_gradient_init_from_constants, servo_id_gradient_machine_estimates,
    servo_id_gradient_resume, servo_id_gradient_sample,
};
use servo_loop::fixed_point::{servo_id_fixed_loop_init, servo_id_fixed_loop_process};
use servo_loop::gradient::{
    servo_id_gradient_loop_control, servo_id_gradient_loop_init, servo_id_gradient_loop_learn,
    servo_id_gradient_loop_process,
};

fn size<T: Storage>() -> u32 {
    8 * T::WORDS as u32
}

/// No memory of a kind: null, or an address that is no multiple of its alignment.
fn nowhere<T>(misaligned: bool) -> *mut T {
    if misaligned {
        0x1001 as *mut T
    } else {
        null_mut()
    }
}

const NO_ESTIMATES: Estimates = Estimates {
    value: [0.0; 4],
    std_error: [f64::NAN; 4],
    at_bound: [0; 4],
};

const NO_ERROR: Error = Error {
    status: 0,
    allowed: 0,
    value: 0.0,
    low: 0.0,
    high: 0.0,
    parameter: std::ptr::null(),
};

/// Settings that every estimator accepts.
fn settings() -> Settings {
    let range = |low, high| Range { low, high };
    Settings {
        sample_time: 1e-3,
        counts_per_revolution: 1e4,
        kp: 9.0,
        kd: 0.19,
        ki: 4.0,
        limit: range(-10.0, 10.0),
        gamma: Each {
            a: 23.0,
            b: 1700.0,
            coulomb: 100.0,
            load: 0.0,
        },
        bounds: Each {
            coulomb: range(0.0, 100.0),
            ..Each::default()
        },
        servo_range: ServoRange {
            a: range(0.0, 50.0),
            b: range(110.0, 1000.0),
        },
        travel: range(-0.3, 0.3),
        speed: 15.0,
        duration: 1.0,
        ..Settings::default()
    }
}

/// The constants of a gradient identifier.
fn constants() -> Vec<u32> {
    let mut given = identifier_core::Settings::new(1e-3, 1e4);
    given.identifier.correction = Some([9.0, 0.19, 4.0]);
    given.identifier.initial.b = Some(200.0);
    given.identifier.gamma = Some(identifier_core::settings::diagonal([
        23.0, 1700.0, 0.0, 0.0,
    ]));
    let built: GradientIdentifier<f32, LowPass<f32>, Unknowns<2>, 2> =
        given.build().expect("right settings");
    let mut constants = Vec::new();
    identifier_core::constants::words(&(built, ()), |word| constants.push(word));
    constants
}

#[test]
fn a_refusal_names_the_field_and_what_is_allowed() {
    let refused = |change: &dyn Fn(&mut Settings)| {
        let mut own = settings();
        change(&mut own);
        let mut object = Gradient::empty();
        let mut error = NO_ERROR;
        // SAFETY: the objects are of their types.
        let status = unsafe {
            servo_id_gradient_init(
                &raw mut object,
                size::<Gradient>(),
                &raw const own,
                &raw mut error,
            )
        };
        // SAFETY: as above.
        let after = unsafe { servo_id_gradient_sample(&raw mut object, 0, 0.0) };
        assert_eq!(after, status::NOT_INITIALISED, "a refused object is none");
        assert_eq!(status, error.status);
        // SAFETY: a field is a text of the library.
        let field = unsafe { CStr::from_ptr(error.parameter) };
        (error, field.to_str().expect("text"))
    };
    let (error, field) = refused(&|own| own.sample_time = 1e9);
    assert_eq!(
        (error.status, field, error.allowed),
        (status::OUT_OF_RANGE, "sample_time", 7)
    );
    assert!(
        error.value.to_bits() == 1e9_f64.to_bits() && error.low < error.high && error.high < 1e9
    );
    let (error, field) = refused(&|own| own.mu = 1000.0);
    assert_eq!((error.status, field), (status::CERTIFICATE, "mu"));
    assert!(error.value >= error.high, "{error:?}");
    let (error, field) = refused(&|own| own.gamma.b = -1.0);
    assert_eq!((error.status, field), (status::GAMMA, "gamma.b"));
    let (error, field) = refused(&|own| own.initial.b = -1.0);
    assert_eq!((error.status, field), (status::OUT_OF_RANGE, "initial.b"));
    for (change, missing) in [
        (
            (|own| own.sample_time = 0.0) as fn(&mut Settings),
            "sample_time",
        ),
        (
            |own| own.counts_per_revolution = 0.0,
            "counts_per_revolution",
        ),
        (|own| own.ranges.error = 1.0, "ranges.velocity"),
        (|own| own.servo_range.a = Range::default(), "servo_range.a"),
    ] {
        let (error, field) = refused(&change);
        assert_eq!((error.status, field), (status::NOT_GIVEN, missing));
    }
}

#[test]
fn a_parameter_is_known_to_be_zero_only_where_that_is_stated() {
    let estimates = |known: i32| {
        let mut own = settings();
        own.known.coulomb = known;
        let mut object = Object::<gauss_newton::Inner>::empty();
        let at = &raw mut object;
        let size = size::<Object<gauss_newton::Inner>>();
        let mut found = NO_ESTIMATES;
        // SAFETY: the objects are of their types.
        unsafe {
            assert_eq!(
                servo_id_gauss_newton_init(at, size, &raw const own, null_mut()),
                status::OK
            );
            let mut position = 0.0_f64;
            let mut velocity = 0.0_f64;
            let mut last = 0;
            for sample in 0..4000 {
                let command: f64 = if sample / 120 % 2 == 0 { 0.5 } else { -0.5 };
                let count = (position * 1e4 / std::f64::consts::TAU).floor() as i32;
                servo_id_gauss_newton_sample(at, count - last, command as f32);
                servo_id_gauss_newton_work(at, 8);
                last = count;
                let pushed = velocity + 1e-3 * (200.0 * command - 2.0 * velocity);
                let rubbed = 1e-3 * 10.0;
                let next = pushed.signum() * (pushed.abs() - rubbed).max(0.0);
                position += 0.5e-3 * (velocity + next);
                velocity = next;
            }
            servo_id_gauss_newton_estimates(at, &raw mut found);
        }
        found.value[2]
    };
    assert!((estimates(0) - 10.0).abs() < 2.0, "{}", estimates(0));
    assert_eq!(estimates(1).to_bits(), 0.0_f64.to_bits());
}

/// A number from a sequence, with what is special among them.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }

    fn below(&mut self, limit: u32) -> u32 {
        self.next() % limit
    }

    fn whole(&mut self) -> i32 {
        match self.below(6) {
            0 => i32::MIN,
            1 => i32::MAX,
            2 => self.next() as i32,
            _ => self.below(200) as i32 - 100,
        }
    }

    fn real(&mut self) -> f64 {
        match self.below(10) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            3 => 0.0,
            4 => f64::from_bits(u64::from(self.next()) << 32 | u64::from(self.next())),
            5 => 1e300,
            6 => 1e-300,
            _ => f64::from(self.whole()) * 0.01,
        }
    }

    fn single(&mut self) -> f32 {
        self.real() as f32
    }

    /// One of ten is a wrong address.
    fn address<T>(&mut self, right: *mut T) -> *mut T {
        match self.below(20) {
            0 => nowhere(false),
            1 if align_of::<T>() > 1 => nowhere(true),
            _ => right,
        }
    }

    fn size<T: Storage>(&mut self) -> u32 {
        match self.below(8) {
            0 => 0,
            1 => self.below(size::<T>()),
            2 => u32::MAX,
            _ => size::<T>(),
        }
    }
}

/// An object and the settings it is built from, with guards around it.
#[repr(C)]
struct Guarded<T> {
    before: [u64; 8],
    object: Object<T>,
    after: [u64; 8],
}

const GUARD: [u64; 8] = [0x5555_aaaa_3333_cccc; 8];

impl<T> Guarded<T> {
    fn new() -> Box<Self> {
        Box::new(Self {
            before: GUARD,
            object: Object::empty(),
            after: GUARD,
        })
    }

    fn holds(&self) -> bool {
        self.before == GUARD && self.after == GUARD
    }
}

fn number_of_calls() -> u64 {
    let asked = std::env::var("SERVO_ID_CALLS")
        .ok()
        .and_then(|text| text.parse().ok());
    asked.unwrap_or(if cfg!(miri) { 3000 } else { 200_000 })
}

#[test]
fn whatever_is_called_has_a_status() {
    let mut numbers = Numbers(1);
    let n = &mut numbers;
    let (mut good, mut given) = (settings(), settings());
    let mut gradient = Guarded::<gradient::Inner>::new();
    let mut gauss_newton = Guarded::<gauss_newton::Inner>::new();
    let mut fixed = Guarded::<fixed::Inner>::new();
    let mut servo_loop = Guarded::<servo_loop::gradient::Inner>::new();
    let mut fixed_loop = Guarded::<servo_loop::fixed_point::Inner>::new();
    let mut tuner = Guarded::<Working>::new();
    let mut commission = Guarded::<Interrupt>::new();
    let mut solver = Guarded::<Background>::new();
    let mut decision = Decision::empty();
    let mut step = CommissionStep {
        command: 0.0,
        is_enabled: 0,
        phase: 0,
        has_record: 0,
        record: Record::empty(),
    };
    let constants = constants();
    let (mut refused, mut taken) = (0_u64, 0_u64);
    for call in 0..number_of_calls() {
        if call % 1000 == 0 {
            given = settings();
        }
        let own = if n.below(2) == 0 {
            &raw mut good
        } else {
            &raw mut given
        };
        let none = null_mut();
        // SAFETY: an address is null, misaligned, or of an object of its type.
        let answered = unsafe {
            match n.below(20) {
                0..3 => {
                    let at = n.address(&raw mut gradient.object);
                    match n.below(40) {
                        0 => servo_id_gradient_init(at, n.size::<Gradient>(), n.address(own), none),
                        1 => estimate(n, |to| servo_id_gradient_estimates(at, to)),
                        2 => servo_id_gradient_resume(at, n.whole()),
                        3 => {
                            let mut constants = constants.clone();
                            if n.below(3) == 0 {
                                let place = n.below(constants.len() as u32) as usize;
                                constants[place] ^= 1 << n.below(32);
                            }
                            let all = constants.len() as u32;
                            let words = if n.below(4) == 0 { n.below(all) } else { all };
                            let from = n.address(constants.as_mut_ptr());
                            servo_id_gradient_init_from_constants(
                                at,
                                n.size::<Gradient>(),
                                from,
                                words,
                            )
                        }
                        4 => {
                            let mut machine = [f32::NAN; 4];
                            let to = n.address(machine.as_mut_ptr());
                            let answered = servo_id_gradient_machine_estimates(at, to);
                            assert!(answered < 0 || machine.iter().all(|value| value.is_finite()));
                            answered
                        }
                        _ => servo_id_gradient_sample(at, n.whole(), n.single()),
                    }
                }
                3..6 => {
                    let at = n.address(&raw mut gauss_newton.object);
                    match n.below(40) {
                        0 => {
                            let size = n.size::<Object<gauss_newton::Inner>>();
                            refusable(n, |error| servo_id_gauss_newton_init(at, size, own, error))
                        }
                        1 => estimate(n, |to| servo_id_gauss_newton_estimates(at, to)),
                        2 => servo_id_gauss_newton_resume(at, n.whole()),
                        3 => servo_id_gauss_newton_work(at, n.below(100)),
                        _ => servo_id_gauss_newton_sample(at, n.whole(), n.single()),
                    }
                }
                6..9 => {
                    let at = n.address(&raw mut fixed.object);
                    match n.below(40) {
                        0 => {
                            let size = n.size::<Object<fixed::Inner>>();
                            refusable(n, |error| servo_id_fixed_init(at, size, own, error))
                        }
                        1 => estimate(n, |to| servo_id_fixed_estimates(at, to)),
                        2 => servo_id_fixed_resume(at, n.whole()),
                        _ => servo_id_fixed_sample(at, n.whole(), n.whole()),
                    }
                }
                9 | 10 => {
                    let mut command = 7.0;
                    let to = n.address(&raw mut command);
                    let at = n.address(&raw mut servo_loop.object);
                    match n.below(30) {
                        0 => {
                            let size = n.size::<Object<servo_loop::gradient::Inner>>();
                            servo_id_gradient_loop_init(at, size, n.address(own), n.whole(), none)
                        }
                        1..5 => servo_id_gradient_loop_learn(at, n.single()),
                        way => {
                            let (remaining_change, offset, now) =
                                (n.whole(), n.single(), n.whole());
                            let call = if way < 9 {
                                servo_id_gradient_loop_control
                            } else {
                                servo_id_gradient_loop_process
                            };
                            let answered = call(at, remaining_change, offset, now, to);
                            let right = std::ptr::eq(to, &raw const command);
                            assert!(answered >= 0 || !right || command.to_bits() == 0);
                            answered
                        }
                    }
                }
                11 => {
                    let mut command = 7;
                    let to = n.address(&raw mut command);
                    let at = n.address(&raw mut fixed_loop.object);
                    match n.below(30) {
                        0 => {
                            let size = n.size::<Object<servo_loop::fixed_point::Inner>>();
                            servo_id_fixed_loop_init(at, size, n.address(own), n.whole(), none)
                        }
                        _ => servo_id_fixed_loop_process(at, n.whole(), n.whole(), n.whole(), to),
                    }
                }
                12 | 13 => {
                    // SAFETY: the settings are numbers alone, of which the last are whole.
                    let places = size_of::<Settings>() / 8 - 3;
                    let numbers = (&raw mut given).cast::<f64>();
                    numbers.add(n.below(places as u32) as usize).write(n.real());
                    let (amplitude, hold) = (n.real(), n.real());
                    let samples = n.below(200);
                    let at = n.address(&raw mut given);
                    refusable(n, |error| {
                        servo_id_settings_choose_gamma(at, amplitude, hold, samples, 1, error)
                    })
                }
                14 => {
                    let mut estimates = Estimates {
                        value: [n.real(), n.real(), n.real(), n.real()],
                        std_error: [n.real(), n.real(), n.real(), n.real()],
                        at_bound: [n.whole(), 0, 1, 2],
                    };
                    let mut verdict = MaybeUninit::<Verdict>::uninit();
                    let (from, to) = (
                        n.address(&raw mut estimates),
                        n.address(verdict.as_mut_ptr()),
                    );
                    servo_id_judge(from, n.real(), n.real(), to)
                }
                15 | 16 => {
                    let at = n.address(&raw mut commission.object);
                    match n.below(40) {
                        0 => {
                            let size = n.size::<Commission>();
                            let (now, held) = (n.whole(), n.single());
                            refusable(n, |error| {
                                servo_id_commission_init(at, size, own, now, held, error)
                            })
                        }
                        1 => {
                            let mut result = MaybeUninit::<CommissionResult>::uninit();
                            servo_id_commission_get_result(at, n.address(result.as_mut_ptr()))
                        }
                        2 => {
                            let mut slices = 0;
                            servo_id_commission_slices(at, n.address(&raw mut slices))
                        }
                        3..8 => servo_id_commission_accept(at, n.address(&raw mut decision)),
                        _ => {
                            let (now, conditions) = (n.whole(), n.below(5) as i32);
                            let stop = if n.below(200) == 0 { n.whole() } else { 0 };
                            let to = n.address(&raw mut step);
                            servo_id_commission_sample(at, now, conditions, stop, to)
                        }
                    }
                }
                17 | 18 => {
                    let at = n.address(&raw mut solver.object);
                    match n.below(40) {
                        0 => {
                            let size = n.size::<Solver>();
                            refusable(n, |error| servo_id_solver_init(at, size, own, error))
                        }
                        1..20 => servo_id_solver_take(at, n.address(&raw mut step.record)),
                        _ => {
                            let mut slices = n.below(100);
                            let to = n.address(&raw mut decision);
                            servo_id_solver_work(at, n.address(&raw mut slices), to)
                        }
                    }
                }
                _ => {
                    let at = n.address(&raw mut tuner.object);
                    let mut servo = Servo {
                        value: [2.0, 257.7, n.real(), n.real()],
                        delay: n.real(),
                        covariance: [[0.0; 5]; 5],
                        unexplained: n.real(),
                    };
                    let mut tuning = MaybeUninit::<Tuning>::uninit();
                    if n.below(4) == 0 {
                        let (size, from) = (n.size::<Tuner>(), n.address(&raw mut servo));
                        refusable(n, |error| servo_id_tuner_init(at, size, own, from, error))
                    } else {
                        servo_id_tuner_work(at, n.below(50), n.address(tuning.as_mut_ptr()), none)
                    }
                }
            }
        };
        assert!(
            status::ROWS.iter().any(|row| row.number == answered),
            "status {answered}"
        );
        if answered < 0 {
            refused += 1;
        } else {
            taken += 1;
        }
    }
    let some = number_of_calls() / 20;
    assert!(refused > some && taken > some, "{refused}, {taken}");
    assert!(gradient.holds() && gauss_newton.holds() && fixed.holds());
    assert!(servo_loop.holds() && fixed_loop.holds() && tuner.holds());
    assert!(commission.holds() && solver.holds());
}

/// A step with the command of a motor that is driven.
fn driven() -> CommissionStep {
    CommissionStep {
        command: 7.02,
        is_enabled: 1,
        phase: 0,
        has_record: 1,
        record: Record::empty(),
    }
}

/// A sample of a commissioning: its status, its command and whether the stage is enabled.
fn sampled(commission: &mut Commission, count: i32, stop: i32) -> (i32, f32, i32) {
    let mut step = driven();
    // SAFETY: the objects are of their types.
    let answered = unsafe { servo_id_commission_sample(commission, count, 0, stop, &raw mut step) };
    (answered, step.command, step.is_enabled)
}

#[test]
fn a_stop_by_any_number_disables_the_stage_for_good() {
    for stop in [255, 256, -1, i32::MIN, i32::MAX, 99, 170] {
        let mut commission = Commission::empty();
        // SAFETY: the objects are of their types.
        let built = unsafe {
            let size = size::<Commission>();
            servo_id_commission_init(&raw mut commission, size, &settings(), 0, 7.02, null_mut())
        };
        assert_eq!(built, status::OK);
        let (answered, command, enabled) = sampled(&mut commission, 0, 0);
        assert_eq!((answered, enabled), (status::OK, 1));
        assert!((command - 7.02).abs() < 0.01, "{command}");
        let is_known = stop == 170;
        let refused = if is_known {
            status::OK
        } else {
            status::NO_SUCH_NUMBER
        };
        assert_eq!(
            sampled(&mut commission, 0, stop),
            (refused, 0.0, 0),
            "{stop}"
        );
        for count in 0..50 {
            let after = sampled(&mut commission, count, 0);
            assert_eq!(after, (status::OK, 0.0, 0), "{stop}");
        }
        let mut result = MaybeUninit::uninit();
        // SAFETY: the objects are of their types; a result that is answered is written.
        let result = unsafe {
            let answered =
                servo_id_commission_get_result(&raw const commission, result.as_mut_ptr());
            assert_eq!(answered, status::OK);
            result.assume_init()
        };
        assert_eq!((result.phase, result.reason), (10, 170), "{stop}");
    }
}

#[test]
fn a_sample_that_is_refused_drives_no_motor() {
    let refused = sampled(&mut Commission::empty(), 0, 0);
    assert_eq!(refused, (status::NOT_INITIALISED, 0.0, 0));
    let mut step = driven();
    for misaligned in [false, true] {
        // SAFETY: null and misaligned addresses are refused; the step is of its type.
        let answered =
            unsafe { servo_id_commission_sample(nowhere(misaligned), 0, 0, 0, &raw mut step) };
        assert!(answered < 0);
        let written = (step.command, step.is_enabled, step.has_record);
        assert_eq!(written, (0.0, 0, 0));
        step = driven();
    }
}

/// A loop that controls, processes a sample, and is then to learn.
macro_rules! learnt_after_process {
    ($servo_loop:ident, $init:ident $control:ident $process:ident $learn:ident, $zero:literal) => {{
        use servo_loop::$servo_loop::*;
        let mut own = Object::<Inner>::empty();
        let at = &raw mut own;
        let mut command = $zero;
        // SAFETY: the objects are of their types.
        unsafe {
            let size = size::<Object<Inner>>();
            assert_eq!($init(at, size, &settings(), 0, null_mut()), status::OK);
            assert_eq!($control(at, 3, $zero, 0, &raw mut command), status::OK);
            assert!($process(at, 3, $zero, 1, &raw mut command) >= 0);
            assert_eq!($learn(at, command), status::NO_SAMPLE);
            // Nor from one before a sample that may be refused.
            assert_eq!($control(at, 3, $zero, 1, &raw mut command), status::OK);
            $process(at, i32::MAX, $zero, 1, &raw mut command);
            assert_eq!($learn(at, command), status::NO_SAMPLE);
        }
    }};
}

#[test]
fn a_loop_learns_from_the_last_sample_or_from_none() {
    learnt_after_process!(gradient, servo_id_gradient_loop_init servo_id_gradient_loop_control
        servo_id_gradient_loop_process servo_id_gradient_loop_learn, 0.0);
    learnt_after_process!(fixed_point, servo_id_fixed_loop_init servo_id_fixed_loop_control
        servo_id_fixed_loop_process servo_id_fixed_loop_learn, 0);
}

/// Estimates, at a right or a wrong address; finite wherever they are answered.
fn estimate(numbers: &mut Numbers, call: impl FnOnce(*mut Estimates) -> i32) -> i32 {
    let mut found = NO_ESTIMATES;
    let answered = call(numbers.address(&raw mut found));
    assert!(
        answered < 0 || found.value.iter().all(|value| value.is_finite()),
        "{found:?}"
    );
    answered
}

/// A call that writes an error, at a right or a wrong address.
fn refusable(numbers: &mut Numbers, call: impl FnOnce(*mut Error) -> i32) -> i32 {
    let mut error = NO_ERROR;
    let to = numbers.address(&raw mut error);
    let answered = call(to);
    assert!(answered >= 0 || !std::ptr::eq(to, &raw const error) || error.status == answered);
    answered
}
