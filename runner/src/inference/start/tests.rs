//! Standard linear solids under all four indenters: what went in comes out.

use super::*;
use crate::data::random::Random;

const SECONDS: f64 = 100.0;

/// Samples of the closed form of a rig: ramp of `ramp_s` to `depth`, hold, at 100 Hz, then ever wider apart.
fn measured(
    rig: &Rig,
    (equilibrium, branches): (f64, &[(f64, f64)]),
    depth: f64,
    ramp_s: f64,
    noise: f64,
) -> Measurement {
    let mut time_s: Vec<f64> = (0..200).map(|k| 0.01 * ramp_s.max(0.5) * f64::from(k)).collect();
    let mut step = 0.02;
    while time_s[time_s.len() - 1] < SECONDS {
        time_s.push(time_s[time_s.len() - 1] + step);
        step = (step * 1.02).min(1.0);
    }
    let path = [(0.0, 0.0), (ramp_s, depth), (time_s[time_s.len() - 1], depth)];
    let history = relaxation::History::new(&path, &rig.law(depth), &time_s);
    let mut force_n: Vec<f64> = history.elastic().iter().map(|f| equilibrium * f).collect();
    for (tau, shear) in branches {
        force_n.iter_mut().zip(history.relaxed(*tau)).for_each(|(f, r)| *f += shear * r);
    }
    let peak = force_n.iter().copied().fold(0.0, f64::max);
    let mut random = Random::new(5);
    force_n.iter_mut().for_each(|f| *f += noise * peak * random.normal());
    let displacement_m = time_s.iter().map(|t| relaxation::depth_at(&path, *t)).collect();
    Measurement { time_s, displacement_m, force_n, ..Measurement::default() }
}

fn rigs() -> Vec<(Rig, f64)> {
    let wide = Rig {
        face: Face::Flat { radius: 2e-3 },
        sample_radius: 2e-2,
        sample_height: 1e-2,
        bonded_face: true,
        bonded_support: true,
    };
    let plug = Rig { face: Face::Platen, sample_radius: 3e-3, sample_height: 2e-3, ..wide };
    vec![
        (wide, 5e-4),
        (Rig { face: Face::Sphere { radius: 1.5e-4, shank: 1.5e-4 }, ..wide }, 2.1e-4),
        (Rig { face: Face::Cone { half_angle: 1.0, shank: 2e-3 }, ..wide }, 4e-4),
        (plug, 2e-4),
        (Rig { bonded_face: false, bonded_support: false, ..plug }, 2e-4),
    ]
}

fn known(rig: Rig) -> Known {
    Known { rig, lambda_star_pa: 1e5, fluid_viscosity_pa_s: 1e-3 }
}

#[test]
fn a_standard_linear_solid_comes_back_under_every_indenter() {
    for (rig, depth) in rigs() {
        for (equilibrium, shear, tau) in [(10.0, 30.0, 0.3), (3e3, 3e3, 5.0), (4e6, 1e6, 40.0)] {
            let m = measured(&rig, (equilibrium, &[(tau, shear)]), depth, 0.5, 0.003);
            let found = Start::of(&[&m], &known(rig), 1..=MOST_BRANCHES).unwrap();
            let [branch] = found.branches[..] else { panic!("{rig:?} {tau}: {found:?}") };
            for (got, expected) in
                [(found.equilibrium_pa, equilibrium), (branch.shear_pa, shear), (branch.tau_s, tau)]
            {
                assert!((got / expected - 1.0).abs() < 0.1, "{rig:?}: {got} {expected} in {found:?}");
            }
        }
    }
}

#[test]
fn as_many_branches_as_there_are() {
    let truth = [(0.05, 2000.0), (1.0, 1000.0), (20.0, 800.0)];
    for (rig, depth) in rigs() {
        for n in 1..=3 {
            let m = measured(&rig, (500.0, &truth[..n]), depth, 0.2, 0.002);
            let found = Start::of(&[&m], &known(rig), 1..=MOST_BRANCHES).unwrap();
            assert_eq!(found.branches.len(), n, "{rig:?}: {found:?}");
            for (branch, (tau, shear)) in found.branches.iter().zip(truth) {
                let (a, b) = (branch.tau_s / tau, branch.shear_pa / shear);
                assert!((0.6..1.6).contains(&a) && (0.6..1.6).contains(&b), "{rig:?}: {found:?}");
            }
        }
    }
}

#[test]
fn what_the_user_named_stays() {
    let (rig, depth) = rigs()[0];
    let m = measured(&rig, (500.0, &[(1.0, 1000.0)]), depth, 0.2, 0.002);
    let asked = Start::of(&[&m], &known(rig), 2..=MOST_BRANCHES).unwrap();
    assert_eq!(asked.branches.len(), 2);
    assert!((asked.instantaneous_pa() / 1500.0 - 1.0).abs() < 0.2, "{asked:?}");
    let found = Start::of(&[&m], &known(rig), 1..=MOST_BRANCHES).unwrap();
    let all = found.defaults(Mentioned { free: false, lambda_star: false, branch: 0 });
    assert_eq!(all.fixed.len(), MOST_BRANCHES - 1);
    assert!(all.free.contains(&"material.branch[1].eta".to_owned()));
    let named = found.defaults(Mentioned { free: true, lambda_star: false, branch: 1 });
    assert!(named.free.is_empty() && named.fixed.is_empty() && named.start.len() == all.start.len());
}

#[test]
fn a_hidden_branch_takes_the_place_that_is_named() {
    let branches = [(1.0, 100.0), (50.0, 10.0)].map(|(tau_s, shear_pa)| Branch { shear_pa, tau_s });
    let (rig, depth) = rigs()[0];
    let m = measured(&rig, (200.0, &[(1.0, 100.0)]), depth, 0.2, 0.002);
    let told = Start { branches: branches.to_vec(), ..Start::of(&[&m], &known(rig), 2..=2).unwrap() };
    for (dropped, kept) in [(0, branches[1]), (1, branches[0])] {
        let hidden = told.clone().with_hidden_branch(dropped);
        assert_eq!(hidden.branches.len(), 2);
        assert!(
            hidden.branches[0].tau_s < 0.2 * told.shortest_ramp_s && hidden.branches[1] == kept,
            "{hidden:?}"
        );
        assert_eq!(hidden.permeability_m2, told.permeability_m2);
    }
    let ratio = told.clone().slowly_draining().permeability_m2 / told.permeability_m2;
    assert!((ratio / (told.shortest_ramp_s / told.longest_s) - 1.0).abs() < 1e-12, "{ratio}");
}

#[test]
fn a_stiff_sample_frees_the_skeleton_and_a_silent_one_tells_nothing() {
    let (rig, depth) = rigs()[0];
    let m = measured(&rig, (5e4, &[(1.0, 1e4)]), depth, 0.2, 0.0);
    let found = Start::of(&[&m], &known(rig), 1..=MOST_BRANCHES).unwrap();
    assert!((found.lambda_star_pa.unwrap() / 6e5 - 1.0).abs() < 0.2, "{found:?}");
    let silent = Measurement { force_n: vec![0.0; m.len()], ..m };
    assert_eq!(Start::of(&[&silent], &known(rig), 1..=MOST_BRANCHES), None);
}
