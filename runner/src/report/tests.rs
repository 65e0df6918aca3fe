//! A report of a small exact problem: force `g exp(-t / tau)`, offset by a known noise pattern.

use super::*;
use crate::fit::StopReason;
use crate::inference::cases::{fit_of, positive};
use crate::inference::derived::{DerivedQuantity, Values};
use crate::inference::parameter::Unit;
use crate::inference::{FitParameter, Statistics, Unknowns};
use nalgebra::{DMatrix, DVector};

const SIGMA: f64 = 0.05;

fn curve(name: &str, role: Role, amplitude: f64) -> MeasuredCurve {
    let time_s: Vec<f64> = (0..120).map(|i| -0.1 + 0.05 * i as f64).collect();
    let model = |t: f64| if t < 0.0 { 0.0 } else { amplitude * (0.4 + 0.6 * (-t / 2.0).exp()) };
    let model_mn: Vec<f64> = time_s.iter().map(|&t| model(t)).collect();
    let noise = |i: usize| if i.is_multiple_of(2) { SIGMA } else { -SIGMA };
    MeasuredCurve {
        name: name.to_owned(),
        file: format!("data/{name}.csv"),
        role,
        provenance: Some("Synthetic: made for a test <b>".to_owned()),
        displacement_mm: time_s.iter().map(|&t| (10.0 * t).min(1.0)).collect(),
        measured_mn: model_mn.iter().enumerate().map(|(i, f)| f + noise(i)).collect(),
        spread_mn: Some(vec![0.2; 120]),
        specimens: vec![SpecimenCurve { name: "s01".into(), force_mn: vec![1.0; 120] }],
        sigma_mn: vec![SIGMA; 120],
        chi_square: 120.0,
        model_solid_mn: Some(model_mn.iter().map(|f| 0.7 * f).collect()),
        model_fluid_mn: Some(model_mn.iter().map(|f| 0.3 * f).collect()),
        model_mn,
        time_s,
    }
}

fn report() -> FitReport {
    let unit = || Unit::new("Pa", 1.0);
    let parameters = [
        FitParameter::new("material.mu", "mu_1", unit(), -100.0, [-1e3, -1.0]).unwrap(),
        FitParameter::new("material.alpha", "alpha_1", Unit::new("", 1.0), -5.0, [-30.0, -1.0]).unwrap(),
    ];
    let fitted = curve("P2", Role::Fit, 12.0);
    let unknowns = Unknowns::of(parameters.to_vec());
    let gap = DVector::from_fn(120, |i, _| fitted.measured_mn[i] - fitted.model_mn[i]);
    let mut fit = fit_of(&unknowns, DMatrix::from_fn(120, 2, |i, _| fitted.model_mn[i]), gap, SIGMA);
    fit.solution.stop = StopReason::ChiSquareChange;
    let derived = [DerivedQuantity {
        name: "shear_modulus[1]".to_owned(),
        symbol: "G_1".to_owned(),
        formula: "mu_1 alpha_1 / 2".to_owned(),
        unit: unit(),
        evaluate: Box::new(|v: &Values| Some(0.5 * v.get("material.mu")? * v.get("material.alpha")?)),
    }];
    Assembly {
        given: Given {
            title: "Identification of a test".to_owned(),
            created: "2026-01-01T00:00:00Z".to_owned(),
            command: "runner identify data/P2.csv".to_owned(),
            model: "test".to_owned(),
            runs: RunStatistics { runs: 40, cache_hits: 3, failed: 1, ..RunStatistics::default() },
            ..Given::default()
        },
        unknowns: &unknowns,
        fit: &fit,
        statistics: Statistics::new(&unknowns, &fit, &[120]).unwrap(),
        stretches: &[120],
        profiles: vec![],
        far_points: None,
        derived: &derived,
        complete: &|_| {},
        first_holds: vec![],
        curves: vec![fitted, curve("P1", Role::Validation, 11.0)],
    }
    .build()
    .unwrap()
}

#[test]
fn characteristic_numbers_and_chi_square() {
    let report = report();
    let p2 = &report.measurements[0];
    assert!((p2.chi_square_per_point - 1.0).abs() < 1e-12);
    assert!((p2.rms_mn - SIGMA).abs() < 1e-12);
    let end = 0.4 + 0.6 * f64::exp(-(-0.1 + 0.05 * 119.0) / 2.0);
    let peak = p2.curve.model_mn.iter().copied().fold(0.0, f64::max);
    assert!((p2.relaxation_percent.model - 100.0 * (1.0 - 12.0 * end / peak)).abs() < 1e-9);
    assert_eq!(report.ratios.len(), 1);
    assert_eq!(report.ratios[0].name, "peak P2 / peak P1");
    assert!((report.ratios[0].value.model - 12.0 / 11.0).abs() < 1e-12);
}

#[test]
fn the_verdict_says_what_is_not_determined_and_that_data_are_synthetic() {
    let verdict = report().verdict;
    assert!(verdict.headline.starts_with("The data determine none of the 2 free parameters by itself"));
    assert!(verdict.headline.contains("but the combination G_1"), "{}", verdict.headline);
    assert!(verdict.headline.contains("meets the data to their noise"), "{}", verdict.headline);
    assert!(verdict.undetermined[0].contains("mu_1 and alpha_1 enter almost only as G_1"));
    assert!(verdict.warnings.iter().any(|w| w.contains("synthetic")));
    assert!(verdict.warnings.iter().any(|w| w.contains("1 of 40 simulations failed")));
}

#[test]
fn json_round_trip_is_exact_and_versioned() {
    let report = report();
    let json = serde_json::to_string_pretty(&report).unwrap();
    assert!(json.contains(r#""schema": "poropunch.fit-report/1""#));
    assert!(serde_json::from_slice::<FitReport>(json.as_bytes()).unwrap() == report);
}

#[test]
fn the_page_is_self_contained_and_escaped() {
    let html = page(&report());
    assert!(html.contains("made for a test &lt;b&gt;"));
    for outside in ["<script ", " src=", "<link", " href=\"", "@import", "url(http"] {
        assert!(!html.contains(outside), "{outside}");
    }
    // Fig. 6 A (also narrow), B, C, two of Fig. 7, two residual plots, heat map, two interval bars.
    assert_eq!(html.matches("<svg").count(), 11);
    assert!(html.contains("μ₁") && html.contains("Synthetic data") && !html.contains("NaN"));
}

#[test]
fn the_page_explains_its_words_and_fits_narrow_and_dark_screens() {
    let html = page(&report());
    for part in [
        "prefers-color-scheme: dark",
        "max-width: 620px",
        "data-label=\"95 % interval\"",
        "<dt>evidence</dt>",
        "every specimen",
    ] {
        assert!(html.contains(part), "no {part}");
    }
    // Two tests with one specimen each, in both shapes of Fig. 6 A and in B.
    assert_eq!(html.matches("stroke-opacity=\"0.3\"").count(), 6);
    // What the script reads stands in the figures: axes and what each series is.
    assert!(html.contains("data-x=\"log ") && html.contains("data-told=\"P2 measured\""));
}

#[test]
fn the_fastest_branch_comes_first() {
    let mut report = report();
    for (k, p) in report.parameters.iter_mut().enumerate() {
        p.name = format!("material.branch[{}].eta", k + 1);
    }
    let times = [("tau_1", 5.0), ("tau_2", 0.1)];
    let derived = report.derived[0].clone();
    report.derived.extend(times.map(|(s, value)| DerivedRow {
        symbol: s.to_owned(),
        value,
        ..derived.clone()
    }));
    let html = page(&report);
    let at = |name: &str| html.find(name).unwrap();
    assert!(at("material.branch[2].eta") < at("material.branch[1].eta"));
}

#[test]
fn tables_hold_every_number_once() {
    let report = report();
    let curves = curves_csv(&report);
    assert_eq!(curves.lines().count(), 1 + 240);
    assert!(curves.lines().all(|l| l.split(',').count() == 10));
    let parameters = parameters_csv(&report);
    assert_eq!(parameters.lines().count(), 1 + 3);
    assert!(parameters.lines().all(|l| l.split(',').count() == 10), "{parameters}");
    let text = table(&report);
    assert!(text.contains("Not determined:") && text.contains("material.alpha"), "{text}");
}

#[test]
fn curves_of_different_length_are_refused() {
    let mut broken = curve("P2", Role::Fit, 1.0);
    broken.model_mn.pop();
    let unknowns = positive(&[("g", 1.0, [0.1, 10.0])]);
    let fit = fit_of(&unknowns, DMatrix::zeros(3, 1), DVector::zeros(3), 1.0);
    let assembly = Assembly {
        given: Given::default(),
        unknowns: &unknowns,
        fit: &fit,
        statistics: Statistics::new(&unknowns, &fit, &[]).unwrap(),
        stretches: &[],
        profiles: vec![],
        far_points: None,
        derived: &[],
        complete: &|_| {},
        first_holds: vec![],
        curves: vec![broken],
    };
    assert!(assembly.build().is_err());
}
