//! Where each option of the command line stands in a job file. The options themselves say it: their name is the key, the heading
//! of `--help` under which they stand is the table, so that a new option has its place without a line here.

use clap::{Arg, ArgAction, ArgMatches, Command, ValueHint};

/// Commands that take a job file; a step of one by both words.
pub const COMMANDS: [&str; 9] = [
    "simulate",
    "inspect",
    "identify",
    "diagnose",
    "validate",
    "batch",
    "um-bridge",
    "challenge make",
    "challenge answer",
];
/// Options that say how to run, not what: they change no result.
const NOT_KEPT: [&str; 8] = ["help", "version", "job", "resume", "json", "progress", "jobs", "verbose"];
/// Options of a form `NAME=VALUE`: tables in a job file.
const TABLES: [(&str, [&str; 2]); 7] = [
    ("set", ["parameters", "set"]),
    ("fix", ["parameters", "fix"]),
    ("bounds", ["parameters", "bounds"]),
    ("start", ["parameters", "start"]),
    ("tie", ["parameters", "tie"]),
    ("column", ["columns", ""]),
    ("weight", ["fit", "weight"]),
];
/// Tables that the headings of `--help` stand for.
const HEADINGS: [(&str, &str); 3] = [("Reading the files", "reading"), ("Fit", "fit"), ("Model", "model")];
/// Short for `[parameters.set]` with names that begin so.
pub const GEOMETRY: &str = "geometry";

/// How an option's values are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// One value.
    Value,
    /// true or false.
    Flag,
    /// A list.
    List,
    /// Names with values.
    Table,
}

/// Place of an option.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Keys from the outermost table inwards.
    pub path: Vec<String>,
    /// How its values are written.
    pub form: Form,
    /// The option's identifier in clap.
    pub id: String,
    /// `--name=`; empty where it is told by its position.
    pub prefix: String,
    /// Its values are paths, to be taken from the job file's directory.
    pub is_path: bool,
    /// It names where results go.
    pub is_output: bool,
    /// What it is, for the schema.
    pub help: String,
    /// The values it may have, where they are few.
    pub values: Vec<String>,
}

/// The command, or step of one, of a name.
pub fn command_named<'a>(program: &'a Command, name: &str) -> Option<&'a Command> {
    name.split(' ').try_fold(program, |command, word| command.find_subcommand(word))
}

/// The command that was given, with its steps, and what was given to it.
pub fn given_command(matches: &ArgMatches) -> Option<(String, &ArgMatches)> {
    let (name, inner) = matches.subcommand()?;
    Some(match given_command(inner) {
        Some((step, innermost)) => (format!("{name} {step}"), innermost),
        None => (name.to_owned(), inner),
    })
}

/// Keys of the table that holds what belongs to a command only.
pub fn table_of(name: &str) -> Vec<String> {
    name.replace('-', "_").split(' ').map(str::to_owned).collect()
}

/// Places of all options of a command.
pub fn places(program: &Command, name: &str) -> Vec<Place> {
    let arguments = command_named(program, name).into_iter().flat_map(Command::get_arguments);
    arguments.filter_map(|arg| place(name, arg)).collect()
}

fn place(command: &str, arg: &Arg) -> Option<Place> {
    let id = arg.get_id().as_str();
    if NOT_KEPT.contains(&id) {
        return None;
    }
    let key = arg.get_long().unwrap_or(id).replace('-', "_");
    let table = TABLES.iter().find(|(name, _)| *name == key && arg.get_long().is_some());
    let heading = || arg.get_help_heading().and_then(|h| HEADINGS.iter().find(|(name, _)| *name == h));
    let own = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<Vec<String>>();
    let path = match table {
        Some((_, path)) => path.iter().filter(|p| !p.is_empty()).map(|p| (*p).to_owned()).collect(),
        None if key == "free" => own(&["parameters", "free"]),
        None if key == "measurements" => own(&["measurements"]),
        None => {
            let table = heading().map_or_else(|| table_of(command), |(_, table)| own(&[*table]));
            [table, own(&[key.as_str()])].concat()
        }
    };
    let is_flag = matches!(arg.get_action(), ArgAction::SetTrue);
    let form = match arg.get_action() {
        _ if table.is_some() => Form::Table,
        ArgAction::SetTrue => Form::Flag,
        ArgAction::Append => Form::List,
        _ => Form::Value,
    };
    let values = if is_flag { vec![] } else { arg.get_possible_values() };
    Some(Place {
        path,
        form,
        id: id.to_owned(),
        prefix: arg.get_long().map_or_else(String::new, |long| format!("--{long}=")),
        is_path: arg.get_value_hint() != ValueHint::Unknown,
        is_output: id == "out",
        help: arg.get_help().map(ToString::to_string).unwrap_or_default(),
        values: values.iter().map(|v| v.get_name().to_owned()).collect(),
    })
}

/// Places in all commands' job files.
pub fn all_places(program: &Command) -> Vec<Place> {
    let mut all: Vec<Place> = Vec::new();
    for name in COMMANDS {
        for place in places(program, name) {
            if !all.iter().any(|p| p.path == place.path) {
                all.push(place);
            }
        }
    }
    all
}
