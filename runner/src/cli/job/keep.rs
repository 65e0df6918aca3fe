//! The job file that repeats a command, made from what clap understood of the command line.

use super::super::called;
use super::error::JobError;
use super::place::{Form, GEOMETRY, Place, command_named, places, table_of};
use crate::data::source::{Source, from_directory};
use crate::output::mark;
use clap::parser::ValueSource;
use clap::{ArgMatches, Command};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// An option that was given.
#[derive(Debug, Clone, PartialEq)]
struct Given {
    place: Place,
    values: Vec<String>,
}

/// What a command was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    command: String,
    given: Vec<Given>,
}

impl Kept {
    /// What was given to a command of the program, defaults left out.
    pub fn of(program: &Command, name: &str, matches: &ArgMatches) -> Self {
        let command = command_named(program, name).unwrap_or(program);
        let given = |place: Place| {
            let id = place.id.as_str();
            let is_given = matches.value_source(id) == Some(ValueSource::CommandLine);
            let raw = matches.get_raw(id).filter(|_| is_given)?;
            let values: Vec<String> = raw.map(|v| v.to_string_lossy().into_owned()).collect();
            let defaults = command.get_arguments().find(|a| a.get_id().as_str() == id)?.get_default_values();
            let is_default = values.iter().map(String::as_str).eq(defaults.iter().filter_map(|d| d.to_str()));
            // Of one name the last counts.
            let name = |v: &String| v.split('=').next().map(|n| n.trim().to_owned());
            let is_last = |(k, v): &(usize, &String)| {
                place.form != Form::Table || !values[k + 1..].iter().any(|later| name(later) == name(v))
            };
            let last: Vec<String> =
                values.iter().enumerate().filter(is_last).map(|(_, v)| v.clone()).collect();
            // A flag has a default, too.
            (place.form == Form::Flag || !is_default).then_some(Given { place, values: last })
        };
        Self {
            command: name.to_owned(),
            given: places(program, name).into_iter().filter_map(given).collect(),
        }
    }

    /// The command line that says the same, but for where the results go.
    pub fn command_line(&self) -> String {
        let words = self.given.iter().filter(|g| !g.place.is_output).flat_map(|g| {
            let one = |v: &String| match g.place.form {
                Form::Flag => g.place.prefix.trim_end_matches('=').to_owned(),
                _ if g.place.prefix.is_empty() => shell(&absolute(&g.place, v)),
                _ => format!("{}{}", g.place.prefix, shell(&absolute(&g.place, v))),
            };
            g.values.iter().map(one).collect::<Vec<_>>()
        });
        // Positions first, as people write them.
        let (options, positions): (Vec<String>, Vec<String>) = words.partition(|w| w.starts_with('-'));
        let head = [called().to_owned(), self.command.clone()];
        head.into_iter().chain(positions).chain(options).collect::<Vec<_>>().join(" ")
    }

    /// The job file, for `file`: paths are absolute, the place of the results is the file's own.
    ///
    /// # Errors
    /// When a measurement cannot be read.
    pub fn text(&self, file: &Path) -> Result<String, JobError> {
        let mut root = Table::new();
        for Given { place, values } in &self.given {
            if place.is_output {
                continue;
            }
            if place.form == Form::Table {
                values.iter().for_each(|v| insert_named(&mut root, place, v));
                continue;
            }
            let value = match place.form {
                Form::Flag => Value::Boolean(true),
                Form::List => Value::Array(values.iter().map(|v| item(place, v)).collect::<Result<_, _>>()?),
                _ => typed(&absolute(place, &values[0]), place.is_path),
            };
            insert(&mut root, &place.path, value);
        }
        if let Some(out) = self.place_of_results(file) {
            insert(&mut root, &[table_of(&self.command), vec!["out".to_owned()]].concat(), out.into());
        }
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let repeat = format!("# repeat: {} {} --job {}\n", called(), self.command, shell(&name));
        let head = format!("# {}\n{repeat}", mark::words());
        Ok(format!("{head}{}", toml::to_string(&root).unwrap_or_default()))
    }

    /// Where results are, as a job file tells it: beside it, called as it is, or where they were asked for.
    fn place_of_results(&self, file: &Path) -> Option<String> {
        match self.command.as_str() {
            "simulate" => file.file_stem().map(|s| s.to_string_lossy().into_owned()),
            "challenge answer" => None,
            "challenge make" => {
                let given = self.given.iter().find(|g| g.place.is_output)?;
                Some(absolute(&given.place, &given.values[0]))
            }
            _ => Some(".".to_owned()),
        }
    }

    /// The first field in which another one differs.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let field = |g: &Given| g.place.path.join(".");
        let find = |k: &Self, id: &str| k.given.iter().find(|g| g.place.id == id).cloned();
        let absolute_values = |g: Option<Given>| {
            g.map(|g| g.values.iter().map(|v| absolute(&g.place, v)).collect::<Vec<String>>())
        };
        let differs = |g: &&Given| {
            !g.place.is_output
                && absolute_values(find(self, &g.place.id)) != absolute_values(find(other, &g.place.id))
        };
        self.given.iter().chain(&other.given).find(differs).map(field)
    }
}

/// A path that holds from anywhere; anything else as it is.
fn absolute(place: &Place, value: &str) -> String {
    if !place.is_path {
        return value.to_owned();
    }
    let here = std::env::current_dir().unwrap_or_default().join(super::FILE);
    from_directory(value, &here)
}

fn item(place: &Place, value: &str) -> Result<Value, JobError> {
    if !place.is_path {
        return Ok(typed(value, false));
    }
    let Source { file, hash } = Source::of(&PathBuf::from(value))?;
    let fields = [("file", file.to_string_lossy().into_owned()), ("blake3", hash)];
    Ok(Value::Table(fields.into_iter().map(|(k, v)| (k.to_owned(), v.into())).collect()))
}

/// A number where the text is one, and would be written so again.
fn typed(text: &str, is_path: bool) -> Value {
    let integer = text.parse::<i64>().ok().filter(|n| n.to_string() == text);
    let float = || text.parse::<f64>().ok().filter(|x| x.is_finite() && format!("{x}") == text);
    match integer {
        _ if is_path => text.into(),
        Some(integer) => integer.into(),
        None => float().map_or_else(|| text.into(), Value::Float),
    }
}

fn insert(root: &mut Table, path: &[String], value: Value) {
    let Some((last, tables)) = path.split_last() else { return };
    let mut table = root;
    for key in tables {
        let inner = table.entry(key.clone()).or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(inner) = inner else { return };
        table = inner;
    }
    // A later one wins, and is last.
    table.remove(last);
    table.insert(last.clone(), value);
}

fn insert_named(root: &mut Table, place: &Place, assignment: &str) {
    let (name, value) = match assignment.split_once('=') {
        Some((name, value)) => (name.trim(), typed(value.trim(), false)),
        None => (assignment.trim(), Value::Boolean(true)),
    };
    match name.split_once('.').filter(|(head, _)| *head == GEOMETRY && place.id == "set") {
        Some((head, leaf)) => insert(root, &[head.to_owned(), leaf.to_owned()], value),
        None => insert(root, &[place.path.as_slice(), &[name.to_owned()]].concat(), value),
    }
}

/// A word as a shell takes it.
fn shell(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_./=:,+-^%@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}
