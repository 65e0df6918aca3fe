//! States and resets, whose functions have other names in the two versions and the same arguments.

/// Defines `state`, which does something by chance with a state, and `reset`; `$read_time` follows a restored state.
macro_rules! states {
    (
        $reset:ident, $read_time:ident, $get:ident, $set:ident, $free:ident, $size:ident, $serialise:ident,
        $deserialise:ident
    ) => {
        fn reset(driver: &mut Driver, which: usize) {
            assert!(call!(driver, $reset(driver.slaves[which].component)));
            driver.slaves[which].time = 0.0;
        }

        fn state(driver: &mut Driver, which: usize) {
            let c = driver.slaves[which].component;
            let chosen = driver.random.below(driver.states.len());
            let mut state = driver.states[chosen];
            match driver.random.below(6) {
                0 if driver.states.len() < 12 => {
                    let mut new = null_mut();
                    if call!(driver, $get(c, &mut new)) {
                        driver.states.push(new);
                    }
                }
                0 | 1 => {
                    call!(driver, $free(c, &mut state));
                    // Sometimes it stays: a handle that is none any more.
                    if driver.states.len() > 8 || driver.random.one_in(2) {
                        driver.states.swap_remove(chosen);
                        if driver.states.is_empty() {
                            let none = driver.random.of(&[null_mut(), 8 as *mut c_void, usize::MAX as _]);
                            driver.states.push(none);
                        }
                    }
                }
                2 => {
                    if call!(driver, $set(c, state)) {
                        driver.count.restored += 1;
                        $read_time(driver, which);
                    }
                }
                3 => {
                    let mut size = 0;
                    if call!(driver, $size(c, state, &mut size)) {
                        let mut bytes = vec![0; size];
                        let less = driver.random.below(2);
                        if call!(driver, $serialise(c, state, bytes.as_mut_ptr(), size - less)) {
                            driver.bytes = bytes;
                        }
                    }
                }
                _ => {
                    let (bytes, forged) = driver.random.forged(&driver.bytes);
                    let all = bytes.len();
                    let n = if driver.random.one_in(20) { driver.random.below(all + 1) } else { all };
                    let mut new = null_mut();
                    if call!(driver, $deserialise(c, bytes.as_ptr(), n, &mut new)) {
                        if call!(driver, $set(c, new)) {
                            driver.count.forged_restored += usize::from(forged);
                            $read_time(driver, which);
                        }
                        assert!(call!(driver, $free(c, &mut new)));
                    }
                }
            }
        }
    };
}
pub(crate) use states;
