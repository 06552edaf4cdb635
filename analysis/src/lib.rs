//! What the answers mean: preferences, scales, categories and ratings, with intervals, and a reason in
//! words for what does not follow.
//!
//! [`input::responses::read`] reads what observers answered, [`analyze`] computes what follows from it, and
//! [`report`] writes it for people. Tables of votes and preference matrices are read by
//! [`Preferences::from_votes`] and [`input::matrix::read`]. One statistic per file, each with its formula
//! and source.
//!
//! ```
//! use shutterlab_analysis::{Preferences, paired, report};
//! use shutterlab_data_schema::Votes;
//!
//! let votes = Votes::parse("item,votes\nA5,59\nA4,51\nA3,48\nA2,34\nA1,8\n", "votes.csv")?;
//! let preferences = Preferences::from_votes(&votes, 20, "votes.csv")?;
//! let analysis = paired::analyze(&preferences, 0.01)?;
//! assert_eq!(analysis.grouping.as_ref().unwrap().r_c, 24);
//! assert!(report::text(&analysis.document()).contains("R_c = 24"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod analysis;
pub mod categories;
pub mod error;
pub mod export;
pub mod input;
pub mod maths;
pub mod outcome;
pub mod paired;
pub mod planning;
pub mod psychometric;
pub mod ratings;
pub mod replication;
pub mod report;
pub mod scaling;

pub use analysis::{Analysis, analyze};
pub use error::InputError;
pub use input::preferences::Preferences;
pub use maths::p_value::PValue;
pub use outcome::Outcome;
