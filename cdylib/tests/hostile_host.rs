//! Goal: nothing that a host passes or sets up makes the library read memory that is not there, ask for absurd
//! memory, crash or hang: counts, handles, forged states with a right checksum, trapped floating-point exceptions.
//! Set-up: the rlib of the FMU, coarse mesh; what might kill a process runs in one of its own.

use poropunch::model_description::guid;
use poropunch::variables::by_name;
use poropunch_fmi::fmi2::abi::CallbackFunctions;
use poropunch_fmi::fmi2::*;
use poropunch_fmi::{ERROR, OK, Status};
use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::MaybeUninit;
use std::process::{Command, ExitStatus};
use std::ptr::{null, null_mut};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// A component with what it logged.
struct Host {
    component: *mut c_void,
    heard: Box<Mutex<Vec<String>>>,
}

unsafe extern "C" fn hear(
    heard: *mut c_void,
    _: *const c_char,
    _: Status,
    _: *const c_char,
    message: *const c_char,
) {
    let (heard, message) = unsafe { (&*heard.cast::<Mutex<Vec<String>>>(), CStr::from_ptr(message)) };
    heard.lock().unwrap().push(message.to_str().unwrap().to_owned());
}

impl Host {
    fn new() -> Self {
        let heard = Box::new(Mutex::new(Vec::new()));
        let callbacks = CallbackFunctions::hearing(hear, (&raw const *heard).cast_mut().cast());
        let id = CString::new(guid()).unwrap();
        let component =
            unsafe { fmi2Instantiate(c"test".as_ptr(), 1, id.as_ptr(), null(), &callbacks, 0, 1) };
        assert!(!component.is_null());
        let host = Self { component, heard };
        host.integer("mesh.preset", 1);
        host
    }

    fn integer(&self, name: &str, value: i32) {
        assert_eq!(unsafe { fmi2SetInteger(self.component, &reference(name), 1, &value) }, OK, "{name}");
    }

    fn real(&self, name: &str, value: f64) {
        assert_eq!(unsafe { fmi2SetReal(self.component, &reference(name), 1, &value) }, OK, "{name}");
    }

    fn boolean(&self, name: &str, value: i32) {
        assert_eq!(unsafe { fmi2SetBoolean(self.component, &reference(name), 1, &value) }, OK, "{name}");
    }

    fn get(&self, name: &str) -> f64 {
        let mut value = MaybeUninit::uninit();
        assert_eq!(unsafe { fmi2GetReal(self.component, &reference(name), 1, value.as_mut_ptr()) }, OK);
        unsafe { value.assume_init() }
    }

    fn initialise(&self) -> Status {
        unsafe {
            assert_eq!(fmi2EnterInitializationMode(self.component), OK);
            fmi2ExitInitializationMode(self.component)
        }
    }

    fn step(&self, time: f64, size: f64) -> Status {
        unsafe { fmi2DoStep(self.component, time, size, 1) }
    }

    fn state(&self) -> *mut c_void {
        let mut state = null_mut();
        assert_eq!(unsafe { fmi2GetFMUstate(self.component, &mut state) }, OK);
        state
    }

    fn bytes(&self, state: *mut c_void) -> Vec<u8> {
        let mut size = MaybeUninit::uninit();
        unsafe {
            assert_eq!(fmi2SerializedFMUstateSize(self.component, state, size.as_mut_ptr()), OK);
            let size = size.assume_init();
            let mut bytes = Vec::with_capacity(size);
            assert_eq!(fmi2SerializeFMUstate(self.component, state, bytes.as_mut_ptr(), size), OK);
            bytes.set_len(size);
            bytes
        }
    }

    fn last_words(&self) -> String {
        self.heard.lock().unwrap().last().cloned().unwrap_or_default()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.component) };
    }
}

fn reference(name: &str) -> u32 {
    by_name(name).unwrap_or_else(|| panic!("{name}")).0
}

#[test]
fn absurd_counts_are_refused_before_anything_is_read() {
    let host = Host::new();
    let c = host.component;
    let displacement = reference("displacement");
    for n in [1 << 17, 1 << 40, usize::MAX] {
        unsafe {
            assert_eq!(fmi2SetReal(c, &displacement, n, &0.0), ERROR);
            assert_eq!(fmi2SetInteger(c, &displacement, n, &0), ERROR);
            assert_eq!(fmi2SetBoolean(c, &displacement, n, &0), ERROR);
            assert_eq!(fmi2SetString(c, &displacement, n, &c"".as_ptr()), ERROR);
            assert_eq!(fmi2SetDebugLogging(c, 1, n, &c"logEvents".as_ptr()), ERROR);
            assert_eq!(fmi2SetRealInputDerivatives(c, &displacement, n, &1, &0.0), ERROR);
        }
        assert!(host.last_words().contains("values in one call"), "{}", host.last_words());
    }
    assert_eq!(host.initialise(), OK);
    let bytes = host.bytes(host.state());
    for n in [1 << 17, 1 << 40, usize::MAX] {
        unsafe {
            assert_eq!(fmi2GetReal(c, &displacement, n, &mut 0.0), ERROR);
            assert_eq!(fmi2GetString(c, &displacement, n, &mut null()), ERROR);
            assert_eq!(fmi2DeSerializeFMUstate(c, bytes.as_ptr(), n, &mut null_mut()), ERROR);
        }
    }
}

/// FMI 2.0.5, section 2.1.8: the handle of `fmi2DeSerializeFMUstate` only comes out; what it was does not matter.
#[test]
fn a_handle_that_only_comes_out_is_not_read() {
    let host = Host::new();
    let state = host.state();
    let before = host.bytes(state);
    host.real("material.permeability", 1e-12);
    let other = host.bytes(host.state());
    let mut handle = state;
    assert_eq!(
        unsafe { fmi2DeSerializeFMUstate(host.component, other.as_ptr(), other.len(), &mut handle) },
        OK
    );
    assert_ne!(handle, state);
    assert!(host.bytes(state) == before, "another state was overwritten");
    assert!(host.bytes(handle) == other);
}

/// The default run presses; a step of 1e9 s goes through every corner of the protocol.
#[test]
fn a_huge_step_does_not_skip_the_protocol() {
    let work = |steps: &[f64]| {
        let host = Host::new();
        assert_eq!(host.initialise(), OK);
        let mut time = 0.0;
        for &end in steps {
            assert_eq!(host.step(time, end - time), OK, "{}", host.last_words());
            time = end;
        }
        ["viscous_dissipation", "external_work"].map(|name| host.get(name))
    };
    let (huge, expected) = (work(&[1e9]), work(&[0.0625, 0.6875, 90.6875, 200.0, 1e9]));
    for (huge, expected) in huge.into_iter().zip(expected) {
        assert!(expected > 1e-7 && (huge / expected - 1.0).abs() < 1e-3, "{huge} against {expected}");
    }
}

#[test]
fn what_has_no_effect_or_no_sense_is_said() {
    let host = Host::new();
    host.real("displacement", 1e-4);
    assert_eq!(host.initialise(), ERROR, "inputs and the built-in protocol");
    assert!(host.last_words().contains("displacement has no effect"), "{}", host.last_words());

    let host = Host::new();
    assert_eq!(host.initialise(), OK);
    let c = host.component;
    unsafe {
        assert_eq!(
            fmi2SetReal(c, &reference("displacement"), 1, &0.0),
            OK,
            "its start value asks for nothing"
        );
        assert_eq!(fmi2SetReal(c, &reference("displacement"), 1, &1e-4), ERROR);
        assert_eq!(fmi2SetRealInputDerivatives(c, &reference("displacement"), 1, &1, &1e-3), ERROR);
    }
    assert!(host.last_words().contains("der(displacement) has no effect"), "{}", host.last_words());

    // The integer twin, for masters without enumerations.
    let host = Host::new();
    host.integer("protocol.source_number", 1);
    host.real("displacement", -1e-4);
    assert_eq!(host.initialise(), OK);
    host.real("displacement", 1e-4);
    assert_eq!(host.step(0.0, 0.1), OK);
    assert!(host.get("force") > 1e-5);

    let host = Host::new();
    host.real("material.branch[4].mu", 1e9);
    assert_eq!(host.initialise(), ERROR);
    assert!(host.last_words().contains("material.branch[4]: mu"), "{}", host.last_words());

    let host = Host::new();
    assert_eq!(unsafe { fmi2SetupExperiment(host.component, 1, 1e-4, 0.0, 0, 0.0) }, OK);
    assert!(host.last_words().contains("the tolerance 0.0001 of the experiment is not used"));

    // An edge so sharp that its elements would have no size.
    let host = Host::new();
    host.real("indenter.edge_radius", 1e-300);
    assert_eq!(host.initialise(), ERROR);
    assert!(host.last_words().contains("indenter.edge_radius = "), "{}", host.last_words());

    // A sphere on elements of a hundred-thousandth of its size: refused, not tried.
    let host = Host::new();
    host.integer("indenter.profile", 2);
    host.real("mesh.edge_size", 2e-8);
    host.real("mesh.growth", 1.05);
    assert_eq!(host.initialise(), ERROR);
    assert!(host.last_words().contains("the mesh is too large"), "{}", host.last_words());
}

/// This test program again, with one ignored test; killed after five minutes, with 4 GB of memory at most.
fn in_a_process_of_its_own(test: &str, case: &str) -> (ExitStatus, String) {
    let program = std::env::current_exe().unwrap();
    let out = std::env::temp_dir().join(format!("poropunch-{test}-{case}-{}", std::process::id()));
    let mut child = Command::new("sh")
        .args(["-c", "ulimit -v 4000000; exec \"$0\" --exact \"$1\" --ignored --nocapture > \"$2\" 2>&1"])
        .arg(program)
        .arg(test)
        .arg(&out)
        .env("POROPUNCH_CASE", case)
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if begun.elapsed() > Duration::from_secs(300) {
            child.kill().unwrap();
            break child.wait().unwrap();
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let said = std::fs::read_to_string(&out).unwrap_or_default();
    let _ = std::fs::remove_file(out);
    (status, said)
}

#[test]
fn forged_states_are_errors_or_good() {
    let (status, said) = in_a_process_of_its_own("forge", "");
    println!("{status}\n{said}");
    assert!(status.success());
}

/// Magic, version, GUID and length stand before the payload, the checksum behind it.
const HEADER: usize = 36;
const CHECKSUM: usize = 16;

fn sealed(header: &[u8], payload: &[u8]) -> Vec<u8> {
    let mut bytes = header[..28].to_vec();
    bytes.extend((payload.len() as u64).to_le_bytes());
    bytes.extend(payload);
    let hash = blake3::hash(&bytes);
    bytes.extend(&hash.as_bytes()[..CHECKSUM]);
    bytes
}

/// Numbers below `n`, the same in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }
}

#[test]
#[ignore = "run by forged_states_are_errors_or_good in a process of its own"]
fn forge() {
    let host = Host::new();
    assert_eq!(host.initialise(), OK);
    assert_eq!(host.step(0.0, 0.3), OK);
    let good = host.bytes(host.state());
    let (header, payload) = (&good[..HEADER], &good[HEADER..good.len() - CHECKSUM]);
    assert!(sealed(header, payload) == good, "the format is not what this test takes it for");
    let mut random = Random(1);
    let specials = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300, -1e300, 1e-300, 2e-8].map(f64::to_le_bytes);
    let (mut refused, mut not_restored, mut stepped, mut failed) = (0, 0, 0, 0);
    for turn in 0..1500 {
        let mut forged = payload.to_vec();
        // The settings stand at the beginning, the path's numbers at the end.
        let place = match turn % 3 {
            0 => random.below(1500),
            1 => forged.len() - 1 - random.below(1500),
            _ => random.below(forged.len()),
        };
        match random.below(5) {
            0 => forged[place] ^= 1 << random.below(8),
            1 => {
                let end = (place + 8).min(forged.len());
                forged[place..end].copy_from_slice(&specials[random.below(specials.len())][..end - place]);
            }
            2 => forged.truncate(place),
            3 => (0..9).for_each(|_| forged.insert(place, 0xff)),
            _ => forged[place] = random.below(256) as u8,
        }
        let bytes = sealed(header, &forged);
        let mut state = null_mut();
        let c = host.component;
        unsafe {
            if fmi2DeSerializeFMUstate(c, bytes.as_ptr(), bytes.len(), &mut state) != OK {
                refused += 1;
                continue;
            }
            if fmi2SetFMUstate(c, state) != OK {
                not_restored += 1;
            } else if turn % 10 < 2 {
                let mut time = 0.0;
                if fmi2GetRealStatus(c, 2, &mut time) == OK {
                    let made = fmi2DoStep(c, time, 0.05, 1);
                    if made == OK { stepped += 1 } else { failed += 1 }
                }
            }
            assert_eq!(fmi2FreeFMUstate(c, &mut state), OK);
        }
    }
    println!(
        "forged states: {refused} refused, {not_restored} not restored, of some of the others {stepped} went on and \
         {failed} said why not"
    );
    assert!(refused > 150 && stepped > 30);
    // Alive and well.
    assert_eq!(unsafe { fmi2Reset(host.component) }, OK);
    host.integer("mesh.preset", 1);
    assert_eq!(host.initialise(), OK);
    assert_eq!(host.step(0.0, 0.3), OK);
    assert_eq!(host.bytes(host.state()), good);
}

#[cfg(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"))]
mod floating_point {
    use super::{Host, OK, in_a_process_of_its_own};

    unsafe extern "C" {
        /// glibc: the calling thread gets SIGFPE where one of these exceptions is raised.
        fn feenableexcept(exceptions: i32) -> i32;
    }

    /// FE_INVALID, FE_DIVBYZERO, FE_OVERFLOW of x86-64.
    const TRAPPED: i32 = 1 | 4 | 8;

    const CASES: [&str; 8] =
        ["plain", "sphere", "slip", "adhesion", "sensitivities", "machine", "eyring", "softening"];

    fn choose(host: &Host, case: &str) {
        match case {
            "plain" => {}
            "sphere" => {
                host.integer("indenter.profile", 2);
                host.real("indenter.sphere_radius", 3e-3);
            }
            "slip" => host.real("effect.slip.compliance", 1e-6),
            "adhesion" => {
                host.real("effect.adhesion.strength", 100.0);
                host.real("effect.adhesion.opening", 1e-4);
            }
            "sensitivities" => {
                host.boolean("solver.sensitivities", 1);
                host.boolean("solver.effect_sensitivities", 1);
            }
            "machine" => {
                host.real("effect.compliance.per_newton", 1e-3);
                host.real("effect.load_cell_lag.time", 0.1);
            }
            "eyring" => host.real("effect.eyring.inverse_stress", 1e-3),
            "softening" => host.real("effect.softening.loss", 0.3),
            other => panic!("{other}"),
        }
    }

    /// P2, two cycles, in hosts that stop at a division by zero, an invalid operation or an overflow.
    #[test]
    fn nothing_traps() {
        let results = CASES.map(|case| (case, in_a_process_of_its_own("floating_point::trap", case)));
        for (case, (status, said)) in &results {
            println!("{case}: {status}\n{said}");
        }
        assert!(results.iter().all(|(_, (status, _))| status.success()));
    }

    #[test]
    #[ignore = "run by nothing_traps in a process of its own"]
    fn trap() {
        let case = std::env::var("POROPUNCH_CASE").unwrap_or_else(|_| "plain".to_owned());
        // What a debug build of a host does.
        unsafe { feenableexcept(TRAPPED) };
        let host = Host::new();
        choose(&host, &case);
        host.integer("protocol.cycles", 2);
        assert_eq!(host.initialise(), OK, "{}", host.last_words());
        // Steps of one size: the corners lie within them; then the rests.
        let mut time = 0.0;
        while time < 600.0 {
            let size = if time < 1.0 { 0.0625 } else { 1.25 };
            assert_eq!(host.step(time, size), OK, "no step: {}", host.last_words());
            time += size;
        }
        assert!(host.get("external_work") > 0.0);
    }
}
