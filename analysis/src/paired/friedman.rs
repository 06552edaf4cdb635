//! Friedman's test and Kendall's coefficient of concordance W on the scores that each judge gave.

use crate::maths::distributions::chi_square_tail;
use crate::maths::p_value::PValue;
use crate::outcome::Outcome;
use serde::Serialize;

/// Do the judges order the stimuli alike (Friedman 1937; Kendall 1970, with ties)?
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Friedman {
    /// Friedman's χ², corrected for ties.
    pub chi2: f64,
    /// Degrees of freedom: t − 1.
    pub df: u64,
    /// Upper tail of `chi2`, approximate.
    pub p: PValue,
    /// Kendall's W, corrected for ties: 0 without, 1 with perfect concordance.
    pub w: f64,
    /// Number of judges.
    pub judges: u64,
}

/// Compares the `scores` that each judge gave to each of t stimuli: how often the judge chose it.
///
/// # Formula
/// ```text
/// χ² = [12 Σⱼ Rⱼ² − 3 m² t (t+1)²] / [m t (t+1) − Σ (u³ − u)/(t−1)],  df = t − 1
/// W = χ² / (m (t−1))
/// ```
/// Rⱼ is the sum over the m judges of the rank of stimulus j among the judge's scores, equal scores
/// sharing their mean rank; u runs over the sizes of all sets of equal scores of one judge.
///
/// # Errors
/// In words: there are fewer than two judges or stimuli, a judge did not score all of them, or every
/// judge gave all stimuli one score.
pub fn friedman(scores: &[Vec<u64>]) -> Outcome<Friedman> {
    let (judges, t) = (scores.len(), scores.first().map_or(0, Vec::len));
    if judges < 2 || t < 2 {
        return Err(format!(
            "concordance needs at least 2 observers and 2 stimuli; there are {judges} and {t}"
        ));
    }
    if scores.iter().any(|judge| judge.len() != t) {
        return Err("concordance needs a score of every stimulus from every observer".into());
    }
    let mut rank_sums = vec![0.0; t];
    let mut ties = 0.0;
    for judge in scores {
        for (sum, score) in rank_sums.iter_mut().zip(judge) {
            let below = judge.iter().filter(|other| *other < score).count() as f64;
            let equal = judge.iter().filter(|other| *other == score).count() as f64;
            *sum += below + 0.5 * (equal + 1.0);
            // Summed over the u members of a set of equal scores this is u³ − u.
            ties += equal * equal - 1.0;
        }
    }
    let (m, t) = (judges as f64, t as f64);
    let spread = m * t * (t + 1.0) - ties / (t - 1.0);
    if spread <= 0.0 {
        return Err("every observer chose all stimuli equally often, so none ranks them".into());
    }
    let mean = 0.5 * m * (t + 1.0);
    let squares: f64 = rank_sums.iter().map(|sum| (sum - mean) * (sum - mean)).sum();
    let chi2 = 12.0 * squares / spread;
    Ok(Friedman {
        chi2,
        df: t as u64 - 1,
        p: PValue::new(chi_square_tail(chi2, t - 1.0)),
        w: chi2 / (m * (t - 1.0)),
        judges: judges as u64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn judges_who_agree_have_concordance_one() {
        let agree = friedman(&[vec![3, 2, 1, 0], vec![3, 2, 1, 0], vec![3, 2, 1, 0]]).unwrap();
        assert!((agree.w - 1.0).abs() < 1e-12);
        assert!((agree.chi2 - 9.0).abs() < 1e-12);
    }

    #[test]
    fn scores_that_rank_nothing_are_refused_in_words() {
        assert!(friedman(&vec![vec![1, 1, 1]; 3]).unwrap_err().starts_with("every observer chose"));
        assert!(friedman(&[vec![2, 1, 0]]).unwrap_err().starts_with("concordance needs at least"));
        assert!(friedman(&[]).unwrap_err().starts_with("concordance needs at least"));
        assert!(friedman(&[vec![0, 1], vec![1]]).unwrap_err().contains("a score of every"));
    }
}
