//! Gains for an identified servo.

use identifier_core::control::FeedForwardSettings as FeedForward;
use identifier_core::parameters::{IdentifiedServo as Servo, ServoParameters};
use identifier_core::tuning::{Cap, PredictedResponse, Tuner as CoreTuner, TunerState};

use crate::identifier::Estimates;
use crate::object::{Content, Object, answered, check, content, fill, given, read, storage, write};
use crate::settings::Settings;
use crate::status::{self, Error};

/// Gains and their predicted performance, SI: `servo_id_tuning` in the header.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Tuning {
    /// Proportional gain.
    pub kp: f64,
    /// Derivative gain.
    pub kd: f64,
    /// Integral gain.
    pub ki: f64,
    /// Cut-off of the velocity estimate, rad/s.
    pub cutoff: f64,
    /// Time constant of the filter of the reference, s; zero for none.
    pub reference_filter: f64,
    /// Frequency of the notch filter of the command, rad/s; zero for none.
    pub notch: f64,
    /// The feed-forward.
    pub feed_forward: FeedForward,
    /// ω of the poles, rad/s.
    pub bandwidth: f64,
    /// The predicted response.
    pub predicted_response: PredictedResponse,
    /// The limit that keeps it from being faster: [`CAPS`].
    pub cap: i32,
    /// For eight bytes.
    pub unused: i32,
}

/// Caps by number.
pub const CAPS: &[(&str, i32)] = &[
    ("CAP_NONE", 0),
    ("CAP_DELAY", 1),
    ("CAP_ENCODER_NOISE", 2),
    ("CAP_COMMAND_LIMIT", 3),
    ("CAP_RESONANCE", 4),
    ("CAP_UNSEEN_RESONANCE", 5),
];

/// A tuner and its work.
#[derive(Debug, Clone, Copy)]
pub struct Working {
    tuner: CoreTuner,
    state: TunerState,
}

/// `servo_id_tuner` in the header.
pub type Tuner = Object<Working>;

impl Content for Working {
    const MARK: u32 = 0x5e1d_0021;
    const WORDS: usize = 352;
}

impl From<identifier_core::tuning::Tuning> for Tuning {
    fn from(found: identifier_core::tuning::Tuning) -> Self {
        Self {
            kp: found.kp,
            kd: found.kd,
            ki: found.ki,
            cutoff: found.cutoff,
            reference_filter: found.reference_filter,
            notch: found.notch,
            feed_forward: found.feed_forward.unwrap_or_default(),
            bandwidth: found.bandwidth,
            predicted_response: found.predicted_response,
            cap: match found.cap {
                None => 0,
                Some(Cap::Delay) => 1,
                Some(Cap::EncoderNoise) => 2,
                Some(Cap::CommandLimit) => 3,
                Some(Cap::Resonance) => 4,
                Some(Cap::UnseenResonance) => 5,
            },
            unused: 0,
        }
    }
}

/// # Safety
/// As the header says.
unsafe fn build(
    tuner: *mut Tuner,
    size: u32,
    settings: *const Settings,
    servo: *const Servo,
) -> Result<i32, Error> {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let object = storage(tuner, size)?;
        let given = given(settings)?;
        let servo = read(servo)?;
        let tuner =
            CoreTuner::new(&given.tuning(), &servo).map_err(|error| Error::tuning(&error))?;
        let state = tuner.start();
        fill(object, Working { tuner, state });
    }
    Ok(status::OK)
}

/// # Safety
/// As the header says.
unsafe fn work(tuner: *mut Tuner, slices: u32, tuning: *mut Tuning) -> Result<i32, Error> {
    check(tuning)?;
    // SAFETY: guaranteed by the caller.
    let own = unsafe { content(tuner) }?;
    for _ in 0..slices {
        if let Some(done) = own.tuner.work(&mut own.state) {
            let found = done.map_err(|refused| Error::tuning(&refused))?;
            // SAFETY: guaranteed by the caller; it was checked.
            unsafe { tuning.write(found.into()) };
            return Ok(status::OK);
        }
    }
    Ok(status::PENDING)
}

face! {
    /// The servo of estimates with standard errors, which are taken as independent.
    fn servo_id_servo_from_estimates(
        estimates: *const Estimates,
        delay: f64,
        unexplained: f64,
        servo: *mut Servo,
    ) {
        // SAFETY: the header's conditions.
        let estimates = unsafe { read(estimates) }?;
        if estimates.std_error.iter().any(|error| !error.is_finite()) {
            return Err(status::NO_STANDARD_ERRORS);
        }
        let [a, b, coulomb, load] = estimates.std_error;
        let deviations = [a, b, coulomb, 0.0, load];
        let [of_a, of_b, of_coulomb, of_load] = estimates.value;
        let mut found = Servo {
            parameters: ServoParameters::new(of_a, of_b, of_coulomb, of_load),
            delay,
            covariance: [[0.0; 5]; 5],
            unexplained,
        };
        for (place, (row, deviation)) in found.covariance.iter_mut().zip(deviations).enumerate() {
            for (beside, entry) in row.iter_mut().enumerate() {
                if beside == place {
                    *entry = deviation * deviation;
                }
            }
        }
        // SAFETY: the header's conditions.
        unsafe { write(servo, found) }?;
        Ok(status::OK)
    }

    /// Begins to look for gains.
    fn servo_id_tuner_init(
        tuner: *mut Tuner,
        size: u32,
        settings: *const Settings,
        servo: *const Servo,
        error: *mut Error,
    ) {
        // SAFETY: the header's conditions.
        unsafe { answered(error, build(tuner, size, settings, servo)) }
    }

    /// At most this number of slices of work.
    fn servo_id_tuner_work(
        tuner: *mut Tuner,
        slices: u32,
        tuning: *mut Tuning,
        error: *mut Error,
    ) {
        // SAFETY: the header's conditions.
        unsafe { answered(error, work(tuner, slices, tuning)) }
    }
}
