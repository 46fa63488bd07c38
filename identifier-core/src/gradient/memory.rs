use crate::constants::encode;
use crate::identify::Report;
use crate::number::{Arithmetic, Encoded, Number};
use crate::parameters::{Parameter, PerParameter, Unknown};
use crate::scales::FullScales;
use crate::units::Units;
use crate::windows::{COLUMNS, Found, MeasuredPiece, Pieces, WindowSettings, Windows};

/// The background's half of the gradient identifier: the windows of the motion, and what they give the estimates.
///
/// The step θ ← (Ω + ρ Γ⁻¹)⁻¹ (Y + ρ Γ⁻¹ θ) is in the metric of Γ, so that the storage function (12) falls in each of them. It is computed in the floating-point number of the identifier, and in f32 beside
/// fixed point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientMemory<N: Arithmetic> {
    pub(super) pieces: Pieces<N>,
    pub(super) windows: WindowSettings<N::Real>,
    pub(super) scales: FullScales,
    pub(super) units: Units,
}

encode! {
    [N: Encoded] GradientMemory<N> as "GradientMemory" { pieces, windows, scales, units }
}

/// Its state between pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientMemoryState<F> {
    windows: Windows<F>,
    /// The number of the next piece.
    next: u32,
    lost: u32,
    /// Pieces since the last correction, and whether they completed a window.
    since: u8,
    is_new: bool,
    found: Option<Found<F>>,
}

/// The estimates after a step of the memory, and the load, machine units. They replace those before, so that a correction
/// may be late, lost or taken over twice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientCorrection<N> {
    pub(super) estimates: PerParameter<N>,
}

impl<N: Arithmetic> GradientMemory<N> {
    /// Without a motion.
    #[must_use]
    pub fn start(&self) -> GradientMemoryState<N::Real> {
        GradientMemoryState {
            windows: self.windows.start(),
            next: 0,
            lost: 0,
            since: 0,
            is_new: false,
            found: None,
        }
    }

    /// Takes a piece of the motion. Every fourth one may give a correction of the estimates
    /// ([`MachineEstimates`](crate::identifier::MachineEstimates)).
    pub fn process(
        &self,
        state: &mut GradientMemoryState<N::Real>,
        piece: &MeasuredPiece<N>,
        estimates: &PerParameter<N>,
    ) -> Option<GradientCorrection<N>> {
        /// Pieces to a correction.
        const EVERY: u8 = 4;
        let missing = piece.number().wrapping_sub(state.next);
        if missing != 0 {
            state.lost = state.lost.wrapping_add(missing);
            state.windows.interrupt();
        }
        state.next = piece.number().wrapping_add(1);
        state.is_new |= self
            .windows
            .push(&mut state.windows, &self.pieces.piece(piece));
        state.since = state.since.saturating_add(1);
        if state.since < EVERY || !state.is_new {
            return None;
        }
        (state.since, state.is_new) = (0, false);
        let real = |parameter: Parameter| {
            let value = estimates
                .get(parameter)
                .value(self.scales.estimate(parameter));
            <N::Real as Number>::from_f64(value)
        };
        let delayed = state.found.map(
            |Found {
                 unknowns: [.., delayed],
                 ..
             }| delayed,
        );
        let present: [_; COLUMNS] = [
            real(Parameter::A),
            real(Parameter::B),
            real(Parameter::Coulomb),
            delayed.unwrap_or_default(),
        ];
        let found = self.windows.find(&state.windows, &present)?;
        if !found.is_finite() {
            return None;
        }
        state.found = Some(found);
        let ([a, b, coulomb, _], [load, _]) = (found.unknowns, found.load);
        let word = |parameter, value: N::Real| {
            let exponent = self.scales.estimate(parameter);
            N::signal(value.to_f64(), exponent).saturated()
        };
        Some(GradientCorrection {
            estimates: PerParameter::new(
                word(Parameter::A, a),
                word(Parameter::B, b),
                word(Parameter::Coulomb, coulomb),
                word(Parameter::Load, load),
            ),
        })
    }

    /// Pieces that were lost on the way.
    #[must_use]
    pub fn lost(&self, state: &GradientMemoryState<N::Real>) -> u32 {
        state.lost
    }

    /// Standard errors and delay, SI.
    #[must_use]
    pub fn report(&self, state: &GradientMemoryState<N::Real>) -> Report {
        let mut report = Report::default();
        let Some(found) = &state.found else {
            return report;
        };
        let root = |variance: N::Real| libm::sqrt(variance.to_f64().max(0.0));
        let ([a, b, c, delayed], [_, load]) = (found.variances.map(root), found.load);
        let [_, gain, _, lag] = found.unknowns.map(<N::Real as Number>::to_f64);
        let mut set = |unknown: Unknown, error: f64| {
            if let Some(place) = report.standard_errors.get_mut(unknown as usize) {
                *place = Some(error / unknown.scale(&self.units));
            }
        };
        set(Unknown::A, a);
        set(Unknown::B, b);
        set(Unknown::Coulomb, c);
        set(Unknown::Load, root(load));
        if gain > 0.0 {
            let delay = lag / gain;
            set(Unknown::Delay, libm::hypot(delayed, delay * b) / gain);
            report.delay = Some(delay * self.units.sample_time());
        }
        report
    }
}
