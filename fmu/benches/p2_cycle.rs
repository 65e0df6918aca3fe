//! Cost of protocol P2's first cycle (ramp and 90 s of hold), and how instances scale over threads.
//!
//! ```text
//! cargo bench -p poropunch --bench p2_cycle
//! ```

use cpu_time::ThreadTime;
use poropunch::parameters::MeshPreset;
use poropunch::{Instance, Model, Parameters, Statistics, StepError};
use std::time::Instant;

const REPETITIONS: usize = 5;
const INSTANCES: usize = 8;

fn cycle(model: &Model) -> Result<Statistics, StepError> {
    let mut instance = Instance::new(model, -1e-4)?;
    for (duration, displacement) in [(1.1 / 1.6, 1e-3), (90.0, 1e-3)] {
        instance.set_displacement(displacement);
        instance.advance(duration)?;
    }
    Ok(instance.statistics())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| mesh | unknowns | steps | iterations | CPU s, least of {REPETITIONS} | with sensitivities | ratio |"
    );
    println!("|---|---|---|---|---|---|---|");
    for preset in [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine] {
        let mut parameters = Parameters::default();
        parameters.mesh.preset = preset;
        let plain = Model::new(parameters.clone())?;
        parameters.solver.sensitivities = true;
        let with_sensitivities = Model::new(parameters)?;
        let mut least = [f64::INFINITY; 2];
        let mut statistics = Statistics::default();
        for _ in 0..REPETITIONS {
            for (least, model) in least.iter_mut().zip([&plain, &with_sensitivities]) {
                let start = ThreadTime::now();
                statistics = cycle(model)?;
                *least = least.min(start.elapsed().as_secs_f64());
            }
        }
        let (Statistics { steps, iterations, .. }, [without, with]) = (statistics, least);
        println!(
            "| {preset:?} | {} | {steps} | {iterations} | {without:.2} | {with:.2} | {:.2} |",
            plain.unknowns(),
            with / without
        );
    }

    let model = Model::new(Parameters::default())?;
    let throughput = |threads: usize| -> Result<f64, StepError> {
        let start = Instant::now();
        std::thread::scope(|scope| {
            let share = || (0..INSTANCES / threads).try_for_each(|_| cycle(&model).map(drop));
            let started: Vec<_> = (0..threads).map(|_| scope.spawn(share)).collect();
            started.into_iter().try_for_each(|thread| thread.join().expect("no panic"))
        })?;
        Ok(INSTANCES as f64 / start.elapsed().as_secs_f64())
    };
    let (one, two) = (throughput(1)?, throughput(2)?);
    println!(
        "\nstandard, cycles per second: {one:.2} on 1 thread, {two:.2} on 2 threads, ratio {:.2}",
        two / one
    );
    Ok(())
}
