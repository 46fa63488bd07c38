//! The verdict in short: is an estimate known?

use core::array;

use identifier_core::parameters::{Parameter, Tolerance};

use crate::identifier::Estimates;
use crate::object::{read, write};
use crate::status;

/// `servo_id_verdict` in the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Verdict {
    /// One if every estimate is within tolerance.
    pub known: i32,
    /// For a, b, Coulomb friction and load: [`STATES`].
    pub state: [i32; 4],
}

/// The verdicts on an estimate.
pub const STATES: &[(&str, i32)] = &[("KNOWN", 0), ("UNCERTAIN", 1), ("IS_AT_BOUND", 2)];

const KNOWN: i32 = 0;
const UNCERTAIN: i32 = 1;
const IS_AT_BOUND: i32 = 2;

impl Verdict {
    fn of(estimates: &Estimates, command: f64, speed: f64) -> Self {
        let [_, b, _, _] = estimates.value;
        let force = (b * command).abs();
        let beside = [force / speed, 0.0, force, force];
        let state = array::from_fn(|place| {
            let (value, beside) = (estimates.value[place], beside[place]);
            let limit = Tolerance::STD_ERROR.limit(Parameter::ALL[place].into(), value, beside);
            let is_at_bound = estimates.at_bound[place] != 0;
            if is_at_bound && value.abs() > Tolerance::ZERO_SHARE * beside {
                IS_AT_BOUND
            } else if estimates.std_error[place] <= limit {
                KNOWN
            } else {
                // NaN too.
                UNCERTAIN
            }
        });
        Self {
            known: state.iter().all(|&state| state == KNOWN).into(),
            state,
        }
    }
}

face! {
    /// Judges estimates by their standard errors, for a usual command and speed.
    fn servo_id_judge(
        estimates: *const Estimates,
        command: f64,
        speed: f64,
        verdict: *mut Verdict,
    ) {
        // SAFETY: the header's conditions.
        let estimates = unsafe { read(estimates) }?;
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if !positive(command) || !positive(speed) {
            return Err(status::OUT_OF_RANGE);
        }
        if estimates.std_error.iter().all(|error| error.is_nan()) {
            return Err(status::NO_STANDARD_ERRORS);
        }
        let found = Verdict::of(&estimates, command, speed);
        // SAFETY: the header's conditions.
        unsafe { write(verdict, found) }?;
        Ok(status::OK)
    }
}
