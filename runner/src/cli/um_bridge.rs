//! `runner um-bridge`: the model for samplers, over HTTP.

use super::engine_args::RunArguments;
use super::exit::UsageError;
use super::idle::nothing_fitted;
use super::job::Invocation;
use super::protocols::motion;
use super::{CliResult, Ending};
use crate::fmi::Fmu;
use crate::pool::Wiring;
use crate::pool::wiring::Names;
use crate::setting::{settings_from, variable_named};
use crate::um_bridge::{ForwardModel, NAME, Worker, serve};
use clap::{Args, ValueHint};
use poropunch::variables;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;

/// Serve the model to samplers that speak UM-Bridge: parameters in (SI), force out (mN), with exact derivatives.
#[derive(Debug, Args)]
pub struct Arguments {
    /// P1 or P2 (the first cycle, to the end of the hold), or a CSV file with time_s,displacement_mm
    #[arg(value_name = "PROTOCOL|FILE", default_value = "P2", value_hint = ValueHint::FilePath)]
    motion: String,
    /// Parameter that is an input, in this order (repeatable) [default: those that `identify` fits]
    #[arg(long = "parameter", value_name = "NAME")]
    inputs: Vec<String>,
    /// Complete cycles of P1 or P2
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i32).range(1..=1000))]
    cycles: Option<i32>,
    /// Number of output times for P1 and P2, a file has its own [default: 300]
    #[arg(long, value_name = "N", value_parser = super::count::points)]
    points: Option<usize>,
    /// Port to listen on; 0 for any that is free
    #[arg(long, value_name = "PORT", default_value_t = 4242)]
    port: u16,
    /// Address to listen on; others than this machine's own see the model, and can keep it busy
    #[arg(long, value_name = "IP", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    address: IpAddr,
    #[command(flatten)]
    run: RunArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments, call: &Invocation) -> CliResult {
    let RunArguments { reading, engine, .. } = &arguments.run;
    nothing_fitted(reading, "um-bridge")?;
    let motion = motion(&arguments.motion, arguments.cycles, arguments.points, reading)?;
    let fmu = Arc::new(match &engine.fmu {
        Some(path) => Fmu::open(path)?,
        None => Fmu::builtin()?,
    });
    let (input, output) = (engine.input.clone(), engine.output.clone());
    let names = Names { input, output, sensitivities: true, ..Names::default() };
    let wiring = Wiring::new(fmu.description(), &names)?;
    engine.show_notes(&wiring);
    let model = ForwardModel {
        settings: settings_from(&wiring, &engine.settings(&wiring)?)?,
        parameters: inputs(&wiring, &arguments.inputs)?,
        protocol: motion.protocol,
        time_s: motion.time_s,
        wiring: Arc::new(wiring),
    };
    let threads = match engine.jobs {
        0 => std::thread::available_parallelism().map_or(1, Into::into),
        jobs => jobs,
    };
    let worker = |_| Worker::new(&model, &fmu, &call.stop).map_err(|e| e.to_string());
    let workers = (0..threads).map(worker).collect::<Result<_, _>>()?;
    let listening = |address| {
        say!("UM-Bridge model {NAME} at http://{address}: input {}", model.parameters.join(", "));
    };
    serve(SocketAddr::new(arguments.address, arguments.port), workers, &call.stop, listening)?;
    Ok(Ending::Interrupted)
}

/// Names of the inputs, checked.
fn inputs(wiring: &Wiring, asked: &[String]) -> Result<Vec<String>, Box<dyn std::error::Error>> {
    let mut names = Vec::new();
    let fitted = || variables::identifiable().filter(|(_, how)| how.free).map(|(v, _)| v.name.to_owned());
    let own = asked.is_empty().then(|| fitted().filter(|name| wiring.parameters.contains_key(name)));
    for name in own.into_iter().flatten().chain(asked.iter().cloned()) {
        let name = variable_named(wiring, &name)?.name.clone();
        if names.contains(&name) {
            return Err(UsageError(format!("--parameter {name} is given twice")).into());
        }
        names.push(name);
    }
    if names.is_empty() {
        return Err(
            UsageError("name the FMU's parameters that are inputs: --parameter NAME".to_owned()).into()
        );
    }
    Ok(names)
}
