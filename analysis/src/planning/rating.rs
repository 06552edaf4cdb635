//! Ratings: how many observers show that a pair is called the same by at least 80 %.

use super::precision::expected_widths;
use crate::maths::binomial::upper_tail;
use crate::maths::distributions::wilson_95;
use serde::Serialize;

/// The rating at which a simplified stimulus is taken for visually equivalent (Zhang et al. 2014, Appendix A).
pub const EQUIVALENT: f64 = 0.8;

/// The true ratings at which power is told.
pub const TRUTHS: [f64; 2] = [0.9, 0.95];

/// More trials than this are not looked at.
const MAX_TRIALS: u64 = 5000;

/// Ratings of one pair by so many observers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RatingRow {
    /// Number of observers.
    pub observers: u64,
    /// Answers to the pair.
    pub trials: u64,
    /// Expected width of Wilson's 95 % interval at a true rating of 0.8.
    pub wilson_width: f64,
    /// The same of Clopper and Pearson's.
    pub clopper_pearson_width: f64,
    /// Exact probability that the lower end of Wilson's interval is above 0.8, at each of the true ratings
    /// [`TRUTHS`].
    pub clears: [f64; 2],
}

/// Ratings of one pair that each observer judges so many `times`; repetitions are taken as independent.
pub fn rows(observers: &[u64], times: u64) -> Vec<RatingRow> {
    let row = |&observers: &u64| {
        let trials = observers * times;
        let [wilson_width, clopper_pearson_width] = expected_widths(trials, EQUIVALENT);
        let clears = TRUTHS.map(|truth| clears(trials, truth));
        RatingRow { observers, trials, wilson_width, clopper_pearson_width, clears }
    };
    observers.iter().map(row).collect()
}

/// Probability that the lower end of Wilson's 95 % interval is above [`EQUIVALENT`] after so many `trials`,
/// when the true rating is `truth`: exact.
pub fn clears(trials: u64, truth: f64) -> f64 {
    let (mut low, mut high) = (0, trials + 1);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if wilson_95(middle, trials)[0] > EQUIVALENT { high = middle } else { low = middle }
    }
    // With no trials there is no interval.
    if trials == 0 { 0.0 } else { upper_tail(high, trials, truth) }
}

/// The number of trials from which on the interval clears [`EQUIVALENT`] with probability `power` at least,
/// whatever more there are; none up to 5000.
///
/// The probability goes up and down by single counts, so the first number that reaches it is not enough.
pub fn trials_needed(truth: f64, power: f64) -> Option<u64> {
    let last_short = (1..=MAX_TRIALS).rev().find(|trials| clears(*trials, truth) < power);
    match last_short.unwrap_or(0) {
        MAX_TRIALS => None,
        short => Some(short + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_the_number_needed_on_the_power_is_reached() {
        for truth in TRUTHS {
            let needed = trials_needed(truth, 0.8).unwrap();
            assert!(clears(needed - 1, truth) < 0.8 && clears(needed, truth) >= 0.8, "{truth}");
            assert!((needed..needed + 300).all(|trials| clears(trials, truth) >= 0.8), "{truth}");
        }
        assert_eq!(trials_needed(0.8, 0.8), None);
    }

    #[test]
    fn a_rating_at_the_threshold_rarely_clears_it() {
        for trials in [0, 1, 10, 100, 1000] {
            assert!(clears(trials, EQUIVALENT) <= 0.04, "{trials}");
        }
    }
}
