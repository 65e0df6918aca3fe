//! Which further test would tell the surviving explanations apart.
//!
//! One explanation A is taken to be true; it predicts the force of a candidate test. The other one, B, is fitted to what was measured and
//! that prediction together, linearised: `|P [0; inv(L)(F_A - F_B)]|^2` with `P` the projector of B's derivatives over both is the fall of
//! chi^2 that the new test is expected to show against B, twice the log evidence but for what both have in common.

use super::confirming::Refit;
use crate::data::Measurement;
use crate::data::random::Random;
use crate::fit::{EvaluationFailure, Problem, Whitening};
use crate::inference::effect::{Candidate, Place, is_continuous};
use crate::inference::fit::{FitFailure, least_chi_square};
use crate::inference::rough::Twin;
use crate::inference::{ForceProblem, Linearised, Setup, Unknowns};
use crate::noise::{NoiseModel, Observation, Weights, noise_model};
use nalgebra::DVector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RADIUS: &str = "geometry.punch_radius";
/// Times and depths are changed by these factors, within what a machine and a specimen bear.
const RATE: f64 = 10.0;
const LONGER: f64 = 10.0;
const DEEPER: f64 = 1.5;
/// A depth beyond this part of the specimen's height is not proposed.
const DEEPEST: f64 = 0.5;
/// Points of each straight part of the motion.
const POINTS: usize = 40;
/// Falls of chi^2 that tell explanations apart, as the odds that they are: 400 and 20.
const SURELY: f64 = 12.0;
const PROBABLY: f64 = 6.0;
/// Evaluations of a refit with a test that was proposed.
const EVALUATIONS: usize = 40;

/// A test that is proposed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Proposal {
    /// What to do.
    pub what: String,
    /// Fall of chi^2 that tells the explanations apart; none where the test tells the machine's from the specimen's by itself.
    pub evidence: Option<f64>,
}

impl Proposal {
    /// In a sentence.
    pub fn in_words(&self) -> String {
        match self.evidence {
            None => self.what.clone(),
            Some(evidence) => {
                let odds = match evidence {
                    e if e > SURELY => "would tell them apart",
                    e if e > PROBABLY => "would probably tell them apart",
                    _ => "would hardly tell them apart",
                };
                format!("{}: {odds} (expected fall of chi^2 {evidence:.0})", self.what)
            }
        }
    }
}

/// A candidate: the motion (s, m), and a parameter that it changes.
struct Test {
    what: &'static str,
    corners: Vec<(f64, f64)>,
    changed: Option<(&'static str, f64)>,
}

/// Tests that would tell the explanations apart, the best first; for groups of three what the worst told two of them have.
///
/// # Errors
/// When the user asked to stop.
pub fn proposals(
    setup: Setup,
    candidates: &[Candidate],
    noise: &NoiseModel,
    rivals: &[&Refit],
    sample_height_m: Option<f64>,
) -> Result<Vec<Proposal>, EvaluationFailure> {
    if rivals.len() < 2 {
        return Ok(vec![]);
    }
    let mut found = Vec::new();
    for test in tests(setup, sample_height_m) {
        found.extend(value(setup, candidates, noise, rivals, &test)?.map(|evidence| (evidence, test.what)));
    }
    found.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let proposal =
        |&(evidence, what): &(f64, &str)| Proposal { what: what.to_owned(), evidence: Some(evidence) };
    let mut all: Vec<Proposal> = found.iter().map(proposal).collect();
    let outside = rivals.iter().filter(|r| is_outside(r, candidates)).count();
    if outside > 0 && outside < rivals.len() {
        // Without a specimen there are two answers: for more explanations, a test that tells all of them apart is worth more.
        let all_apart = found.iter().take_while(|(evidence, _)| *evidence > SURELY).count();
        let place = if rivals.len() > 2 { all_apart } else { 0 };
        let what = "the same motion on a stiff blank (steel, or a spring): what is left there is the machine's or the sensor's";
        all.insert(place, Proposal { what: what.to_owned(), evidence: None });
    }
    Ok(all)
}

/// Whether an explanation acts without a specimen, too.
pub fn is_outside(refit: &Refit, candidates: &[Candidate]) -> bool {
    refit.members.iter().all(|k| matches!(candidates[*k].effect.place, Place::Machine | Place::Sensor))
}

/// Changes of the deepest test that was made.
fn tests(setup: Setup, sample_height_m: Option<f64>) -> Vec<Test> {
    let cycles = setup.observations.iter().filter_map(|o| o.cycles.first());
    let Some(cycle) = cycles.max_by(|a, b| a.depth_m.total_cmp(&b.depth_m)) else { return vec![] };
    let (depth, ramp, hold) =
        (cycle.depth_m, cycle.times.ramp_end_s - cycle.times.ramp_start_s, cycle.hold_s());
    let held = |depth: f64, ramp: f64, hold: f64| vec![(0.0, 0.0), (ramp, depth), (ramp + hold, depth)];
    let mut cycled = vec![(0.0, 0.0)];
    for start in [0.0, 1.0, 2.0].map(|k| k * (2.0 * ramp + 2.0 * hold)) {
        cycled.push((start + ramp, depth));
        cycled.push((start + ramp + hold, depth));
        cycled.push((start + 2.0 * ramp + hold, 0.0));
        cycled.push((start + 2.0 * ramp + 2.0 * hold, 0.0));
    }
    let test = |what, corners| Test { what, corners, changed: None };
    let mut all = vec![
        test("loading ten times as slowly", held(depth, RATE * ramp, hold)),
        test("loading ten times as fast", held(depth, ramp / RATE, hold)),
        test("half the depth", held(0.5 * depth, 0.5 * ramp, hold)),
        test("a hold ten times as long", held(depth, ramp, LONGER * hold)),
        test("three cycles, with rests as long as the hold", cycled),
    ];
    if sample_height_m.is_some_and(|height| DEEPER * depth < DEEPEST * height) {
        all.push(test("one and a half times the depth", held(DEEPER * depth, DEEPER * ramp, hold)));
    }
    let radius = setup.value(&setup.unknowns.settings(setup.unknowns.start()), RADIUS);
    if let Some(radius) = radius.filter(|_| setup.engine.is_own()) {
        let corners = held(0.5 * depth, 0.5 * ramp, hold);
        let what = "half the depth with a punch of half the radius";
        all.push(Test { what, corners, changed: Some((RADIUS, 0.5 * radius)) });
    }
    all
}

/// White noise of a further test (mN): that of the noisiest one.
fn white_mn(noise: &NoiseModel) -> f64 {
    noise.tests.iter().map(|t| t.white_mn.mean()).fold(0.0, f64::max)
}

impl Test {
    /// What is fitted, with what the test changes.
    fn unknowns(&self, setup: Setup) -> Unknowns {
        setup.unknowns.clone().with_fixed(&self.changed.into_iter().collect::<Vec<_>>())
    }

    /// The test with this force (mN) and its deviation (mN).
    fn observation(&self, force_mn: &[f64], white_mn: f64) -> Option<Observation> {
        let (time_s, displacement_m) = self.motion();
        let spread_n = Some(vec![white_mn * 1e-3; time_s.len()]);
        let force_n = force_mn.iter().map(|f| f * 1e-3).collect();
        let measurement = Measurement { time_s, displacement_m, force_n, spread_n, ..Measurement::default() };
        Observation::new(&measurement, None).ok()
    }

    /// The test before it is made: without force.
    fn silent(&self, white_mn: f64) -> Option<[Observation; 1]> {
        Some([self.observation(&vec![0.0; self.motion().0.len()], white_mn)?])
    }

    /// The test where the true force is `true_mn` and `measured_mn` was measured, and its noise.
    fn measured(
        &self,
        true_mn: &[f64],
        measured_mn: &[f64],
        white_mn: f64,
    ) -> Option<([Observation; 1], NoiseModel)> {
        let observed = [self.observation(measured_mn, white_mn)?];
        let model = noise_model(&observed, true_mn, vec![], &Weights::default()).ok()?;
        Some((observed, model))
    }

    /// Times (s) and depths (m).
    fn motion(&self) -> (Vec<f64>, Vec<f64>) {
        let (mut time_s, mut displacement_m) = (vec![0.0], vec![0.0]);
        for pair in self.corners.windows(2) {
            let ((from, a), (to, b)) = (pair[0], pair[1]);
            for k in 1..=POINTS {
                // Dense where a straight part begins: relaxation is fast there.
                let part = (k as f64 / POINTS as f64).powi(3);
                time_s.push(from + part * (to - from));
                displacement_m.push(a + part * (b - a));
            }
        }
        (time_s, displacement_m)
    }
}

/// Expected fall of chi^2 against the wrong explanation, of the two that the test tells apart worst; none where the model fails.
fn value(
    setup: Setup,
    candidates: &[Candidate],
    noise: &NoiseModel,
    rivals: &[&Refit],
    test: &Test,
) -> Result<Option<f64>, EvaluationFailure> {
    let unknowns = test.unknowns(setup);
    let white_mn = white_mn(noise);
    let Some(silent) = test.silent(white_mn) else { return Ok(None) };
    let there = Setup { observations: &silent, unknowns: &unknowns, ..setup };
    // What the explanations differ by is the same by a rougher model.
    let every: Vec<&Candidate> = rivals.iter().flat_map(|rival| rival.active(candidates)).collect();
    let twin = Twin::leading(there, &every);
    let there = Twin::setup_or(twin.as_ref(), there);
    // Forces (mN) and their derivatives, each explanation's.
    let mut all = Vec::new();
    for rival in rivals {
        let forces = ForceProblem::new(there, &rival.active(candidates)).with_jacobian(&rival.fit.solution.x);
        match EvaluationFailure::or_none(forces)? {
            Some((force_mn, jacobian_mn)) => all.push((DVector::from_vec(force_mn), jacobian_mn)),
            None => return Ok(None),
        }
    }
    let mut least = f64::INFINITY;
    for (a, (true_mn, _)) in all.iter().enumerate() {
        let measured = test.measured(true_mn.as_slice(), true_mn.as_slice(), white_mn);
        let Some((_, model)) = measured else { return Ok(None) };
        for (b, (wrong_mn, jacobian_mn)) in all.iter().enumerate().filter(|(b, _)| *b != a) {
            let before = &rivals[b].fit.linear.design;
            let added = model.covariance.apply_columns(jacobian_mn);
            let (n, m) = (before.nrows(), added.nrows());
            let mut design = before.clone().resize_vertically(n + m, 0.0);
            design.rows_mut(n, m).copy_from(&added);
            let mut difference = DVector::zeros(n + m);
            difference.rows_mut(n, m).copy_from(&model.covariance.apply(&(true_mn - wrong_mn)));
            least = least.min(Linearised::new(design, &difference).residual.norm_squared());
        }
    }
    Ok(least.is_finite().then_some(least))
}

/// What a test that is proposed would tell: chi^2 of each explanation, refitted to what was measured and to this test together, which is
/// simulated with the explanation `truth` and white noise; none where the model fails, or the test decides by itself.
///
/// # Errors
/// When the user asked to stop.
pub fn told_apart(
    setup: Setup,
    candidates: &[Candidate],
    noise: &NoiseModel,
    rivals: &[&Refit],
    proposal: &Proposal,
    (truth, seed): (usize, u64),
) -> Result<Option<Vec<f64>>, EvaluationFailure> {
    let Some(test) = tests(setup, Some(f64::INFINITY)).into_iter().find(|t| t.what == proposal.what) else {
        return Ok(None);
    };
    let unknowns = test.unknowns(setup);
    let white_mn = white_mn(noise);
    let Some(silent) = test.silent(white_mn) else { return Ok(None) };
    let there = Setup { observations: &silent, unknowns: &unknowns, ..setup };
    let Refit { fit, .. } = rivals[truth];
    let forces = ForceProblem::new(there, &rivals[truth].active(candidates)).residual(&fit.solution.x);
    let Some(true_mn) = EvaluationFailure::or_none(forces)? else { return Ok(None) };
    let mut random = Random::new(seed);
    let measured_mn: Vec<f64> = true_mn.iter().map(|f| f + white_mn * random.normal()).collect();
    let Some((observed, model)) = test.measured(&true_mn, &measured_mn, white_mn) else { return Ok(None) };
    let there = Setup { observations: &observed, ..there };
    let all = [(setup, &noise.covariance), (there, &model.covariance)];
    let mut found = Vec::new();
    for rival in rivals {
        match least_chi_square(&all, &rival.active(candidates), &rival.fit.solution.x, EVALUATIONS) {
            Ok(chi_square) => found.push(chi_square),
            Err(FitFailure::Evaluation(EvaluationFailure::Interrupted)) => {
                return Err(EvaluationFailure::Interrupted);
            }
            Err(_) => return Ok(None),
        }
    }
    Ok(Some(found))
}

/// The refits of these candidates alone, as far as they have a size of their own.
pub fn rivals<'a>(refits: &'a [Refit], members: &[usize], candidates: &[Candidate]) -> Vec<&'a Refit> {
    let of = |k: &usize| refits.iter().find(|r| r.members == [*k] && is_continuous(&candidates[*k]));
    members.iter().filter_map(of).collect()
}
