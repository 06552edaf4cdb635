//! Categories: which of two candidates matches the reference, and whether two stimuli look the same.

pub mod accuracy;
pub mod confusion;
pub mod discrimination;
pub mod forced_choice;
pub mod kappa;
mod likelihood_interval;
pub mod matching;
pub mod merged;
pub mod observers;
pub mod quality;
pub mod resampled;
pub mod response_times;
pub mod same_different;
pub mod section;
pub mod trials;

pub use matching::{Matching, analyze_matching};
pub use same_different::{SameDifferent, analyze_same_different};
