//! Were several alternatives chosen equally often?

use super::distributions::chi_square_tail;
use super::p_value::PValue;

/// Pearson's (1900) test of `counts` of m ≥ 2 alternatives, not all zero, against equal chances: χ², its
/// degrees of freedom and its upper tail, approximate.
///
/// # Formula
/// ```text
/// χ² = Σ (xᵢ − n/m)²/(n/m), df = m − 1
/// ```
pub fn equal_chances(counts: &[u64]) -> (f64, u64, PValue) {
    let (n, m) = (counts.iter().sum::<u64>() as f64, counts.len() as f64);
    let expected = n / m;
    let squares: f64 = counts.iter().map(|x| (*x as f64 - expected) * (*x as f64 - expected)).sum();
    let (chi2, df) = (squares / expected, counts.len() as u64 - 1);
    (chi2, df, PValue::new(chi_square_tail(chi2, df as f64)))
}
