//! Signature algebra against answers known by hand, and the false accusations of noise alone.

use super::super::unsure_noise::UnsureNoise;
use super::*;
use crate::data::random::Random;
use nalgebra::DMatrix;

/// Whitening by a single deviation.
struct White(f64);

impl Whitening for White {
    fn apply(&self, values: &DVector<f64>) -> DVector<f64> {
        values / self.0
    }

    fn white_part(&self, values: &DVector<f64>) -> DVector<f64> {
        values.clone()
    }
}

/// Two parameters with unit columns along the first axes, prior of deviation `prior`.
fn fit(prior: f64, residual: [f64; 4]) -> Linearised {
    let mut design = DMatrix::zeros(6, 2);
    (design[(0, 0)], design[(1, 1)]) = (1.0, 1.0);
    (design[(4, 0)], design[(5, 1)]) = (1.0 / prior, 1.0 / prior);
    let y = DVector::from_row_slice(&residual).resize_vertically(6, 0.0);
    Linearised::new(design, &y)
}

fn vector(v: [f64; 4]) -> DVector<f64> {
    DVector::from_row_slice(&v)
}

#[test]
fn a_refit_absorbs_what_lies_along_its_parameters() {
    let fit = fit(1e6, [5.0, -3.0, 2.0, 0.0]);
    // Of (3, 0, 4, 0) with noise 0.5 the part 8 along the third axis is left of 10.
    let signature = fit.signature(&White(0.5), &vector([3.0, 0.0, 4.0, 0.0]));
    assert!((signature.norm - 10.0).abs() < 1e-9 && (signature.strength() - 8.0).abs() < 1e-6);
    assert!((signature.absorbed() - 0.2).abs() < 1e-6);
    assert!((signature.score(&fit.residual) - 2.0).abs() < 1e-6);
    let (magnitude, deviation) = signature.magnitude(&fit.residual);
    assert!((magnitude - 0.25).abs() < 1e-6 && (deviation - 0.125).abs() < 1e-6);
}

#[test]
fn a_tight_prior_keeps_the_parameters_from_absorbing() {
    let (loose, tight) = (fit(1e6, [0.0; 4]), fit(1e-6, [0.0; 4]));
    let along = vector([1.0, 0.0, 0.0, 0.0]);
    assert!(loose.signature(&White(1.0), &along).absorbed() > 0.999);
    assert!(tight.signature(&White(1.0), &along).absorbed() < 1e-3);
}

#[test]
fn the_projector_is_one() {
    let fit = fit(0.7, [1.0, 2.0, 3.0, 4.0]);
    let mut random = Random::new(1);
    let v = DVector::from_fn(6, |_, _| random.normal());
    let once = fit.project(&v);
    assert!((fit.project(&once) - &once).norm() < 1e-12);
    assert!(fit.design.tr_mul(&once).norm() < 1e-12);
}

#[test]
fn the_evidence_is_the_ratio_of_the_marginal_likelihoods() {
    // One point beyond the parameters: y ~ N(0, 1) without, N(s m, 1) with an effect of a magnitude m of the Cauchy distribution.
    let (s, y) = (3.0, 4.0);
    let fit = fit(1e6, [0.0, 0.0, y, 0.0]);
    let signature = fit.signature(&White(1.0), &vector([0.0, 0.0, s, 0.0]));
    let density = |m: f64| (-0.5 * (y - s * m).powi(2)).exp() / (std::f64::consts::PI * (1.0 + m * m));
    let sum = |from: i32| (from..4000).map(|k| density(f64::from(k) * 1e-2) * 1e-2).sum::<f64>();
    let evidence = |mean: f64| 2.0 * mean.ln() + y * y;
    let both = signature.evidence(&fit.residual, false);
    assert!((both - evidence(sum(-4000))).abs() < 1e-3, "{both}");
    // Nearly all of the magnitude's posterior is positive: twice the density, twice the evidence.
    let gained = signature.evidence(&fit.residual, true) - both;
    assert!((gained - 2.0 * 2f64.ln()).abs() < 1e-3, "{gained}");
}

#[test]
fn confusable_signatures_are_grouped_through_common_members() {
    let fit = fit(1.0, [0.0; 4]);
    let at = |angle: f64| fit.signature(&White(1.0), &vector([0.0, 0.0, angle.cos(), angle.sin()]));
    // 20 degrees: cosine 0.94; 40 degrees: 0.77; the sign does not matter.
    let degrees = [0.0_f64, 20.0, 220.0, 100.0];
    let signatures: Vec<Signature> = degrees.iter().map(|a| at(a.to_radians())).collect();
    let found = groups(&signatures.iter().collect::<Vec<_>>());
    assert_eq!(found, [vec![0, 1, 2], vec![3]]);
}

/// A cheap model: exponentials in 200 points, five candidate shapes.
struct Cheap {
    design: DMatrix<f64>,
    shapes: Vec<DVector<f64>>,
}

const POINTS: usize = 200;

fn cheap() -> Cheap {
    let t = |i: usize| 0.5 * i as f64;
    let shape = |f: &dyn Fn(f64) -> f64| DVector::from_fn(POINTS, |i, _| f(t(i)));
    let columns = [
        shape(&|_| 8.0),
        shape(&|t| 6.0 * (-t / 20.0).exp()),
        shape(&|t| 6.0 * t / 20.0 * (-t / 20.0).exp()),
    ];
    let mut design = DMatrix::zeros(POINTS + 3, 3);
    for (j, column) in columns.iter().enumerate() {
        design.view_mut((0, j), (POINTS, 1)).copy_from(column);
        design[(POINTS + j, j)] = 0.1;
    }
    let shapes = vec![
        shape(&|t| -0.01 * t),
        shape(&|t| (-t / 200.0).exp()),
        shape(&|t| (-t / 2.0).exp()),
        shape(&|t| if t < 1.0 { 1.0 } else { 0.0 }),
        shape(&|t| (0.1 * t).sin()),
    ];
    Cheap { design, shapes }
}

#[test]
fn scores_of_noise_are_standard_normal_and_rarely_accuse() {
    let model = cheap();
    let plain = Linearised::new(model.design.clone(), &DVector::zeros(POINTS + 3));
    let signatures: Vec<Signature> = model.shapes.iter().map(|d| plain.signature(&White(1.0), d)).collect();
    let all: Vec<&Signature> = signatures.iter().collect();
    let one_sided = [false, true, true, false, false];
    let threshold = Family::new(&all, &one_sided, &UnsureNoise::default(), 11).threshold(0.05);
    let (cases, mut accused) = (2000, 0);
    let mut squares = vec![0.0; all.len()];
    for seed in 0..cases {
        let mut random = Random::new(1000 + seed);
        let noise = DVector::from_fn(POINTS + 3, |_, _| random.normal());
        let fit = Linearised::new(model.design.clone(), &noise);
        let scores: Vec<f64> = all.iter().map(|s| s.score(&fit.residual)).collect();
        squares.iter_mut().zip(&scores).for_each(|(q, z)| *q += z * z);
        let counted = scores.iter().zip(one_sided).map(|(z, one)| if one { *z } else { z.abs() });
        accused += u32::from(counted.fold(0.0, f64::max) > threshold);
    }
    for square in squares {
        let variance = square / cases as f64;
        assert!((0.9..1.1).contains(&variance), "{variance}");
    }
    let rate = f64::from(accused) / cases as f64;
    assert!((0.035..0.065).contains(&rate), "{rate}");
}

#[test]
fn a_planted_effect_has_its_magnitude() {
    let model = cheap();
    let mut scores = vec![];
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let mut y = DVector::from_fn(POINTS + 3, |_, _| random.normal());
        let mut data = y.rows_mut(0, POINTS);
        data += &model.shapes[0] * 30.0;
        let fit = Linearised::new(model.design.clone(), &y);
        let (magnitude, deviation) = fit.signature(&White(1.0), &model.shapes[0]).magnitude(&fit.residual);
        scores.push((magnitude - 30.0) / deviation);
    }
    let mean = scores.iter().sum::<f64>() / 300.0;
    let square = scores.iter().map(|z| z * z).sum::<f64>() / 300.0;
    assert!(mean.abs() < 0.2 && (0.8..1.2).contains(&square), "{mean} {square}");
}

#[test]
fn probability_and_threshold_agree() {
    let model = cheap();
    let plain = Linearised::new(model.design.clone(), &DVector::zeros(POINTS + 3));
    let one = plain.signature(&White(1.0), &model.shapes[0]);
    let family = Family::new(&[&one], &[false], &UnsureNoise::default(), 5);
    assert!((family.threshold(0.05) - 1.96).abs() < 0.08, "{}", family.threshold(0.05));
    assert!((family.probability(family.threshold(0.05)) - 0.05).abs() < 0.01);
    assert!(family.probability(50.0) < 1e-3);
}
