//! The confusion matrix: which level was presented and which was answered, where every level was
//! offered as an answer.

use super::accuracy::Accuracy;
use super::kappa::{Kappa, Weights, kappa};
use crate::maths::distributions::chi_square_tail;
use crate::maths::p_value::PValue;
use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;

/// What a confusion matrix says.
#[derive(Clone, Debug, PartialEq)]
pub struct Confusion {
    /// Answers: presented level (row) × answered level (column).
    pub counts: Vec<Vec<u64>>,
    /// Answers on the diagonal; by chance 1/m of m levels.
    pub accuracy: Accuracy,
    /// Of the presentations of each level, those that were answered right, against 1/m.
    pub recall: Vec<Option<Accuracy>>,
    /// Of the answers of each level, those that were right: a share from 0 to 1; none if it was never
    /// answered.
    pub precision: Vec<Option<f64>>,
    /// What the answer tells of the stimulus, in bits: the plug-in estimate, which is too large by about
    /// (r − 1)(c − 1)/(2n ln 2).
    pub mutual_information_bits: f64,
    /// The same less that excess (Miller 1955), at least 0.
    pub mutual_information_corrected_bits: f64,
    /// κ of the answers with the stimuli.
    pub kappa: Outcome<Kappa>,
    /// κ with linear weights, for levels in their order.
    pub kappa_linear: Outcome<Kappa>,
    /// κ with quadratic weights, for levels in their order.
    pub kappa_quadratic: Outcome<Kappa>,
    /// Whether answers depend on stimuli at all.
    pub association: Outcome<Association>,
}

serialize_outcomes!(
    Confusion,
    [
        counts,
        accuracy,
        recall,
        precision,
        mutual_information_bits,
        mutual_information_corrected_bits
    ],
    [kappa, kappa_linear, kappa_quadratic, association]
);

/// Pearson's χ² test of independence, without correction, over rows and columns that have answers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Association {
    /// χ².
    pub chi2: f64,
    /// Degrees of freedom: (r − 1)(c − 1).
    pub df: u64,
    /// Upper tail of `chi2`, approximate.
    pub p: PValue,
    /// Cramér's V, from 0 to 1.
    pub cramers_v: f64,
    /// Cells that are expected to have less than 5 answers: if many, the approximation is poor.
    pub cells_below_5: u64,
}

/// The confusion matrix `counts`: presented level (row) × answered level (column), square.
///
/// # Formula
/// ```text
/// χ² = Σ (n_ij − n_i. n_.j/n)²/(n_i. n_.j/n),  V = √(χ²/(n (min(r, c) − 1)))
/// I = Σ p_ij log₂(p_ij/(p_i. p_.j))
/// ```
/// (Pearson 1900; Cramér 1946; Shannon 1948; over answers, Miller and Nicely 1955).
///
/// # Errors
/// In words: the table is not square, or has less than two levels or no answers.
pub fn confusion(counts: &[Vec<u64>]) -> Outcome<Confusion> {
    let m = counts.len();
    if m < 2 || counts.iter().any(|row| row.len() != m) {
        return Err("a confusion matrix needs as many columns as rows, at least two".into());
    }
    let n: u64 = counts.iter().flatten().sum();
    let chance = 1.0 / m as f64;
    let rows: Vec<u64> = counts.iter().map(|row| row.iter().sum()).collect();
    let columns: Vec<u64> = (0..m).map(|j| counts.iter().map(|row| row[j]).sum()).collect();
    let expected = |i: usize, j: usize| rows[i] as f64 * columns[j] as f64 / n as f64;
    let cells = || (0..m).flat_map(|i| (0..m).map(move |j| (i, j)));
    let information: f64 = cells()
        .filter(|(i, j)| counts[*i][*j] > 0)
        .map(|(i, j)| {
            let count = counts[i][j] as f64;
            count / n as f64 * libm::log2(count / expected(i, j))
        })
        .sum();
    let used = |sums: &[u64]| sums.iter().filter(|sum| **sum > 0).count() as u64;
    let (r, c) = (used(&rows), used(&columns));
    let excess =
        (r.max(1) - 1) as f64 * (c.max(1) - 1) as f64 / (2.0 * n as f64 * std::f64::consts::LN_2);
    let association = if r < 2 || c < 2 {
        Err("χ² and V need two levels that were presented and two that were answered".into())
    } else {
        let terms =
            || cells().map(|(i, j)| (counts[i][j] as f64, expected(i, j))).filter(|t| t.1 > 0.0);
        let chi2: f64 = terms().map(|(o, e)| (o - e) * (o - e) / e).sum();
        let df = (r - 1) * (c - 1);
        Ok(Association {
            chi2,
            df,
            p: PValue::new(chi_square_tail(chi2, df as f64)),
            cramers_v: libm::sqrt(chi2 / (n as f64 * (r.min(c) - 1) as f64)),
            cells_below_5: terms().filter(|(_, expected)| *expected < 5.0).count() as u64,
        })
    };
    Ok(Confusion {
        counts: counts.to_vec(),
        accuracy: Accuracy::new((0..m).map(|i| counts[i][i]).sum(), n, chance)?,
        recall: (0..m).map(|i| Accuracy::new(counts[i][i], rows[i], chance).ok()).collect(),
        precision: (0..m)
            .map(|i| (columns[i] > 0).then(|| counts[i][i] as f64 / columns[i] as f64))
            .collect(),
        mutual_information_bits: information.max(0.0),
        mutual_information_corrected_bits: (information - excess).max(0.0),
        kappa: kappa(counts, Weights::None),
        kappa_linear: kappa(counts, Weights::Linear),
        kappa_quadratic: kappa(counts, Weights::Quadratic),
        association,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The levels of `counts` in the order `order`.
    fn relabelled(counts: &[Vec<u64>], order: &[usize]) -> Vec<Vec<u64>> {
        order.iter().map(|i| order.iter().map(|j| counts[*i][*j]).collect()).collect()
    }

    #[test]
    fn relabelling_levels_changes_only_what_their_order_means() {
        let counts = [vec![9, 3, 1], vec![2, 8, 4], vec![0, 5, 7]];
        let plain = confusion(&counts).unwrap();
        let other = confusion(&relabelled(&counts, &[2, 0, 1])).unwrap();
        assert_eq!(other.accuracy, plain.accuracy);
        assert_eq!(other.recall, [plain.recall[2], plain.recall[0], plain.recall[1]]);
        let (a, b) = (plain.association.unwrap(), other.association.unwrap());
        assert!((a.chi2 - b.chi2).abs() < 1e-12);
        assert!((plain.kappa.unwrap().se - other.kappa.unwrap().se).abs() < 1e-14);
        // Reversing keeps the distances of the levels.
        let reversed = confusion(&relabelled(&counts, &[2, 1, 0])).unwrap();
        let (a, b) = (plain.kappa_quadratic.unwrap(), reversed.kappa_quadratic.unwrap());
        assert!((a.kappa - b.kappa).abs() < 1e-14 && (a.se - b.se).abs() < 1e-14);
    }

    #[test]
    fn all_answers_alike_leave_words_for_what_is_not_known() {
        let alike = confusion(&[vec![6, 0], vec![4, 0]]).unwrap();
        assert!(alike.association.as_ref().unwrap_err().contains("two that were answered"));
        assert_eq!((alike.mutual_information_bits, alike.precision[1]), (0.0, None));
        assert_eq!(alike.kappa.as_ref().unwrap().kappa, 0.0);
        let json = serde_json::to_value(&alike).unwrap();
        assert!(json["association"].is_null());
        assert!(json["association_reason"].as_str().unwrap().contains("two"));
        assert!(confusion(&[vec![0, 0], vec![0, 0]]).unwrap_err().contains("no answers"));
        assert!(confusion(&[vec![1, 2]]).is_err());
    }
}
