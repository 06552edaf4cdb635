//! The binomial distribution with any chance of success: its tails and the exact test.

use statrs::function::{beta::beta_reg, factorial::ln_binomial};

/// Outcomes whose probabilities differ by no more than this part count as equally likely, as in R's
/// `binom.test`.
const EQUALLY_LIKELY: f64 = 1e-7;

/// Upper tail of the binomial distribution: `k` or more successes in `n` trials of chance `p`.
///
/// # Formula
/// ```text
/// P(X ≥ k) = I_p(k, n − k + 1), the regularised incomplete beta function; 1 for k = 0
/// ```
pub fn upper_tail(k: u64, n: u64, p: f64) -> f64 {
    match (k, p) {
        (0, _) => 1.0,
        (_, p) if k > n || p <= 0.0 => 0.0,
        (_, p) if p >= 1.0 => 1.0,
        _ => beta_reg(k as f64, (n - k + 1) as f64, p),
    }
}

/// Lower tail of the binomial distribution: `k` or fewer successes in `n` trials of chance `p`.
pub fn lower_tail(k: u64, n: u64, p: f64) -> f64 {
    if k >= n { 1.0 } else { upper_tail(n - k, n, 1.0 - p) }
}

/// Two-sided exact test of `k` successes in `n` trials against the chance `p`, 0 < `p` < 1.
///
/// # Formula
/// ```text
/// p = Σ P(X = x) over all x with P(X = x) ≤ P(X = k), X ~ Binomial(n, p)
/// ```
pub fn two_sided(k: u64, n: u64, p: f64) -> f64 {
    let ln_chance =
        |x: u64| ln_binomial(n, x) + x as f64 * libm::log(p) + (n - x) as f64 * libm::log1p(-p);
    let limit = ln_chance(k) + EQUALLY_LIKELY;
    let sum: f64 = (0..=n).map(ln_chance).filter(|ln| *ln <= limit).map(libm::exp).sum();
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maths::distributions::fair_binomial_two_sided;

    #[test]
    fn the_tail_is_the_sum_of_its_outcomes() {
        for (n, p) in [(1_u64, 0.8), (20, 0.8), (33, 0.05)] {
            let mut sum = 0.0;
            for k in (0..=n).rev() {
                sum += libm::exp(
                    ln_binomial(n, k)
                        + k as f64 * libm::log(p)
                        + (n - k) as f64 * libm::log(1.0 - p),
                );
                assert!((upper_tail(k, n, p) - sum).abs() < 1e-12, "{k} of {n}");
                assert!((lower_tail(n - k, n, 1.0 - p) - sum).abs() < 1e-12, "{k} of {n}");
            }
        }
    }

    #[test]
    fn a_fair_coin_is_a_special_case() {
        for k in 0..=17 {
            assert!((two_sided(k, 17, 0.5) - fair_binomial_two_sided(17, k)).abs() < 1e-13);
        }
    }
}
