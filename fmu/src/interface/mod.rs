//! What the outside sees: the variable table, the model description, the co-simulation slave, recorded fields.

pub mod cosimulation;
pub mod effect_table;
mod hash;
pub mod model_description;
pub mod recording;
pub mod variables;
