//! Groups of stimuli whose scores do not differ: the multiple-comparison test of score differences
//! (David 1988, §3.3; Starks and David 1961), as the field's rendering studies use it.

use crate::maths::studentized_range::{upper_quantile, upper_tail};
use serde::Serialize;

/// Groups of stimuli that the scores do not tell apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Grouping {
    /// Level of significance of the largest of all score differences.
    pub alpha: f64,
    /// Upper quantile W_{t,α} of the studentized range with infinite degrees of freedom.
    pub w: f64,
    /// Critical difference R_c: two stimuli differ when their votes differ by this or more.
    pub r_c: u64,
    /// Maximal runs of the ordered stimuli that do not differ, best first; they may overlap.
    pub groups: Vec<Vec<String>>,
}

/// Groups `items`, best first, by their `votes`; each pair was judged once by each observer.
pub fn score_groups(items: &[String], votes: &[u64], observers: u64, alpha: f64) -> Grouping {
    let r_c = critical_difference(observers, items.len(), alpha);
    let groups = runs(votes, r_c).into_iter().map(|run| items[run].to_vec()).collect();
    Grouping { alpha, w: upper_quantile(alpha, items.len()), r_c, groups }
}

/// The critical score difference R_c.
///
/// # Formula
/// ```text
/// R_c = the smallest integer R with P(W_t ≥ (2R − ½)/√(m t)) ≤ α = ⌈½ W_{t,α} √(m t) + ¼⌉
/// ```
/// where m is the number of observers, t of stimuli, and ½ a continuity correction.
pub fn critical_difference(observers: u64, t: usize, alpha: f64) -> u64 {
    let scale = libm::sqrt(observers as f64 * t as f64);
    let reaches = |r: u64| upper_tail((2.0 * r as f64 - 0.5) / scale, t) <= alpha;
    // The quantile gives R_c to within rounding; the definition decides.
    let guess = libm::ceil(0.5 * upper_quantile(alpha, t) * scale + 0.25) as u64;
    (guess.saturating_sub(1).max(1)..=guess).find(|r| reaches(*r)).unwrap_or(guess + 1)
}

/// Maximal runs of scores in descending order whose range is below `r_c`.
pub(crate) fn runs(votes: &[u64], r_c: u64) -> Vec<std::ops::Range<usize>> {
    let mut runs: Vec<std::ops::Range<usize>> = Vec::new();
    for start in 0..votes.len() {
        let end = votes.partition_point(|v| v + r_c > votes[start]);
        if runs.last().is_none_or(|run| end > run.end) {
            runs.push(start..end);
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_maximal_and_a_difference_of_r_c_separates() {
        assert_eq!(runs(&[10, 8, 5, 0], 5), [0..2, 1..3, 3..4]);
        assert_eq!(runs(&[10, 8, 6, 1], 5), [0..3, 3..4]);
        assert_eq!(runs(&[9, 9, 4, 4], 5), [0..2, 2..4]);
    }

    #[test]
    fn a_smaller_alpha_asks_for_a_larger_difference() {
        let differences = [0.1, 0.05, 0.01, 0.001].map(|alpha| critical_difference(20, 5, alpha));
        assert!(differences.is_sorted(), "{differences:?}");
    }
}
