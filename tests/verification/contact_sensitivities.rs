//! Derivatives of the force through whole tests, proved by replaying their steps.
//!
//! The force is a piecewise smooth function of the parameters: with them move the steps' sizes and the stages in which
//! nodes are touched, released or let slide, and a difference of two free runs sees every such event between them.
//! Here both runs of a difference make the same steps and the same decisions of the contact as the run whose
//! derivatives are judged; what is left depends smoothly on the parameters, and differences can be small.

use crate::verification::sensitivities::value;
use poropunch::contact::decision::Decision;
use poropunch::contact::status::{Contact, Status};
use poropunch::contact::surface::Touch;
use poropunch::effect::EffectParameters;
use poropunch::law::{Magnitude, MaterialParameter, Spring};
use poropunch::motion::path::Path;
use poropunch::motion::protocol::Trapezoid;
use poropunch::parameters::MeshPreset;
use poropunch::solver::newton::NewtonFailure;
use poropunch::specimen::step::{Found, Solved, Task};
use poropunch::specimen::{Constants, Discretisation, Motion, Patience, Sample, State, Step, Stepper};
use poropunch::{ForceSensitivity, Instance, Model, Outputs, Parameters, Statistics};
use std::sync::atomic::{AtomicUsize, Ordering};

/// One step of a path, with everything that is needed to make it again.
struct Recorded {
    from_time: f64,
    motion: Motion,
    dt: f64,
    stages: Vec<Solved>,
    forces: Vec<ForceSensitivity>,
}

impl Recorded {
    fn decisions(&self) -> impl Iterator<Item = &Decision> {
        self.stages.iter().flat_map(|stage| &stage.decisions)
    }

    /// Whether a patch yields in one of its stages.
    fn yields(&self) -> bool {
        self.decisions().any(|decision| decision.corners().contains(&Status::Yields))
    }
}

/// A stepper that writes down the steps that its path keeps.
struct Recorder {
    stepper: Stepper,
    steps: Vec<Recorded>,
}

impl Discretisation for Recorder {
    fn undeformed(&self, time: f64) -> State {
        self.stepper.undeformed(time)
    }
    fn constants(&self) -> &Constants {
        self.stepper.constants()
    }
    fn touch(&self, contact: &Contact, x: &[f64]) -> Touch {
        self.stepper.touch(contact, x)
    }
    fn solve(&mut self, task: &Task<'_>, statistics: &mut Statistics) -> Result<Found, NewtonFailure> {
        self.stepper.solve(task, statistics)
    }
    fn step(
        &mut self,
        old: &State,
        motion: Motion,
        dt: f64,
        patience: Patience,
        statistics: &mut Statistics,
    ) -> Result<Step, NewtonFailure> {
        let step = self.stepper.step(old, motion, dt, patience, statistics)?;
        // A step that starts earlier than one before takes its place.
        self.steps.retain(|earlier| earlier.from_time < old.time);
        self.steps.push(Recorded {
            from_time: old.time,
            motion,
            dt,
            stages: step.stages.clone(),
            forces: step.state.sensitivity.as_ref().map(|s| s.forces.clone()).unwrap_or_default(),
        });
        Ok(step)
    }
}

/// What the force is differentiated by.
#[derive(Debug, Clone, Copy, PartialEq)]
enum By {
    Material(MaterialParameter),
    Effect(Magnitude),
}

impl By {
    /// All parameters of a material with so many branches.
    fn material(branches: usize) -> Vec<Self> {
        MaterialParameter::all(branches).map(Self::Material).collect()
    }

    /// Place among the derivatives of a material with so many branches.
    fn place(self, branches: usize) -> usize {
        match self {
            Self::Material(parameter) => parameter.index(),
            Self::Effect(magnitude) => MaterialParameter::count(branches) + magnitude.index(),
        }
    }

    /// To how far on either side differences are taken.
    fn step(self, parameters: &Parameters) -> f64 {
        match self {
            // What hardly matters has to move farther to stand out from rounding.
            Self::Material(parameter) => {
                let relative = if parameter == MaterialParameter::SolidFraction { 1.5e-1 } else { 3e-4 };
                relative * *value(&mut parameters.material.clone(), parameter)
            }
            Self::Effect(magnitude) => magnitude_of(magnitude).1,
        }
    }

    fn add(self, parameters: &mut Parameters, change: f64) {
        match self {
            Self::Material(parameter) => *value(&mut parameters.material, parameter) += change,
            Self::Effect(magnitude) => *magnitude_of(magnitude).0(&mut parameters.effect) += change,
        }
    }
}

type Field = fn(&mut EffectParameters) -> &mut f64;

/// Where a magnitude of the specimen is, and a small change of it.
fn magnitude_of(magnitude: Magnitude) -> (Field, f64) {
    match magnitude {
        Magnitude::InverseStress => (|e| &mut e.eyring.inverse_stress, 1e-6),
        Magnitude::PermeabilityExponent => (|e| &mut e.permeability.exponent, 1e-2),
        Magnitude::Loss => (|e| &mut e.softening.loss, 1e-4),
        Magnitude::LossStrain => (|e| &mut e.softening.strain, 5e-5),
        Magnitude::GrowthRate => (|e| &mut e.modulus_drift.rate, 1e-7),
        Magnitude::Amplitude => (|e| &mut e.amplitude.log_factor, 3e-4),
        Magnitude::ShearCompliance => (|e| &mut e.slip.compliance, 3e-10),
        Magnitude::AdhesiveStrength => (|e| &mut e.adhesion.strength, 3e-2),
        Magnitude::SurfaceHeight => (|e| &mut e.offset.height, 1e-8),
        Magnitude::MachineCompliance => (|e| &mut e.compliance.per_newton, 1e-6),
        Magnitude::DriftRate | Magnitude::Lag => panic!("the specimen does not feel the load cell"),
    }
}

/// A test: its parameters, protocol and the effects that act, by the names of their parameters.
struct Case {
    trapezoid: Trapezoid,
    preset: MeshPreset,
    settings: Vec<(&'static str, f64)>,
}

impl Case {
    fn parameters(&self) -> Parameters {
        let mut p = crate::verification::effects::parameters(&self.settings);
        p.mesh.preset = self.preset;
        p.mesh = p.resolved_mesh();
        p.solver.newton_tolerance = 1e-12;
        p
    }

    /// The steps of the test's path from first touch.
    fn record(&self, with_magnitudes: bool) -> Vec<Recorded> {
        let mut p = self.parameters();
        p.solver.sensitivities = true;
        p.solver.effect_sensitivities = with_magnitudes;
        let sample = Sample::shared_under(&p.indenter, &p.geometry, &p.mesh).unwrap();
        let mut recorder = Recorder { stepper: Stepper::new(&p.setup(), sample), steps: Vec::new() };
        let protocol = self.trapezoid.protocol().unwrap();
        let mut points = protocol.points().windows(2);
        let Some([(t0, d0), (t1, d1)]) = points.next() else { panic!("a protocol has legs") };
        let touch = t0 + (t1 - t0) * (-d0 / (d1 - d0));
        let mut path = Path::touch(&recorder, touch);
        let first = [(touch, 0.0), (*t1, *d1)];
        let mut statistics = Statistics::default();
        for pair in std::iter::once(&first[..]).chain(points) {
            let radius = p.geometry.reach();
            path.advance(&mut recorder, &p.solver, radius, pair[0], pair[1], &mut statistics).unwrap();
        }
        recorder.steps
    }

    /// Forces, total and fluid (N), at the ends of recorded steps for moved parameters.
    fn replay(&self, steps: &[Recorded], moved: &dyn Fn(&mut Parameters)) -> Vec<[f64; 2]> {
        let mut p = self.parameters();
        moved(&mut p);
        // The punch goes where the recorded one went, but for how far the surface moved.
        let shift = p.effect.offset.height - self.parameters().effect.offset.height;
        let sample = Sample::shared_under(&p.indenter, &p.geometry, &p.mesh).unwrap();
        let mut stepper = Stepper::new(&p.setup(), sample);
        let mut state = stepper.undeformed(steps[0].from_time);
        steps
            .iter()
            .map(|step| {
                assert_eq!(state.time, step.from_time);
                let Recorded { motion, dt, stages, .. } = step;
                let motion = Motion { start: motion.start + shift, ..*motion };
                let made = stepper.replay(&state, motion, *dt, stages, &mut Statistics::default());
                state = made.unwrap_or_else(|e| panic!("{:?}, {} s: {e}", self.settings, state.time)).state;
                [state.outputs.force_specimen, state.outputs.force_fluid]
            })
            .collect()
    }

    /// Derivatives of both forces by every parameter against central differences, as a part of each one's largest.
    fn check(&self, tolerance: f64) -> Vec<Recorded> {
        self.check_some(&By::material(self.parameters().material.branches.len()), tolerance)
    }

    /// The same by some of the parameters.
    fn check_some(&self, parameters: &[By], tolerance: f64) -> Vec<Recorded> {
        let steps = self.record(parameters.iter().any(|by| matches!(by, By::Effect(_))));
        for &by in parameters {
            let place = by.place(self.parameters().material.branches.len());
            // part, error over the largest value, time
            let worst = |step: f64| -> (usize, f64, f64) {
                let at = |change: f64| self.replay(&steps, &|p| by.add(p, change));
                let (up, down) = (at(step), at(-step));
                let of = |part: usize| {
                    let slopes: Vec<f64> =
                        up.iter().zip(&down).map(|(u, d)| (u[part] - d[part]) / (2.0 * step)).collect();
                    let largest = slopes.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
                    assert!(largest > 0.0, "{by:?} does not matter");
                    let error = |(recorded, slope): (&Recorded, &f64)| {
                        let s = recorded.forces[place];
                        let exact = [s.force, s.fluid][part];
                        (part, (exact - slope).abs() / largest, recorded.from_time + recorded.dt)
                    };
                    // What is no number counts as the largest error.
                    steps.iter().zip(&slopes).map(error).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
                };
                [of(0), of(1)].into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
            };
            let step = by.step(&self.parameters());
            // The difference's own error falls with the square of its step; that of a derivative stays.
            let mut found = worst(step);
            if found.1 >= tolerance {
                found = worst(step / 8.0);
            }
            assert!(found.1 < tolerance, "{:?} {by:?}: {found:?} (part, error, time)", self.settings);
        }
        steps
    }
}

fn case(trapezoid: Trapezoid, cycles: i32, preset: MeshPreset, settings: &[(&'static str, f64)]) -> Case {
    Case { trapezoid: Trapezoid { cycles, ..trapezoid }, preset, settings: settings.to_vec() }
}

/// Checks all cases on both cores, tells each that passes, and fails with all that do not.
fn check_all(cases: Vec<(Case, Vec<By>)>) {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut failed = Vec::new();
        while let Some((case, by)) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = format!("{:?} {:?} {:?}", case.trapezoid, case.preset, case.settings);
            match std::panic::catch_unwind(|| case.check_some(by, 1e-4)) {
                Ok(steps) => println!("{name}: {} steps", steps.len()),
                Err(_) => failed.push(name),
            }
        }
        failed
    };
    let failed = std::thread::scope(|scope| {
        let other = scope.spawn(work);
        [work(), other.join().unwrap()].concat()
    });
    assert!(failed.is_empty(), "{failed:#?}");
}

/// One parameter of each law.
const ONE_OF_EACH: [By; 4] = [
    By::Material(MaterialParameter::LambdaStar),
    By::Material(MaterialParameter::Permeability),
    By::Material(MaterialParameter::Mu(Spring::Equilibrium)),
    By::Material(MaterialParameter::Eta(1)),
];

/// Goal: dF/dtheta and dF_fluid/dtheta are exact at the end of every step of two cycles of P2: ramp, hold, peeling, separation, second
/// touch. Set-up: coarse mesh, the default step control, Newton to 1e-12, one parameter of each law. Reference: central differences of
/// replays, 3e-4 of the parameter to either side (n0S, which hardly matters: 15 %). Tolerance: 1e-4 of each derivative's largest value.
#[test]
fn two_cycles() {
    let steps = case(Trapezoid::p2(), 2, MeshPreset::Coarse, &[]).check_some(&ONE_OF_EACH, 1e-4);
    assert!(
        steps.iter().any(|s| s.stages.iter().any(|stage| stage.decisions.len() > 1)),
        "no contact changed"
    );
}

/// The same by all twelve parameters.
#[test]
#[ignore = "long: twenty seconds"]
fn two_cycles_by_all_parameters() {
    case(Trapezoid::p2(), 2, MeshPreset::Coarse, &[]).check(1e-4);
}

/// Magnitudes that change the force of the plain model in proportion.
const FROM_NULL: [By; 6] = [
    By::Effect(Magnitude::PermeabilityExponent),
    By::Effect(Magnitude::Loss),
    By::Effect(Magnitude::GrowthRate),
    By::Effect(Magnitude::Amplitude),
    By::Effect(Magnitude::SurfaceHeight),
    By::Effect(Magnitude::MachineCompliance),
];

/// All effects of specimen, contact and machine that have a magnitude.
const ACTING: [(&str, f64); 9] = [
    ("effect.eyring.inverse_stress", 5e-3),
    ("effect.permeability.exponent", 5.0),
    ("effect.softening.loss", 0.3),
    ("effect.modulus_drift.rate", 1e-3),
    ("effect.amplitude.log_factor", 0.2),
    ("effect.slip.compliance", 1e-6),
    ("effect.adhesion.strength", 100.0),
    ("effect.offset.height", 2e-5),
    ("effect.compliance.per_newton", 2e-3),
];

/// All magnitudes but the load cell's.
fn of_specimen() -> Vec<By> {
    Magnitude::ALL[..Magnitude::OF_SPECIMEN].iter().copied().map(By::Effect).collect()
}

/// Goal: the derivatives by the magnitudes of effects are exact, too, where the effects do not act. Set-up, reference and
/// tolerance as for two cycles. The force is an even function of Eyring's inverse stress: it has no slope at 0, and grows
/// with the square, to 2 %.
fn magnitudes_at_null(cycles: i32) {
    let case = case(Trapezoid::p2(), cycles, MeshPreset::Coarse, &[]);
    let steps = case.check_some(&FROM_NULL, 1e-4);
    let by = By::Effect(Magnitude::InverseStress);
    assert!(steps.iter().all(|step| step.forces[by.place(2)] == ForceSensitivity::default()));
    let at = |inverse_stress: f64| case.replay(&steps, &|p| by.add(p, inverse_stress));
    let (none, once, twice) = (at(0.0), at(1e-5), at(2e-5));
    let change = |k: usize, curve: &[[f64; 2]]| curve[k][0] - none[k][0];
    let largest =
        (0..steps.len()).max_by(|&a, &b| change(a, &twice).abs().total_cmp(&change(b, &twice).abs()));
    let ratio = change(largest.unwrap(), &twice) / change(largest.unwrap(), &once);
    assert!((ratio - 4.0).abs() < 0.08, "{ratio}");
}

#[test]
fn magnitudes_at_null_through_a_cycle() {
    magnitudes_at_null(1);
}

#[test]
#[ignore = "long: twenty seconds"]
fn magnitudes_at_null_through_two_cycles() {
    magnitudes_at_null(2);
}

/// Goal, reference and tolerance as for two cycles, of all magnitudes while all effects act.
#[test]
#[ignore = "long: half a minute"]
fn magnitudes_while_all_effects_act() {
    case(Trapezoid::p2(), 2, MeshPreset::Coarse, &ACTING).check_some(&of_specimen(), 1e-4);
}

/// The same of the strength of adhesion, where friction acts beside a part of the face that is bridged.
#[test]
#[ignore = "long: a quarter of a minute"]
fn strength_of_adhesion_with_friction() {
    let settings =
        [("effect.adhesion.strength", 100.0), ("boundary.friction", 0.3), ("indenter.profile", 2.0)];
    let case = case(Trapezoid::p2(), 2, MeshPreset::Coarse, &settings);
    let steps = case.check_some(&[By::Effect(Magnitude::AdhesiveStrength)], 1e-4);
    let slides = |decision: &Decision| {
        decision.corners().contains(&Status::Bridged)
            && decision.corners().iter().any(|c| matches!(c, Status::PushedInwards | Status::PushedOutwards))
    };
    assert!(steps.iter().flat_map(Recorded::decisions).any(slides), "nothing slides");
}

/// The same in whole tests of six cycles: both protocols, coarse and standard mesh; where no effect acts, where those of the laws or of
/// contact and machine do, softening with delay, adhesion under a flat punch and a sphere, friction alone. All effects together
/// strain the element beside the edge of the standard mesh beyond its range: they act on the coarse one.
#[test]
#[ignore = "long: 280 runs of six cycles"]
fn whole_tests_by_magnitudes() {
    use Magnitude::{
        AdhesiveStrength, Amplitude, GrowthRate, InverseStress, Loss, LossStrain, MachineCompliance,
        PermeabilityExponent, ShearCompliance, SurfaceHeight,
    };
    let laws = [
        ("effect.eyring.inverse_stress", 5e-3),
        ("effect.permeability.exponent", 5.0),
        ("effect.modulus_drift.rate", 1e-3),
        ("effect.amplitude.log_factor", 0.3),
        ("effect.offset.height", 2e-5),
    ];
    let machine = [("effect.compliance.per_newton", 2e-2), ("effect.slip.compliance", 1e-6)];
    let softening = [("effect.softening.loss", 0.3), ("effect.softening.delay", 20.0)];
    let adhesion = [("effect.adhesion.strength", 200.0)];
    let sphere = [("indenter.profile", 2.0), ("effect.adhesion.strength", 100.0)];
    let friction = [("boundary.friction", 0.3), ("boundary.partial_slip", 1.0)];
    let by = |magnitudes: &[Magnitude]| magnitudes.iter().copied().map(By::Effect).collect::<Vec<_>>();
    type Acting<'a> = &'a [(&'static str, f64)];
    let cases: [(Acting, Vec<By>); 7] = [
        (&[], FROM_NULL.to_vec()),
        (&laws, by(&[InverseStress, PermeabilityExponent, GrowthRate, Amplitude, SurfaceHeight])),
        (&machine, by(&[ShearCompliance, MachineCompliance])),
        (&softening, by(&[Loss, LossStrain])),
        (&adhesion, by(&[AdhesiveStrength, SurfaceHeight])),
        (&sphere, by(&[AdhesiveStrength, SurfaceHeight, MachineCompliance])),
        (&friction, by(&[AdhesiveStrength, SurfaceHeight])),
    ];
    let mut all = Vec::new();
    for trapezoid in [Trapezoid::p2(), Trapezoid::p1()] {
        all.push((case(trapezoid, 6, MeshPreset::Coarse, &ACTING), of_specimen()));
        for preset in [MeshPreset::Coarse, MeshPreset::Standard] {
            for (settings, magnitudes) in &cases {
                all.push((case(trapezoid, 6, preset, settings), magnitudes.clone()));
            }
        }
    }
    check_all(all);
}

/// Goal, reference and tolerance as for two cycles, where a patch yields for a stage and sticks again. Set-up: three
/// cycles of P2, a friction of 3, which holds more of what is pulled, one parameter of each law.
#[test]
#[ignore = "long: three cycles"]
fn a_patch_that_yields() {
    let steps = case(Trapezoid::p2(), 3, MeshPreset::Coarse, &[("boundary.friction", 3.0)]).check_some(
        &[MaterialParameter::Mu(Spring::Equilibrium), MaterialParameter::Eta(1)].map(By::Material),
        1e-4,
    );
    assert!(steps.iter().any(Recorded::yields), "no patch yields");
}

/// Checks derivatives where friction of 0.3 alone holds the face; the face slips both ways under pressure and sticks anew.
fn check_partial_slip(profile: f64, parameters: &[By]) {
    let settings =
        [("boundary.partial_slip", 1.0), ("boundary.friction", 0.3), ("indenter.profile", profile)];
    let steps = case(Trapezoid::p2(), 2, MeshPreset::Coarse, &settings).check_some(parameters, 1e-4);
    let slides =
        |step: &Recorded, status| step.decisions().any(|decision| decision.corners().contains(&status));
    for status in [Status::PushedInwards, Status::PushedOutwards] {
        assert!(steps.iter().any(|step| slides(step, status)), "nothing is {status:?}");
    }
}

/// Goal, reference and tolerance as for two cycles, where friction alone holds the face. Set-up: two cycles of P2 under a flat punch,
/// one parameter of the skeleton.
#[test]
fn partial_slip() {
    check_partial_slip(1.0, &[By::Material(MaterialParameter::LambdaStar)]);
}

/// The same under a flat punch and a sphere, one parameter of each law.
#[test]
#[ignore = "long: forty seconds"]
fn partial_slip_under_flat_and_sphere() {
    for profile in [1.0, 2.0] {
        check_partial_slip(profile, &ONE_OF_EACH);
    }
}

/// The same in whole tests of six cycles: bonded, frictionless and adhesive faces, weak friction, partial slip, a curved face, a compliant
/// machine, the effects of the specimen; on the coarse and the standard mesh.
fn whole_tests(trapezoid: Trapezoid) {
    let faces: [&[(&str, f64)]; 8] = [
        &[],
        &[("boundary.bonded_punch", 0.0)],
        &[("effect.adhesion.strength", 200.0)],
        &[("boundary.friction", 0.3)],
        &[("boundary.friction", 0.3), ("boundary.partial_slip", 1.0)],
        &[("indenter.profile", 2.0), ("effect.adhesion.strength", 100.0)],
        &[("effect.compliance.per_newton", 2e-2), ("effect.slip.compliance", 1e-6)],
        &[
            ("effect.eyring.inverse_stress", 5e-3),
            ("effect.permeability.exponent", 5.0),
            ("effect.modulus_drift.rate", 1e-3),
            ("effect.amplitude.log_factor", 0.3),
            ("effect.offset.height", 2e-5),
        ],
    ];
    let mut cases = Vec::new();
    for settings in faces {
        for preset in [MeshPreset::Coarse, MeshPreset::Standard] {
            cases.push((case(trapezoid, 6, preset, settings), By::material(2)));
        }
    }
    check_all(cases);
}

#[test]
#[ignore = "long: 400 runs of six cycles"]
fn whole_tests_of_p1() {
    whole_tests(Trapezoid::p1());
}

#[test]
#[ignore = "long: 400 runs of six cycles"]
fn whole_tests_of_p2() {
    whole_tests(Trapezoid::p2());
}

/// Goal: without effects of machine and sensor the derivatives of what is read are those of the specimen's force, at
/// every output. Set-up: six cycles of P2 by forty outputs a leg. Tolerance: none, bit for bit.
#[test]
fn reading_and_force_have_the_same_derivatives() {
    let mut p = crate::verification::effects::parameters(&[]);
    p.solver.sensitivities = true;
    let protocol = Trapezoid { cycles: 6, ..Trapezoid::p2() }.protocol().unwrap();
    let mut instance = Instance::new(&Model::new(p).unwrap(), protocol.points()[0].1).unwrap();
    let mut compared = 0;
    for pair in protocol.points().windows(2) {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        for k in 1..=40 {
            let part = f64::from(k) / 40.0;
            instance.set_displacement(a + (b - a) * part);
            instance.advance(from + (to - from) * part - instance.time()).unwrap();
            for s in instance.sensitivities() {
                assert_eq!(s.force.to_bits(), s.specimen.to_bits(), "{} s", instance.time());
                compared += 1;
            }
        }
    }
    assert!(compared > 10_000);
}

/// Goal: computing sensitivities changes no force through contact changes, without effects and with all. Tolerance: none, bit
/// for bit.
#[test]
#[ignore = "long: six runs of two cycles"]
fn sensitivities_leave_the_forces_alone() {
    for settings in [&[][..], &ACTING] {
        let case = case(Trapezoid::p2(), 2, MeshPreset::Coarse, settings);
        let curve = |sensitivities, effect_sensitivities| {
            let mut p = case.parameters();
            (p.solver.sensitivities, p.solver.effect_sensitivities) = (sensitivities, effect_sensitivities);
            tests::follow(&p, &case.trapezoid.protocol().unwrap(), 12)
        };
        let plain = curve(false, false);
        for with in [curve(true, false), curve(true, true)] {
            let same = |((_, a), (_, b)): (&(f64, Outputs), &(f64, Outputs))| {
                a.force.to_bits() == b.force.to_bits()
                    && a.stored_energy.to_bits() == b.stored_energy.to_bits()
            };
            assert!(plain.iter().zip(&with).all(same), "{settings:?}");
        }
    }
}
