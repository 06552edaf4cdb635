//! The F distribution, for tests of several coefficients at once.

use statrs::function::beta::beta_reg;

/// Upper tail of the F distribution with `df` and `df_error` degrees of freedom, above 0 each.
///
/// # Formula
/// ```text
/// P(F ≥ f) = I_x(df_error/2, df/2), x = df_error/(df_error + df f), the regularised incomplete beta
/// ```
pub fn f_tail(f: f64, df: f64, df_error: f64) -> f64 {
    match f <= 0.0 {
        true => 1.0,
        false => beta_reg(0.5 * df_error, 0.5 * df, df_error / (df_error + df * f)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_r() {
        // R 4.2.2: pf(2.5, 3, 12, lower = FALSE) and so on.
        for (f, df, df_error, p) in [
            (2.5, 3.0, 12.0, 0.109154712395006),
            (0.7, 8.0, 2.0, 0.705220187076526),
            (45.0, 5.0, 60.0, 4.67082075283647e-19),
            (0.0, 2.0, 3.0, 1.0),
        ] {
            assert!((f_tail(f, df, df_error) / p - 1.0).abs() < 1e-10, "{f}");
        }
    }
}
