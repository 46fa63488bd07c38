//! Received and lost frames: each carries the number of its sample.

use super::frame::Frame;

/// Counts frames, and those that are missing between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telemetry {
    /// Samples from one frame to the next.
    every: u16,
    last: Option<Frame>,
    frames: u64,
    lost: u64,
}

impl Telemetry {
    /// Expects a frame every `samples` samples.
    #[must_use]
    pub fn every(samples: u16) -> Self {
        Self {
            every: samples.max(1),
            last: None,
            frames: 0,
            lost: 0,
        }
    }

    /// Samples from one frame to the next.
    #[must_use]
    pub fn samples_apart(&self) -> u16 {
        self.every
    }

    /// Frames received.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Frames lost.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// The next frame may be any: telemetry was requested again.
    pub fn resynchronise(&mut self) {
        self.last = None;
    }

    /// Takes in a frame; true if it is the first received of a motion.
    pub fn take(&mut self, frame: &Frame) -> bool {
        let every = u32::from(self.every);
        let sample = frame.sample();
        let before = self.last.replace(*frame);
        self.frames += 1;
        let continued = before.filter(|before| frame.continues(before));
        self.lost += u64::from(match (continued, before) {
            (Some(last), _) => ((sample - last.sample()) / every).saturating_sub(1),
            // A new motion sends one of its first samples.
            (None, Some(_)) => sample.saturating_sub(1) / every,
            (None, None) => 0,
        });
        continued.is_none()
    }
}

#[cfg(test)]
mod tests {
    use commissioning::Phase;
    use drive_link::{Estimates, Progress, Snapshot};

    use super::*;

    fn running(sample: u32) -> Frame {
        Frame::Running(Snapshot {
            sample,
            reference: 0.0,
            position: 0.0,
            command: 0.0,
            output_error: 0.0,
            estimates: Estimates::default(),
        })
    }

    fn commissioning(sample: u32) -> Frame {
        Frame::Commissioning(Progress {
            phase: Phase::Idle,
            sample,
            position: 0.0,
            command: None,
            recorded: 0,
            gain: None,
        })
    }

    #[test]
    fn a_thousand_frames_a_second_leave_room_on_a_serial_line() {
        const BITS_OF_A_BYTE: usize = 10;
        const BAUD: usize = 1_000_000;
        let Frame::Running(mut snapshot) = running(u32::MAX) else {
            panic!("it is one");
        };
        snapshot.estimates.servo.b = 257.7;
        let framed = drive_link::frame(&drive_link::Report::Snapshot(snapshot)).expect("it fits");
        assert!(1000 * BITS_OF_A_BYTE * framed.len() < 8 * BAUD / 10);
    }

    #[test]
    fn a_frame_that_is_missing_is_counted() {
        let mut telemetry = Telemetry::every(1);
        for sample in 500..600 {
            telemetry.take(&running(sample));
        }
        assert_eq!((telemetry.frames(), telemetry.lost()), (100, 0));
        assert!(!telemetry.take(&running(602)) && !telemetry.take(&running(603)));
        assert_eq!((telemetry.frames(), telemetry.lost()), (102, 2));
    }

    #[test]
    fn frames_may_be_many_samples_apart() {
        let mut telemetry = Telemetry::every(20);
        let begins = [7, 27, 87].map(|sample| telemetry.take(&running(sample)));
        assert_eq!(begins, [true, false, false]);
        assert_eq!(telemetry.lost(), 2);
    }

    #[test]
    fn the_beginning_of_a_motion_may_be_missing_too() {
        let mut telemetry = Telemetry::every(2);
        telemetry.take(&running(40));
        assert!(telemetry.take(&running(2)));
        assert_eq!(telemetry.lost(), 0);
        assert!(telemetry.take(&commissioning(7)));
        assert_eq!(telemetry.lost(), 3);
    }

    #[test]
    fn samples_before_a_resynchronisation_are_not_lost() {
        let mut telemetry = Telemetry::every(1);
        telemetry.take(&running(1_000));
        telemetry.resynchronise();
        telemetry.take(&running(9_000));
        assert_eq!(telemetry.lost(), 0);
    }
}
