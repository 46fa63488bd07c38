use identifier_core::parameters::ServoParameters;

use crate::scenario::{Fault, Scenario};

/// A servo and its surroundings, as a scenario whose estimator does not matter.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name.
    pub name: &'static str,
    /// Its conditions.
    pub detail: String,
    /// The scenario.
    pub scenario: Scenario,
}

impl Case {
    /// The cases of a scenario. The first is its servo without load and friction. Then comes one thing at a time from
    /// the `[compare]` table, then all of them.
    ///
    /// # Errors
    /// The servo is not given.
    pub fn all(base: &Scenario) -> Result<Vec<Self>, Fault> {
        let with = &base.compare;
        let servo = base.servo()?;
        let bare = ServoParameters {
            coulomb: 0.0,
            load: 0.0,
            ..servo
        };
        let load = with.load.unwrap_or(0.08 * servo.b);
        let coulomb = with.coulomb.unwrap_or(0.04 * servo.b);
        let counts = with.counts_per_rev;
        let limit = with.limit.unwrap_or(base.controller().kp / 9.0);
        let case = |name, detail: String, plant, coarse: bool, saturated: bool| {
            let mut scenario = base.clone();
            scenario.plant = Some(plant);
            scenario.effects = base.effects.carried_over(&servo, &plant);
            if coarse {
                scenario.set_encoder(counts);
            }
            if saturated {
                let controller = scenario.stated.controller;
                scenario.stated.controller = controller.map(|own| own.limited(limit));
            }
            Self {
                name,
                detail,
                scenario,
            }
        };
        let loaded = ServoParameters { load, ..bare };
        let rubbing = ServoParameters { coulomb, ..bare };
        let both = ServoParameters { coulomb, ..loaded };
        let nothing = "no load, no friction, the scenario's encoder and amplifier";
        Ok(vec![
            case("as it should be", nothing.to_owned(), bare, false, false),
            case("load", format!("d = {load} rad/s²"), loaded, false, false),
            case(
                "friction",
                format!("c = {coulomb} rad/s²"),
                rubbing,
                false,
                false,
            ),
            case(
                "coarse encoder",
                format!("{counts} counts per revolution"),
                bare,
                true,
                false,
            ),
            case("saturation", format!("|u| ≤ {limit}"), bare, false, true),
            case(
                "all together",
                "load, friction, coarse encoder and saturation".to_owned(),
                both,
                true,
                true,
            ),
        ])
    }
}
