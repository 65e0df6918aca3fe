//! Progress: a bar on the terminal, or one JSON per line; nothing where there is no terminal.

use super::terminal::{ProgressKind, event, speech};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::time::Duration;

/// A bar, or a line of text with the time that has passed.
pub struct Progress {
    bar: ProgressBar,
    kind: &'static str,
}

impl Progress {
    /// A bar over a known number of runs, with the time left.
    pub fn of_runs(total: u64) -> Self {
        let style = "{bar:30} {pos}/{len} runs, {elapsed} passed, {eta} left";
        Self::new("run", total, style)
    }

    /// A fit: iterations at most, chi^2 and runs so far.
    pub fn of_fit(evaluations: u64) -> Self {
        Self::new("step", evaluations, "{spinner} {msg}, {elapsed} passed, at most {eta} left")
    }

    fn new(kind: &'static str, total: u64, style: &str) -> Self {
        // indicatif draws on stderr, and hides itself when that is not a terminal.
        let bar = match speech().progress {
            ProgressKind::Bar => ProgressBar::new(total),
            _ => ProgressBar::hidden(),
        };
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        bar.set_length(total);
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, kind }
    }

    /// One more run has ended.
    pub fn advance(&self) {
        self.bar.inc(1);
        let (done, total) = (self.bar.position(), self.bar.length());
        event(&json!({ "event": self.kind, "done": done, "total": total, "seconds": self.seconds() }));
    }

    /// So many evaluations are done, and what to say about it.
    pub fn show(&self, evaluations: u64, message: String) {
        self.bar.set_position(evaluations);
        event(&json!({ "event": self.kind, "text": message, "seconds": self.seconds() }));
        self.bar.set_message(message);
    }

    /// The same with numbers for programs.
    pub fn show_fit(&self, evaluations: u64, message: String, mut numbers: Value) {
        self.bar.set_position(evaluations);
        numbers["event"] = json!("iteration");
        numbers["seconds"] = json!(self.seconds());
        event(&numbers);
        self.bar.set_message(message);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn seconds(&self) -> f64 {
        self.bar.elapsed().as_secs_f64()
    }
}
