//! What is said while a command runs: texts, progress and the result, for people or for programs.
//!
//! | | standard output | standard error |
//! |---|---|---|
//! | people (default) | texts of the result | notes, warnings, a progress bar |
//! | `--json` | the result, one JSON | everything else |
//! | `--progress json` | | each line is one JSON: `{"event": ...}` |

use crate::output::OutputError;
use crate::text::wrapped;
use clap::{Args, ValueEnum};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;
use std::sync::OnceLock;

/// How to speak.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Speech {
    /// Print the result as one JSON on standard output, all texts on standard error
    #[arg(long, global = true, display_order = 1000)]
    pub json: bool,
    /// Progress on standard error: a bar where that is a terminal, or one JSON per line, or nothing
    #[arg(long, global = true, value_enum, value_name = "HOW", default_value_t, display_order = 1001)]
    pub progress: ProgressKind,
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum ProgressKind {
    /// A bar on a terminal
    #[default]
    Bar,
    /// JSON lines
    Json,
    /// Nothing
    None,
}

static SPEECH: OnceLock<Speech> = OnceLock::new();

/// Decides once how this program speaks.
pub fn choose(speech: Speech) {
    let _ = SPEECH.set(speech);
}

/// How it speaks.
pub fn speech() -> Speech {
    SPEECH.get().copied().unwrap_or_default()
}

/// A text of the result.
pub fn text(text: &str) {
    if speech().json {
        return aside("text", text);
    }
    // A reader that has gone away (`| head`) is no reason to fail.
    let _ = writeln!(std::io::stdout(), "{}", wrapped(text, 2));
}

/// `note: ...`: what was understood that is not obvious.
pub fn note(text: &str) {
    told("note", text);
}

/// `warning: ...`: what may spoil the result.
pub fn warning(text: &str) {
    told("warning", text);
}

/// `error: ...`: why there is no result.
pub fn error(text: &str) {
    told("error", text);
}

fn told(kind: &str, text: &str) {
    match speech().progress {
        ProgressKind::Json => aside(kind, text),
        _ => aside(kind, &format!("{kind}: {text}")),
    }
}

/// A text that is no result.
pub fn aside(kind: &str, text: &str) {
    if speech().progress == ProgressKind::Json {
        return event(&json!({ "event": kind, "text": text }));
    }
    let _ = writeln!(std::io::stderr(), "{}", wrapped(text, 2));
}

/// What happened, for `--progress json`.
pub fn event(event: &Value) {
    if speech().progress == ProgressKind::Json {
        let _ = writeln!(std::io::stderr(), "{event}");
    }
}

/// The result, where JSON was asked for; as it would be written to `file`.
///
/// # Errors
/// When it could not be read back.
pub fn result<T: Serialize + DeserializeOwned>(value: &T) -> Result<(), OutputError> {
    if speech().json {
        let text = crate::output::json(Path::new("standard output"), value)?;
        let mut out = std::io::stdout();
        let _ = out.write_all(&text).and_then(|()| out.write_all(b"\n"));
    }
    Ok(())
}
