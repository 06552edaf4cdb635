//! Agreement among judges: Kendall's u (Kendall and Babington Smith 1940), its χ² tests and its
//! exact distribution.
//!
//! Where pairs were judged by unequal numbers of judges, u is generalised to the share of agreeing
//! pairs of judgements and tested exactly; the χ² tests need equal numbers.

use crate::input::preferences::WinMatrix;
use crate::maths::distributions::{chi_square_tail, fair_binomial};
use crate::maths::p_value::PValue;
use serde::Serialize;

/// The exact test is left out when its convolution would take more multiplications than this
/// (about a second on one core).
const MAX_EXACT_WORK: u64 = 1_500_000_000;

/// The coefficient of agreement and its tests against chance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Σ: pairs of judgements that agree.
    pub sigma: u64,
    /// Coefficient of agreement: 1 when all agree, about 0 by chance.
    pub u: f64,
    /// The smallest u that so many judges can have.
    pub u_min: f64,
    /// χ² without correction.
    pub chi2: Option<f64>,
    /// Degrees of freedom of both χ² values; not a whole number.
    pub df: Option<f64>,
    /// Upper tail of `chi2`, approximate.
    pub p: Option<PValue>,
    /// χ² with Kendall and Babington Smith's continuity correction (1 subtracted from Σ).
    pub chi2_corrected: Option<f64>,
    /// Upper tail of `chi2_corrected`, approximate.
    pub p_corrected: Option<PValue>,
    /// Why there is no χ².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi2_reason: Option<String>,
    /// P(Σ ≥ observed) when every answer is a fair coin, exact.
    pub p_exact: Option<PValue>,
    /// Why there is no exact p.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_exact_reason: Option<String>,
    /// Which tail every p of this object is.
    pub tail: &'static str,
}

/// Agreement of the judges whose choices are pooled in `wins`.
///
/// # Formula
/// ```text
/// Σ = Σ_{i≠j} C(xᵢⱼ, 2),  u = 2Σ / Σ_{i<j} C(mᵢⱼ, 2) − 1,  mᵢⱼ = xᵢⱼ + xⱼᵢ
/// and, when every mᵢⱼ is m ≥ 3:
/// χ² = 4/(m−2) · [Σ − ½ C(t,2) C(m,2) (m−3)/(m−2)],  df = C(t,2) m(m−1)/(m−2)²
/// ```
/// where xᵢⱼ judges chose i over j. With equal m the smallest u is −1/m (odd m) or −1/(m−1).
///
/// # Errors
/// Says why there is no u: no pair was judged twice.
pub fn agreement(wins: &WinMatrix) -> Result<Agreement, String> {
    let pairs: Vec<(u64, u64)> =
        wins.pairs().map(|(i, j)| (wins.get(i, j), wins.get(j, i))).collect();
    let judgements: u64 = pairs.iter().map(|(a, b)| choose_2(a + b)).sum();
    if judgements == 0 {
        return Err("agreement needs at least 2 observers who judged the same pair".into());
    }
    let sigma: u64 = pairs.iter().map(|(a, b)| choose_2(*a) + choose_2(*b)).sum();
    let smallest: u64 = pairs.iter().map(|(a, b)| least_agreement(a + b)).sum();
    let u = |sigma: u64| 2.0 * sigma as f64 / judgements as f64 - 1.0;
    let m = pairs[0].0 + pairs[0].1;
    let complete = pairs.iter().all(|(a, b)| a + b == m);
    let chi2_reason = match (complete, m) {
        (false, _) => {
            Some("χ² needs every pair judged by the same number of observers".to_string())
        }
        (true, 2) => Some("χ² needs at least 3 observers".to_string()),
        _ => None,
    };
    let chi2 = |correction: f64| {
        let (pairs, m) = (pairs.len() as f64, m as f64);
        let by_chance = 0.25 * pairs * m * (m - 1.0) * (m - 3.0) / (m - 2.0);
        let chi2 = 4.0 / (m - 2.0) * (sigma as f64 - correction - by_chance);
        let df = pairs * m * (m - 1.0) / ((m - 2.0) * (m - 2.0));
        (chi2, df, PValue::new(chi_square_tail(chi2, df)))
    };
    let plain = chi2_reason.is_none().then(|| chi2(0.0));
    let corrected = chi2_reason.is_none().then(|| chi2(1.0));
    let judges: Vec<u64> = pairs.iter().map(|(a, b)| a + b).collect();
    let (p_exact, p_exact_reason) = match exact_tail(&judges, sigma - smallest) {
        Ok(p) => (Some(p), None),
        Err(reason) => (None, Some(reason)),
    };
    Ok(Agreement {
        sigma,
        u: u(sigma),
        u_min: u(smallest),
        chi2: plain.map(|(chi2, ..)| chi2),
        df: plain.map(|(_, df, _)| df),
        p: plain.map(|(.., p)| p),
        chi2_corrected: corrected.map(|(chi2, ..)| chi2),
        p_corrected: corrected.map(|(.., p)| p),
        chi2_reason,
        p_exact,
        p_exact_reason,
        tail: "upper",
    })
}

/// P(Σ − Σ_min ≥ `excess`) when pair i is judged by `judges[i]` fair coins.
///
/// The law of one pair's agreement is convolved over the pairs, counted up from the least agreement
/// or down from the most, whichever is nearer. Either way the tail is a sum of positive terms and
/// keeps its digits however small it is.
///
/// # Errors
/// Says how large the work would be when it is too large.
pub fn exact_tail(judges: &[u64], excess: u64) -> Result<PValue, String> {
    if excess == 0 {
        return Ok(PValue::new(1.0));
    }
    let mut laws: Vec<Vec<(u64, f64)>> = judges.iter().map(|m| one_pair(*m)).collect();
    let most = |law: &[(u64, f64)]| law.iter().map(|(gain, _)| *gain).max().unwrap_or(0);
    let below_most = laws.iter().map(|law| most(law)).sum::<u64>().saturating_sub(excess);
    let terms: u64 = judges.iter().map(|m| m / 2 + 1).sum();
    let work = terms.saturating_mul(excess.min(below_most + 1));
    if work > MAX_EXACT_WORK {
        return Err(format!(
            "the exact p would take {work} steps, at most {MAX_EXACT_WORK} are taken"
        ));
    }
    if excess <= below_most {
        let (_, from_excess) = law_of_sum(&laws, excess);
        return Ok(PValue::new(from_excess));
    }
    for law in &mut laws {
        let most = most(law);
        law.iter_mut().for_each(|(gain, _)| *gain = most - *gain);
    }
    let (up_to_excess, _) = law_of_sum(&laws, below_most + 1);
    Ok(PValue::new(up_to_excess.iter().sum()))
}

/// Probabilities of each sum below `limit` of independent variables with these `laws`, and that it is not
/// below.
pub(crate) fn law_of_sum(laws: &[Vec<(u64, f64)>], limit: u64) -> (Vec<f64>, f64) {
    let mut below = vec![1.0];
    let mut from_limit = 0.0;
    for law in laws {
        let most = law.iter().map(|(value, _)| *value).max().unwrap_or(0);
        let mut next = vec![0.0; (below.len() as u64 + most).min(limit) as usize];
        for (sum, weight) in below.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            for (value, p) in law {
                match next.get_mut(sum + *value as usize) {
                    Some(slot) => *slot += weight * p,
                    None => from_limit += weight * p,
                }
            }
        }
        below = next;
    }
    (below, from_limit)
}

/// What one pair judged by `m` fair coins adds to Σ above its minimum, with probabilities.
pub(crate) fn one_pair(m: u64) -> Vec<(u64, f64)> {
    (0..=m / 2)
        .map(|minority| {
            let gain = choose_2(minority) + choose_2(m - minority) - least_agreement(m);
            let ways = if 2 * minority == m { 1.0 } else { 2.0 };
            (gain, ways * fair_binomial(m, minority))
        })
        .collect()
}

/// Agreeing pairs of judgements when `m` judges split as evenly as they can.
fn least_agreement(m: u64) -> u64 {
    choose_2(m / 2) + choose_2(m - m / 2)
}

fn choose_2(n: u64) -> u64 {
    n * n.saturating_sub(1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wins(t: usize, cell: impl Fn(usize, usize) -> u64) -> WinMatrix {
        let mut wins = WinMatrix::new(t);
        for i in 0..t {
            for j in (0..t).filter(|j| *j != i) {
                wins.add(i, j, cell(i, j));
            }
        }
        wins
    }

    #[test]
    fn the_smallest_u_is_kendalls_for_odd_and_even_numbers_of_judges() {
        for (m, expected) in
            [(3, -1.0 / 3.0), (4, -1.0 / 3.0), (18, -1.0 / 17.0), (21, -1.0 / 21.0)]
        {
            let even = wins(5, |i, j| if i < j { m / 2 } else { m - m / 2 });
            let result = agreement(&even).unwrap();
            assert!((result.u_min - expected).abs() < 1e-15, "m = {m}");
            assert_eq!(result.u, result.u_min);
            assert_eq!(result.p_exact.unwrap().value(), 1.0);
        }
    }

    #[test]
    fn all_agree_gives_one() {
        let result = agreement(&wins(4, |i, j| if i < j { 3 } else { 0 })).unwrap();
        assert_eq!(result.u, 1.0);
        // Six pairs, each unanimous among three coins with probability 1/4.
        assert!((result.p_exact.unwrap().value() / 0.25_f64.powi(6) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn two_judges_have_no_chi_square_and_one_has_no_agreement() {
        let two = agreement(&wins(3, |i, j| if i < j { 2 } else { 0 })).unwrap();
        assert_eq!((two.chi2, two.p), (None, None));
        assert_eq!(two.chi2_reason.as_deref(), Some("χ² needs at least 3 observers"));
        assert!((two.p_exact.unwrap().value() - 0.125).abs() < 1e-15);
        let one = agreement(&wins(3, |i, j| u64::from(i < j))).unwrap_err();
        assert!(one.starts_with("agreement needs at least 2 observers"), "{one}");
    }

    #[test]
    fn unequal_numbers_of_judges_are_tested_exactly() {
        // Pairs judged 2, 3 and 0 times: Σ = 1 + 3 of 1 + 3; chance is ½ · ¼.
        let mut uneven = WinMatrix::new(3);
        uneven.add(0, 1, 2);
        uneven.add(2, 0, 3);
        let result = agreement(&uneven).unwrap();
        assert_eq!((result.sigma, result.u, result.chi2), (4, 1.0, None));
        assert!((result.p_exact.unwrap().value() - 0.125).abs() < 1e-15);
        assert!(result.chi2_reason.unwrap().starts_with("χ² needs every pair"));
    }

    #[test]
    fn too_much_work_is_refused_in_words() {
        let error = exact_tail(&[10_000; 100], 1_000_000_000).unwrap_err();
        assert!(error.starts_with("the exact p would take 500100000000000 steps"), "{error}");
        // As many judges who all agree are counted from the other end: one step per pair.
        assert!(exact_tail(&[10_000; 100], 100 * 25_000_000).is_ok());
    }
}
