//! Overall test of equality of the scores: could all stimuli be chosen equally often?

use crate::maths::distributions::chi_square_tail;
use crate::maths::p_value::PValue;
use serde::Serialize;

/// The overall test of equality of the scores (David 1988, §3.2).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScoreEquality {
    /// The statistic D.
    pub d: f64,
    /// Degrees of freedom: t − 1.
    pub df: u64,
    /// Upper tail of χ² at D, approximate, no correction.
    pub p: PValue,
    /// Which tail p is.
    pub tail: &'static str,
}

/// Tests the scores `votes` of t ≥ 2 stimuli, each pair judged once by each of `observers`.
///
/// # Formula
/// ```text
/// D = 4 [Σ aᵢ² − t m² (t−1)²/4] / (m t)  ~  χ²(t − 1)
/// ```
/// where aᵢ is the score of stimulus i and m the number of observers.
pub fn score_equality(votes: &[u64], observers: u64) -> ScoreEquality {
    let (t, m) = (votes.len() as f64, observers as f64);
    // Written with deviations from the mean score, which is the same and does not cancel.
    let mean = 0.5 * m * (t - 1.0);
    let squares: f64 = votes.iter().map(|a| (*a as f64 - mean) * (*a as f64 - mean)).sum();
    let d = 4.0 * squares / (m * t);
    let df = votes.len() as u64 - 1;
    ScoreEquality { d, df, p: PValue::new(chi_square_tail(d, df as f64)), tail: "upper" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_scores_give_zero_and_one() {
        let equal = score_equality(&[20, 20, 20, 20, 20], 10);
        assert_eq!((equal.d, equal.df, equal.p.value()), (0.0, 4, 1.0));
    }

    #[test]
    fn two_stimuli_give_the_plain_chi_square_of_one_preference() {
        // 14 of 20: (2·14 − 20)²/20 = 3.2, p = 0.0736382701203028 (R 4.2.2, chisq.test).
        let two = score_equality(&[14, 6], 20);
        assert!((two.d - 3.2).abs() < 1e-12);
        assert!((two.p.value() - 0.0736382701203028).abs() < 1e-12);
    }
}
