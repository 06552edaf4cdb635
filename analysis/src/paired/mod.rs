//! Paired comparisons: what the choices between two stimuli mean.

pub mod agreement;
mod analysis;
pub mod axes;
pub mod circular_triads;
pub mod clustered;
pub mod consistency;
pub mod equivalence;
mod figures;
pub mod friedman;
mod group_counts;
pub mod level_check;
pub mod levels;
pub mod observer_groups;
pub mod order_effects;
mod overview;
pub mod preference;
pub mod score_equality;
pub mod score_groups;
pub mod sections;
pub mod transitivity;

pub use analysis::{Options, PairedComparison, Source, analyze};
