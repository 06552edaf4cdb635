//! Power of the exact binomial test of a share against a half.

use crate::maths::binomial::{lower_tail, upper_tail};
use crate::maths::distributions::{bisect, normal_density};
use serde::Serialize;

/// Which departures from a half a test looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sides {
    /// A larger share only: answers better than chance.
    One,
    /// A larger or a smaller one: a preference either way.
    Two,
}

/// The smallest count out of `trials` that is significant at `alpha`; none if not even all are.
///
/// # Formula
/// ```text
/// the smallest k with s·P(X ≥ k) ≤ α, X ~ Binomial(n, ½), s = 1 or 2 sides
/// ```
pub fn critical_count(trials: u64, alpha: f64, sides: Sides) -> Option<u64> {
    let both = if sides == Sides::Two { 2.0 } else { 1.0 };
    let (mut low, mut high) = (trials / 2, trials + 1);
    // The tail falls with the count; no more than half of them is never significant.
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if both * upper_tail(middle, trials, 0.5) <= alpha { high = middle } else { low = middle }
    }
    (high <= trials).then_some(high)
}

/// Probability that a count out of `trials` is `critical` or more (or, with two sides, that of the other
/// answer is), when each has the chance `share`.
pub fn power(critical: Option<u64>, trials: u64, share: f64, sides: Sides) -> f64 {
    let Some(k) = critical else { return 0.0 };
    let other = if sides == Sides::Two { lower_tail(trials - k, trials, share) } else { 0.0 };
    upper_tail(k, trials, share) + other
}

/// Correlation of two answers of one person to the same question, when people differ.
///
/// # Formula
/// ```text
/// ρ = var(P) / (p(1 − p)),  P = 1/(1 + exp(−μ − s·Z)), Z ~ N(0, 1), E(P) = p
/// ```
/// where s is the standard deviation of a person's log-odds and p the share over all people; the
/// expectations by the trapezoidal rule.
pub fn intraclass_correlation(share: f64, sd: f64) -> f64 {
    let moments = |mean: f64| {
        const STEP: f64 = 1.0 / 16.0;
        let mut sums = [0.0; 3];
        for i in -144..=144 {
            let z = STEP * f64::from(i);
            let p = 1.0 / (1.0 + libm::exp(-mean - sd * z));
            let weight = STEP * normal_density(z);
            for (sum, value) in sums.iter_mut().zip([1.0, p, p * p]) {
                *sum += weight * value;
            }
        }
        [sums[1] / sums[0], sums[2] / sums[0]]
    };
    let reach = 40.0 + 10.0 * sd;
    let mean = bisect(-reach, reach, |mean| moments(mean)[0] >= share);
    let [first, second] = moments(mean);
    ((second - first * first) / (first * (1.0 - first))).clamp(0.0, 1.0)
}

/// How much larger the variance of a share is for `answers` of each person than for as many people (Kish
/// 1965).
///
/// # Formula
/// ```text
/// 1 + (k − 1)·ρ
/// ```
pub fn design_effect(answers: u64, correlation: f64) -> f64 {
    1.0 + (answers as f64 - 1.0) * correlation
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_is_at_most_alpha_and_one_less_would_exceed_it() {
        for trials in [1, 4, 7, 20, 21, 504] {
            for (sides, both) in [(Sides::One, 1.0), (Sides::Two, 2.0)] {
                let critical = critical_count(trials, 0.05, sides);
                assert!(power(critical, trials, 0.5, sides) <= 0.05, "{trials}");
                let before = critical.map_or(trials, |k| k - 1);
                assert!(both * upper_tail(before, trials, 0.5) > 0.05, "{trials}");
            }
        }
    }

    #[test]
    fn few_trials_cannot_be_significant() {
        assert_eq!(critical_count(7, 0.01, Sides::Two), None);
        assert_eq!(critical_count(8, 0.01, Sides::Two), Some(8));
        assert_eq!(power(None, 7, 0.99, Sides::Two), 0.0);
        assert_eq!(critical_count(0, 0.05, Sides::One), None);
    }

    #[test]
    fn people_who_are_alike_have_no_correlation_and_those_who_never_waver_have_one() {
        assert!(intraclass_correlation(0.7, 0.0) < 1e-12);
        assert!(intraclass_correlation(0.5, 200.0) > 0.95);
        // A small spread: var(P) ≈ (p(1 − p)s)².
        let small = intraclass_correlation(0.7, 0.01);
        assert!((small / (0.21 * 0.0001) - 1.0).abs() < 1e-3, "{small}");
        // The mirrored share has the same correlation.
        let (one, other) = (intraclass_correlation(0.8, 0.7), intraclass_correlation(0.2, 0.7));
        assert!((one - other).abs() < 1e-12);
    }

    #[test]
    fn one_answer_each_has_no_design_effect() {
        assert_eq!(design_effect(1, 0.3), 1.0);
        assert_eq!(design_effect(8, 0.0), 1.0);
        assert_eq!(design_effect(8, 1.0), 8.0);
    }
}
