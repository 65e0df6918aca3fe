//! `runner simulate`: motion in, force curve out.

use super::assumed;
use super::engine_args::{EngineArguments, RunArguments};
use super::exit::UsageError;
use super::fields::FieldArguments;
use super::heading::Heading;
use super::idle::nothing_fitted;
use super::job::Invocation;
use super::plots::force_plot;
use super::protocols::motion;
use super::terminal;
use super::{CliResult, Ending};
use crate::output::{check_no_device, curve_csv, mark_written, write_file};
use crate::pool::wiring::{Names, asks_for};
use crate::pool::{ForceCurve, Job, Priority, RunFailure};
use crate::setting::settings_from;
use clap::{Args, ValueHint};
use poropunch::variables::sensitivities;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Compute the force of a protocol or of a measured motion.
#[derive(Debug, Args)]
pub struct Arguments {
    /// P1 or P2 (the paper's first cycle, to the end of the hold), or a CSV file with time_s,displacement_mm
    #[arg(value_name = "PROTOCOL|FILE", value_hint = ValueHint::FilePath)]
    motion: String,
    /// Where to write: PATH.csv and PATH.svg [default: the protocol's name]
    #[arg(long, short, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Outputs to record beside the force, e.g. stored_energy or sensitivity.force (derivatives by every
    /// material parameter); all but the derivatives with `all`
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_value = "force_solid,force_fluid")]
    record: Vec<String>,
    /// Complete cycles of P1 or P2, with unloading and rests; without it, the first cycle to the end of the hold
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i32).range(1..=1000))]
    cycles: Option<i32>,
    /// Number of output times for P1 and P2, a file has its own [default: 300]
    #[arg(long, value_name = "N", value_parser = super::count::points)]
    points: Option<usize>,
    #[command(flatten)]
    fields: FieldArguments,
    #[command(flatten)]
    run: RunArguments,
}

/// A force curve: what `--json` prints. All series have the length of `time_s`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Simulation {
    /// `poropunch.simulation/1`.
    pub schema: String,
    /// Which command, which model, which parameters.
    #[serde(flatten)]
    pub heading: Heading,
    /// Name of the motion.
    pub motion: String,
    /// Times (s).
    pub time_s: Vec<f64>,
    /// Displacement of the punch, positive into the sample (mm).
    pub displacement_mm: Vec<f64>,
    /// Outputs by their names, SI units; the first is the force (N).
    pub outputs: Vec<Series>,
}

/// One output over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Series {
    /// Name of the output.
    pub name: String,
    /// Its values, SI units.
    pub values: Vec<f64>,
}

impl Simulation {
    fn of(heading: Heading, motion: &str, curve: &ForceCurve) -> Self {
        let series =
            |(name, values): (&String, &Vec<f64>)| Series { name: name.clone(), values: values.clone() };
        Self {
            schema: "poropunch.simulation/1".to_owned(),
            heading,
            motion: motion.to_owned(),
            time_s: curve.time_s.clone(),
            displacement_mm: curve.displacement_m.iter().map(|d| d * 1e3).collect(),
            outputs: curve.names.iter().zip(&curve.values).map(series).collect(),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, call: &Invocation) -> CliResult {
    nothing_fitted(&arguments.run.reading, "simulate")?;
    let stop = &call.stop;
    let motion = motion(&arguments.motion, arguments.cycles, arguments.points, &arguments.run.reading)?;
    let single = EngineArguments { jobs: 1, ..arguments.run.engine.clone() };
    let pvd = arguments.fields.pvd(&motion.name);
    arguments.fields.check_place(pvd.as_deref())?;
    let names = Names {
        input: single.input.clone(),
        output: single.output.clone(),
        extra: arguments.record.clone(),
        texts: FieldArguments::texts(pvd.as_deref())?,
        ..Names::default()
    };
    let engine = single.engine_of(names, stop)?;
    single.show_notes(engine.wiring());
    for name in &arguments.record {
        let recorded = engine.wiring().outputs.iter().any(|p| asks_for(name, &p.name));
        if !recorded && engine.is_own() {
            return Err(UsageError(format!("the FMU has no real output `{name}` (--record)")).into());
        }
    }
    let settings = arguments.run.engine.settings(engine.wiring())?;
    let mut parameters = settings_from(engine.wiring(), &settings)?;
    parameters.extend(arguments.fields.parameters());
    for switch in sensitivities::switches(engine.wiring().outputs.iter().map(|p| p.name.as_str())) {
        parameters.entry(switch.to_owned()).or_insert(1.0);
    }
    let assumptions = assumed::of(&engine, &parameters, &[]);
    let assumed = assumed::say_before(&assumptions);
    let base = arguments.out.clone().unwrap_or_else(|| PathBuf::from(&motion.name));
    check_no_device(&base).map_err(|e| UsageError(format!("--out {}: {e}", base.display())))?;
    let job = Job { parameters, protocol: motion.protocol, time_s: motion.time_s };
    let ended = engine.submit(&job, Priority::Urgent).wait();
    if let Some(pvd) = pvd.as_deref().filter(|pvd| pvd.is_file()) {
        mark_written(pvd)?;
    }
    let curve = match ended {
        Ok(curve) => curve,
        Err(RunFailure::Cancelled) => return Ok(Ending::Interrupted),
        Err(failure) => return Err(format!("the simulation failed: {failure}").into()),
    };

    call.keep_as(&with_suffix(&base, "toml"))?;
    let (csv, svg) = (with_suffix(&base, "csv"), with_suffix(&base, "svg"));
    let comment = format!("{} simulated by {} {}", motion.name, engine.model_name(), settings.join(" "));
    write_file(&csv, curve_csv(&curve, &[comment.trim().to_owned()]).as_bytes())?;
    write_file(&svg, force_plot(&motion.name, &curve).as_bytes())?;
    let forces = curve.time_s.iter().zip(curve.force_n());
    if let Some((time, peak)) = forces.max_by(|a, b| a.1.total_cmp(b.1)) {
        say!("peak force {:.3} mN at {time:.3} s", peak * 1e3);
    }
    say!("wrote {} and {}", csv.display(), svg.display());
    if let Some(pvd) = pvd {
        say!("wrote the fields to {}: open it in ParaView", pvd.display());
    }
    if let Some(assumed) = assumed {
        say!("{assumed}");
    }
    let heading = Heading::new(call, &engine, assumptions);
    terminal::result(&Simulation::of(heading, &motion.name, &curve))?;
    Ok(Ending::Complete)
}

/// `a/b.c` and `csv` give `a/b.c.csv`, but `a/b.csv` stays.
fn with_suffix(base: &std::path::Path, suffix: &str) -> PathBuf {
    let known = base.extension().is_some_and(|e| e == "csv" || e == "svg");
    let stem = if known { base.with_extension("") } else { base.to_owned() };
    let mut name = stem.into_os_string();
    name.push(".");
    name.push(suffix);
    name.into()
}
