//! What an instance goes through alike in FMI 2.0 and 3.0.

/// Defines a version's functions that differ from the other's in their names only; the third one ends with `$then`.
macro_rules! life_functions {
    ($set_debug_logging:ident, $free_instance:ident, $(#[$doc:meta])+ $set_up:ident, $then:expr) => {
        /// Switches log categories on or off.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set_debug_logging(
            instance: *mut c_void,
            logging_on: Boolean,
            n: usize,
            categories: *const *const c_char,
        ) -> Status {
            // SAFETY: see the top of this file.
            unsafe {
                call(instance, stringify!($set_debug_logging), ANY, |c| {
                    c.logger.select(logging_on != 0, &texts(categories, n, "log category")?)
                })
            }
        }

        /// Frees an instance and all states it still holds; NULL is ignored.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free_instance(instance: *mut c_void) {
            // SAFETY: see the top of this file; the pointer was made by this version's instantiation.
            unsafe { guard::free(instance) };
        }

        $(#[$doc])+
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set_up(
            instance: *mut c_void,
            tolerance_defined: Boolean,
            tolerance: f64,
            start_time: f64,
            stop_time_defined: Boolean,
            stop_time: f64,
        ) -> Status {
            let then: fn(&mut Component) -> guard::Outcome = $then;
            // SAFETY: see the top of this file.
            unsafe {
                call(instance, stringify!($set_up), INSTANTIATED, |c| {
                    let tolerance = (tolerance_defined != 0).then_some(tolerance);
                    c.set_experiment(tolerance, start_time, (stop_time_defined != 0).then_some(stop_time))?;
                    then(c)
                })
            }
        }
    };
}
pub(crate) use life_functions;
