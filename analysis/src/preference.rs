//! Preferences as percentages, per stimulus and per pair, with intervals and tests against ½.

use crate::distributions::{
    chi_square_tail, clopper_pearson_95, fair_binomial_two_sided, wilson_95,
};
use crate::p_value::PValue;
use crate::preferences::WinMatrix;
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
    /// Exact binomial test against ½, two-sided.
    pub p_binomial: PValue,
}

impl Proportion {
    /// The share of `chosen` in `trials` ≥ 1.
    ///
    /// # Formula
    /// ```text
    /// χ² = (2k − n)²/n, df = 1
    /// ```
    /// where k is `chosen` and n is `trials`.
    pub fn new(chosen: u64, trials: u64) -> Self {
        let (k, n) = (chosen as f64, trials as f64);
        let chi2 = (2.0 * k - n) * (2.0 * k - n) / n;
        Self {
            chosen,
            trials,
            percent: 100.0 * k / n,
            wilson_95: wilson_95(chosen, trials),
            clopper_pearson_95: clopper_pearson_95(chosen, trials),
            chi2,
            df: 1,
            p_chi2: PValue::new(chi_square_tail(chi2, 1.0)),
            p_binomial: PValue::new(fair_binomial_two_sided(trials, chosen)),
        }
    }
}

/// How often a stimulus was chosen, over all pairs it was in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ItemPreference {
    /// The stimulus.
    pub item: String,
    /// How often it was chosen.
    #[serde(flatten)]
    pub proportion: Proportion,
}

/// How often the first of two stimuli was chosen over the second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairPreference {
    /// The stimulus with more votes over all pairs (or before the other, if they have as many).
    pub item: String,
    /// The other.
    pub over: String,
    /// How often `item` was chosen over `over`.
    #[serde(flatten)]
    pub proportion: Proportion,
}

/// The preference for each of `items`, which has `votes` in so many `trials`.
pub fn per_item(items: &[String], votes: &[u64], trials: &[u64]) -> Vec<ItemPreference> {
    items
        .iter()
        .zip(votes.iter().zip(trials))
        .map(|(item, (chosen, trials))| ItemPreference {
            item: item.clone(),
            proportion: Proportion::new(*chosen, *trials),
        })
        .collect()
}

/// The preference in each pair of `items` that was judged at all.
pub fn per_pair(items: &[String], wins: &WinMatrix) -> Vec<PairPreference> {
    wins.pairs()
        .filter(|(i, j)| wins.trials(*i, *j) > 0)
        .map(|(i, j)| PairPreference {
            item: items[i].clone(),
            over: items[j].clone(),
            proportion: Proportion::new(wins.get(i, j), wins.trials(i, j)),
        })
        .collect()
}
