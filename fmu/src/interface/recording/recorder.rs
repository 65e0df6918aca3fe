//! Writes frames along a run.

use super::FieldSettings;
use super::pace::Pace;
use super::series::{Frame, Series};
use crate::Instance;
use crate::fields::FieldsError;
use serde::{Deserialize, Serialize};

/// A series and what decides over its next frame.
#[derive(Debug)]
pub struct Recorder {
    series: Series,
    pace: Pace,
}

/// What a saved state keeps of a recorder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecorderState {
    pace: Pace,
    frames: Vec<Frame>,
}

impl Recorder {
    /// Begins the series with a frame at the start, `time` (s); none where no path is set.
    ///
    /// # Errors
    /// When the model has no fields or the place cannot be written.
    pub fn begin(
        settings: &FieldSettings,
        instance: &mut Instance,
        time: f64,
    ) -> Result<Option<Self>, FieldsError> {
        if settings.path.is_empty() {
            return Ok(None);
        }
        // Before anything is written: a model without fields leaves no trace.
        let fields = instance.fields()?;
        let mut series = Series::begin(&settings.path)?;
        series.add(time, &fields)?;
        let radius = instance.parameters().geometry.punch_radius;
        let pace = Pace::new(settings, radius, time, instance.outputs().displacement);
        Ok(Some(Self { series, pace }))
    }

    /// Before a step from `time` (s) with the punch at `velocity` (m/s); returns what [`Recorder::undo`] needs.
    ///
    /// # Errors
    /// When a frame cannot be made.
    pub fn before_step(
        &mut self,
        instance: &mut Instance,
        time: f64,
        velocity: f64,
    ) -> Result<Pace, FieldsError> {
        let before = self.pace;
        if self.pace.turns(time, instance.outputs().displacement, velocity) {
            self.record(instance, time).inspect_err(|_| self.pace = before)?;
        }
        Ok(before)
    }

    /// The step failed.
    pub fn undo(&mut self, before: &Pace) {
        self.pace.unturn(before);
    }

    /// After a step to `time` (s).
    ///
    /// # Errors
    /// When a frame cannot be made.
    pub fn after_step(&mut self, instance: &mut Instance, time: f64) -> Result<(), FieldsError> {
        if self.pace.is_due(time, instance.outputs().displacement) {
            self.record(instance, time)?;
        }
        Ok(())
    }

    /// At the end of a run, which is a frame too.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn finish(&mut self, instance: &mut Instance, time: f64) -> Result<(), FieldsError> {
        if self.pace.is_new(time) {
            self.record(instance, time)?;
        }
        Ok(())
    }

    fn record(&mut self, instance: &mut Instance, time: f64) -> Result<(), FieldsError> {
        let fields = instance.fields()?;
        self.series.add(time, &fields)?;
        self.pace.note(time, instance.outputs().displacement);
        Ok(())
    }

    /// What a saved state keeps.
    pub fn save(&self) -> RecorderState {
        RecorderState { pace: self.pace, frames: self.series.frames().to_vec() }
    }

    /// Makes `present` the recorder of a saved state with its series at `path`; later frames are removed.
    ///
    /// # Errors
    /// When the files cannot be changed.
    pub fn restore(
        present: &mut Option<Self>,
        path: &str,
        saved: Option<&RecorderState>,
    ) -> Result<(), FieldsError> {
        match (saved, &mut *present) {
            (None, _) => *present = None,
            (Some(saved), Some(recorder)) if recorder.series.is_at(path) => {
                recorder.series.return_to(&saved.frames)?;
                recorder.pace = saved.pace;
            }
            (Some(saved), _) => {
                let series = Series::resume(path, &saved.frames)?;
                *present = Some(Self { series, pace: saved.pace });
            }
        }
        Ok(())
    }
}
