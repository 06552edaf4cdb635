//! Stochastic transitivity: do the preferences of all observers together lie on a line?

use crate::input::preferences::WinMatrix;
use crate::outcome::Outcome;
use serde::Serialize;

/// Violations of stochastic transitivity among the triples of stimuli (Tversky 1969).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Transitivity {
    /// Triples whose three pairs were all judged.
    pub triples: u64,
    /// Triples left out because a pair of them was never judged.
    pub untested_triples: u64,
    /// Weak: where most prefer i to j and j to k, most prefer i to k.
    pub weak: Violations,
    /// Moderate: i is preferred to k at least as often as the less certain of the two.
    pub moderate: Violations,
    /// Strong: i is preferred to k at least as often as the more certain of the two.
    pub strong: Violations,
}

/// How many triples violate a condition, and by how much.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Violations {
    /// The number of triples.
    pub violations: u64,
    /// Mean of what the share of i over k is short of, over these triples, from 0 to 1; 0 without any.
    pub mean_deviation: f64,
    /// The largest of them.
    pub max_deviation: f64,
}

/// Counts the triples of stimuli that violate stochastic transitivity.
///
/// # Formula
/// ```text
/// where Pᵢⱼ ≥ ½ and Pⱼₖ ≥ ½:  Pᵢₖ ≥ ½ (weak), ≥ min(Pᵢⱼ, Pⱼₖ) (moderate), ≥ max(Pᵢⱼ, Pⱼₖ) (strong)
/// ```
/// Pᵢⱼ is the share of answers that chose i over j. A triple counts once, in the order of its stimuli
/// that meets the premise and most of the three conditions, then with the largest Pᵢₖ. These are
/// descriptions: sampling alone makes violations, most of all of the strong condition.
///
/// # Errors
/// In words: there is no triple with all its pairs judged.
pub fn transitivity(wins: &WinMatrix) -> Outcome<Transitivity> {
    let t = wins.scores().len();
    let share = |i: usize, j: usize| wins.get(i, j) as f64 / wins.trials(i, j) as f64;
    let mut triples = 0;
    let mut untested_triples = 0;
    let mut short = [(); 3].map(|()| Vec::new());
    for (i, j) in wins.pairs() {
        for k in j + 1..t {
            if [(i, j), (j, k), (i, k)].iter().any(|(a, b)| wins.trials(*a, *b) == 0) {
                untested_triples += 1;
                continue;
            }
            triples += 1;
            let orders = [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]];
            let kept = orders
                .into_iter()
                .map(|[a, b, c]| [share(a, b), share(b, c), share(a, c)])
                .filter(|[ab, bc, _]| *ab >= 0.5 && *bc >= 0.5)
                .map(|[ab, bc, ac]| (ac, [0.5 - ac, ab.min(bc) - ac, ab.max(bc) - ac]))
                .min_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal));
            // Of three pairs at least two point the same way around, so there is one.
            let deviations = kept.map_or([0.0; 3], |(_, deviations)| deviations);
            for (short, deviation) in short.iter_mut().zip(deviations) {
                if deviation > 0.0 {
                    short.push(deviation);
                }
            }
        }
    }
    if triples == 0 {
        return Err(
            "transitivity needs three stimuli that were all compared with each other".into()
        );
    }
    let [weak, moderate, strong] = short.map(|deviations: Vec<f64>| Violations {
        violations: deviations.len() as u64,
        // An empty sum is −0.
        mean_deviation: deviations.iter().sum::<f64>().abs() / deviations.len().max(1) as f64,
        max_deviation: deviations.iter().copied().fold(0.0, f64::max),
    });
    Ok(Transitivity { triples, untested_triples, weak, moderate, strong })
}

/// The order in which the readings of a triple are kept: few violations, a large share of i over k,
/// a small deviation.
fn rank((share, deviations): &(f64, [f64; 3])) -> (usize, f64, f64) {
    let violations = deviations.iter().filter(|deviation| **deviation > 0.0).count();
    (violations, -share, deviations[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of three pairs (0, 1), (1, 2), (0, 2) with its wins and losses.
    fn three(counts: [[u64; 2]; 3]) -> WinMatrix {
        let mut wins = WinMatrix::new(3);
        for ((i, j), [won, lost]) in [(0, 1), (1, 2), (0, 2)].into_iter().zip(counts) {
            wins.add(i, j, won);
            wins.add(j, i, lost);
        }
        wins
    }

    fn violations(counts: [[u64; 2]; 3]) -> [u64; 3] {
        let found = transitivity(&three(counts)).unwrap();
        [found.weak, found.moderate, found.strong].map(|v| v.violations)
    }

    #[test]
    fn each_condition_is_stricter_than_the_one_before() {
        assert_eq!(violations([[6, 4], [7, 3], [8, 2]]), [0, 0, 0]);
        assert_eq!(violations([[6, 4], [8, 2], [7, 3]]), [0, 0, 1]);
        assert_eq!(violations([[7, 3], [8, 2], [6, 4]]), [0, 1, 1]);
        assert_eq!(violations([[7, 3], [8, 2], [4, 6]]), [1, 1, 1]);
    }

    #[test]
    fn deviations_are_what_is_missing() {
        let found = transitivity(&three([[7, 3], [8, 2], [6, 4]])).unwrap();
        assert!((found.moderate.max_deviation - 0.1).abs() < 1e-12);
        assert!((found.strong.mean_deviation - 0.2).abs() < 1e-12);
        assert_eq!(found.weak, Violations::default());
    }

    #[test]
    fn ties_allow_several_orders_and_the_kindest_counts() {
        // 0 beats 1 by 7:3 and ties with 2; 1 beats 2 by 6:4. In the order 0, 1, 2 the tie is too weak;
        // in the order 2, 0, 1 the share of 2 over 1 would have to be ½.
        assert_eq!(violations([[7, 3], [6, 4], [5, 5]]), [0, 1, 1]);
        assert_eq!(violations([[5, 5], [5, 5], [5, 5]]), [0, 0, 0]);
    }

    #[test]
    fn triples_with_a_missing_pair_are_named() {
        let found = transitivity(&three([[7, 3], [2, 8], [0, 0]])).unwrap_err();
        assert!(found.starts_with("transitivity needs three stimuli"), "{found}");
    }
}
