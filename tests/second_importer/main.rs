//! Steps poropunch's FMU by fmi-rs: `second-importer FMU ROWS.csv REFERENCES`.
//!
//! The first two columns of the rows are communication points (s) and displacements of the punch (m); the displacement is given
//! as a start and a rate. The value references are those of the mesh preset, the protocol's source, the displacement, its rate, then of what is printed,
//! with the time and the displacement before it, one line per step.

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::fmi2Status;

fn ok(status: fmi2Status) {
    assert_eq!(status, fmi2Status::Ok);
}

fn main() {
    let [archive, rows, references] = [1, 2, 3].map(|k| std::env::args().nth(k).expect("three arguments"));
    let references: Vec<u32> = references.split(',').map(|r| r.parse().expect("a number")).collect();
    let (inputs, outputs) = references.split_at(4);
    let rows = std::fs::read_to_string(rows).expect("rows");
    let number = |field: &str| field.parse::<f64>().expect("a number");
    let rows: Vec<Vec<f64>> = rows.lines().map(|line| line.split(',').map(number).collect()).collect();
    let end = rows.last().expect("a row")[0];

    let builder = FMU2Builder::new(&std::path::Path::new(&archive)).expect("an FMU");
    let instance = builder.instantiate_cs("second").expect("an instance");
    ok(instance.setInteger(&inputs[..2], &[1, 1]));
    ok(instance.setReal(&inputs[2..3], &[rows[0][1]]));
    ok(instance.setupExperiment(None, 0.0, Some(end)));
    ok(instance.enterInitializationMode());
    ok(instance.exitInitializationMode());
    for pair in rows.windows(2) {
        let (from, to) = (&pair[0], &pair[1]);
        let step = to[0] - from[0];
        ok(instance.setReal(&inputs[2..], &[from[1], (to[1] - from[1]) / step]));
        ok(instance.doStep(from[0], step, 1));
        let mut values = vec![0.0; outputs.len()];
        ok(instance.getReal(outputs, &mut values));
        let line: Vec<String> = to[..2].iter().chain(&values).map(f64::to_string).collect();
        println!("{}", line.join(","));
    }
    ok(instance.terminate());
}
