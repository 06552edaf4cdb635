//! Answers of "not sure" in a model of their own: Davidson's (1970) extension of Bradley and Terry.

use super::comparisons::{Comparisons, Pair};
use super::connection::{check_connected, separation};
use super::fit::{Estimate, Estimation, Scale};
use super::model::Model;
use super::solver::{MOST_STEPS, Pace, TOO_FAR, UNSETTLED, centred, centred_covariance};
use crate::maths::distributions::chi_square_tail;
use crate::maths::p_value::PValue;
use crate::outcome::Outcome;
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::Serialize;

/// Scale values and the readiness to say "not sure".
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Davidson {
    /// Scale values in logits: the log odds that an item is chosen over another rather than rejected.
    pub scale: Scale,
    /// Logarithm of the threshold parameter ν.
    pub ln_nu: Estimate,
    /// The threshold parameter ν: equal items tie with chance ν/(2 + ν).
    pub nu: Estimate,
    /// Deviance from the observed shares of wins, losses and ties.
    pub deviance: f64,
    /// Degrees of freedom: twice the pairs compared − t.
    pub df: usize,
    /// Upper tail of χ² at the deviance, approximate; none without degrees of freedom.
    pub p: Option<PValue>,
}

/// Fits Davidson's model by maximum likelihood.
///
/// # Formula
/// ```text
/// P(i over j) = πᵢ/(πᵢ + πⱼ + ν√(πᵢπⱼ)),  P(tie) = ν√(πᵢπⱼ)/(πᵢ + πⱼ + ν√(πᵢπⱼ)),  s = ln π
/// ```
///
/// # Errors
/// In words: there is no tie; the comparisons are not connected or separated; the ties are where the
/// threshold could grow without end.
pub fn davidson(comparisons: &Comparisons) -> Outcome<Davidson> {
    check_connected(comparisons)?;
    if comparisons.ties() == 0.0 {
        return Err("there is no tie, so there is no threshold to estimate".into());
    }
    separation(comparisons).map_or(Ok(()), Err)?;
    check_threshold(comparisons)?;
    let t = comparisons.items().len();
    // The first item stands at zero; ln ν has its place.
    let mut values = DVector::zeros(t);
    let mut pace = Pace::new(t);
    for _ in 0..MOST_STEPS {
        let (gradient, information) = equations(comparisons, &values);
        let inverse = Cholesky::new(information).ok_or(TOO_FAR)?.inverse();
        let step = &inverse * gradient;
        let moves = |pair: &Pair| (at(&step, pair.i) - at(&step, pair.j)).abs();
        let moves = comparisons.pairs().iter().map(moves).map(|r| r.max(0.5 * r + step[0].abs()));
        let (part, settled) = pace.take(&step, moves.fold(0.0, f64::max));
        values.axpy(part, &step, 1.0);
        if settled {
            return Ok(describe(comparisons, &values, inverse));
        }
    }
    Err(UNSETTLED.into())
}

/// The scale value of item `i`.
fn at(values: &DVector<f64>, i: usize) -> f64 {
    if i == 0 { 0.0 } else { values[i] }
}

/// Chances of a win of i, of a win of j, and of a tie.
fn chances(values: &DVector<f64>, pair: &Pair) -> [f64; 3] {
    let half = 0.5 * (at(values, pair.i) - at(values, pair.j));
    let exponents = [half, -half, values[0]];
    let largest = exponents.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let weights = exponents.map(|exponent| libm::exp(exponent - largest));
    weights.map(|weight| weight / weights.iter().sum::<f64>())
}

/// The gradient of the log-likelihood and its negative second derivative.
fn equations(comparisons: &Comparisons, values: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let t = values.len();
    let (mut gradient, mut information) = (DVector::zeros(t), DMatrix::zeros(t, t));
    for pair in comparisons.pairs() {
        let trials = pair.trials();
        let [i_wins, j_wins, tie] = chances(values, pair);
        let mean = 0.5 * (i_wins - j_wins);
        let residual = 0.5 * (pair.wins[0] - pair.wins[1]) - trials * mean;
        let weight = trials * (0.25 * (i_wins + j_wins) - mean * mean);
        let with_tie = -trials * mean * tie;
        gradient[0] += pair.ties - trials * tie;
        information[(0, 0)] += trials * tie * (1.0 - tie);
        let places = [(pair.i, 1.0), (pair.j, -1.0)];
        for (place, sign) in places.into_iter().filter(|(place, _)| *place > 0) {
            gradient[place] += sign * residual;
            information[(place, 0)] += sign * with_tie;
            for (other, other_sign) in places.into_iter().filter(|(other, _)| *other > 0) {
                information[(place, other)] += sign * other_sign * weight;
            }
        }
    }
    (gradient, information)
}

fn describe(
    comparisons: &Comparisons,
    values: &DVector<f64>,
    mut inverse: DMatrix<f64>,
) -> Davidson {
    let ln_nu = Estimate { value: values[0], se: libm::sqrt(inverse[(0, 0)]) };
    let nu = libm::exp(ln_nu.value);
    inverse.row_mut(0).fill(0.0);
    inverse.column_mut(0).fill(0.0);
    let mut grounded = values.clone();
    grounded[0] = 0.0;
    let (centred_values, covariance) = (centred(&grounded), centred_covariance(&inverse));
    let (items, model) = (comparisons.items(), Model::BradleyTerry);
    let of_pair = |pair: &Pair| {
        let counts = [pair.wins[0], pair.wins[1], pair.ties];
        let expected = chances(values, pair).map(|chance| chance * pair.trials());
        let terms = counts.into_iter().zip(expected).filter(|(count, _)| *count > 0.0);
        terms.map(|(count, expected)| 2.0 * count * libm::log(count / expected)).sum::<f64>()
    };
    let deviance = comparisons.pairs().iter().map(of_pair).sum();
    let df = (2 * comparisons.pairs().len()).saturating_sub(comparisons.items().len());
    Davidson {
        scale: Scale::new(items, model, Estimation::MaximumLikelihood, centred_values, covariance),
        ln_nu,
        nu: Estimate { value: nu, se: nu * ln_nu.se },
        deviance,
        df,
        p: (df > 0).then(|| PValue::new(chi_square_tail(deviance, df as f64))),
    }
}

/// Refuses data to which an endless threshold is likeliest: values in which each winner is at least one
/// unit above the loser and each tie is within one unit. By the theorem of alternatives there are none if
/// and only if a cycle over wins (−1) and ties (+1) has a negative sum (Bellman 1958, Ford 1956).
fn check_threshold(comparisons: &Comparisons) -> Outcome<()> {
    let mut highest = vec![0_i64; comparisons.items().len()];
    for _ in 0..=highest.len() {
        let mut lowered = false;
        for pair in comparisons.pairs() {
            let (i, j) = (pair.i, pair.j);
            let limits = [
                (i, j, pair.wins[0], -1),
                (j, i, pair.wins[1], -1),
                (i, j, pair.ties, 1),
                (j, i, pair.ties, 1),
            ];
            for (from, to, count, step) in limits {
                if count > 0.0 && highest[from] + step < highest[to] {
                    highest[to] = highest[from] + step;
                    lowered = true;
                }
            }
        }
        if !lowered {
            return Err("all choices go one way along an order in which only neighbours tie, so the likelihood grows without end with the threshold".into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact expected counts of Davidson's model.
    fn expected(values: [f64; 3], nu: f64, trials: f64) -> Comparisons {
        let exact = DVector::from_column_slice(&[libm::log(nu), values[1], values[2]]);
        let pairs = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| {
            let chances = chances(&exact, &Pair { i, j, wins: [0.0; 2], ties: 0.0 });
            let [i_wins, j_wins, ties] = chances.map(|chance| trials * chance);
            Pair { i, j, wins: [i_wins, j_wins], ties }
        });
        of_pairs(3, pairs.to_vec())
    }

    fn of_pairs(t: usize, pairs: Vec<Pair>) -> Comparisons {
        let items: Vec<String> = (0..t).map(|i| format!("item {i}")).collect();
        Comparisons::of_pairs(&items, pairs).unwrap()
    }

    #[test]
    fn exact_expected_counts_give_the_parameters_back() {
        let fitted = davidson(&expected([0.0, 1.3, -0.6], 0.4, 30.0)).unwrap();
        assert!((fitted.nu.value - 0.4).abs() < 1e-9);
        assert!((fitted.scale.difference(1, 0).value - 1.3).abs() < 1e-9);
        assert!((fitted.scale.difference(2, 0).value + 0.6).abs() < 1e-9);
        assert!(fitted.deviance.abs() < 1e-9);
        assert_eq!(fitted.df, 3);
        let more = davidson(&expected([0.0, 1.3, -0.6], 0.4, 120.0)).unwrap();
        assert!((more.nu.se / fitted.nu.se - 0.5).abs() < 1e-9);
        let errors = [&more, &fitted].map(|fitted| fitted.scale.difference(1, 2).se);
        assert!((errors[0] / errors[1] - 0.5).abs() < 1e-9);
    }

    #[test]
    fn equal_items_tie_as_often_as_they_did() {
        // Two items alike with 6 wins each and 8 ties: ν/(2 + ν) = 0.4, and ln ν is the logit of 0.4 plus
        // ln 2, whose variance is 1/(20·0.4·0.6).
        let fitted = davidson(&of_pairs(2, vec![Pair { i: 0, j: 1, wins: [6.0; 2], ties: 8.0 }]));
        let fitted = fitted.unwrap();
        assert!((fitted.nu.value - 4.0 / 3.0).abs() < 1e-10);
        assert!((fitted.ln_nu.se - libm::sqrt(1.0 / 4.8)).abs() < 1e-10);
        assert!(fitted.scale.values[0].abs() < 1e-10);
        assert_eq!(fitted.p, None);
    }

    #[test]
    fn what_has_no_finite_threshold_is_said_in_words() {
        let two = |wins, ties| davidson(&of_pairs(2, vec![Pair { i: 0, j: 1, wins, ties }]));
        assert!(two([5.0, 3.0], 0.0).unwrap_err().contains("no tie"));
        assert!(two([5.0, 0.0], 2.0).unwrap_err().contains("only neighbours tie"));
        assert!(two([0.0, 0.0], 2.0).unwrap_err().contains("only neighbours tie"));
        assert!(two([5.0, 1.0], 2.0).is_ok());
        // A beats B, B beats C, and A ties with C: the tie is further than two wins allow.
        let pair = |i, j, wins, ties| Pair { i, j, wins, ties };
        let ring = |ties| {
            vec![
                pair(0, 1, [4.0, 0.0], 0.0),
                pair(1, 2, [4.0, 0.0], 0.0),
                pair(0, 2, [0.0; 2], ties),
            ]
        };
        assert!(davidson(&of_pairs(3, ring(3.0))).is_ok());
    }
}
