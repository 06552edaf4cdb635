//! Groups of observers: do experienced and naive ones, or those who saw it in mono and in stereo, prefer
//! the same?

use super::group_counts::GroupCounts;
use crate::input::preferences::{Choice, Observer};
use crate::maths::corrections::{holm, holm_of_known};
use crate::maths::fisher_exact::fisher_exact;
use crate::maths::p_value::PValue;
use crate::maths::permutation::permutation_test;
use crate::maths::proportion::Proportion;
use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

const MOST_GROUPS: usize = 6;
const FEWEST_OBSERVERS: usize = 2;
/// What the random groupings are drawn from, fixed so that an analysis can be repeated.
const SEED: u64 = 0x6f62_7365_7276_6572;

/// The groups that one trait divides the observers into.
#[derive(Clone, Debug, PartialEq)]
pub struct TraitGroups {
    /// The trait: `experience`.
    pub name: String,
    /// Its groups and their comparison.
    pub comparison: Outcome<GroupComparison>,
}

serialize_outcomes!(TraitGroups, [name], [comparison]);

/// The comparison of groups of observers.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupComparison {
    /// The groups.
    pub groups: Vec<Group>,
    /// Observers whose group is not known.
    pub unknown: u64,
    /// Permutation test of all stimuli together: how observers share their choices out among them.
    pub overall: Outcome<OverallTest>,
    /// Each stimulus, then each level of each axis.
    pub shares: Vec<GroupShare>,
    /// Each pair that observers of at least two groups chose in.
    pub pairs: Vec<GroupPair>,
    /// Correlation of the stimuli's shares, for each two groups.
    pub correlations: Vec<Correlation>,
}

serialize_outcomes!(GroupComparison, [groups, unknown, shares, pairs, correlations], [overall]);

/// A permutation test of group membership, one vector of shares per observer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OverallTest {
    /// Share of the groupings that differ as much.
    pub p: PValue,
    /// Whether every grouping was looked at; else they were drawn.
    pub exact: bool,
    /// How many groupings of the observers were looked at.
    pub groupings: u64,
    /// The smallest p that so many observers could give.
    pub smallest_p: PValue,
    /// Observers left out because some stimulus or level is missing from their answers.
    pub incomplete: u64,
}

/// A group of observers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// What its observers answered to the trait's question: `naive`.
    pub value: String,
    /// How many they are.
    pub observers: u64,
}

/// How often each group chose a stimulus or a level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupShare {
    /// The stimulus or the level.
    pub item: String,
    /// Whether it is a level: then of all pairs that differ in its axis.
    pub level: bool,
    /// The choices of each group, in the order of the groups; none where it made none.
    pub proportions: Vec<Option<Proportion>>,
    /// Permutation test of the observers' shares, one value per observer; none where `overall` has none.
    pub p: Option<PValue>,
    /// `p` corrected for the number of shares by Holm (1979).
    pub p_holm: Option<PValue>,
}

/// How often each group chose one stimulus of a pair.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupPair {
    /// The stimulus that comes first among the stimuli.
    pub item: String,
    /// The other.
    pub over: String,
    /// How often each group chose `item`, and out of how many, in the order of the groups.
    pub chosen: Vec<[u64; 2]>,
    /// Fisher's exact test of group and choice, two-sided.
    pub p: Outcome<PValue>,
    /// `p` corrected for the number of pairs that were tested by Holm (1979).
    pub p_holm: Option<PValue>,
}

serialize_outcomes!(GroupPair, [item, over, chosen, p_holm], [p]);

/// How alike two groups' shares of the stimuli are.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlation {
    /// The two groups.
    pub groups: [String; 2],
    /// Pearson's r over the stimuli.
    pub r: Outcome<f64>,
}

serialize_outcomes!(Correlation, [groups], [r]);

/// Compares groups of `observers` by each of their traits.
///
/// Answers of one observer are not independent, so stimuli and levels are tested with one value per
/// observer. In a pair each observer answers once (unless the protocol repeats it), so answers to it are
/// independent.
pub fn observer_groups(
    items: &[String],
    observers: &[Observer],
    choices: &[Choice],
) -> Vec<TraitGroups> {
    let names: BTreeSet<&String> = observers.iter().flat_map(|o| o.traits.keys()).collect();
    names
        .into_iter()
        .map(|name| TraitGroups {
            name: name.clone(),
            comparison: compare(name, items, observers, choices),
        })
        .collect()
}

fn compare(
    name: &str,
    items: &[String],
    observers: &[Observer],
    choices: &[Choice],
) -> Outcome<GroupComparison> {
    let answered: BTreeSet<usize> = choices.iter().map(|choice| choice.observer).collect();
    let mut members: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for observer in &answered {
        if let Some(value) = observers[*observer].traits.get(name) {
            members.entry(value).or_default().push(*observer);
        }
    }
    let known: usize = members.values().map(Vec::len).sum();
    check(&members)?;
    let group_of: BTreeMap<usize, usize> = members
        .values()
        .enumerate()
        .flat_map(|(group, members)| members.iter().map(move |observer| (*observer, group)))
        .collect();
    let groups = members.len();

    let GroupCounts { names, observers: own, groups: counts, pairs } =
        GroupCounts::of(items, choices, &group_of, groups);
    let complete = own.iter().filter(|(_, own)| own.iter().all(|[_, trials]| *trials > 0.0));
    let complete = complete.map(|(observer, own)| {
        (group_of[observer], own.iter().map(|[chosen, trials]| chosen / trials).collect())
    });
    let (labels, values): (Vec<usize>, Vec<Vec<f64>>) = complete.unzip();
    let stimuli = names.iter().filter(|(_, level)| !level).count();
    let permutations = match (0..groups).all(|group| labels.contains(&group)) {
        true => Ok(permutation_test(&labels, &values, stimuli, SEED)),
        false => {
            Err("in one of the groups no observer judged every stimulus and level".to_string())
        }
    };
    let p = permutations.as_ref().map_or(&[][..], |found| &found.p);
    let p_holm = holm(p);
    let shares = names.into_iter().enumerate().map(|(place, (item, level))| GroupShare {
        item,
        level,
        proportions: counts
            .iter()
            .map(|group| group[place])
            .map(|[chosen, trials]| (trials > 0).then(|| Proportion::new(chosen, trials)))
            .collect(),
        p: p.get(place).copied().map(PValue::new),
        p_holm: p_holm.get(place).copied().map(PValue::new),
    });
    let shares = shares.collect();
    let values: Vec<&str> = members.keys().copied().collect();
    Ok(GroupComparison {
        groups: members
            .iter()
            .map(|(value, members)| Group {
                value: value.to_string(),
                observers: members.len() as u64,
            })
            .collect(),
        unknown: (answered.len() - known) as u64,
        overall: permutations.map(|found| OverallTest {
            p: PValue::new(found.p_overall),
            exact: found.exact,
            groupings: found.ways,
            smallest_p: PValue::new(found.smallest_p),
            incomplete: (known - labels.len()) as u64,
        }),
        pairs: of_pairs(items, pairs),
        correlations: correlations(&values, &counts, stimuli),
        shares,
    })
}

/// Refuses groups that cannot be compared.
fn check(members: &BTreeMap<&str, Vec<usize>>) -> Outcome<()> {
    match members.len() {
        0 => return Err("no observer's answer to it is known".into()),
        1 => return Err("all observers are of one group".into()),
        2..=MOST_GROUPS => {}
        groups => return Err(format!("{groups} groups are more than the {MOST_GROUPS} compared")),
    }
    match members.iter().find(|(_, members)| members.len() < FEWEST_OBSERVERS) {
        Some((value, _)) => Err(format!("only one observer is of the group `{value}`")),
        None => Ok(()),
    }
}

fn of_pairs(items: &[String], pairs: BTreeMap<(usize, usize), Vec<[u64; 2]>>) -> Vec<GroupPair> {
    let asked = |groups: &Vec<[u64; 2]>| groups.iter().filter(|group| group[1] > 0).count() > 1;
    let pairs: Vec<_> = pairs.into_iter().filter(|(_, groups)| asked(groups)).collect();
    let table = |groups: &Vec<[u64; 2]>| -> Vec<[u64; 2]> {
        groups.iter().map(|[chosen, trials]| [*chosen, trials - chosen]).collect()
    };
    let p: Vec<Outcome<f64>> =
        pairs.iter().map(|(_, groups)| fisher_exact(&table(groups))).collect();
    let p_holm = holm_of_known(&p);
    let corrected = pairs.into_iter().zip(p.into_iter().zip(p_holm));
    corrected
        .map(|(((i, j), chosen), (p, p_holm))| GroupPair {
            item: items[i].clone(),
            over: items[j].clone(),
            chosen,
            p: p.map(PValue::new),
            p_holm,
        })
        .collect()
}

fn correlations(groups: &[&str], counts: &[Vec<[u64; 2]>], stimuli: usize) -> Vec<Correlation> {
    let mut found = Vec::new();
    for a in 0..groups.len() {
        for b in a + 1..groups.len() {
            let both = counts[a].iter().zip(&counts[b]).take(stimuli);
            let judged = both.filter(|(a, b)| a[1] > 0 && b[1] > 0);
            let shares: Vec<[f64; 2]> = judged
                .map(|(a, b)| [a, b].map(|[chosen, trials]| *chosen as f64 / *trials as f64))
                .collect();
            let groups = [groups[a].to_string(), groups[b].to_string()];
            found.push(Correlation { groups, r: correlation(&shares) });
        }
    }
    found
}

/// Pearson's coefficient of correlation.
fn correlation(pairs: &[[f64; 2]]) -> Outcome<f64> {
    if pairs.len() < 3 {
        return Err("a correlation needs at least 3 stimuli that both groups judged".into());
    }
    let n = pairs.len() as f64;
    let mean = |side: usize| pairs.iter().map(|pair| pair[side]).sum::<f64>() / n;
    let means = [mean(0), mean(1)];
    let sum = |a: usize, b: usize| -> f64 {
        pairs.iter().map(|pair| (pair[a] - means[a]) * (pair[b] - means[b])).sum()
    };
    let spread = sum(0, 0) * sum(1, 1);
    match spread > 1e-24 {
        true => Ok((sum(0, 1) / libm::sqrt(spread)).clamp(-1.0, 1.0)),
        false => Err("one of the groups chose all stimuli equally often".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shutterlab_data_schema::response::Side;

    /// Four stimuli of a grid; `shift` is how much more the second group likes T3.
    fn study(shift: u64) -> (Vec<String>, Vec<Observer>, Vec<Choice>) {
        let items = ["T3-A4", "T3-A5", "T4-A4", "T4-A5"].map(String::from).to_vec();
        let observers = (0..8_usize).map(|place| Observer {
            code: format!("P{place}"),
            traits: BTreeMap::from([
                ("experience".into(), if place < 4 { "naive" } else { "expert" }.into()),
                ("age".into(), place.to_string()),
            ]),
        });
        let mut choices = Vec::new();
        for observer in 0..8 {
            for a in 0..4 {
                for b in a + 1..4 {
                    let noise = (observer * 7 + a * 3 + b * 5) as u64 % 4;
                    let likes_a = noise + if observer < 4 || b < 2 { 0 } else { shift } >= 2;
                    let chosen = Some(if likes_a { Side::A } else { Side::B });
                    choices.push(Choice { observer, a, b, chosen, first: Some(Side::A) });
                }
            }
        }
        (items, observers.collect(), choices)
    }

    fn experience(study: &(Vec<String>, Vec<Observer>, Vec<Choice>)) -> GroupComparison {
        let found = observer_groups(&study.0, &study.1, &study.2);
        found.into_iter().find(|t| t.name == "experience").unwrap().comparison.unwrap()
    }

    #[test]
    fn a_difference_is_found_where_there_is_one() {
        let found = experience(&study(4));
        let overall = found.overall.unwrap();
        assert!((overall.exact, overall.groupings) == (true, 70), "{overall:?}");
        // No other of the 70 groupings but the mirrored one is as far apart.
        assert!((overall.p.value() - 2.0 / 70.0).abs() < 1e-12, "{overall:?}");
        assert_eq!(found.groups[0], Group { value: "expert".into(), observers: 4 });
        assert_eq!((found.shares.len(), found.pairs.len()), (8, 6));
        assert!(experience(&study(0)).overall.unwrap().p.value() > 0.2);
    }

    #[test]
    fn a_pair_with_too_many_tables_leaves_the_others_tested() {
        let few = vec![[9, 10], [1, 10], [5, 10], [5, 10]];
        let pairs = BTreeMap::from([((0, 1), vec![[500, 1000]; 4]), ((0, 2), few)]);
        let found = of_pairs(&["A", "B", "C"].map(String::from), pairs);
        assert!(found[0].p.as_ref().unwrap_err().starts_with("Fisher's exact test"));
        assert_eq!((found[0].p_holm, found[1].p_holm), (None, found[1].p.clone().ok()));
        assert!(found[1].p_holm.is_some());
    }

    #[test]
    fn traits_that_make_no_groups_are_refused_in_words() {
        let (items, mut observers, choices) = study(0);
        for (place, observer) in observers.iter_mut().enumerate() {
            observer.traits.insert("study".into(), "same".into());
            observer.traits.insert("eye".into(), if place == 3 { "left" } else { "right" }.into());
        }
        let found = observer_groups(&items, &observers, &choices);
        let reasons: Vec<(&str, &str)> = found
            .iter()
            .filter_map(|t| Some((t.name.as_str(), t.comparison.as_ref().err()?.as_str())))
            .collect();
        assert_eq!(
            reasons,
            [
                ("age", "8 groups are more than the 6 compared"),
                ("eye", "only one observer is of the group `left`"),
                ("study", "all observers are of one group"),
            ]
        );
    }

    #[test]
    fn neither_the_order_of_observers_nor_the_sides_matter() {
        let straight = study(1);
        let (items, mut observers, mut choices) = straight.clone();
        observers.reverse();
        for choice in &mut choices {
            choice.observer = 7 - choice.observer;
            (choice.a, choice.b) = (choice.b, choice.a);
            (choice.chosen, choice.first) =
                (choice.chosen.map(Side::other), choice.first.map(Side::other));
        }
        let (turned, straight) = (experience(&(items, observers, choices)), experience(&straight));
        assert_eq!(turned.overall, straight.overall);
        assert_eq!(turned.pairs, straight.pairs);
        for (turned, straight) in turned.shares.iter().zip(&straight.shares) {
            assert_eq!((&turned.proportions, turned.p), (&straight.proportions, straight.p));
        }
    }
}
