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

/// A test: the force on the specimen and the true motion.
pub struct Run {
    history: History,
    motion: Motion,
}

impl Run {
    /// Of a recorded motion, with the effects that act on the specimen.
    ///
    /// # Errors
    /// When the specimen makes no sense or a step cannot be solved.
    pub fn new(specimen: &Specimen, motion: &Motion, effects: &[Effect]) -> Result<Self, MakerError> {
        Self::with_steps(specimen, motion, effects, 1.0)
    }

    /// The same with another part of the tolerance of the steps, which tells whether the force depends on them.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn with_steps(
        specimen: &Specimen,
        motion: &Motion,
        effects: &[Effect],
        part_of_tolerance: f64,
    ) -> Result<Self, MakerError> {
        let mut setup = Setup::plain(specimen, motion);
        for effect in effects {
            setup.add(effect);
        }
        setup.scale_tolerance(part_of_tolerance);
        let motion = setup.motion().clone();
        Ok(Self { history: setup.run()?, motion })
    }

    /// What the load cell reads (N), without noise, at times (s) that do not fall, with the effects that act on it.
    pub fn readings_n(&self, times_s: &[f64], effects: &[Effect]) -> Vec<f64> {
        reading::readings(&self.history, &self.motion, times_s, effects)
    }
}

/// Whether an effect acts on the specimen: runs with and without it differ.
pub fn acts_on_specimen(effect: &Effect, specimen: &Specimen, motion: &Motion) -> bool {
    Setup::plain(specimen, motion).add(effect)
}

/// The plain model's force with another mesh and another tolerance of the steps (over the peak, 5e-4 as a rule).
///
/// # Errors
/// As [`Run::new`].
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
