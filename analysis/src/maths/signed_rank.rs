//! Wilcoxon's signed-rank test of paired differences, exact with or without ties.

use super::p_value::PValue;
use serde::Serialize;

/// Beyond so many differences the exact distribution would take long; nobody tests so many observers.
const MAX_PAIRS: usize = 1000;

/// Wilcoxon's signed-rank test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SignedRank {
    /// Differences that are not 0.
    pub pairs: u64,
    /// Differences that are 0, which the test leaves out.
    pub zeros: u64,
    /// Sum of the ranks of the positive differences; equal ones share their mean rank.
    pub w: f64,
    /// Two-sided, exact: every sign is + or − with probability ½.
    pub p: PValue,
}

/// Whether `differences` are centred on 0 (Wilcoxon 1945).
///
/// # Formula
/// ```text
/// W = Σ rank(|dᵢ|) over dᵢ > 0,  p = min(1, 2·min(P(W ≤ w), P(W ≥ w)))
/// ```
/// over all 2ⁿ signs of the differences that are not 0.
///
/// # Errors
/// In words: no difference other than 0, too many, or one that is no finite number.
pub fn signed_rank(differences: &[f64]) -> Result<SignedRank, String> {
    if differences.iter().any(|d| !d.is_finite()) {
        return Err("a difference is no finite number".into());
    }
    let mut sorted: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
    if sorted.is_empty() {
        return Err("the signed-rank test needs a difference that is not 0".into());
    }
    if sorted.len() > MAX_PAIRS {
        return Err(format!(
            "the exact signed-rank test takes at most {MAX_PAIRS} differences, here are {}",
            sorted.len()
        ));
    }
    sorted.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    // Twice the ranks, which are whole numbers with ties too.
    let ranks: Vec<usize> = sorted
        .chunk_by(|a, b| a.abs() == b.abs())
        .scan(0, |before, tied| {
            let rank = 2 * *before + tied.len() + 1;
            *before += tied.len();
            Some(vec![rank; tied.len()])
        })
        .flatten()
        .collect();
    let w: usize = ranks.iter().zip(&sorted).filter(|(_, d)| **d > 0.0).map(|(r, _)| r).sum();
    let mut law = vec![1.0];
    for rank in &ranks {
        let mut next = vec![0.0; law.len() + rank];
        for (sum, p) in law.iter().enumerate() {
            next[sum] += 0.5 * p;
            next[sum + rank] += 0.5 * p;
        }
        law = next;
    }
    // The law is symmetric: the smaller tail on either side of w.
    let lower: f64 = law[..=w.min(law.len() - 1 - w)].iter().sum();
    Ok(SignedRank {
        pairs: sorted.len() as u64,
        zeros: (differences.len() - sorted.len()) as u64,
        w: 0.5 * w as f64,
        p: PValue::new((2.0 * lower).min(1.0)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_ties_it_is_that_of_r() {
        // R 4.2.2: wilcox.test(c(1.1, -.4, 2.5, 3.6, -.7, .9, 1.8, -2.2)).
        let test = signed_rank(&[1.1, -0.4, 2.5, 3.6, -0.7, 0.9, 1.8, -2.2]).unwrap();
        assert_eq!((test.w, test.pairs, test.zeros), (27.0, 8, 0));
        assert!((test.p.value() - 0.25).abs() < 1e-12, "{:?}", test.p);
    }

    #[test]
    fn with_ties_it_is_the_share_of_all_signs() {
        let differences = [1.0, 1.0, -1.0, 2.0, 3.0, 3.0, 0.0, -2.0, 5.0];
        let test = signed_rank(&differences).unwrap();
        let ranks = [2.0, 2.0, 2.0, 4.5, 4.5, 6.5, 6.5, 8.0];
        let sums: Vec<f64> = (0..256_u32)
            .map(|signs| (0..8).filter(|i| signs >> i & 1 == 1).map(|i| ranks[i]).sum())
            .collect();
        let share =
            |tail: &dyn Fn(f64) -> bool| sums.iter().filter(|s| tail(**s)).count() as f64 / 256.0;
        let expected = 2.0 * share(&|s| s <= test.w).min(share(&|s| s >= test.w));
        assert_eq!((test.w, test.zeros), (29.5, 1));
        assert!((test.p.value() - expected).abs() < 1e-12);
    }

    #[test]
    fn turning_the_differences_changes_no_p() {
        let differences = [0.3, -1.2, 2.0, 2.0, 0.7];
        let turned = differences.map(|d: f64| -d);
        assert_eq!(signed_rank(&differences).unwrap().p, signed_rank(&turned).unwrap().p);
    }

    #[test]
    fn what_cannot_be_tested_is_said() {
        assert!(signed_rank(&[]).unwrap_err().contains("not 0"));
        assert!(signed_rank(&[0.0, 0.0]).is_err());
        assert!(signed_rank(&[f64::NAN]).unwrap_err().contains("finite"));
    }
}
