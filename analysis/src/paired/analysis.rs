//! The analysis of one paired-comparison experiment: everything that follows from the choices, and
//! a reason in words for everything that does not.

use super::agreement::{Agreement, agreement};
use super::clustered::{ClusteredPreference, by_item, by_level};
use super::consistency::{Consistency, consistency_of};
use super::equivalence::{DEFAULT_MARGIN, PairEquivalence, equivalence_within_groups};
use super::friedman::{Friedman, friedman};
use super::level_check::{LevelCheck, level_check};
use super::levels::{Levels, levels};
use super::observer_groups::{TraitGroups, observer_groups};
use super::order_effects::{OrderEffects, order_effects};
use super::preference::{ItemPreference, PairPreference, per_item, per_pair};
use super::score_equality::{ScoreEquality, score_equality};
use super::score_groups::{Grouping, score_groups};
use super::transitivity::{Transitivity, transitivity};
use crate::analysis::SEED;
use crate::error::InputError;
use crate::input::data_quality::DataQuality;
use crate::input::preferences::{Judgements, Preferences, WinMatrix};
use crate::outcome::{Outcome, serialize_outcomes};
use crate::replication::published;
use crate::scaling::study::{Scaling, scaling};
use serde::Serialize;

/// Why there is no check of the level.
pub(super) const NOT_ASKED: &str = "not asked for";
const NEEDS_ANSWERS: &str = "votes alone do not tell the answers to single pairs";
const NEEDS_JUDGES: &str = "a pooled matrix does not tell the answers of single observers";
const NEEDS_EVERY_PAIR: &str = "observers who chose in every pair of stimuli are needed";
const NEEDS_COMPLETE: &str = "scores can only be compared when every observer judged every pair";

/// What the choices mean. In JSON a field that does not follow from the input is `null`, and the field of
/// the same name with `_reason` says why.
#[derive(Clone, Debug, PartialEq)]
pub struct PairedComparison {
    /// What was analysed.
    pub source: Source,
    /// Whether the observers were simulated.
    pub simulated: Outcome<bool>,
    /// The stimuli, best first; stimuli with equal votes stay in the order of the input.
    pub items: Vec<String>,
    /// How often each was chosen over another, in the order of `items`.
    pub votes: Vec<u64>,
    /// Number n of observers, that is of complete sets of pairs.
    pub observers: u64,
    /// Number of trials.
    pub trials: u64,
    /// Groups of stimuli that the scores do not tell apart.
    pub grouping: Outcome<Grouping>,
    /// Monte Carlo check of the level of the grouping, on request.
    pub level_check: Outcome<LevelCheck>,
    /// Overall test of equality of the scores.
    pub score_equality: Outcome<ScoreEquality>,
    /// Friedman's test and Kendall's W on the observers' scores.
    pub friedman: Outcome<Friedman>,
    /// Circular triads and ζ.
    pub consistency: Outcome<Consistency>,
    /// Kendall's u.
    pub agreement: Outcome<Agreement>,
    /// Violations of stochastic transitivity by the pooled choices.
    pub transitivity: Outcome<Transitivity>,
    /// How often each stimulus was chosen, in the order of `items`.
    pub preference: Vec<ItemPreference>,
    /// How often one of each pair was chosen; pairs never judged are left out.
    pub pairs: Outcome<Vec<PairPreference>>,
    /// How often the row was chosen over the column, both in the order of `items`.
    pub matrix: Outcome<Vec<Vec<u64>>>,
    /// Preferences between the levels of each axis of the stimuli.
    pub levels: Outcome<Levels>,
    /// Whether pairs of one group are interchangeable within a margin.
    pub equivalence: Outcome<Vec<PairEquivalence>>,
    /// Scale values.
    pub scaling: Outcome<Scaling>,
    /// Preferences between stimuli with the observers as clusters.
    pub clustered_items: Outcome<ClusteredPreference>,
    /// Preferences between levels with the observers as clusters.
    pub clustered_levels: Outcome<ClusteredPreference>,
    /// What the order within a trial did.
    pub order_effects: Outcome<OrderEffects>,
    /// Groups of observers compared, by what is known of them.
    pub observer_groups: Outcome<Vec<TraitGroups>>,
    /// Where the answers came from and how they were given.
    pub data_quality: Outcome<DataQuality>,
    /// What a reader of the results has to know.
    pub notes: Vec<String>,
}

serialize_outcomes!(
    PairedComparison,
    [source, items, votes, observers, trials, preference, notes],
    [
        simulated,
        grouping,
        level_check,
        score_equality,
        friedman,
        consistency,
        agreement,
        transitivity,
        pairs,
        matrix,
        levels,
        equivalence,
        scaling,
        clustered_items,
        clustered_levels,
        order_effects,
        observer_groups,
        data_quality
    ]
);

/// What an analysis is asked for beyond the answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Level of significance of the groups.
    pub alpha: f64,
    /// Half width of the range of preferences around ½ that count as equivalent.
    pub margin: f64,
    /// Number of simulated studies for a Monte Carlo check of the level; none for no check.
    pub level_check: Option<u64>,
}

impl From<f64> for Options {
    /// At the level `alpha`: a margin of 0.1, no check.
    fn from(alpha: f64) -> Self {
        Self { alpha, margin: DEFAULT_MARGIN, level_check: None }
    }
}

/// What was analysed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// The answers to single trials.
    Responses,
    /// A preference matrix of all observers together.
    Matrix,
    /// A table of votes.
    Votes,
}

/// Analyses `preferences`. Random draws (bootstrap, permutation, check of the level) are the same every
/// time.
///
/// # Errors
/// `alpha` is not between 0 and 1, or `margin` not between 0 and ½.
pub fn analyze(
    preferences: &Preferences,
    options: impl Into<Options>,
) -> Result<PairedComparison, InputError> {
    let Options { alpha, margin, level_check: studies } = options.into();
    if !(alpha > 0.0 && alpha < 1.0) {
        return Err(InputError::Alpha(alpha));
    }
    if !(margin > 0.0 && margin < 0.5) {
        return Err(InputError::Margin(margin));
    }
    let t = preferences.items.len();
    let observers = preferences.observers();
    let pooled = preferences.pooled();
    let scores = match &preferences.judgements {
        Judgements::Votes { votes, .. } => votes.clone(),
        _ => pooled.as_ref().map_or_else(Vec::new, WinMatrix::scores),
    };
    let mut order: Vec<usize> = (0..t).collect();
    order.sort_by_key(|i| std::cmp::Reverse(scores[*i]));
    let items: Vec<String> = order.iter().map(|i| preferences.items[*i].clone()).collect();
    let votes: Vec<u64> = order.iter().map(|i| scores[*i]).collect();
    let wins = pooled.map(|wins| wins.reordered(&order)).ok_or_else(|| NEEDS_ANSWERS.to_string());
    let trials_per_item = match &wins {
        Ok(wins) => wins.trials_per_item(),
        Err(_) => vec![observers * (t as u64 - 1); t],
    };
    let complete = trials_per_item.iter().all(|trials| *trials == observers * (t as u64 - 1));
    let compared = || if complete { Ok(()) } else { Err(NEEDS_COMPLETE.to_string()) };
    let complete_judges = match &preferences.judgements {
        Judgements::Judges(judges) if complete => Ok(judges.as_slice()),
        Judgements::Judges(_) => Err(NEEDS_EVERY_PAIR),
        Judgements::Pooled { .. } => Err(NEEDS_JUDGES),
        Judgements::Votes { .. } => Err(NEEDS_ANSWERS),
    }
    .map_err(str::to_string);
    let grouping = compared().map(|()| score_groups(&items, &votes, observers, alpha));
    let answers = match preferences.choices.is_empty() {
        true => Err("only the answers to single trials tell".to_string()),
        false => Ok((&preferences.items, &preferences.observers, &preferences.choices)),
    };
    let pairs = wins.as_ref().map(|wins| per_pair(&items, wins)).map_err(String::clone);
    let data_quality = preferences.data_quality.clone();
    let unknown = |what: &str| format!("only the responses tell {what}");
    let mut notes = preferences.notes.clone();
    notes.extend(notes_on(preferences));
    Ok(PairedComparison {
        source: match &preferences.judgements {
            Judgements::Judges(_) => Source::Responses,
            Judgements::Pooled { .. } => Source::Matrix,
            Judgements::Votes { .. } => Source::Votes,
        },
        simulated: preferences
            .simulated
            .ok_or_else(|| unknown("whether the observers were simulated")),
        trials: trials_per_item.iter().sum::<u64>() / 2,
        observers,
        level_check: compared().and_then(|()| match studies {
            Some(studies) => level_check(observers, t, alpha, 0.0, studies, SEED),
            None => Err(NOT_ASKED.into()),
        }),
        score_equality: compared().map(|()| score_equality(&votes, observers)),
        friedman: complete_judges.clone().and_then(|judges| {
            friedman(&judges.iter().map(|judge| judge.wins.scores()).collect::<Vec<_>>())
        }),
        consistency: complete_judges.and_then(|judges| consistency_of(judges, t, alpha)),
        transitivity: wins.clone().and_then(|wins| transitivity(&wins)),
        levels: wins.clone().and_then(|wins| levels(&items, &wins)),
        equivalence: match (&wins, &grouping) {
            (Ok(wins), Ok(grouping)) => {
                equivalence_within_groups(&items, wins, &grouping.groups, margin, alpha)
            }
            (Err(reason), _) | (_, Err(reason)) => Err(reason.clone()),
        },
        scaling: scaling(preferences, SEED),
        clustered_items: answers.clone().and_then(|(items, _, choices)| by_item(items, choices)),
        clustered_levels: answers.clone().and_then(|(items, _, choices)| by_level(items, choices)),
        order_effects: answers
            .clone()
            .and_then(|(items, observers, choices)| order_effects(items, observers, choices)),
        observer_groups: answers
            .map(|(items, observers, choices)| observer_groups(items, observers, choices)),
        grouping,
        agreement: wins.clone().and_then(|wins| agreement(&wins)),
        preference: per_item(&items, &votes, &trials_per_item),
        pairs,
        matrix: wins.map(|wins| wins.rows()),
        data_quality: data_quality.ok_or_else(|| unknown("how the answers were given")),
        items,
        votes,
        notes,
    })
}

/// What holds for every result of this kind and is easily read over.
fn notes_on(preferences: &Preferences) -> Vec<String> {
    let mut notes = Vec::new();
    let observers = preferences.observers();
    if observers < 5 {
        notes.push(format!(
            "n = {observers}: the groups and the tests by χ² rest on large-sample distributions."
        ));
    }
    notes.extend(published::repeated_by(preferences).into_iter().flat_map(|t| t.remarks()));
    if let Some(subjects) = preferences.data_quality.as_ref().map(|data| data.subjects)
        && subjects < observers
    {
        notes.push(format!(
            "n = {observers} complete sets come from {subjects} subjects. Each set is counted as an \
             observer, but sets of one person are not independent: p-values that count them so \
             are too small."
        ));
    }
    notes.push(
        "Stimuli of one group are not shown to be equal: their scores only do not differ \
         significantly."
            .into(),
    );
    notes.push(
        "The preference tables count the answers of one observer about a stimulus as independent; the model \
         with observers as clusters does not."
            .into(),
    );
    notes
}
