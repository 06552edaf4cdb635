//! What the answers mean: consistency, agreement, groups and preferences from paired comparisons.
//!
//! [`responses::read`], [`matrix::read`] and [`Preferences::from_votes`] read what observers chose;
//! [`analyze`] computes what follows from it; [`report`] writes it for people. One statistic per
//! file, each with its formula and source.
//!
//! ```
//! use shutterlab_analysis::{Preferences, analyze, report};
//! use shutterlab_data_schema::Votes;
//!
//! let votes = Votes::parse("item,votes\nA5,59\nA4,51\nA3,48\nA2,34\nA1,8\n", "votes.csv")?;
//! let preferences = Preferences::from_votes(&votes, 20, "votes.csv")?;
//! let analysis = analyze(&preferences, 0.01)?;
//! assert_eq!(analysis.grouping.as_ref().unwrap().r_c, 24);
//! assert!(report::text(&analysis).contains("R_c = 24"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod agreement;
pub mod analysis;
pub mod circular_triads;
pub mod data_quality;
pub mod distributions;
pub mod error;
pub mod matrix;
pub mod p_value;
pub mod preference;
pub mod preferences;
pub mod published;
pub mod report;
pub mod responses;
pub mod score_equality;
pub mod score_groups;
pub mod studentized_range;

pub use analysis::{Analysis, analyze};
pub use error::InputError;
pub use p_value::PValue;
pub use preferences::Preferences;
