//! The model against closed forms, ordinary differential equations and an independent solver.

mod balance;
mod closed_forms;
mod consolidation;
mod contact;
mod contact_conditions;
mod contact_sensitivities;
mod cryer;
mod discretisation;
mod effects;
mod efficiency;
mod fluid_balance;
mod independent_curves;
mod inf_sup;
mod layer;
mod manufactured;
mod objectivity;
mod partial_slip;
mod profiles;
mod punch_on_block;
mod relaxation;
mod retraction;
mod sensitivities;
mod small_steps;
mod solid_3d;
mod stepping;
mod two_programs;
