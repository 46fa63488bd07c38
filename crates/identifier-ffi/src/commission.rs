//! Commissioning: a half for the interrupt, a half for the background, and what goes between them.

use core::ffi::c_char;

use commissioning::{
    CommissionError, CommissionInputs, CommissionIsr, CommissionSolver, CommissionState,
    CommissionStep as Step, Decision as CoreDecision, HoldingGains, Phase, RecordEvent,
};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::parameters::IdentifiedServo as Servo;
use identifier_core::reason::Reason;

use crate::object::{
    Content, Object, answered, check, content, fill, given, read, shared, storage, write,
};
use crate::settings::Settings;
use crate::status::{self, Error, of_loop};
use crate::tuner::Tuning;

/// The interrupt's half.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Interrupt {
    isr: CommissionIsr<f32>,
    state: CommissionState<f32>,
}

/// The background's half.
#[derive(Debug, Clone, Copy)]
pub struct Background {
    solver: CommissionSolver<f32>,
}

/// `servo_id_commission` in the header.
pub type Commission = Object<Interrupt>;

/// `servo_id_solver` in the header.
pub type Solver = Object<Background>;

/// `servo_id_record` in the header, from the interrupt to the background.
pub type Record = Object<RecordEvent<f32>>;

/// `servo_id_decision` in the header, from the background to the interrupt.
pub type Decision = Object<CoreDecision<f32>>;

impl Content for Interrupt {
    const MARK: u32 = 0x5e1d_0031;
    const WORDS: usize = 660;
}

impl Content for Background {
    const MARK: u32 = 0x5e1d_0032;
    const WORDS: usize = 1900;
}

impl Content for RecordEvent<f32> {
    const MARK: u32 = 0x5e1d_0033;
    const WORDS: usize = 6;
}

impl Content for CoreDecision<f32> {
    const MARK: u32 = 0x5e1d_0034;
    const WORDS: usize = 80;
}

/// A sample of the interrupt's half: `servo_id_commission_step` in the header.
#[derive(Debug)]
#[repr(C)]
pub struct CommissionStep {
    /// The command that acts until the next sample; zero where the stage is to be disabled.
    pub command: f32,
    /// One if the stage is to be enabled.
    pub is_enabled: i32,
    /// The number of its phase.
    pub phase: i32,
    /// One if there is a record for the background.
    pub has_record: i32,
    /// The record.
    pub record: Record,
}

/// Its results so far: `servo_id_commission_result` in the header.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct CommissionResult {
    /// The number of its phase.
    pub phase: i32,
    /// The number of the reason why it ended without new gains, zero for none.
    pub reason: i32,
    /// One if there is a servo.
    pub has_servo: i32,
    /// One if there are gains.
    pub has_tuning: i32,
    /// The servo as identified so far.
    pub servo: Servo,
    /// The gains, on trial or applied.
    pub tuning: Tuning,
    /// Rise time that the trial measured, s; NaN for none.
    pub measured_rise_time: f64,
    /// Overshoot that it measured, a part of the step; NaN for none.
    pub measured_overshoot: f64,
}

/// Conditions of a sample, bits, and no reason to stop.
pub const CONDITIONS: &[(&str, i32)] = &[
    ("IN_ORDER", 0),
    ("NO_COUNT", 1),
    ("LATE", 2),
    ("NO_STOP", 0),
];

/// The step of a sample that was not taken: the stage is to be disabled.
const REFUSED: Step<f32> = Step {
    command: None,
    phase: Phase::Idle,
    finding: None,
};

impl Interrupt {
    /// A sample with its status. A stop by a number that is no reason is a stop all the same.
    fn sample(&mut self, count: i32, conditions: i32, stop: i32) -> (Step<f32>, i32) {
        let reason = u8::try_from(stop).ok().and_then(Reason::from_number);
        let status = match (stop, reason) {
            (0, _) | (_, Some(_)) => status::OK,
            (_, None) => status::NO_SUCH_NUMBER,
        };
        let inputs = CommissionInputs {
            count: (conditions & 1 == 0).then_some(count),
            late: conditions & 2 != 0,
            stop: (stop != 0).then(|| reason.unwrap_or(Reason::Stopped)),
        };
        (self.isr.process(&mut self.state, &inputs), status)
    }
}

impl Error {
    fn commission(error: &CommissionError) -> Self {
        let (parameter, value, allowed) = match *error {
            CommissionError::Range(error) => {
                let field = |name| match name {
                    "command" => "limit",
                    name => of_loop(name),
                };
                return Self::about(status::OUT_OF_RANGE, &error.renamed(field));
            }
            CommissionError::TravelTooSmall { travel, needed } => {
                ("travel", travel, Allowed::AtLeast(needed))
            }
            CommissionError::SpeedTooSmall { speed, needed } => {
                ("speed", speed, Allowed::AtLeast(needed))
            }
            CommissionError::TooStrong {
                sample_time, most, ..
            } => ("sample_time", sample_time, Allowed::AtMost(most)),
            CommissionError::TooFast { bandwidth, most } => {
                return Self::too_fast(bandwidth, most);
            }
        };
        Self::about(
            status::OUT_OF_RANGE,
            &OutOfRange::new(parameter, value, allowed),
        )
    }
}

/// # Safety
/// As the header says.
unsafe fn build(
    commission: *mut Commission,
    size: u32,
    settings: *const Settings,
    count: i32,
    held: f32,
) -> Result<i32, Error> {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let object = storage(commission, size)?;
        let given = given(settings)?;
        let before = HoldingGains::of(&given.settings());
        if !held.is_finite() {
            return Err(Error::of(status::COMMAND_NOT_FINITE));
        }
        let settings = given.commission()?;
        let isr = CommissionIsr::new(&settings, before.as_ref())
            .and_then(|isr| settings.check_held(f64::from(held)).map(|()| isr))
            .map_err(|error| Error::commission(&error))?;
        let state = isr.start(count, before.map(|_| held));
        fill(object, Interrupt { isr, state });
    }
    Ok(status::OK)
}

/// # Safety
/// As the header says.
unsafe fn build_solver(
    solver: *mut Solver,
    size: u32,
    settings: *const Settings,
) -> Result<i32, Error> {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let object = storage(solver, size)?;
        let solver = CommissionSolver::new(&given(settings)?.commission()?)
            .map_err(|error| Error::commission(&error))?;
        fill(object, Background { solver });
    }
    Ok(status::OK)
}

/// The size of a record or a decision, which the library itself initialises.
const fn size<T: Content>() -> u32 {
    8 * T::WORDS as u32
}

face! {
    /// Begins where the servo stands, released, or held by the PID of the settings with a command.
    fn servo_id_commission_init(
        commission: *mut Commission,
        size: u32,
        settings: *const Settings,
        count: i32,
        held: f32,
        error: *mut Error,
    ) {
        // SAFETY: the header's conditions.
        unsafe { answered(error, build(commission, size, settings, count, held)) }
    }

    /// The slices of work that the background does in each sample.
    fn servo_id_commission_slices(commission: *const Commission, slices: *mut u32) {
        // SAFETY: the header's conditions.
        let own = unsafe { shared(commission) }?;
        // SAFETY: the header's conditions.
        unsafe { write(slices, own.isr.slices()) }?;
        Ok(status::OK)
    }

    /// A sample.
    fn servo_id_commission_sample(
        commission: *mut Commission,
        count: i32,
        conditions: i32,
        stop: i32,
        step: *mut CommissionStep,
    ) {
        check(step)?;
        // SAFETY: the header's conditions.
        let (done, status) = match unsafe { content(commission) } {
            Ok(own) => own.sample(count, conditions, stop),
            Err(refused) => (REFUSED, refused),
        };
        // SAFETY: the header's conditions; it was checked.
        unsafe {
            (&raw mut (*step).command).write(done.command.unwrap_or(0.0));
            (&raw mut (*step).is_enabled).write(done.command.is_some().into());
            (&raw mut (*step).phase).write(done.phase as i32);
            (&raw mut (*step).has_record).write(done.finding.is_some().into());
            if let Some(finding) = done.finding {
                fill(&raw mut (*step).record, finding);
            }
        }
        Ok(status)
    }

    /// Takes a decision of the background.
    fn servo_id_commission_accept(commission: *mut Commission, decision: *const Decision) {
        // SAFETY: the header's conditions.
        unsafe {
            let own = content(commission)?;
            own.isr.accept(&mut own.state, shared(decision)?);
        }
        Ok(status::OK)
    }

    /// The results so far.
    fn servo_id_commission_get_result(
        commission: *const Commission,
        result: *mut CommissionResult,
    ) {
        // SAFETY: the header's conditions.
        let own = unsafe { shared(commission) }?;
        let state = &own.state;
        let trial = state.trial();
        let found = CommissionResult {
            phase: state.phase() as i32,
            reason: state.reason().map_or(0, |reason| reason.number().into()),
            has_servo: state.servo().is_some().into(),
            has_tuning: state.tuning().is_some().into(),
            servo: state.servo().copied().unwrap_or_default(),
            tuning: state.tuning().copied().map(Into::into).unwrap_or_default(),
            measured_rise_time: trial.and_then(|trial| trial.rise_time).unwrap_or(f64::NAN),
            measured_overshoot: trial.map_or(f64::NAN, |trial| trial.overshoot),
        };
        // SAFETY: the header's conditions.
        unsafe { write(result, found) }?;
        Ok(status::OK)
    }

    /// The background's half.
    fn servo_id_solver_init(
        solver: *mut Solver,
        size: u32,
        settings: *const Settings,
        error: *mut Error,
    ) {
        // SAFETY: the header's conditions.
        unsafe { answered(error, build_solver(solver, size, settings)) }
    }

    /// Takes a record of the interrupt.
    fn servo_id_solver_take(solver: *mut Solver, record: *const Record) {
        // SAFETY: the header's conditions.
        unsafe {
            content(solver)?.solver.take(shared(record)?);
        }
        Ok(status::OK)
    }

    /// At most this number of slices of work, up to a decision.
    fn servo_id_solver_work(solver: *mut Solver, slices: *mut u32, decision: *mut Decision) {
        // SAFETY: the header's conditions.
        unsafe {
            let own = content(solver)?;
            let mut left = read(slices)?;
            let to = storage(decision, size::<CoreDecision<f32>>())?;
            while left > 0 {
                left -= 1;
                if let Some(decided) = own.solver.work() {
                    fill(to, decided);
                    slices.write(left);
                    return Ok(status::DECIDED);
                }
            }
            slices.write(0);
        }
        Ok(status::PENDING)
    }

    /// The cause of a reason, without a zero at its end.
    fn servo_id_reason_cause(reason: i32, text: *mut *const c_char, length: *mut u32) {
        let found = u8::try_from(reason).ok().and_then(Reason::from_number);
        let cause = found.map_or("", Reason::cause);
        // SAFETY: the header's conditions.
        unsafe {
            write(text, cause.as_ptr().cast())?;
            write(length, cause.len() as u32)?;
        }
        found.map(|_| status::OK).ok_or(status::NO_SUCH_NUMBER)
    }
}
