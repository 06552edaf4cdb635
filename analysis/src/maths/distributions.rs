//! The distributions that several tests share: normal, χ² and binomial, with upper tails that keep
//! their relative precision when they are tiny.

use super::normal_quantile::normal_quantile;
use statrs::function::{
    beta::beta_reg,
    factorial::ln_binomial,
    gamma::{gamma_lr, gamma_ur},
};

/// Quantile of the standard normal distribution for two-sided 95 % intervals, Φ⁻¹(0.975).
pub const Z_975: f64 = 1.959_963_984_540_054;

/// Density of the standard normal distribution.
///
/// # Formula
/// ```text
/// φ(z) = exp(−z²/2) / √(2π)
/// ```
pub fn normal_density(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / libm::sqrt(2.0 * std::f64::consts::PI)
}

/// Upper tail of the standard normal distribution.
///
/// # Formula
/// ```text
/// Q(z) = 1 − Φ(z) = ½ erfc(z/√2)
/// ```
pub fn normal_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Upper tail of the χ² distribution with `df` degrees of freedom, which need not be whole.
///
/// # Formula
/// ```text
/// P(χ² ≥ x) = Q(df/2, x/2), the regularised upper incomplete gamma function
/// ```
pub fn chi_square_tail(x: f64, df: f64) -> f64 {
    if x <= 0.0 { 1.0 } else { gamma_ur(0.5 * df, 0.5 * x) }
}

/// Lower tail of the χ² distribution with `df` degrees of freedom, which need not be whole.
///
/// # Formula
/// ```text
/// P(χ² ≤ x) = P(df/2, x/2), the regularised lower incomplete gamma function
/// ```
pub fn chi_square_lower_tail(x: f64, df: f64) -> f64 {
    if x <= 0.0 { 0.0 } else { gamma_lr(0.5 * df, 0.5 * x) }
}

/// Probability of `k` successes in `n` fair coin tosses.
///
/// # Formula
/// ```text
/// P(X = k) = C(n, k) / 2ⁿ
/// ```
pub fn fair_binomial(n: u64, k: u64) -> f64 {
    libm::exp(ln_binomial(n, k) - n as f64 * std::f64::consts::LN_2)
}

/// Two-sided exact test of `k` successes in `n` trials against a fair coin.
///
/// # Formula
/// ```text
/// p = min(1, 2·P(X ≥ max(k, n − k))), X ~ Binomial(n, ½)
/// ```
/// The distribution is symmetric, so this is also the sum of all outcomes no likelier than `k`.
pub fn fair_binomial_two_sided(n: u64, k: u64) -> f64 {
    let tail: f64 = (k.max(n - k)..=n).rev().map(|x| fair_binomial(n, x)).sum();
    (2.0 * tail).min(1.0)
}

/// Wilson's 95 % interval for a proportion of `k` in `n` > 0; see [`wilson`].
pub fn wilson_95(k: u64, n: u64) -> [f64; 2] {
    wilson_at(k, n, Z_975)
}

/// Wilson's interval for a proportion of `k` in `n` > 0 at a `level` such as 0.95 (Wilson 1927).
///
/// # Formula
/// ```text
/// (k + z²/2 ± z √(k(n − k)/n + z²/4)) / (n + z²), z = Φ⁻¹((1 + level)/2)
/// ```
pub fn wilson(k: u64, n: u64, level: f64) -> [f64; 2] {
    wilson_at(k, n, normal_quantile(0.5 * (1.0 + level)))
}

fn wilson_at(k: u64, n: u64, z: f64) -> [f64; 2] {
    let (k, n, z2) = (k as f64, n as f64, z * z);
    let centre = (k + 0.5 * z2) / (n + z2);
    let half = z * libm::sqrt(k * (n - k) / n + 0.25 * z2) / (n + z2);
    [(centre - half).max(0.0), (centre + half).min(1.0)]
}

/// Clopper and Pearson's exact 95 % interval for a proportion of `k` in `n` > 0; see
/// [`clopper_pearson`].
pub fn clopper_pearson_95(k: u64, n: u64) -> [f64; 2] {
    clopper_pearson(k, n, 0.95)
}

/// Clopper and Pearson's exact interval for a proportion of `k` in `n` > 0 at a `level` such as 0.95
/// (1934).
///
/// # Formula
/// ```text
/// lower: the p with P(X ≥ k | n, p) = (1 − level)/2, 0 for k = 0
/// upper: the p with P(X ≤ k | n, p) = (1 − level)/2, 1 for k = n
/// P(X ≥ k | n, p) = I_p(k, n − k + 1), the regularised incomplete beta function
/// ```
pub fn clopper_pearson(k: u64, n: u64, level: f64) -> [f64; 2] {
    let lower = |k: u64| match k {
        0 => 0.0,
        _ => bisect(0.0, 1.0, |p| beta_reg(k as f64, (n - k + 1) as f64, p) >= 0.5 * (1.0 - level)),
    };
    [lower(k), 1.0 - lower(n - k)]
}

/// The smallest point between `low` and `high`, to the last bit, at which `reached` turns true;
/// `reached` is false up to it and true from it on.
pub(crate) fn bisect(mut low: f64, mut high: f64, reached: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return high;
        }
        if reached(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_and_clopper_pearson_mirror_with_the_answers() {
        for n in [1, 7, 36, 210] {
            for k in 0..=n {
                for interval in [wilson_95, clopper_pearson_95] {
                    let [low, high] = interval(k, n);
                    let [mirrored_low, mirrored_high] = interval(n - k, n);
                    assert!((low - (1.0 - mirrored_high)).abs() < 1e-13, "{k} of {n}");
                    assert!((high - (1.0 - mirrored_low)).abs() < 1e-13, "{k} of {n}");
                    let share = k as f64 / n as f64;
                    assert!(low <= share + 1e-15 && share <= high + 1e-15, "{k} of {n}");
                }
            }
        }
    }

    #[test]
    fn the_two_sided_binomial_test_is_the_sum_of_outcomes_no_likelier() {
        for n in [1_u64, 2, 9, 20] {
            for k in 0..=n {
                let likelihood = fair_binomial(n, k) * (1.0 + 1e-12);
                let sum: f64 =
                    (0..=n).map(|x| fair_binomial(n, x)).filter(|p| *p <= likelihood).sum();
                assert!((fair_binomial_two_sided(n, k) - sum).abs() < 1e-13, "{k} of {n}");
            }
        }
    }

    #[test]
    fn intervals_at_other_levels_are_those_of_r() {
        // R 4.2.2: binom.test(14, 20, conf.level = .98), prop.test(14, 20, conf.level = .9, correct = F).
        for (interval, expected) in [
            (clopper_pearson(14, 20, 0.98), [0.4171362817100388, 0.9024577903043473]),
            (wilson(14, 20, 0.9), [0.5161962804075577, 0.8361405846480565]),
        ] {
            for side in [0, 1] {
                assert!((interval[side] - expected[side]).abs() < 1e-12, "{interval:?}");
            }
        }
    }

    #[test]
    fn the_chi_square_tail_is_one_up_to_zero() {
        assert_eq!(chi_square_tail(-3.0, 9.5), 1.0);
        assert_eq!(chi_square_tail(0.0, 9.5), 1.0);
    }
}
