//! A share of answers in percent, with intervals and tests against ½.

use super::distributions::{
    chi_square_tail, clopper_pearson_95, fair_binomial_two_sided, wilson_95,
};
use super::p_value::PValue;
use serde::Serialize;

/// A share of answers, with intervals and tests against ½.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Proportion {
    /// How often it was chosen.
    pub chosen: u64,
    /// Out of how many trials.
    pub trials: u64,
    /// The share in percent.
    pub percent: f64,
    /// Wilson's 95 % interval of the share, from 0 to 1.
    pub wilson_95: [f64; 2],
    /// Clopper and Pearson's exact 95 % interval of the share, from 0 to 1.
    pub clopper_pearson_95: [f64; 2],
    /// χ² against ½, without correction.
    pub chi2: f64,
    /// Degrees of freedom of `chi2`: 1.
    pub df: u64,
    /// Upper tail of `chi2`, approximate.
    pub p_chi2: PValue,
    /// χ² against ½ with Yates's continuity correction.
    pub chi2_corrected: f64,
    /// Upper tail of `chi2_corrected`, approximate.
    pub p_chi2_corrected: PValue,
    /// Exact binomial test against ½, two-sided.
    pub p_binomial: PValue,
}

impl Proportion {
    /// The share of `chosen` in `trials` ≥ 1.
    ///
    /// # Formula
    /// ```text
    /// χ² = (2k − n)²/n, with correction (|2k − n| − 1)²/n or 0 if |2k − n| < 1, df = 1
    /// ```
    /// where k is `chosen` and n is `trials`.
    pub fn new(chosen: u64, trials: u64) -> Self {
        let (k, n) = (chosen as f64, trials as f64);
        let chi2 = |correction: f64| {
            let distance = ((2.0 * k - n).abs() - correction).max(0.0);
            distance * distance / n
        };
        let p = |chi2: f64| PValue::new(chi_square_tail(chi2, 1.0));
        Self {
            chosen,
            trials,
            percent: 100.0 * k / n,
            wilson_95: wilson_95(chosen, trials),
            clopper_pearson_95: clopper_pearson_95(chosen, trials),
            chi2: chi2(0.0),
            df: 1,
            p_chi2: p(chi2(0.0)),
            chi2_corrected: chi2(1.0),
            p_chi2_corrected: p(chi2(1.0)),
            p_binomial: PValue::new(fair_binomial_two_sided(trials, chosen)),
        }
    }
}
