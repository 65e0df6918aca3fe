//! Rows of a file, in SI, to one measurement.

use super::error::Problem;
use super::header::{Column, Quantity};
use super::measurement::Measurement;
use super::reader::FEWEST_POINTS;
use std::collections::BTreeMap;

/// One row in SI units.
#[derive(Debug, Default)]
pub struct Row {
    time: f64,
    displacement: f64,
    force: Option<f64>,
    std: Option<f64>,
    quartiles: (Option<f64>, Option<f64>),
    specimens: Vec<f64>,
    /// Name of the specimen; empty where the file has no such column.
    pub specimen: String,
    line: u64,
}

impl Row {
    /// A row of a line, still empty.
    pub fn at(line: u64) -> Self {
        Self { line, ..Self::default() }
    }

    /// Takes a value in SI.
    ///
    /// # Errors
    /// When a spread is negative.
    pub fn set(&mut self, column: &Column, value: f64) -> Result<(), Problem> {
        match column.quantity {
            Quantity::Time => self.time = value,
            Quantity::Displacement => self.displacement = value,
            Quantity::Force => self.force = Some(value),
            Quantity::ForceStd if value < 0.0 => return Err(Problem::NegativeSpread(value / column.factor)),
            Quantity::ForceStd => self.std = Some(value),
            Quantity::ForceQ25 => self.quartiles.0 = Some(value),
            Quantity::ForceQ75 => self.quartiles.1 = Some(value),
            Quantity::SpecimenForce => self.specimens.push(value),
            Quantity::Specimen | Quantity::Unused => {}
        }
        Ok(())
    }

    /// Standard deviation given, or from the quartiles of a normal distribution.
    fn spread(&self) -> Result<Option<f64>, Problem> {
        const QUARTILES_PER_DEVIATION: f64 = 1.348_979_5;
        match (self.std, self.quartiles) {
            (Some(std), _) => Ok(Some(std)),
            (None, (Some(q25), Some(q75))) if q75 < q25 => Err(Problem::NegativeSpread((q75 - q25) * 1e3)),
            (None, (Some(q25), Some(q75))) => Ok(Some((q75 - q25) / QUARTILES_PER_DEVIATION)),
            _ => Ok(None),
        }
    }
}

/// Rows by specimen (one nameless specimen when there is no such column).
#[derive(Debug, Default)]
pub struct Table {
    specimens: BTreeMap<String, Vec<Row>>,
}

impl Table {
    /// Whether there is any.
    pub fn has_rows(&self) -> bool {
        !self.specimens.is_empty()
    }

    /// Adds a row.
    ///
    /// # Errors
    /// When its time does not come after the one before, or its quartiles are the wrong way round.
    pub fn push(&mut self, row: Row) -> Result<(), (&'static str, Problem)> {
        row.spread().map_err(|p| ("force_q75", p))?;
        let rows = self.specimens.entry(row.specimen.clone()).or_default();
        if let Some(last) = rows.last().filter(|last| row.time <= last.time) {
            let (time_s, previous_s) = (row.time, last.time);
            return Err(("time", Problem::NonMonotonicTime { time_s, previous_s }));
        }
        rows.push(row);
        Ok(())
    }

    /// The measurement of all rows.
    ///
    /// # Errors
    /// When there are none, or the specimens were not measured at the same times.
    pub fn into_measurement(self, described: Measurement) -> Result<Measurement, Problem> {
        let mut groups = self.specimens.into_iter();
        let Some((first, rows)) = groups.next() else {
            return Err(Problem::TooFewPoints { found: 0, needed: FEWEST_POINTS });
        };
        let time_s: Vec<f64> = rows.iter().map(|r| r.time).collect();
        let displacement_m: Vec<f64> = rows.iter().map(|r| r.displacement).collect();
        let lines = rows.iter().map(|r| r.line).collect();
        let mut m = Measurement { time_s, displacement_m, lines, ..described };
        let groups: Vec<_> = groups.collect();
        if groups.is_empty() {
            let n = rows.first().map_or(0, |r| r.specimens.len());
            m.specimens_n = (0..n).map(|k| rows.iter().map(|r| r.specimens[k]).collect()).collect();
            m.force_n = rows.iter().filter_map(|r| r.force).collect();
            let spread: Vec<f64> = rows.iter().filter_map(|r| r.spread().ok().flatten()).collect();
            m.spread_n = (spread.len() == rows.len()).then_some(spread);
            let quartiles: Vec<_> = rows.iter().filter_map(|r| r.quartiles.0.zip(r.quartiles.1)).collect();
            m.quartiles_n = (quartiles.len() == rows.len()).then_some(quartiles);
        } else {
            m.specimens_n.push(rows.iter().filter_map(|r| r.force).collect());
            m.specimen_names.push(first.clone());
            for (specimen, rows) in groups {
                let same = rows.len() == m.len()
                    && rows
                        .iter()
                        .zip(m.time_s.iter().zip(&m.displacement_m))
                        .all(|(r, (t, d))| (r.time - t).abs() < 1e-9 && (r.displacement - d).abs() < 1e-7);
                if !same {
                    return Err(Problem::SpecimensDiffer { specimen, first });
                }
                m.specimens_n.push(rows.iter().filter_map(|r| r.force).collect());
                m.specimen_names.push(specimen);
            }
        }
        m.summarise_specimens();
        Ok(m)
    }
}
