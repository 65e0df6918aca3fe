//! Steps poropunch's FMU by fmi-rs: `second-importer FMU ROWS.csv REFERENCES [3]`, the last for FMI 3.0.
//!
//! The first two columns of the rows are communication points (s) and displacements of the punch (m); the displacement is given
//! as a start and a rate. The value references are those of the mesh preset, the protocol's source, the displacement, its rate, then of what is printed,
//! with the time and the displacement before it, one line per step.

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::fmi2Status;
use fmi_rs::fmi3::builder::FMU3Builder;
use fmi_rs::fmi3::types::fmi3Status;
use std::path::Path;

/// Instantiates with choices and a first displacement, initialised; then sets two inputs, steps, gets outputs.
type Step = Box<dyn Fn([f64; 2], f64, f64, &mut [f64])>;

fn ok(status: fmi2Status) {
    assert_eq!(status, fmi2Status::Ok);
}

fn ok3(status: fmi3Status) {
    assert_eq!(status, fmi3Status::Ok);
}

fn fmi2(archive: &Path, references: Vec<u32>, start: f64, end: f64) -> Step {
    let builder = FMU2Builder::new(&archive).expect("an FMU");
    let instance = builder.instantiate_cs("second").expect("an instance");
    ok(instance.setInteger(&references[..2], &[1, 1]));
    ok(instance.setReal(&references[2..3], &[start]));
    ok(instance.setupExperiment(None, 0.0, Some(end)));
    ok(instance.enterInitializationMode());
    ok(instance.exitInitializationMode());
    Box::new(move |inputs, time, size, outputs| {
        // The library lies in the builder's folder.
        let _ = &builder;
        ok(instance.setReal(&references[2..4], &inputs));
        ok(instance.doStep(time, size, 1));
        ok(instance.getReal(&references[4..], outputs));
    })
}

fn fmi3(archive: &Path, references: Vec<u32>, start: f64, end: f64) -> Step {
    let mut builder = FMU3Builder::new(&archive).expect("an FMU");
    (builder.eventModeUsed, builder.earlyReturnAllowed) = (false, false);
    let instance = builder.instantiate_cs("second").expect("an instance");
    ok3(instance.setInt64(&references[..2], &[1, 1]));
    ok3(instance.setFloat64(&references[2..3], &[start]));
    ok3(instance.enterInitializationMode(None, 0.0, Some(end)));
    ok3(instance.exitInitializationMode());
    Box::new(move |inputs, time, size, outputs| {
        let _ = &builder;
        ok3(instance.setFloat64(&references[2..4], &inputs));
        let (mut event, mut ends, mut early, mut last) = (false, false, false, 0.0);
        ok3(instance.doStep(time, size, true, &mut event, &mut ends, &mut early, &mut last));
        assert!(!event && !ends && !early && last == time + size);
        ok3(instance.getFloat64(&references[4..], outputs));
    })
}

fn main() {
    let [archive, rows, references] = [1, 2, 3].map(|k| std::env::args().nth(k).expect("three arguments"));
    let references: Vec<u32> = references.split(',').map(|r| r.parse().expect("a number")).collect();
    let rows = std::fs::read_to_string(rows).expect("rows");
    let number = |field: &str| field.parse::<f64>().expect("a number");
    let rows: Vec<Vec<f64>> = rows.lines().map(|line| line.split(',').map(number).collect()).collect();
    let (start, end) = (rows[0][1], rows.last().expect("a row")[0]);
    let mut values = vec![0.0; references.len() - 4];
    let make = if std::env::args().nth(4).is_some() { fmi3 } else { fmi2 };
    let go = make(Path::new(&archive), references, start, end);
    for pair in rows.windows(2) {
        let (from, to) = (&pair[0], &pair[1]);
        let size = to[0] - from[0];
        go([from[1], (to[1] - from[1]) / size], from[0], size, &mut values);
        let line: Vec<String> = to[..2].iter().chain(&values).map(f64::to_string).collect();
        println!("{}", line.join(","));
    }
}
