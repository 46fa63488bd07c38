//! First estimates that need none: the equation of motion in its weak form.

use super::spectrum::{MAX_UNKNOWNS, Spectrum};
use super::statistics::windows;
use super::{Effect, Record, RecordStatistics, Values};

/// An estimate from windows of one width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Start {
    /// a, b, c, d and the delay.
    pub(super) values: Values,
    /// Deviation of the windows' weights, samples.
    pub(super) width: f64,
    /// The part of the acceleration's variance that it explains, at most 1.
    pub(super) explained: f64,
}

/// The most starts: half widths from 6 samples by a factor of 1.6.
pub(super) const MAX_STARTS: usize = 14;

/// Estimates from windows of several widths: with weights g that vanish at both ends,
///
/// −∫g′q̇ = −a ∫g q̇ + b ∫g (u − τ u̇) − c ∫g sign q̇ + d ∫g
///
/// is linear in a, b, bτ, c, d and gravity, and no noise is differentiated. Literature: Preisig and Rippin, "Theory and
/// application of the modulating function method", Computers & Chemical Engineering 17(1), 1993.
pub(super) fn starts(
    record: &Record<'_>,
    statistics: &RecordStatistics,
    has_gravity: bool,
) -> [Option<Start>; MAX_STARTS] {
    let mut starts = [None; MAX_STARTS];
    let mut half_width = 6;
    for start in &mut starts {
        if half_width >= (record.len() / 12).max(8) {
            break;
        }
        *start = one(record, statistics, half_width, has_gravity);
        half_width = half_width * 8 / 5 + 1;
    }
    starts
}

fn one(
    record: &Record<'_>,
    statistics: &RecordStatistics,
    half_width: usize,
    has_gravity: bool,
) -> Option<Start> {
    /// Windows of which less moves are left out: at rest friction is unknown.
    const MIN_MOVING: f64 = 0.7;
    /// The fewest windows.
    const MIN_WINDOWS: f64 = 20.0;
    /// Standard deviation of the weights over the half width.
    const DEVIATION: f64 = 1.0 / 3.0;
    let unknowns = if has_gravity { 7 } else { 5 };
    let mut hessian = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
    let mut gradient = [0.0; MAX_UNKNOWNS];
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    windows(record, half_width, statistics.noise, &mut |window| {
        if window.moving < MIN_MOVING {
            return;
        }
        let row = [
            -window.velocity,
            window.command,
            -window.direction,
            1.0,
            -window.command_change,
            window.wave[0],
            window.wave[1],
        ];
        let y = window.acceleration;
        for (i, &one) in row.iter().enumerate().take(unknowns) {
            gradient[i] += one * y;
            for (j, &other) in row.iter().enumerate().take(unknowns) {
                hessian[i][j] += one * other;
            }
        }
        count += 1.0;
        sum += y;
        squares += y * y;
    });
    if count < MIN_WINDOWS {
        return None;
    }
    let spectrum = Spectrum::new(&hessian, unknowns);
    let solution = spectrum.solve(&gradient, 1e-6);
    let explained: f64 = (0..unknowns)
        .map(|i| {
            let along: f64 = (0..unknowns).map(|j| hessian[i][j] * solution[j]).sum();
            solution[i] * (2.0 * gradient[i] - along)
        })
        .sum();
    let rest = (squares - explained).max(0.0);
    let gain = solution[1];
    let total = squares - sum * sum / count;
    let mut values = Values::NONE;
    values.set(Effect::A, solution[0].clamp(0.0, 0.5));
    values.set(Effect::B, gain);
    values.set(Effect::Coulomb, solution[2].max(0.0));
    values.set(Effect::Load, solution[3]);
    values.set(Effect::Delay, solution[4] / gain);
    if has_gravity {
        values.set(Effect::GravitySine, solution[5]);
        values.set(Effect::GravityCosine, solution[6]);
    }
    Some(Start {
        values,
        width: DEVIATION * half_width as f64,
        explained: 1.0 - rest / total.max(f64::MIN_POSITIVE),
    })
}
