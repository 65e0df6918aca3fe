//! What a user can set: material, geometry, mesh, boundary conditions, solver.

use crate::effect::EffectParameters;
use crate::error::ParameterError;
use crate::indentation::profile::LARGEST_CAP;
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

/// One Ogden term: `beta_a = mu (ltilde_a^alpha - mean_b ltilde_b^alpha)` (Eqs. 8, 9).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OgdenParameters {
    /// Stress-like coefficient mu (Pa); has the sign of `alpha`.
    pub mu: f64,
    /// Exponent alpha [-].
    pub alpha: f64,
}

impl OgdenParameters {
    /// Shear modulus at small strain, `mu alpha / 2` (Pa).
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.mu * self.alpha
    }
}

/// One viscous branch: an Ogden spring in series with a dashpot (Eqs. 9, 12).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BranchParameters {
    /// The spring.
    pub ogden: OgdenParameters,
    /// Viscosity eta (Pa s).
    pub eta: f64,
}

impl BranchParameters {
    /// Relaxation time at small strain, `eta / (mu alpha / 2)` (s).
    pub fn relaxation_time(&self) -> f64 {
        self.eta / self.ogden.shear_modulus()
    }
}

/// Constitutive parameters of the biphasic solid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaterialParameters {
    /// Initial solid volume fraction n0S [-].
    pub n0s: f64,
    /// Volumetric stiffness lambda* (Pa) (Eq. 10).
    pub lambda_star: f64,
    /// Dynamic viscosity of the pore fluid mu_FR (Pa s).
    pub fluid_viscosity: f64,
    /// Initial intrinsic permeability K0 (m^2).
    pub permeability: f64,
    /// Equilibrium response.
    pub equilibrium: OgdenParameters,
    /// Viscous branches, any number.
    pub branches: Vec<BranchParameters>,
}

impl Default for MaterialParameters {
    fn default() -> Self {
        let branch = |mu, alpha, eta| BranchParameters { ogden: OgdenParameters { mu, alpha }, eta };
        Self {
            n0s: 0.032,
            lambda_star: 1e5,
            fluid_viscosity: 0.89e-3,
            permeability: 2.30e-15,
            equilibrium: OgdenParameters { mu: -217.0, alpha: -2.16 },
            branches: vec![branch(-418.0, -13.5, 50.6), branch(-161.0, -2.97, 4680.0)],
        }
    }
}

/// Punch and sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GeometryParameters {
    /// Radius of the flat punch, or of the shank of a sphere or cone: the largest contact radius, up to which the
    /// mesh is fine (m). A flat punch at least as wide as the sample is a platen.
    pub punch_radius: f64,
    /// Radius of the sample (m).
    pub sample_radius: f64,
    /// Height of the sample (m).
    pub sample_height: f64,
}

impl Default for GeometryParameters {
    fn default() -> Self {
        Self { punch_radius: 2e-3, sample_radius: 10e-3, sample_height: 10e-3 }
    }
}

impl GeometryParameters {
    /// Whether the punch covers the whole sample.
    pub fn is_platen(&self) -> bool {
        self.punch_radius >= self.sample_radius
    }

    /// Radius of the part of the surface that the punch can touch in the undeformed sample (m).
    pub fn reach(&self) -> f64 {
        self.punch_radius.min(self.sample_radius)
    }
}

/// Shape of the punch's face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum IndenterProfile {
    /// A plane.
    #[default]
    Flat,
    /// A sphere.
    Sphere,
    /// A cone.
    Cone,
}

/// The punch's face; dimensions of a profile that was not chosen stay at their defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IndenterParameters {
    /// Its shape.
    pub profile: IndenterProfile,
    /// Radius of a flat punch's edge (m); 0: sharp.
    pub edge_radius: f64,
    /// Radius of the sphere (m).
    pub sphere_radius: f64,
    /// Angle between the cone's axis and its flank (rad).
    pub cone_half_angle: f64,
}

impl Default for IndenterParameters {
    fn default() -> Self {
        Self {
            profile: IndenterProfile::Flat,
            edge_radius: 0.0,
            sphere_radius: 4e-3,
            cone_half_angle: PI / 3.0,
        }
    }
}

impl IndenterParameters {
    /// Whether the face is a plane up to a sharp edge.
    pub fn is_plane(&self) -> bool {
        self.profile == IndenterProfile::Flat && self.edge_radius == 0.0
    }

    /// Distance from the axis (m) from which on the edge of the contact can run; `None` where it is the punch's.
    pub fn contact_edge_from(&self, punch_radius: f64) -> Option<f64> {
        match self.profile {
            IndenterProfile::Flat => (!self.is_plane()).then_some(punch_radius - self.edge_radius),
            IndenterProfile::Sphere | IndenterProfile::Cone => Some(0.0),
        }
    }
}

/// Named meshes, from quick to accurate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum MeshPreset {
    /// Quick.
    Coarse,
    /// The default; accurate to the force of real measurements.
    #[default]
    Standard,
    /// Accurate.
    Fine,
}

/// How the sample is discretised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum MeshKind {
    /// Axisymmetric elements, chosen by the other mesh parameters.
    #[default]
    Axisymmetric,
    /// A quarter of the cylinder in 3184 hexahedra with hanging nodes, of the paper's size.
    Paper3d,
}

/// Spatial discretisation: a preset, with overrides.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MeshParameters {
    /// Axisymmetric or three-dimensional; the parameters below are those of the axisymmetric mesh.
    pub kind: MeshKind,
    /// The preset.
    pub preset: MeshPreset,
    /// Size of the innermost ring of elements at the punch's edge (m); 0 takes the preset's.
    pub edge_size: f64,
    /// Ratio of neighbouring rings [-]; 0 takes the preset's.
    pub growth: f64,
    /// Elements along the inner side of every ring; 0 takes the preset's.
    pub divisions: u32,
}

/// Boundary conditions, each one switchable. `default()` is the paper's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoundaryParameters {
    /// p = 0 on the bottom; otherwise no flux.
    pub drained_bottom: bool,
    /// p = 0 on the lateral surface.
    pub drained_side: bool,
    /// p = 0 on the free part of the top.
    pub drained_top: bool,
    /// p = 0 under the punch (porous punch).
    pub drained_punch: bool,
    /// u_r = 0 under the punch (full adhesion); otherwise frictionless.
    pub bonded_punch: bool,
    /// Friction coefficient of a bonded punch [-]: the bond fails beside an open part of the face where the
    /// shear exceeds this times the pressure.
    pub friction: f64,
    /// u_r = 0 on the bottom (glued); otherwise it slides on its support.
    pub bonded_bottom: bool,
    /// u_r = 0 on the lateral surface (sample in a smooth rigid ring); otherwise it is free.
    pub confined_side: bool,
}

impl Default for BoundaryParameters {
    fn default() -> Self {
        Self {
            drained_bottom: true,
            drained_side: true,
            drained_top: true,
            drained_punch: false,
            bonded_punch: true,
            friction: 1.0,
            bonded_bottom: true,
            confined_side: false,
        }
    }
}

/// Integration scheme in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum TimeScheme {
    /// Two-stage, stiffly accurate, L-stable SDIRK: second order.
    #[default]
    Sdirk2,
    /// Backward Euler, the paper's: first order.
    BackwardEuler,
}

/// Direct solver of the linear systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum LinearSolverKind {
    /// Multifrontal LU along the mesh's nested dissection; faer's LU where its pivots do not suffice.
    #[default]
    Multifrontal,
    /// faer's sparse LU with partial pivoting.
    Faer,
}

/// Time stepping and Newton iteration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolverParameters {
    /// Integration scheme.
    pub time_scheme: TimeScheme,
    /// Direct solver of the linear systems.
    pub linear_solver: LinearSolverKind,
    /// Relative error allowed per step in the force [-].
    pub tolerance: f64,
    /// Travel of the punch within the first step after a change of its velocity (m).
    pub initial_increment: f64,
    /// Largest step (s).
    pub max_step: f64,
    /// Newton iteration ends when the scaled residual is below this [-].
    pub newton_tolerance: f64,
    /// Whether the derivatives of the force by the material's parameters are computed along.
    pub sensitivities: bool,
}

impl Default for SolverParameters {
    fn default() -> Self {
        Self {
            time_scheme: TimeScheme::Sdirk2,
            linear_solver: LinearSolverKind::Multifrontal,
            tolerance: 3e-4,
            initial_increment: 2e-6,
            max_step: 1e6,
            newton_tolerance: 1e-9,
            sensitivities: false,
        }
    }
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
        }
        within("solver.tolerance", s.tolerance, 1e-9, 1.0)?;
        positive("solver.initial_increment", s.initial_increment)?;
        positive("solver.max_step", s.max_step)?;
        within("solver.newton_tolerance", s.newton_tolerance, 1e-14, 1e-2)?;
        EffectParameters::validate(self)
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
                let least = self.geometry.punch_radius / LARGEST_CAP;
                within("indenter.sphere_radius", i.sphere_radius, least, f64::MAX)?;
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
