//! Calls of FMI 2.0.

use crate::states::states;
use crate::{Driver, Slave, Version, call};
use poropunch::model_description::guid;
use poropunch::variables::{Kind, by_name, table};
use poropunch_fmi::fmi2::abi::CallbackFunctions;
use poropunch_fmi::fmi2::*;
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};

states! {
    fmi2Reset, read_time, fmi2GetFMUstate, fmi2SetFMUstate, fmi2FreeFMUstate, fmi2SerializedFMUstateSize, fmi2SerializeFMUstate,
    fmi2DeSerializeFMUstate
}

pub static VERSION: Version = Version { instantiate, free, get, set, step, state, other, reset, begin };

fn instantiate(driver: &mut Driver) -> Slave {
    let id = CString::new(guid()).unwrap();
    let component = unsafe {
        fmi2Instantiate(c"random".as_ptr(), 1, id.as_ptr(), null(), &CallbackFunctions::SILENT, 0, 0)
    };
    assert!(!component.is_null() && !fmi2GetVersion().is_null() && !fmi2GetTypesPlatform().is_null());
    driver.called.extend(["fmi2Instantiate", "fmi2GetVersion", "fmi2GetTypesPlatform"]);
    Slave { version: &VERSION, component, time: 0.0, master: null_mut() }
}

fn free(driver: &mut Driver, slave: &Slave) {
    unsafe { fmi2FreeInstance(slave.component) };
    driver.noted("fmi2FreeInstance", 0);
}

fn read_time(driver: &mut Driver, which: usize) {
    let mut time = 0.0;
    if call!(driver, fmi2GetRealStatus(driver.slaves[which].component, 2, &mut time)) {
        driver.slaves[which].time = time;
    }
}

fn get(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    let n = driver.random.below(4);
    let references: Vec<u32> = (0..n).map(|_| driver.random.reference(table().len())).collect();
    let n = driver.random.count(n);
    let references = if driver.random.one_in(30) { null() } else { references.as_ptr() };
    match driver.random.below(4) {
        0 => call!(driver, fmi2GetReal(c, references, n, [0.0; 4].as_mut_ptr())),
        1 => call!(driver, fmi2GetInteger(c, references, n, [0; 4].as_mut_ptr())),
        2 => call!(driver, fmi2GetBoolean(c, references, n, [0; 4].as_mut_ptr())),
        _ => call!(driver, fmi2GetString(c, references, n, [null(); 4].as_mut_ptr())),
    };
}

fn set(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    let reference = driver.random.reference(table().len());
    // Meshes other than the coarse one, and three dimensions, cost minutes and show nothing more.
    if table().get(reference as usize).is_some_and(|v| v.name.starts_with("mesh.")) {
        return;
    }
    let kind = table().get(reference as usize).map(|variable| variable.kind);
    let (real, whole, n) = (driver.random.real(), driver.random.whole(), driver.random.count(1));
    match kind {
        Some(Kind::Real { .. }) if driver.random.one_in(4) => {
            call!(driver, fmi2SetRealInputDerivatives(c, &reference, n, &1, &real))
        }
        Some(Kind::Real { .. }) | None => call!(driver, fmi2SetReal(c, &reference, n, &real)),
        Some(Kind::Boolean) => call!(driver, fmi2SetBoolean(c, &reference, n, &whole)),
        Some(Kind::Text) => call!(driver, fmi2SetString(c, &reference, n, &null())),
        Some(_) => call!(driver, fmi2SetInteger(c, &reference, n, &whole)),
    };
}

fn step(driver: &mut Driver, which: usize) {
    let Slave { component, time, .. } = driver.slaves[which];
    let (size, from) = (driver.random.size(), driver.random.near(time));
    if call!(driver, fmi2DoStep(component, from, size, 1)) {
        driver.slaves[which].time = from + size;
        driver.count.steps += 1;
    }
}

fn other(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    let (reference, real) = (driver.random.reference(table().len()), driver.random.real());
    let kind = driver.random.whole();
    match driver.random.below(14) {
        0 => {
            let category = driver.random.of(&[c"nothing".as_ptr(), c"logEvents".as_ptr()]);
            call!(driver, fmi2SetDebugLogging(c, 1, 1, &category))
        }
        1 => {
            let (has_stop, stop) = (i32::from(driver.random.one_in(4)), driver.random.real());
            call!(driver, fmi2SetupExperiment(c, kind & 1, real, 0.0, has_stop, stop))
        }
        2 => call!(driver, fmi2EnterInitializationMode(c)),
        3 if driver.random.one_in(4) => call!(driver, fmi2Terminate(c)),
        4 => call!(driver, fmi2CancelStep(c)),
        5 => call!(driver, fmi2GetStatus(c, kind, &mut 0)),
        6 => call!(driver, fmi2GetRealStatus(c, kind, &mut 0.0)),
        7 => call!(driver, fmi2GetIntegerStatus(c, kind, &mut 0)),
        8 => call!(driver, fmi2GetBooleanStatus(c, kind, &mut 0)),
        9 => call!(driver, fmi2GetStringStatus(c, kind, &mut null())),
        10 => call!(driver, fmi2GetRealOutputDerivatives(c, &reference, 1, &kind, &mut 0.0)),
        11 => call!(driver, fmi2GetDirectionalDerivative(c, &reference, 1, &reference, 1, &real, &mut 0.0)),
        12 => call!(driver, fmi2GetReal(null_mut(), &reference, 1, &mut 0.0)),
        _ => call!(driver, fmi2DoStep(c, 0.0, 1e-3, 0)),
    };
}

fn begin(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    reset(driver, which);
    let coarse = by_name("mesh.preset").unwrap().0;
    call!(driver, fmi2SetInteger(c, &coarse, 1, &1));
    if driver.random.one_in(2) {
        call!(driver, fmi2SetInteger(c, &by_name("protocol.source").unwrap().0, 1, &1));
    }
    for _ in 0..driver.random.below(3) {
        set(driver, which);
    }
    let good = call!(driver, fmi2EnterInitializationMode(c)) && call!(driver, fmi2ExitInitializationMode(c));
    driver.count.runs += usize::from(good);
}
