//! What a user can set: material, geometry, mesh, boundary conditions, solver.

pub use crate::contact::parameters::*;
use crate::effect::{Access, CATALOGUE, EffectParameters, Place, offset, slip};
use crate::error::ParameterError;
pub use crate::law::parameters::*;
pub use crate::mesh::parameters::*;
pub use crate::solver::parameters::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Every parameter of the model, in SI units. `default()` is Table 1 of the paper.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Parameters {
    /// Constitutive parameters.
    pub material: MaterialParameters,
    /// Punch and sample.
    pub geometry: GeometryParameters,
    /// Shape of the punch's face.
    pub indenter: IndenterParameters,
    /// Spatial discretisation.
    pub mesh: MeshParameters,
    /// Boundary conditions.
    pub boundary: BoundaryParameters,
    /// Time stepping and Newton iteration.
    pub solver: SolverParameters,
    /// Effects that the plain model leaves out; none by default.
    pub effect: EffectParameters,
}

impl Parameters {
    /// Checks that every value is admissible.
    ///
    /// # Errors
    /// Names the first parameter that is not, with the reason.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let m = &self.material;
        within("material.n0s", m.n0s, 1e-6, 0.999)?;
        positive("material.lambda_star", m.lambda_star)?;
        positive("material.fluid_viscosity", m.fluid_viscosity)?;
        positive("material.permeability", m.permeability)?;
        ogden("material.equilibrium", &m.equilibrium)?;
        for (i, branch) in m.branches.iter().enumerate() {
            validate_branch(i + 1, branch)?;
        }
        let g = &self.geometry;
        positive("geometry.punch_radius", g.punch_radius)?;
        positive("geometry.sample_height", g.sample_height)?;
        positive("geometry.sample_radius", g.sample_radius)?;
        let flat = self.indenter.is_plane();
        // Between 1 and 1.05 neither the edge nor the side would be resolved.
        if !(g.is_platen() && flat && self.mesh.kind == MeshKind::Axisymmetric) {
            within("geometry.sample_radius", g.sample_radius, 1.05 * g.punch_radius, f64::MAX)?;
        }
        self.validate_indenter()?;
        if self.mesh.edge_size != 0.0 {
            within("mesh.edge_size", self.mesh.edge_size, SMALLEST_EDGE * g.reach(), g.reach())?;
        }
        if self.mesh.growth != 0.0 {
            within("mesh.growth", self.mesh.growth, 1.05, 10.0)?;
        }
        within("mesh.divisions", f64::from(self.mesh.divisions), 0.0, 64.0)?;
        within("boundary.friction", self.boundary.friction, 0.0, 1e3)?;
        let s = &self.solver;
        if self.mesh.kind == MeshKind::Paper3d {
            if s.sensitivities {
                return Err(ParameterError::NotIn3d("solver.sensitivities"));
            }
            if s.linear_solver != LinearSolverKind::Multifrontal {
                return Err(ParameterError::NotIn3d("solver.linear_solver"));
            }
            if self.boundary.partial_slip {
                return Err(ParameterError::NotIn3d("boundary.partial_slip"));
            }
        }
        if s.effect_sensitivities && !s.sensitivities {
            let [switch, needed] = ["solver.effect_sensitivities", "solver.sensitivities = true"];
            return Err(ParameterError::Contradiction(switch, needed));
        }
        within("solver.tolerance", s.tolerance, 1e-9, 1.0)?;
        positive("solver.initial_increment", s.initial_increment)?;
        positive("solver.max_step", s.max_step)?;
        within("solver.newton_tolerance", s.newton_tolerance, 1e-14, 1e-2)?;
        self.validate_effects()
    }
}

impl Parameters {
    /// What acts only with one profile is refused with the others, unless it is left at its default.
    fn validate_indenter(&self) -> Result<(), ParameterError> {
        let (i, default) = (&self.indenter, IndenterParameters::default());
        let only = |changed: bool, name, with| {
            if changed { Err(ParameterError::Contradiction(name, with)) } else { Ok(()) }
        };
        match i.profile {
            IndenterProfile::Sphere => {
                within("indenter.sphere_radius", i.sphere_radius, self.geometry.punch_radius, f64::MAX)?;
            }
            _ => only(
                i.sphere_radius != default.sphere_radius,
                "indenter.sphere_radius",
                "indenter.profile = sphere",
            )?,
        }
        match i.profile {
            IndenterProfile::Cone => {
                let (least, most) = CONE_HALF_ANGLE;
                within("indenter.cone_half_angle", i.cone_half_angle, least, most)?;
            }
            _ => only(
                i.cone_half_angle != default.cone_half_angle,
                "indenter.cone_half_angle",
                "indenter.profile = cone",
            )?,
        }
        match i.profile {
            IndenterProfile::Flat => {
                // A smaller one would have elements of no size.
                let (radius, sharp) = (self.geometry.punch_radius, i.edge_radius == 0.0);
                let least = if sharp { 0.0 } else { SMALLEST_EDGE * radius };
                within("indenter.edge_radius", i.edge_radius, least, radius)?;
            }
            _ => only(i.edge_radius != 0.0, "indenter.edge_radius", "indenter.profile = flat")?,
        }
        let rings = i.is_plane() && !self.geometry.is_platen();
        only(
            self.mesh.divisions != 0 && !rings,
            "mesh.divisions",
            "indenter.profile = flat, a sharp edge and geometry.punch_radius < geometry.sample_radius",
        )?;
        if self.mesh.kind == MeshKind::Paper3d && !i.is_plane() {
            let rounded = i.profile == IndenterProfile::Flat;
            return Err(ParameterError::NotIn3d(if rounded {
                "indenter.edge_radius"
            } else {
                "indenter.profile"
            }));
        }
        Ok(())
    }
}

/// Smallest element and smallest radius of an edge, over the punch's radius.
const SMALLEST_EDGE: f64 = 1e-5;

impl Parameters {
    /// Checks the ranges of the effects that the variable table declares, and what cannot be combined.
    ///
    /// # Errors
    /// Names the first parameter that is not admissible, with the reason.
    fn validate_effects(&self) -> Result<(), ParameterError> {
        for parameter in crate::effect::PARAMETERS.iter().copied().flatten() {
            if let Access::Real { range: (min, max), get, .. } = parameter.access {
                within(parameter.name, get(&self.effect), min, max)?;
            }
        }
        let effect = &self.effect;
        let slips = slip::EFFECT.acts(effect);
        if slips && !self.boundary.bonded_punch {
            return Err(ParameterError::Contradiction(
                "effect.slip.compliance",
                "boundary.bonded_punch = true",
            ));
        }
        if slips && !self.indenter.is_plane() {
            // The layer knows where a plane was touched: at rest.
            return Err(ParameterError::Contradiction(
                "effect.slip.compliance",
                "indenter.profile = flat with a sharp edge",
            ));
        }
        if self.solver.sensitivities && effect.discretisation.traction {
            return Err(ParameterError::NoSensitivities("effect.discretisation.traction"));
        }
        if self.mesh.kind == MeshKind::Paper3d {
            // The contact point's offset moves the punch, not the specimen.
            let inside =
                CATALOGUE.iter().filter(|e| e.place <= Place::Machine && e.name != offset::EFFECT.name);
            if let Some(name) = inside.filter_map(|e| e.acting(effect)).next() {
                return Err(ParameterError::NotIn3d(name));
            }
        }
        Ok(())
    }
}

/// Admissible half-angles of a cone (rad): from 10 degrees to half a degree short of a plane.
pub(crate) const CONE_HALF_ANGLE: (f64, f64) = (PI / 18.0, PI * 89.5 / 180.0);

/// Checks the viscous branch with this number.
pub(crate) fn validate_branch(number: usize, branch: &BranchParameters) -> Result<(), ParameterError> {
    let name = format!("material.branch[{number}]");
    ogden(&name, &branch.ogden)?;
    positive(&format!("{name}.eta"), branch.eta)
}

fn positive(name: &str, value: f64) -> Result<(), ParameterError> {
    within(name, value, f64::MIN_POSITIVE, f64::MAX)
}

fn within(name: &str, value: f64, min: f64, max: f64) -> Result<(), ParameterError> {
    if value >= min && value <= max {
        return Ok(());
    }
    Err(ParameterError::OutOfRange { name: name.to_owned(), value, min, max })
}

fn ogden(name: &str, p: &OgdenParameters) -> Result<(), ParameterError> {
    if p.shear_modulus() > 0.0 && p.shear_modulus().is_finite() {
        return Ok(());
    }
    Err(ParameterError::NotElliptic { name: name.to_owned(), mu: p.mu, alpha: p.alpha })
}
