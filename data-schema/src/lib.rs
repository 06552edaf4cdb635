//! What is written down: the records that Shutterlab reads and writes, the files they live in,
//! and the schemas generated from them.
//!
//! A definition (protocol, cohort, display profile, fitted parameters, grid, scene) is TOML, read by [`definition::read`]. An
//! observation (response, participant, votes) is CSV. Every schema beside this crate (`*.schema.json`) is
//! generated from the types here and tested against drift.

pub mod cohort;
pub mod definition;
pub mod display;
pub mod files;
pub mod fitted;
pub mod item_table;
pub mod participant;
pub mod protocol;
pub mod response;
pub mod study;
pub mod table_schema;
pub mod votes;

pub use cohort::Cohort;
pub use display::DisplayProfile;
pub use fitted::FittedParameters;
pub use participant::{Participant, ParticipantCode};
pub use protocol::Protocol;
pub use response::Response;
pub use votes::Votes;
