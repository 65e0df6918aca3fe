//! Quantities computed from the parameters, with intervals by the delta method: often the data determine these
//! and not the parameters they are made of.

use super::parameter::Unit;
use super::resolution::Resolution;
use super::statistics::{Determination, Interval, Statistics};
use super::unknowns::Unknowns;
use super::wording::significant;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Named values in SI: free, fixed and tied parameters alike.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Values(BTreeMap<String, f64>);

impl Values {
    /// The value of a parameter, if there is one of that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    /// Sets a value.
    pub fn set(&mut self, name: &str, value: f64) {
        self.0.insert(name.to_owned(), value);
    }
}

impl<S: Into<String>> FromIterator<(S, f64)> for Values {
    fn from_iter<I: IntoIterator<Item = (S, f64)>>(items: I) -> Self {
        Self(items.into_iter().map(|(name, value)| (name.into(), value)).collect())
    }
}

/// Value (SI) of a quantity at given parameters; `None` where it is undefined.
pub type Evaluate = Box<dyn Fn(&Values) -> Option<f64>>;

/// A quantity that depends on named parameters.
pub struct DerivedQuantity {
    /// Full name, e.g. `shear_modulus[1]`.
    pub name: String,
    /// Short symbol, e.g. `G_1`.
    pub symbol: String,
    /// What it is, in symbols, e.g. `mu_1 alpha_1 / 2`.
    pub formula: String,
    /// Unit for people.
    pub unit: Unit,
    /// Value (SI) at given parameters; `None` where it is undefined.
    pub evaluate: Evaluate,
}

/// A derived quantity at the solution, values in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DerivedEstimate {
    /// Full name.
    pub name: String,
    /// Short symbol.
    pub symbol: String,
    /// Formula in symbols.
    pub formula: String,
    /// Unit for people.
    pub unit: Unit,
    /// Value.
    pub value: f64,
    /// 95 % interval.
    pub interval: Interval,
    /// Half of the interval's width in ln(value).
    pub half_width: f64,
    /// How well it is known.
    pub determination: Determination,
    /// Names of the terms that it depends on.
    pub depends_on: Vec<String>,
}

/// Values and intervals of derived quantities at `x`. `complete` adds what nobody set. Quantities that are undefined, zero or
/// independent of every variable are left out.
pub fn estimate(
    quantities: &[DerivedQuantity],
    unknowns: &Unknowns,
    x: &[f64],
    statistics: &Statistics,
    complete: &dyn Fn(&mut Values),
) -> Vec<DerivedEstimate> {
    let values = |x: &[f64]| {
        let mut values: Values = unknowns.settings(x).into_iter().collect();
        complete(&mut values);
        values
    };
    let (terms, rows) = unknowns.terms();
    let back = rows.try_inverse().unwrap_or_else(|| DMatrix::identity(x.len(), x.len()));
    let one = |quantity: &DerivedQuantity| {
        let value = (quantity.evaluate)(&values(x)).filter(|v| v.is_finite() && *v != 0.0)?;
        let mut gradient = DVector::zeros(x.len());
        for j in 0..x.len() {
            let at = |h: f64| {
                let mut y = x.to_vec();
                y[j] += h;
                (quantity.evaluate)(&values(&y)).filter(|v| v.is_finite())
            };
            gradient[j] = (at(H)? - at(-H)?) / (2.0 * H * value);
            if gradient[j].abs() < ROUNDING {
                gradient[j] = 0.0;
            }
        }
        let along = back.tr_mul(&gradient);
        let used = |j: &usize| along[*j].abs() > ROUNDING;
        let depends_on: Vec<_> = (0..x.len()).filter(used).map(|j| terms[j].name.clone()).collect();
        if depends_on.is_empty() {
            return None;
        }
        let moved = |by: &DVector<f64>| {
            let there: Vec<f64> = x.iter().zip(by.iter()).map(|(x, by)| x + by).collect();
            let ratio = (quantity.evaluate)(&values(&there))? / value;
            (ratio > 0.0 && ratio.is_finite()).then(|| ratio.ln())
        };
        let [down, up] = statistics.reach(&gradient, &moved);
        let half_width = 0.5 * (down + up);
        let (a, b) = (value * (-down).exp(), value * up.exp());
        Some(DerivedEstimate {
            name: quantity.name.clone(),
            symbol: quantity.symbol.clone(),
            formula: quantity.formula.clone(),
            unit: quantity.unit.clone(),
            value,
            interval: Interval { lower: a.min(b), upper: a.max(b) },
            half_width,
            determination: Determination::of(half_width)
                .unresolved_if(statistics.resolution.is_arbitrary(&quantity.name)),
            depends_on,
        })
    };
    quantities.iter().filter_map(one).collect()
}

/// Step of the central differences, relative in log parameters.
const H: f64 = 1e-5;
/// A smaller derivative is rounding.
const ROUNDING: f64 = 1e-6;

/// The quantities that the poro-viscoelastic model's response rests on: shear moduli `mu alpha / 2`, instantaneous
/// modulus, sums of what the data do not tell apart, relaxation times `eta / G` of `branches` viscous branches, the relaxation modulus
/// `G(t) = G_inf + sum G_i exp(-t / tau_i)` at a few times of the tests, and the hydraulic conductivity `K0 rho g / mu_FR` of water.
pub fn material_quantities(branches: usize, resolution: &Resolution) -> Vec<DerivedQuantity> {
    let modulus = |prefix: String| {
        move |v: &Values| Some(0.5 * v.get(&format!("{prefix}.mu"))? * v.get(&format!("{prefix}.alpha"))?)
    };
    let time = move |i: usize| {
        move |v: &Values| {
            let prefix = format!("material.branch[{i}]");
            Some(v.get(&format!("{prefix}.eta"))? / modulus(prefix)(v)?)
        }
    };
    let quantity = |name: &str, symbol: &str, formula: &str, unit: (&str, f64)| {
        (name.to_owned(), symbol.to_owned(), formula.to_owned(), Unit::new(unit.0, unit.1))
    };
    let build = |(name, symbol, formula, unit), evaluate: Evaluate| DerivedQuantity {
        name,
        symbol,
        formula,
        unit,
        evaluate,
    };
    let branch = |i: usize| format!("material.branch[{i}]");
    let equilibrium = "material.equilibrium".to_owned();
    let pascal = ("Pa", 1.0);

    let mut all = vec![build(
        quantity("shear_modulus[inf]", "G_inf", "mu_inf alpha_inf / 2", pascal),
        Box::new(modulus(equilibrium.clone())),
    )];
    for i in 1..=branches {
        let (name, symbol) = (format!("shear_modulus[{i}]"), format!("G_{i}"));
        let formula = format!("mu_{i} alpha_{i} / 2");
        all.push(build(quantity(&name, &symbol, &formula, pascal), Box::new(modulus(branch(i)))));
    }
    for [a, b] in resolution.close_pairs() {
        let (a, b) = (a.label.clone(), b.label.clone());
        let (name, formula) = (format!("shear_modulus[{a}+{b}]"), format!("G_{a} + G_{b}"));
        let sum = move |v: &Values| {
            let one = |label: &str| modulus(format!("material.branch[{label}]"))(v);
            Some(one(&a)? + one(&b)?)
        };
        all.push(build(quantity(&name, &formula, &formula, pascal), Box::new(sum)));
    }
    if branches > 0 {
        let equilibrium = equilibrium.clone();
        let total = move |v: &Values| {
            let start = modulus(equilibrium.clone())(v);
            (1..=branches).try_fold(start?, |sum, i| Some(sum + modulus(branch(i))(v)?))
        };
        let formula: String = (1..=branches).map(|i| format!(" + G_{i}")).collect();
        let meta = quantity("shear_modulus[0]", "G_0", &format!("G_inf{formula}"), pascal);
        all.push(build(meta, Box::new(total)));
    }
    for i in 1..=branches {
        let (name, symbol) = (format!("relaxation_time[{i}]"), format!("tau_{i}"));
        all.push(build(quantity(&name, &symbol, &format!("eta_{i} / G_{i}"), ("s", 1.0)), Box::new(time(i))));
    }
    for &t in resolution.told_s.iter().filter(|_| branches > 0) {
        let at = format!("{} s", significant(t, 3).trim_end_matches(".00").trim_end_matches(".0"));
        let (name, symbol) = (format!("relaxation_modulus[{at}]"), format!("G({at})"));
        let equilibrium = equilibrium.clone();
        let relaxed = move |v: &Values| {
            let start = modulus(equilibrium.clone())(v);
            (1..=branches)
                .try_fold(start?, |sum, i| Some(sum + modulus(branch(i))(v)? * (-t / time(i)(v)?).exp()))
        };
        let meta = quantity(&name, &symbol, "relaxation modulus", pascal);
        all.push(build(meta, Box::new(relaxed)));
    }
    let conductivity = |v: &Values| {
        Some(v.get("material.permeability")? * WATER_WEIGHT / v.get("material.fluid_viscosity")?)
    };
    let meta = quantity("hydraulic_conductivity", "k_f", "K0 rho g / mu_FR", ("m/s", 1.0));
    all.push(build(meta, Box::new(conductivity)));
    all
}

/// Specific weight of water, rho g [N/m^3].
const WATER_WEIGHT: f64 = 1000.0 * 9.81;

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Table 1 of the paper: moduli 234, 2820, 239 Pa; times 0.018 and 19.6 s; conductivity 2.5e-8 m/s.
    #[test]
    fn table_1_gives_the_papers_derived_values() {
        let values: Values = [
            ("material.equilibrium.mu", -217.0),
            ("material.equilibrium.alpha", -2.16),
            ("material.branch[1].mu", -418.0),
            ("material.branch[1].alpha", -13.5),
            ("material.branch[1].eta", 50.6),
            ("material.branch[2].mu", -161.0),
            ("material.branch[2].alpha", -2.97),
            ("material.branch[2].eta", 4680.0),
            ("material.permeability", 2.30e-15),
            ("material.fluid_viscosity", 0.89e-3),
        ]
        .into_iter()
        .collect();
        let expected = [234.0, 2820.0, 239.0, 3295.0, 0.018, 19.6, 2.535e-8];
        for (quantity, expected) in material_quantities(2, &Resolution::default()).iter().zip(expected) {
            let value = (quantity.evaluate)(&values).unwrap();
            assert_relative_eq!(value, expected, max_relative = 4e-3);
        }
    }
}
