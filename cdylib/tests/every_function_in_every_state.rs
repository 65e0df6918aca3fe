//! Goal: each of the 30 functions on a component answers as FMI 2.0.5 (section 4.2.4) says in each state,
//! and `fmi2Reset` leads from each state to what a fresh instance is.
//! Set-up: the rlib of the FMU, coarse mesh. Reference: the table below, written from the standard.

use poropunch::model_description::guid;
use poropunch::variables::by_name;
use poropunch_fmi::fmi2::abi::CallbackFunctions;
use poropunch_fmi::fmi2::*;
use poropunch_fmi::{ERROR, OK, Status};
use std::ffi::{CStr, CString, c_int, c_void};
use std::ptr::{null, null_mut};

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Instantiated,
    Initialization,
    StepComplete,
    Error,
    Terminated,
}
use State::{Error, Initialization, Instantiated, StepComplete, Terminated};
const ALL: [State; 5] = [Instantiated, Initialization, StepComplete, Error, Terminated];

fn instantiate(name: &str, kind: c_int, guid: &str) -> *mut c_void {
    let (name, guid) = (CString::new(name).unwrap(), CString::new(guid).unwrap());
    unsafe { fmi2Instantiate(name.as_ptr(), kind, guid.as_ptr(), null(), &CallbackFunctions::SILENT, 0, 0) }
}

fn fresh() -> *mut c_void {
    let component = instantiate("test", 1, guid());
    assert!(!component.is_null());
    component
}

fn reference(name: &str) -> u32 {
    by_name(name).unwrap().0
}

/// From `Instantiated` into a state, the punch at the surface and following the inputs, a coarse mesh.
unsafe fn bring(c: *mut c_void, state: State) {
    unsafe {
        if state == Instantiated {
            return;
        }
        let choices = ["mesh.preset", "protocol.source"].map(reference);
        assert_eq!(fmi2SetInteger(c, choices.as_ptr(), 2, [1, 1].as_ptr()), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        if state == Initialization {
            return;
        }
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        match state {
            Error => assert_eq!(fmi2DoStep(c, 0.0, f64::NAN, 1), ERROR),
            Terminated => assert_eq!(fmi2Terminate(c), OK),
            _ => {}
        }
    }
}

/// Force after a tenth of a second of loading.
unsafe fn force(c: *mut c_void) -> u64 {
    unsafe {
        bring(c, StepComplete);
        let input = (reference("displacement"), 1e-4);
        assert_eq!(fmi2SetReal(c, &input.0, 1, &input.1), OK);
        assert_eq!(fmi2DoStep(c, 0.0, 0.1, 1), OK);
        let mut force = 0.0;
        assert_eq!(fmi2GetReal(c, &reference("force"), 1, &mut force), OK);
        assert!(force > 1e-5);
        force.to_bits()
    }
}

type Call = fn(*mut c_void) -> Status;

/// A function that must succeed in the named states and fail in all others.
fn table() -> Vec<(&'static str, Call, &'static [State])> {
    const SET: &[State] = &[Instantiated, Initialization, StepComplete];
    const GET: &[State] = &[Initialization, StepComplete, Error, Terminated];
    const STATUS: &[State] = &[StepComplete, Error, Terminated];
    unsafe {
        vec![
            ("SetDebugLogging", |c| fmi2SetDebugLogging(c, 0, 0, null()), &ALL),
            ("SetupExperiment", |c| fmi2SetupExperiment(c, 0, 0.0, 0.0, 1, 9.0), &[Instantiated]),
            ("EnterInitializationMode", |c| fmi2EnterInitializationMode(c), &[Instantiated]),
            ("ExitInitializationMode", |c| fmi2ExitInitializationMode(c), &[Initialization]),
            ("Terminate", |c| fmi2Terminate(c), &[StepComplete]),
            ("Reset", |c| fmi2Reset(c), &ALL),
            ("GetReal", |c| fmi2GetReal(c, &reference("force"), 1, &mut 0.0), GET),
            ("GetInteger", |c| fmi2GetInteger(c, &reference("mesh.preset"), 1, &mut 0), GET),
            ("GetBoolean", |c| fmi2GetBoolean(c, &reference("boundary.drained_top"), 1, &mut 0), GET),
            ("GetString", |c| fmi2GetString(c, &reference("fields.path"), 1, &mut null()), GET),
            ("SetReal", |c| fmi2SetReal(c, &reference("displacement"), 1, &0.0), SET),
            // Parameters are fixed once the initialisation is over.
            ("SetInteger", |c| fmi2SetInteger(c, &reference("mesh.preset"), 1, &1), &SET[..2]),
            ("SetBoolean", |c| fmi2SetBoolean(c, &reference("boundary.drained_top"), 1, &1), &SET[..2]),
            ("SetString", |c| fmi2SetString(c, &reference("fields.path"), 1, &c"".as_ptr()), &SET[..2]),
            ("GetFMUstate", |c| fmi2GetFMUstate(c, &mut null_mut()), &ALL),
            ("SetFMUstate", |c| with_state(c, |c, s| fmi2SetFMUstate(c, *s)), &ALL),
            ("FreeFMUstate", |c| with_state(c, |c, s| fmi2FreeFMUstate(c, s)), &ALL),
            (
                "SerializedFMUstateSize",
                |c| with_state(c, |c, s| fmi2SerializedFMUstateSize(c, *s, &mut 0)),
                &ALL,
            ),
            ("SerializeFMUstate", |c| with_state(c, |c, s| serialize(c, *s).map_or(ERROR, |_| OK)), &ALL),
            (
                "DeSerializeFMUstate",
                |c| {
                    with_state(c, |c, s| {
                        let bytes = serialize(c, *s).unwrap();
                        fmi2DeSerializeFMUstate(c, bytes.as_ptr(), bytes.len(), &mut null_mut())
                    })
                },
                &ALL,
            ),
            (
                "GetDirectionalDerivative",
                |c| fmi2GetDirectionalDerivative(c, null(), 0, null(), 0, null(), null_mut()),
                &[],
            ),
            (
                "SetRealInputDerivatives",
                |c| fmi2SetRealInputDerivatives(c, &reference("displacement"), 1, &1, &0.0),
                SET,
            ),
            (
                "GetRealOutputDerivatives",
                |c| fmi2GetRealOutputDerivatives(c, null(), 0, null(), null_mut()),
                STATUS,
            ),
            ("DoStep", |c| fmi2DoStep(c, 0.0, 0.1, 1), &[StepComplete]),
            ("CancelStep", |c| fmi2CancelStep(c), &[]),
            ("GetStatus", |c| fmi2GetStatus(c, 0, &mut 0), STATUS),
            ("GetRealStatus", |c| fmi2GetRealStatus(c, 2, &mut 0.0), STATUS),
            ("GetBooleanStatus", |c| fmi2GetBooleanStatus(c, 3, &mut 0), STATUS),
            ("GetIntegerStatus", |c| fmi2GetIntegerStatus(c, 0, &mut 0), &[]),
            ("GetStringStatus", |c| fmi2GetStringStatus(c, 1, &mut null()), &[]),
        ]
    }
}

fn with_state(c: *mut c_void, run: fn(*mut c_void, &mut *mut c_void) -> Status) -> Status {
    let mut state = null_mut();
    assert_eq!(unsafe { fmi2GetFMUstate(c, &mut state) }, OK);
    run(c, &mut state)
}

fn serialize(c: *mut c_void, state: *mut c_void) -> Option<Vec<u8>> {
    let mut size = 0;
    unsafe {
        (fmi2SerializedFMUstateSize(c, state, &mut size) == OK).then_some(())?;
        let mut bytes = vec![0; size];
        (fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size) == OK).then_some(bytes)
    }
}

#[test]
fn answers_as_the_standard_says() {
    for state in ALL {
        for (name, call, allowed) in table() {
            let c = fresh();
            unsafe { bring(c, state) };
            let expected = if allowed.contains(&state) { OK } else { ERROR };
            assert_eq!(call(c), expected, "fmi2{name} in {state:?}");
            unsafe { fmi2FreeInstance(c) };
        }
    }
}

#[test]
fn reset_from_every_state_is_a_fresh_instance() {
    unsafe {
        let c = fresh();
        let expected = force(c);
        fmi2FreeInstance(c);
        for state in ALL {
            let c = fresh();
            assert_eq!(fmi2SetReal(c, &reference("material.permeability"), 1, &1e-12), OK);
            bring(c, state);
            assert_eq!(fmi2Reset(c), OK);
            assert_eq!(force(c), expected, "after Reset from {state:?}");
            fmi2FreeInstance(c);
        }
    }
}

#[test]
fn a_null_component_is_an_error_everywhere() {
    unsafe {
        fmi2FreeInstance(null_mut());
        for (name, call, _) in table() {
            // The helpers that need a state first cannot run without a component.
            if !name.contains("FMUstate") {
                assert_eq!(call(null_mut()), ERROR, "fmi2{name}");
            }
        }
        assert_eq!(fmi2GetFMUstate(null_mut(), &mut null_mut()), ERROR);
        assert_eq!(fmi2SetFMUstate(null_mut(), null_mut()), ERROR);
        assert_eq!(fmi2FreeFMUstate(null_mut(), &mut null_mut()), ERROR);
        assert_eq!(fmi2DeSerializeFMUstate(null_mut(), null(), 0, &mut null_mut()), ERROR);
    }
}

#[test]
fn bad_arguments_are_errors_and_change_nothing() {
    unsafe {
        let c = fresh();
        let (displacement, force) = (reference("displacement"), reference("force"));
        assert_eq!(fmi2SetReal(c, null(), 0, null()), OK);
        assert_eq!(fmi2SetReal(c, null(), 1, null()), ERROR);
        assert_eq!(fmi2SetReal(c, &999_999, 1, &0.0), ERROR);
        assert_eq!(fmi2SetReal(c, &reference("mesh.preset"), 1, &1.0), ERROR, "wrong type");
        assert_eq!(fmi2SetReal(c, &force, 1, &1.0), ERROR, "an output");
        assert_eq!(fmi2SetInteger(c, &reference("mesh.preset"), 1, &4), ERROR, "no such item");
        assert_eq!(fmi2SetReal(c, &displacement, 1, &-2e-4), OK);
        // All or none: the first value is good, the second is not.
        let both = [displacement, reference("displacement_rate")];
        assert_eq!(fmi2SetReal(c, both.as_ptr(), 2, [-1e-4, f64::NAN].as_ptr()), ERROR);
        assert_eq!(fmi2SetReal(c, &reference("material.n0s"), 1, &1.5), ERROR, "out of range");
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        let mut value = 0.0;
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), OK);
        assert_eq!(fmi2GetReal(c, &999_999, 1, &mut value), ERROR);
        assert_eq!(fmi2GetReal(c, &displacement, 1, &mut value), OK);
        assert_eq!(value, -2e-4, "the old value stays");
        fmi2FreeInstance(c);
    }
}

#[test]
fn texts_come_back_as_they_were_set() {
    unsafe {
        let c = fresh();
        let path = reference("fields.path");
        let given = c"a b \u{fc}%s/x.pvd";
        assert_eq!(fmi2SetString(c, &path, 1, &given.as_ptr()), OK);
        assert_eq!(fmi2SetString(c, &path, 1, &null()), ERROR, "NULL");
        assert_eq!(fmi2SetString(c, &path, 1, &c"\xff".as_ptr()), ERROR, "not UTF-8");
        assert_eq!(fmi2SetString(c, &reference("force"), 1, &given.as_ptr()), ERROR, "an output");
        assert_eq!(fmi2SetString(c, &reference("mesh.preset"), 1, &given.as_ptr()), ERROR, "wrong type");
        assert_eq!(fmi2SetReal(c, &path, 1, &0.0), ERROR, "wrong type");
        assert_eq!(fmi2SetString(c, null(), 0, null()), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        let mut twice = [null(); 2];
        assert_eq!(fmi2GetString(c, [path; 2].as_ptr(), 2, twice.as_mut_ptr()), OK);
        assert!(twice.iter().all(|&text| CStr::from_ptr(text) == given));
        assert_eq!(fmi2GetString(c, &reference("force"), 1, &mut null()), ERROR, "wrong type");
        assert_eq!(fmi2GetString(c, &path, 1, null_mut()), ERROR, "no array");
        fmi2FreeInstance(c);
    }
}

/// Every frame in the file, the last at fmi2Terminate; a series that cannot be written is refused at once.
#[test]
fn fields_are_written() {
    let folder = std::env::temp_dir().join(format!("poropunch-cdylib-{}", std::process::id()));
    let pvd = folder.join("x.pvd");
    let text = CString::new(pvd.to_str().unwrap()).unwrap();
    unsafe {
        let c = fresh();
        assert_eq!(fmi2SetString(c, &reference("fields.path"), 1, &text.as_ptr()), OK);
        assert_eq!(fmi2SetReal(c, &reference("fields.interval"), 1, &1e3), OK);
        bring(c, StepComplete);
        assert_eq!(fmi2DoStep(c, 0.0, 0.1, 1), OK);
        let frames = || std::fs::read_to_string(&pvd).unwrap().matches("<DataSet").count();
        assert_eq!(frames(), 1);
        assert_eq!(fmi2Terminate(c), OK);
        assert_eq!(frames(), 2);
        fmi2FreeInstance(c);

        let c = fresh();
        let below = CString::new(pvd.join("below/x.pvd").to_str().unwrap()).unwrap();
        assert_eq!(fmi2SetString(c, &reference("fields.path"), 1, &below.as_ptr()), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), ERROR);
        assert_eq!(fmi2Reset(c), OK);
        bring(c, StepComplete);
        fmi2FreeInstance(c);
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn instantiation_is_refused_for_wrong_guid_name_or_type() {
    assert!(instantiate("test", 1, "{wrong}").is_null());
    assert!(instantiate(" ", 1, guid()).is_null());
    assert!(instantiate("test", 0, guid()).is_null());
    let (name, id) = (CString::new("test").unwrap(), CString::new(guid()).unwrap());
    unsafe {
        assert!(fmi2Instantiate(null(), 1, id.as_ptr(), null(), &CallbackFunctions::SILENT, 0, 0).is_null());
        assert!(
            fmi2Instantiate(name.as_ptr(), 1, null(), null(), &CallbackFunctions::SILENT, 0, 0).is_null()
        );
        assert!(fmi2Instantiate(name.as_ptr(), 1, id.as_ptr(), null(), null(), 0, 0).is_null());
    }
}

#[test]
fn state_handles_of_others_and_freed_ones_are_errors() {
    unsafe {
        let (a, b) = (fresh(), fresh());
        let mut state = null_mut();
        assert_eq!(fmi2GetFMUstate(a, &mut state), OK);
        assert_eq!(fmi2SetFMUstate(b, state), ERROR, "foreign");
        assert_eq!(fmi2FreeFMUstate(b, &mut state.clone()), ERROR, "foreign");
        let mut copy = state;
        assert_eq!(fmi2FreeFMUstate(a, &mut state), OK);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(a, &mut state), OK, "NULL is ignored");
        assert_eq!(fmi2FreeFMUstate(a, &mut copy), ERROR, "double free");
        assert_eq!(fmi2SetFMUstate(a, copy), ERROR, "freed");
        fmi2FreeInstance(a);
        fmi2FreeInstance(b);
    }
}
