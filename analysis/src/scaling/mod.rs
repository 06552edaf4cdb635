//! Scaling: places of the items on one scale, from the choices between them.

pub mod bootstrap;
pub mod comparisons;
pub mod connection;
pub mod differences;
pub mod fit;
pub mod goodness_of_fit;
pub mod intervals;
pub mod model;
pub mod section;
mod sentences;
pub mod simulated_fit;
mod solver;
pub mod study;
mod tables;
pub mod ties;
