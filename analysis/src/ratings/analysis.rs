//! What follows from ratings alone: the ratings, the histogram for r, and the coarsest levels of detail.

use super::answers::Ratings;
use super::histogram::{Histogram, histogram};
use super::level_of_detail::{CoarsestLevel, coarsest_levels};
use super::rating::{Rating, ratings};
use serde::Serialize;
use shutterlab_data_schema::fitted::VelocityUnit;

/// What ratings say.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RatingAnalysis {
    /// The unit of all speeds.
    pub speed_unit: VelocityUnit,
    /// Whether the answers were simulated, where that is known.
    pub simulated: Option<bool>,
    /// How many answers do not say of which simplified model they are, and are left out.
    pub unnamed: usize,
    /// How many observers there are, if they are told apart.
    pub observers: Option<usize>,
    /// Whether an observer answered to an image more than once.
    pub repeated: bool,
    /// The rating of each image.
    pub ratings: Vec<Rating>,
    /// Images over the threshold by r.
    pub histogram: Histogram,
    /// The coarsest level of detail of each model, r and speed.
    pub coarsest: Vec<CoarsestLevel>,
}

/// Analyses `answers`, with `count` resamples drawn with `seed`.
pub fn analyze(answers: &Ratings, count: usize, seed: u64) -> RatingAnalysis {
    RatingAnalysis {
        speed_unit: answers.speed_unit,
        simulated: answers.simulated,
        unnamed: answers.unnamed,
        observers: answers.observers(),
        repeated: answers.repeated(),
        ratings: ratings(answers),
        histogram: histogram(answers, count, seed),
        coarsest: coarsest_levels(answers),
    }
}
