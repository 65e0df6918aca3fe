//! E. Many instances at once equal one after the other, bit for bit; and the cost of a call.

use super::support::{fmu, get, load, reference, running, set};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Force histories of `n` instances with parameters of their own, `threads` at a time.
fn sweep(n: usize, threads: usize) -> Vec<Vec<u64>> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(vec![Vec::new(); n]);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    if i >= n {
                        return;
                    }
                    let mut instance = super::support::coarse();
                    set(&mut instance, "material.branch[2].eta", 4000.0 + 10.0 * i as f64);
                    super::support::initialise(&mut instance, None);
                    let forces = load(&mut instance, 0.0, 0.05, 3);
                    results.lock().unwrap()[i] = forces;
                }
            });
        }
    });
    results.into_inner().unwrap()
}

#[test]
fn sixty_four_threads_equal_serial() {
    let serial = sweep(64, 1);
    assert_eq!(sweep(64, 64), serial);
    assert_ne!(serial[0], serial[63], "the parameters must matter");
}

#[test]
#[ignore = "long: 1000 instances"]
fn a_thousand_instances_equal_serial() {
    assert_eq!(sweep(1000, 100), sweep(1000, 1));
}

#[test]
fn an_instance_may_move_between_threads() {
    let expected = load(&mut running(), 0.0, 0.05, 8);
    let mut instance = running();
    let mut forces = Vec::new();
    for n in 0..8 {
        let moved = std::thread::spawn(move || {
            let force = load(&mut instance, n as f64 * 0.05, 0.05, 1);
            (instance, force)
        });
        let (back, force) = moved.join().unwrap();
        instance = back;
        forces.extend(force);
    }
    assert_eq!(forces, expected);
}

#[test]
fn a_call_costs_less_than_a_microsecond() {
    let mut instance = running();
    let references = [reference("force")];
    let input = [reference("displacement")];
    // The best of some batches: other processes share the machine.
    let mut best = |run: &mut dyn FnMut(&mut runner::fmi::FmuInstance)| {
        let batch = (0..20).map(|_| {
            let start = Instant::now();
            for _ in 0..1000 {
                run(&mut instance);
            }
            start.elapsed().as_secs_f64() / 1000.0
        });
        batch.fold(f64::INFINITY, f64::min)
    };
    let get_cost = best(&mut |i| assert!(i.get_real(&references).unwrap()[0].abs() < 1.0));
    let set_cost = best(&mut |i| i.set_real(&input, &[0.0]).unwrap());
    println!("GetReal {:.0} ns, SetReal {:.0} ns", get_cost * 1e9, set_cost * 1e9);
    assert!(get_cost < 1e-6 && set_cost < 1e-6, "get {get_cost} s, set {set_cost} s");
    assert!(get(&mut instance, "force").abs() < 1.0);
    assert!(fmu().library().exists());
}
