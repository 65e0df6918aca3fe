//! A job file: read, checked against the options that there are, and turned into words of the command line.

use super::error::JobError;
use super::place::{COMMANDS, Form, GEOMETRY, Place, all_places, places, table_of};
use crate::data::source::{Source, from_directory};
use clap::Command;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// One option with its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Where it stands.
    pub place: Place,
    /// NAME of a NAME=VALUE.
    pub name: Option<String>,
    /// Words of the command line.
    pub words: Vec<String>,
    /// Line in the file, from 1.
    pub line: usize,
}

/// What a job file says to one command.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// The file.
    pub file: PathBuf,
    /// Its options, in their order.
    pub entries: Vec<Entry>,
    /// Fields that the command does not use.
    pub unused: Vec<String>,
}

impl Job {
    /// Reads the file for a command of the program.
    ///
    /// # Errors
    /// When it cannot be read, is no TOML, or has a field that there is not or that cannot have its value; when a measurement
    /// is not what its hash says.
    pub fn load(file: &Path, program: &Command, command: &str) -> Result<Self, JobError> {
        let unreadable = |source| JobError::Unreadable { file: file.to_owned(), source };
        let bytes = crate::output::read_input(file).map_err(unreadable)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            unreadable(std::io::Error::new(std::io::ErrorKind::InvalidData, "it is not UTF-8"))
        })?;
        let parsed = DeTable::parse(&text).map_err(|error| JobError::Syntax {
            file: file.to_owned(),
            line: line_at(&text, error.span().map_or(0, |s| s.start)),
            problem: error.message().to_owned(),
        })?;
        let own = places(program, command);
        let mut reader =
            Reader { file, text: &text, own, all: all_places(program), entries: vec![], unused: vec![] };
        reader.table(parsed.get_ref(), &mut vec![])?;
        Ok(Self { file: file.to_owned(), entries: reader.entries, unused: reader.unused })
    }

    /// The complaint about a field, told by what a message names.
    pub fn located(&self, message: &str) -> Option<JobError> {
        let names = |e: &&Entry| e.name.as_ref().is_some_and(|name| message.contains(name.as_str()));
        let entry = self.entries.iter().filter(names).max_by_key(|e| e.name.as_ref().map(String::len))?;
        Some(self.complaint(entry, message))
    }

    /// The complaint of the command line about one of the words, as one about the file.
    pub fn explained(&self, error: &clap::Error) -> Option<JobError> {
        use clap::error::{ContextKind, ContextValue};
        let text = |kind| match error.get(kind) {
            Some(ContextValue::String(text)) => Some(text.as_str()),
            _ => None,
        };
        let (option, value) = (text(ContextKind::InvalidArg)?, text(ContextKind::InvalidValue)?);
        let is_it = |e: &&Entry| {
            let long = e.place.prefix.trim_end_matches('=');
            !long.is_empty()
                && option.split([' ', '=']).next() == Some(long)
                && e.words.iter().any(|w| w.ends_with(value))
        };
        let entry = self.entries.iter().find(is_it)?;
        let rendered = error.to_string();
        let lines = rendered.lines().take_while(|l| !l.is_empty()).map(str::trim);
        let told = lines.collect::<Vec<_>>().join(" ");
        Some(self.complaint(entry, told.trim_start_matches("error: ")))
    }

    fn complaint(&self, entry: &Entry, problem: &str) -> JobError {
        let mut field = entry.place.path.join(".");
        if let Some(name) = &entry.name {
            field = format!("{field}.\"{name}\"");
        }
        JobError::Field { file: self.file.clone(), line: entry.line, field, problem: problem.to_owned() }
    }
}

fn line_at(text: &str, byte: usize) -> usize {
    text.bytes().take(byte).filter(|b| *b == b'\n').count() + 1
}

struct Reader<'a> {
    file: &'a Path,
    text: &'a str,
    own: Vec<Place>,
    all: Vec<Place>,
    entries: Vec<Entry>,
    unused: Vec<String>,
}

type Key<'i> = Spanned<DeString<'i>>;

impl Reader<'_> {
    fn table(&mut self, table: &DeTable, path: &mut Vec<String>) -> Result<(), JobError> {
        for (key, value) in table {
            path.push(key.get_ref().to_string());
            self.field(key, value.get_ref(), path)?;
            path.pop();
        }
        Ok(())
    }

    fn field(&mut self, key: &Key, value: &DeValue, path: &mut Vec<String>) -> Result<(), JobError> {
        let is_inside = |p: &Place| p.path.len() > path.len() && p.path.starts_with(path);
        let is_geometry = path.len() > 1 && path[0] == GEOMETRY;
        let full = if is_geometry {
            [&["parameters".to_owned(), "set".to_owned()], path.as_slice()].concat()
        } else {
            path.clone()
        };
        let is_it = |p: &&Place| {
            p.path == full
                || (p.form == Form::Table && full.len() > p.path.len() && full.starts_with(&p.path))
        };
        let Some(place) = self.all.iter().find(is_it).cloned() else {
            return match value {
                DeValue::Table(inner) if self.all.iter().any(is_inside) || path[..] == [GEOMETRY] => {
                    self.table(inner, path)
                }
                _ => Err(self.unknown(key, path)),
            };
        };
        if let (Form::Table, DeValue::Table(inner)) = (place.form, value) {
            return self.table(inner, path);
        }
        let Some(place) = self.own.iter().find(|p| p.path == place.path).cloned() else {
            // Another command's own table is that command's matter.
            let field = if is_geometry { GEOMETRY.to_owned() } else { place.path.join(".") };
            let is_of_a_command = COMMANDS.iter().any(|name| table_of(name)[0] == place.path[0]);
            if !is_of_a_command && !self.unused.contains(&field) {
                self.unused.push(field);
            }
            return Ok(());
        };
        let line = line_at(self.text, key.span().start);
        let name = full.get(place.path.len()..).filter(|rest| !rest.is_empty()).map(|rest| rest.join("."));
        let words = self.words(key, path, value, &place, name.as_deref())?;
        self.entries.push(Entry { place, name, words, line });
        Ok(())
    }

    /// The field as words of the command line.
    fn words(
        &self,
        key: &Key,
        path: &[String],
        value: &DeValue,
        place: &Place,
        name: Option<&str>,
    ) -> Result<Vec<String>, JobError> {
        let bad = |problem: &str| self.complaint(key, path, problem.to_owned());
        if place.form == Form::Flag {
            return match value.as_bool() {
                Some(true) => Ok(vec![place.prefix.trim_end_matches('=').to_owned()]),
                Some(false) => Ok(vec![]),
                None => Err(bad("must be true or false")),
            };
        }
        let scalar = |value: &DeValue| match value {
            DeValue::String(text) => Some(text.to_string()),
            DeValue::Integer(number) if number.radix() == 10 => Some(number.as_str().to_owned()),
            DeValue::Float(number) => Some(number.as_str().to_owned()),
            DeValue::Boolean(is_true) => Some(is_true.to_string()),
            _ => None,
        };
        let placed = |text: String| {
            let text = if place.is_path { from_directory(&text, self.file) } else { text };
            format!("{}{text}", place.prefix)
        };
        match (value, name) {
            (DeValue::Boolean(true), Some(name)) if place.id == "fix" => {
                Ok(vec![format!("{}{name}", place.prefix)])
            }
            (_, Some(name)) => {
                let text = scalar(value).ok_or_else(|| bad("must be a number, a text, true or false"))?;
                Ok(vec![format!("{}{name}={text}", place.prefix)])
            }
            (DeValue::Array(items), None) if place.form != Form::Value => {
                let item = |item: &Spanned<DeValue>| match item.get_ref() {
                    DeValue::Table(file) if place.is_path => {
                        self.hashed(key, path, file).map(|argument| format!("{}{argument}", place.prefix))
                    }
                    other => scalar(other).map(placed).ok_or_else(|| bad("must be a list of texts")),
                };
                items.iter().map(item).collect()
            }
            (_, None) if place.form != Form::Table => {
                let text = scalar(value).ok_or_else(|| {
                    bad(if place.form == Form::List {
                        "must be a list of texts"
                    } else {
                        "must be one value"
                    })
                })?;
                Ok(vec![placed(text)])
            }
            _ => Err(bad("must be a table of names with values, or a list of NAME=VALUE")),
        }
    }

    /// `{ file = "...", blake3 = "..." }`: a measurement that must be what it was.
    fn hashed(&self, key: &Key, path: &[String], table: &DeTable) -> Result<String, JobError> {
        let bad = || {
            let problem = "a measurement is a text or { file = \"...\", blake3 = \"...\" }";
            self.complaint(key, path, problem.to_owned())
        };
        let text = |name: &str| table.get(name).and_then(|v| v.get_ref().as_str()).map(str::to_owned);
        let file = text("file").ok_or_else(bad)?;
        if table.keys().any(|k| !["file", "blake3"].contains(&k.get_ref().as_ref())) {
            return Err(bad());
        }
        let argument = from_directory(&file, self.file);
        if let Some(hash) = text("blake3")
            && Source::of(Path::new(&argument))?.hash != hash
        {
            return Err(JobError::Changed { data: argument.into(), file: self.file.to_owned() });
        }
        Ok(argument)
    }

    fn unknown(&self, key: &Key, path: &[String]) -> JobError {
        let asked = path.join(".");
        let tables = self.all.iter().flat_map(|p| [p.path.join("."), p.path[0].clone()]);
        let known = tables.chain([GEOMETRY.to_owned()]);
        let similar = known
            .map(|k| (strsim::jaro_winkler(&k, &asked), k))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(likeness, _)| *likeness > 0.7);
        let remedy = similar.map_or_else(
            || "remove it; `runner schema job` prints all that there are".to_owned(),
            |(_, k)| format!("did you mean `{k}`?"),
        );
        self.complaint(key, path, format!("there is no such field; {remedy}"))
    }

    fn complaint(&self, key: &Key, path: &[String], problem: String) -> JobError {
        let line = line_at(self.text, key.span().start);
        JobError::Field { file: self.file.to_owned(), line, field: path.join("."), problem }
    }
}
