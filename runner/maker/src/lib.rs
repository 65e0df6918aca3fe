//! An independent solver of the indentation test: it makes the cases on which poropunch's diagnosis is tested.
//!
//! It shares with poropunch nothing but the plain model's laws (Eqs. 2-14): six-node triangles, BDF2, contact by
//! penalty with Coulomb friction, flow in the viscous metric, and every effect in a form of its own. SI units.

mod boundary;
mod contact;
mod drive;
mod effect;
mod element;
mod error;
mod history;
mod law;
mod linear;
mod mesh;
mod motion;
mod reading;
mod setup;
mod specimen;
mod step;
mod system;
mod time;
#[cfg(test)]
mod verification;
mod weak;

pub use effect::Effect;
pub use error::{Failure, MakerError};
pub use history::History;
pub use mesh::Fineness;
pub use motion::Motion;
pub use specimen::{Branch, Geometry, Material, Ogden, Specimen};

use setup::Setup;

/// What the load cell reads (N), without noise, at times (s) that do not fall, of a recorded motion.
///
/// # Errors
/// When the specimen makes no sense or a step cannot be solved.
pub fn simulate(
    specimen: &Specimen,
    motion: &Motion,
    times_s: &[f64],
    effects: &[Effect],
) -> Result<Vec<f64>, MakerError> {
    let mut setup = Setup::plain(specimen, motion);
    effects.iter().for_each(|e| setup.add(e));
    let motion = setup.motion().clone();
    Ok(reading::readings(&setup.run()?, &motion, times_s, effects))
}

/// The plain model's force with another mesh and another tolerance of the steps (over the peak, 5e-4 as a rule).
///
/// # Errors
/// As [`simulate`].
pub fn simulate_plain(
    specimen: &Specimen,
    motion: &Motion,
    fineness: Fineness,
    tolerance: f64,
) -> Result<History, MakerError> {
    let mut setup = Setup::plain(specimen, motion);
    setup.accuracy(fineness, tolerance);
    setup.run()
}
