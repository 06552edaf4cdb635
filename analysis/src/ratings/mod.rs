//! Ratings of simplified models in motion: do they look the same as the original? From the answers
//! follow the weight's exponent r, the coarsest level of detail that will do, and the law of the level of
//! detail by speed (Zhang et al. 2014, Appendix A).

pub mod analysis;
pub mod answers;
pub mod candidates;
pub mod histogram;
pub mod images;
pub mod joint_law;
pub mod law;
pub mod law_section;
mod law_tables;
mod least_squares;
pub mod level_of_detail;
pub mod over_models;
pub mod points;
pub mod rating;
pub mod reciprocal;
pub mod reciprocal_bootstrap;
pub mod section;
mod section_figures;
mod section_tables;
pub mod table;
