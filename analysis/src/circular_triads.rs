//! Circular triads and the coefficient of consistency ζ (Kendall and Babington Smith 1940).
//!
//! A judge who prefers X to Y, Y to Z and Z to X has made a circular triad. Few of them mean that
//! the judge orders the stimuli; as many as chance gives mean that the answers are guesses.

use crate::distributions::chi_square_tail;
use crate::p_value::PValue;
use std::collections::HashMap;

/// Up to this number of stimuli the distribution of d under chance is computed exactly.
pub const MAX_EXACT_STIMULI: usize = 10;

/// Number of circular triads of one judge.
///
/// # Formula
/// ```text
/// d = C(t, 3) − Σᵢ C(sᵢ, 2)
/// ```
/// where sᵢ is how often the judge chose stimulus i over another; every pair was judged once.
pub fn circular_triads(scores: &[u64]) -> u64 {
    let t = scores.len() as u64;
    let transitive: u64 = scores.iter().map(|s| s * s.saturating_sub(1) / 2).sum();
    triples(t) - transitive
}

/// The largest possible number of circular triads with `t` stimuli.
///
/// # Formula
/// ```text
/// (t³ − t)/24 for odd t, (t³ − 4t)/24 for even t
/// ```
pub fn max_circular_triads(t: usize) -> u64 {
    let t = t as u64;
    if t % 2 == 1 { (t * t * t - t) / 24 } else { (t * t * t - 4 * t) / 24 }
}

/// Coefficient of consistency ζ of `judges` judges with `d` circular triads together, for `t` ≥ 3.
///
/// # Formula
/// ```text
/// ζ = 1 − d / (judges · d_max)
/// ```
/// From one judge it is Kendall's ζ; from several it is the mean of theirs.
pub fn consistency(d: u64, judges: u64, t: usize) -> f64 {
    1.0 - d as f64 / (judges * max_circular_triads(t)) as f64
}

/// The distribution of the number of circular triads when every pair is decided by a fair coin.
#[derive(Clone, Debug)]
pub enum TriadsByChance {
    /// Number of tournaments for each d from 0, for t ≤ [`MAX_EXACT_STIMULI`].
    Exact {
        /// Tournaments with d circular triads; their sum is 2^C(t,2).
        tournaments: Vec<u64>,
    },
    /// The χ² approximation, for more stimuli.
    ChiSquare {
        /// The number of stimuli t.
        stimuli: usize,
    },
}

/// The result of a test for fewer circular triads than chance gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriadsTest {
    /// P(D ≤ d).
    pub p: PValue,
    /// χ² and its degrees of freedom where p is approximate; none where it is exact.
    pub chi_square: Option<(f64, f64)>,
}

impl TriadsByChance {
    /// The distribution for `t` ≥ 3 stimuli.
    pub fn new(t: usize) -> Self {
        match t <= MAX_EXACT_STIMULI {
            true => Self::Exact { tournaments: tournaments_by_triads(t) },
            false => Self::ChiSquare { stimuli: t },
        }
    }

    /// Tests whether one judge with `d` circular triads is more consistent than chance.
    pub fn test(&self, d: u64) -> TriadsTest {
        self.test_pooled(&[d])
    }

    /// Tests whether judges with `triads` circular triads each are, together, more consistent than
    /// chance: exactly by convolution, or by the sum of their χ² values.
    ///
    /// # Formula
    /// ```text
    /// t ≤ 10: p = P(D₁ + … + D_m ≤ d₁ + … + d_m)
    /// above:  χ² = Σ { 8/(t−4) · [C(t,3)/4 − dᵢ − ½] + f },  df = m f,
    ///         f = t(t−1)(t−2)/(t−4)²,  upper tail
    /// ```
    /// Few triads make a large χ². The continuity correction −½ is for P(D ≤ d); the +½ printed by
    /// Kendall is for P(D ≥ d). One correction per judge keeps the sum on the safe side.
    pub fn test_pooled(&self, triads: &[u64]) -> TriadsTest {
        match self {
            Self::Exact { tournaments } => {
                let total: u64 = tournaments.iter().sum();
                let one: Vec<f64> = tournaments.iter().map(|n| *n as f64 / total as f64).collect();
                let mut sum = vec![1.0];
                for _ in triads {
                    sum = convolve(&sum, &one);
                }
                let d = triads.iter().sum::<u64>() as usize;
                let p = sum.iter().take(d + 1).sum();
                TriadsTest { p: PValue::new(p), chi_square: None }
            }
            Self::ChiSquare { stimuli } => {
                let t = *stimuli as f64;
                let f = t * (t - 1.0) * (t - 2.0) / ((t - 4.0) * (t - 4.0));
                let expected = triples(*stimuli as u64) as f64 / 4.0;
                let chi2 =
                    triads.iter().map(|d| 8.0 / (t - 4.0) * (expected - *d as f64 - 0.5) + f).sum();
                let df = f * triads.len() as f64;
                let p = PValue::new(chi_square_tail(chi2, df));
                TriadsTest { p, chi_square: Some((chi2, df)) }
            }
        }
    }
}

/// C(t, 3).
fn triples(t: u64) -> u64 {
    t * (t - 1) * (t - 2) / 6
}

/// The number of labelled tournaments on `t` vertices with d circular triads, for every d.
///
/// d depends on the scores alone, and tournaments grow one vertex at a time: the newcomer beats a
/// chosen set of the others, every other gains a point. So it is enough to count tournaments per
/// sorted list of scores (490 lists at t = 9) instead of the 2⁴⁵ tournaments at t = 10.
fn tournaments_by_triads(t: usize) -> Vec<u64> {
    let mut by_scores: HashMap<Vec<u64>, u64> = HashMap::from([(vec![0], 1)]);
    for vertices in 1..t {
        let mut grown: HashMap<Vec<u64>, u64> = HashMap::new();
        for (scores, count) in by_scores {
            for beaten in 0..1_u32 << vertices {
                let mut next: Vec<u64> = (0..vertices)
                    .map(|i| scores[i] + u64::from(beaten & (1 << i) == 0))
                    .chain([u64::from(beaten.count_ones())])
                    .collect();
                next.sort_unstable();
                *grown.entry(next).or_default() += count;
            }
        }
        by_scores = grown;
    }
    let mut tournaments = vec![0; max_circular_triads(t) as usize + 1];
    for (scores, count) in by_scores {
        tournaments[circular_triads(&scores) as usize] += count;
    }
    tournaments
}

fn convolve(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            sum[i + j] += x * y;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ranking_has_none_and_a_cycle_has_one() {
        assert_eq!(circular_triads(&[3, 2, 1, 0]), 0);
        assert_eq!(circular_triads(&[1, 1, 1]), 1);
        assert_eq!(consistency(0, 1, 4), 1.0);
        assert_eq!(consistency(1, 1, 3), 0.0);
    }

    #[test]
    fn mean_and_variance_by_chance_are_kendalls() {
        for t in 3..=8 {
            let TriadsByChance::Exact { tournaments } = TriadsByChance::new(t) else { panic!() };
            let total: u64 = tournaments.iter().sum();
            assert_eq!(total, 1 << (t * (t - 1) / 2));
            let moment = |k: i32| -> f64 {
                let weigh = |(d, n): (usize, &u64)| (d as f64).powi(k) * *n as f64 / total as f64;
                tournaments.iter().enumerate().map(weigh).sum()
            };
            let triples = triples(t as u64) as f64;
            assert!((moment(1) - triples / 4.0).abs() < 1e-10, "t = {t}");
            assert!((moment(2) - moment(1).powi(2) - triples * 3.0 / 16.0).abs() < 1e-9, "t = {t}");
        }
    }

    #[test]
    fn the_pooled_test_is_the_enumeration_over_both_judges() {
        let chance = TriadsByChance::new(4);
        // 24, 16 and 24 of 64 tournaments have 0, 1 and 2 circular triads.
        let at_most_one = (24.0 * 24.0 + 2.0 * 24.0 * 16.0) / (64.0 * 64.0);
        assert!((chance.test_pooled(&[0, 1]).p.value() - at_most_one).abs() < 1e-15);
        assert_eq!(chance.test_pooled(&[1, 0]), chance.test_pooled(&[0, 1]));
    }
}
