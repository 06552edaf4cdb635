//! Is the level of the groups by score differences what it says? A Monte Carlo check.

use super::score_groups::critical_difference;
use crate::maths::distributions::clopper_pearson_95;
use crate::maths::random::stream;
use crate::outcome::Outcome;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::Serialize;

/// How often simulated studies without any difference between the stimuli show one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LevelCheck {
    /// Number n of simulated observers.
    pub observers: u64,
    /// Number t of stimuli.
    pub stimuli: usize,
    /// Level of significance asked for.
    pub alpha: f64,
    /// Critical difference R_c at that level.
    pub r_c: u64,
    /// Standard deviation in logits of what an observer finds better about a stimulus than others do; 0
    /// is a fair coin for every answer.
    pub spread: f64,
    /// Number of simulated studies.
    pub studies: u64,
    /// Studies whose largest score difference reached R_c.
    pub rejections: u64,
    /// Their share: the level that was found.
    pub level: f64,
    /// Clopper and Pearson's 95 % interval of `level`.
    pub interval_95: [f64; 2],
}

/// Simulates `studies` studies of `observers` who judge all pairs of t = `stimuli` once, where no
/// stimulus is better than another on the whole. With a `spread` above 0 each observer has preferences
/// of their own, so that the answers of one are not independent.
///
/// # Formula
/// ```text
/// P(observer g chooses i over j) = 1/(1 + exp(u_gj − u_gi)), u_gi ~ N(0, spread²)
/// ```
///
/// # Errors
/// In words: a number is out of range.
pub fn level_check(
    observers: u64,
    stimuli: usize,
    alpha: f64,
    spread: f64,
    studies: u64,
    seed: u64,
) -> Outcome<LevelCheck> {
    if observers == 0 || stimuli < 2 || studies == 0 {
        return Err("a check needs observers, at least 2 stimuli and at least one study".into());
    }
    if !(alpha > 0.0 && alpha < 1.0 && spread >= 0.0 && spread.is_finite()) {
        return Err("a check needs α between 0 and 1 and a spread that is not negative".into());
    }
    let r_c = critical_difference(observers, stimuli, alpha);
    let reaches = |study: u64| {
        let votes = votes(observers, stimuli, spread, &mut stream(seed, study));
        let [low, high] = votes.iter().fold([u64::MAX, 0], |[l, h], v| [l.min(*v), h.max(*v)]);
        high - low >= r_c
    };
    let rejections = (0..studies).into_par_iter().filter(|study| reaches(*study)).count() as u64;
    Ok(LevelCheck {
        observers,
        stimuli,
        alpha,
        r_c,
        spread,
        studies,
        rejections,
        level: rejections as f64 / studies as f64,
        interval_95: clopper_pearson_95(rejections, studies),
    })
}

/// The votes of one simulated study.
fn votes(observers: u64, stimuli: usize, spread: f64, random: &mut impl Rng) -> Vec<u64> {
    let mut votes = vec![0; stimuli];
    for _ in 0..observers {
        let own: Vec<f64> = (0..stimuli)
            .map(|_| {
                let standard: f64 = StandardNormal.sample(random);
                spread * standard
            })
            .collect();
        for i in 0..stimuli {
            for j in i + 1..stimuli {
                let i_chosen = random.random::<f64>() * (1.0 + libm::exp(own[j] - own[i])) < 1.0;
                votes[if i_chosen { i } else { j }] += 1;
            }
        }
    }
    votes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fair_coins_keep_the_level() {
        let found = level_check(20, 5, 0.05, 0.0, 4000, 1).unwrap();
        assert_eq!(found.r_c, 20);
        // R_c is a whole number: P(W ≥ (2·20 − ½)/10) is 0.04.
        assert!(found.interval_95[0] < 0.05 && found.interval_95[1] > 0.03, "{found:?}");
        assert_eq!(level_check(20, 5, 0.05, 0.0, 4000, 1), Ok(found));
    }

    #[test]
    fn observers_with_preferences_of_their_own_exceed_it() {
        let found = level_check(20, 5, 0.05, 1.5, 1000, 1).unwrap();
        assert!(found.interval_95[0] > 0.05, "{found:?}");
    }

    #[test]
    fn numbers_out_of_range_are_refused_in_words() {
        assert!(level_check(0, 5, 0.05, 0.0, 10, 1).is_err());
        assert!(level_check(5, 1, 0.05, 0.0, 10, 1).is_err());
        assert!(level_check(5, 5, 1.0, 0.0, 10, 1).is_err());
        assert!(level_check(5, 5, 0.05, f64::NAN, 10, 1).is_err());
    }
}
