//! Does a scale describe the choices: deviance, Pearson's χ², and the test that all items are alike.

use super::comparisons::{Comparisons, Pair};
use super::fit::{Estimation, Scale};
use super::solver;
use crate::maths::distributions::chi_square_tail;
use crate::maths::p_value::PValue;
use serde::Serialize;

/// Below this expected count χ² is a rough description (Cochran 1954).
const SMALL: f64 = 5.0;

pub(super) const NOTHING_LEFT: &str =
    "there are no more pairs than scale values, so nothing is left to test the fit with";

const JUDGED_ONCE: &str = "no pair was judged more than once, so χ² does not describe the deviance";
const NOT_LIKELIEST: &str =
    "the values are bias-reduced, not the likeliest, so their deviance gives no likelihood ratio";

/// How well a scale describes the choices.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoodnessOfFit {
    /// Binomial log-likelihood of the counts.
    pub log_likelihood: f64,
    /// Deviance from the observed shares.
    pub deviance: f64,
    /// Pearson's χ².
    pub pearson: f64,
    /// Degrees of freedom of both: pairs compared − (t − 1).
    pub df: usize,
    /// Upper tail of χ² at the deviance, approximate.
    pub p: Option<PValue>,
    /// Upper tail of χ² at Pearson's χ², approximate.
    pub p_pearson: Option<PValue>,
    /// Why there is no p.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_reason: Option<String>,
    /// The smallest count that the scale expects on either side of a pair.
    pub smallest_expected: f64,
    /// How many of the counts that the scale expects are below 5, out of twice the pairs compared.
    pub small_expected: usize,
    /// The test that all items have the same value.
    pub equal_worth: EqualWorth,
}

/// The likelihood-ratio test that all items have the same value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EqualWorth {
    /// Deviance of equal values from the observed shares.
    pub null_deviance: f64,
    /// Null deviance less the deviance of the scale.
    pub chi2: Option<f64>,
    /// Degrees of freedom: t − 1.
    pub df: usize,
    /// Upper tail of χ², approximate.
    pub p: Option<PValue>,
    /// Why there are neither χ² nor p.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_reason: Option<&'static str>,
}

/// Compares a scale with the `comparisons` that it was fitted to; a tie is half a win for each.
///
/// # Formula
/// ```text
/// log-likelihood  ℓ = Σ [ln C(n, y) + y ln F + (n−y) ln(1−F)]
/// deviance          = 2 Σ [y ln(y/nF) + (n−y) ln((n−y)/n(1−F))]
/// Pearson        X² = Σ (y − nF)²/(nF(1−F))
/// ```
/// over the pairs compared, with y wins in n answers and chance F by the model.
pub fn goodness_of_fit(comparisons: &Comparisons, scale: &Scale) -> GoodnessOfFit {
    let pairs = comparisons.pairs();
    let items = comparisons.items().len();
    let deviance = solver::deviance(scale.model, &scale.values, comparisons.answers());
    let null_deviance = solver::deviance(scale.model, &vec![0.0; items], comparisons.answers());
    let (mut log_likelihood, mut pearson) = (0.0, 0.0);
    let (mut smallest_expected, mut small_expected): (f64, _) = (f64::INFINITY, 0);
    for pair in pairs {
        let (trials, wins) = (pair.trials(), pair.wins_and_half_ties());
        let p = scale.model.preference(scale.values[pair.i] - scale.values[pair.j]);
        let expected = [trials * p.chosen, trials * p.rejected];
        log_likelihood += libm::lgamma(trials + 1.0);
        for (wins, expected) in wins.into_iter().zip(expected) {
            let log_chance = if wins > 0.0 { wins * libm::log(expected / trials) } else { 0.0 };
            log_likelihood += log_chance - libm::lgamma(wins + 1.0);
            smallest_expected = smallest_expected.min(expected);
            small_expected += usize::from(expected < SMALL);
        }
        let residual = wins[0] - expected[0];
        pearson += residual * residual / (trials * p.chosen * p.rejected);
    }
    let df = (pairs.len() + 1).saturating_sub(items);
    let judged_once = pairs.iter().map(Pair::trials).fold(0.0, f64::max) <= 1.0;
    let p_reason =
        if df == 0 { Some(NOTHING_LEFT.into()) } else { judged_once.then(|| JUDGED_ONCE.into()) };
    let p = |x| p_reason.is_none().then(|| PValue::new(chi_square_tail(x, df as f64)));
    let reason = match scale.estimation {
        Estimation::BiasReduced => Some(NOT_LIKELIEST),
        Estimation::MaximumLikelihood => judged_once.then_some(JUDGED_ONCE),
    };
    let chi2 = reason.is_none().then_some(null_deviance - deviance);
    let equal_worth = EqualWorth {
        null_deviance,
        chi2,
        df: items - 1,
        p: chi2.map(|chi2| PValue::new(chi_square_tail(chi2, (items - 1) as f64))),
        p_reason: reason,
    };
    GoodnessOfFit {
        log_likelihood,
        deviance,
        pearson,
        df,
        p: p(deviance),
        p_pearson: p(pearson),
        p_reason,
        smallest_expected,
        small_expected,
        equal_worth,
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::fit;
    use super::super::model::Model;
    use super::*;

    fn equal_worth(wins: [[f64; 3]; 3], estimation: Estimation) -> EqualWorth {
        let items = ["a", "b", "c"].map(String::from);
        let wins = Comparisons::of_matrix(&items, &wins.map(|row| row.to_vec())).unwrap();
        let scale = fit(&wins, Model::BradleyTerry, estimation).unwrap();
        goodness_of_fit(&wins, &scale).equal_worth
    }

    #[test]
    fn equality_is_tested_by_the_likeliest_values_alone() {
        let separated = [[0., 10., 10.], [0., 0., 5.], [0., 5., 0.]];
        let test = equal_worth(separated, Estimation::BiasReduced);
        assert_eq!((test.chi2, test.p, test.p_reason), (None, None, Some(NOT_LIKELIEST)));
        let once = [[0., 1., 0.], [0., 0., 1.], [1., 0., 0.]];
        let test = equal_worth(once, Estimation::MaximumLikelihood);
        assert_eq!((test.p, test.p_reason), (None, Some(JUDGED_ONCE)));
    }
}
