//! A pass of the model over a record, with the derivatives of its output error.

use super::acting::Acting;
use super::coupling::Coupling;
use super::front_end::{Current, FrontEnd, Part};
use super::gain::{Diffuse, Riccati};
use super::state::{OwnResonance, Response, State, Tangents};
use super::twisting::Twisting;
use super::waves::Waves;
use super::{Column, Effect, Horizon, Record, Values};

/// The most columns of a pass.
pub const MAX_COLUMNS: usize = 72;

/// A sample of a pass.
#[derive(Debug)]
pub struct Row<'a> {
    /// The sample.
    pub sample: usize,
    /// The innovation: measured less predicted position, counts.
    pub innovation: f64,
    /// Its variance over that of a measurement.
    pub variance: f64,
    /// The load that walks, counts/sample².
    pub walk: f64,
    /// The predicted position per unit of each column, counts.
    pub regressor: &'a [f64],
}

/// The model loop: the recorded command drives the servo's model, and a Kalman filter keeps it with the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelPass<'a> {
    /// The record.
    pub record: &'a Record<'a>,
    /// The horizon of the filter.
    pub horizon: Horizon,
    /// Viscous friction in the filter's own model, 1/sample. It is not a parameter of the fit, so that the filter stays
    /// constant during the search.
    pub damping: f64,
    pub(super) diffuse: Diffuse,
    /// Of a model that runs free: for each motion its distance from the record (counts, measured less model) and its
    /// velocity at the beginning. None if the filter keeps it with the record.
    pub starts: Option<&'a [[f64; 2]]>,
}

/// Innovations beyond this end a pass, counts.
const DIVERGED: f64 = 1e9;

impl ModelPass<'_> {
    /// Runs the model with some values over the record and shows every sample to `observe`. Returns false
    /// if the model ran away.
    pub fn run(
        &self,
        values: &Values,
        columns: &[Column],
        observe: &mut dyn FnMut(&Row<'_>),
    ) -> bool {
        let is_plain = values.is_plain() && columns.iter().all(|column| column.effect.is_base());
        match (is_plain, columns.len()) {
            (true, 0..=5) => self.run_with::<5, true>(values, columns, observe),
            (_, 0..=8) => self.run_with::<8, false>(values, columns, observe),
            (_, 9..=16) => self.run_with::<16, false>(values, columns, observe),
            _ => self.run_with::<MAX_COLUMNS, false>(values, columns, observe),
        }
    }

    fn run_with<const C: usize, const PLAIN: bool>(
        &self,
        values: &Values,
        asked: &[Column],
        observe: &mut dyn FnMut(&Row<'_>),
    ) -> bool {
        let asked = &asked[..asked.len().min(C)];
        let base = Effect::BASE.map(Column::from);
        // A plain model has all columns at fixed places: of which effect one is takes no time then.
        let columns = if PLAIN { &base[..] } else { asked };
        let place_of = |effect| columns.iter().position(|one| one.effect == effect);
        let mut places = [0; C];
        for (place, one) in places.iter_mut().zip(asked) {
            *place = place_of(one.effect).unwrap_or(0);
        }
        let front_end = FrontEnd::new(values, columns);
        let mut waves = Waves::new(columns);
        let has_backlash = values.get(Effect::Backlash) != 0.0
            || columns
                .iter()
                .any(|column| column.effect == Effect::Backlash);
        let mut regressor = [0.0; C];
        let mut ordered = [0.0; C];
        let mut responses = [Response::default(); 2];
        let resonances: Vec<OwnResonance> = if PLAIN {
            Vec::new()
        } else {
            columns.iter().map(OwnResonance::of).collect()
        };
        for (number, motion) in self.record.motions().enumerate() {
            let start = self.starts.and_then(|starts| starts.get(number));
            let [error, velocity] = start.copied().unwrap_or_default();
            let mut state = State::<C, PLAIN> {
                error,
                velocity,
                load: 0.0,
                acceleration: 0.0,
                twisting: Twisting::NONE,
                backlash: 0.0,
                has_backlash,
                columns,
                resonances: &resonances,
                delay: place_of(Effect::Delay),
                tangents: Tangents::NONE,
                responses: &mut responses,
            };
            let mut current = Current::default();
            let mut filter = Riccati::new(self.damping, self.horizon, &self.diffuse);
            for sample in motion.0..motion.1 {
                if self.record.is_measured(sample - motion.0) {
                    filter.measure();
                    let wave = if PLAIN {
                        [0.0; 2]
                    } else {
                        self.record.wave_since(motion.0, sample)
                    };
                    let innovation = state.innovation(values, wave, &mut regressor);
                    if innovation.is_nan() || innovation.abs() > DIVERGED {
                        return false;
                    }
                    let shown = if PLAIN {
                        for (ordered, &place) in ordered.iter_mut().zip(&places) {
                            *ordered = regressor[place];
                        }
                        &ordered
                    } else {
                        &regressor
                    };
                    observe(&Row {
                        sample,
                        innovation,
                        variance: filter.variance,
                        walk: state.load,
                        regressor: &shown[..asked.len()],
                    });
                    if self.starts.is_none() {
                        state.correct(&filter.gain, innovation, &regressor);
                    }
                }
                filter.predict();
                let mut parts = front_end.recorded(self.record, motion, sample);
                if !PLAIN {
                    front_end.process(self.record, &mut parts, &mut current);
                    waves.place(self.record.wave(sample, 1.0));
                }
                self.advance(
                    values,
                    &front_end,
                    &parts,
                    &waves,
                    (motion, sample),
                    &mut state,
                );
                if !PLAIN {
                    state.twist_columns();
                }
                if sample + 1 < motion.1 {
                    state.error += self.record.increment(sample);
                }
            }
        }
        true
    }

    #[inline]
    fn advance<const C: usize, const PLAIN: bool>(
        &self,
        values: &Values,
        front_end: &FrontEnd,
        parts: &[Part; 2],
        waves: &Waves,
        (motion, sample): ((usize, usize), usize),
        state: &mut State<'_, C, PLAIN>,
    ) {
        use Effect::{
            B, Backlash, Coulomb, FrictionDrift, GainDrift, InertiaCosine, InertiaSine,
            LoadFriction, TorqueRippleCosine, TorqueRippleSine,
        };
        let record = self.record;
        let passed = sample as f64 / record.len() as f64 - 0.5;
        let extra = |effect| State::<C, PLAIN>::extra(values, effect);
        let has = |one: Effect, other: Effect| extra(one) != 0.0 || extra(other) != 0.0;
        // The record's angle stands in for the model's where a filter keeps them together.
        let ahead = match self.starts {
            Some(_) if !PLAIN && record.radian > 0.0 => {
                let grown = 0.5 * (record.increment(sample) - state.velocity);
                (state.error + grown) / record.radian
            }
            _ => 0.0,
        };
        let along = |one: Effect, other: Effect, order: f64| {
            let [sine, cosine] = record.wave(sample, order);
            let of_record = values.get(one) * sine + values.get(other) * cosine;
            if ahead == 0.0 {
                return of_record;
            }
            let across = values.get(one) * cosine - values.get(other) * sine;
            of_record * libm::cos(order * ahead) - across * libm::sin(order * ahead)
        };
        let drifted = |effect| match extra(effect) {
            0.0 => 1.0,
            change => 1.0 + change * passed,
        };
        let mut load = values.get(Effect::Load) + state.load;
        for ([sine, cosine], order) in Effect::FORCES.into_iter().zip(values.orders) {
            if has(sine, cosine) {
                load += along(sine, cosine, order);
            }
        }
        let mut gain = values.get(B) * drifted(GainDrift);
        let mut per_ripple = 1.0;
        if has(TorqueRippleSine, TorqueRippleCosine) {
            let ripple = 1.0 + along(TorqueRippleSine, TorqueRippleCosine, values.gain_order);
            gain *= ripple;
            per_ripple = 1.0 / ripple;
        }
        let (mut per_inertia, mut inertia_change) = (1.0, 0.0);
        if has(InertiaSine, InertiaCosine) {
            let order = values.inertia_order;
            per_inertia = 1.0 / (1.0 + along(InertiaSine, InertiaCosine, order)).max(0.1);
            let [sine, cosine] = record.wave_change(motion, sample, order);
            inertia_change = values.get(InertiaSine) * sine + values.get(InertiaCosine) * cosine;
        }
        let coupling = if PLAIN { None } else { Coupling::of(values) };
        let per_motor = coupling.map_or(1.0, |coupling| coupling.motor_inertia_inverse());
        let motor_inertia_inverse = per_inertia * per_motor;
        let drift = f64::max(drifted(FrictionDrift), 0.0);
        let before = state.velocity;
        // With a stiff shaft the derivatives of the accelerations are not visible.
        let twists = extra(Effect::Compliance) != 0.0;
        if twists {
            state.tangents.acceleration = state.tangents.velocity;
        }
        let error = state.error;
        let errors = if state.has_backlash() {
            state.tangents.error
        } else {
            [0.0; C]
        };
        let mut last = None;
        for (i, part) in parts.iter().enumerate() {
            let drive = gain * part.command * motor_inertia_inverse;
            let effort = (gain * motor_inertia_inverse).abs() * part.size;
            let mut coulomb = values.get(Coulomb) * motor_inertia_inverse * drift;
            if !PLAIN {
                coulomb += values.get(LoadFriction) * effort * drift;
            }
            let mut acting = Acting {
                values,
                front_end,
                part,
                motion,
                sample,
                record,
                waves,
                length: front_end.lengths[i],
                gain: gain * motor_inertia_inverse,
                drive,
                effort,
                push: drive + load * motor_inertia_inverse,
                coulomb,
                drift,
                motor_inertia_inverse,
                per_inertia,
                per_motor,
                friction: drift * motor_inertia_inverse,
                inertia_change,
                per_ripple,
                passed,
            };
            // Behind a current loop the command has a slope and no step.
            if let (Some(earlier), Some(place)) = (last, state.delay())
                && (PLAIN || !front_end.has_lag())
            {
                let held = coupling.map_or(0.0, |coupling| coupling.holds(&state.twisting));
                state.pass_step(&acting, earlier, motor_inertia_inverse * held, place);
            }
            last = Some(acting.push);
            if acting.length > 0.0 {
                state.advance(coupling.as_ref(), &mut acting);
            }
        }
        state.acceleration = state.velocity - before;
        if twists {
            for i in 0..C {
                let tangents = &mut state.tangents;
                tangents.acceleration[i] = tangents.velocity[i] - tangents.acceleration[i];
            }
        }
        if state.has_backlash() {
            state.take_up_backlash(extra(Backlash), error - state.error, &errors);
        }
    }
}
