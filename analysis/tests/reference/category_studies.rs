//! Matching and same/different studies made up here: what must not change their results, and words where
//! there are no numbers.

use crate::close;
use crate::made_up::{csv_text, study};
use serde_json::Value;
use shutterlab_analysis::categories::discrimination::DPrime;
use shutterlab_analysis::categories::resampled::Resampled;
use shutterlab_analysis::categories::trials::{MatchingTrial, Trials};
use shutterlab_analysis::categories::{
    Matching, SameDifferent, analyze_matching, analyze_same_different, section,
};
use shutterlab_analysis::input::responses;
use shutterlab_analysis::report::section::{Cell, Section};
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::{Answer, Side, TrialKind};

const LEVELS: [&str; 5] =
    ["M3-S2-T1-A5", "M3-S2-T2-A5", "M3-S2-T3-A5", "M3-S2-T4-A5", "M3-S2-T5-A5"];

/// Every pair of levels matched once by each observer, levels further apart more surely; of the two first
/// trials one is practice and one to catch.
fn matching_rows(observers: u32) -> Vec<Response> {
    let mut rows = study(observers, &LEVELS, TrialKind::Real);
    for row in &mut rows {
        row.task = Task::Matching;
        if row.trial == 2 {
            row.kind = TrialKind::Catch;
        }
        let correct = row.selected.as_ref() == Some(&row.stimulus_a);
        let reference = if row.trial % 2 == 0 { Side::A } else { Side::B };
        set_matching(row, reference, correct);
    }
    rows
}

fn set_matching(row: &mut Response, reference: Side, correct: bool) {
    let chosen = if correct { reference } else { reference.other() };
    let id = |side| if side == Side::A { row.stimulus_a.clone() } else { row.stimulus_b.clone() };
    (row.reference, row.selected) = (Some(id(reference)), Some(id(chosen)));
    row.answer = if chosen == row.first { Answer::First } else { Answer::Second };
    row.correct = Some(correct);
}

/// The first level is the ground truth of the others; every other pair becomes two of it.
fn same_different_rows(observers: u32) -> Vec<Response> {
    let mut rows = study(observers, &LEVELS, TrialKind::Real);
    for row in &mut rows {
        row.task = Task::SameDifferent;
        let different = row.stimulus_a == LEVELS[0];
        let usual = row.selected.as_ref() == Some(&row.stimulus_a);
        if !different {
            (row.stimulus_a, row.stimulus_b) = (LEVELS[0].into(), LEVELS[0].into());
        }
        row.answer = if usual == different { Answer::Different } else { Answer::Same };
        row.correct = Some(usual);
        (row.reference, row.selected) = (Some(LEVELS[0].into()), None);
    }
    rows
}

fn matching_trials(rows: &[Response]) -> Trials<MatchingTrial> {
    Trials::matching(&responses::parse(&csv_text(rows), "m.csv").unwrap()).unwrap()
}

fn matching(rows: &[Response]) -> Matching {
    analyze_matching(&matching_trials(rows), 0.05).unwrap()
}

fn same_different(rows: &[Response]) -> SameDifferent {
    let responses = responses::parse(&csv_text(rows), "s.csv").unwrap();
    analyze_same_different(&Trials::same_different(&responses).unwrap(), 0.05).unwrap()
}

#[test]
fn responses_become_trials() {
    let trials = matching_trials(&matching_rows(3));
    assert_eq!(trials.levels, ["T1", "T2", "T3", "T4", "T5"]);
    assert!(trials.ordered && !trials.simulated);
    assert_eq!((trials.trials.len(), trials.catch.len(), trials.observers.len()), (30, 3, 3));
    assert!(trials.trials.iter().all(|trial| trial.since_onset_s == trial.response_time_s + 4.0));

    let mut rows = same_different_rows(3);
    // An identical pair to catch tells of false alarms; what is practice does not.
    rows[1].kind = TrialKind::Catch;
    (rows[1].stimulus_b, rows[1].answer) = (LEVELS[0].into(), Answer::Same);
    let responses = responses::parse(&csv_text(&rows), "s.csv").unwrap();
    let trials = Trials::same_different(&responses).unwrap();
    assert_eq!(trials.trials.len(), 31);
    let wrong_task = Trials::matching(&responses).unwrap_err().to_string();
    assert!(wrong_task.contains("answers to matching are needed"), "{wrong_task}");
}

#[test]
fn a_whole_matching_study_gives_everything() {
    let found = matching(&matching_rows(16));
    assert_eq!(
        (found.accuracy.pooled.trials, found.pairs.len(), found.per_observer.len()),
        (160, 10, 16)
    );
    assert!(found.accuracy.pooled.percent > 60.0);
    let (row_sums, cells): (u64, u64) = (
        found.chosen.iter().flatten().sum(),
        found.cells.iter().map(|cell| cell.accuracy.trials).sum(),
    );
    assert_eq!((row_sums, cells), (160, 160));
    let sides = found.sides.as_ref().unwrap();
    assert_eq!(sides.accuracy.correct, found.accuracy.pooled.correct);
    assert!(found.d_prime.as_ref().unwrap().bootstrap_95.is_ok());
    assert!(found.accuracy.robust_95.is_ok() && found.merged.is_ok());
    complete(&serde_json::to_value(&found).unwrap(), "matching");
    whole(&section::matching(&Ok(found)));
}

#[test]
fn neither_names_of_observers_nor_the_order_of_rows_matter() {
    let rows = matching_rows(9);
    let straight = matching(&rows);
    let mut renamed = rows;
    renamed.reverse();
    for row in &mut renamed {
        let number: u32 = row.subject.to_string()[1..].parse().unwrap();
        row.subject = format!("P{:02}", 50 - number).parse().unwrap();
    }
    let mut renamed = matching(&renamed);
    renamed.per_observer.reverse();
    for (now, before) in renamed.per_observer.iter_mut().zip(&straight.per_observer) {
        now.observer.clone_from(&before.observer);
    }
    assert_eq!(renamed, straight);
}

#[test]
fn names_of_levels_change_only_names() {
    let rows = matching_rows(12);
    let straight = matching(&rows);
    let mut renamed = rows;
    let rename = |id: &mut String| {
        if let Some(place) = LEVELS.iter().position(|level| level == id) {
            *id = LEVELS[4 - place].into();
        }
    };
    for row in &mut renamed {
        rename(&mut row.stimulus_a);
        rename(&mut row.stimulus_b);
        row.selected.iter_mut().for_each(rename);
        row.reference.iter_mut().for_each(rename);
    }
    let mut turned = matching(&renamed);
    let back = |name: &mut String| {
        let level: usize = name[1..].parse().unwrap();
        *name = format!("T{}", 6 - level);
    };
    for pair in &mut turned.pairs {
        pair.levels.iter_mut().for_each(back);
        pair.levels.reverse();
    }
    turned.pairs.sort_by_key(|pair| pair.levels.clone());
    assert_eq!(turned.pairs, straight.pairs);
    assert_eq!(turned.accuracy, straight.accuracy);
    let mut groups = turned.merged.unwrap().groups;
    groups.reverse();
    groups.iter_mut().for_each(|group| *group = group.iter().rev().map(|i| 4 - i).collect());
    assert_eq!(groups, straight.merged.unwrap().groups);
}

#[test]
fn swapping_the_candidates_changes_only_sides() {
    let mut rows = matching_rows(12);
    let straight = matching(&rows);
    for row in &mut rows {
        row.first = row.first.other();
        row.answer = if row.answer == Answer::First { Answer::Second } else { Answer::First };
    }
    let swapped = matching(&rows);
    assert_eq!(swapped.pairs, straight.pairs);
    assert_eq!(swapped.cells, straight.cells);
    assert_eq!(swapped.accuracy, straight.accuracy);
    let d = |study: &Matching| study.d_prime.as_ref().unwrap().estimate.clone();
    let (a, b) = (d(&straight), d(&swapped));
    close(a.d_prime, b.d_prime, 1e-12, "d′");
    close(a.criterion, -b.criterion, 1e-12, "criterion");
    for end in [0, 1] {
        close(a.interval_95[end].unwrap(), b.interval_95[end].unwrap(), 1e-9, "interval");
    }
}

#[test]
fn one_observer_gets_words() {
    let found = matching(&matching_rows(1));
    assert!(found.accuracy.robust_95.as_ref().unwrap_err().contains("one observer"));
    assert!(found.accuracy.heterogeneity.is_err() && found.accuracy.bootstrap_95.is_err());
    assert!(found.comparisons.iter().all(|comparison| comparison.test.is_err()));
    complete(&serde_json::to_value(&found).unwrap(), "one observer");
    whole(&section::matching(&Ok(found)));
}

#[test]
fn answers_all_alike_get_words() {
    let mut rows = matching_rows(6);
    for row in &mut rows {
        // Always the first candidate.
        let reference =
            if row.reference.as_ref() == Some(&row.stimulus_a) { Side::A } else { Side::B };
        set_matching(row, reference, reference == row.first);
    }
    let found = matching(&rows);
    let sides = found.sides.as_ref().unwrap();
    assert!(sides.association.as_ref().unwrap_err().contains("two that were answered"));
    assert!(found.d_prime.as_ref().unwrap_err().contains("all answers were alike"));
    assert!(found.per_observer.iter().all(|one| one.runs.as_ref().unwrap_err().contains("alike")));
    complete(&serde_json::to_value(&found).unwrap(), "one side");

    for row in &mut rows {
        let reference = if row.trial % 2 == 0 { Side::A } else { Side::B };
        set_matching(row, reference, true);
    }
    let found = matching(&rows);
    assert!(found.accuracy.robust_95.as_ref().unwrap_err().contains("all answers are right"));
    let DPrime { correction, interval_95, .. } = &found.d_prime.as_ref().unwrap().estimate;
    assert!(correction.unwrap().starts_with("log-linear"));
    assert!(interval_95[0].unwrap() > 1.0 && interval_95[1].is_none());
    complete(&serde_json::to_value(&found).unwrap(), "all right");
    whole(&section::matching(&Ok(found)));
}

#[test]
fn missing_pairs_and_unequal_repetitions_are_taken_as_they_are() {
    let mut rows = matching_rows(8);
    rows.retain(|row| (&*row.stimulus_a, &*row.stimulus_b) != (LEVELS[1], LEVELS[2]));
    rows.retain(|row| row.subject.to_string() != "P03" || row.trial < 7);
    let found = matching(&rows);
    assert_eq!(found.pairs.len(), 9);
    let merged = found.merged.as_ref().unwrap();
    assert!(merged.groups.iter().all(|group| !(group.contains(&1) && group.contains(&2))));
    complete(&serde_json::to_value(&found).unwrap(), "missing pair");
}

#[test]
fn undecided_answers_count_nowhere() {
    let mut rows = matching_rows(4);
    for row in rows.iter_mut().filter(|row| row.trial > 2) {
        (row.answer, row.selected, row.correct) = (Answer::NotSure, None, Some(false));
    }
    let trials = matching_trials(&rows);
    assert_eq!(analyze_matching(&trials, 0.05).unwrap_err(), "there are no answers");
    let said = section::matching(&analyze_matching(&trials, 0.05));
    assert_eq!(said.sentences, ["Not known: there are no answers."]);
}

#[test]
fn a_trial_that_cannot_be_is_refused() {
    let mut trials = matching_trials(&matching_rows(2));
    trials.trials[0].candidates = [0, 0];
    assert!(analyze_matching(&trials, 0.05).unwrap_err().contains("no matching trial"));
    trials.trials.clear();
    assert!(analyze_matching(&trials, 0.05).is_err());
}

#[test]
fn a_whole_same_different_study_gives_everything() {
    let found = same_different(&same_different_rows(16));
    assert_eq!(found.candidates.len(), 4);
    let counts = found.d_prime.as_ref().unwrap().estimate.counts;
    assert_eq!((counts.signals, counts.noises), (64, 96));
    assert!(found.candidates.iter().all(|c| c.counts.noises == 96 && c.d_prime.is_ok()));
    let d = |r: &Resampled<DPrime>| r.estimate.d_prime;
    let (differencing, independent) = (
        found.d_prime.as_ref().map(d).unwrap(),
        found.d_prime_independent.as_ref().map(d).unwrap(),
    );
    assert!(differencing > independent && independent > 0.0);
    complete(&serde_json::to_value(&found).unwrap(), "same/different");
    whole(&section::same_different(&Ok(found)));
}

#[test]
fn accuracy_is_tested_where_always_one_answer_is_right_in_half() {
    // Four different pairs and six identical ones per observer; then four of each.
    let mut rows = same_different_rows(6);
    let found = same_different(&rows).accuracy.pooled;
    assert_eq!(found.p_above_chance, None);
    assert!(found.p_above_chance_reason.is_some_and(|reason| reason.contains("one answer")));
    let mut seen = std::collections::BTreeMap::<_, u32>::new();
    rows.retain(|row| {
        let seen = seen.entry((row.subject.to_string(), row.stimulus_b == LEVELS[0])).or_default();
        *seen += 1;
        *seen <= 4
    });
    assert!(same_different(&rows).accuracy.pooled.p_above_chance.is_some());
}

#[test]
fn without_identical_pairs_there_is_no_sensitivity() {
    let mut rows = same_different_rows(6);
    rows.retain(|row| row.stimulus_a != row.stimulus_b);
    let found = same_different(&rows);
    let reason = found.d_prime.as_ref().unwrap_err();
    assert!(reason.contains("no pairs of identical stimuli"), "{reason}");
    assert!(found.candidates.iter().all(|c| c.told_apart.is_none() && c.d_prime.is_err()));
    complete(&serde_json::to_value(&found).unwrap(), "no identical pairs");
    let section = section::same_different(&Ok(found));
    assert!(section.sentences.iter().any(|line| line.contains("no pairs of identical stimuli")));
    whole(&section);
}

#[test]
fn names_of_candidates_and_observers_change_only_names_in_same_different() {
    let rows = same_different_rows(7);
    let straight = same_different(&rows);
    let mut renamed = rows;
    for row in &mut renamed {
        let number: u32 = row.subject.to_string()[1..].parse().unwrap();
        row.subject = format!("P{:02}", 60 - number).parse().unwrap();
        // The candidates T2 to T5 in the other order.
        if let Some(place) = LEVELS.iter().skip(1).position(|level| *level == row.stimulus_b) {
            row.stimulus_b = LEVELS[4 - place].into();
        }
    }
    let mut renamed = same_different(&renamed);
    renamed.candidates.reverse();
    for (now, before) in renamed.candidates.iter_mut().zip(&straight.candidates) {
        now.candidate.clone_from(&before.candidate);
    }
    assert_eq!(renamed, straight);
}

/// Asserts that every `null` is explained, but for what is empty by its description.
fn complete(value: &Value, at: &str) {
    const EMPTY: [&str; 9] = [
        "as_reference",
        "as_foil",
        "when_chosen",
        "correction",
        "median_difference_s",
        "p_holm",
        "told_apart",
        "recall",
        "precision",
    ];
    match value {
        Value::Object(map) => {
            for (name, value) in map {
                let explained = map.contains_key(&format!("{name}_reason"));
                let here = format!("{at}.{name}");
                assert!(!value.is_null() || explained || EMPTY.contains(&&**name), "{here}");
                complete(value, &here);
            }
        }
        Value::Array(values) => {
            let may_be_empty =
                ["interval_95", "recall", "precision"].iter().any(|name| at.ends_with(name));
            for value in values {
                assert!(!value.is_null() || may_be_empty, "{at}");
                complete(value, at);
            }
        }
        _ => (),
    }
}

/// Asserts that a section's tables are whole and that it says nothing that is no number.
fn whole(section: &Section) {
    for table in &section.tables {
        assert!(!table.caption.is_empty());
        for row in &table.rows {
            assert_eq!(row.len(), table.columns.len(), "{}", table.name);
            let finite = |cell: &Cell| !matches!(cell, Cell::Number(x) if !x.is_finite());
            assert!(row.iter().all(finite), "{}", table.name);
        }
    }
    let figures = section.figures.iter().map(|figure| &figure.svg);
    for text in section.sentences.iter().chain(figures) {
        assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
    }
    for method in &section.method {
        for cited in ["Clopper", "Holm", "Hautus", "Zhang", "Wilcoxon", "Fisher's (1935)"] {
            let name = cited.split('\'').next().unwrap_or(cited);
            let known = section.references.iter().any(|reference| reference.starts_with(name));
            assert!(!method.contains(cited) || known, "{cited}");
        }
    }
}
