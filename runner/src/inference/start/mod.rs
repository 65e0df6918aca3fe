//! Where a fit starts: moduli, relaxation times, number of branches and permeability, told by the measurements themselves.
//!
//! ```text
//! Measurement -> record (rows of the first loading and hold) -> relaxation (Boltzmann, with the closed form of rig)
//!             -> prony (non-negative, as many branches as the evidence asks for) -> Start -> names
//! ```
//! Closed forms are small strain, of an incompressible sample: a start is worth some ten per cent, and the bounds around it are
//! wide: moduli five decades and more, times from a thousandth of the ramp to a hundred times the test.

pub mod names;
pub mod nonnegative;
pub mod prony;
pub mod record;
pub mod relaxation;
pub mod rig;
#[cfg(test)]
mod tests;

pub use names::Mentioned;
pub use rig::{Face, Rig};

use crate::data::Measurement;
use record::Record;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Most viscous branches: those that the FMU has.
pub const MOST_BRANCHES: usize = poropunch::variables::BRANCHES;
/// A modulus that the data do not show is this part of the instantaneous one: it must not start at zero.
const UNSEEN: f64 = 1e-3;
/// The skeleton counts as incompressible from this many instantaneous shear moduli on: its ratio of Poisson is 0.45.
const STIFF: f64 = 10.0;

/// What is known beside the measurements (SI).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// The test's geometry.
    pub rig: Rig,
    /// Volumetric stiffness of the skeleton (Pa).
    pub lambda_star_pa: f64,
    /// Viscosity of the pore fluid (Pa s).
    pub fluid_viscosity_pa_s: f64,
}

/// A viscous branch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Branch {
    /// Shear modulus (Pa).
    pub shear_pa: f64,
    /// Relaxation time (s).
    pub tau_s: f64,
}

/// Where a fit starts (SI).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Long-term shear modulus (Pa).
    pub equilibrium_pa: f64,
    /// Branches, the fastest first; the instantaneous shear modulus is the sum of all.
    pub branches: Vec<Branch>,
    /// Permeability (m^2) at which the contact drains in the time of the ramp: where the force depends most on it.
    pub permeability_m2: f64,
    /// Volumetric stiffness (Pa), where the known one is not clearly above the shear modulus and so decides the force.
    pub lambda_star_pa: Option<f64>,
    /// Shortest ramp of the tests (s).
    #[serde(default)]
    pub shortest_ramp_s: f64,
    /// Longest time of loading and hold (s).
    #[serde(default)]
    pub longest_s: f64,
}

/// A branch of this part of the shortest ramp's time has relaxed when the ramp ends: its force is there during the ramp only.
const HIDDEN: f64 = 0.1;
/// A contact of this part of the permeability that drains it within the ramp has hardly drained by its end.
const HARDLY_DRAINING: f64 = 1e-2;

impl Start {
    /// The start that measurements tell, with so many branches; none where no force rises.
    pub fn of(measurements: &[&Measurement], known: &Known, branches: RangeInclusive<usize>) -> Option<Self> {
        let records: Vec<Record> = measurements.iter().filter_map(|m| Record::of(m)).collect();
        Self::from_records(&records, known, branches)
    }

    /// The same from their rows.
    pub fn from_records(records: &[Record], known: &Known, branches: RangeInclusive<usize>) -> Option<Self> {
        let deepest = records.iter().max_by(|a, b| a.depth_m.total_cmp(&b.depth_m))?;
        let rig = &known.rig;
        let all = problem(records, rig).best(MOST_BRANCHES, MOST_BRANCHES);
        let widened = |record: &Record| record.clone().widened(&record.law(rig), &all);
        let widened: Vec<Record> = records.iter().map(widened).collect();
        let series = problem(&widened, rig).best(*branches.start(), *branches.end());
        let instantaneous = series.equilibrium_pa + series.branches.iter().map(|b| b.1).sum::<f64>();
        if !(instantaneous > 0.0 && instantaneous.is_finite()) {
            return None;
        }
        let seen = |shear: f64| shear.max(UNSEEN * instantaneous);
        let stiff = known.lambda_star_pa >= STIFF * instantaneous;
        let lambda_star = if stiff { known.lambda_star_pa } else { STIFF * instantaneous };
        let contact = known.rig.contact_radius(deepest.depth_m);
        let modulus = lambda_star + 4.0 / 3.0 * instantaneous;
        Some(Self {
            equilibrium_pa: seen(series.equilibrium_pa),
            branches: series.branches.iter().map(|b| Branch { tau_s: b.0, shear_pa: seen(b.1) }).collect(),
            permeability_m2: known.fluid_viscosity_pa_s * contact * contact / (modulus * deepest.ramp_s),
            lambda_star_pa: (!stiff).then_some(lambda_star),
            shortest_ramp_s: records.iter().map(|r| r.ramp_s).fold(f64::INFINITY, f64::min),
            longest_s: records.iter().filter_map(|r| r.time_s.last()).copied().fold(deepest.ramp_s, f64::max),
        })
    }

    /// The same number of branches, one of them so fast that the ramp hides it, in the place of branch `dropped` where there are others:
    /// what a slow sensor, a soft machine or a surface found too late keeps from the data, so that these do not tell it.
    #[must_use]
    pub fn with_hidden_branch(mut self, dropped: usize) -> Self {
        let hidden = Branch { shear_pa: self.instantaneous_pa(), tau_s: HIDDEN * self.shortest_ramp_s };
        if self.branches.len() > 1 && dropped < self.branches.len() {
            self.branches.remove(dropped);
        }
        self.branches.insert(0, hidden);
        self
    }

    /// The same with a contact that drains in the time of the test, not of the ramp: relaxation by flow and relaxation by viscosity are
    /// two explanations of one curve, each with its own minimum.
    #[must_use]
    pub fn slowly_draining(mut self) -> Self {
        self.permeability_m2 *= (self.shortest_ramp_s / self.longest_s).min(1.0);
        self
    }

    /// The same with a contact that hardly drains during the ramp: where the volumetric stiffness is not known either, relaxation by flow
    /// and relaxation by viscosity are two explanations of one curve, each with its own minimum.
    #[must_use]
    pub fn hardly_draining(mut self) -> Self {
        self.permeability_m2 *= HARDLY_DRAINING;
        self
    }

    /// Instantaneous shear modulus (Pa).
    pub fn instantaneous_pa(&self) -> f64 {
        self.equilibrium_pa + self.branches.iter().map(|b| b.shear_pa).sum::<f64>()
    }
}

/// The series' problem of all rows.
fn problem(records: &[Record], rig: &Rig) -> prony::Problem {
    let grid = record::grid(records);
    let (mut force, mut columns) = (Vec::new(), vec![Vec::new(); grid.len() + 1]);
    for record in records {
        let (rows, parts) = record.system(&record.law(rig), &grid);
        force.extend(rows);
        columns.iter_mut().zip(parts).for_each(|(all, part)| all.extend(part));
    }
    prony::Problem::new(grid, &columns, &force)
}
