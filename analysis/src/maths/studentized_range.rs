//! The studentized range with infinite degrees of freedom: the range W of t independent standard
//! normal variables, its upper tail and its upper quantile W_{t,α}.
//!
//! It is the limit law of the largest difference between the scores of a paired-comparison
//! experiment (David 1988, §3.3); Pearson and Hartley's Table 29 prints it to two decimals.

use crate::maths::distributions::{bisect, normal_density, normal_tail};

/// Step of the trapezoidal rule. Its error for analytic integrands that vanish at both ends falls
/// exponentially with 1/step; at 1/32 it is below the rounding error.
const STEP: f64 = 1.0 / 32.0;
/// Distance from the peaks of the integrand beyond which it is below 10⁻³⁰ of them.
const REACH: f64 = 12.0;

/// Upper tail of the range of `t` ≥ 2 independent standard normal variables.
///
/// # Formula
/// ```text
/// P(W ≥ q) = 1 − t ∫ φ(z) [Φ(z + q) − Φ(z)]^(t−1) dz
///          = t ∫ φ(z) {Q(z)^(t−1) − [Q(z) − Q(z + q)]^(t−1)} dz,  Q = 1 − Φ
/// ```
/// where z is the smallest of the t. The second form has no cancellation, so small tails keep
/// their digits.
pub fn upper_tail(q: f64, t: usize) -> f64 {
    if q <= 0.0 {
        return 1.0;
    }
    let power = t as f64 - 1.0;
    let integrand = |z: f64| {
        let above = normal_tail(z);
        let beyond = normal_tail(z + q);
        // aᵏ − (a − b)ᵏ = −aᵏ·expm1(k·ln(1 − b/a))
        let missed = -libm::expm1(power * libm::log1p(-(beyond / above).min(1.0)));
        normal_density(z) * libm::pow(above, power) * missed
    };
    // The minimum of t variables lies within REACH of 0, or near −q/2 once q is large.
    let low = -(0.5 * q + REACH);
    let steps = ((REACH - low) / STEP).ceil() as usize;
    let sum: f64 = (0..=steps).map(|i| integrand(low + STEP * i as f64)).sum();
    (t as f64 * STEP * sum).min(1.0)
}

/// Upper quantile W_{t,α}: the q with P(W ≥ q) = α, for `t` ≥ 2 and 0 < `alpha` < 1.
pub fn upper_quantile(alpha: f64, t: usize) -> f64 {
    // At the top, each of the C(t,2) differences alone (standard deviation √2) has P < 10⁻³⁰⁰/t².
    bisect(0.0, 54.0, |q| upper_tail(q, t) <= alpha)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_variables_have_a_closed_form() {
        // The difference of two standard normal variables has standard deviation √2.
        for q in [0.01, 0.5, 1.0, 3.0, 7.0, 20.0, 50.0] {
            let closed = 2.0 * normal_tail(q / std::f64::consts::SQRT_2);
            assert!((upper_tail(q, 2) / closed - 1.0).abs() < 1e-11, "q = {q}");
        }
    }

    #[test]
    fn the_tail_is_one_minus_the_textbook_integral() {
        for t in [3, 5, 9, 13, 20] {
            for q in [0.5, 2.0, 3.5, 5.0] {
                // t ∫ φ(z) [Φ(z + q) − Φ(z)]^(t−1) dz by Simpson's rule.
                let (low, step, steps) = (-9.0 - q, 0.01, 1800 + (100.0 * q) as i32);
                let simpson: f64 = (0..=steps)
                    .map(|i| {
                        let z = low + step * f64::from(i);
                        let weight = if i % 2 == 0 { 2.0 } else { 4.0 };
                        let inside = normal_tail(z) - normal_tail(z + q);
                        weight * normal_density(z) * inside.powi(t - 1)
                    })
                    .sum();
                let textbook = 1.0 - f64::from(t) * step / 3.0 * simpson;
                assert!((upper_tail(q, t as usize) - textbook).abs() < 1e-12, "q = {q}, t = {t}");
            }
        }
    }

    #[test]
    fn quantile_and_tail_are_inverse() {
        for t in [2, 3, 5, 9, 25, 225] {
            for alpha in [0.9, 0.05, 0.01, 1e-6] {
                let p = upper_tail(upper_quantile(alpha, t), t);
                assert!((p / alpha - 1.0).abs() < 1e-10, "t = {t}, α = {alpha}: {p}");
            }
        }
    }

    #[test]
    fn a_range_is_never_negative() {
        assert_eq!(upper_tail(0.0, 5), 1.0);
        assert_eq!(upper_tail(-1.0, 5), 1.0);
    }
}
