//! Psychometric functions: how the chance of an answer rises with the level of a stimulus, and the
//! level at which it reaches a value.

pub mod analysis;
pub mod bootstrap;
pub mod fit;
pub mod function;
pub mod goodness;
mod scoring;
pub mod section;
mod separation;
pub mod table;
pub mod threshold;
