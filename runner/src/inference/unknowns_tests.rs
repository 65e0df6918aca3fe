//! The map between the optimiser's variables and the FMU's parameters.

use super::*;
use crate::fmi::Fmu;
use crate::inference::requests::Defaults;
use crate::pool::wiring::Names;
use approx::assert_relative_eq;

fn unknowns(requests: Requests) -> Result<Unknowns, ParameterError> {
    let fmu = Fmu::builtin().unwrap();
    let wiring = Wiring::new(fmu.description(), &Names::default()).unwrap();
    Unknowns::new(&wiring, true, &requests)
}

fn asked(option: fn(&mut Requests) -> &mut Vec<String>, texts: &[&str]) -> Requests {
    let mut requests = Requests::default();
    option(&mut requests).extend(texts.iter().map(|t| (*t).to_owned()));
    requests
}

fn symbols(unknowns: &Unknowns) -> Vec<&str> {
    unknowns.variables().iter().map(|v| v.symbol.as_str()).collect()
}

const DEFAULT: [&str; 9] =
    ["K0", "G_inf", "alpha_inf", "G_1", "alpha_1", "tau_1", "G_2", "alpha_2", "tau_2 / tau_1"];

#[test]
fn the_start_gives_back_table_1() {
    let u = unknowns(Requests::default()).unwrap();
    assert_eq!(symbols(&u), DEFAULT);
    let values = u.settings(u.start());
    for (name, value) in [
        ("material.equilibrium.mu", -217.0),
        ("material.equilibrium.alpha", -2.16),
        ("material.branch[1].mu", -418.0),
        ("material.branch[1].eta", 50.6),
        ("material.branch[2].mu", -161.0),
        ("material.branch[2].eta", 4680.0),
    ] {
        assert_relative_eq!(values[name], value, max_relative = 1e-12);
    }
    let (terms, rows) = u.terms();
    assert_eq!(terms[8].symbol, "tau_2");
    let tau_2: f64 = (rows * nalgebra::DVector::from_column_slice(u.start()))[8].exp();
    assert_relative_eq!(tau_2, 4680.0 / (0.5 * 161.0 * 2.97), max_relative = 1e-12);
}

/// With a tie through which a slope goes on, and an exponent that the user bounds.
#[test]
fn slopes_are_those_of_the_settings() {
    let mut requests = asked(|r| &mut r.tie, &["material.branch[3].eta=material.branch[2].alpha*-7"]);
    requests.bounds = vec!["material.branch[1].alpha=-20:-2".to_owned()];
    let u = unknowns(requests).unwrap();
    let x: Vec<f64> = u.start().iter().enumerate().map(|(j, x)| x + 0.1 * (j as f64).sin()).collect();
    const H: f64 = 1e-6;
    for j in 0..u.len() {
        let at = |h: f64| {
            let mut y = x.clone();
            y[j] += h;
            u.settings(&y)
        };
        let (up, down) = (at(H), at(-H));
        let slopes: BTreeMap<String, f64> = u.slopes(&x, j).into_iter().collect();
        for (name, value) in &up {
            let numeric = (value - down[name]) / (2.0 * H);
            let found = slopes.get(name).copied().unwrap_or(0.0);
            assert!(
                (found - numeric).abs() < 1e-6 * value.abs().max(1e-30),
                "{name} by {j}: {found} {numeric}"
            );
        }
    }
}

/// The slower branch cannot become the faster one, whichever has which number.
#[test]
fn branches_keep_their_order_in_time() {
    let requests =
        asked(|r| &mut r.start, &["material.branch[1].eta=1e5Pa.s", "material.branch[2].eta=2Pa.s"]);
    let u = unknowns(requests).unwrap();
    assert_eq!(symbols(&u)[5], "tau_1 / tau_2");
    for at in [u.bounds().0, u.bounds().1] {
        let values = u.settings(at);
        let time = |i: usize| {
            let of = |name: &str| values[&format!("material.branch[{i}].{name}")];
            of("eta") / (0.5 * of("mu") * of("alpha"))
        };
        assert!(time(1) >= 0.999_999 * time(2), "{} {}", time(1), time(2));
    }
}

#[test]
fn what_the_user_names_is_fitted_under_that_name() {
    let bounded = unknowns(asked(|r| &mut r.bounds, &["material.branch[1].eta=10:100Pa.s"])).unwrap();
    assert_eq!(symbols(&bounded)[3..6], ["mu_1", "alpha_1", "eta_1"]);
    assert_eq!(symbols(&bounded)[8], "tau_2");
    let fixed = unknowns(asked(|r| &mut r.fix, &["material.branch[1].mu=-500Pa"])).unwrap();
    assert_eq!(symbols(&fixed)[3..5], ["alpha_1", "eta_1"]);
    assert_eq!(fixed.settings(fixed.start())["material.branch[1].mu"], -500.0);
    // A fixed exponent leaves modulus and time.
    let exponent = unknowns(asked(|r| &mut r.fix, &["material.branch[1].alpha=-5"])).unwrap();
    assert_eq!(symbols(&exponent)[3..5], ["G_1", "tau_1"]);
    let values = exponent.settings(exponent.start());
    assert_relative_eq!(values["material.branch[1].mu"], -418.0, max_relative = 1e-12);
    let tie = "material.branch[1].alpha=material.branch[1].mu*0.03";
    let tied = unknowns(asked(|r| &mut r.tie, &[tie])).unwrap();
    assert_eq!(symbols(&tied)[3..5], ["mu_1", "eta_1"]);
}

/// What the data say: moduli (Pa) and times (s), exponents at their own start.
fn told(equilibrium_pa: f64, branches: &[(f64, f64)]) -> Requests {
    let mut defaults = Defaults::default();
    let mut group = |prefix: String, modulus_pa: f64, time_s: Option<f64>| {
        let alpha: f64 = -3.0;
        defaults.start.insert(format!("{prefix}.alpha"), (alpha, [-30.0, -1.0]));
        // Bounds of mu and eta are of no account: those of modulus and time follow from their start.
        defaults.start.insert(format!("{prefix}.mu"), (2.0 * modulus_pa / alpha, [-1.0, -0.5]));
        defaults.free.extend([format!("{prefix}.mu"), format!("{prefix}.alpha")]);
        if let Some(time_s) = time_s {
            defaults.start.insert(format!("{prefix}.eta"), (modulus_pa * time_s, [1.0, 2.0]));
            defaults.free.push(format!("{prefix}.eta"));
        }
    };
    group("material.equilibrium".to_owned(), equilibrium_pa, None);
    for (k, (modulus_pa, time_s)) in branches.iter().enumerate() {
        group(format!("material.branch[{}]", k + 1), *modulus_pa, Some(*time_s));
    }
    for k in branches.len() + 1..=4 {
        defaults.fixed.insert(format!("material.branch[{k}].mu"), 0.0);
    }
    defaults.free.push("material.permeability".to_owned());
    defaults.start.insert("material.permeability".to_owned(), (1e-14, [1e-17, 1e-11]));
    Requests { defaults, ..Requests::default() }
}

#[test]
fn the_data_say_where_to_begin_and_how_many_branches_there_are() {
    let u = unknowns(told(1500.0, &[(800.0, 0.3), (600.0, 4.0), (300.0, 90.0)])).unwrap();
    assert_eq!(symbols(&u)[8..], ["G_3", "alpha_3", "tau_3 / tau_2", "K0"]);
    let values = u.settings(u.start());
    assert_relative_eq!(values["material.permeability"], 1e-14, max_relative = 1e-12);
    let modulus = |of: &str| 0.5 * values[&format!("{of}.mu")] * values[&format!("{of}.alpha")];
    assert_relative_eq!(modulus("material.equilibrium"), 1500.0, max_relative = 1e-12);
    let third = "material.branch[3]";
    assert_relative_eq!(values[&format!("{third}.eta")] / modulus(third), 90.0, max_relative = 1e-12);
    assert_eq!(values["material.branch[4].mu"], 0.0);
    let fewer = || told(1500.0, &[(800.0, 0.3)]);
    let u = unknowns(fewer()).unwrap();
    assert_eq!(symbols(&u), ["G_inf", "alpha_inf", "G_1", "alpha_1", "tau_1", "K0"]);
    assert_eq!(u.settings(u.start())["material.branch[2].mu"], 0.0);
    // What the user says wins, beyond what the data allow.
    let u =
        unknowns(Requests { start: vec!["material.permeability=1e-13mm^2".to_owned()], ..fewer() }).unwrap();
    assert_relative_eq!(u.settings(u.start())["material.permeability"], 1e-19, max_relative = 1e-12);
}

/// The same numbers follow the data: a truth ten times away from the start costs less than one unit of chi^2.
#[test]
fn the_prior_of_a_modulus_is_wide() {
    let u = unknowns(Requests::default()).unwrap();
    let mut x = u.start().to_vec();
    let size = |x: &[f64]| -> f64 { u.prior().residual(x).iter().map(|r| r * r).sum() };
    let start = size(&x);
    x[3] += 10f64.ln();
    assert!((size(&x) - start).abs() < 1.0, "{start} {}", size(&x));
}

/// Two branches that the start cannot tell apart, one of them of nearly no modulus, may be any two branches of these data.
#[test]
fn bounds_do_not_follow_how_the_start_shares_the_moduli() {
    let mut requests = told(500.0, &[(5.0, 20.0), (290.0, 21.0)]);
    requests.defaults.times_s = Some([1e-3, 4e4]);
    let u = unknowns(requests).unwrap();
    let (lower, upper) = u.bounds();
    let at = |symbol: &str| symbols(&u).iter().position(|s| *s == symbol).unwrap();
    for symbol in ["G_1", "G_2"] {
        let j = at(symbol);
        assert_relative_eq!(upper[j], (EITHER_WAY * 795.0).ln(), max_relative = 1e-9);
    }
    assert_relative_eq!(lower[at("tau_1")], 1e-3f64.ln(), max_relative = 1e-9);
    assert_relative_eq!(upper[at("tau_2 / tau_1")], 4e7f64.ln(), max_relative = 1e-9);
}
