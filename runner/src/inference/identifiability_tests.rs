//! Analytic responses in which the answer is known by construction.

use super::*;
use crate::inference::cases::{fit_of, positive};
use crate::inference::derived::{self, Values, material_quantities};
use crate::inference::fit::Fit;
use crate::inference::parameter::Unit;
use crate::inference::statistics::Determination;
use crate::inference::unknowns::Unknowns;
use nalgebra::DVector;

fn parameter(name: &str, symbol: &str, value: f64, bounds: [f64; 2]) -> FitParameter {
    FitParameter::new(name, symbol, Unit::new("Pa", 1.0), value, bounds).unwrap()
}

/// Differences from a generalised Maxwell response in units of 0.01, at exact values: the force
/// `F = G_inf + sum G_i exp(-t / tau_i)` sees mu and alpha only as mu alpha / 2, and K0 not at all, but for a
/// faint trace. Fitted under the FMU's names, as a user may want it.
fn maxwell(trace: f64) -> (Unknowns, Fit) {
    let unknowns = Unknowns::of(vec![
        parameter("material.equilibrium.mu", "mu_inf", -217.0, [-1e3, -1.0]),
        parameter("material.equilibrium.alpha", "alpha_inf", -2.0, [-30.0, -1.0]),
        parameter("material.branch[1].mu", "mu_1", -418.0, [-1e3, -1.0]),
        parameter("material.branch[1].alpha", "alpha_1", -13.5, [-30.0, -1.0]),
        parameter("material.branch[1].eta", "eta_1", 3000.0, [1.0, 1e5]),
        parameter("material.permeability", "K0", 2.3e-15, [1e-20, 1e-8]),
    ]);
    let x = unknowns.start().to_vec();
    let scale = 1e-2 * 3000.0;
    let model = |x: &[f64]| {
        let g_inf = 0.5 * (x[0] + x[1]).exp();
        let g_1 = 0.5 * (x[2] + x[3]).exp();
        let tau = x[4].exp() / g_1;
        DVector::from_fn(200, |i, _| {
            let t = 0.05 * i as f64;
            // A faint trace of alpha_1 and K0, far below the noise.
            (g_inf + g_1 * (-t / tau).exp()) / scale + trace * ((x[3] * t).sin() + 10.0 * x[5] * t.cos())
        })
    };
    let mut jacobian = DMatrix::zeros(200, 6);
    for j in 0..6 {
        let at = |h: f64| {
            let mut y = x.clone();
            y[j] += h;
            model(&y)
        };
        jacobian.set_column(j, &((at(1e-6) - at(-1e-6)) / 2e-6));
    }
    let gap = DVector::from_fn(200, |i, _| if (i * i) % 7 < 3 { 0.9 } else { -0.9 });
    let fit = fit_of(&unknowns, jacobian, gap, 1.0);
    (unknowns, fit)
}

fn analyse(trace: f64) -> (Statistics, Vec<DerivedEstimate>, Identifiability) {
    let (unknowns, fit) = maxwell(trace);
    let statistics = Statistics::new(&unknowns, &fit, &[]).unwrap();
    let complete = |v: &mut Values| v.set("material.fluid_viscosity", 0.89e-3);
    let quantities = material_quantities(1, &crate::inference::Resolution::default());
    let derived = derived::estimate(&quantities, &unknowns, &fit.solution.x, &statistics, &complete);
    let analysis = Identifiability::new(&statistics, &derived);
    (statistics, derived, analysis)
}

#[test]
fn products_and_invisible_parameters_are_named() {
    let (statistics, _, analysis) = analyse(1e-5);
    assert_eq!(analysis.findings.len(), 3, "{:#?}", analysis.findings);
    let of = |name: &str| analysis.findings.iter().find(|f| f.parameters.iter().any(|p| p == name)).unwrap();
    let equilibrium = of("material.equilibrium.mu");
    assert_eq!(equilibrium.kind, FindingKind::TradeOff);
    assert_eq!(equilibrium.known_combination.as_deref(), Some("shear_modulus[inf]"));
    assert!(
        equilibrium.text.contains("mu_inf and alpha_inf enter almost only as G_inf = mu_inf alpha_inf / 2")
    );
    assert!(equilibrium.text.contains("each alone is not determined"), "{}", equilibrium.text);
    let branch = of("material.branch[1].alpha");
    assert!(branch.correlation.unwrap() < -0.9999);
    assert!(branch.text.contains("(correlation -1.0000)"), "{}", branch.text);
    assert_eq!(branch.parameters.len(), 2);
    let permeability = of("material.permeability");
    assert_eq!(permeability.kind, FindingKind::Invisible);
    assert!(permeability.text.starts_with("K0 is invisible"), "{}", permeability.text);
    assert_eq!(statistics.estimates[5].determination, Determination::Undetermined);
    // eta_1 is not named among the undetermined; it is among the determined.
    assert!(!analysis.undetermined_names().contains(&"material.branch[1].eta".to_owned()));
    for symbol in ["G_inf = 217 Pa", "G_1 = 2820 Pa", "tau_1 = 1.06 s", "eta_1 = 3000 Pa"] {
        assert!(analysis.determined.iter().any(|d| d.starts_with(symbol)), "{:?}", analysis.determined);
    }
}

/// What a profile determines of a direction is not called undetermined, and a direction of which it determines all is no finding.
#[test]
fn what_a_profile_determines_is_not_called_undetermined() {
    let (mut statistics, derived, _) = analyse(1e-5);
    let mut after = |k: usize| {
        (statistics.terms[k].half_width, statistics.terms[k].determination) =
            (0.1, Determination::Determined);
        let findings = Identifiability::new(&statistics, &derived).findings;
        findings.into_iter().find(|f| f.parameters.iter().any(|p| p == "material.equilibrium.mu"))
    };
    let text = after(0).unwrap().text;
    assert!(text.contains("alpha_inf alone is not determined") && !text.contains("each"), "{text}");
    assert_eq!(after(1), None);
}

/// The modulus's interval by the delta method equals that of a fit whose parameter is the modulus itself.
#[test]
fn delta_method_equals_the_direct_parameterisation() {
    let (unknowns, fit) = maxwell(0.0);
    let (_, derived, _) = analyse(0.0);
    // d/d ln G_1 at fixed eta: the column of mu_1 (alpha_1's is the same); drop the others that are redundant.
    let keep = [0, 2, 4];
    let reduced = Unknowns::of(keep.iter().map(|&j| unknowns.variables()[j].clone()).collect());
    let fit = fit_of(&reduced, fit.jacobian_mn.select_columns(&keep), fit.gap_mn, 1.0);
    let direct = Statistics::new(&reduced, &fit, &[]).unwrap();
    for (name, index) in [("shear_modulus[inf]", 0), ("shear_modulus[1]", 1)] {
        let delta = derived.iter().find(|d| d.name == name).unwrap();
        let expected = direct.estimates[index].half_width;
        let error = (delta.half_width / expected - 1.0).abs();
        // Only the t quantiles differ (194 and 197 degrees of freedom).
        assert!(error < 5e-4, "{name}: {} against {expected}", delta.half_width);
    }
}

#[test]
fn a_known_ratio_without_a_name_is_put_in_words() {
    let unknowns = positive(&[("a", 2.0, [0.1, 100.0]), ("b", 4.0, [0.1, 100.0])]);
    let jacobian = DMatrix::from_fn(30, 2, |i, j| (1.0 + i as f64) * if j == 0 { 1.0 } else { -1.0 });
    let fit = fit_of(&unknowns, jacobian, DVector::from_element(30, 0.5), 1.0);
    let statistics = Statistics::new(&unknowns, &fit, &[]).unwrap();
    let analysis = Identifiability::new(&statistics, &[]);
    assert_eq!(analysis.findings.len(), 1);
    assert!(analysis.findings[0].text.contains("the ratio a / b"), "{}", analysis.findings[0].text);
}

#[test]
fn a_sparse_basis_separates_independent_groups() {
    // Rows mixed from (1, -1, 0, 0, 0) and (0, 0, 1, 2, 0).
    let mixed = DMatrix::from_row_slice(2, 5, &[1.0, -1.0, 0.5, 1.0, 0.0, -1.0, 1.0, 1.0, 2.0, 0.0]);
    let mut basis = sparse_basis(&mixed);
    basis.sort_by(|a, b| b[3].abs().total_cmp(&a[3].abs()));
    for (row, expected) in basis.iter().zip([[0.0, 0.0, 0.5, 1.0, 0.0], [1.0, -1.0, 0.0, 0.0, 0.0]]) {
        let sign = if row[1] > 0.0 { -1.0 } else { 1.0 };
        assert!(row.iter().zip(expected).all(|(a, b)| (sign * a - b).abs() < 1e-12), "{row:?}");
    }
}
