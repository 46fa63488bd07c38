//! The governor, through which the command of every activity passes: it keeps an unknown servo within its speed and
//! its travel.

use super::Limits;
use identifier_core::number::Number;
use identifier_core::units::Units;

/// An observer of speed and unexplained acceleration, and a barrier: the commands that may act are those under which
/// the servo comes near its limit without passing it.
///
/// With the speed v, the acceleration w that b u does not explain (load, friction, a spring), and the speed limit V, a
/// command is at most
///
/// u = ((V′ − v)/τ − w)/b
///
/// so that a servo with this b, or a smaller one, approaches V′ with the time constant τ, some times the delay of the
/// loop. The command of a servo that is faster brakes. V′ is 0.8 V, or zero if the servo would not stop before the end
/// of its travel. For the least command the same holds with V′ changed in sign. There is no switch, so an error of w
/// changes the speed by τ times that and no more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Governor<N> {
    /// The largest share of a sample in v, with which some counts pass at V.
    share: N,
    /// The square of a share in v over b: a count changes w by no more than a part of the whole command.
    share_per_gain: N,
    /// V′, counts a sample.
    fast: N,
    /// 1/τ, per sample.
    rate: N,
    /// Samples in which a servo that brakes by the barrier goes on: delay and τ.
    stopping: N,
    /// The places within which it is to stop, counts.
    ends: [N; 2],
    command: [N; 2],
    /// The largest b that the servo may have, and that of a servo of which nothing is known; with the reciprocals.
    largest: [N; 2],
    unknown: [N; 2],
}

/// The servo as it is observed. Counts and samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Governed<N> {
    speed: N,
    unexplained: N,
    /// b, and the shares of a sample in v and w: a double pole.
    gain: N,
    shares: [N; 2],
    /// The commands that may act in this sample.
    allowed: [N; 2],
}

impl<N: Number> Governed<N> {
    /// The speed, counts a sample: the mean of the last counts with the effect of the commands since then.
    pub(super) fn speed(&self) -> N {
        self.speed
    }

    /// Goes on from another estimate.
    pub(super) fn set_speed(&mut self, speed: N) {
        self.speed = speed;
    }

    /// A command within those that may act in this sample.
    pub(super) fn confined(&self, command: N) -> N {
        let [least, most] = self.allowed;
        command.limited(least, most)
    }
}

impl<N: Number> Governor<N> {
    /// Counts that pass at the largest speed in the time of the mean, and the largest share of a sample in it.
    const MEAN: (f64, f64) = (3.0, 0.35);
    /// Four times the part of the command's effect that a count may change.
    const RESOLVED: f64 = 0.15;
    /// V′ over the speed limit.
    const FAST: f64 = 0.8;
    /// The part of the travel within which a servo stops.
    const ENDS: f64 = 0.95;
    /// The part of the command that may hold a load.
    pub(super) const HOLDS: f64 = 0.8;
    /// τ over the delay.
    const TIME: f64 = 1.5;
    /// The change of the speed within the delay by all of the command over the limit, for a servo of which nothing is
    /// known. The counts do not warn of a stronger one in time.
    const STRONGEST: f64 = 0.5;

    /// For limits, with the largest b if it is stated, and a delay in samples.
    pub(super) fn new(units: &Units, limits: &Limits, max_gain: Option<f64>, delay: f64) -> Self {
        let speed = limits.speed * units.velocity();
        let (counts, share) = Self::MEAN;
        let share = share.min(speed / counts);
        let [low, high] = limits.command;
        let late = delay + 1.0 / share;
        let acceleration = units.velocity() * units.sample_time();
        let largest = max_gain.map_or(f64::INFINITY, |gain| gain * acceleration);
        let unknown = Self::STRONGEST * speed / (high.max(-low) * late);
        let gain = |gain: f64| [gain, 1.0 / gain].map(N::from_f64);
        Self {
            share: N::from_f64(share),
            share_per_gain: N::from_f64(Self::RESOLVED * high.min(-low)),
            fast: N::from_f64(Self::FAST * speed),
            rate: N::from_f64(1.0 / (Self::TIME * late)),
            stopping: N::from_f64(delay + Self::TIME * late),
            ends: limits
                .travel
                .map(|end| N::from_f64(Self::ENDS * end * units.position())),
            command: limits.command.map(N::from_f64),
            largest: gain(largest),
            unknown: gain(unknown.min(largest)),
        }
    }

    /// Takes an increment under the command that was given before.
    #[inline]
    pub(super) fn follow(&self, state: &mut Governed<N>, increment: N, command: N) {
        let predicted = state.speed + state.gain * command + state.unexplained;
        let [speed, unexplained] = state.shares;
        let error = increment - predicted;
        state.speed = predicted + speed * error;
        state.unexplained += unexplained * error;
    }

    /// The commands that may act on a servo at a position, counts, with an estimate of b and 1/b, if there is one. The
    /// last command is that of the sample before.
    #[inline]
    pub(super) fn allow(
        &self,
        state: &mut Governed<N>,
        known: Option<[N; 2]>,
        position: N,
        last: N,
    ) -> [N; 2] {
        let [gain, per_gain] = match known {
            Some([gain, _]) if gain > self.largest[0] => self.largest,
            Some(gain) => gain,
            None => self.unknown,
        };
        if gain != state.gain {
            // The acceleration of the servo remains.
            state.unexplained += (state.gain - gain) * last;
            state.gain = gain;
            let square = self.share_per_gain * gain;
            let share = (square * square.reciprocal_root()).smaller(self.share);
            let half = N::from_f64(0.5) * share;
            state.shares = [share, half * half];
        }
        let [low, high] = self.command;
        let balance = -(state.unexplained * per_gain);
        let [lightest, heaviest] = self.command.map(|end| N::from_f64(Self::HOLDS) * end);
        let balance = balance.limited(lightest, heaviest);
        let speed = state.speed;
        let stops = |direction: N, end: usize, brakes: N| {
            let speed = (direction * speed).larger(N::ZERO);
            let room = direction * (self.ends[end] - position) - self.stopping * speed;
            // v² < 2 ẍ s, with half of b.
            known.is_none() || room > N::ZERO && speed * speed < gain * brakes * room
        };
        let fast = |stops: bool| if stops { self.fast } else { N::ZERO };
        let rate = per_gain * self.rate;
        let most = balance + rate * (fast(stops(N::ONE, 1, balance - low)) - speed);
        let least = balance - rate * (fast(stops(-N::ONE, 0, high - balance)) + speed);
        state.allowed = [least, most].map(|end| end.limited(low, high));
        state.allowed
    }

    /// True if a command that acts is at an end of those that may act, and not at a limit of the order.
    pub(super) fn cuts(&self, state: &Governed<N>, command: N) -> bool {
        let ([least, most], [low, high]) = (state.allowed, self.command);
        command >= most && most < high || command <= least && least > low
    }

    /// Has all commands act.
    pub(super) fn allow_all(&self, state: &mut Governed<N>) -> [N; 2] {
        state.allowed = self.command;
        state.allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use virtual_servo::SplitMix64;

    const LIMIT: f64 = 10.0;

    /// A rigid servo in counts and samples, with the knowledge that its governor has.
    #[derive(Debug, Clone, Copy)]
    struct Drawn {
        gain: f64,
        load: f64,
        friction: f64,
        delay: usize,
        speed: f64,
        travel: f64,
        /// The largest b that is stated, and the estimate, if there is one.
        stated: f64,
        known: Option<f64>,
    }

    /// All of the command changes the speed by up to 0.05 of the limit in a sample. The load is up to 0.3 of it, friction up
    /// to 0.2, a delay up to two samples; the travel is such that all of the command stops the servo within a half of it.
    fn drawn(random: &mut SplitMix64) -> Drawn {
        let logarithmic = |random: &mut SplitMix64, low: f64, high: f64| {
            low * (high / low).powf(random.next_uniform())
        };
        let speed = logarithmic(random, 1.0, 300.0);
        let push = speed * logarithmic(random, 0.003, 0.05);
        let gain = push / LIMIT;
        let stated = gain * random.uniform(1.0, 2.0);
        Drawn {
            gain,
            load: push * random.uniform(-0.3, 0.3),
            friction: push * random.uniform(0.0, 0.2),
            delay: random.uniform(0.0, 2.99) as usize,
            speed,
            travel: speed * speed / push * random.uniform(1.0, 5.0) + 10.0 * speed,
            stated,
            known: (random.next_uniform() < 0.7).then(|| gain * random.uniform(0.8, 2.0)),
        }
    }

    /// The largest speed and travel over their limits, under commands that do what they like.
    fn reached(drawn: &Drawn, random: &mut SplitMix64) -> [f64; 2] {
        let (time, resolution) = (1e-3, 1e-4);
        let units = Units::new(time, resolution).expect("valid");
        let travel = drawn.travel * resolution;
        let limits = Limits::new(
            [-travel, travel],
            drawn.speed * resolution / time,
            [-LIMIT, LIMIT],
        );
        let stated = drawn.stated * resolution / (time * time);
        let governor = Governor::<f32>::new(&units, &limits, Some(stated), drawn.delay as f64);
        let mut state = Governed::default();
        let known = drawn
            .known
            .map(|gain| [gain, 1.0 / gain].map(|value| value as f32));
        let (mut position, mut speed, mut count) = (0.0_f64, 0.0_f64, 0.0_f64);
        let (mut command, mut wanted, mut left) = (0.0_f32, 0.0, 0.0);
        let mut acting = [0.0; 4];
        let mut reached = [0.0_f64; 2];
        for _ in 0..3000 {
            let now = position.floor();
            governor.follow(&mut state, (now - count) as f32, command);
            count = now;
            left -= 1.0;
            if left < 0.0 {
                // From a sample to longer than the travel takes.
                left = 500.0_f64.powf(random.next_uniform());
                wanted = LIMIT * random.uniform(-2.0, 2.0);
            }
            let _ = governor.allow(&mut state, known, count as f32, command);
            command = state.confined(wanted as f32);
            acting.rotate_right(1);
            acting[0] = f64::from(command);
            let force = drawn.gain * acting[drawn.delay] + drawn.load;
            let pushed = speed + force;
            speed = pushed - pushed.clamp(-drawn.friction, drawn.friction);
            position += speed;
            reached[0] = reached[0].max(speed.abs() / drawn.speed);
            reached[1] = reached[1].max((position.abs() - 1.0) / drawn.travel);
        }
        reached
    }

    #[test]
    fn no_command_takes_a_servo_beyond_its_speed_or_its_travel() {
        let mut random = SplitMix64::new(97);
        for _ in 0..2000 {
            let drawn = drawn(&mut random);
            let [speed, travel] = reached(&drawn, &mut random);
            assert!(speed <= 1.1, "{speed} {drawn:?}");
            // Without an estimate of b there is none of the distance that a brake takes.
            assert!(
                drawn.known.is_none() || travel <= 1.02,
                "{travel} {drawn:?}"
            );
        }
    }
}
