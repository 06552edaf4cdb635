//! The human rating of an image: the share of "same" among the answers (Zhang et al. 2014, Appendix A).

use super::answers::Ratings;
use super::images::Image;
use crate::PValue;
use crate::maths::binomial::{lower_tail, upper_tail};
use crate::maths::corrections::holm;
use crate::maths::distributions::{clopper_pearson_95, wilson_95};
use serde::Serialize;

/// From this rating on, the paper takes an image for visually equivalent to that of the original.
pub const THRESHOLD: f64 = 0.8;

/// The rating of one image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rating {
    /// What was rated.
    #[serde(flatten)]
    pub image: Image,
    /// u₁: how often the answer was "same".
    pub same: u64,
    /// u₂: how often it was "different".
    pub different: u64,
    /// How often it was "not sure"; these answers are left out.
    pub not_sure: u64,
    /// The rating and its tests.
    #[serde(flatten)]
    pub share: Option<Share>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rating_reason: Option<&'static str>,
}

/// A rating with its intervals and tests against 0.8.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Share {
    /// u₁/(u₁ + u₂), from 0 to 1.
    pub rating: f64,
    /// Wilson's 95 % interval.
    pub wilson_95: [f64; 2],
    /// Clopper and Pearson's exact 95 % interval.
    pub clopper_pearson_95: [f64; 2],
    /// Whether the rating is 0.8 or more: the paper's rule.
    pub reaches: bool,
    /// Whether Wilson's interval lies above 0.8.
    pub wilson_clears: bool,
    /// Whether Clopper and Pearson's interval lies above 0.8.
    pub clopper_pearson_clears: bool,
    /// Exact binomial test against 0.8, upper tail: small where the rating is above it.
    pub p_above: PValue,
    /// `p_above` with Holm's correction for all images of the table that have a rating.
    pub p_above_holm: PValue,
    /// Exact binomial test against 0.8, lower tail: small where the rating is below it.
    pub p_below: PValue,
}

/// Whether u₁/(u₁ + u₂) is 0.8 or more, in whole numbers: 4 of 5 is. Nothing of nothing is not.
pub fn reaches(same: u64, trials: u64) -> bool {
    trials > 0 && 5 * u128::from(same) >= 4 * u128::from(trials)
}

/// The rating of each image.
pub fn ratings(answers: &Ratings) -> Vec<Rating> {
    let counts = answers.counts();
    let mut found: Vec<Rating> = answers
        .images()
        .iter()
        .zip(&counts)
        .map(|(image, counts)| {
            let trials = counts.trials();
            let share = (trials > 0).then(|| Share::of(counts.same, trials));
            Rating {
                image: image.clone(),
                same: counts.same,
                different: counts.different,
                not_sure: counts.not_sure,
                rating_reason: share.is_none().then_some("nobody answered same or different"),
                share,
            }
        })
        .collect();
    Share::correct(found.iter_mut().filter_map(|rating| rating.share.as_mut()));
    found
}

impl Share {
    /// The rating by `same` of `trials` > 0 answers; not yet corrected for the number of tests.
    ///
    /// # Formula
    /// ```text
    /// p_above = P(X ≥ u₁),  p_below = P(X ≤ u₁),  X ~ Binomial(u₁ + u₂, 0.8)
    /// ```
    pub(super) fn of(same: u64, trials: u64) -> Self {
        let (wilson, exact) = (wilson_95(same, trials), clopper_pearson_95(same, trials));
        let p_above = PValue::new(upper_tail(same, trials, THRESHOLD));
        Self {
            rating: same as f64 / trials as f64,
            wilson_95: wilson,
            clopper_pearson_95: exact,
            reaches: reaches(same, trials),
            wilson_clears: wilson[0] > THRESHOLD,
            clopper_pearson_clears: exact[0] > THRESHOLD,
            p_above,
            p_above_holm: p_above,
            p_below: PValue::new(lower_tail(same, trials, THRESHOLD)),
        }
    }

    /// Corrects the p of `shares` for their number.
    pub(super) fn correct<'a>(shares: impl Iterator<Item = &'a mut Self>) {
        let shares: Vec<&mut Self> = shares.collect();
        let p: Vec<f64> = shares.iter().map(|share| share.p_above.value()).collect();
        for (share, p) in shares.into_iter().zip(holm(&p)) {
            share.p_above_holm = PValue::new(p);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::answers::RatingTrial;
    use super::*;
    use shutterlab_data_schema::fitted::VelocityUnit;

    #[test]
    fn four_of_five_reach_the_threshold() {
        assert!(reaches(4, 5) && reaches(16, 20) && reaches(20, 20));
        assert!(!reaches(15, 20) && !reaches(0, 0));
    }

    #[test]
    fn an_image_without_answers_has_a_reason() {
        let trial = |model: &str, same| RatingTrial {
            observer: 1,
            model: model.into(),
            r: 4.0,
            level_of_detail: 0.1,
            speed: 1.0,
            same,
        };
        let trials = [trial("a", None), trial("b", Some(true))];
        let found =
            ratings(&Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap());
        assert_eq!(found[0].share, None);
        assert!((found[1].share.as_ref().unwrap().p_above.value() - 0.8).abs() < 1e-12);
        let json = serde_json::to_value(&found).unwrap();
        assert_eq!(json[0]["rating_reason"], "nobody answered same or different");
        assert_eq!(json[1]["rating"], 1.0);
    }
}
