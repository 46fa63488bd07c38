//! Calls of all kinds, right and wrong: each has a status, and nothing is touched that was not passed.

use std::collections::BTreeMap;
use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr::null_mut;

use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::identifier::GradientIdentifier;
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{
    IdentifiedServo as Servo, PerParameter as Each, ServoParameters, Unknowns,
};
use identifier_core::settings::ParameterRangeSettings as ServoRange;
use identifier_ffi::commission::{CommissionResult, CommissionStep};
use identifier_ffi::identifier::Estimates;
use identifier_ffi::judge::Verdict;
use identifier_ffi::settings::Settings;
use identifier_ffi::status::{self, Error};
use identifier_ffi::tuner::{Tuning, servo_id_tuner_init};
use identifier_ffi::{Argument, objects, prototypes};

/// Settings that every estimator accepts.
fn settings() -> Settings {
    Settings {
        sample_time: 1e-3,
        counts_per_revolution: 1e4,
        kp: 9.0,
        kd: 0.19,
        ki: 4.0,
        limit: [-10.0, 10.0],
        gamma: Each {
            a: 23.0,
            b: 1700.0,
            coulomb: 100.0,
            load: 0.0,
        },
        bounds: Each {
            coulomb: [0.0, 100.0],
            ..Each::default()
        },
        servo_range: ServoRange {
            a: [0.0, 50.0],
            b: [110.0, 1000.0],
        },
        command: 10.0,
        step: 0.1,
        travel: [-0.3, 0.3],
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
    given.identifier.gamma = Some(Each::new(23.0, 1700.0, 0.0, 0.0));
    let built: GradientIdentifier<f32, LowPass<f32>, Unknowns<2>, 2> =
        given.build().expect("right settings");
    let mut constants = Vec::new();
    identifier_core::constants::words(&(built, ()), |word| constants.push(word));
    constants
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
}

/// Bytes of a type that an address is of; of numbers some room, for arrays.
fn bytes(of: &str) -> usize {
    match of {
        "Settings" => size_of::<Settings>(),
        "Error" => size_of::<Error>(),
        "Estimates" => size_of::<Estimates>(),
        "Verdict" => size_of::<Verdict>(),
        "Servo" => size_of::<Servo>(),
        "Tuning" => size_of::<Tuning>(),
        "CommissionStep" => size_of::<CommissionStep>(),
        "CommissionResult" => size_of::<CommissionResult>(),
        "i32" | "u32" | "f32" | "f64" => 4 * size_of::<f64>(),
        text if text.starts_with('*') => size_of::<*const u8>(),
        object => {
            let mut named = objects().into_iter();
            let (_, words) = named
                .find(|(name, _)| name.replace('_', "").eq_ignore_ascii_case(object))
                .expect("an object of the header");
            8 * words
        }
    }
}

/// Guards before and behind a memory.
const GUARD: [u64; 8] = [0x5555_aaaa_3333_cccc; 8];

/// The memory that is passed, and of the arguments of a call those that the next ones or its answer depend on.
struct Caller {
    numbers: Numbers,
    constants: Vec<u32>,
    passed: Vec<u32>,
    right: Box<Settings>,
    memory: BTreeMap<&'static str, Vec<u64>>,
    /// Bytes of the first object.
    size: usize,
    /// Where the call writes, by the names of its arguments.
    to: BTreeMap<&'static str, *mut u64>,
}

impl Caller {
    fn memory<T>(&mut self, of: &'static str) -> *mut T {
        let whole = self.memory.entry(of).or_insert_with(|| {
            [
                GUARD.to_vec(),
                vec![0; bytes(of).div_ceil(8)],
                GUARD.to_vec(),
            ]
            .concat()
        });
        whole[GUARD.len()..].as_mut_ptr().cast()
    }

    /// One of ten is a wrong address: null, or no multiple of any alignment.
    fn address(&mut self, name: &'static str, right: *mut u64) -> Argument {
        let address = match self.numbers.below(20) {
            0 => null_mut(),
            1 => std::ptr::without_provenance_mut(0x1001),
            _ => {
                self.to.insert(name, right);
                right
            }
        };
        let address = address.cast();
        Argument { address }
    }

    fn argument(&mut self, name: &'static str, of: &'static str) -> Argument {
        let n = &mut self.numbers;
        match (name, of) {
            ("size", _) => {
                let u32 = match n.below(8) {
                    0 => 0,
                    1 => n.below(self.size as u32),
                    2 => u32::MAX,
                    _ => self.size as u32,
                };
                Argument { u32 }
            }
            // Any of these ends a commissioning.
            ("stop" | "conditions" | "count", _) => Argument {
                i32: if n.below(500) == 0 { n.whole() } else { 0 },
            },
            ("words", _) => {
                let all = self.constants.len() as u32;
                let u32 = if n.below(4) == 0 { n.below(all) } else { all };
                Argument { u32 }
            }
            ("constants", _) => {
                self.passed = self.constants.clone();
                if n.below(3) == 0 {
                    let place = n.below(self.passed.len() as u32) as usize;
                    self.passed[place] ^= 1 << n.below(32);
                }
                let right = self.passed.as_mut_ptr().cast();
                self.address(name, right)
            }
            (_, "i32") => Argument { i32: n.whole() },
            (_, "u32") => Argument { u32: n.below(100) },
            (_, "f32") => Argument {
                f32: n.real() as f32,
            },
            (_, "f64") => Argument { f64: n.real() },
            (_, of) => {
                let address = of.trim_start_matches(['*', ' ']).split_once(' ');
                let (access, to) = address.expect("an address");
                let right = self.filled(to, access == "const");
                if self.size == 0 {
                    self.size = bytes(to);
                }
                self.address(name, right)
            }
        }
    }

    /// The memory of a type, with something to read where it is read, and something to write over.
    fn filled(&mut self, of: &'static str, is_read: bool) -> *mut u64 {
        // SAFETY: each is of its type, of which all bits are numbers.
        unsafe {
            match of {
                // Right ones, half of the time.
                "Settings" if is_read && self.numbers.below(2) == 0 => {
                    *self.right = settings();
                    (&raw mut *self.right).cast()
                }
                // As a sample has written it.
                "Record" => {
                    let step = self.memory::<CommissionStep>("CommissionStep");
                    (&raw mut (*step).record).cast()
                }
                "CommissionStep" => {
                    let own = self.memory::<CommissionStep>(of);
                    (&raw mut (*own).command).write(7.0);
                    (&raw mut (*own).is_enabled).write(1);
                    own.cast()
                }
                "u32" | "i32" | "f32" | "f64" => {
                    let own = self.memory::<u64>(of);
                    own.write(self.numbers.below(100).into());
                    own
                }
                "Estimates" | "Servo" => {
                    let own = self.memory::<f64>(of);
                    own.write(2.0);
                    own.add(1).write(257.7);
                    for place in 2..bytes(of) / 8 {
                        let is_any = self.numbers.below(4) == 0;
                        let value = if is_any { self.numbers.real() } else { 0.0 };
                        own.add(place).write(value);
                    }
                    own.cast()
                }
                _ => self.memory(of),
            }
        }
    }

    /// Nothing of a refused call drives a motor, and what is answered is a number.
    fn check(&self, name: &str, answered: i32) {
        let refused = answered < 0;
        for (&argument, to) in &self.to {
            // SAFETY: each is of its type, and all bits are numbers.
            unsafe {
                match argument {
                    "error" if refused => assert_eq!((*to.cast::<Error>()).status, answered),
                    "command" if refused => assert_eq!(*to.cast::<u32>(), 0, "{name}"),
                    "step" if refused => {
                        let step = &*to.cast::<CommissionStep>();
                        let written = (step.command, step.is_enabled, step.has_record);
                        assert_eq!(written, (0.0, 0, 0), "{name}: {answered}");
                    }
                    "estimates"
                        if !refused && !name.contains("from") && !name.contains("judge") =>
                    {
                        let found = &*to.cast::<Estimates>();
                        assert!(found.value.iter().all(|value| value.is_finite()), "{name}");
                    }
                    "machine" if !refused && !name.contains("fixed") => {
                        let found = &*to.cast::<[f32; 4]>();
                        assert!(found.iter().all(|value| value.is_finite()), "{name}");
                    }
                    _ => {}
                }
            }
        }
    }
}

/// How much rarer than a sample a function is called: an object lives for some samples.
fn rarity(name: &str) -> u32 {
    const SAMPLES: [&str; 7] = [
        "sample", "process", "control", "learn", "work", "take", "accept",
    ];
    if name.contains("_init_from") {
        200
    } else if name.contains("_init") {
        50
    } else if SAMPLES.iter().any(|end| name.ends_with(end)) {
        1
    } else {
        10
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
    let mut own = Caller {
        numbers: Numbers(1),
        constants: constants(),
        passed: Vec::new(),
        right: Box::default(),
        memory: BTreeMap::new(),
        size: 0,
        to: BTreeMap::new(),
    };
    let places = size_of::<Settings>() / 8 - 3;
    let functions: Vec<_> = prototypes().collect();
    let mut answers = vec![[0_u64; 2]; functions.len()];
    for call in 0..number_of_calls() {
        let given = own.memory::<Settings>("Settings");
        let (place, value) = (own.numbers.below(places as u32), own.numbers.real());
        // SAFETY: settings are numbers alone, of which the last are whole.
        unsafe {
            if call % 1000 == 0 {
                given.write(settings());
            } else if call % 50 == 0 {
                given.cast::<f64>().add(place as usize).write(value);
            }
        }
        let number = loop {
            let number = own.numbers.below(functions.len() as u32) as usize;
            if own.numbers.below(rarity(functions[number].name)) == 0 {
                break number;
            }
        };
        let function = functions[number];
        own.size = 0;
        own.to.clear();
        // SAFETY: an address is null, misaligned, or of an object of its type.
        let answered = unsafe { (function.call)(&mut |name, of| own.argument(name, of)) };
        assert!(
            status::ROWS.iter().any(|row| row.number == answered),
            "{}: status {answered}",
            function.name
        );
        own.check(function.name, answered);
        answers[number][usize::from(answered < 0)] += 1;
    }
    for (of, memory) in &own.memory {
        let is_whole = memory.starts_with(&GUARD) && memory.ends_with(&GUARD);
        assert!(is_whole, "{of}");
    }
    for (function, [taken, refused]) in functions.iter().zip(&answers) {
        println!("{}: {taken} taken, {refused} refused", function.name);
    }
    let [taken, refused] = [0, 1].map(|place| answers.iter().map(|own| own[place]).sum::<u64>());
    let some = number_of_calls() / 20;
    assert!(taken > some && refused > some, "{taken}, {refused}");
}

/// The number of a range's kind and its ends as the core's.
fn allowed(refused: &Error) -> Allowed {
    match refused.allowed {
        2 => Allowed::Above(refused.low),
        3 => Allowed::AtLeast(refused.low),
        6 => Allowed::Between(refused.low, refused.high),
        7 => Allowed::Within(refused.low, refused.high),
        8 => Allowed::PositiveUpTo(refused.high),
        other => panic!("{other}"),
    }
}

#[test]
fn a_tuning_is_refused_with_what_the_core_says() {
    let servo = Servo::known(ServoParameters::new(0.5, 200.0, 0.0, 0.0), 1e-3);
    for sentence in include_str!("../../../identifier-core/tests/tuning/refusals.txt").lines() {
        let (name, rest) = sentence.split_once(" = ").expect("a value");
        let mut given = settings();
        let field = match name {
            "bandwidth" => &mut given.loop_bandwidth,
            "command_delay" => &mut given.command_delay,
            "cutoff" => &mut given.cutoff,
            "max_noise" => &mut given.max_noise,
            "max_sensitivity" => &mut given.max_sensitivity,
            "resonance" => &mut given.resonance,
            "response_time" => &mut given.response_time,
            "sample_time" => &mut given.sample_time,
            other => panic!("{other}"),
        };
        *field = rest
            .split(' ')
            .next()
            .expect("a word")
            .parse()
            .expect("a number");
        let (mut words, mut error) = ([0_u64; 352], MaybeUninit::<Error>::uninit());
        let (tuner, size) = (words.as_mut_ptr().cast(), size_of_val(&words) as u32);
        // SAFETY: as the header says.
        let (status, refused) = unsafe {
            let status = servo_id_tuner_init(
                tuner,
                size,
                &raw const given,
                &raw const servo,
                error.as_mut_ptr(),
            );
            (status, error.assume_init())
        };
        assert_eq!(status, status::OUT_OF_RANGE, "{sentence}");
        // SAFETY: a refusal of a setting names a field.
        let field = unsafe { CStr::from_ptr(refused.parameter) };
        let field = field.to_str().expect("text").trim_start_matches("loop_");
        let told = OutOfRange::new(field, refused.value, allowed(&refused));
        assert_eq!(told.to_string(), sentence);
    }
}
