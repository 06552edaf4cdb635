//! Preferences per level of each factor: which level of an axis is chosen, all else equal or not.

use super::axes::{Axis, axes};
use crate::input::preferences::WinMatrix;
use crate::maths::corrections::Corrected;
use crate::maths::proportion::Proportion;
use crate::outcome::Outcome;
use serde::Serialize;

/// Preferences per level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Levels {
    /// Each two levels of one axis, from the pairs of stimuli that differ in this axis alone.
    pub alone: Vec<LevelPair>,
    /// Each level, from all pairs of stimuli that differ in its axis, whatever else they differ in.
    pub shares: Vec<LevelShare>,
    /// Levels of one axis that were never compared with all else equal.
    pub never_alone: Vec<[String; 2]>,
}

/// How often one level was chosen over another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelPair {
    /// All levels of the axis, joined by `/`.
    pub axis: String,
    /// The level that was chosen more often (or comes first, if both were chosen as often).
    pub level: String,
    /// The other.
    pub over: String,
    /// How often `level` was chosen over `over`.
    #[serde(flatten)]
    pub proportion: Proportion,
    /// Exact p corrected for the number of tests of this kind.
    #[serde(flatten)]
    pub corrected: Corrected,
}

/// How often a level was chosen over all others of its axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelShare {
    /// All levels of the axis, joined by `/`.
    pub axis: String,
    /// The level.
    pub level: String,
    /// How often it was chosen.
    #[serde(flatten)]
    pub proportion: Proportion,
    /// Exact p corrected for the number of tests of this kind.
    #[serde(flatten)]
    pub corrected: Corrected,
}

/// Preferences per level of the axes of `items`, whose choices are `wins`. Answers are counted as
/// independent.
///
/// # Errors
/// In words: the ids do not tell levels, or nothing was compared.
pub fn levels(items: &[String], wins: &WinMatrix) -> Outcome<Levels> {
    let axes = axes(items)?;
    let mut alone = Vec::new();
    let mut shares = Vec::new();
    let mut never_alone = Vec::new();
    for (place, axis) in axes.iter().enumerate() {
        let others: Vec<&Axis> =
            axes.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, a)| a).collect();
        let else_equal = |i: usize, j: usize| others.iter().all(|a| a.of_item[i] == a.of_item[j]);
        let all = by_level(axis, wins, |_, _| true);
        let only = by_level(axis, wins, else_equal);
        for (level, name) in axis.levels.iter().enumerate() {
            let trials = all.trials_per_item()[level];
            if trials > 0 {
                let proportion = Proportion::new(all.scores()[level], trials);
                shares.push((axis.name(), name.clone(), proportion));
            }
        }
        for (a, b) in only.pairs() {
            let (a, b) = if only.get(b, a) > only.get(a, b) { (b, a) } else { (a, b) };
            let names = [axis.levels[a].clone(), axis.levels[b].clone()];
            match only.trials(a, b) {
                0 => never_alone.push(names),
                trials => {
                    alone.push((axis.name(), names, Proportion::new(only.get(a, b), trials)));
                }
            }
        }
    }
    if shares.is_empty() {
        return Err("no stimuli that differ along an axis were compared".into());
    }
    let of_pairs = Corrected::of(alone.iter().map(|(.., share)| share.p_binomial));
    let of_levels = Corrected::of(shares.iter().map(|(.., share)| share.p_binomial));
    Ok(Levels {
        alone: alone
            .into_iter()
            .zip(of_pairs)
            .map(|((axis, [level, over], proportion), corrected)| LevelPair {
                axis,
                level,
                over,
                proportion,
                corrected,
            })
            .collect(),
        shares: shares
            .into_iter()
            .zip(of_levels)
            .map(|((axis, level, proportion), corrected)| LevelShare {
                axis,
                level,
                proportion,
                corrected,
            })
            .collect(),
        never_alone,
    })
}

/// The choices between levels of `axis`, over the pairs of stimuli that `counts`.
fn by_level(axis: &Axis, wins: &WinMatrix, counts: impl Fn(usize, usize) -> bool) -> WinMatrix {
    let mut sums = WinMatrix::new(axis.levels.len());
    for (i, j) in wins.pairs().filter(|(i, j)| counts(*i, *j)) {
        let (a, b) = (axis.of_item[i], axis.of_item[j]);
        if a != b {
            sums.add(a, b, wins.get(i, j));
            sums.add(b, a, wins.get(j, i));
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two shutters × two sampling levels; 10 answers per pair.
    fn study() -> (Vec<String>, WinMatrix) {
        let items = ["T3-A4", "T3-A5", "T4-A4", "T4-A5"].map(String::from).to_vec();
        let mut wins = WinMatrix::new(4);
        let pairs: Vec<(usize, usize)> = wins.pairs().collect();
        for ((i, j), won) in pairs.into_iter().zip([5, 8, 6, 9, 7, 4]) {
            wins.add(i, j, won);
            wins.add(j, i, 10 - won);
        }
        (items, wins)
    }

    #[test]
    fn levels_are_compared_with_all_else_equal_and_overall() {
        let (items, wins) = study();
        let found = levels(&items, &wins).unwrap();
        // T3 over T4 at A4 (0, 2) and at A5 (1, 3): 8 + 7 of 20; A5 over A4: 5 + 6 of 20.
        let pairs: Vec<_> = found
            .alone
            .iter()
            .map(|p| (p.level.as_str(), p.over.as_str(), p.proportion.chosen, p.proportion.trials))
            .collect();
        assert_eq!(pairs, [("T3", "T4", 15, 20), ("A5", "A4", 11, 20)]);
        // T3 in the pairs (0,2), (0,3), (1,2), (1,3): 8 + 6 + 9 + 7 of 40.
        let shares: Vec<_> =
            found.shares.iter().map(|s| (s.level.as_str(), s.proportion.chosen)).collect();
        assert_eq!(shares, [("T3", 30), ("T4", 10), ("A4", 16), ("A5", 24)]);
        assert!(found.shares.iter().all(|s| s.proportion.trials == 40));
        assert!(found.alone.iter().all(|p| p.corrected.p_holm >= p.proportion.p_binomial));
    }

    #[test]
    fn neither_the_order_of_the_stimuli_nor_the_names_of_the_levels_matter() {
        let (items, wins) = study();
        let straight = levels(&items, &wins).unwrap();
        let order = [2, 0, 3, 1];
        let shuffled: Vec<String> = order.iter().map(|i| items[*i].clone()).collect();
        assert_eq!(levels(&shuffled, &wins.reordered(&order)).unwrap(), straight);
        let renamed: Vec<String> =
            items.iter().map(|i| i.replace('T', "X").replace('A', "Y")).collect();
        let found = levels(&renamed, &wins).unwrap();
        let shares =
            |levels: &Levels| levels.shares.iter().map(|s| s.proportion).collect::<Vec<_>>();
        assert_eq!(shares(&found), shares(&straight));
        assert_eq!(found.shares[0].level, "X3");
    }

    #[test]
    fn levels_never_compared_alone_are_named() {
        let items = ["T3-A4", "T4-A5"].map(String::from);
        let mut wins = WinMatrix::new(2);
        assert!(levels(&items, &wins).unwrap_err().starts_with("no stimuli that differ"));
        wins.add(0, 1, 3);
        let found = levels(&items, &wins).unwrap();
        assert_eq!(found.never_alone, [["T3", "T4"], ["A4", "A5"]]);
        assert!(found.alone.is_empty());
    }
}
