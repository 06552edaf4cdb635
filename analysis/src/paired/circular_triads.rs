//! Circular triads and the coefficient of consistency ζ (Kendall and Babington Smith 1940).
//!
//! A judge who prefers X to Y, Y to Z and Z to X has made a circular triad. Few of them mean that
//! the judge orders the stimuli; as many as chance gives mean that the answers are guesses.

use crate::maths::distributions::{chi_square_lower_tail, chi_square_tail};
use crate::maths::p_value::PValue;
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

/// Which departure from chance a test of circular triads looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alternative {
    /// Fewer circular triads: the judges are consistent.
    Less,
    /// More circular triads.
    Greater,
    /// Either.
    TwoSided,
}

/// The distribution of the number of circular triads when every pair is decided by a fair coin.
#[derive(Clone, Debug)]
pub struct TriadsByChance {
    stimuli: usize,
    tournaments: Option<Vec<u64>>,
}

/// A test of circular triads against chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriadsTest {
    /// Exact p, for t ≤ [`MAX_EXACT_STIMULI`].
    pub p_exact: Option<PValue>,
    /// χ² without correction, for t ≥ 5.
    pub chi_square: Option<ChiSquare>,
    /// χ² with continuity correction, for t ≥ 5.
    pub chi_square_corrected: Option<ChiSquare>,
}

/// A χ² value and its approximate p. Few triads make a large χ².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// χ².
    pub chi2: f64,
    /// Degrees of freedom; not a whole number.
    pub df: f64,
    /// Its tail, or twice the smaller one if the test is two-sided.
    pub p: PValue,
}

impl TriadsByChance {
    /// The distribution for `t` ≥ 3 stimuli.
    pub fn new(t: usize) -> Self {
        let tournaments = (t <= MAX_EXACT_STIMULI).then(|| tournaments_by_triads(t));
        Self { stimuli: t, tournaments }
    }

    /// Number of tournaments with d circular triads, for each d from 0, for t ≤ [`MAX_EXACT_STIMULI`];
    /// their sum is 2^C(t,2).
    pub fn tournaments(&self) -> Option<&[u64]> {
        self.tournaments.as_deref()
    }

    /// Tests whether judges with `triads` circular triads each differ, together, from chance.
    ///
    /// # Formula
    /// ```text
    /// exact: p = P(D₁ + … + D_m ≤ d₁ + … + d_m), by convolution
    /// χ² = 8/(t−4) · [m C(t,3)/4 − Σ dᵢ + k] + m f,  df = m f,  f = t(t−1)(t−2)/(t−4)²
    /// ```
    /// Few triads make a large χ², so "fewer than chance" is its upper tail, with the continuity correction
    /// k = −½. The +½ printed by Kendall is for P(D ≥ d). The sum of the judges' triads is one whole number
    /// and corrected once. The exact two-sided p adds to the nearer tail as much of the other tail as is
    /// no likelier.
    pub fn test(&self, triads: &[u64], alternative: Alternative) -> TriadsTest {
        TriadsTest {
            p_exact: self.exact(triads, alternative),
            chi_square: self.chi_square(triads, alternative, 0.0),
            chi_square_corrected: self.chi_square(triads, alternative, 0.5),
        }
    }

    /// Circular triads that one judge makes on average by chance.
    fn expected(&self) -> f64 {
        triples(self.stimuli as u64) as f64 / 4.0
    }

    fn exact(&self, triads: &[u64], alternative: Alternative) -> Option<PValue> {
        let tournaments = self.tournaments.as_ref()?;
        let total: u64 = tournaments.iter().sum();
        let one: Vec<f64> = tournaments.iter().map(|n| *n as f64 / total as f64).collect();
        let law = triads.iter().fold(vec![1.0], |sum, _| convolve(&sum, &one));
        let d = triads.iter().sum::<u64>() as usize;
        let few: f64 = law.iter().take(d + 1).sum();
        let many: f64 = law.iter().skip(d).rev().sum();
        let no_likelier_than = |p: f64, tail: &mut dyn Iterator<Item = &f64>| -> f64 {
            let sums = tail.scan(0.0, |sum, p| {
                *sum += p;
                Some(*sum)
            });
            sums.take_while(|sum| *sum <= p * (1.0 + 1e-12)).last().unwrap_or(0.0)
        };
        let p = match alternative {
            Alternative::Less => few,
            Alternative::Greater => many,
            Alternative::TwoSided if d as f64 <= triads.len() as f64 * self.expected() => {
                few + no_likelier_than(few, &mut law.iter().rev())
            }
            Alternative::TwoSided => many + no_likelier_than(many, &mut law.iter()),
        };
        Some(PValue::new(p.min(1.0)))
    }

    fn chi_square(
        &self,
        triads: &[u64],
        alternative: Alternative,
        correction: f64,
    ) -> Option<ChiSquare> {
        if self.stimuli < 5 {
            return None;
        }
        let (t, judges) = (self.stimuli as f64, triads.len() as f64);
        let missing = judges * self.expected() - triads.iter().sum::<u64>() as f64;
        let k = match alternative {
            Alternative::Less => -correction,
            Alternative::Greater => correction,
            Alternative::TwoSided => -correction.copysign(missing),
        };
        let df = judges * t * (t - 1.0) * (t - 2.0) / ((t - 4.0) * (t - 4.0));
        let chi2 = 8.0 / (t - 4.0) * (missing + k) + df;
        let (few, many) = (chi_square_tail(chi2, df), chi_square_lower_tail(chi2, df));
        let p = match alternative {
            Alternative::Less => few,
            Alternative::Greater => many,
            Alternative::TwoSided => (2.0 * few.min(many)).min(1.0),
        };
        Some(ChiSquare { chi2, df, p: PValue::new(p) })
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
            let chance = TriadsByChance::new(t);
            let tournaments = chance.tournaments().unwrap();
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
        let test = chance.test(&[0, 1], Alternative::Less);
        assert!((test.p_exact.unwrap().value() - at_most_one).abs() < 1e-15);
        assert_eq!(chance.test(&[1, 0], Alternative::Less), test);
        assert_eq!(test.chi_square, None);
    }
}
