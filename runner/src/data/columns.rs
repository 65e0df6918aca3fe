//! Which column of a table is what: by this project's names, a laboratory's names, the row of units, and what the user says.

use super::error::{Problem, Question};
use super::header::{Column, Quantity, read_column};
use super::layout::Layout;
use super::names::{Rank, dimension, meaning, unit};
use super::number::DecimalMark;
use super::reading::{ColumnChoice, Reading};
use crate::units::known_units;

/// The columns of a table, in its order, and what is open.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    /// Each column; those that are not needed are `Unused`.
    pub all: Vec<Column>,
    /// What must be asked.
    pub questions: Vec<Question>,
    /// Names that are not used.
    pub unused: Vec<String>,
}

/// A complaint about one column, by its name.
pub type Complaint = (Option<String>, Problem);

const REQUIRED: [(Quantity, &str, &str); 3] = [
    (Quantity::Time, "time", "s"),
    (Quantity::Displacement, "displacement", "mm"),
    (Quantity::Force, "force", "mN"),
];

/// A column that may be a quantity.
struct Candidate {
    index: usize,
    rank: Rank,
    unit: Option<String>,
}

/// Resolves the columns of a table of which `force` is wanted or not.
///
/// # Errors
/// When a column of this project's own names is wrong, or a column that the user names is not there.
pub fn resolve(layout: &Layout, reading: &Reading, force: bool) -> Result<Columns, Complaint> {
    let unused = |name: &String| Column {
        name: name.clone(),
        quantity: Quantity::Unused,
        factor: 1.0,
        clock: None,
        own: false,
        note: None,
    };
    let mut columns =
        Columns { all: layout.names.iter().map(unused).collect(), questions: vec![], unused: vec![] };
    let mut own = vec![false; layout.names.len()];
    for (i, name) in layout.names.iter().enumerate() {
        match read_column(name) {
            Ok(column) => {
                own[i] = true;
                columns.all[i] = column;
            }
            // A laboratory's name, or one without its unit, is looked at below.
            Err(Problem::UnknownColumn | Problem::MissingUnit { .. }) => {}
            Err(problem) if meaning(name).is_none() => return Err((Some(name.clone()), problem)),
            Err(problem) if layout.units.is_none() && reading.columns.is_empty() => {
                return Err((Some(name.clone()), problem));
            }
            Err(_) => {}
        }
    }
    let specimens = columns.all.iter().any(|c| c.quantity == Quantity::SpecimenForce)
        && !columns.all.iter().any(|c| c.quantity == Quantity::Specimen);
    for (quantity, word, example) in REQUIRED {
        // The last word counts.
        let choice = reading.columns.iter().rfind(|c| c.quantity == quantity);
        if choice.is_none() && quantity == Quantity::Force && (specimens || !force) {
            let has_own = columns.all.iter().any(|c| c.quantity == quantity);
            if has_own || specimens || !force {
                continue;
            }
        }
        let candidates = match choice {
            Some(choice) => vec![chosen(layout, choice)?],
            None => candidates(layout, &columns.all, &own, quantity),
        };
        settle(&mut columns, layout, (quantity, word, example), candidates)?;
    }
    // A column that the user or a surer name took over is no second one.
    let needed = columns.all.clone();
    for (i, column) in columns.all.iter_mut().enumerate() {
        let taken = needed.iter().enumerate().any(|(k, c)| k != i && c.quantity == column.quantity);
        let single = REQUIRED.iter().any(|(q, ..)| *q == column.quantity);
        let asked = reading.columns.iter().any(|c| c.quantity == column.quantity);
        if single && taken && asked && own[i] && !is_choice(layout, reading, i) {
            column.quantity = Quantity::Unused;
        }
    }
    let left = columns.all.iter().enumerate().filter(|(i, c)| c.quantity == Quantity::Unused && !own[*i]);
    columns.unused = left.map(|(_, c)| c.name.clone()).filter(|name| !name.is_empty()).collect();
    Ok(columns)
}

fn is_choice(layout: &Layout, reading: &Reading, index: usize) -> bool {
    reading.columns.iter().any(|c| place(layout, &c.name) == Some(index))
}

fn place(layout: &Layout, name: &str) -> Option<usize> {
    let named = layout.names.iter().position(|n| n.eq_ignore_ascii_case(name));
    let number =
        || name.parse::<usize>().ok().filter(|n| (1..=layout.names.len()).contains(n)).map(|n| n - 1);
    named.or_else(number)
}

fn chosen(layout: &Layout, choice: &ColumnChoice) -> Result<Candidate, Complaint> {
    let all = layout.names.join("`, `");
    let missing = || (None, Problem::NoSuchColumn { name: choice.name.clone(), all });
    let index = place(layout, &choice.name).ok_or_else(missing)?;
    let in_name = meaning(&layout.names[index]).and_then(|m| m.unit);
    Ok(Candidate { index, rank: Rank::Own, unit: choice.unit.clone().or(in_name) })
}

fn candidates(layout: &Layout, all: &[Column], own: &[bool], quantity: Quantity) -> Vec<Candidate> {
    let one = |(index, name): (usize, &String)| {
        if own[index] {
            let is_it = all[index].quantity == quantity;
            return is_it.then_some(Candidate { index, rank: Rank::Own, unit: None });
        }
        let found = meaning(name).filter(|m| m.quantity == quantity)?;
        Some(Candidate { index, rank: found.rank, unit: found.unit })
    };
    layout.names.iter().enumerate().filter_map(one).collect()
}

/// Takes the surest candidate, or asks.
fn settle(
    columns: &mut Columns,
    layout: &Layout,
    (quantity, word, example): (Quantity, &'static str, &str),
    candidates: Vec<Candidate>,
) -> Result<(), Complaint> {
    let Some(best) = candidates.iter().map(|c| c.rank).min() else {
        let open: Vec<&str> =
            columns.all.iter().filter(|c| c.quantity == Quantity::Unused).map(|c| c.name.as_str()).collect();
        if open.is_empty() {
            return Err((None, Problem::MissingColumn(word)));
        }
        columns.questions.push(Question {
            what: format!("no column for the {word}: is it one of `{}`?", open.join("`, `")),
            answer: format!("--column '{word}={}:{example}'", open[0]),
        });
        return Ok(());
    };
    let (sure, others): (Vec<Candidate>, Vec<Candidate>) =
        candidates.into_iter().partition(|c| c.rank == best);
    let name = |c: &Candidate| layout.names[c.index].clone();
    if sure.len() > 1 {
        if best == Rank::Own || sure.iter().any(|c| name(c) == name(&sure[0]) && c.index != sure[0].index) {
            return Err((Some(name(&sure[1])), Problem::DuplicateColumn(name(&sure[0]))));
        }
        let all: Vec<String> = sure.iter().map(name).collect();
        columns.questions.push(Question {
            what: format!("which column is the {word}: `{}`?", all.join("`, or `")),
            answer: match sure[0].unit.is_some() || layout.units.is_some() {
                true => format!("--column '{word}={}'", all[0]),
                false => format!("--column '{word}={}:{example}'", all[0]),
            },
        });
        return Ok(());
    }
    let candidate = &sure[0];
    if columns.all[candidate.index].quantity == quantity && candidate.unit.is_none() {
        return Ok(());
    }
    let told = layout.units.as_ref().and_then(|units| units.get(candidate.index)).filter(|u| !u.is_empty());
    let text = candidate.unit.clone().or_else(|| told.cloned());
    let column = &mut columns.all[candidate.index];
    let clock = text.as_deref().and_then(clock_form);
    if let Some(short) = clock.filter(|_| quantity == Quantity::Time) {
        (column.quantity, column.clock) = (quantity, Some(short));
        column.note =
            Some(format!("column `{}` read as time in {}", column.name, if short { "m:s" } else { "h:m:s" }));
        return Ok(());
    }
    let dimension = dimension(quantity).unwrap_or(crate::units::Dimension::Number);
    match text.as_deref().map(|t| (t, unit(t, dimension))) {
        Some((_, Some(unit))) => {
            (column.quantity, column.factor, column.own) = (quantity, unit.factor, false);
            column.note = Some(format!("column `{}` read as {word} in {}", column.name, unit.symbol));
            let more: Vec<String> = others.iter().map(|c| format!("`{}`", layout.names[c.index])).collect();
            if !more.is_empty() {
                column.note = column.note.take().map(|n| format!("{n}, not {}", more.join(" or ")));
            }
        }
        other => columns.questions.push(Question {
            what: match other {
                Some((text, _)) => format!(
                    "`{text}` of column `{}` is not a unit of {word} (known: {})",
                    column.name,
                    known_units(dimension)
                ),
                None => format!("column `{}` has no unit", column.name),
            },
            answer: format!("--column '{word}={}:{example}'", column.name),
        }),
    }
    Ok(())
}

/// Whether a unit of time is `m:s` (true) or `h:m:s` (false).
fn clock_form(text: &str) -> Option<bool> {
    match text.trim_matches(['(', ')', '[', ']']).to_lowercase().as_str() {
        "h:m:s" | "hh:mm:ss" | "hh:mm:ss.s" | "h:mm:ss" => Some(false),
        "m:s" | "mm:ss" | "mm:ss.s" => Some(true),
        _ => None,
    }
}

/// The question of the decimal mark, where it is open.
pub fn decimal_question(decimal: Option<DecimalMark>) -> Option<Question> {
    decimal.is_none().then(|| Question {
        what: "is the comma in numbers such as `1,234` a decimal mark, or does it part the thousands?"
            .to_owned(),
        answer: "--decimal comma".to_owned(),
    })
}
