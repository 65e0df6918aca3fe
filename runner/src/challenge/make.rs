//! `runner challenge make`: cases for the diagnosis, and their sealed key.

use super::by_engine::ByEngine;
use super::by_maker::{ByMaker, SHORT_STEPS};
use super::draw::{Drawn, Kind, again, and_others, draw};
use super::ground::Ground;
use super::key::{CASES, CONTENT, Key, Replaced, SEAL, Secret, Solution, hash, sealed};
use super::noise::{csv, measured_n};
use super::oracle::{Oracle, Seen};
use super::simulate::{Source, Test, tests};
use crate::data::{DataError, Measurement, Wanted, read_str};
use crate::engine::Engine;
use crate::fit::EvaluationFailure;
use crate::inference::ParameterError;
use crate::inference::fit::FitFailure;
use crate::noise::ObservationError;
use crate::output::mark::marked;
use crate::output::{OutputError, check_free, claim_directory, write_file};
use crate::pool::RunFailure;
use crate::setting::SettingError;
use poropunch::motion::protocol::ProtocolError;
use poropunch_maker::MakerError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Cases that cannot be made.
#[derive(Debug, Error)]
pub enum MakeError {
    /// A motion.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// A simulation.
    #[error("a case cannot be simulated: {0}")]
    Run(#[from] RunFailure),
    /// The same by the independent solver.
    #[error("a case cannot be simulated: {0}")]
    Maker(#[from] MakerError),
    /// Threads for it.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A file that was written is not read as a measurement.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The same.
    #[error(transparent)]
    Dataset(#[from] ObservationError),
    /// The FMU's parameters.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A value of one.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A simulation with derivatives.
    #[error("a case cannot be simulated: {0}")]
    Evaluation(#[from] EvaluationFailure),
    /// Likewise, where a cause is refitted.
    #[error("a case cannot be refitted: {0}")]
    Fit(#[from] FitFailure),
    /// A file.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Changes of the force by a cause, or the derivatives beside them.
    #[error("a cause changes the force by what is no number")]
    NotFinite,
    /// The key.
    #[error("the key cannot be sealed")]
    Seal,
    /// The force depends on the time steps: it has several solutions near each other, where a face sticks or opens.
    #[error("other time steps change the force by {0:.1} % of the largest one")]
    Steps(f64),
    /// No draw of a case could be taken.
    #[error("case {number}: none of {attempts} draws can be taken; try another seed, or more cycles")]
    NoDraw {
        /// Which case, from 1.
        number: usize,
        /// Draws that were tried.
        attempts: u64,
    },
}

impl MakeError {
    /// Whether another draw may do better: this one cannot be computed, or depends on the time steps.
    fn is_of_the_draw(&self) -> bool {
        use EvaluationFailure::Failed;
        matches!(
            self,
            Self::Run(RunFailure::Model(_)) | Self::Maker(_) | Self::Evaluation(Failed(_)) | Self::Steps(_)
        )
    }
}

/// What is made.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// Seed of all draws.
    pub seed: u64,
    /// Number of cases.
    pub cases: usize,
    /// Their kinds; all where none is given.
    pub kinds: &'a [Kind],
    /// Where they are drawn from.
    pub ground: Ground,
    /// Whether single effects and pairs are drawn again until each cause can be seen.
    pub visible: bool,
    /// Cycles of each test.
    pub cycles: i32,
    /// The engine's mesh and time steps: for the near ground's forces, and for the derivatives that tell what can be seen.
    pub numerics: BTreeMap<String, f64>,
    /// Runs of the independent solver at a time; 0: as many as there are cores.
    pub jobs: usize,
    /// Folder of the cases.
    pub out: &'a Path,
    /// File of the key.
    pub key: &'a Path,
}

/// What was made.
#[derive(Clone)]
pub struct Made {
    /// What opens the key.
    pub secret: Secret,
    /// Draws that others replace: they could not be computed, or depend on the time steps, however short.
    pub replaced: usize,
}

/// Times that a case which cannot be simulated is drawn again before the maker gives up.
pub const ATTEMPTS: u64 = 8;
/// Times that one is drawn whose causes should be visible: of pairs, one in thirteen is.
pub const VISIBLE_ATTEMPTS: u64 = 100;
/// Largest part of the largest force that the time steps may change: a fifth of the gap that matters. Of most cases it is a thousandth; the
/// others are computed with shorter steps.
pub const LARGEST_ERROR_OF_STEPS: f64 = 2e-3;

/// Writes the cases to `cases/ID/P1.csv` and `P2.csv`, the sealed key, and its hash beside the cases.
///
/// # Errors
/// When a case cannot be simulated or written.
pub fn make(engine: &Engine, plan: &Plan, say: &mut dyn FnMut(String)) -> Result<Made, MakeError> {
    let is_stopped = || engine.is_stopped();
    let by_engine = ByEngine { engine, numerics: &plan.numerics };
    let by_maker = ByMaker::new(plan.jobs, &is_stopped)?;
    let source: &dyn Source = match plan.ground {
        Ground::Near => &by_engine,
        Ground::Wide => &by_maker,
    };
    let folder = plan.out.join(CASES);
    // What is refused leaves nothing behind.
    check_free(&folder, "--out")?;
    check_free(plan.key, "--key")?;
    claim_directory(&folder, "--out")?;
    let mut maker = Maker { engine, plan, tests: tests(plan.cycles)?, source, replaced: vec![] };
    let mut cases = Vec::new();
    for (number, drawn) in draw(plan.seed, plan.cases, plan.kinds, plan.ground).into_iter().enumerate() {
        say(format!("case {} of {}", number + 1, plan.cases));
        let chosen = plan.visible && matches!(drawn.kind, Kind::Single | Kind::Pair);
        let attempts = if chosen { VISIBLE_ATTEMPTS } else { ATTEMPTS };
        // Draws of one case are apart from each other's further ones.
        let mut draws = and_others(&drawn, ATTEMPTS + 1, plan.ground).take(attempts as usize);
        let solution = loop {
            let Some(drawn) = draws.next() else {
                return Err(MakeError::NoDraw { number: number + 1, attempts });
            };
            if chosen && maker.is_hidden(&drawn) {
                continue;
            }
            let is_wanted = |solution: &Solution| !chosen || solution.is_visible();
            let made = maker.computable(&drawn)?;
            let settled = if is_wanted(&made.0) { maker.settled(made)? } else { None };
            if let Some((solution, files)) = settled.filter(|(solution, _)| is_wanted(solution)) {
                files.iter().try_for_each(|(path, text)| write_file(path, text.as_bytes()))?;
                break solution;
            }
        };
        cases.push(solution);
    }
    let Maker { replaced, .. } = maker;
    let (schema, ground, replacements) = (CONTENT.to_owned(), plan.ground, replaced.len());
    let key = Key { schema, seed: plan.seed, ground, cycles: plan.cycles, cases, replaced };
    let secret = Secret::random();
    write_sealed(&key, &secret, plan.key, plan.out)?;
    Ok(Made { secret, replaced: replacements })
}

/// Writes a key that the secret opens to `file`, and its hash beside the cases in `out`.
///
/// # Errors
/// When it cannot be sealed or written.
pub fn write_sealed(key: &Key, secret: &Secret, file: &Path, out: &Path) -> Result<(), MakeError> {
    let bytes = marked(file, &sealed(key, secret).ok_or(MakeError::Seal)?).into_owned();
    write_file(file, &bytes)?;
    write_file(&out.join(SEAL), format!("{}\n", hash(&bytes)).as_bytes())?;
    Ok(())
}

/// Paths of a case's files and what is to be in them.
pub type Files = Vec<(PathBuf, String)>;

/// The files of a case in a challenge's folder, of readings without noise (N).
pub fn files(out: &Path, drawn: &Drawn, tests: &[Test; 2], readings_n: &[Vec<f64>]) -> Files {
    let folder = out.join(CASES).join(&drawn.id);
    let measured_n = measured_n(drawn, tests, readings_n);
    let file = |(test, n): (&Test, &Vec<Vec<f64>>)| (folder.join(format!("{}.csv", test.name)), csv(test, n));
    tests.iter().zip(&measured_n).map(file).collect()
}

/// A challenge that is being made.
struct Maker<'a> {
    engine: &'a Engine,
    plan: &'a Plan<'a>,
    tests: [Test; 2],
    source: &'a dyn Source,
    replaced: Vec<Replaced>,
}

impl Maker<'_> {
    /// The case, or another one of its kind where some material and causes together are beyond what the mesh can follow.
    fn computable(&mut self, drawn: &Drawn) -> Result<(Solution, Files), MakeError> {
        let ground = self.plan.ground;
        for next in and_others(drawn, 1, ground).take(ATTEMPTS as usize) {
            if let Some(made) = self.or_replaced(&next, self.one(next.clone(), 1.0))? {
                return Ok(made);
            }
        }
        self.one(again(drawn, ATTEMPTS, ground), 1.0)
    }

    /// The case with a force that does not depend on the time steps, which are shortened where it does; a draw whose force does not settle
    /// is replaced.
    fn settled(&mut self, made: (Solution, Files)) -> Result<Option<(Solution, Files)>, MakeError> {
        let drawn = made.0.drawn.clone();
        let found = match self.checked(made, 1.0) {
            Err(MakeError::Steps(_)) => {
                self.one(drawn.clone(), SHORT_STEPS).and_then(|made| self.checked(made, SHORT_STEPS))
            }
            other => other,
        };
        self.or_replaced(&drawn, found)
    }

    /// What was made of a draw; `None` where it is kept for the key, as another one replaces it.
    fn or_replaced<T>(&mut self, drawn: &Drawn, made: Result<T, MakeError>) -> Result<Option<T>, MakeError> {
        match made {
            Err(e) if e.is_of_the_draw() => {
                self.replaced.push(Replaced { drawn: drawn.clone(), reason: e.to_string() });
                Ok(None)
            }
            made => made.map(Some),
        }
    }

    /// A case with this part of the steps' tolerance, unless its force depends on the steps.
    fn checked(
        &self,
        made: (Solution, Files),
        part_of_tolerance: f64,
    ) -> Result<(Solution, Files), MakeError> {
        let Drawn { material, causes, .. } = &made.0.drawn;
        let truth_n = made.0.truth_n();
        let error = self.source.error_of_steps(material, causes, &self.tests, &truth_n, part_of_tolerance)?;
        if error <= LARGEST_ERROR_OF_STEPS { Ok(made) } else { Err(MakeError::Steps(100.0 * error)) }
    }

    fn one(&self, drawn: Drawn, part_of_tolerance: f64) -> Result<(Solution, Files), MakeError> {
        let tests = &self.tests;
        // With all causes, without any, and with each of them alone.
        let mut sets = vec![drawn.causes.clone()];
        if !drawn.causes.is_empty() {
            sets.push(vec![]);
        }
        if drawn.causes.len() > 1 {
            sets.extend(drawn.causes.iter().map(|c| vec![c.clone()]));
        }
        let readings = self.source.readings_n(&drawn.material, &sets, tests, part_of_tolerance)?;
        let (files, measurements) = self.recorded(&drawn, &readings[0])?;
        let alone = if readings.len() > 2 { &readings[2..] } else { &readings[..drawn.causes.len()] };
        let changes: Vec<Vec<f64>> = alone.iter().map(|r| change_mn(r, &readings[1])).collect();
        let seen = match changes[..] {
            [] => vec![],
            _ => self.oracle(&drawn, &measurements)?.seen(&changes)?,
        };
        let (visibility, gap_percent) = seen.iter().map(|s| (s.score, s.gap_percent)).unzip();
        Ok((Solution::new(drawn, visibility, gap_percent, &readings[0]), files))
    }

    fn oracle(&self, drawn: &Drawn, measurements: &[Measurement]) -> Result<Oracle<'_>, MakeError> {
        Oracle::new(self.engine, drawn, &self.plan.numerics, measurements)
    }

    /// Files of a case, and what they say.
    fn recorded(
        &self,
        drawn: &Drawn,
        readings_n: &[Vec<f64>],
    ) -> Result<(Files, Vec<Measurement>), MakeError> {
        let files = files(self.plan.out, drawn, &self.tests, readings_n);
        let measurements = files.iter().map(|(path, text)| read_str(text, path, Wanted::MotionAndForce));
        let measurements = measurements.collect::<Result<_, _>>()?;
        Ok((files, measurements))
    }

    /// Whether one of several causes is surely hidden: each alone is computed in turn, and what that shows beside those before.
    fn is_hidden(&self, drawn: &Drawn) -> bool {
        let is_hidden_beside_those_before = |causes: usize| {
            let alone = drawn.causes[..causes].iter().map(|cause| vec![cause.clone()]);
            let sets: Vec<_> = std::iter::once(vec![]).chain(alone).collect();
            let readings = self.source.readings_n(&drawn.material, &sets, &self.tests, 1.0)?;
            let (_, measurements) = self.recorded(drawn, &readings[1])?;
            let mut changes: Vec<_> = readings[1..].iter().map(|r| change_mn(r, &readings[0])).collect();
            // Those that are not computed yet change nothing.
            changes.resize(drawn.causes.len(), vec![0.0; changes[0].len()]);
            let seen = self.oracle(drawn, &measurements)?.seen_linearly(&changes)?;
            Ok::<_, MakeError>(seen[..causes].iter().any(Seen::is_surely_hidden))
        };
        // What cannot be computed is told where the case is made.
        drawn.causes.len() > 1
            && (1..=drawn.causes.len()).any(|causes| is_hidden_beside_those_before(causes).unwrap_or(false))
    }
}

/// Change of the readings (mN) of all tests, one after the other, against others (N).
fn change_mn(readings_n: &[Vec<f64>], plain_n: &[Vec<f64>]) -> Vec<f64> {
    let pairs = readings_n.iter().flatten().zip(plain_n.iter().flatten());
    pairs.map(|(with, without)| (with - without) * 1e3).collect()
}
