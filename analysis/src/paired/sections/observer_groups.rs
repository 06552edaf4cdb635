//! The section on groups of observers.

use super::{FISHER, HOLM, not_known};
use crate::outcome::Outcome;
use crate::paired::observer_groups::{GroupComparison, TraitGroups};
use crate::report::labels::counted;
use crate::report::section::{Cell, Column, Kind, Section, Table, share_cells, share_columns};

/// Whether groups of observers prefer the same.
pub fn observer_groups(traits: &Outcome<Vec<TraitGroups>>) -> Section {
    let heading = "Groups of observers";
    let traits = match traits {
        Ok(traits) => traits,
        Err(reason) => return not_known(heading, reason),
    };
    let mut sentences: Vec<String> = traits
        .iter()
        .flat_map(|group| match &group.comparison {
            Ok(comparison) => compared(&group.name, comparison),
            Err(reason) => vec![format!("{}: not compared, {reason}", group.name)],
        })
        .collect();
    if sentences.is_empty() {
        sentences
            .push("nothing is known of the observers that would divide them into groups".into());
    }
    let known: Vec<(&str, &GroupComparison)> = traits
        .iter()
        .filter_map(|group| Some((group.name.as_str(), group.comparison.as_ref().ok()?)))
        .collect();
    let mut section = Section { heading: heading.into(), sentences, ..Section::default() };
    if known.is_empty() {
        return section;
    }
    section.tables = vec![shares(&known), pairs(&known)];
    section.method = vec![
        "The answers of one observer are not independent, so groups are compared with one value per \
         observer: the share of each stimulus (and of each level). All stimuli together, and each share, \
         are tested by permuting the observers over the groups (Fisher 1935; Pitman 1937): the statistic is \
         the sum of squares between the groups. In a single pair each observer answers once, so Fisher's \
         (1935) exact test compares the groups. Both tables are corrected by Holm (1979)."
            .into(),
    ];
    section.references = vec![
        FISHER,
        HOLM,
        "Pitman, E. J. G. (1937). Significance tests which may be applied to samples from any populations. \
         Supplement to the Journal of the Royal Statistical Society 4, 119–130.",
    ];
    section
}

fn compared(name: &str, comparison: &GroupComparison) -> Vec<String> {
    let groups: Vec<String> =
        comparison.groups.iter().map(|g| format!("{} n = {}", g.value, g.observers)).collect();
    let who = format!("{name} ({})", groups.join(", "));
    let mut sentences = vec![match &comparison.overall {
        Ok(test) => format!(
            "{who}: all stimuli together {} (permutation of the observers, {} {} groupings; no correction)",
            test.p.equation(),
            if test.exact { "exact over all" } else { "Monte Carlo over" },
            test.groupings
        ),
        Err(reason) => format!("{who}: stimuli and levels not tested, {reason}"),
    }];
    if let Ok(test) = &comparison.overall {
        if test.smallest_p.value() > 0.05 {
            sentences.push(format!(
                "{name}: with so few observers p could not be below {}",
                test.smallest_p
            ));
        }
        if test.incomplete > 0 {
            sentences.push(format!(
                "{name}: {} left out of these tests because their answers lack a stimulus or level",
                counted(test.incomplete as usize, "observer")
            ));
        }
        let differ = comparison.shares.iter().filter_map(|share| Some((share, share.p_holm?)));
        let differ: Vec<String> = differ
            .filter(|(_, p)| p.value() <= 0.05)
            .map(|(share, p)| format!("{} ({})", share.item, p.equation()))
            .collect();
        sentences.push(format!(
            "{name}: {} of {} shares of stimuli and levels have p ≤ 0.05, corrected by Holm{}",
            differ.len(),
            comparison.shares.len(),
            if differ.is_empty() { String::new() } else { format!(": {}", differ.join(", ")) }
        ));
    }
    let tested = comparison.pairs.iter().filter_map(|pair| pair.p_holm);
    sentences.push(format!(
        "{name}: {} of {} have p ≤ 0.05 (Fisher's exact test, two-sided, corrected by Holm)",
        tested.clone().filter(|p| p.value() <= 0.05).count(),
        counted(tested.count(), "pair")
    ));
    sentences.extend(comparison.pairs.iter().filter_map(|pair| {
        let reason = pair.p.as_ref().err()?;
        Some(format!("{name}: {} over {} not tested, {reason}", pair.item, pair.over))
    }));
    sentences.extend(comparison.correlations.iter().map(|correlation| {
        let [a, b] = &correlation.groups;
        match correlation.r {
            Ok(r) => format!("{name}: scores of {a} and {b} correlate with r = {r:.3}"),
            Err(ref reason) => format!("{name}: correlation of {a} and {b} not known: {reason}"),
        }
    }));
    if comparison.unknown > 0 {
        sentences.push(format!(
            "{name}: {} in no group, as their answer is not known",
            counted(comparison.unknown as usize, "observer")
        ));
    }
    sentences
}

fn first_columns() -> [Column; 2] {
    [
        Column::new("trait", "trait", Kind::Text, "What divides the observers into groups."),
        Column::new("group", "group", Kind::Text, "The group."),
    ]
}

fn test_columns(p: &str) -> [Column; 2] {
    [
        Column::new("p", "p", Kind::P, p),
        Column::new("p_holm", "p (Holm)", Kind::P, "p corrected by Holm (1979)."),
    ]
}

fn shares(traits: &[(&str, &GroupComparison)]) -> Table {
    let mut columns = first_columns().to_vec();
    columns.push(Column::new(
        "item",
        "stimulus or level",
        Kind::Text,
        "The stimulus or the level.",
    ));
    columns.push(Column::new(
        "level",
        "level",
        Kind::Flag,
        "Whether it is a level: then of all pairs that differ in its axis.",
    ));
    columns.extend(share_columns());
    columns.extend(test_columns(
        "Permutation test of the difference between the groups, one value per observer; the same for all \
         groups of a row's trait and item.",
    ));
    let mut rows = Vec::new();
    for (name, comparison) in traits {
        for share in &comparison.shares {
            for (group, proportion) in comparison.groups.iter().zip(&share.proportions) {
                let Some(proportion) = proportion else { continue };
                let mut row = vec![
                    Cell::from(*name),
                    group.value.as_str().into(),
                    share.item.as_str().into(),
                    share.level.into(),
                ];
                row.extend(share_cells(proportion));
                row.extend([share.p.into(), share.p_holm.into()]);
                rows.push(row);
            }
        }
    }
    Table {
        name: "observer-groups".into(),
        caption: "How often each group chose each stimulus and level. Intervals: 95 %; they and the tests \
                  against ½ count the answers of one observer as independent."
            .into(),
        columns,
        rows,
    }
}

fn pairs(traits: &[(&str, &GroupComparison)]) -> Table {
    let mut columns = first_columns().to_vec();
    columns.extend([
        Column::new("item", "stimulus", Kind::Text, "Id of the stimulus."),
        Column::new("over", "over", Kind::Text, "Id of the other."),
        Column::new(
            "chosen",
            "chosen",
            Kind::Integer,
            "How often the group chose item over other.",
        ),
        Column::new("trials", "of", Kind::Integer, "Number of trials."),
    ]);
    columns.extend(test_columns(
        "Fisher's exact test of group and choice, two-sided; the same for all groups of a pair.",
    ));
    let mut rows = Vec::new();
    for (name, comparison) in traits {
        for pair in &comparison.pairs {
            for (group, [chosen, trials]) in comparison.groups.iter().zip(&pair.chosen) {
                rows.push(vec![
                    Cell::from(*name),
                    group.value.as_str().into(),
                    pair.item.as_str().into(),
                    pair.over.as_str().into(),
                    (*chosen).into(),
                    (*trials).into(),
                    pair.p.as_ref().ok().copied().into(),
                    pair.p_holm.into(),
                ]);
            }
        }
    }
    Table {
        name: "observer-groups-pairs".into(),
        caption: "Choices of each group in each pair; tests corrected for the number of pairs of a trait that were tested."
            .into(),
        columns,
        rows,
    }
}
