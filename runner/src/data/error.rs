//! What can be wrong with a measurement file, where, and what to do about it.

use super::number::DecimalMark;
use super::reading::Reading;
use std::fmt;
use std::path::PathBuf;
use thiserror::Error;

/// A file that cannot be used: where and why.
#[derive(Debug, Clone, PartialEq)]
pub struct DataError {
    /// The file.
    pub file: PathBuf,
    /// Line in the file, counted from 1, if the problem has one.
    pub line: Option<u64>,
    /// Column as the header names it, if the problem has one.
    pub column: Option<String>,
    /// What is wrong.
    pub problem: Problem,
}

impl fmt::Display for DataError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", column `{column}`")?;
        }
        write!(f, ": {}\n  remedy: {}", self.problem, self.problem.remedy())
    }
}

impl std::error::Error for DataError {}

/// Something that a file leaves open, and an option that answers it.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// The question.
    pub what: String,
    /// The option that answers it in the way that is most likely.
    pub answer: String,
}

impl Question {
    /// Assumes the answer about columns and numbers, so that what depends on it can be asked in the same go.
    pub fn assume(&self, reading: &mut Reading) {
        let column = self.answer.strip_prefix("--column '").and_then(|a| a.strip_suffix('\''));
        let choice = column.and_then(|choice| choice.parse().ok());
        // A question that its own answer leaves open would be asked for ever.
        reading.columns.extend(choice.filter(|c| !reading.columns.contains(c)));
        if self.answer == "--decimal comma" {
            reading.decimal = Some(DecimalMark::Comma);
        }
    }
}

/// What is wrong with a file.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Problem {
    /// The operating system refuses.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// Not text.
    #[error("is no text")]
    NotText,
    /// No header at all.
    #[error("the file is empty")]
    Empty,
    /// The first row holds numbers.
    #[error("the first row is not a header: it holds numbers")]
    NoHeader,
    /// A column that is needed and absent.
    #[error("there is no column for the {0}")]
    MissingColumn(&'static str),
    /// A column that means nothing.
    #[error("unknown column")]
    UnknownColumn,
    /// A column that means nothing, where a quantity is missing.
    #[error("unknown column, and there is no column for the {0}")]
    UnknownInstead(&'static str),
    /// A column that the user named.
    #[error("there is no column `{name}`; the columns are `{all}`")]
    NoSuchColumn {
        /// As named.
        name: String,
        /// Those that are there.
        all: String,
    },
    /// The file can be read in several ways.
    #[error("the file leaves open:{}", numbered(.0))]
    Unclear(Vec<Question>),
    /// A number that stands for none.
    #[error("`{0}` stands for a value that is missing")]
    Sentinel(String),
    /// A number beyond everything that can be measured.
    #[error("`{0}` is beyond everything that can be measured")]
    Absurd(String),
    /// One specimen under two names.
    #[error("specimens `{first}` and `{second}` are the same data")]
    SameTwice {
        /// The one.
        first: String,
        /// The other.
        second: String,
    },
    /// Two tests of one name.
    #[error("a second test is called `{0}`")]
    SameName(String),
    /// Two columns for the same quantity.
    #[error("is the second column for the same quantity as `{0}`")]
    DuplicateColumn(String),
    /// A quantity without its unit.
    #[error("has no unit")]
    MissingUnit {
        /// A spelling that would be understood.
        example: &'static str,
    },
    /// A unit that is unknown or measures something else.
    #[error("`{unit}` is not a unit of {quantity}")]
    WrongUnit {
        /// As written.
        unit: String,
        /// Quantity of the column.
        quantity: &'static str,
        /// What would be understood.
        known: String,
    },
    /// A row with another number of fields than the header.
    #[error("the row has {found} fields, the header has {expected}")]
    FieldCount {
        /// Fields of the row.
        found: usize,
        /// Columns of the header.
        expected: usize,
    },
    /// A field that is not a number.
    #[error("`{0}` is not a number")]
    NotANumber(String),
    /// NaN or infinity.
    #[error("`{0}` is not a finite number")]
    NotFinite(String),
    /// An empty field.
    #[error("the field is empty")]
    EmptyField,
    /// Time does not increase.
    #[error("time {time_s} s does not come after {previous_s} s")]
    NonMonotonicTime {
        /// Time of the row (s).
        time_s: f64,
        /// Time of the row before (s).
        previous_s: f64,
    },
    /// A spread below zero.
    #[error("a spread cannot be negative ({0})")]
    NegativeSpread(f64),
    /// Not enough rows.
    #[error("{found} points are too few, at least {needed} are needed")]
    TooFewPoints {
        /// Rows with data.
        found: usize,
        /// Rows needed.
        needed: usize,
    },
    /// The punch stays above the surface.
    #[error("the punch never touches the sample: the largest displacement is {max_mm} mm")]
    NeverTouches {
        /// Largest displacement (mm).
        max_mm: f64,
    },
    /// The first row already indents.
    #[error("the history starts inside the sample, at {start_mm} mm")]
    StartsInside {
        /// First displacement (mm).
        start_mm: f64,
    },
    /// Deeper than the sample is high.
    #[error("the displacement reaches {depth_mm} mm, but the sample is {height_mm} mm high")]
    TooDeep {
        /// Largest displacement (mm).
        depth_mm: f64,
        /// Height of the sample (mm).
        height_mm: f64,
    },
    /// The displacement changes impossibly fast.
    #[error("the displacement jumps from {from_mm:.4} to {to_mm:.4} mm within {within_s:.4} s")]
    DisplacementJumps {
        /// Before (mm).
        from_mm: f64,
        /// After (mm).
        to_mm: f64,
        /// Time between the two (s).
        within_s: f64,
    },
    /// The punch only rests, or only moves out.
    #[error("there is no ramp: the punch does not move into the sample")]
    NoRamp,
    /// Files that are not specimens of one test.
    #[error(
        "its ramp ({rate_mm_s:.3} mm/s, {from_mm:.3} to {to_mm:.3} mm) does not match that of `{first}` ({first_rate_mm_s:.3} mm/s, {first_from_mm:.3} to {first_to_mm:.3} mm)"
    )]
    RampsDiffer {
        /// The file that the others are put onto.
        first: String,
        /// Rate (mm/s).
        rate_mm_s: f64,
        /// Beginning of the ramp (mm).
        from_mm: f64,
        /// End of the ramp (mm).
        to_mm: f64,
        /// Rate of the first file (mm/s).
        first_rate_mm_s: f64,
        /// Beginning of the first file's ramp (mm).
        first_from_mm: f64,
        /// End of the first file's ramp (mm).
        first_to_mm: f64,
    },
    /// Nothing is left of the time that all specimens were measured.
    #[error(
        "put onto the ramp of `{first}`, only {points} of its points lie within the time of all specimens"
    )]
    NoCommonTime {
        /// The file that the others are put onto.
        first: String,
        /// Points left.
        points: usize,
    },
    /// A directory or pattern without measurements.
    #[error("there is no CSV file here")]
    NoFiles,
    /// Two specimens are the same file.
    #[error("is named twice")]
    NamedTwice,
    /// Specimens of one file with different times or motion.
    #[error("specimen `{specimen}` was not measured at the same times and displacements as `{first}`")]
    SpecimensDiffer {
        /// The one that differs.
        specimen: String,
        /// The first one.
        first: String,
    },
}

fn numbered(questions: &[Question]) -> String {
    let line = |(i, q): (usize, &Question)| format!("\n  {}. {}\n     {}", i + 1, q.what, q.answer);
    questions.iter().enumerate().map(line).collect()
}

impl Problem {
    /// What the user can do.
    pub fn remedy(&self) -> String {
        match self {
            Self::Unreadable(_) => "check the path and the permissions".into(),
            Self::NotText => "export the file as text (CSV)".into(),
            Self::Empty => {
                "the file needs a header such as `time_s,displacement_mm,force_mN` and rows".into()
            }
            Self::NoHeader => {
                "put `time_s,displacement_mm,force_mN` (with your units) above the numbers".into()
            }
            Self::MissingColumn(what) => format!("add or rename one, for example `{}`", example_of(what)),
            Self::UnknownColumn => "rename or remove it; known are time, displacement, force, force_std, \
                 force_q25, force_q75, force_solid, force_fluid (each with its unit), specimen, and specimen \
                 forces in mN s01, s02, ..."
                .into(),
            Self::DuplicateColumn(first) => {
                format!("keep one of the two, or name the one that counts: --column '...={first}'")
            }
            Self::UnknownInstead(what) => format!(
                "rename or remove it, or say what it is, for example --column '{what}=NAME:{}'",
                example_of(what).rsplit('_').next().unwrap_or("")
            ),
            Self::NoSuchColumn { .. } => "name one of them, or give its number (1 is the first)".into(),
            Self::Unclear(questions) => {
                let answers: Vec<&str> = questions.iter().map(|q| q.answer.as_str()).collect();
                format!("answer all in one go, if this is so: {}", answers.join(" "))
            }
            Self::Sentinel(_) => "remove the row, or put the measured value there".into(),
            Self::Absurd(_) => "correct it, or the unit of the column".into(),
            Self::SameTwice { .. } => {
                "keep one of the two: a specimen that counts twice makes intervals too narrow".into()
            }
            Self::SameName(name) => format!("give each its own: {name}_1=FILE {name}_2=FILE"),
            Self::MissingUnit { example } => format!("write it into the name, for example `{example}`, or give it with --column"),
            Self::WrongUnit { known, .. } => format!("write one of {known} (capitals matter: mN is not MN)"),
            Self::FieldCount { .. } => {
                "check for decimal commas, missing separators or a line that was cut off".into()
            }
            Self::NotANumber(text) if text.contains(',') => "write decimal points, not commas".into(),
            Self::NotANumber(_) | Self::NotFinite(_) | Self::EmptyField => {
                "correct the value or remove the row".into()
            }
            Self::NonMonotonicTime { .. } => {
                "sort the rows by time and remove repeated ones; several tests need one file each".into()
            }
            Self::NegativeSpread(_) => {
                "a spread is a standard deviation, or quartiles with q25 <= q75".into()
            }
            Self::TooFewPoints { .. } => "measure or export more points of the loading and the hold".into(),
            Self::NeverTouches { .. } => {
                "displacement is positive into the sample, 0 at its surface; check sign, zero and unit".into()
            }
            Self::StartsInside { .. } => {
                "start the history at or above the surface (displacement <= 0), before first touch".into()
            }
            Self::TooDeep { .. } => {
                "check the unit of the displacement column, or set geometry.sample_height".into()
            }
            Self::DisplacementJumps { .. } => {
                "correct or remove that point; if the punch did move so fast, export more points of the stroke"
                    .into()
            }
            Self::NoRamp => {
                "start the file before the loading; displacement must grow when the punch goes in: \
                 --flip=displacement reverses it"
                    .into()
            }
            Self::RampsDiffer { .. } => {
                "specimens of one test share rate and depth to 10 %; give tests of another protocol separately"
                    .into()
            }
            Self::NoCommonTime { .. } => {
                "leave out the specimens whose files are too short, or export their whole test".into()
            }
            Self::NoFiles => "name a CSV file, a directory of one CSV file per specimen, or NAME=FILE,FILE,... \
                 (with * in quotes)"
                .into(),
            Self::NamedTwice => "name every specimen once".into(),
            Self::SpecimensDiffer { .. } => {
                "resample the specimens on common times, or give one file per specimen".into()
            }
        }
    }
}

fn example_of(what: &str) -> &'static str {
    match what {
        "time" => "time_s",
        "displacement" => "displacement_mm",
        "force" => "force_mN",
        "lower quartile" => "force_q25_mN",
        "upper quartile" => "force_q75_mN",
        _ => "specimen",
    }
}
