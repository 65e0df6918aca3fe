//! Progress on the terminal; nothing where there is no terminal.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A bar, or a line of text with the time that has passed.
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar over a known number of runs, with the time left.
    pub fn of_runs(total: u64) -> Self {
        let style = "{bar:30} {pos}/{len} runs, {elapsed} passed, {eta} left";
        Self::new(ProgressBar::new(total), style)
    }

    /// A fit: iterations at most, chi^2 and runs so far.
    pub fn of_fit(evaluations: u64) -> Self {
        Self::new(ProgressBar::new(evaluations), "{spinner} {msg}, {elapsed} passed, at most {eta} left")
    }

    fn new(bar: ProgressBar, style: &str) -> Self {
        // indicatif draws on stderr, and hides itself when that is not a terminal.
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    /// One more run has ended.
    pub fn advance(&self) {
        self.0.inc(1);
    }

    /// So many evaluations are done, and what to say about it.
    pub fn show(&self, evaluations: u64, message: String) {
        self.0.set_position(evaluations);
        self.0.set_message(message);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
