//! The complete state of a slave, saved, restored and as bytes.

use super::{Run, Slave, SlaveError, protocol};
use crate::interface::hash::hash_128;
use crate::interface::model_description::guid_bytes;
use crate::interface::recording::{Recorder, RecorderState};
use crate::interface::variables::Settings;
use crate::{Instance, Snapshot};
use serde::{Deserialize, Serialize};

/// A complete saved state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SlaveState {
    settings: Settings,
    derivative: Option<f64>,
    run: Option<RunState>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct RunState {
    start_time: f64,
    time: f64,
    snapshot: Snapshot,
    recorder: Option<RecorderState>,
}

impl Slave {
    /// The complete state.
    pub fn save(&self) -> SlaveState {
        let run = self.run.as_ref().map(|run| RunState {
            start_time: run.start_time,
            time: run.time,
            snapshot: run.instance.save(),
            recorder: run.recorder.as_ref().map(Recorder::save),
        });
        SlaveState { settings: self.settings.clone(), derivative: self.derivative, run }
    }

    /// Returns to a saved state, bit for bit.
    ///
    /// # Errors
    /// When the state does not fit its own parameters; nothing has changed then.
    pub fn restore(&mut self, state: &SlaveState) -> Result<(), SlaveError> {
        match &state.run {
            None => self.run = None,
            Some(saved) => self.restore_run(&state.settings, saved)?,
        }
        self.settings = state.settings.clone();
        self.derivative = state.derivative;
        Ok(())
    }

    fn restore_run(&mut self, settings: &Settings, saved: &RunState) -> Result<(), SlaveError> {
        let settings = &settings.chosen();
        settings.validate_branches()?;
        let (start_time, time, protocol) = (saved.start_time, saved.time, protocol(settings)?);
        let parameters = settings.parameters();
        let (path, recorded) = (&settings.fields.path, saved.recorder.as_ref());
        let same = self.model.as_ref().is_some_and(|model| *model.parameters() == parameters);
        if let Some(run) = self.run.as_mut().filter(|_| same) {
            let before = run.instance.save();
            run.instance.restore(&saved.snapshot)?;
            if let Err(error) = Recorder::restore(&mut run.recorder, path, recorded) {
                // Cannot fail: the state was saved by this very instance.
                let _ = run.instance.restore(&before);
                return Err(error.into());
            }
            (run.start_time, run.time, run.protocol) = (start_time, time, protocol);
            return Ok(());
        }
        let model = self.model(parameters)?;
        // The snapshot overwrites the punch's position: any admissible one will do, like the true surface.
        let surface = -settings.padded.effect.offset.height;
        let mut instance = Instance::new(&model, surface)?;
        instance.restore(&saved.snapshot)?;
        let mut recorder = self.run.as_mut().and_then(|run| run.recorder.take());
        Recorder::restore(&mut recorder, path, recorded)?;
        self.model = Some(model);
        self.run = Some(Run { instance, start_time, time, protocol, recorder });
        Ok(())
    }
}

const MAGIC: [u8; 8] = *b"POROFMU\0";
const VERSION: u32 = 4;
/// Magic, version, GUID, length of the payload.
const HEADER: usize = 8 + 4 + 16 + 8;
const CHECKSUM: usize = 16;

impl SlaveState {
    /// Header, payload, checksum; little-endian, valid in another process and on another machine.
    /// `attachment` is stored beside the state: the caller's own.
    ///
    /// # Errors
    /// When the state cannot be written.
    pub fn to_bytes(&self, attachment: &[u8]) -> Result<Vec<u8>, SlaveError> {
        let payload = postcard::to_allocvec(&(attachment, self))
            .map_err(|_| SlaveError::BadState("it cannot be serialised"))?;
        let mut bytes = Vec::with_capacity(HEADER + payload.len() + CHECKSUM);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(guid_bytes());
        bytes.extend((payload.len() as u64).to_le_bytes());
        bytes.extend(payload);
        bytes.extend(hash_128(&bytes));
        Ok(bytes)
    }

    /// Reads what [`SlaveState::to_bytes`] wrote: state and attachment.
    ///
    /// # Errors
    /// When anything about the bytes is wrong: they may come from anywhere.
    pub fn from_bytes(bytes: &[u8]) -> Result<(Self, Vec<u8>), SlaveError> {
        let bad = SlaveError::BadState;
        let body =
            bytes.len().checked_sub(CHECKSUM).filter(|&n| n >= HEADER).ok_or(bad("it is too short"))?;
        let (body, checksum) = bytes.split_at(body);
        if body[..8] != MAGIC {
            return Err(bad("it does not begin like one"));
        }
        if body[8..12] != VERSION.to_le_bytes() {
            return Err(bad("another version of the format"));
        }
        if body[12..28] != *guid_bytes() {
            return Err(bad("written by an FMU with another GUID"));
        }
        if body[28..HEADER] != ((body.len() - HEADER) as u64).to_le_bytes() {
            return Err(bad("its length is wrong"));
        }
        if *checksum != hash_128(body) {
            return Err(bad("its checksum is wrong"));
        }
        let (attachment, state): (_, Self) =
            postcard::from_bytes(&body[HEADER..]).map_err(|_| bad("its contents cannot be read"))?;
        state.validate()?;
        Ok((state, attachment))
    }

    /// Checks what a checksum does not: nothing may be restored that could not have been set or reached.
    fn validate(&self) -> Result<(), SlaveError> {
        self.settings.validate()?;
        let run = self.run.as_ref();
        let times = run.map_or([0.0; 2], |run| [run.start_time, run.time]);
        if !(times.iter().chain(&self.derivative).all(|number| number.is_finite())) {
            return Err(SlaveError::BadState("a time or derivative is no number"));
        }
        if run.is_some_and(|run| !run.snapshot.is_sound()) {
            return Err(SlaveError::BadState("its path could not have been reached"));
        }
        Ok(())
    }
}
