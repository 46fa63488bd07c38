use super::following::Following;
use super::line::LineState;
use super::plan::Motion;
use super::window::{ResponseWindows, Window};
use super::{FrictionBalance, LineSums, Lines, ResponsePlan};
use crate::commission::RoughModel;
use crate::commission::holding::Holding;
use crate::commission::noise::has_missed;
use identifier_core::number::Number;

/// Frequency-response motions under way: reference, oscillators and sums. Counts and samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::commission) struct ResponseMotion<N> {
    motion: Motion<N>,
    lines: [LineState<N>; Lines::MAX],
    count: u8,
    stage: Stage,
    /// Samples of the stage.
    passed: u32,
    /// Velocity of the reference, and where it goes.
    velocity: N,
    heading: N,
    following: Following,
    /// Samples since the encoder last moved.
    still: u32,
    /// The command that balances the change of its load with the angle.
    compensation: N,
    /// The part of the injection that acts, and whether it has the opposite sign.
    fade: N,
    inverted: bool,
    window: Window<N>,
    /// True if its balance is to be handed over after the lines.
    is_balanced: bool,
    /// Motions in which the servo is still to be learnt, and those that were measured.
    learning: u8,
    measured: u8,
    /// True if the governor has changed a command of the window, and motions that were repeated for it.
    is_cut: bool,
    repeated: u8,
    /// Whether the injection was inverted in the motion whose sums are handed over, and the next line of it. None if it
    /// only adapts the amplitudes.
    handed: Option<bool>,
    line: u8,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Stage {
    Approach,
    Turn,
    Settling,
    Window,
    #[default]
    Stopping,
}

/// The state of the motions after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::commission) enum ResponseProgress<N> {
    Going,
    /// The sums of a line, of a motion that is over.
    Line(LineSums<N>),
    /// After them the motion beneath the lines.
    Balance(FrictionBalance<N>),
    /// The servo is about to come to standstill and all sums were passed on, or a load moves it.
    Over,
}

impl<N: Number> ResponseMotion<N> {
    /// Speeds of the first half of the motions and of the others, as parts of the plan's. Two speeds put the
    /// harmonics of the quantisation on different lines.
    const SPEEDS: [f64; 2] = [1.0, 0.8];

    /// Motions of a round that are repeated at most because their commands were changed.
    const REPEATED: u8 = 2;

    /// The part of the largest error that a loop of less bandwidth may have once the servo is learnt.
    const HELD: f64 = 0.5;

    /// Takes in a plan.
    pub(in crate::commission) fn plan(&mut self, plan: &ResponsePlan<N>) {
        self.motion = plan.motion;
        self.count = plan.count;
        let lines = self.lines.iter_mut().zip(&plan.lines);
        for (place, (line, planned)) in lines.enumerate() {
            line.plan(planned, place);
        }
    }

    /// Begins as planned, with a servo at rest under the loop that was planned.
    pub(in crate::commission) fn begin(&mut self, holding: &mut Holding<N>) {
        // The feed-forward has load and friction.
        holding.balance(N::ZERO);
        let speed = self.motion.speed;
        let is_beyond = holding.reference() > self.motion.start;
        self.heading = if is_beyond { -speed } else { speed };
        self.enter(Stage::Approach);
        (self.velocity, self.fade) = (N::ZERO, N::ZERO);
        (self.measured, self.repeated, self.line) = (0, 0, self.count);
        (self.following, self.compensation) = (Following::default(), N::ZERO);
        self.learning = self.motion.learning;
    }

    /// A sample: takes it into the sums, and leads the loop on. A servo that does not follow ends the motions.
    pub(in crate::commission) fn process(
        &mut self,
        holding: &mut Holding<N>,
        sample: &ResponseWindows<N>,
    ) -> ResponseProgress<N> {
        self.still = if sample.increment == N::ZERO {
            self.still.saturating_add(1)
        } else {
            0
        };
        let error = holding.reference() - sample.position;
        let follows = self.following.take(error, &self.motion);
        if self.following.is_over(&self.motion) && self.stage != Stage::Stopping {
            self.measured = self.motion.response_motions;
            self.enter(Stage::Stopping);
        }
        if follows || self.stage == Stage::Window {
            self.passed = self.passed.saturating_add(1);
        }
        if self.stage == Stage::Window {
            self.is_cut |= sample.is_cut;
            self.window.farthest = self.window.farthest.larger(error.magnitude());
            self.gather(sample);
        }
        let learning = self.learning;
        self.proceed(holding.reference());
        if Following::is_pushed(error, sample.velocity, &self.motion) {
            return ResponseProgress::Over;
        }
        if self.learning < learning {
            self.learn(holding);
        }
        let acceleration = self.accelerate();
        let injection = self.inject();
        let feed_forward = self.feed_forward(acceleration);
        // The reference waits for a servo that breaks away late.
        let velocity = if follows { self.velocity } else { N::ZERO };
        let ahead = sample.position + self.motion.delay * velocity;
        self.compensation = -self.motion.forces.load(ahead);
        holding.lead(velocity, feed_forward + self.compensation + injection);
        if let Some(sums) = self.hand_over() {
            return ResponseProgress::Line(sums);
        }
        if core::mem::take(&mut self.is_balanced) {
            return ResponseProgress::Balance(self.window.balance(self.motion.window));
        }
        let stands = self.stage == Stage::Stopping && self.velocity == N::ZERO;
        if stands && self.line >= self.count {
            ResponseProgress::Over
        } else {
            ResponseProgress::Going
        }
    }

    /// Model, delay and bandwidth of the loop that is planned to hold the servo meanwhile.
    pub(in crate::commission) fn loop_plan(&self) -> (&RoughModel<N>, N, N) {
        let Motion {
            servo,
            delay,
            bandwidth,
            ..
        } = &self.motion;
        (servo, *delay, *bandwidth)
    }

    /// True while friction and load are still to be learnt.
    pub(in crate::commission) fn learns(&self) -> bool {
        self.learning > 0
    }

    /// True while the multisine acts.
    pub(in crate::commission) fn injects(&self) -> bool {
        self.fade > N::ZERO
    }

    fn enter(&mut self, stage: Stage) {
        self.stage = stage;
        self.passed = 0;
        if stage == Stage::Stopping {
            self.heading = N::ZERO;
        }
    }

    /// Goes on to the next stage where one is over.
    fn proceed(&mut self, reference: N) {
        match self.stage {
            Stage::Approach => {
                let passed_start = (reference - self.motion.start) * self.heading >= N::ZERO;
                if passed_start {
                    self.heading = self.motion.speed;
                    self.enter(Stage::Turn);
                }
            }
            Stage::Turn if self.velocity == self.heading => {
                self.inverted = self.is_half_done();
                self.enter(Stage::Settling);
            }
            Stage::Settling if self.passed >= self.motion.settling => {
                (self.window, self.is_cut) = (Window::begin(), false);
                self.enter(Stage::Window);
            }
            Stage::Window if self.passed >= self.motion.window => self.end_window(),
            _ => {}
        }
    }

    /// Has the sums handed over, unless it was to be learnt, and turns it round.
    fn end_window(&mut self) {
        self.line = 0;
        if self.learning > 0 {
            self.learning -= 1;
            self.handed = None;
        } else if self.is_cut && self.repeated < Self::REPEATED {
            self.repeated += 1;
            self.handed = None;
        } else {
            self.handed = Some(self.inverted);
            self.is_balanced = true;
            self.measured += 1;
        }
        if self.measured >= self.motion.response_motions {
            self.enter(Stage::Stopping);
            return;
        }
        let [first, second] = Self::SPEEDS;
        let part = if self.is_half_done() { second } else { first };
        let speed = N::from_f64(part) * self.motion.speed;
        self.heading = if self.heading > N::ZERO {
            -speed
        } else {
            speed
        };
        self.enter(Stage::Turn);
    }

    /// Takes the command that the integral had to find in the motion that is over into the feed-forward.
    fn learn(&mut self, holding: &mut Holding<N>) {
        let balance = self.window.balance(self.motion.window);
        let change = self.motion.servo.learn(&balance);
        holding.subtract_from_integral(change);
        if self.learning == 0 {
            // A force that changes with the place moves the servo by the reciprocal square of the bandwidth.
            let most = N::from_f64(Self::HELD) * self.motion.max_error;
            let least = self.motion.learnt_bandwidth * self.motion.learnt_bandwidth;
            let held = (self.window.farthest * most.reciprocal()).limited(least, N::ONE);
            holding.reduce_bandwidth(held * held.reciprocal_root());
        }
    }

    /// True if the next motion is one of the last half, whose injection is inverted.
    fn is_half_done(&self) -> bool {
        self.measured >= self.motion.response_motions / 2
    }

    /// Takes a sample into the sums of every line.
    fn gather(&mut self, sample: &ResponseWindows<N>) {
        // Without the change of the load and the part of the command that balances it.
        let balanced = ResponseWindows {
            command: sample.command - self.compensation,
            ..*sample
        };
        let [increment, command] = self.window.take(&balanced, self.motion.window_rotation);
        for line in self.lines.iter_mut().take(usize::from(self.count)) {
            line.gather(increment, command);
        }
    }

    /// The acceleration of the reference in the next sample.
    fn accelerate(&mut self) -> N {
        let most = self.motion.acceleration;
        let left = self.heading - self.velocity;
        if left.magnitude() <= most {
            self.velocity = self.heading;
            return left;
        }
        let change = left.limited(-most, most);
        self.velocity += change;
        change
    }

    /// The command that the identified servo needs for the motion of the reference, load and friction included.
    fn feed_forward(&self, acceleration: N) -> N {
        let servo = &self.motion.servo;
        if self.velocity == N::ZERO {
            return servo.holding();
        }
        let command = servo.command(acceleration + servo.viscous * self.velocity, self.velocity);
        if !has_missed(self.velocity, self.still) {
            return command;
        }
        let toward = if self.velocity > N::ZERO {
            N::ONE
        } else {
            -N::ONE
        };
        command + toward * self.motion.forces.low_speed
    }

    /// The multisine's next sample.
    fn inject(&mut self) -> N {
        let acts = matches!(self.stage, Stage::Settling | Stage::Window);
        let growth = if acts {
            self.motion.fade
        } else {
            -self.motion.fade
        };
        self.fade = (self.fade + growth).limited(N::ZERO, N::ONE);
        if self.fade == N::ZERO {
            return N::ZERO;
        }
        let mut sum = N::ZERO;
        for line in self.lines.iter_mut().take(usize::from(self.count)) {
            sum += line.inject();
        }
        let sum = self.fade * sum;
        if self.inverted { -sum } else { sum }
    }

    /// The sums of the next line that is to be handed over; adapts its amplitude and begins it anew.
    fn hand_over(&mut self) -> Option<LineSums<N>> {
        if self.line >= self.count {
            return None;
        }
        let number = self.line;
        self.line += 1;
        let wanted = self.motion.line_speed;
        let window = N::from_count(self.motion.window as i32);
        let line = self.lines.get_mut(usize::from(number))?;
        line.adapt(wanted * window);
        let sums = self.handed.map(|inverted| LineSums {
            line: number,
            inverted,
            position: line.position,
            command: line.command,
        });
        line.begin_anew();
        sums
    }
}
