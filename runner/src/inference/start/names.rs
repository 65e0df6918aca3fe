//! A start in the names of the model's parameters: what is fitted, from where, between which bounds.

use super::{Face, HARDLY_DRAINING, Known, MOST_BRANCHES, Rig, Start};
use crate::data::Measurement;
use crate::engine::Engine;
use crate::inference::ParameterError;
use crate::inference::requests::{Defaults, Requests};
use crate::inference::unknowns::Unknowns;
use crate::noise::Observation;
use crate::setting::{SettingError, settings_from};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Half the width of the bounds: two and a half decades to either side.
const REACH: f64 = 316.0;
/// Of a branch that relaxes in this part of the ramp only the viscosity shows; of one that takes this many times the test only the
/// modulus.
const TOO_FAST: f64 = 1e-3;
const TOO_SLOW: f64 = 1e2;
/// Exponent at which every spring starts: force and depth of one test say little of it.
const ALPHA: f64 = -3.0;
const ALPHA_BOUNDS: [f64; 2] = [-30.0, -1.0];

const LAMBDA_STAR: &str = "material.lambda_star";
const PERMEABILITY: &str = "material.permeability";

fn branch(number: usize, leaf: &str) -> String {
    format!("material.branch[{number}].{leaf}")
}

impl Known {
    /// From the values of the FMU's parameters (SI); none where no closed form fits the test.
    pub fn of(value: &dyn Fn(&str) -> Option<f64>) -> Option<Self> {
        let is = |name| value(name).is_some_and(|v| v != 0.0);
        if is("boundary.confined_side") {
            return None;
        }
        let (shank, sample_radius) = (value("geometry.punch_radius")?, value("geometry.sample_radius")?);
        let face = match value("indenter.profile")? as i32 {
            1 if shank >= sample_radius => Face::Platen,
            1 => Face::Flat { radius: shank },
            2 => Face::Sphere { radius: value("indenter.sphere_radius")?, shank },
            3 => Face::Cone { half_angle: value("indenter.cone_half_angle")?.min(0.499 * PI), shank },
            _ => return None,
        };
        let rig = Rig {
            face,
            sample_radius,
            sample_height: value("geometry.sample_height")?,
            bonded_face: is("boundary.bonded_punch"),
            bonded_support: is("boundary.bonded_bottom"),
        };
        let (lambda_star_pa, fluid_viscosity_pa_s) =
            (value(LAMBDA_STAR)?, value("material.fluid_viscosity")?);
        Some(Self { rig, lambda_star_pa, fluid_viscosity_pa_s })
    }
}

impl Start {
    /// Where the data say that a fit starts, with so many branches, and what the user said of it; of poropunch's own FMU only.
    ///
    /// # Errors
    /// A setting that cannot be used.
    pub fn told_by(
        engine: &Engine,
        fitted: &[Observation],
        requests: &Requests,
        branches: RangeInclusive<usize>,
    ) -> Result<Option<(Self, Mentioned)>, SettingError> {
        if !engine.is_own() {
            return Ok(None);
        }
        let set = settings_from(engine.wiring(), &requests.set)?;
        let default = |name: &str| engine.wiring().parameters.get(name)?.start_number();
        let known = Known::of(&|name| set.get(name).copied().or_else(|| default(name)));
        let mentioned = Mentioned::of(requests);
        let measurements: Vec<&Measurement> = fitted.iter().map(|o| &o.measurement).collect();
        let branches = mentioned.branch.max(*branches.start())..=*branches.end();
        let start = known.and_then(|known| Self::of(&measurements, &known, branches));
        Ok(start.map(|start| (start, mentioned)))
    }
}

/// What the user said of the material: that wins over any estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mentioned {
    /// Whether the fitted parameters were named one by one.
    pub free: bool,
    /// Whether lambda* was given.
    pub lambda_star: bool,
    /// The highest branch that was named; 0: none.
    pub branch: usize,
}

impl Mentioned {
    /// In the requests of a fit.
    pub fn of(requests: &Requests) -> Self {
        let r = requests;
        let texts = || [&r.set, &r.free, &r.fix, &r.tie, &r.bounds, &r.start].into_iter().flatten();
        let branch =
            (1..=MOST_BRANCHES).rfind(|n| texts().any(|t| t.contains(&format!("material.branch[{n}]"))));
        Self {
            free: !r.free.is_empty(),
            lambda_star: texts().any(|t| t.contains(LAMBDA_STAR)),
            branch: branch.unwrap_or(0),
        }
    }
}

impl Start {
    /// Defaults of a fit: starts, bounds, what is fitted and which branches are switched off.
    pub fn defaults(&self, mentioned: Mentioned) -> Defaults {
        let around = |value: f64| (value, [value / REACH, value * REACH]);
        let mu = |shear: f64| {
            let (value, [low, high]) = around(2.0 * shear / ALPHA);
            (value, [high, low])
        };
        let mut start: BTreeMap<String, (f64, [f64; 2])> = BTreeMap::new();
        let mut spring = |prefix: &str, shear: f64| {
            start.insert(format!("{prefix}.mu"), mu(shear));
            start.insert(format!("{prefix}.alpha"), (ALPHA, ALPHA_BOUNDS));
        };
        spring("material.equilibrium", self.equilibrium_pa);
        for (k, b) in self.branches.iter().enumerate() {
            spring(&format!("material.branch[{}]", k + 1), b.shear_pa);
        }
        for (k, b) in self.branches.iter().enumerate() {
            start.insert(branch(k + 1, "eta"), around(b.shear_pa * b.tau_s));
        }
        start.insert(PERMEABILITY.to_owned(), around(self.permeability_m2));
        if let Some(lambda_star) = self.lambda_star_pa.filter(|_| !mentioned.lambda_star) {
            start.insert(LAMBDA_STAR.to_owned(), around(lambda_star));
        }
        let times_s = Some([TOO_FAST * self.shortest_ramp_s, TOO_SLOW * self.longest_s]);
        if mentioned.free {
            return Defaults { start, times_s, ..Defaults::default() };
        }
        let absent = (self.branches.len() + 1..=MOST_BRANCHES).map(|n| (branch(n, "mu"), 0.0)).collect();
        let table = poropunch::variables::table().iter().map(|v| v.name);
        let free = table.filter(|name| start.contains_key(*name)).map(str::to_owned).collect();
        Defaults { free, fixed: absent, start, times_s }
    }

    /// Where else a fit of these unknowns, which start here, may start: none where lambda* is known or the permeability's start was given.
    ///
    /// # Errors
    /// A request that cannot be used.
    pub fn elsewhere(
        &self,
        mentioned: Mentioned,
        engine: &Engine,
        requests: &Requests,
        unknowns: &Unknowns,
    ) -> Result<Vec<Vec<f64>>, ParameterError> {
        if !unknowns.free().iter().any(|p| p.name == LAMBDA_STAR) {
            return Ok(vec![]);
        }
        let requests =
            Requests { defaults: self.clone().hardly_draining().defaults(mentioned), ..requests.clone() };
        let other = Unknowns::new(engine.wiring(), engine.is_own(), &requests)?;
        let start = other.start().to_vec();
        Ok(if start == unknowns.start() { vec![] } else { vec![start] })
    }

    /// What [`Start::elsewhere`] tells, in words.
    pub fn elsewhere_in_words() -> String {
        format!("a second fit starts with {HARDLY_DRAINING} of that K0")
    }

    /// In words, for terminal and report.
    pub fn in_words(&self) -> String {
        let branches: Vec<String> = self
            .branches
            .iter()
            .map(|b| format!("{} Pa over {} s", three(b.shear_pa), three(b.tau_s)))
            .collect();
        let skeleton = self.lambda_star_pa.map(|l| format!(", lambda* {} Pa (fitted)", three(l)));
        format!(
            "G_inf {} Pa, branches {}, K0 {} mm^2{}",
            three(self.equilibrium_pa),
            branches.join(", "),
            three(self.permeability_m2 * 1e6),
            skeleton.unwrap_or_default()
        )
    }
}

/// Three digits.
fn three(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    if (1e-3..1e6).contains(&rounded) { format!("{rounded}") } else { format!("{rounded:e}") }
}
