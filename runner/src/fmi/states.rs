//! Saved states, alike in FMI 2.0 and 3.0 but for the functions' names.

/// Defines what a [`Face`](super::instance::Face) does with states, by an instance's `binary`, `component`, `description` and `messages`; takes
/// the names of the functions.
macro_rules! states {
    ($get:literal, $set:literal, $free:literal, $size:literal, $serialize:literal, $deserialize:literal) => {
        fn get_state(&mut self) -> Result<FmuState, FmiError> {
            let get = self.binary.get_state.filter(|_| self.description.capabilities.get_and_set_state);
            let get = get.ok_or(FmiError::NotSupported("save its state"))?;
            let mut state = std::ptr::null_mut();
            // SAFETY: a live component of this library; NULL asks for a new state.
            let status = unsafe { get(self.component, &raw mut state) };
            self.messages.check($get, status)?;
            Ok(FmuState(state))
        }

        fn set_state(&mut self, state: &FmuState) -> Result<(), FmiError> {
            let set = self.binary.set_state.ok_or(FmiError::NotSupported("restore its state"))?;
            // SAFETY: a live component of this library and a state it made.
            let status = unsafe { set(self.component, state.0) };
            self.messages.check($set, status)
        }

        fn free_state(&mut self, mut state: FmuState) -> Result<(), FmiError> {
            let free = self.binary.free_state.ok_or(FmiError::NotSupported("free its state"))?;
            // SAFETY: a live component of this library and a state it made.
            let status = unsafe { free(self.component, &raw mut state.0) };
            self.messages.check($free, status)
        }

        fn serialize_state(&mut self, state: &FmuState) -> Result<Vec<u8>, FmiError> {
            let missing = FmiError::NotSupported("serialise its state");
            let (Some(size_of), Some(write)) = (self.binary.state_size, self.binary.serialize_state) else {
                return Err(missing);
            };
            let mut size = 0;
            // SAFETY: a live component of this library and a state it made.
            let status = unsafe { size_of(self.component, state.0, &raw mut size) };
            self.messages.check($size, status)?;
            let mut bytes = vec![0; size];
            // SAFETY: the buffer has the size the FMU asked for.
            let status = unsafe { write(self.component, state.0, bytes.as_mut_ptr(), size) };
            self.messages.check($serialize, status)?;
            Ok(bytes)
        }

        fn deserialize_state(&mut self, bytes: &[u8]) -> Result<FmuState, FmiError> {
            let read =
                self.binary.deserialize_state.ok_or(FmiError::NotSupported("deserialise its state"))?;
            let mut state = std::ptr::null_mut();
            // SAFETY: a live component of this library; the buffer has the stated length.
            let status = unsafe { read(self.component, bytes.as_ptr(), bytes.len(), &raw mut state) };
            self.messages.check($deserialize, status)?;
            Ok(FmuState(state))
        }
    };
}

pub(crate) use states;
