//! Answers of one observer are not independent: accuracy per observer, whether observers differ, and
//! intervals that hold when they do.

use super::accuracy::Accuracy;
use crate::maths::bootstrap::by_observer;
use crate::maths::distributions::chi_square_tail;
use crate::maths::p_value::PValue;
use crate::maths::random::stream;
use crate::maths::student::t_975;
use crate::outcome::{Outcome, serialize_outcomes};
use rand::RngExt;
use serde::Serialize;

/// What the random draws of this file follow from.
const SEED: u64 = 0x0b5e_7e75;
/// How often answers are dealt out anew in the test of whether observers differ.
const DEALS: u64 = 9999;

/// The accuracy of several observers together.
#[derive(Clone, Debug, PartialEq)]
pub struct Observers {
    /// Observers who answered.
    pub observers: u64,
    /// Accuracy of all answers pooled; its intervals and test take them for independent.
    pub pooled: Accuracy,
    /// 95 % interval of the share that holds when observers differ, from 0 to 1.
    pub robust_95: Outcome<[f64; 2]>,
    /// How many times larger the variance of the share is than that of independent answers.
    pub design_effect: Outcome<f64>,
    /// 95 % bootstrap interval of the share by observer, from 0 to 1.
    pub bootstrap_95: Outcome<[f64; 2]>,
    /// Whether observers differ.
    pub heterogeneity: Outcome<Heterogeneity>,
}

serialize_outcomes!(
    Observers,
    [observers, pooled],
    [robust_95, design_effect, bootstrap_95, heterogeneity]
);

/// Whether observers differ in accuracy: Pearson's χ² over observers × right or wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Heterogeneity {
    /// χ².
    pub chi2: f64,
    /// Degrees of freedom: observers less 1.
    pub df: u64,
    /// Upper tail of `chi2`, approximate.
    pub p: PValue,
    /// The same by dealing out the right answers anew among all trials, (1 + larger)/(1 + deals):
    /// it needs no large numbers.
    pub p_permutation: PValue,
    /// How often they were dealt.
    pub deals: u64,
}

/// The accuracy of observers who gave `(right, all)` answers each, of which guessing gets the share
/// `chance` right. Observers without answers are left out.
///
/// # Formula
/// ```text
/// P = Σ k_i / Σ n_i,  var P = g/(g − 1) Σ (k_i − n_i P)² / (Σ n_i)²
/// interval: logit P ± t_{g−1; 0.975} √(var P) / (P (1 − P))
/// χ² = Σ (k_i − n_i P)² / (n_i P (1 − P)),  df = g − 1
/// ```
/// for g observers (Liang and Zeger 1986; Cochran 1954).
///
/// # Errors
/// In words: there are no answers, or the numbers cannot be.
pub fn observers(answers: &[(u64, u64)], chance: f64) -> Outcome<Observers> {
    let mut answers: Vec<(u64, u64)> = answers.iter().copied().filter(|(_, n)| *n > 0).collect();
    // Random draws do not depend on the order in which observers are listed.
    answers.sort_unstable();
    let sum = |of: &dyn Fn(&(u64, u64)) -> u64| answers.iter().map(of).sum::<u64>();
    let pooled = Accuracy::new(sum(&|(k, _)| *k), sum(&|(_, n)| *n), chance)?;
    let (groups, share) = (answers.len() as f64, pooled.share());
    let variable = match (answers.len(), pooled.correct) {
        (1, _) => Err("one observer cannot tell how observers differ".to_string()),
        (_, 0) => Err("all answers are wrong".into()),
        (_, k) if k == pooled.trials => Err("all answers are right".into()),
        _ => Ok(share * (1.0 - share)),
    };
    let squares = |weight: &dyn Fn(f64) -> f64| -> f64 {
        let square = |k: f64, n: f64| (k - n * share) * (k - n * share) / weight(n);
        answers.iter().map(|(k, n)| square(*k as f64, *n as f64)).sum()
    };
    let n = pooled.trials as f64;
    let variance = variable.clone().and_then(|variable| {
        let variance = groups / (groups - 1.0) * squares(&|_| n * n);
        match answers.iter().all(|(k, n)| k * pooled.trials == n * pooled.correct) {
            true => Err("all observers got the same share right".to_string()),
            false => Ok((variable, variance)),
        }
    });
    let robust = |(variable, variance): (f64, f64)| {
        let half = t_975(groups - 1.0) * libm::sqrt(variance) / variable;
        let logit = libm::log(share / (1.0 - share));
        [logit - half, logit + half].map(|x| 1.0 / (1.0 + libm::exp(-x)))
    };
    let bootstrap = |_| {
        by_observer(answers.len(), SEED, |drawn| {
            let [k, n] =
                drawn.iter().fold([0, 0], |[k, n], i| [k + answers[*i].0, n + answers[*i].1]);
            Some(k as f64 / n as f64)
        })
    };
    Ok(Observers {
        observers: answers.len() as u64,
        pooled,
        robust_95: variance.clone().map(robust),
        design_effect: variance.clone().map(|(variable, variance)| variance / (variable / n)),
        bootstrap_95: variance.and_then(bootstrap),
        heterogeneity: variable.map(|variable| {
            let chi2 = squares(&|n| n * variable);
            Heterogeneity {
                chi2,
                df: answers.len() as u64 - 1,
                p: PValue::new(chi_square_tail(chi2, groups - 1.0)),
                p_permutation: permutation(&answers, pooled.correct),
                deals: DEALS,
            }
        }),
    })
}

/// P of a χ² at least as large when the right answers fall on any of the trials.
fn permutation(answers: &[(u64, u64)], correct: u64) -> PValue {
    // With fixed sums χ² rises with Σ k²/n alone.
    let statistic = |right: &[u64]| -> f64 {
        right.iter().zip(answers).map(|(k, (_, n))| (k * k) as f64 / *n as f64).sum()
    };
    let observed = statistic(&answers.iter().map(|(k, _)| *k).collect::<Vec<_>>()) * (1.0 - 1e-12);
    let mut trials: Vec<usize> =
        answers.iter().enumerate().flat_map(|(i, (_, n))| vec![i; *n as usize]).collect();
    let mut random = stream(SEED, 0);
    let as_large = (0..DEALS)
        .filter(|_| {
            let mut right = vec![0; answers.len()];
            for place in 0..correct as usize {
                let drawn = random.random_range(place..trials.len());
                trials.swap(place, drawn);
                right[trials[place]] += 1;
            }
            statistic(&right) >= observed
        })
        .count();
    PValue::new((1 + as_large) as f64 / (1 + DEALS) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn observers_who_differ_widen_the_interval() {
        let alike =
            observers(&[(7, 10), (8, 10), (6, 10), (7, 10), (8, 10), (6, 10)], 0.5).unwrap();
        let unlike =
            observers(&[(2, 10), (10, 10), (4, 10), (10, 10), (9, 10), (7, 10)], 0.5).unwrap();
        assert_eq!(alike.pooled, unlike.pooled);
        let width = |x: &Observers| {
            let [low, high] = *x.robust_95.as_ref().unwrap();
            assert!(low < 0.7 && high > 0.7);
            high - low
        };
        assert!(width(&alike) < width(&unlike));
        assert!(alike.design_effect.unwrap() < 1.0 && unlike.design_effect.unwrap() > 1.0);
        assert!(alike.heterogeneity.unwrap().p_permutation.value() > 0.5);
        assert!(unlike.heterogeneity.unwrap().p_permutation.value() < 0.01);
    }

    #[test]
    fn chi_square_is_that_of_r() {
        // R 4.2.2: chisq.test(rbind(c(2, 10, 4, 9), 10 - c(2, 10, 4, 9)), correct = FALSE), and with
        // simulate.p.value = TRUE, B = 1e5: p = 0.00012.
        let test =
            observers(&[(2, 10), (10, 10), (4, 10), (9, 10)], 0.5).unwrap().heterogeneity.unwrap();
        assert!((test.chi2 - 19.093333333333334).abs() < 1e-10, "{}", test.chi2);
        assert!(test.p_permutation.value() < 0.002);
    }

    #[test]
    fn what_does_not_follow_is_said() {
        assert!(observers(&[], 0.5).is_err());
        let one = observers(&[(3, 5), (0, 0)], 0.5).unwrap();
        assert!(one.robust_95.unwrap_err().contains("one observer"));
        assert!(one.heterogeneity.is_err() && one.bootstrap_95.is_err());
        let all = observers(&[(5, 5), (5, 5), (4, 4), (1, 1), (2, 2)], 0.5).unwrap();
        assert!(all.bootstrap_95.unwrap_err().contains("all answers are right"));
        let same = observers(&[(4, 5), (4, 5)], 0.5).unwrap();
        assert!(same.robust_95.unwrap_err().contains("same share"));
        let resampled = observers(&[(4, 6), (8, 12), (4, 6), (4, 6), (2, 3)], 0.5).unwrap();
        assert!(resampled.bootstrap_95.unwrap_err().contains("same share"));
    }
}
