use super::start::StartFit;
use super::{FrozenServo, Observation, Play, Squares, State};

/// What an open-loop simulation is off the recorded positions by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenLoop {
    /// Samples that it covers.
    pub samples: u64,
    /// Root mean square of the position error, rad.
    pub rms: f64,
    /// The largest position error, rad.
    pub largest: f64,
    /// The error relative to the motion from where each stretch begins.
    pub relative: f64,
}

/// Drives a servo by the recorded command alone.
///
/// **The start is fitted**: position and velocity at the first sample of each stretch are those from
/// which the simulation comes nearest to all of it, as is usual for published results. The first
/// samples alone do not tell the velocity to what an encoder rounds away, and what they leave would add
/// up to more than the model's own error. Nothing else is fitted.
///
/// None where samples have no command, or the simulation leaves every bound.
///
/// # Errors
/// Whatever playing the samples ends with.
pub fn open_loop<E>(servo: &FrozenServo, play: Play<'_, E>) -> Result<Option<OpenLoop>, E> {
    /// The most steps of the fit.
    const STEPS: u32 = 8;
    let Some(mut fits) = first_guesses(play)? else {
        return Ok(None);
    };
    for _ in 0..STEPS {
        let mut stretch = None;
        play(&mut |sample| {
            let fit = fits.get_mut(next(&mut stretch, sample));
            if let (Some(fit), Some(command)) = (fit, sample.command) {
                fit.add(servo, sample, command);
            }
        })?;
        let worth = fits.iter_mut().map(StartFit::step);
        if !worth.fold(false, |any, one| any | one) {
            break;
        }
    }
    let starts: Vec<_> = fits.iter().map(StartFit::start).collect();
    simulated(servo, &starts, play)
}

/// The number of the stretch that a sample belongs to.
fn next(stretch: &mut Option<usize>, sample: &Observation) -> usize {
    let number = match *stretch {
        None => 0,
        Some(before) => before + usize::from(sample.begins),
    };
    *stretch = Some(number);
    number
}

/// The first position and the first step of each stretch, and the usual speed.
fn first_guesses<E>(play: Play<'_, E>) -> Result<Option<Vec<StartFit>>, E> {
    let mut stretch = None;
    let mut starts: Vec<State> = Vec::new();
    let mut last = 0.0;
    let (mut squares, mut steps) = (0.0, 0.0);
    let mut is_second = false;
    let mut commanded = true;
    play(&mut |sample| {
        commanded &= sample.command.is_some();
        let number = next(&mut stretch, sample);
        if number == starts.len() {
            starts.push(State {
                position: sample.position,
                velocity: 0.0,
            });
            is_second = true;
        } else {
            let step: f64 = sample.position - last;
            if std::mem::take(&mut is_second) {
                starts[number].velocity = step;
            }
            squares += step * step;
            steps += 1.0;
        }
        last = sample.position;
    })?;
    let speed = f64::sqrt(squares / steps);
    let is_moved = commanded && speed > 0.0;
    let fit = |start: State| StartFit::new(start, speed);
    Ok(is_moved.then(|| starts.into_iter().map(fit).collect()))
}

fn simulated<E>(
    servo: &FrozenServo,
    starts: &[State],
    play: Play<'_, E>,
) -> Result<Option<OpenLoop>, E> {
    let mut stretch = None;
    let (mut state, mut first) = (State::default(), 0.0);
    let (mut squares, mut largest, mut samples) = (Squares::default(), 0.0_f64, 0);
    play(&mut |sample| {
        let before = stretch;
        let number = next(&mut stretch, sample);
        if stretch != before {
            state = starts.get(number).copied().unwrap_or_default();
            first = sample.position;
        }
        squares.add(sample.position - first, state.position - first);
        largest = largest.max((sample.position - state.position).abs());
        samples += 1;
        servo.advance(&mut state, sample.command.unwrap_or(f64::NAN));
    })?;
    let rms = (squares.error / samples as f64).sqrt();
    Ok(rms.is_finite().then(|| OpenLoop {
        samples,
        rms,
        largest,
        relative: squares.relative(),
    }))
}
