//! Preferences as percentages, per stimulus and per pair, with intervals and tests against ½.

use crate::input::preferences::WinMatrix;
use crate::maths::corrections::Corrected;
use crate::maths::proportion::Proportion;
use serde::Serialize;

/// How often a stimulus was chosen, over all pairs it was in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ItemPreference {
    /// The stimulus.
    pub item: String,
    /// How often it was chosen.
    #[serde(flatten)]
    pub proportion: Proportion,
    /// Its exact p corrected for the number of tests of this kind.
    #[serde(flatten)]
    pub corrected: Corrected,
}

/// How often the first of two stimuli was chosen over the second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairPreference {
    /// The stimulus with more votes over all pairs (or before the other, if they have as many).
    pub item: String,
    /// The other.
    pub over: String,
    /// How often `item` was chosen over `over`.
    #[serde(flatten)]
    pub proportion: Proportion,
    /// Its exact p corrected for the number of tests of this kind.
    #[serde(flatten)]
    pub corrected: Corrected,
}

/// The preference for each of `items` that was judged at all, with `votes` in so many `trials`.
pub fn per_item(items: &[String], votes: &[u64], trials: &[u64]) -> Vec<ItemPreference> {
    let judged: Vec<(&String, Proportion)> = items
        .iter()
        .zip(votes.iter().zip(trials))
        .filter(|(_, (_, trials))| **trials > 0)
        .map(|(item, (chosen, trials))| (item, Proportion::new(*chosen, *trials)))
        .collect();
    let corrected = Corrected::of(judged.iter().map(|(_, share)| share.p_binomial));
    judged
        .into_iter()
        .zip(corrected)
        .map(|((item, proportion), corrected)| ItemPreference {
            item: item.clone(),
            proportion,
            corrected,
        })
        .collect()
}

/// The preference in each pair of `items` that was judged at all.
pub fn per_pair(items: &[String], wins: &WinMatrix) -> Vec<PairPreference> {
    let judged: Vec<(usize, usize, Proportion)> = wins
        .pairs()
        .filter(|(i, j)| wins.trials(*i, *j) > 0)
        .map(|(i, j)| (i, j, Proportion::new(wins.get(i, j), wins.trials(i, j))))
        .collect();
    let corrected = Corrected::of(judged.iter().map(|(.., share)| share.p_binomial));
    judged
        .into_iter()
        .zip(corrected)
        .map(|((i, j, proportion), corrected)| PairPreference {
            item: items[i].clone(),
            over: items[j].clone(),
            proportion,
            corrected,
        })
        .collect()
}
