//! A measured log: the Electro-Mechanical Positioning System of A. Janot, M. Gautier and M. Brunot
//! (Workshop on Nonlinear System Identification Benchmarks, 2019; nonlinearbenchmark.org).
//!
//! The log is not part of this project. Put `emps_train.csv.gz` (columns t_s, q_ref_m, q_m, vir_V)
//! where `EMPS_LOG` says, or in `shared/data/emps` beside the project.

use std::path::{Path, PathBuf};

use host_sim::replay::{Log, replay};
use host_sim::report::{Summariser, Summary};
use host_sim::scenario::{Purpose, Scenario};
use identifier_core::units::Units;

/// Force per command, N/V: known.
const FORCE: f64 = 35.150_651_882_485_47;

/// Published off-line reference (inverse model, zero-phase filtering): M kg, Fv N/(m/s), Fc N, OF N.
const PUBLISHED: [f64; 4] = [95.1089, 203.5034, 20.3935, -3.1648];

/// Published standard deviations of the same.
const DEVIATIONS: [f64; 4] = [0.1085, 1.1460, 0.1012, 0.0444];

fn log_path() -> Option<PathBuf> {
    let path = std::env::var_os("EMPS_LOG").map_or_else(
        || {
            PathBuf::from(env!("CARGO_MANIFEST_DIR"))
                .join("../../shared/data/emps/emps_train.csv.gz")
        },
        PathBuf::from,
    );
    path.exists().then_some(path)
}

/// One causal pass from the published values times these factors.
fn identify(path: &Path, factors: [f64; 4]) -> (Summary, [f64; 4]) {
    let [mass, viscous, coulomb, offset] = std::array::from_fn(|i| PUBLISHED[i] * factors[i]);
    let text = format!(
        "[amplifier]\n\
         limit = 10.0\n\
         [controller]\n\
         kp = {kp}\n\
         kd = 243.45\n\
         ki = 0.0\n\
         sample_time = 0.001\n\
         velocity_filter = {{ kind = \"averaged-difference\" }}\n\
         [identifier]\n\
         law = \"gauss-newton\"\n\
         parameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n\
         initial = {{ a = {a}, b = {b}, coulomb = {c}, load = {d} }}\n\
         arithmetic = \"f64\"\n\
         [log]\n\
         time = \"t_s\"\n\
         reference = \"q_ref_m\"\n\
         position = \"q_m\"\n\
         command = \"vir_V\"\n",
        kp = 160.18 * 243.45,
        a = viscous / mass,
        b = FORCE / mass,
        c = coulomb / mass,
        d = -offset / mass,
    );
    let mut scenario = Scenario::parse("emps", &text, Purpose::Replay).expect("valid");
    let columns = scenario.log.clone().expect("it has a log");
    let log = Log::read(path, &columns, 1e-3).expect("a sound log");
    scenario.controller.units = Units::new(1e-3, log.resolution()).expect("valid");
    let mut summariser = Summariser::lasting(&scenario, log.records.len() as f64 * 1e-3);
    let replayed = replay(&scenario, &log, 1, &mut |sample| summariser.add(sample))
        .expect("the declared controller ran");
    let agreement = replayed.agreement.expect("the log has a command");
    assert!(agreement.relative() < 0.01, "{agreement}");
    let summary = summariser.finish(&scenario, replayed.outcome);
    let mass = FORCE / summary.b.last;
    let found = [
        mass,
        summary.a.last * mass,
        summary.coulomb.last * mass,
        -summary.load.last * mass,
    ];
    (summary, found)
}

#[test]
fn one_causal_pass_comes_near_the_published_values() {
    let Some(path) = log_path() else {
        println!("the EMPS log is not here: nothing was tested; see the head of this file");
        return;
    };
    let check = |factors: [f64; 4], tolerances: [f64; 4]| {
        let (_, found) = identify(&path, factors);
        println!("from {factors:?}: M, Fv, Fc, OF = {found:.2?}");
        for i in 0..4 {
            let error = (found[i] - PUBLISHED[i]).abs();
            assert!(error < tolerances[i], "from {factors:?}: {found:?}");
        }
    };
    let three_deviations = DEVIATIONS.map(|deviation| 3.0 * deviation);
    check([1.0, 1.0, 1.0, 1.0], three_deviations);
    check([0.7, 1.3, 0.7, 1.3], three_deviations);
    check([1.5, 0.7, 1.4, 0.5], three_deviations);
    // From further away, to 1, 5, 4 and 5 %.
    let relative = [0.01, 0.05, 0.04, 0.05];
    let tolerances = std::array::from_fn(|i| relative[i] * PUBLISHED[i].abs());
    check([2.0, 0.5, 0.5, 2.0], tolerances);
}
