//! Goal: no order of calls, and nothing that is passed with them, crashes the host, hangs or asks for absurd memory.
//! Set-up: the rlib of the FMU, two components of FMI 2.0 and two of FMI 3.0 that exchange their states, all 109 functions and their
//! arguments by chance: good ones and NaN, references and handles that are none, counts of 2^40, states whose bytes were changed and
//! sealed again, masters that call whatever they like within a step. All calls are in the ranges that FMI lets a host choose from:
//! pointers are valid or NULL.
//! The long test makes a million calls; a part of them is made under valgrind, which must be installed.

mod fmi2;
mod fmi3;
mod random;
mod states;

use poropunch_fmi::OK;
use random::Random;
use std::collections::BTreeSet;
use std::ffi::c_void;
use std::process::Command;
use std::ptr::null_mut;

/// Functions of FMI 2.0 and of FMI 3.0.
const FUNCTIONS: usize = 34 + 75;

/// What a version of FMI is called with.
struct Version {
    instantiate: fn(&mut Driver) -> Slave,
    free: fn(&mut Driver, &Slave),
    get: fn(&mut Driver, usize),
    set: fn(&mut Driver, usize),
    step: fn(&mut Driver, usize),
    state: fn(&mut Driver, usize),
    other: fn(&mut Driver, usize),
    reset: fn(&mut Driver, usize),
    /// From a reset into a run, with a coarse mesh and some parameters by chance.
    begin: fn(&mut Driver, usize),
}

struct Slave {
    version: &'static Version,
    component: *mut c_void,
    time: f64,
    /// What the master keeps for its callback.
    master: *mut c_void,
}

/// What happened.
#[derive(Debug, Default)]
struct Count {
    calls: usize,
    good: usize,
    steps: usize,
    runs: usize,
    restored: usize,
    forged_restored: usize,
}

struct Driver {
    random: Random,
    slaves: Vec<Slave>,
    /// Handles, among them some that were freed and some that never were any.
    states: Vec<*mut c_void>,
    bytes: Vec<u8>,
    count: Count,
    called: BTreeSet<&'static str>,
}

/// Calls a function that answers with a status and notes it; whether it was done.
macro_rules! call {
    ($driver:expr, $function:ident($($argument:expr),* $(,)?)) => {{
        let status = unsafe { $function($($argument),*) };
        $driver.noted(stringify!($function), status)
    }};
}
use call;

impl Driver {
    fn new(seed: u64) -> Self {
        let mut driver = Self {
            random: Random(seed),
            slaves: Vec::new(),
            states: vec![null_mut()],
            bytes: vec![1; 100],
            count: Count::default(),
            called: BTreeSet::new(),
        };
        for version in [&fmi2::VERSION, &fmi3::VERSION, &fmi2::VERSION, &fmi3::VERSION] {
            let slave = (version.instantiate)(&mut driver);
            driver.slaves.push(slave);
        }
        driver
    }

    fn noted(&mut self, name: &'static str, status: i32) -> bool {
        self.count.calls += 1;
        self.count.good += usize::from(status == OK);
        self.called.insert(name);
        status == OK
    }

    /// One call by chance of one of the components, or a few that belong together.
    fn call(&mut self) {
        let which = self.random.below(self.slaves.len());
        let version = self.slaves[which].version;
        match self.random.below(1000) {
            0..350 => (version.get)(self, which),
            350..600 => (version.set)(self, which),
            600..740 => (version.step)(self, which),
            740..850 => (version.state)(self, which),
            850..980 => (version.other)(self, which),
            // A run of its own, so that steps are not always refused.
            980..996 => (version.begin)(self, which),
            996..999 => (version.reset)(self, which),
            _ => {
                let new = (version.instantiate)(self);
                let old = std::mem::replace(&mut self.slaves[which], new);
                (version.free)(self, &old);
            }
        }
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        for slave in std::mem::take(&mut self.slaves) {
            (slave.version.free)(self, &slave);
        }
    }
}

/// As many calls as asked for, one seed after the other.
fn drive(calls: usize, seed: u64) -> Driver {
    let mut driver = Driver::new(seed);
    // The library keeps panics quiet; here they are what is looked for.
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    while driver.count.calls < calls {
        driver.call();
    }
    println!("{:?}", driver.count);
    let count = &driver.count;
    assert!(count.good > calls / 20 && count.steps > calls / 100 && count.runs > calls / 1000, "{count:?}");
    assert!(count.restored > calls / 1000 && count.forged_restored > calls / 1000, "{count:?}");
    driver
}

#[test]
fn twenty_thousand_calls_by_chance() {
    let driver = drive(20_000, 1);
    assert_eq!(driver.called.len(), FUNCTIONS, "{:?}", driver.called);
}

#[test]
#[ignore = "long: a million calls"]
fn a_million_calls_by_chance() {
    // Fifty hosts, two at a time.
    std::thread::scope(|scope| {
        for half in 0..2 {
            scope.spawn(move || (0..25).for_each(|k| drop(drive(20_000, 100 + 2 * k + half))));
        }
    });
}

#[test]
#[ignore = "run by a_part_of_them_under_valgrind"]
fn fewer_calls() {
    drive(4_000, 7);
}

#[test]
#[ignore = "long: needs valgrind"]
fn a_part_of_them_under_valgrind() {
    let mut valgrind = Command::new("valgrind");
    valgrind.args(["--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite", "-q"]);
    let output = valgrind
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "fewer_calls", "--ignored", "--nocapture", "--test-threads=1"])
        .output()
        .expect("valgrind, which Debian has, is needed");
    let [said, complaints] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    println!("{said}\n{complaints}");
    assert!(output.status.success());
}
