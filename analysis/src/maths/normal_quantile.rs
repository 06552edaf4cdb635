//! Quantiles of the normal distribution.

use statrs::function::erf::erfc_inv;

/// Quantile of the standard normal distribution, Φ⁻¹(p) for 0 < `p` < 1.
///
/// # Formula
/// ```text
/// Φ⁻¹(p) = −√2 · erfc⁻¹(2p)
/// ```
pub fn normal_quantile(p: f64) -> f64 {
    -std::f64::consts::SQRT_2 * erfc_inv(2.0 * p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maths::distributions::normal_tail;

    #[test]
    fn the_normal_quantile_is_the_inverse_of_the_tail() {
        for p in [1e-12, 1e-4, 0.025, 0.3, 0.5, 0.8, 0.999] {
            assert!((normal_tail(-normal_quantile(p)) / p - 1.0).abs() < 1e-12, "p = {p}");
        }
    }
}
