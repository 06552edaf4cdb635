//! Cohen's κ, plain and weighted: agreement beyond what the marginal shares give by chance.

use crate::maths::distributions::Z_975;
use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;

/// How much an answer agrees that is not the right one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weights {
    /// Not at all (Cohen 1960).
    None,
    /// Less by the distance of the levels: 1 − |i − j|/(m − 1).
    Linear,
    /// Less by its square: 1 − (i − j)²/(m − 1)².
    Quadratic,
}

/// Cohen's κ.
#[derive(Clone, Debug, PartialEq)]
pub struct Kappa {
    /// How partial agreement counts.
    pub weights: Weights,
    /// 1 for full agreement, 0 for that of chance.
    pub kappa: f64,
    /// Its standard error for large samples.
    pub se: f64,
    /// κ ± 1.96 standard errors, at most 1.
    pub interval_95: Outcome<[f64; 2]>,
}

serialize_outcomes!(Kappa, [weights, kappa, se], [interval_95]);

impl Weights {
    fn of(self, i: usize, j: usize, levels: usize) -> f64 {
        let distance = i.abs_diff(j) as f64 / (levels - 1) as f64;
        match self {
            Self::None => f64::from(i == j),
            Self::Linear => 1.0 - distance,
            Self::Quadratic => 1.0 - distance * distance,
        }
    }
}

/// κ of a square table of counts with at least two levels.
///
/// # Formula
/// ```text
/// κ = (P_o − P_e)/(1 − P_e),  P_o = Σ w_ij p_ij,  P_e = Σ w_ij p_i. p_.j
/// var κ = {Σ p_ij [w_ij − (w̄_i. + w̄_.j)(1 − κ)]² − [κ − P_e(1 − κ)]²} / [n (1 − P_e)²]
/// w̄_i. = Σ_j p_.j w_ij,  w̄_.j = Σ_i p_i. w_ij
/// ```
/// (Cohen 1960, 1968; the variance of Fleiss, Cohen and Everitt 1969).
///
/// # Errors
/// In words: no answers, or all in one row and the same column.
pub fn kappa(counts: &[Vec<u64>], weights: Weights) -> Outcome<Kappa> {
    let m = counts.len();
    let n = counts.iter().flatten().sum::<u64>() as f64;
    if m < 2 || counts.iter().any(|row| row.len() != m) || n == 0.0 {
        return Err("κ needs answers in a square table of at least two levels".into());
    }
    let p = |i: usize, j: usize| counts[i][j] as f64 / n;
    let w = |i: usize, j: usize| weights.of(i, j, m);
    let rows: Vec<f64> = (0..m).map(|i| (0..m).map(|j| p(i, j)).sum()).collect();
    let columns: Vec<f64> = (0..m).map(|j| (0..m).map(|i| p(i, j)).sum()).collect();
    let row_weights: Vec<f64> =
        (0..m).map(|i| (0..m).map(|j| columns[j] * w(i, j)).sum()).collect();
    let column_weights: Vec<f64> =
        (0..m).map(|j| (0..m).map(|i| rows[i] * w(i, j)).sum()).collect();
    let cells = || (0..m).flat_map(move |i| (0..m).map(move |j| (i, j)));
    let observed: f64 = cells().map(|(i, j)| w(i, j) * p(i, j)).sum();
    let expected: f64 = cells().map(|(i, j)| w(i, j) * rows[i] * columns[j]).sum();
    if 1.0 - expected < 1e-12 {
        return Err("all stimuli and all answers are of one level".into());
    }
    let kappa = (observed - expected) / (1.0 - expected);
    let sum: f64 = cells()
        .map(|(i, j)| {
            let deviation = w(i, j) - (row_weights[i] + column_weights[j]) * (1.0 - kappa);
            p(i, j) * deviation * deviation
        })
        .sum();
    let mean = kappa - expected * (1.0 - kappa);
    let variance = (sum - mean * mean).max(0.0) / (n * (1.0 - expected) * (1.0 - expected));
    let se = libm::sqrt(variance);
    let interval_95 = match se > 0.0 {
        true => Ok([(kappa - Z_975 * se).max(-1.0), (kappa + Z_975 * se).min(1.0)]),
        false => Err("its standard error for large samples is 0 in such a table".into()),
    };
    Ok(Kappa { weights, kappa, se, interval_95 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_two_levels_all_weights_are_one() {
        let counts = [vec![20, 5], vec![10, 15]];
        let plain = kappa(&counts, Weights::None).unwrap();
        for weights in [Weights::Linear, Weights::Quadratic] {
            let weighted = kappa(&counts, weights).unwrap();
            assert!((weighted.kappa - plain.kappa).abs() < 1e-14);
            assert!((weighted.se - plain.se).abs() < 1e-14);
        }
    }

    #[test]
    fn full_agreement_is_one_but_its_interval_is_not_known() {
        let all = kappa(&[vec![4, 0, 0], vec![0, 7, 0], vec![0, 0, 2]], Weights::Linear).unwrap();
        assert_eq!(all.kappa, 1.0);
        assert!(all.interval_95.unwrap_err().contains("is 0"));
    }

    #[test]
    fn one_level_only_is_said() {
        assert!(kappa(&[vec![9, 0], vec![0, 0]], Weights::None).unwrap_err().contains("one level"));
        assert!(kappa(&[vec![9]], Weights::None).is_err());
        assert!(kappa(&[vec![0, 0], vec![0, 0]], Weights::None).is_err());
    }
}
