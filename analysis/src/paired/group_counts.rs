//! Choices counted by observer, by group of observers, and by pair.

use super::axes::axes;
use crate::input::preferences::Choice;
use shutterlab_data_schema::response::Side;
use std::collections::BTreeMap;

/// The choices of observers in groups.
pub(super) struct GroupCounts {
    /// What was judged: the stimuli, then the levels of all axes, and whether it is a level.
    pub names: Vec<(String, bool)>,
    /// Per observer and name: choices (half of a "not sure" each) and trials.
    pub observers: BTreeMap<usize, Vec<[f64; 2]>>,
    /// Per group and name: choices and trials, without "not sure".
    pub groups: Vec<Vec<[u64; 2]>>,
    /// Per pair and group: choices of the stimulus listed first, and trials, without "not sure".
    pub pairs: BTreeMap<(usize, usize), Vec<[u64; 2]>>,
}

impl GroupCounts {
    /// Counts the `choices` among `items` of the observers that have a group, one of `groups`.
    pub fn of(
        items: &[String],
        choices: &[Choice],
        group_of: &BTreeMap<usize, usize>,
        groups: usize,
    ) -> Self {
        let axes = axes(items).unwrap_or_default();
        let stimuli = items.iter().map(|item| (item.clone(), false));
        let levels = axes.iter().flat_map(|axis| &axis.levels).map(|level| (level.clone(), true));
        let names: Vec<(String, bool)> = stimuli.chain(levels).collect();
        // A stimulus counts always, its level where the other stimulus has another.
        let places = |item: usize, other: usize| {
            let mut places = vec![item];
            let mut start = items.len();
            for axis in &axes {
                if axis.of_item[item] != axis.of_item[other] {
                    places.push(start + axis.of_item[item]);
                }
                start += axis.levels.len();
            }
            places
        };
        let mut counts = Self {
            observers: BTreeMap::new(),
            groups: vec![vec![[0; 2]; names.len()]; groups],
            pairs: BTreeMap::new(),
            names,
        };
        for choice in choices {
            let Some(group) = group_of.get(&choice.observer) else { continue };
            let of_group = &mut counts.groups[*group];
            let own =
                counts.observers.entry(choice.observer).or_insert(vec![[0.0; 2]; of_group.len()]);
            let sides = [(choice.a, choice.b, Side::A), (choice.b, choice.a, Side::B)];
            for (item, other, side) in sides {
                let chosen = choice.chosen.map(|chosen| u64::from(chosen == side));
                for place in places(item, other) {
                    own[place][0] += chosen.map_or(0.5, |chosen| chosen as f64);
                    own[place][1] += 1.0;
                    if let Some(chosen) = chosen {
                        of_group[place][0] += chosen;
                        of_group[place][1] += 1;
                    }
                }
            }
            if let Some(chosen) = choice.chosen {
                let listed_first = if choice.a < choice.b { Side::A } else { Side::B };
                let pair = (choice.a.min(choice.b), choice.a.max(choice.b));
                let of_pair = counts.pairs.entry(pair).or_insert(vec![[0; 2]; groups]);
                of_pair[*group][0] += u64::from(chosen == listed_first);
                of_pair[*group][1] += 1;
            }
        }
        counts.drop_unjudged();
        counts
    }

    /// Forgets the stimuli and levels that nobody judged.
    fn drop_unjudged(&mut self) {
        let judged: Vec<bool> = (0..self.names.len())
            .map(|place| self.observers.values().any(|own| own[place][1] > 0.0))
            .collect();
        keep(&mut self.names, &judged);
        self.groups.iter_mut().for_each(|group| keep(group, &judged));
        self.observers.values_mut().for_each(|own| keep(own, &judged));
    }
}

/// Keeps the elements whose place is `kept`.
fn keep<T>(elements: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    elements.retain(|_| kept.next() == Some(&true));
}
