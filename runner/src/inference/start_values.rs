//! What is believed of the material before the fit: where the search starts, and the centre of the priors.

use super::unknowns::branch_of;
use crate::pool::Wiring;
use std::collections::BTreeMap;

/// Moduli and times as the data (or whoever knows them) say.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Start {
    /// Shear modulus of the equilibrium response (Pa).
    pub equilibrium_modulus_pa: f64,
    /// Shear modulus (Pa) and relaxation time (s) of each branch that there is.
    pub branches: Vec<(f64, f64)>,
    /// Permeability (m^2), where something is known of it.
    pub permeability_m2: Option<f64>,
}

impl Start {
    /// Values of the FMU's parameters: exponents at their own start.
    pub(super) fn values(&self, wiring: &Wiring) -> BTreeMap<String, f64> {
        let own = |name: &str| wiring.parameters.get(name).and_then(|v| v.start_number());
        let mut values = BTreeMap::new();
        let mut group = |prefix: String, modulus_pa: f64, time_s: Option<f64>| {
            if let Some(alpha) = own(&format!("{prefix}.alpha")) {
                values.insert(format!("{prefix}.mu"), 2.0 * modulus_pa / alpha);
                values.extend(time_s.map(|t| (format!("{prefix}.eta"), modulus_pa * t)));
            }
        };
        group("material.equilibrium".to_owned(), self.equilibrium_modulus_pa, None);
        for (k, (modulus_pa, time_s)) in self.branches.iter().enumerate() {
            group(format!("material.branch[{}]", k + 1), *modulus_pa, Some(*time_s));
        }
        values.extend(self.permeability_m2.map(|k| ("material.permeability".to_owned(), k)));
        values
    }

    /// `mu = 0` of the branches that there are not.
    pub(super) fn absent(&self, wiring: &Wiring) -> BTreeMap<String, f64> {
        let is_absent = |name: &&String| branch_of(name).is_some_and(|i| i > self.branches.len());
        let absent = wiring.parameters.keys().filter(is_absent).filter(|n| n.ends_with(".mu"));
        absent.map(|name| (name.clone(), 0.0)).collect()
    }
}
