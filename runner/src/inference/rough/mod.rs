//! Fits by a rough model, corrected by runs of the model asked for (space mapping: Bandler et al. 1994).
//!
//! ```text
//! twin (a rougher model, with what the one asked for differed by at a point)
//!   -> correction (fit, correct, go on, until a run of the model asked for gives what the corrected rough one foresees)
//!   -> search (identify: from several starts; the rough one's derivatives are kept)
//!   -> lead (diagnose: the way to where a fit by the model asked for begins)
//! ```

mod correction;
mod lead;
mod search;
mod twin;

pub(in crate::inference) use correction::Goal;
pub use correction::Trust;
pub(in crate::inference) use lead::{Led, lead};
pub use lead::{coarser_at, leading_at};
pub use search::search_roughly;
pub use twin::{Twin, applies};
