//! What the key of a challenge says of a cause: whether anybody could see it.

use poropunch::variables::identifiable;
use runner::challenge::draw::{Drawn, Kind, draw};
use runner::challenge::ground::Ground;
use runner::challenge::oracle::seen;
use runner::data::reader::{Wanted, read};
use runner::engine::{Engine, EngineOptions};
use runner::fit::Problem as _;
use runner::inference::{ForceProblem, Requests, Setup, Transform, Unknowns};
use runner::noise::observation::observe;
use runner::setting::settings_from;
use std::path::Path;

/// Goal: a cause that other parameters do as well is invisible, however far these are. Set-up: the change of the force when all moduli
/// and times are half as large again. Criterion: a refit leaves less than the noise and 0.1 % of the peak,
/// where the derivatives at the true parameters alone call it visible and large.
#[test]
#[ignore = "long: fits of a dozen parameters"]
fn what_other_parameters_do_as_well_is_invisible() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/measurement/table1-one-cycle");
    let measurements =
        ["P1", "P2"].map(|t| read(&folder.join(format!("{t}.csv")), Wanted::MotionAndForce).unwrap());
    let engine = Engine::new(&EngineOptions::default()).unwrap();
    let coarse = ["mesh.preset=coarse".to_owned()];
    let numerics = settings_from(engine.wiring(), &coarse).unwrap();
    let table_1 = identifiable().filter(|(_, i)| i.free).map(|(v, _)| (v.name.to_owned(), v.start_number()));
    let mut drawn: Drawn = draw(1, 1, &[Kind::Null], Ground::Near).remove(0);
    drawn.material = table_1.collect();
    let requests = Requests { set: coarse.to_vec(), ..Requests::default() };
    let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests).unwrap();
    let observations = observe(&measurements, None).unwrap();
    let mut problem = ForceProblem::new(Setup::new(&engine, &observations, &unknowns), &[]);
    let truth = unknowns.start().to_vec();
    let other: Vec<f64> = unknowns
        .variables()
        .iter()
        .zip(&truth)
        .map(|(v, x)| if matches!(v.transform, Transform::Logarithmic { .. }) { x + 0.4 } else { *x })
        .collect();
    assert_ne!(truth, other);
    let (there, here) = (problem.residual(&other).unwrap(), problem.residual(&truth).unwrap());
    let change: Vec<f64> = there.iter().zip(&here).map(|(a, b)| a - b).collect();
    // Beside another cause, here of no size, the refit is linear.
    let nothing = vec![0.0; change.len()];
    let seen = |changes: &[Vec<f64>]| seen(&engine, &drawn, &numerics, &measurements, changes).unwrap()[0];
    let (linear, found) = (seen(&[change.clone(), nothing]), seen(&[change]));
    assert!(linear.score > 6.0 && linear.gap_percent > 1.0, "{linear:?}");
    assert!(found.score < 1.0 && found.gap_percent < 0.1, "{found:?}");
}
