//! An independent solver of the indentation test, for cases that test poropunch's diagnosis.

mod contact;
mod drive;
mod element;
mod error;
mod history;
mod law;
mod linear;
mod mesh;
mod motion;
mod specimen;
mod step;
mod system;
mod time;

pub use error::{Failure, MakerError};
pub use history::History;
pub use mesh::Fineness;
pub use motion::Motion;
pub use specimen::{Branch, Geometry, Material, Ogden, Specimen};

use contact::{Face, Friction};
use drive::{Drive, Pace};
use law::{Laws, Seepage, Volumetric};
use system::{Boundary, Drainage, System};

/// Simulates a test.
///
/// # Errors
/// When the specimen makes no sense or a step cannot be solved.
pub fn simulate(specimen: &Specimen, motion: &Motion, friction: f64, fine: Fineness, tol: f64) -> Result<History, MakerError> {
    specimen.check()?;
    let laws = Laws { material: specimen.material.clone(), volumetric: Volumetric::Compaction, seepage: Seepage::Linear, thinning: None, softening: None };
    let face = Face { friction: Friction::Coulomb(friction), cohesion: None, slip_film: std::env::var("FILM").map_or(0.2, |f| f.parse().unwrap()) * specimen.material.instantaneous_modulus() / specimen.geometry.punch_radius };
    let boundary = Boundary { bottom: Drainage::Free, side: Drainage::Free, face: 0.0 };
    let shortest = specimen.material.branches.iter().map(Branch::relaxation_time).fold(f64::INFINITY, f64::min);
    let system = System::new(specimen, laws, face, &boundary, &fine).map_err(|_| MakerError::Invalid("memory"))?;
    eprintln!("{} triangles {} unknowns", system.mesh.triangles.len(), system.equation.len());
    Drive::new(&system, None, Pace { tolerance: tol, ..Pace::default() }, shortest, &|_| 1.0).run(motion)
}
