//! p-values corrected for the number of tests in a table.

use super::p_value::PValue;
use crate::outcome::Outcome;
use serde::Serialize;

/// A p corrected for the number of tests in its table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Corrected {
    /// By Holm (1979).
    pub p_holm: PValue,
    /// By Benjamini and Hochberg (1995).
    pub p_benjamini_hochberg: PValue,
}

impl Corrected {
    /// Each p of a table, corrected.
    pub fn of(p: impl IntoIterator<Item = PValue>) -> Vec<Self> {
        let p: Vec<f64> = p.into_iter().map(PValue::value).collect();
        let both = holm(&p).into_iter().zip(benjamini_hochberg(&p));
        both.map(|(holm, benjamini_hochberg)| Self {
            p_holm: PValue::new(holm),
            p_benjamini_hochberg: PValue::new(benjamini_hochberg),
        })
        .collect()
    }
}

/// Holm's (1979) step-down correction, which bounds the chance of any false finding in the table, in the
/// order of `p`.
///
/// # Formula
/// ```text
/// p₍ᵢ₎ = max over k ≤ i of min(1, (m − k + 1)·p₍ₖ₎), p₍₁₎ ≤ … ≤ p₍ₘ₎
/// ```
pub fn holm(p: &[f64]) -> Vec<f64> {
    let m = p.len();
    let mut corrected = vec![0.0; m];
    let mut largest: f64 = 0.0;
    for (rank, i) in ascending(p).into_iter().enumerate() {
        largest = largest.max(((m - rank) as f64 * p[i]).min(1.0));
        corrected[i] = largest;
    }
    corrected
}

/// [`holm`] over the p that are known; none for the others.
pub fn holm_of_known(p: &[Outcome<f64>]) -> Vec<Option<PValue>> {
    let known: Vec<f64> = p.iter().filter_map(|p| p.as_ref().ok().copied()).collect();
    let mut corrected = holm(&known).into_iter();
    p.iter().map(|p| p.as_ref().ok().and_then(|_| corrected.next()).map(PValue::new)).collect()
}

/// Benjamini and Hochberg's (1995) correction, which bounds the expected share of false findings among
/// the findings, in the order of `p`.
///
/// # Formula
/// ```text
/// p₍ᵢ₎ = min over k ≥ i of min(1, m/k·p₍ₖ₎), p₍₁₎ ≤ … ≤ p₍ₘ₎
/// ```
pub fn benjamini_hochberg(p: &[f64]) -> Vec<f64> {
    let m = p.len();
    let mut corrected = vec![0.0; m];
    let mut smallest: f64 = 1.0;
    for (rank, i) in ascending(p).into_iter().enumerate().rev() {
        smallest = smallest.min(m as f64 / (rank + 1) as f64 * p[i]);
        corrected[i] = smallest;
    }
    corrected
}

/// The places of `p` from the smallest to the largest.
fn ascending(p: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
        }
    }

    #[test]
    fn both_are_those_of_r() {
        // R 4.2.2: p.adjust(c(.01, .04, .03, .005), "holm") and "BH".
        let p = [0.01, 0.04, 0.03, 0.005];
        close(&holm(&p), &[0.03, 0.06, 0.06, 0.02]);
        close(&benjamini_hochberg(&p), &[0.02, 0.04, 0.04, 0.02]);
        assert!(holm(&[]).is_empty());
    }
}
