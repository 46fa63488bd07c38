use identifier_core::control::{ControlState, Controller};
use identifier_core::fixed_point::{
    FixedControlState, FixedGradientIdentifier, FixedGradientState, FixedVelocity,
    reference_of_counts,
};
use identifier_core::identifier::{GradientIdentifier, GradientIdentifierState, IdentifierError};
use identifier_core::measurement::origin::Origin;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;
use identifier_core::units::Units;

use crate::scenario::fixed::{Choose, FixedParts, WithFixed};
use crate::scenario::{GradientSettings, Law, Reference, Scenario, WithSet, WithVelocity};

/// The number formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Double precision, what the others are held against.
    F64,
    /// Single precision.
    F32,
    /// Fixed point.
    Fixed,
}

impl Format {
    /// All of them, the reference first.
    pub const ALL: [Self; 3] = [Self::F64, Self::F32, Self::Fixed];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
            Self::Fixed => "fixed",
        }
    }
}

/// What a format makes of a sample, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signals {
    /// Velocity estimate, rad/s.
    pub velocity: f64,
    /// Command, command units.
    pub command: f64,
    /// Output error, rad.
    pub output_error: f64,
    /// The estimates.
    pub estimates: ServoParameters,
}

/// Controller and identifier of one format.
pub(super) trait Beside {
    /// One sample: reference and position, counts.
    fn process(&mut self, reference: f64, position: i64) -> Signals;
}

/// Those of a floating-point format, at rest at a count.
pub(super) fn floating<N: Number>(
    scenario: &Scenario,
    position: i64,
) -> Result<Box<dyn Beside>, IdentifierError> {
    let units = &scenario.controller.units;
    let work = WithFilter { scenario, position };
    scenario.controller.velocity.with::<N, _>(units, work)?
}

struct WithFilter<'a> {
    scenario: &'a Scenario,
    position: i64,
}

impl<N: Number> WithVelocity<N> for WithFilter<'_> {
    type Output = Result<Box<dyn Beside>, IdentifierError>;

    fn with<V: VelocityEstimate<N> + 'static>(self, velocity: V) -> Self::Output {
        let Self { scenario, position } = self;
        scenario.identifier.model_set().with(WithParameters {
            scenario,
            position,
            velocity,
            number: std::marker::PhantomData::<N>,
        })
    }
}

struct WithParameters<'a, N, V> {
    scenario: &'a Scenario,
    position: i64,
    velocity: V,
    number: std::marker::PhantomData<N>,
}

impl<N: Number, V: VelocityEstimate<N> + 'static> WithSet for WithParameters<'_, N, V> {
    type Output = Result<Box<dyn Beside>, IdentifierError>;

    fn with<S: ParameterSet<P> + 'static, const P: usize, const Q: usize>(self) -> Self::Output {
        let Self {
            scenario,
            position,
            velocity,
            ..
        } = self;
        let units = scenario.controller.units;
        let settings = match &scenario.identifier.law {
            Law::Gradient(settings) | Law::PdGradient(settings) => settings.clone(),
            _ => GradientSettings::default(),
        };
        let played = Reference::<f64>::new(&units, &scenario.excitation)?;
        let law = scenario.gradient_law::<S, P>(&settings, &played)?;
        let config = scenario.identifier_config();
        let identifier = GradientIdentifier::<N, V, S, P>::new(&config, &law, velocity)?;
        Ok(Box::new(Floating {
            controller: scenario.controller::<N, V>(velocity),
            control: ControlState::at_rest(N::ZERO),
            state: identifier.start(),
            identifier,
            origin: Origin::new(position),
            units,
        }))
    }
}

struct Floating<N: Number, V: VelocityEstimate<N>, S, const P: usize> {
    controller: Controller<N, V>,
    control: ControlState<N, V::State>,
    identifier: GradientIdentifier<N, V, S, P>,
    state: GradientIdentifierState<N, V::State, P>,
    origin: Origin,
    units: Units,
}

impl<N, V, S, const P: usize> Beside for Floating<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    fn process(&mut self, reference: f64, position: i64) -> Signals {
        if let Some(moved) = self.origin.follow::<N>(position) {
            self.control.shift_origin(moved);
        }
        let (velocity, command, output_error) = self
            .controller
            .process(
                &mut self.control,
                N::from_f64(reference - self.origin.count() as f64),
                self.origin.position(position),
            )
            .map_or((f64::NAN, f64::NAN, f64::NAN), |real| {
                let seen = self.identifier.process(&mut self.state, &real);
                (
                    real.velocity.to_f64(),
                    real.command.to_f64(),
                    seen.output_error.to_f64(),
                )
            });
        Signals {
            velocity: velocity / self.units.velocity(),
            command,
            output_error: output_error * self.units.position_unit(),
            estimates: self.identifier.estimates(&self.state),
        }
    }
}

/// Those of fixed point, at rest at a count.
pub(super) fn fixed(
    scenario: &Scenario,
    position: i64,
) -> Result<Box<dyn Beside>, IdentifierError> {
    Choose { scenario }.with(BuildFixed {
        units: scenario.controller.units,
        position,
    })
}

struct BuildFixed {
    units: Units,
    position: i64,
}

impl WithFixed for BuildFixed {
    type Output = Box<dyn Beside>;

    fn with<W, V, S, const P: usize>(
        self,
        parts: FixedParts<V, S, P>,
    ) -> Result<Box<dyn Beside>, IdentifierError>
    where
        W: VelocityEstimate<f64>,
        V: FixedVelocity + 'static,
        S: ParameterSet<P> + 'static,
    {
        let FixedParts { identifier, .. } = parts;
        Ok(Box::new(Words {
            control: identifier.controller().start(self.position),
            state: identifier.start(),
            identifier,
            units: self.units,
        }))
    }
}

struct Words<V: FixedVelocity, S, const P: usize> {
    control: FixedControlState<V::State>,
    identifier: FixedGradientIdentifier<V, S, P>,
    state: FixedGradientState<V::State, P>,
    units: Units,
}

impl<V: FixedVelocity, S: ParameterSet<P>, const P: usize> Beside for Words<V, S, P> {
    fn process(&mut self, reference: f64, position: i64) -> Signals {
        let controller = self.identifier.controller();
        let real = controller.process(&mut self.control, reference_of_counts(reference), position);
        let seen = self.identifier.process(&mut self.state, &real);
        Signals {
            velocity: controller.velocity(&real) / self.units.velocity(),
            command: controller.command(&real),
            output_error: self.identifier.output_error(&seen) * self.units.position_unit(),
            estimates: self.identifier.estimates(&self.state),
        }
    }
}
