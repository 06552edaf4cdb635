//! The images that are rated, and the answers to one of them.

use crate::outcome::Outcome;
use serde::Serialize;
use std::cmp::Ordering;

/// What was shown: a model, simplified, at a speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Image {
    /// Name of the model.
    pub model: String,
    /// The weight's exponent that it was simplified with.
    pub r: f64,
    /// Speed of the model, in the unit of the [`Ratings`].
    pub speed: f64,
    /// Part of the original's faces, above 0 up to 1.
    pub level_of_detail: f64,
}

/// Answers to one image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// u₁: "same".
    pub same: u64,
    /// u₂: "different".
    pub different: u64,
    /// "Not sure", which is in neither.
    pub not_sure: u64,
}

impl Counts {
    /// Answers that the rating is made of.
    pub fn trials(self) -> u64 {
        self.same + self.different
    }

    pub(super) fn add(&mut self, other: Self, times: u64) {
        self.same += times * other.same;
        self.different += times * other.different;
        self.not_sure += times * other.not_sure;
    }
}

impl Image {
    /// By model, r, speed and level of detail.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        let numbers = |image: &Self| [image.r, image.speed, image.level_of_detail];
        let by_number = numbers(self).into_iter().zip(numbers(other)).map(|(a, b)| a.total_cmp(&b));
        by_number.fold(self.model.cmp(&other.model), Ordering::then)
    }

    /// Refuses what cannot have been shown, and takes −0 for 0.
    pub(super) fn checked(self) -> Outcome<Self> {
        let Self { r, speed, level_of_detail, .. } = self;
        for (name, value, allowed) in [
            ("r", r, (0.0..f64::INFINITY).contains(&r)),
            ("speed", speed, (0.0..f64::INFINITY).contains(&speed)),
            ("level_of_detail", level_of_detail, level_of_detail > 0.0 && level_of_detail <= 1.0),
        ] {
            if !allowed {
                let needed = match name {
                    "level_of_detail" => "above 0 and at most 1",
                    _ => "a number from 0",
                };
                return Err(format!("{name} of `{}`: {value}: {needed} is needed", self.model));
            }
        }
        Ok(Self { r: r + 0.0, speed: speed + 0.0, ..self })
    }
}
