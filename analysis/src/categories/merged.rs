//! Merged levels: neighbours that observers did not tell apart.

use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;

/// Levels after those that were not told apart are merged. "Not told apart" is not "equal": the interval
/// of a pair's accuracy says what difference the answers leave possible.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// Places of the levels in each group, in their order; groups may overlap, and a level that is told
    /// apart from its neighbours is alone.
    pub groups: Vec<Vec<usize>>,
    /// Answers to pairs within a group, which count no longer.
    pub left_out: u64,
    /// The right answers to the other pairs.
    pub others: Outcome<Others>,
}

/// Right answers to the pairs that are left: chosen after their answers were seen, so they are counts
/// without interval or test, no estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Others {
    /// Right answers.
    pub correct: u64,
    /// Answers.
    pub trials: u64,
    /// The share in percent.
    pub percent: f64,
}

serialize_outcomes!(Merged, [groups, left_out], [others]);

/// A pair of levels: their places, its right answers and answers, and whether it was told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Places of the two levels.
    pub levels: [usize; 2],
    /// Right answers.
    pub correct: u64,
    /// Answers.
    pub trials: u64,
    /// Whether the answers are better than guessing.
    pub told_apart: bool,
}

/// Merges the levels 0 to `levels` − 1 of an axis, in their order.
///
/// The groups are the maximal runs of neighbouring levels in which every pair was asked and none was told
/// apart. A run whose ends are told apart is not merged, though each level in it may be mistaken for the
/// next: so groups may overlap, as groups of scores do.
pub fn merged(levels: usize, pairs: &[Pair]) -> Merged {
    let like = |i: usize, j: usize| {
        pairs.iter().any(|pair| {
            (pair.levels == [i, j] || pair.levels == [j, i]) && pair.trials > 0 && !pair.told_apart
        })
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut end = 0;
    for start in 0..levels {
        let mut next = start + 1;
        while next < levels && (start..next).all(|i| like(i, next)) {
            next += 1;
        }
        if next > end {
            groups.push((start..next).collect());
            end = next;
        }
    }
    let merged = |pair: &Pair| {
        groups.iter().any(|group| pair.levels.iter().all(|level| group.contains(level)))
    };
    let (within, between): (Vec<&Pair>, Vec<&Pair>) = pairs.iter().partition(|pair| merged(pair));
    let sum = |of: fn(&Pair) -> u64| between.iter().map(|pair| of(pair)).sum::<u64>();
    let others = match (sum(|pair| pair.correct), sum(|pair| pair.trials)) {
        (_, 0) => Err("no pair is left whose levels are not merged".into()),
        (correct, trials) => {
            Ok(Others { correct, trials, percent: 100.0 * correct as f64 / trials as f64 })
        }
    };
    let left_out = within.iter().map(|pair| pair.trials).sum();
    Merged { groups, left_out, others }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All pairs of `levels`, each with 10 answers, those in `apart` told apart.
    fn pairs(levels: usize, apart: &[[usize; 2]]) -> Vec<Pair> {
        let all = (0..levels).flat_map(|i| (i + 1..levels).map(move |j| [i, j]));
        all.map(|levels| {
            let told_apart = apart.contains(&levels);
            Pair { levels, correct: if told_apart { 9 } else { 5 }, trials: 10, told_apart }
        })
        .collect()
    }

    #[test]
    fn groups_are_runs_of_which_no_pair_is_told_apart() {
        let found = merged(5, &pairs(5, &[[0, 3], [0, 4], [1, 4], [2, 4], [3, 4]]));
        assert_eq!(found.groups, [vec![0, 1, 2], vec![1, 2, 3], vec![4]]);
        assert_eq!(found.left_out, 50);
        assert_eq!(found.others, Ok(Others { correct: 45, trials: 50, percent: 90.0 }));
    }

    #[test]
    fn a_pair_that_was_not_asked_merges_nothing() {
        let mut some = pairs(3, &[]);
        some.retain(|pair| pair.levels != [0, 2]);
        assert_eq!(merged(3, &some).groups, [vec![0, 1], vec![1, 2]]);
    }

    #[test]
    fn reversing_the_levels_reverses_the_groups() {
        let apart = [[0, 2], [1, 3], [0, 3]];
        let turned: Vec<Pair> = pairs(4, &apart)
            .into_iter()
            .map(|pair| Pair { levels: pair.levels.map(|level| 3 - level), ..pair })
            .collect();
        let mut back: Vec<Vec<usize>> = merged(4, &turned).groups;
        back.iter_mut().for_each(|group| {
            group.iter_mut().for_each(|level| *level = 3 - *level);
            group.reverse();
        });
        back.reverse();
        assert_eq!(back, merged(4, &pairs(4, &apart)).groups);
    }

    #[test]
    fn all_merged_leaves_no_accuracy() {
        let found = merged(3, &pairs(3, &[]));
        assert_eq!(found.groups, [vec![0, 1, 2]]);
        assert!(found.others.unwrap_err().contains("no pair is left"));
        assert!(merged(0, &[]).groups.is_empty());
    }
}
