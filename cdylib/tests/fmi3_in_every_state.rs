//! Goal: the functions of FMI 3.0 co-simulation answer as the standard (section 4.2) says in each state; events, early
//! return and intermediate update do what they promise; nothing that a host passes crashes.
//! Set-up: the rlib of the FMU, coarse mesh. Reference: the table below, written from the standard; FMI 2.0.

use poropunch::model_description::fmi3::instantiation_token;
use poropunch::variables::ports::Port;
use poropunch_fmi::fmi3::*;
use poropunch_fmi::{ERROR, OK, Status};
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Instantiated,
    Configuration,
    Initialization,
    Event,
    Step,
    Error,
    Terminated,
}
use State::{Configuration, Error, Event, Initialization, Instantiated, Step, Terminated};
const ALL: [State; 7] = [Instantiated, Configuration, Initialization, Event, Step, Error, Terminated];

fn instantiate(token: &str, events: u8, early: u8) -> *mut c_void {
    let token = CString::new(token).unwrap();
    unsafe {
        fmi3InstantiateCoSimulation(
            c"test".as_ptr(),
            token.as_ptr(),
            null(),
            0,
            0,
            events,
            early,
            null(),
            0,
            null_mut(),
            None,
            None,
        )
    }
}

fn fresh() -> *mut c_void {
    let instance = instantiate(instantiation_token(), 1, 1);
    assert!(!instance.is_null());
    instance
}

fn reference(name: &str) -> u32 {
    Port::by_name(name).unwrap_or_else(|| panic!("{name}")).reference()
}

unsafe fn coarse(c: *mut c_void, source: i64) {
    let choices = ["mesh.preset", "protocol.source"].map(reference);
    assert_eq!(unsafe { fmi3SetInt64(c, choices.as_ptr(), 2, [1, source].as_ptr(), 2) }, OK);
}

/// From `Instantiated` into a state, the punch at the surface and following the inputs, a coarse mesh.
unsafe fn bring(c: *mut c_void, state: State) {
    unsafe {
        match state {
            Instantiated => return,
            Configuration => {
                assert_eq!(fmi3EnterConfigurationMode(c), OK);
                return;
            }
            _ => {}
        }
        coarse(c, 1);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        if state == Initialization {
            return;
        }
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        if state == Event {
            return;
        }
        assert_eq!(fmi3EnterStepMode(c), OK);
        match state {
            Error => assert_eq!(step(c, 0.0, f64::NAN).0, ERROR),
            Terminated => assert_eq!(fmi3Terminate(c), OK),
            _ => {}
        }
    }
}

/// Status, event, early return, time.
unsafe fn step(c: *mut c_void, time: f64, size: f64) -> (Status, bool, bool, f64) {
    let (mut event, mut terminate, mut early, mut last) = (7, 7, 7, f64::NAN);
    let status = unsafe { fmi3DoStep(c, time, size, 1, &mut event, &mut terminate, &mut early, &mut last) };
    assert!(status != OK || terminate == 0);
    (status, event == 1, early == 1, last)
}

unsafe fn get(c: *mut c_void, name: &str) -> f64 {
    let mut value = f64::NAN;
    assert_eq!(unsafe { fmi3GetFloat64(c, &reference(name), 1, &mut value, 1) }, OK, "{name}");
    value
}

type Call = fn(*mut c_void) -> Status;

/// A function that must succeed in the named states and fail in all others.
fn table() -> Vec<(&'static str, Call, &'static [State])> {
    const SET: &[State] = &[Instantiated, Initialization, Event, Step];
    const GET: &[State] = &[Initialization, Event, Step, Error, Terminated];
    unsafe {
        vec![
            ("SetDebugLogging", |c| fmi3SetDebugLogging(c, 0, 0, null()), &ALL),
            (
                "EnterInitializationMode",
                |c| fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0),
                &[Instantiated],
            ),
            ("ExitInitializationMode", |c| fmi3ExitInitializationMode(c), &[Initialization]),
            ("EnterConfigurationMode", |c| fmi3EnterConfigurationMode(c), &[Instantiated]),
            ("ExitConfigurationMode", |c| fmi3ExitConfigurationMode(c), &[Configuration]),
            ("EnterEventMode", |c| fmi3EnterEventMode(c), &[Step]),
            ("EnterStepMode", |c| fmi3EnterStepMode(c), &[Event]),
            ("EvaluateDiscreteStates", |c| fmi3EvaluateDiscreteStates(c), &[Event]),
            ("UpdateDiscreteStates", |c| update(c).0, &[Event]),
            ("Terminate", |c| fmi3Terminate(c), &[Event, Step]),
            ("Reset", |c| fmi3Reset(c), &ALL),
            ("GetFloat64", |c| fmi3GetFloat64(c, &reference("force"), 1, &mut 0.0, 1), GET),
            ("GetInt32", |c| fmi3GetInt32(c, &reference("protocol.cycles"), 1, &mut 0, 1), GET),
            ("GetInt64", |c| fmi3GetInt64(c, &reference("mesh.preset"), 1, &mut 0, 1), GET),
            ("GetUInt64", |c| fmi3GetUInt64(c, &reference("protocol.points"), 1, &mut 0, 1), GET),
            ("GetBoolean", |c| fmi3GetBoolean(c, &reference("boundary.drained_top"), 1, &mut 0, 1), GET),
            ("GetString", |c| fmi3GetString(c, &reference("fields.path"), 1, &mut null(), 1), GET),
            ("SetFloat64", |c| fmi3SetFloat64(c, &reference("displacement"), 1, &0.0, 1), SET),
            // Parameters are fixed once the initialisation is over.
            ("SetInt32", |c| fmi3SetInt32(c, &reference("protocol.cycles"), 1, &1, 1), &SET[..2]),
            ("SetInt64", |c| fmi3SetInt64(c, &reference("mesh.preset"), 1, &1, 1), &SET[..2]),
            (
                "SetUInt64",
                |c| fmi3SetUInt64(c, &reference("protocol.points"), 1, &1, 1),
                &[Instantiated, Configuration],
            ),
            ("SetBoolean", |c| fmi3SetBoolean(c, &reference("boundary.drained_top"), 1, &1, 1), &SET[..2]),
            ("SetString", |c| fmi3SetString(c, &reference("fields.path"), 1, &c"".as_ptr(), 1), &SET[..2]),
            ("GetFMUState", |c| fmi3GetFMUState(c, &mut null_mut()), &ALL),
            ("SetFMUState", |c| fmi3SetFMUState(c, state(c)), &ALL),
            ("FreeFMUState", |c| fmi3FreeFMUState(c, &mut state(c)), &ALL),
            ("SerializedFMUStateSize", |c| fmi3SerializedFMUStateSize(c, state(c), &mut 0), &ALL),
            (
                "DeserializeFMUState",
                |c| {
                    let bytes = bytes(c);
                    fmi3DeserializeFMUState(c, bytes.as_ptr(), bytes.len(), &mut null_mut())
                },
                &ALL,
            ),
            ("DoStep", |c| step(c, 0.0, 0.1).0, &[Step]),
            ("GetOutputDerivatives", |c| fmi3GetOutputDerivatives(c, null(), 0, null(), null_mut(), 0), GET),
            // Asked for nothing, what is not offered has nothing to refuse.
            ("GetClock", |c| fmi3GetClock(c, null(), 0, null_mut()), &ALL),
            ("GetFloat32", |c| fmi3GetFloat32(c, null(), 0, null_mut(), 0), &ALL),
            ("SetClock", |c| fmi3SetClock(c, &0, 1, &1), &[]),
            ("SetInt8", |c| fmi3SetInt8(c, &0, 1, &1, 1), &[]),
            ("SetTime", |c| fmi3SetTime(c, 0.0), &[]),
            ("ActivateModelPartition", |c| fmi3ActivateModelPartition(c, 0, 0.0), &[]),
            (
                "GetDirectionalDerivative",
                |c| fmi3GetDirectionalDerivative(c, &0, 1, &1, 1, &1.0, 1, &mut 0.0, 1),
                &[],
            ),
        ]
    }
}

fn update(c: *mut c_void) -> (Status, Option<f64>) {
    let (mut a, mut b, mut d, mut e, mut defined, mut time) = (7, 7, 7, 7, 7, 0.0);
    let status =
        unsafe { fmi3UpdateDiscreteStates(c, &mut a, &mut b, &mut d, &mut e, &mut defined, &mut time) };
    assert!(status != OK || [a, b, d, e] == [0; 4]);
    (status, (defined == 1).then_some(time))
}

fn state(c: *mut c_void) -> *mut c_void {
    let mut state = null_mut();
    assert_eq!(unsafe { fmi3GetFMUState(c, &mut state) }, OK);
    state
}

fn bytes(c: *mut c_void) -> Vec<u8> {
    let (state, mut size) = (state(c), 0);
    unsafe {
        assert_eq!(fmi3SerializedFMUStateSize(c, state, &mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(c, state, bytes.as_mut_ptr(), size), OK);
        bytes
    }
}

#[test]
fn answers_as_the_standard_says() {
    for at in ALL {
        for (name, call, allowed) in table() {
            let c = fresh();
            unsafe { bring(c, at) };
            let expected = if allowed.contains(&at) { OK } else { ERROR };
            assert_eq!(call(c), expected, "fmi3{name} in {at:?}");
            unsafe { fmi3FreeInstance(c) };
        }
    }
}

#[test]
fn a_null_instance_is_an_error_everywhere() {
    for (name, call, _) in table().into_iter().filter(|(name, ..)| !name.contains("FMUState")) {
        assert_eq!(call(null_mut()), ERROR, "fmi3{name}");
    }
    unsafe { fmi3FreeInstance(null_mut()) };
    assert!(instantiate("{wrong}", 0, 0).is_null());
    assert!(fmi3InstantiateModelExchange(null(), null(), null(), 0, 0, null_mut(), None).is_null());
}

#[test]
fn reset_from_every_state_is_a_fresh_instance() {
    let force = |c| unsafe {
        bring(c, Step);
        assert_eq!(fmi3SetFloat64(c, &reference("displacement"), 1, &1e-4, 1), OK);
        let (status, _, early, time) = step(c, 0.0, 0.1);
        assert_eq!((status, early, time), (OK, false, 0.1));
        get(c, "force").to_bits()
    };
    let expected = force(fresh());
    for at in ALL {
        let c = fresh();
        unsafe {
            assert_eq!(fmi3SetFloat64(c, &reference("material.permeability"), 1, &1e-12, 1), OK);
            bring(c, at);
            assert_eq!(fmi3Reset(c), OK);
            assert_eq!(force(c), expected, "after Reset from {at:?}");
            fmi3FreeInstance(c);
        }
    }
}

#[test]
fn arrays_are_set_as_wholes_or_not_at_all() {
    let c = fresh();
    let mu = reference("material.branch.mu");
    unsafe {
        assert_eq!(fmi3SetFloat64(c, &mu, 1, [-1.0, -2.0, -3.0, -4.0].as_ptr(), 4), OK);
        assert_eq!(fmi3SetFloat64(c, &mu, 1, [-9.0; 3].as_ptr(), 3), ERROR, "too few");
        assert_eq!(fmi3SetFloat64(c, &mu, 1, [-9.0; 5].as_ptr(), 5), ERROR, "too many");
        assert_eq!(fmi3SetFloat64(c, &mu, 1, [-9.0, -9.0, -9.0, f64::NAN].as_ptr(), 4), ERROR, "NaN");
        assert_eq!(fmi3SetFloat64(c, &(mu + 3), 1, &-9.0, 1), ERROR, "an element is no variable");
        assert_eq!(fmi3SetFloat64(c, &mu, 1 << 40, &-9.0, 1 << 40), ERROR, "an absurd count");
        assert_eq!(fmi3SetUInt64(c, &reference("protocol.points"), 1, &(1 << 40), 1), ERROR, "absurd memory");
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        let mut read = [0.0; 5];
        let two = [mu, reference("displacement")];
        assert_eq!(fmi3GetFloat64(c, two.as_ptr(), 2, read.as_mut_ptr(), 5), OK);
        assert_eq!(read, [-1.0, -2.0, -3.0, -4.0, 0.0]);
        assert_eq!(fmi3GetFloat64(c, two.as_ptr(), 2, read.as_mut_ptr(), 4), ERROR, "no room");
        fmi3FreeInstance(c);
    }
}

#[test]
fn two_motions_at_once_are_refused() {
    let c = fresh();
    unsafe {
        coarse(c, 1);
        assert_eq!(fmi3SetUInt64(c, &reference("protocol.points"), 1, &2, 1), OK);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), ERROR);
        fmi3FreeInstance(c);
    }
}

/// P2: touch after 0.0625 s, corner at 0.6875 s. With early return a huge step stops at both, the next corner is
/// announced, and the peak is that of exact steps.
#[test]
fn steps_end_at_events() {
    let peak = |events, early| unsafe {
        let c = instantiate(instantiation_token(), events, early);
        coarse(c, 2);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        let (mut time, mut stops, mut peak) = (0.0, Vec::new(), 0.0_f64);
        if events == 1 {
            assert_eq!(update(c), (OK, Some(0.6875)));
            assert_eq!(fmi3EnterStepMode(c), OK);
        }
        while time < 2.0 {
            let (status, event, returned, last) = step(c, time, 2.0 - time);
            assert_eq!(status, OK);
            assert_eq!(returned, last < 2.0);
            assert_eq!(event, events == 1 && returned);
            if returned {
                stops.push(last);
            }
            time = last;
            peak = peak.max(get(c, "force"));
            if event {
                assert_eq!(fmi3EnterEventMode(c), OK);
                assert_eq!(update(c).0, OK);
                assert_eq!(fmi3EnterStepMode(c), OK);
            }
        }
        fmi3FreeInstance(c);
        (stops, peak)
    };
    let (stops, with_events) = peak(1, 1);
    assert_eq!(stops.len(), 2, "{stops:?}");
    assert!((stops[0] - 0.0625).abs() < 1e-12 && (stops[1] - 0.6875).abs() < 1e-12, "{stops:?}");
    assert!(peak(0, 1).1 == with_events && with_events > 0.0117);
    let (none, end) = peak(1, 0);
    assert!(none.is_empty() && end < 0.9 * with_events);
}

/// What the callback is given and does.
struct Master {
    instance: *mut c_void,
    asked: Mutex<Vec<f64>>,
    told: Mutex<Vec<f64>>,
    ends: bool,
}

unsafe extern "C" fn call_back(
    environment: *mut c_void,
    time: f64,
    set: u8,
    get_allowed: u8,
    _: u8,
    may_end: u8,
    ends: *mut u8,
    at: *mut f64,
) {
    let master = unsafe { &*environment.cast::<Master>() };
    let c = master.instance;
    unsafe {
        if set == 1 {
            master.asked.lock().unwrap().push(time);
            assert_eq!(fmi3SetFloat64(c, &reference("displacement_rate"), 1, &1.0, 1), ERROR, "discrete");
            assert_eq!(fmi3SetFloat64(c, &reference("displacement"), 1, &(1e-3 * time), 1), OK);
        }
        if get_allowed == 1 {
            master.told.lock().unwrap().push(time);
            assert!((get(c, "punch_displacement") - 1e-3 * time).abs() < 1e-15);
        }
        // Nothing else is allowed here, and nothing crashes.
        assert_eq!(fmi3Reset(c), ERROR);
        assert_eq!(step(c, 0.0, 0.1).0, ERROR);
        fmi3FreeInstance(c);
        if may_end == 1 && master.ends {
            (*ends, *at) = (1, time);
        }
    }
}

#[test]
fn the_master_is_asked_and_told_within_steps() {
    for ends in [false, true] {
        let token = CString::new(instantiation_token()).unwrap();
        let mut master =
            Box::new(Master { instance: null_mut(), asked: Mutex::default(), told: Mutex::default(), ends });
        unsafe {
            let c = fmi3InstantiateCoSimulation(
                c"test".as_ptr(),
                token.as_ptr(),
                null(),
                0,
                0,
                0,
                1,
                &reference("displacement"),
                1,
                (&raw mut *master).cast(),
                None,
                Some(call_back),
            );
            master.instance = c;
            coarse(c, 1);
            assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(c), OK);
            let (status, _, early, last) = step(c, 0.0, 0.5);
            assert_eq!((status, early), (OK, ends));
            assert_eq!(*master.asked.lock().unwrap(), [0.5]);
            let told = master.told.lock().unwrap().clone();
            assert!(told.is_sorted() && told.last() == Some(&last));
            assert!(
                if ends { told.len() == 1 && last < 0.5 } else { told.len() > 5 && last == 0.5 },
                "{told:?}"
            );
            assert!(get(c, "force") > 1e-6);
            fmi3FreeInstance(c);
        }
    }
}

/// A state of FMI 3.0 in a phase that FMI 2.0 does not have is refused there; any other goes on.
#[test]
fn states_pass_between_the_versions() {
    use poropunch_fmi::fmi2;
    let id = CString::new(poropunch::model_description::guid()).unwrap();
    let silent = fmi2::abi::CallbackFunctions::SILENT;
    for (at, expected) in [(Step, OK), (Event, ERROR)] {
        let c = fresh();
        unsafe {
            bring(c, at);
            let bytes = bytes(c);
            let other = fmi2::fmi2Instantiate(c"two".as_ptr(), 1, id.as_ptr(), null(), &silent, 0, 0);
            let mut state = null_mut();
            assert_eq!(fmi2::fmi2DeSerializeFMUstate(other, bytes.as_ptr(), bytes.len(), &mut state), OK);
            assert_eq!(fmi2::fmi2SetFMUstate(other, state), expected);
            if expected == OK {
                assert_eq!(fmi2::fmi2DoStep(other, 0.0, 0.1, 1), OK);
            }
            fmi2::fmi2FreeInstance(other);
            fmi3FreeInstance(c);
        }
    }
}
