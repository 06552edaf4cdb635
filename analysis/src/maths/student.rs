//! Student's t distribution, whose degrees of freedom need not be whole.

use super::distributions::bisect;
use statrs::function::beta::beta_reg;

/// Upper tail of Student's t distribution with `df` > 0 degrees of freedom, for `t` ≥ 0.
///
/// # Formula
/// ```text
/// P(T ≥ t) = ½ I_x(df/2, ½), x = df/(df + t²), the regularised incomplete beta function
/// ```
pub fn t_tail(t: f64, df: f64) -> f64 {
    0.5 * beta_reg(0.5 * df, 0.5, df / (df + t * t))
}

/// Quantile of Student's t distribution for two-sided 95 % intervals: the t with P(T ≥ t) = 0.025.
pub fn t_975(df: f64) -> f64 {
    // With half a degree of freedom it is near 200; with fewer nothing should rest on it.
    bisect(0.0, 1e6, |t| t_tail(t, df) <= 0.025)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maths::distributions::Z_975;

    #[test]
    fn quantiles_are_those_of_r() {
        // R 4.2.2: qt(.975, c(1, 3, 4, 18, 2.5)).
        for (df, t) in [
            (1.0, 12.70620473617469),
            (3.0, 3.18244630528371),
            (4.0, 2.77644510519779),
            (18.0, 2.10092204024104),
            (2.5, 3.57465484200369),
        ] {
            assert!((t_975(df) / t - 1.0).abs() < 1e-10, "df = {df}: {}", t_975(df));
        }
        assert!((t_975(1e9) - Z_975).abs() < 1e-6);
    }
}
