//! Reading what is analysed: answers to single trials, preference matrices and tables.

mod choices;
pub(crate) mod columns;
pub mod data_quality;
pub mod matrix;
mod participants;
pub mod preferences;
pub mod pwcmp;
pub mod responses;
