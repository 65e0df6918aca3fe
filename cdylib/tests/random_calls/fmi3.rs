//! Calls of FMI 3.0.

use crate::random::Random;
use crate::states::states;
use crate::{Driver, Slave, Version, call};
use poropunch::model_description::fmi3::instantiation_token;
use poropunch::variables::ports::{BaseType, Port};
use poropunch::variables::table;
use poropunch_fmi::fmi3::*;
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};

states! {
    fmi3Reset, read_time, fmi3GetFMUState, fmi3SetFMUState, fmi3FreeFMUState, fmi3SerializedFMUStateSize, fmi3SerializeFMUState,
    fmi3DeserializeFMUState
}

pub static VERSION: Version = Version { instantiate, free, get, set, step, state, other, reset, begin };

/// Room for the values of a call: three matrices of sensitivities and histories.
const ROOM: usize = 256;
/// References of the table, and of what stands behind it.
fn references() -> usize {
    table().len() + 5
}

fn reference(name: &str) -> u32 {
    Port::by_name(name).unwrap_or_else(|| panic!("{name}")).reference()
}

/// What a master does within a step.
struct Master {
    instance: *mut c_void,
    random: Random,
}

/// Whatever it likes: all but reading, setting the displacement and ending the step is refused.
unsafe extern "C" fn within_a_step(
    master: *mut c_void,
    _: f64,
    _: u8,
    _: u8,
    _: u8,
    _: u8,
    ends: *mut u8,
    at: *mut f64,
) {
    let Master { instance, random } = unsafe { &mut *master.cast::<Master>() };
    let c = *instance;
    let (one, real) = (random.reference(references()), random.real());
    unsafe {
        match random.below(8) {
            0 => drop(fmi3GetFloat64(c, &one, 1, [0.0; ROOM].as_mut_ptr(), 1)),
            1 => drop(fmi3SetFloat64(c, &one, 1, &real, 1)),
            2 => drop(fmi3SetFloat64(c, &reference("displacement"), 1, &real, 1)),
            3 => drop(fmi3Reset(c)),
            4 => drop(fmi3DoStep(c, 0.0, real, 1, &mut 0, &mut 0, &mut 0, &mut 0.0)),
            5 => drop(fmi3GetFMUState(c, &mut null_mut())),
            6 => fmi3FreeInstance(c),
            _ => (*ends, *at) = (random.below(3) as u8, real),
        }
    }
}

fn instantiate(driver: &mut Driver) -> Slave {
    let token = CString::new(instantiation_token()).unwrap();
    let random = Random(driver.random.below(1 << 30) as u64);
    let master = Box::into_raw(Box::new(Master { instance: null_mut(), random })).cast();
    let [events, early] = [2, 2].map(|n| driver.random.below(n) as u8);
    let update = driver.random.one_in(2).then_some(within_a_step as _);
    let component = unsafe {
        fmi3InstantiateCoSimulation(
            c"random".as_ptr(),
            token.as_ptr(),
            null(),
            0,
            0,
            events,
            early,
            &reference("displacement"),
            driver.random.below(2),
            master,
            None,
            update,
        )
    };
    assert!(!component.is_null() && !fmi3GetVersion().is_null());
    unsafe { (*master.cast::<Master>()).instance = component };
    let none = fmi3InstantiateModelExchange(null(), null(), null(), 0, 0, null_mut(), None);
    assert!(none.is_null());
    let none = fmi3InstantiateScheduledExecution(
        null(),
        null(),
        null(),
        0,
        0,
        null_mut(),
        None,
        null(),
        null(),
        null(),
    );
    assert!(none.is_null());
    driver.called.extend(["fmi3InstantiateCoSimulation", "fmi3GetVersion", "fmi3InstantiateModelExchange"]);
    driver.called.insert("fmi3InstantiateScheduledExecution");
    Slave { version: &VERSION, component, time: 0.0, master }
}

fn free(driver: &mut Driver, slave: &Slave) {
    unsafe {
        fmi3FreeInstance(slave.component);
        drop(Box::from_raw(slave.master.cast::<Master>()));
    }
    driver.noted("fmi3FreeInstance", 0);
}

fn read_time(driver: &mut Driver, which: usize) {
    let mut time = 0.0;
    let c = driver.slaves[which].component;
    if call!(driver, fmi3GetFloat64(c, &Port::Time.reference(), 1, &mut time, 1)) {
        driver.slaves[which].time = time;
    }
}

/// References by chance, their type and how many values they have, or one of these wrong.
fn chosen(driver: &mut Driver, n: usize) -> (Vec<u32>, BaseType, usize) {
    let chosen: Vec<u32> = (0..n).map(|_| driver.random.reference(references())).collect();
    let port = |&one: &u32| Port::by_reference(one).ok();
    let points = 1 + driver.random.below(3);
    let size = |port: Port| if port.is_history() { points } else { port.shape().iter().product() };
    let values = chosen.iter().filter_map(port).map(size).sum::<usize>().min(ROOM);
    use BaseType::{Boolean, Enumeration, Float64, Int32, String, UInt64};
    let any = driver.random.of(&[Float64, Int32, Enumeration, UInt64, Boolean, String]);
    let right = chosen.first().and_then(port).map_or(any, Port::base_type);
    let kind = if driver.random.one_in(6) { any } else { right };
    let values = if driver.random.one_in(10) { driver.random.below(ROOM) } else { values };
    (chosen, kind, driver.random.count(values))
}

fn get(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    let n = driver.random.of(&[0, 1, 1, 1, 2, 3]);
    let (references, kind, n_values) = chosen(driver, n);
    let n = driver.random.count(n);
    let r = if driver.random.one_in(30) { null() } else { references.as_ptr() };
    let mut room = [0.0; ROOM];
    let values = if driver.random.one_in(30) { null_mut() } else { room.as_mut_ptr() };
    // Eight bytes are enough for a value of every type.
    match kind {
        BaseType::Float64 => call!(driver, fmi3GetFloat64(c, r, n, values, n_values)),
        BaseType::Int32 => call!(driver, fmi3GetInt32(c, r, n, values.cast(), n_values)),
        BaseType::Enumeration => call!(driver, fmi3GetInt64(c, r, n, values.cast(), n_values)),
        BaseType::UInt64 => call!(driver, fmi3GetUInt64(c, r, n, values.cast(), n_values)),
        BaseType::Boolean => call!(driver, fmi3GetBoolean(c, r, n, values.cast(), n_values)),
        BaseType::String => call!(driver, fmi3GetString(c, r, n, values.cast(), n_values)),
    };
}

fn set(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    let (references, kind, n_values) = chosen(driver, 1);
    // As with FMI 2.0.
    if Port::by_reference(references[0]).is_ok_and(|port| port.name().starts_with("mesh.")) {
        return;
    }
    let n = driver.random.count(1);
    let r = references.as_ptr();
    let (real, whole) = (driver.random.real(), driver.random.whole());
    let mut reals = [real; ROOM];
    if driver.random.one_in(2) {
        // Times of a history increase.
        (0..ROOM).for_each(|k| reals[k] = 1e-3 * k as f64);
    }
    let reals = if driver.random.one_in(30) { null() } else { reals.as_ptr() };
    let points = driver.random.of(&[0, 1, 2, 3, 1 << 40, u64::MAX]);
    match kind {
        BaseType::Float64 => call!(driver, fmi3SetFloat64(c, r, n, reals, n_values)),
        BaseType::Int32 => call!(driver, fmi3SetInt32(c, r, n, [whole; ROOM].as_ptr(), n_values)),
        BaseType::Enumeration => {
            call!(driver, fmi3SetInt64(c, r, n, [i64::from(whole); ROOM].as_ptr(), n_values))
        }
        BaseType::UInt64 => call!(driver, fmi3SetUInt64(c, r, n, [points; ROOM].as_ptr(), n_values)),
        BaseType::Boolean => call!(driver, fmi3SetBoolean(c, r, n, [whole as u8; ROOM].as_ptr(), n_values)),
        BaseType::String => call!(driver, fmi3SetString(c, r, n, [null(); ROOM].as_ptr(), n_values)),
    };
}

fn step(driver: &mut Driver, which: usize) {
    let Slave { component: c, time, .. } = driver.slaves[which];
    if driver.random.one_in(4) {
        // It may be at an event.
        call!(driver, fmi3EnterStepMode(c));
    }
    let (size, from) = (driver.random.size(), driver.random.near(time));
    let (mut event, mut terminate, mut early, mut last) = (0, 0, 0, time);
    let terminate: *mut u8 = if driver.random.one_in(50) { null_mut() } else { &mut terminate };
    if call!(driver, fmi3DoStep(c, from, size, 1, &mut event, terminate, &mut early, &mut last)) {
        driver.slaves[which].time = last;
        driver.count.steps += 1;
    }
}

fn other(driver: &mut Driver, which: usize) {
    match driver.random.below(3) {
        0 => not_offered(driver, which),
        _ => life(driver, which),
    }
}

fn life(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    let (real, defined) = (driver.random.real(), u8::from(driver.random.one_in(4)));
    let flag: *mut u8 = if driver.random.one_in(10) { null_mut() } else { &mut 0 };
    match driver.random.below(12) {
        0 => {
            let category = driver.random.of(&[c"nothing".as_ptr(), c"logEvents".as_ptr()]);
            call!(driver, fmi3SetDebugLogging(c, 1, 1, &category))
        }
        1 => call!(driver, fmi3EnterInitializationMode(c, defined, real, 0.0, defined, real)),
        2 => call!(driver, fmi3ExitInitializationMode(null_mut())),
        3 => call!(driver, fmi3EnterConfigurationMode(c)),
        4 => call!(driver, fmi3ExitConfigurationMode(c)),
        5 => call!(driver, fmi3EnterEventMode(c)),
        6 => call!(driver, fmi3EnterStepMode(c)),
        7 if driver.random.one_in(4) => call!(driver, fmi3Terminate(c)),
        8 => call!(driver, fmi3EvaluateDiscreteStates(c)),
        9 => call!(driver, fmi3UpdateDiscreteStates(c, flag, &mut 0, &mut 0, &mut 0, &mut 0, &mut 0.0)),
        10 => call!(driver, fmi3GetFloat64(null_mut(), &0, 1, &mut 0.0, 1)),
        _ => call!(driver, fmi3DoStep(c, 0.0, 1e-3, 0, null_mut(), flag, &mut 0, &mut 0.0)),
    };
}

/// One of the functions of types, clocks, derivatives and kinds of simulation that the FMU does not have.
fn not_offered(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    let one = driver.random.reference(references());
    let (n, real) = (driver.random.of(&[0, 1, 1, usize::MAX]), driver.random.real());
    let r: *const u32 = if driver.random.one_in(10) { null() } else { &one };
    /// Calls one of them by chance; those of a type without variables stand as pairs.
    macro_rules! one_of {
        (
            $([$get:ident, $set:ident]($c:expr, $r:expr, $n:expr, $zero:literal);)+
            $($function:ident($($argument:expr),*);)+
        ) => {{
            let calls: [&dyn Fn(&mut Driver) -> bool; _] = [
                $(&|d| call!(d, $get($c, $r, $n, &mut $zero, 1)), &|d| call!(d, $set($c, $r, $n, &$zero, 1)),)+
                $(&|d| call!(d, $function($($argument),*))),+
            ];
            let call = driver.random.of(&calls);
            call(driver)
        }};
    }
    one_of! {
        [fmi3GetFloat32, fmi3SetFloat32](c, r, n, 0.0);
        [fmi3GetInt8, fmi3SetInt8](c, r, n, 0);
        [fmi3GetUInt8, fmi3SetUInt8](c, r, n, 0);
        [fmi3GetInt16, fmi3SetInt16](c, r, n, 0);
        [fmi3GetUInt16, fmi3SetUInt16](c, r, n, 0);
        [fmi3GetUInt32, fmi3SetUInt32](c, r, n, 0);
        fmi3GetBinary(c, r, n, &mut 0, &mut null(), 1);
        fmi3SetBinary(c, r, n, &0, &null(), 1);
        fmi3GetClock(c, r, n, &mut 0);
        fmi3SetClock(c, r, n, &0);
        fmi3GetIntervalDecimal(c, r, n, &mut 0.0, &mut 0);
        fmi3GetIntervalFraction(c, r, n, &mut 0, &mut 0, &mut 0);
        fmi3GetShiftDecimal(c, r, n, &mut 0.0);
        fmi3GetShiftFraction(c, r, n, &mut 0, &mut 0);
        fmi3SetIntervalDecimal(c, r, n, &real);
        fmi3SetIntervalFraction(c, r, n, &1, &1);
        fmi3SetShiftDecimal(c, r, n, &real);
        fmi3SetShiftFraction(c, r, n, &1, &1);
        fmi3GetOutputDerivatives(c, r, n, &1, &mut 0.0, 1);
        fmi3GetDirectionalDerivative(c, r, n, r, 1, &real, 1, &mut 0.0, 1);
        fmi3GetAdjointDerivative(c, r, n, r, 1, &real, 1, &mut 0.0, 1);
        fmi3GetNumberOfVariableDependencies(c, one, &mut 0);
        fmi3GetVariableDependencies(c, one, &mut 0, &mut 0, &mut 0, &mut 0, 1);
        fmi3EnterContinuousTimeMode(c);
        fmi3CompletedIntegratorStep(c, 1, &mut 0, &mut 0);
        fmi3SetTime(c, real);
        fmi3SetContinuousStates(c, &real, n);
        fmi3GetContinuousStateDerivatives(c, null_mut(), n);
        fmi3GetEventIndicators(c, null_mut(), n);
        fmi3GetContinuousStates(c, null_mut(), n);
        fmi3GetNominalsOfContinuousStates(c, null_mut(), n);
        fmi3GetNumberOfEventIndicators(c, &mut 0);
        fmi3GetNumberOfContinuousStates(c, &mut 0);
        fmi3ActivateModelPartition(c, one, real);
    };
}

fn begin(driver: &mut Driver, which: usize) {
    let c = driver.slaves[which].component;
    reset(driver, which);
    call!(driver, fmi3SetInt64(c, &reference("mesh.preset"), 1, &1, 1));
    match driver.random.below(3) {
        0 => {
            call!(driver, fmi3SetInt64(c, &reference("protocol.source"), 1, &1, 1));
        }
        1 => {
            let places = ["protocol.history.time", "protocol.history.displacement"].map(reference);
            call!(driver, fmi3SetUInt64(c, &Port::Points.reference(), 1, &3, 1));
            let values = [0.0, 0.002, 0.01, -1e-6, driver.random.of(&[1e-6, 1e-5]), 0.0];
            call!(driver, fmi3SetFloat64(c, places.as_ptr(), 2, values.as_ptr(), 6));
        }
        _ => {}
    }
    for _ in 0..driver.random.below(3) {
        set(driver, which);
    }
    let good = call!(driver, fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0))
        && call!(driver, fmi3ExitInitializationMode(c));
    driver.count.runs += usize::from(good);
    call!(driver, fmi3EnterStepMode(c));
}
