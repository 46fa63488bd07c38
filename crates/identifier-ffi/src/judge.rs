//! The verdict in short: is an estimate known?

use crate::identifier::Estimates;
use crate::object::{read, status_of, write};
use crate::status;

/// `servo_id_verdict` in the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Verdict {
    /// One if every estimate is known.
    pub known: i32,
    /// Of a, b, Coulomb friction and load: [`STATES`].
    pub state: [i32; 4],
}

/// What is said of an estimate.
pub const STATES: &[(&str, i32)] = &[("KNOWN", 0), ("UNCERTAIN", 1), ("IS_AT_BOUND", 2)];

const KNOWN: i32 = 0;
const UNCERTAIN: i32 = 1;
const IS_AT_BOUND: i32 = 2;

/// Standard error up to which b is known, a part of it.
const MAX_GAIN_ERROR: f64 = 0.015;
/// The same for a, Coulomb friction and load.
const MAX_ERROR: f64 = 0.05;
/// Or up to this part of what it acts beside.
const MAX_FORCE_SHARE: f64 = 0.005;
/// The same for a.
const MAX_DAMPING_SHARE: f64 = 0.01;
/// An estimate nearer to zero than this part of what it acts beside is at no bound.
const ZERO_SHARE: f64 = 1e-3;

/// The state of an estimate with a size that its standard error may have beside what it acts beside.
fn judge(
    value: f64,
    error: f64,
    at_bound: bool,
    share: f64,
    beside: f64,
    beside_error: f64,
) -> i32 {
    let size = value.abs();
    let limit = (share * size).max(beside_error * beside);
    if at_bound && size > ZERO_SHARE * beside {
        IS_AT_BOUND
    } else if error <= limit {
        KNOWN
    } else {
        // NaN too.
        UNCERTAIN
    }
}

impl Verdict {
    fn of(estimates: &Estimates, command: f64, speed: f64) -> Self {
        let Estimates {
            value: [a, b, coulomb, load],
            std_error: [error_a, error_b, error_coulomb, error_load],
            at_bound,
        } = *estimates;
        let [bound_a, bound_b, bound_coulomb, bound_load] = at_bound.map(|at_bound| at_bound != 0);
        let force = (b * command).abs();
        let damping = force / speed;
        let state = [
            judge(a, error_a, bound_a, MAX_ERROR, damping, MAX_DAMPING_SHARE),
            judge(b, error_b, bound_b, MAX_GAIN_ERROR, 0.0, 0.0),
            judge(
                coulomb,
                error_coulomb,
                bound_coulomb,
                MAX_ERROR,
                force,
                MAX_FORCE_SHARE,
            ),
            judge(
                load,
                error_load,
                bound_load,
                MAX_ERROR,
                force,
                MAX_FORCE_SHARE,
            ),
        ];
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
        let estimates = match unsafe { read(estimates) } {
            Ok(estimates) => estimates,
            Err(status) => return status,
        };
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if !positive(command) || !positive(speed) {
            return status::OUT_OF_RANGE;
        }
        if estimates.std_error.iter().all(|error| error.is_nan()) {
            return status::NO_STANDARD_ERRORS;
        }
        let found = Verdict::of(&estimates, command, speed);
        // SAFETY: the header's conditions.
        status_of(unsafe { write(verdict, found) }.map(|()| status::OK))
    }
}
