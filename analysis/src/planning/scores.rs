//! Scores and scale values against the number of observers.

use super::design::{Assumptions, Design};
use super::precision::difference_variances;
use super::separability::{separation, smallest_preference};
use crate::maths::distributions::{Z_975, bisect, normal_tail};
use crate::maths::studentized_range::upper_quantile;
use crate::outcome::Outcome;
use crate::paired::score_groups::critical_difference;
use serde::Serialize;

/// The power that the smallest preference is found with.
pub const POWER: f64 = 0.8;

/// Score differences with so many observers: exact, all answers independent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoreRow {
    /// Number of observers.
    pub observers: u64,
    /// Complete sets of pairs.
    pub sets: u64,
    /// Critical difference R_c.
    pub r_c: u64,
    /// The largest difference that two stimuli can have.
    pub largest: u64,
    /// `r_c` as a share of `largest`.
    pub share: f64,
    /// The smallest preference between two stimuli, in a set otherwise alike, that R_c separates with
    /// probability 0.8; none if it separates none.
    pub smallest_preference: Option<f64>,
    /// Probability that R_c separates two stimuli at the assumed effect, in a set otherwise alike.
    pub power: f64,
}

/// Bradley–Terry scale values with so many observers, from the Fisher information.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScaleRow {
    /// Number of observers.
    pub observers: u64,
    /// Least and largest standard error of a difference of two log-worths, if all are equal.
    pub se_equal: [f64; 2],
    /// The same at the assumed worths.
    pub se_assumed: [f64; 2],
    /// Half the width of the 95 % interval of the preference between two equal stimuli, the least precise two,
    /// from 0 to 0.5.
    pub preference_95: f64,
    /// The smallest preference, between the least precise two, that is found with probability 0.8 when all
    /// differences are tested at once: normal approximation, Tukey's correction.
    pub smallest_preference: f64,
    /// Power of that test at the assumed effect.
    pub power: f64,
}

/// R_c and what it separates, where each observer gives so many sets (`times`).
pub(super) fn score_rows(design: &Design, assumptions: &Assumptions, times: u64) -> Vec<ScoreRow> {
    let t = design.stimuli.len();
    let theta = log_odds(assumptions.effect);
    let row = |&observers: &u64| {
        let sets = observers * times;
        let r_c = critical_difference(sets, t, assumptions.alpha);
        let largest = sets * (t as u64 - 1);
        ScoreRow {
            observers,
            sets,
            r_c,
            largest,
            share: r_c as f64 / largest as f64,
            smallest_preference: smallest_preference(sets, t, r_c, POWER),
            power: separation(sets, t, r_c, theta),
        }
    };
    assumptions.observers.iter().map(row).collect()
}

/// Standard errors of the scale.
pub(super) fn scale_rows(
    design: &Design,
    assumptions: &Assumptions,
    worths: &[f64],
) -> Outcome<Vec<ScaleRow>> {
    let t = design.stimuli.len();
    let pairs: Vec<(usize, usize, u64)> =
        design.pairs.iter().filter(|p| p.a != p.b).map(|p| (p.a, p.b, p.times)).collect();
    let extremes = |worths: &[f64]| -> Outcome<[f64; 2]> {
        let variances = difference_variances(worths, &pairs)?;
        let all = (0..t).flat_map(|i| (i + 1..t).map(move |j| (i, j)));
        Ok(all.map(|pair| variances[pair]).fold([f64::INFINITY, 0.0], |[low, high], variance| {
            [low.min(variance), high.max(variance)]
        }))
    };
    let (equal, assumed) = (extremes(&vec![0.0; t])?, extremes(worths)?);
    // A difference d is found if |d|/SE ≥ W/√2.
    let critical = upper_quantile(assumptions.alpha, t) * std::f64::consts::FRAC_1_SQRT_2;
    let power = |size: f64| normal_tail(critical - size) + normal_tail(critical + size);
    let needed = bisect(0.0, critical + 10.0, |size| power(size) >= POWER);
    let row = |&observers: &u64| {
        let error = |variance: f64| libm::sqrt(variance / observers as f64);
        let largest = error(equal[1]);
        ScaleRow {
            observers,
            se_equal: equal.map(error),
            se_assumed: assumed.map(error),
            preference_95: preference(Z_975 * largest) - 0.5,
            smallest_preference: preference(needed * largest),
            power: power(log_odds(assumptions.effect) / largest),
        }
    };
    Ok(assumptions.observers.iter().map(row).collect())
}

fn preference(log_odds: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-log_odds))
}

pub(super) fn log_odds(preference: f64) -> f64 {
    libm::log(preference / (1.0 - preference))
}
