//! What a fit is reported as: one serialisable structure and four views of it.
//!
//! ```text
//! Assembly (solution, curves, counts) -> FitReport -> table (console), JSON, CSV, HTML page
//! ```

mod assembly;
mod csv;
mod figures;
mod first_hold;
mod fit_report;
mod glossary;
mod html;
mod labels;
pub mod plot;
mod posterior;
mod table;
mod verdict;

pub use assembly::Assembly;
pub use csv::{curves_csv, parameters_csv};
pub use fit_report::*;
pub use glossary::glossary;
pub use html::{assumed, document, page, shapes};
pub use posterior::{PosteriorReport, PosteriorRow, posterior_csv};
pub(crate) use table::columns;
pub use table::table;

#[cfg(test)]
mod tests;
