use super::conservative_pid::ConservativePid;
use super::gains::{Loop, Velocity};
use identifier_core::control::{ControlSample, ControlState, ShapedState};
use identifier_core::number::Number;

/// A servo that is held, or brought to a place at a bounded speed. Positions in counts from where the
/// commissioning began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Holding<N: Number> {
    controller: Loop<N>,
    state: ControlState<N, Velocity<N>, ShapedState<N>>,
    /// The reference, and where it goes.
    reference: N,
    target: N,
    /// Counts a sample.
    pace: N,
    /// Added to the command: a disturbance.
    disturbance: N,
    /// The commands that may act in this sample, and at all.
    allowed: [N; 2],
    limit: [N; 2],
    rest: RestWatch<N>,
    /// True while the loop moves it to a position.
    is_led: bool,
}

/// True if a servo stays within a few counts of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RestWatch<N> {
    at: N,
    within: N,
    still: u32,
    needed: u32,
    /// The sum of the commands while it was still, and how many they are.
    commands: N,
    commanded: u32,
}

impl<N: Number> Holding<N> {
    /// Counts within which a servo is at rest: an edge of the encoder to either side.
    const AT_REST: f64 = 2.0;

    /// Counts within which it has arrived: friction holds it short of its place.
    const ARRIVED: f64 = 20.0;

    /// Takes over at the servo's position after the last sample of its predecessor, without a step of the command.
    /// `rest` is the number of samples without motion that count as at rest.
    pub(super) fn take_over(
        controller: Loop<N>,
        limit: [N; 2],
        position: N,
        last: &ControlSample<N>,
        pace: N,
        rest: u32,
    ) -> Self {
        let reference = position + last.error;
        Self {
            state: controller.take_over(last),
            controller,
            reference,
            target: reference,
            pace,
            disturbance: N::ZERO,
            allowed: limit,
            limit,
            rest: RestWatch {
                at: position,
                within: N::from_f64(Self::AT_REST),
                still: 0,
                needed: rest,
                commands: N::ZERO,
                commanded: 0,
            },
            is_led: false,
        }
    }

    /// Confines the command of this sample.
    pub(super) fn allow(&mut self, commands: [N; 2]) {
        self.allowed = commands;
    }

    /// The loop that holds it.
    pub(super) fn controller(&self) -> &Loop<N> {
        &self.controller
    }

    /// Goes on with a part of the loop's bandwidth. The integral's command is kept as far as it balances the load. The
    /// damping of the reference's motion is not, because only that part of it remains.
    pub(super) fn reduce_bandwidth(&mut self, part: N) {
        let damping = self.controller.linear(N::ZERO, self.velocity());
        self.subtract_from_integral((part - N::ONE) * damping);
        self.controller = ConservativePid::slower(&self.controller, part);
        self.state = self.state.with_integral_for(part * part * part);
        self.rest.begin();
    }

    /// Counts as at rest after this many samples, if they are more than otherwise.
    pub(super) fn rest_for(&mut self, samples: u32) {
        self.rest.needed = self.rest.needed.max(samples);
    }

    /// Brings the servo to a place.
    pub(super) fn send(&mut self, target: N) {
        self.target = target;
        self.is_led = true;
        self.rest.begin();
    }

    /// A step of the reference.
    pub(super) fn step_to(&mut self, target: N) {
        self.send(target);
        self.reference = target;
    }

    /// Has the integral hold a load by this command and nothing else. A servo at rest by friction does not notice. The
    /// integral loses the part that it had gathered against friction.
    pub(super) fn balance(&mut self, command: N) {
        let integral = self.controller.integral_for(command, N::ZERO, N::ZERO);
        self.state = self.state.with_integral(integral);
    }

    /// Takes a command from the integral that is added to the loop's from now on.
    pub(super) fn subtract_from_integral(&mut self, command: N) {
        let integral = self.controller.integral_for(command, N::ZERO, N::ZERO);
        self.state = self.state.with_integral_less(integral);
    }

    /// Holds the servo where it is by the command that balances the load and nothing else. The integral of an error that
    /// friction has left would sooner or later move it on.
    pub(super) fn stay(&mut self, position: N, command: N) {
        self.send(position);
        self.reference = position;
        self.balance(command);
    }

    /// Waits where friction holds a servo at rest short of its place. The integral would sooner or later move it on, and
    /// beyond its place where it rubs more at rest.
    pub(super) fn wait(&mut self, position: N) {
        if (self.reference - position).magnitude() > self.rest.within {
            (self.reference, self.target) = (position, position);
            self.balance(self.rest.mean_command());
        }
    }

    /// Disturbs the servo by a command on top of the controller's.
    pub(super) fn disturb(&mut self, command: N) {
        self.disturbance = command;
        self.rest.begin();
    }

    /// Leads the servo on by a velocity for a sample, with this command on top of the controller's.
    pub(super) fn lead(&mut self, velocity: N, command: N) {
        self.reference += velocity;
        self.target = self.reference;
        // The derivative acts on the measured velocity alone, and would brake.
        self.disturbance = command - self.controller.linear(N::ZERO, velocity);
    }

    /// The reference.
    pub(super) fn reference(&self) -> N {
        self.reference
    }

    /// True until it has arrived where it is brought to.
    pub(super) fn is_led(&self) -> bool {
        self.is_led
    }

    /// The velocity of the reference on its way to the target, counts a sample.
    fn velocity(&self) -> N {
        (self.target - self.reference).limited(-self.pace, self.pace)
    }

    /// A sample: the command. None if the position is beyond the loop's counter.
    pub(super) fn process(&mut self, position: N, increment: N) -> Option<N> {
        self.reference += self.velocity();
        let is_there = (self.target - position).magnitude() <= N::from_f64(Self::ARRIVED);
        self.is_led &= !is_there;
        self.rest.observe(position);
        let error = self.reference - position;
        let sample = self.controller.process(&mut self.state, error, increment);
        let [low, high] = self.limit;
        let wanted = (sample.ok()?.command + self.disturbance).limited(low, high);
        let [low, high] = self.allowed;
        let command = wanted.limited(low, high);
        // Anti-windup: an error that drives the command further beyond what may act is not gathered.
        if (wanted - command) * error > N::ZERO {
            self.state = self.state.with_integral_less(error);
        }
        self.rest.gather(command);
        Some(command)
    }

    /// True if the servo has arrived and is at standstill.
    pub(super) fn is_at_rest(&self) -> bool {
        self.reference == self.target && self.rest.still >= self.rest.needed
    }

    /// The sample from which a controller takes over at rest: the mean command, and no velocity. An
    /// edge of a coarse encoder makes much of both in a single sample.
    pub(super) fn resting(&self) -> ControlSample<N> {
        ControlSample {
            error: N::ZERO,
            increment: N::ZERO,
            velocity: N::ZERO,
            command: self.rest.mean_command(),
        }
    }
}

impl<N: Number> RestWatch<N> {
    fn begin(&mut self) {
        self.still = 0;
        self.commands = N::ZERO;
        self.commanded = 0;
    }

    fn gather(&mut self, command: N) {
        self.commands += command;
        self.commanded = self.commanded.saturating_add(1);
    }

    fn mean_command(&self) -> N {
        let commanded = N::from_f64(f64::from(self.commanded.max(1)));
        self.commands * commanded.reciprocal()
    }

    fn observe(&mut self, position: N) {
        if (position - self.at).magnitude() > self.within {
            self.at = position;
            self.begin();
        } else {
            self.still = self.still.saturating_add(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::conservative_pid::tests::{LIMITS, loop_for};
    use super::*;
    use identifier_core::units::Units;

    /// Friction holds it 30 counts short of its place. Until it waits there, the command grows.
    #[test]
    fn a_servo_that_friction_holds_waits_where_it_is_under_a_constant_command() {
        let (time, counts) = (1e-3, 1e5);
        let units = Units::new(time, core::f64::consts::TAU / counts).expect("valid");
        let controller = loop_for(200.0, time, counts, 2.0);
        let last = ControlSample {
            error: 30.0,
            increment: 0.0,
            velocity: 0.0,
            command: 2.0,
        };
        let pace = 4.0 * units.velocity();
        let mut holding = Holding::take_over(controller, LIMITS.command, 0.0, &last, pace, 8);
        let after = |holding: &mut Holding<f64>, samples| {
            let commands = (0..samples).map(|_| holding.process(0.0, 0.0).expect("within"));
            commands.last().expect("some")
        };
        let [first, grown] = [1, 200].map(|samples| after(&mut holding, samples));
        assert!(grown > 1.02 * first, "{first} {grown}");
        assert!(holding.is_at_rest());
        holding.wait(0.0);
        let [first, grown] = [1, 500].map(|samples| after(&mut holding, samples));
        assert!((grown / first - 1.0).abs() < 1e-5, "{first} {grown}");
        assert!(holding.is_at_rest() && holding.reference() == 0.0);
    }

    #[test]
    fn a_loop_gives_way_without_a_bump_at_rest_and_in_motion() {
        const BALANCE: f64 = 2.0;
        for time in [4e-3, 1e-3, 1e-4] {
            let counts = 1e5;
            let units = Units::new(time, core::f64::consts::TAU / counts).expect("valid");
            let controller = loop_for(200.0, time, counts, 2.0);
            let pace = 4.0 * units.velocity();
            for velocity in [0.0, pace, -pace] {
                let last = ControlSample {
                    error: 0.0,
                    increment: velocity,
                    velocity,
                    command: BALANCE,
                };
                let mut holding =
                    Holding::take_over(controller, LIMITS.command, 0.0, &last, pace, 8);
                holding.send(1e3 * velocity);
                for sample in 1..20 {
                    if sample == 10 {
                        holding.reduce_bandwidth(0.4);
                    }
                    let position = velocity * f64::from(sample);
                    let command = holding.process(position, velocity).expect("within");
                    let bump = (command - BALANCE).abs();
                    assert!(bump < 0.01, "{time} {velocity} {sample}: {bump}");
                }
            }
        }
    }
}
