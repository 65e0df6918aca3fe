//! The near ground's forces: the engine on a finer mesh and with another time scheme than the diagnosis'.

use super::cause::Cause;
use super::form::Form;
use super::make::MakeError;
use super::reading::Record;
use super::simulate::{Source, Test};
use crate::engine::Engine;
use crate::pool::{Job, Priority, Run};
use poropunch::motion::protocol::{Protocol, ProtocolError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The engine with a mesh and time steps.
pub struct ByEngine<'a> {
    /// It runs here.
    pub engine: &'a Engine,
    /// Mesh and time steps.
    pub numerics: &'a BTreeMap<String, f64>,
}

/// Parts of each interval at which the force is computed, for filters.
const PARTS: u32 = 4;

/// A run that was started.
struct Started<'a> {
    run: Run,
    dense_s: Vec<f64>,
    forms: Vec<&'a Form>,
    index: usize,
    test: &'a Test,
}

impl Source for ByEngine<'_> {
    fn readings_n(
        &self,
        material: &BTreeMap<String, f64>,
        sets: &[Vec<Cause>],
        tests: &[Test; 2],
        _: f64,
    ) -> Result<Vec<Vec<Vec<f64>>>, MakeError> {
        let mut started = Vec::new();
        for causes in sets {
            let of = |t: (usize, _)| self.start(material, causes, t);
            started.push(tests.iter().enumerate().map(of).collect::<Result<Vec<_>, _>>()?);
        }
        started.iter().map(|tests| tests.iter().map(Started::reading_n).collect()).collect()
    }

    /// Its steps are verified (`tests/verification/`), and short: they are not asked for again.
    fn error_of_steps(
        &self,
        _: &BTreeMap<String, f64>,
        _: &[Cause],
        _: &[Test; 2],
        _: &[Vec<f64>],
        _: f64,
    ) -> Result<f64, MakeError> {
        Ok(0.0)
    }
}

impl ByEngine<'_> {
    fn start<'b>(
        &self,
        material: &BTreeMap<String, f64>,
        causes: &'b [Cause],
        (index, test): (usize, &'b Test),
    ) -> Result<Started<'b>, ProtocolError> {
        let of_engine = |cause: &'b Cause| if let Cause::Engine(form) = cause { Some(form) } else { None };
        let forms: Vec<&Form> = causes.iter().filter_map(of_engine).collect();
        let mut parameters = material.clone();
        parameters.extend(self.numerics.clone());
        let mut points = test.protocol.points().to_vec();
        for form in &forms {
            form.set(&mut parameters);
            points = form.moved(&points);
        }
        let mut dense_s = vec![test.time_s[0]];
        for w in test.time_s.windows(2) {
            dense_s.extend((1..PARTS).map(|k| w[0] + (w[1] - w[0]) * f64::from(k) / f64::from(PARTS)));
            dense_s.push(w[1]);
        }
        let job =
            Job { parameters, protocol: Arc::new(Protocol::new(points)?), time_s: dense_s.clone().into() };
        let run = self.engine.submit(&job, Priority::Urgent);
        Ok(Started { run, dense_s, forms, index, test })
    }
}

impl Started<'_> {
    /// The reading at the sample times (N).
    fn reading_n(&self) -> Result<Vec<f64>, MakeError> {
        let mut force_n = self.run.wait()?.force_n().to_vec();
        let record = Record { test: self.index, ramp_end_s: self.test.ramp_end_s, time_s: &self.dense_s };
        self.forms.iter().for_each(|form| form.read(record, &mut force_n));
        Ok(force_n.into_iter().step_by(PARTS as usize).collect())
    }
}
