//! Series written by a slave: what is on the disk at every time, also after a return to an earlier state.

use crate::fields::FieldsError;
use crate::interface::cosimulation::{Slave, SlaveError, SlaveState};
use crate::interface::variables::{Value, by_name};
use std::fs;
use std::path::{Path, PathBuf};

fn slave(pvd: &Path) -> Slave {
    let mut slave = Slave::new();
    let values = [
        ("mesh.preset", Value::Integer(1)),
        ("protocol.source", Value::Integer(1)),
        ("fields.path", Value::Text(pvd.to_str().unwrap().to_owned())),
        ("fields.frames", Value::Integer(2)),
    ];
    slave.set(&values.map(|(name, value)| (by_name(name).unwrap().0, value))).unwrap();
    slave
}

/// `steps` steps of 10 ms at `velocity` (m/s).
fn go(slave: &mut Slave, steps: usize, velocity: f64) {
    for _ in 0..steps {
        let (time, displacement) = (slave.time().unwrap(), by_name("punch_displacement").unwrap().0);
        let Value::Real(from) = slave.get(displacement).unwrap() else { panic!() };
        slave.set(&[(by_name("displacement").unwrap().0, Value::Real(from + 0.01 * velocity))]).unwrap();
        slave.step(time, 0.01).unwrap();
    }
}

/// Times in the .pvd, each with the contents of its file; nothing else is in the folder.
fn series(pvd: &Path) -> Vec<(f64, String)> {
    let text = fs::read_to_string(pvd).unwrap();
    let attribute = |line: &str, name: &str| {
        line.split_once(&format!("{name}=\"")).unwrap().1.split('"').next().unwrap().to_owned()
    };
    let lines = text.lines().filter(|line| line.starts_with("<DataSet"));
    let frames: Vec<_> = lines
        .map(|line| {
            let file = pvd.parent().unwrap().join(attribute(line, "file"));
            (attribute(line, "timestep").parse().unwrap(), fs::read_to_string(file).unwrap())
        })
        .collect();
    assert_eq!(fs::read_dir(pvd.with_extension("")).unwrap().count(), frames.len());
    frames
}

/// Times of the frames (10 ms).
fn times(pvd: &Path) -> Vec<i32> {
    series(pvd).iter().map(|(time, _)| (time * 100.0).round() as i32).collect()
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("poropunch-fields-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    folder
}

#[test]
fn a_return_to_an_earlier_state_drops_what_came_after() {
    let folder = folder("return");
    // Neither the folder nor its parent is there yet.
    let pvd = folder.join("deep/a b ü.pvd");
    let mut slave = slave(&pvd);
    slave.initialise(0.0).unwrap();
    go(&mut slave, 2, 1e-3);
    let early = slave.save();
    go(&mut slave, 2, 1e-3);
    let late = slave.save();
    let first = series(&pvd);
    assert_eq!(times(&pvd), [0, 1, 2, 3, 4]);

    slave.restore(&early).unwrap();
    assert_eq!(times(&pvd), [0, 1, 2]);
    go(&mut slave, 2, 0.5e-3);
    assert_eq!(times(&pvd), [0, 1, 2, 3, 4]);
    let second = series(&pvd);
    assert!(first[..3] == second[..3] && first[3].1 != second[3].1, "the other branch is another series");

    // A state of the first branch keeps only the frames that both branches share.
    slave.restore(&late).unwrap();
    assert_eq!(times(&pvd), [0, 1, 2]);
    go(&mut slave, 1, 1e-3);
    assert_eq!(times(&pvd), [0, 1, 2, 5]);

    // The same steps again give the same files.
    slave.restore(&early).unwrap();
    go(&mut slave, 2, 1e-3);
    assert!(series(&pvd) == first);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn another_process_goes_on_with_the_series() {
    let folder = folder("process");
    let pvd = folder.join("x.pvd");
    let mut here = slave(&pvd);
    here.initialise(0.0).unwrap();
    go(&mut here, 2, 1e-3);
    let bytes = here.save().to_bytes(&[]).unwrap();
    go(&mut here, 2, 1e-3);
    let expected = series(&pvd);
    drop(here);
    let mut there = Slave::new();
    there.restore(&SlaveState::from_bytes(&bytes).unwrap().0).unwrap();
    assert_eq!(times(&pvd), [0, 1, 2]);
    go(&mut there, 2, 1e-3);
    assert!(series(&pvd) == expected);
    // A frame that somebody changed is not taken for the one that was written.
    fs::write(pvd.with_extension("").join("x_0001.vtu"), "other").unwrap();
    let mut third = Slave::new();
    third.restore(&SlaveState::from_bytes(&bytes).unwrap().0).unwrap();
    assert_eq!(times(&pvd), [0]);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_cannot_be_written_is_an_error_before_anything_is_computed() {
    let folder = folder("error");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("file"), "x").unwrap();
    let mut blocked = slave(&folder.join("file/below.pvd"));
    let error = blocked.initialise(0.0).unwrap_err();
    assert!(matches!(error, SlaveError::Fields(FieldsError::Unwritable { .. })), "{error}");
    let text = error.to_string();
    assert!(text.contains("file/below") && text.contains("fields.path"), "{text}");
    let error = slave(&folder.join("series.vtk")).initialise(0.0).unwrap_err();
    assert!(matches!(error, SlaveError::Fields(FieldsError::NotPvd(_))), "{error}");

    // On the way: the step is not made, what was written stays, and the run can go on.
    let pvd = folder.join("way.pvd");
    let mut slave = slave(&pvd);
    slave.initialise(0.0).unwrap();
    go(&mut slave, 2, 1e-3);
    let before = slave.save();
    fs::create_dir(folder.join("way/way_0003.vtu.part")).unwrap();
    assert!(matches!(slave.step(0.02, 0.01), Err(SlaveError::Fields(FieldsError::Unwritable { .. }))));
    assert!(slave.save() == before);
    fs::remove_dir(folder.join("way/way_0003.vtu.part")).unwrap();
    assert_eq!(times(&pvd), [0, 1, 2]);
    go(&mut slave, 1, 1e-3);
    assert_eq!(times(&pvd), [0, 1, 2, 3]);
    // The end is a frame only where there is none yet.
    slave.finish().unwrap();
    assert_eq!(times(&pvd).len(), 4);
    fs::remove_dir_all(folder).unwrap();
}
