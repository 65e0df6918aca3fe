//! SVG figures, drawn here so that every page and plot looks the same and needs nothing from outside.
//!
//! ```text
//! Chart (axes, series) -> Scale (data to paper) -> SVG text
//! ```

mod chart;
mod grid;
mod scale;
mod symbols;

pub use chart::{Axis, Chart, Mark, Series, Shapes};
pub use grid::{heat_map, interval_bar};
pub use scale::ScaleKind;
pub(crate) use symbols::exponent;
pub use symbols::pretty;

/// Colours that stay apart in print and for colour-blind readers (Okabe and Ito).
pub mod palette {
    /// First protocol.
    pub const BLUE: &str = "#0072b2";
    /// Second protocol.
    pub const VERMILION: &str = "#d55e00";
    /// Solid part; third protocol.
    pub const GREEN: &str = "#009e73";
    /// Fluid part.
    pub const SKY: &str = "#4aa3d9";
    /// Fourth protocol.
    pub const PURPLE: &str = "#b0568c";
    /// Totals and text.
    pub const INK: &str = "#1f2328";
    /// Secondary text, axes.
    pub const GREY: &str = "#6a737d";
    /// Grid.
    pub const FAINT: &str = "#e6e8eb";

    /// Colour of the `i`-th measurement.
    pub fn measurement(i: usize) -> &'static str {
        [BLUE, VERMILION, GREEN, PURPLE, SKY][i % 5]
    }
}

/// Text that is safe inside SVG and HTML.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
