// The loop and its settings, for the build script, which certifies and builds it, and for a comparison on the chip.

use identifier_core::settings::{BoxSettings, SettingsError, diagonal};
use identifier_core::{ControllerSettings, Settings};

#[cfg(not(any(feature = "friction", feature = "gauss-newton")))]
mod estimated {
    pub type Set = identifier_core::parameters::Ab;
    pub const COUNT: usize = 2;
}
#[cfg(all(feature = "friction", not(feature = "gauss-newton")))]
mod estimated {
    pub type Set = identifier_core::parameters::AbCoulomb;
    pub const COUNT: usize = 3;
}

#[cfg(not(any(feature = "fixed-point", feature = "gauss-newton")))]
pub type Loop = identifier_core::GradientLoop<f32, estimated::Set, { estimated::COUNT }>;

#[cfg(feature = "fixed-point")]
pub type Loop = identifier_core::fixed_point::FixedServoLoop<
    identifier_core::measurement::LowPass<identifier_core::fixed_point::Word>,
    estimated::Set,
    { estimated::COUNT },
>;

#[cfg(feature = "gauss-newton")]
pub type Loop = identifier_core::identifier::ServoLoop<
    f32,
    identifier_core::measurement::LowPass<f32>,
    identifier_core::identifier::GaussNewtonRecursion<
        f32,
        identifier_core::parameters::AbCoulombLoad,
        4,
    >,
>;

/// The initial knowledge of the loop besides its configuration.
#[cfg(not(feature = "gauss-newton"))]
pub type Known = ();

/// The servo that is known.
#[cfg(feature = "gauss-newton")]
pub type Known = identifier_core::identifier::PreparedServo<f32>;

/// The constants of the firmware.
pub type Configuration = (Loop, Known);

/// Certifies and builds the loop.
pub fn build() -> Result<Configuration, SettingsError> {
    let mut settings = Settings {
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(1e-3, 10_000.0)
    };
    settings.identifier.plant_box = Some(BoxSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    settings.identifier.gamma = Some(diagonal([20.0, 3000.0, 20.0, 0.0]));
    settings.identifier.bounds.coulomb = Some([0.0, 100.0]);
    let servo_loop: Loop = settings.build()?;
    #[cfg(not(feature = "gauss-newton"))]
    let known = ();
    #[cfg(feature = "gauss-newton")]
    let known = {
        use identifier_core::identifier::ExpectedMotion;
        use identifier_core::parameters::{IdentifiedServo, ServoParameters};
        let servo = IdentifiedServo {
            parameters: ServoParameters {
                a: 2.5,
                b: 250.0,
                coulomb: 0.5,
                load: 0.0,
            },
            delay: 0.0,
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| {
                    if i == j {
                        [0.1, 20.0, 0.5, 0.0, 1.0][i]
                    } else {
                        0.0
                    }
                })
            }),
            unexplained: 2e-4,
        };
        let motion = ExpectedMotion {
            bandwidth: 30.0,
            command: 1.0,
        };
        servo_loop.identifier().prepare(&servo, &motion)
    };
    Ok((servo_loop, known))
}
