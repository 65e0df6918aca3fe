//! The functions of a shared library, looked up once.

/// Declares the table of functions and how it is filled from a library and from the names of its functions for states.
macro_rules! functions {
    ($name:ident: $states:expr; $($(#[$optional:ident])? $field:ident: $symbol:literal as $signature:ty;)+) => {
        /// The functions this program calls; the library stays loaded as long as they exist.
        pub struct $name {
            $(pub $field: $crate::fmi::symbols::functions!(@type $($optional)? $signature),)+
            /// Functions for states.
            pub states: $crate::fmi::states::StateFunctions,
            _library: ::libloading::Library,
        }

        impl $name {
            /// Loads a library and looks up all functions.
            pub fn load(path: &::std::path::Path) -> Result<Self, $crate::fmi::FmiError> {
                // SAFETY: running a foreign library's initialisers is what loading an FMU means.
                let library = unsafe { ::libloading::Library::new(path) }.map_err(|e| $crate::fmi::FmiError::Load {
                    path: path.to_path_buf(),
                    reason: e.to_string(),
                })?;
                // SAFETY: the signatures are those of the FMI headers; the pointers live in the struct
                // that owns the library.
                unsafe {
                    Ok(Self {
                        $($field: $crate::fmi::symbols::functions!(@load $($optional)? library, $symbol, $signature),)+
                        states: $crate::fmi::states::StateFunctions::of(&library, $states),
                        _library: library,
                    })
                }
            }
        }
    };
    (@type optional $signature:ty) => { Option<$signature> };
    (@type $signature:ty) => { $signature };
    (@load optional $library:ident, $symbol:literal, $signature:ty) => {
        $library.get::<$signature>($symbol).ok().map(|symbol| *symbol)
    };
    (@load $library:ident, $symbol:literal, $signature:ty) => {
        *$library
            .get::<$signature>($symbol)
            .map_err(|_| $crate::fmi::FmiError::MissingSymbol($symbol.to_owned()))?
    };
}

pub(crate) use functions;
