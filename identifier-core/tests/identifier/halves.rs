//! The halves of an identifier that fits: an interrupt that records and a background that fits, with a
//! queue each way between them.

use crate::support::{Draw, Kind, Loop, Servo, amplitude_for, paper, shown};
use identifier_core::identifier::{
    Event, GaussNewtonFitted, GaussNewtonFitter, GaussNewtonFitterState, GaussNewtonIdentifier,
    GaussNewtonRecursion, Identify, Update,
};
use identifier_core::parameters::{ServoParameters, Unknowns};
use identifier_core::settings::FromSettings;

/// Blocks of a record.
const W: usize = 64;

type Recursion = GaussNewtonRecursion<f32, Unknowns<4>, 4, W>;
type FirstFit = GaussNewtonFitter<f32, Unknowns<4>, 4, W>;

fn servo(seed: u32) -> Servo {
    paper(ServoParameters::new(2.0, 250.0, 15.0, 20.0), 40.0, seed)
}

/// The servo in the motion from which it can be identified.
fn motion(seed: u32) -> Loop {
    let servo = servo(seed);
    Loop::new(Kind::Pid, &servo, amplitude_for(Kind::Pid, &servo, 0.2))
}

fn sample(motion: &mut Loop) -> (f32, f32) {
    let (increment, command) = motion.sample();
    (increment as f32, command as f32)
}

fn built<T: FromSettings>() -> T {
    servo(0).settings().build().expect("valid")
}

/// Error of b̂, relative to b.
fn off(found: &ServoParameters) -> f64 {
    (found.b / servo(0).parameters.b - 1.0).abs()
}

/// Both halves, with a hand-off after every sample.
struct Halves {
    recorder: Recursion,
    fitter: FirstFit,
    recording: <Recursion as Identify<f32>>::State,
    fitting: GaussNewtonFitterState<f32, W>,
}

impl Halves {
    fn new() -> Self {
        let (recorder, fitter): (Recursion, FirstFit) = (built(), built());
        Self {
            recording: recorder.start(),
            fitting: fitter.start(),
            recorder,
            fitter,
        }
    }

    fn estimates(&self) -> ServoParameters {
        shown(&self.recorder, &self.recording)
    }

    fn take_over(&mut self, fitted: &GaussNewtonFitted<f32>) {
        self.recorder.take_over(&mut self.recording, fitted);
    }

    fn learn(&mut self, (increment, command): (f32, f32)) -> Update<f32> {
        let seen = self.recorder.learn(&mut self.recording, increment, command);
        if let Some(block) = self.recorder.take_block(&mut self.recording) {
            self.fitter.take(&mut self.fitting, &block);
        }
        seen.expect("ordinary samples")
    }

    /// Until there is a result.
    fn find(&mut self, motion: &mut Loop) -> GaussNewtonFitted<f32> {
        let found = (0..4000).find_map(|_| {
            self.learn(sample(motion));
            self.fitter.work(&mut self.fitting, u32::MAX)
        });
        found.expect("a motion with enough information")
    }
}

/// Six seconds of both, with the motion joined twice.
fn compare(budget: u32) {
    let whole: GaussNewtonIdentifier<f32, Unknowns<4>, 4, W> = built();
    let mut state = whole.start();
    let mut halves = Halves::new();
    let mut motion = motion(3);
    let mut started = 0;
    for k in 0..6000 {
        if k == 300 || k == 4000 {
            whole.resume_moving(&mut state, 0.5);
            halves.recorder.resume_moving(&mut halves.recording, 0.5);
        }
        let (increment, command) = sample(&mut motion);
        let seen = whole.learn(&mut state, increment, command);
        assert_eq!(Ok(halves.learn((increment, command))), seen, "sample {k}");
        whole.work(&mut state, budget);
        if let Some(fitted) = halves.fitter.work(&mut halves.fitting, budget) {
            halves.take_over(&fitted);
        }
        assert_eq!(halves.estimates(), shown(&whole, &state));
        let (recorder, recording) = (&halves.recorder, &halves.recording);
        let at_bounds = recorder.at_bounds_in(&recorder.snapshot(recording));
        assert_eq!(at_bounds, whole.at_bounds_in(&whole.snapshot(&state)));
        let errors = recorder.report(recording).standard_errors;
        assert_eq!(errors, whole.report(&state).standard_errors);
        started += u32::from(seen.is_ok_and(|seen| seen.event == Event::Started));
    }
    assert!(started > 0);
    assert!(off(&shown(&whole, &state)) < 0.02);
}

#[test]
fn halves_without_a_backlog_equal_the_whole_identifier() {
    for budget in [u32::MAX, 20, 1] {
        compare(budget);
    }
}

/// Blocks are lost and recording begins anew at any time. A fitter then finds, to the bit, the result of one
/// that was started with the first block after the gap.
#[test]
fn no_first_fit_spans_a_gap() {
    let (recorder, fitter): (Recursion, FirstFit) = (built(), built());
    let (mut found, mut lost, mut joined, mut interrupted) = (0, 0, 0, 0);
    for seed in 0..40 {
        let mut draw = Draw::new(seed);
        let mut motion = motion(seed);
        let mut recording = recorder.start();
        let (mut fitting, mut started_anew) = (fitter.start(), fitter.start());
        let mut gap = false;
        // Blocks between gaps: fewer than a fit needs, and many more.
        let often = draw.between(5e-4, 3e-2);
        let budget = draw.one_of(&[1, 30, u32::MAX]);
        for _ in 0..20_000 {
            if draw.uniform(0.0, 1.0) < 0.1 * often {
                recorder.resume_moving(&mut recording, 0.0);
                (gap, joined) = (true, joined + 1);
            }
            let (increment, command) = sample(&mut motion);
            let seen = recorder.learn(&mut recording, increment, command);
            seen.expect("ordinary samples");
            if let Some(block) = recorder.take_block(&mut recording) {
                if draw.uniform(0.0, 1.0) < often {
                    (gap, lost) = (true, lost + 1);
                } else {
                    if std::mem::take(&mut gap) {
                        started_anew = fitter.start();
                        interrupted += 1;
                    }
                    fitter.take(&mut fitting, &block);
                    fitter.take(&mut started_anew, &block);
                }
            }
            let fitted = fitter.work(&mut fitting, budget);
            assert!(fitted == fitter.work(&mut started_anew, budget));
            found += u32::from(fitted.is_some());
        }
    }
    assert!(
        found > 100 && lost > 100 && joined > 100 && interrupted > 100,
        "{found} {lost} {joined} {interrupted}"
    );
}

/// A fit that is lost is repeated, one of a recording before a gap is not adopted, and a running recursion is not restarted.
#[test]
fn a_first_fit_is_adopted_once_and_only_of_the_present_recording() {
    let mut motion = motion(4);
    let mut halves = Halves::new();
    for _ in 0..3 {
        halves.find(&mut motion);
    }
    assert!(!halves.recorder.is_running(&halves.recording));
    let fitted = halves.find(&mut motion);
    let before = halves.estimates();

    let mut joined = halves.recording;
    halves.recorder.resume_moving(&mut joined, 0.0);
    halves.recorder.take_over(&mut joined, &fitted);
    let (increment, command) = sample(&mut motion);
    let seen = halves.recorder.learn(&mut joined, increment, command);
    assert_eq!(seen.map(|seen| seen.event), Ok(Event::None));
    assert_eq!(shown(&halves.recorder, &joined), before);

    // The same without the gap.
    halves.take_over(&fitted);
    assert_eq!(halves.learn((increment, command)).event, Event::Started);
    assert!(halves.recorder.is_running(&halves.recording));
    assert!(off(&halves.estimates()) < 0.05);
    halves.take_over(&fitted);
    assert_eq!(halves.learn(sample(&mut motion)).event, Event::None);
}

#[test]
fn the_interrupt_keeps_neither_record_nor_fit() {
    let interrupt = size_of::<<Recursion as Identify<f32>>::State>();
    let background = size_of::<GaussNewtonFitterState<f32, W>>();
    let recursion = GaussNewtonIdentifier::<f32, Unknowns<4>, 4, W>::RECURSION_BYTES;
    assert!(interrupt <= recursion + 200, "{interrupt}");
    assert!(background >= W * 12);
}
