//! A specimen, its surroundings and the true motion, with the effects that act on them.

use crate::boundary::{Boundary, Drainage};
use crate::contact::{Cohesion, Face, Friction};
use crate::drive::{Drive, Pace};
use crate::effect::Effect;
use crate::error::MakerError;
use crate::history::History;
use crate::law::{Laws, Seepage, Softening, Thinning, Volumetric};
use crate::mesh::Fineness;
use crate::motion::Motion;
use crate::specimen::{Branch, Ogden, Specimen};
use crate::step::Frame;
use crate::system::System;

/// Friction of a bonded punch once its face opens: the bond fails where it would bear more shear than pressure.
const BONDED: f64 = 1.0;
/// Film of sliding points times the punch's radius over the instantaneous modulus (s).
const SLIP_FILM: f64 = 0.1;
/// Coarsest triangles at the edge that are tried, over the punch's radius.
const COARSEST_EDGE: f64 = 0.1;
/// Time in which a grip slips or a bubble collapses (s).
const SUDDEN_S: f64 = 0.1;

/// Everything before the load cell.
pub struct Setup {
    specimen: Specimen,
    volumetric: Volumetric,
    seepage: Seepage,
    thinning: Option<Thinning>,
    softening: Option<Softening>,
    face: Face,
    boundary: Boundary,
    frame: Option<Frame>,
    fineness: Fineness,
    pace: Pace,
    /// Factors on all moduli, from (gain, begin, time constant): `1 + gain (1 - exp(-(t-begin)/time))`.
    ageing: Vec<(f64, f64, f64)>,
    motion: Motion,
}

impl Setup {
    /// The plain model's.
    pub fn plain(specimen: &Specimen, motion: &Motion) -> Self {
        Self {
            specimen: specimen.clone(),
            volumetric: Volumetric::Compaction,
            seepage: Seepage::Linear,
            thinning: None,
            softening: None,
            face: Face { friction: Friction::Bond(BONDED), cohesion: None, slip_film: 0.0 },
            boundary: Boundary { bottom: Drainage::Free, side: Drainage::Free, face: 0.0 },
            frame: None,
            fineness: Fineness::default(),
            pace: Pace::default(),
            ageing: Vec::new(),
            motion: motion.clone(),
        }
    }

    /// Adds an effect, if it acts here; whether it does.
    pub fn add(&mut self, effect: &Effect) -> bool {
        let s = &mut self.specimen;
        let mobility = s.material.permeability / s.material.fluid_viscosity;
        let tight = |size: f64| match size > 0.0 {
            true => Drainage::Permeance(mobility / (s.geometry.sample_height * size)),
            false => Drainage::Free,
        };
        match *effect {
            Effect::SlowPair { size, time_s } => {
                let spring = Ogden { mu: -20.0 * size, alpha: -3.0 };
                let branch = |time: f64| Branch { spring, eta: time * spring.shear_modulus() };
                if size > 0.0 {
                    s.material.branches.extend([branch(time_s / 2.5), branch(time_s * 2.5)]);
                }
            }
            Effect::Carreau { size } => {
                self.thinning = (size > 0.0).then_some(Thinning { stress: 600.0 / size, exponent: 1.5 });
            }
            Effect::ExponentialPermeability { size } => self.seepage = Seepage::Exponential(5.0 * size),
            Effect::LogarithmicSkeleton { size } => {
                s.material.lambda *= 0.02f64.powf(size);
                self.volumetric = Volumetric::LogarithmicPores;
            }
            Effect::EnergySoftening { size } => {
                // The energy of an isochoric equivalent strain e is 3/2 G e^2.
                self.softening = Some(Softening { loss: (0.3 * size).min(0.6), energy: 1.5 * 0.2 * 0.2 });
            }
            Effect::SaturatingAgeing { size, time_s } => {
                self.ageing.push((1e-4 * size * time_s, 0.0, time_s))
            }
            Effect::Batch { size } => s.material.scale((0.2 * size).exp()),
            Effect::Dimensions { size } => {
                s.geometry.sample_radius *= size.exp2();
                s.geometry.sample_height *= size.exp2();
            }
            Effect::Film { size } if size > 0.0 => self.face.friction = Friction::Film(1e6 / size),
            Effect::LowFriction { coefficient: 0.0 } => self.face.friction = Friction::Film(0.0),
            Effect::LowFriction { coefficient } => self.face.friction = Friction::Coulomb(coefficient),
            Effect::LeakyFace { size } => {
                self.boundary.face = size * mobility / (0.02 * s.geometry.punch_radius)
            }
            Effect::TightBottom { size } => self.boundary.bottom = tight(size),
            Effect::TightSide { size } => self.boundary.side = tight(size),
            Effect::ExponentialAdhesion { size } if size > 0.0 => {
                self.face.cohesion = Some(Cohesion { strength: 100.0 * size, opening: 1e-4 });
            }
            Effect::ShiftedSurface { size } => self.motion = self.motion.map(|_, d| d + 2e-5 * size),
            Effect::StiffeningFrame { size, force } if size > 0.0 => {
                self.frame = Some(Frame { per_newton: 0.002 * size, stiffening_force: force });
            }
            Effect::Coarse { size } => {
                let plain = Fineness::default();
                let by = size.exp2();
                self.fineness =
                    Fineness { edge: plain.edge * by * by, growth: plain.growth * by, near: plain.near * by };
                self.pace.tolerance *= 10f64.powf(size);
                self.pace.first_order = size.min(1.0);
            }
            Effect::Bubble { loss, time_s } => {
                self.ageing.push((-loss, time_s, SUDDEN_S));
                self.motion = self.motion.refined([time_s, time_s + SUDDEN_S]);
            }
            Effect::Overshoot { length, frequency, decay_s } => {
                self.motion = self.motion.with_overshoot(length, frequency, decay_s);
            }
            Effect::GripStep { length, time_s } => {
                let motion = self.motion.refined([time_s, time_s + SUDDEN_S]);
                self.motion = motion.map(|t, d| if t > time_s + 0.5 * SUDDEN_S { d - length } else { d });
            }
            Effect::WarmingFrame { length, time_s } => {
                let (from, to) = self.motion.span();
                let grid = (1..60).map(|i| from + (to - from) * (i as f64 / 60.0).powi(2));
                let warming = |t: f64| length * -(-(t - from) / time_s).exp_m1();
                self.motion = self.motion.refined(grid).map(|t, d| d + warming(t));
            }
            Effect::Backlash { length } => self.motion = self.motion.with_play(length),
            _ => return false,
        }
        true
    }

    /// Mesh and steps of another accuracy.
    pub fn accuracy(&mut self, fineness: Fineness, tolerance: f64) {
        self.fineness = fineness;
        self.pace.tolerance = tolerance;
    }

    /// Multiplies the tolerance of the steps.
    pub fn scale_tolerance(&mut self, part: f64) {
        self.pace.tolerance *= part;
    }

    /// The true motion.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// The force on the specimen.
    ///
    /// # Errors
    /// When the specimen makes no sense or a step cannot be solved.
    pub fn run(mut self) -> Result<History, MakerError> {
        self.specimen.check()?;
        let material = self.specimen.material.clone();
        self.face.slip_film =
            SLIP_FILM * material.instantaneous_modulus() / self.specimen.geometry.punch_radius;
        let branches = material.branches.iter().map(Branch::relaxation_time);
        // Seepage over the punch's radius, with the skeleton's stiffness when it cannot bulge.
        let oedometric = material.lambda + 4.0 / 3.0 * material.equilibrium.shear_modulus();
        let mobility = material.permeability / material.fluid_viscosity;
        let seepage = self.specimen.geometry.punch_radius.powi(2) / (mobility * oedometric);
        let shortest = branches.fold(seepage, f64::min);
        let laws = Laws {
            material,
            volumetric: self.volumetric,
            seepage: self.seepage,
            thinning: self.thinning,
            softening: self.softening,
        };
        let ageing = |t: f64| {
            let factor = |&(gain, begin, time): &(f64, f64, f64)| {
                (1.0 - gain * (-(t - begin).max(0.0) / time).exp_m1()).max(0.05)
            };
            self.ageing.iter().map(factor).product()
        };
        // Where the specimen folds at the punch's edge, triangles a little larger are not turned inside out.
        let mut fineness = self.fineness;
        loop {
            let system = System::new(&self.specimen, laws.clone(), self.face, &self.boundary, &fineness)
                .map_err(|_| MakerError::Invalid("the mesh is too large"))?;
            let done = Drive::new(&system, self.frame, self.pace, shortest, &ageing).run(&self.motion);
            fineness.edge *= 2.0;
            let may_help = matches!(done, Err(MakerError::NoConvergence { .. }));
            if !may_help || fineness.edge > COARSEST_EDGE {
                return done;
            }
        }
    }
}
