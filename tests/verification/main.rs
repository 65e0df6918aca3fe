//! The model against closed forms, ordinary differential equations and an independent solver.

mod balance;
mod consolidation;
mod contact;
mod contact_sensitivities;
mod discretisation;
mod effects;
mod efficiency;
mod independent_curves;
mod profiles;
mod punch_on_block;
mod relaxation;
mod sensitivities;
mod solid_3d;
mod stepping;
