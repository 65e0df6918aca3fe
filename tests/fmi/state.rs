//! D. Saved states: bit-identical, valid in another process, corrupt bytes refused, no growth.

use super::support::{archive, check_states, fmu, get, load, python, read_rows, resident_mb, running};

#[test]
fn going_back_repeats_a_thousand_steps_bit_for_bit() {
    check_states(running(), fmu().instantiate("other").unwrap());
}

#[test]
fn another_process_continues_bit_for_bit() {
    let mut instance = running();
    load(&mut instance, 0.0, 0.1, 4);
    let state = instance.get_state().unwrap();
    let folder = tempfile::TempDir::new().unwrap();
    let (file, out) = (folder.path().join("state"), folder.path().join("out"));
    std::fs::write(&file, instance.serialize_state(&state).unwrap()).unwrap();
    python(&["resume", archive().to_str().unwrap(), file.to_str().unwrap(), out.to_str().unwrap()]);
    for row in read_rows(&out) {
        let time = row[0];
        // The same number that Python forms: now * 1e-3.
        super::support::set(&mut instance, "displacement", time * 1e-3);
        instance.do_step(time, 0.1).unwrap();
        assert_eq!(get(&mut instance, "force").to_bits(), row[1].to_bits());
    }
}

/// Random numbers of xorshift64*: the test needs variety, not quality.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % n
    }
}

fn corrupt(n: usize) {
    let mut instance = running();
    load(&mut instance, 0.0, 0.05, 1);
    let state = instance.get_state().unwrap();
    let good = instance.serialize_state(&state).unwrap();
    let mut random = Random(20_231);
    for turn in 0..n {
        let mut bytes = good.clone();
        match turn % 5 {
            0 => bytes[random.below(good.len())] ^= 1 << random.below(8),
            1 => bytes.truncate(random.below(good.len())),
            2 => bytes.extend((0..=random.below(64)).map(|i| i as u8)),
            // In the header, where lengths and versions are.
            3 => bytes[random.below(40)] = bytes[random.below(40)].wrapping_add(1 + random.below(255) as u8),
            _ => bytes = (0..random.below(200)).map(|_| random.below(256) as u8).collect(),
        }
        if bytes != good {
            let error = instance.deserialize_state(&bytes).unwrap_err().to_string();
            assert!(error.contains("not a saved state"), "{error}");
        }
    }
    // Still alive and well.
    load(&mut instance, 0.05, 0.05, 1);
}

#[test]
fn corrupt_bytes_are_errors() {
    corrupt(2_000);
}

#[test]
#[ignore = "long: 1e5 corrupted states"]
fn corrupt_bytes_are_errors_long() {
    corrupt(100_000);
}

fn get_and_free(n: usize) {
    let mut instance = running();
    load(&mut instance, 0.0, 0.05, 2);
    let mut turns = |n: usize| {
        for _ in 0..n {
            let state = instance.get_state().unwrap();
            instance.free_state(state).unwrap();
        }
    };
    turns(1_000);
    // Other tests run in this process at the same time: a leak shows in every batch, what they hold in some.
    let batch = |_| {
        let before = resident_mb();
        turns(n / 5);
        resident_mb() - before
    };
    let growth = (0..5).map(batch).fold(f64::INFINITY, f64::min);
    println!("{n} times GetFMUstate and FreeFMUstate: growth at least {growth:.3} MB in a fifth of them");
    // A leak would be a fifth of n states of some 100 kB; a page now and then is none.
    assert!(growth < n as f64 * 1e-4, "grown by {growth} MB");
}

#[test]
fn getting_and_freeing_states_does_not_grow() {
    get_and_free(300_000 / 3);
}

#[test]
#[ignore = "long: 1e6 states"]
fn getting_and_freeing_states_does_not_grow_long() {
    get_and_free(1_000_000);
}
