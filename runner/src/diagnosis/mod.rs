//! Where the best fit still misses the data, which effect explains the miss, and how much of it would go.
//!
//! ```text
//! 1 ../noise/     how uncertain each difference is; ../inference/ the fits
//! 2 parity        relations that need no fit
//! 3 baseline      best fit of the plain model, and its linearisation
//! 4 location      where it misses, against noise after a refit, of which a part has an unsure size
//! 5 screening/    which effects would look like that after a refit
//! 6 confirming    refits with the effects, evidence against each other and against something else
//! 7 held_out      does an effect that is chosen without some data predict them (nested)
//! 8 shrinkage     how much of the gap it removes: how far predictions are from the force that true_force draws
//! 9 experiments   what to measure to tell the remaining candidates apart; leftover: what a gap looks like that nothing explains
//! ```

pub mod catalogue;
pub mod confirming;
pub mod declared;
pub mod diagnose;
pub mod experiments;
mod figures;
mod forms;
pub mod gap;
pub mod held_out;
mod joining;
pub mod leftover;
pub mod location;
mod looks;
mod nested;
mod normal_equations;
pub mod page;
mod pairs;
pub mod parity;
pub mod plain_start;
mod promise;
pub mod published;
pub mod result;
pub mod round;
pub mod screening;
pub mod search;
pub mod shrinkage;
mod simple_rules;
mod size;
pub mod something_else;
pub mod summary;
#[cfg(test)]
mod tests;
pub mod thresholds;
mod true_force;
mod unsure_noise;
pub mod verdict;
#[cfg(test)]
mod verdict_tests;
pub mod wording;
