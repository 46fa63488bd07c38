use identifier_core::error::OutOfRange;

/// Why a commissioning is rejected before anything moves.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommissionError {
    /// A setting of [`Limits`](super::Limits) or [`CommissionSettings`](super::CommissionSettings) is out of its range.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// The travel is less than evidence needs with this encoder.
    #[error(
        "a travel of {travel:.4} rad is too small to identify the servo with this encoder: allow {needed:.4} rad"
    )]
    TravelTooSmall {
        /// The given value, rad.
        travel: f64,
        /// The least that would do, rad.
        needed: f64,
    },
    /// The speed is less than evidence needs with this encoder and sample time.
    #[error(
        "a speed of {speed:.4} rad/s is too low to identify the servo with this encoder: allow {needed:.4} rad/s"
    )]
    SpeedTooSmall {
        /// The given value, rad/s.
        speed: f64,
        /// The least that would do, rad/s.
        needed: f64,
    },
    /// With the largest b, all of the command changes the speed too much within a sample. The speed would exceed it
    /// before the encoder shows it.
    #[error(
        "at a sample time of {sample_time} s a servo with the largest b changes its speed too much per sample: sample \
         every {most:.6} s or less, or allow a command of {command:.4} or less"
    )]
    TooStrong {
        /// The given value, s.
        sample_time: f64,
        /// The longest sample time that would do, s.
        most: f64,
        /// The largest command that would do in its place, command units.
        command: f64,
    },
    /// The requested response is faster than sampling and delay permit for any servo.
    #[error(
        "a bandwidth of {bandwidth:.1} rad/s is more than sampling and delay permit: ask for {most:.1} rad/s or less"
    )]
    TooFast {
        /// The requested bandwidth, rad/s.
        bandwidth: f64,
        /// The largest that would do, rad/s.
        most: f64,
    },
}
