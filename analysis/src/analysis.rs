//! The analysis of one paired-comparison experiment: everything that follows from the choices, and
//! a reason in words for everything that does not.

use crate::agreement::{Agreement, agreement};
use crate::circular_triads::{
    TriadsByChance, TriadsTest, circular_triads, consistency, max_circular_triads,
};
use crate::data_quality::DataQuality;
use crate::error::InputError;
use crate::p_value::PValue;
use crate::preference::{ItemPreference, PairPreference, per_item, per_pair};
use crate::preferences::{Judge, Judgements, Preferences, WinMatrix};
use crate::published;
use crate::score_equality::{ScoreEquality, score_equality};
use crate::score_groups::{Grouping, score_groups};
use serde::Serialize;

const NEEDS_ANSWERS: &str = "votes alone do not tell the answers to single pairs";
const NEEDS_JUDGES: &str = "a pooled matrix does not tell the answers of single observers";
const NEEDS_COMPLETE: &str = "scores can only be compared when every observer judged every pair";

/// What the choices mean. A field that does not follow from the input is none (`null` in JSON) and
/// the field of the same name with `_reason` says why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Analysis {
    /// What was analysed.
    pub source: Source,
    /// Whether the observers were simulated.
    pub simulated: Option<bool>,
    /// Why that is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated_reason: Option<String>,
    /// The stimuli, best first; stimuli with equal votes stay in the order of the input.
    pub items: Vec<String>,
    /// How often each was chosen over another, in the order of `items`.
    pub votes: Vec<u64>,
    /// Number n of observers, that is of complete sets of pairs.
    pub observers: u64,
    /// Number of trials.
    pub trials: u64,
    /// Groups of stimuli that the scores do not tell apart.
    pub grouping: Option<Grouping>,
    /// Why there are no groups.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grouping_reason: Option<String>,
    /// Overall test of equality of the scores.
    pub score_equality: Option<ScoreEquality>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub score_equality_reason: Option<String>,
    /// Circular triads and ζ.
    pub consistency: Option<Consistency>,
    /// Why there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub consistency_reason: Option<String>,
    /// Kendall's u.
    pub agreement: Option<Agreement>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreement_reason: Option<String>,
    /// How often each stimulus was chosen, in the order of `items`.
    pub preference: Vec<ItemPreference>,
    /// How often one of each pair was chosen; pairs never judged are left out.
    pub pairs: Option<Vec<PairPreference>>,
    /// How often the row was chosen over the column, both in the order of `items`.
    pub matrix: Option<Vec<Vec<u64>>>,
    /// Why there are no `pairs` and no `matrix`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pairs_reason: Option<String>,
    /// Where the answers came from and how they were given.
    pub data_quality: Option<DataQuality>,
    /// Why that is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data_quality_reason: Option<String>,
    /// What a reader of the results has to know.
    pub notes: Vec<String>,
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

/// Circular triads and the coefficient of consistency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Consistency {
    /// Circular triads of all observers together.
    pub circular_triads: u64,
    /// The most there could be.
    pub max_circular_triads: u64,
    /// Pooled ζ: 1 − `circular_triads` / `max_circular_triads`, the one ζ that studies report.
    pub zeta: f64,
    /// Mean of the observers' ζ; equal to the pooled one, as all judged the same pairs.
    pub zeta_mean: f64,
    /// Probability of so few circular triads by chance, over all observers.
    pub p: PValue,
    /// Whether `p` is exact; else it is the upper tail of `chi2`, with continuity correction.
    pub exact: bool,
    /// χ² where `p` is not exact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi2: Option<f64>,
    /// Its degrees of freedom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub df: Option<f64>,
    /// Which tail every p of this object is.
    pub tail: &'static str,
    /// Each observer alone.
    pub per_observer: Vec<ObserverConsistency>,
    /// Why no single observer can be shown to be more consistent than chance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_observer_not_testable: Option<String>,
}

/// One observer's circular triads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObserverConsistency {
    /// The participant's code.
    pub subject: String,
    /// The participant's sitting.
    pub session: u32,
    /// Which of the sitting's sets of pairs.
    pub repetition: u32,
    /// Circular triads.
    pub circular_triads: u64,
    /// Kendall's ζ.
    pub zeta: f64,
    /// Probability of so few circular triads by chance.
    pub p: PValue,
    /// Whether `p` is exact; else it is the upper tail of `chi2`, with continuity correction.
    pub exact: bool,
    /// χ² where `p` is not exact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi2: Option<f64>,
    /// Its degrees of freedom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub df: Option<f64>,
}

/// Analyses `preferences`, grouping at the level of significance `alpha`.
///
/// # Errors
/// `alpha` is not between 0 and 1.
pub fn analyze(preferences: &Preferences, alpha: f64) -> Result<Analysis, InputError> {
    if !(alpha > 0.0 && alpha < 1.0) {
        return Err(InputError::Alpha(alpha));
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
    let wins = pooled.map(|wins| wins.reordered(&order));
    let trials_per_item = match &wins {
        Some(wins) => wins.trials_per_item(),
        None => vec![observers * (t as u64 - 1); t],
    };
    let complete = trials_per_item.iter().all(|trials| *trials == observers * (t as u64 - 1));
    let compared = |reason: &str| if complete { Ok(()) } else { Err(reason.to_string()) };

    let (grouping, grouping_reason) =
        split(compared(NEEDS_COMPLETE).map(|()| score_groups(&items, &votes, observers, alpha)));
    let (score_equality, score_equality_reason) =
        split(compared(NEEDS_COMPLETE).map(|()| score_equality(&votes, observers)));
    let (consistency, consistency_reason) = split(match &preferences.judgements {
        Judgements::Judges(judges) => consistency_of(judges, t, alpha),
        Judgements::Pooled { .. } => Err(NEEDS_JUDGES.into()),
        Judgements::Votes { .. } => Err(NEEDS_ANSWERS.into()),
    });
    let known = wins.as_ref().ok_or_else(|| NEEDS_ANSWERS.to_string());
    let (agreement, agreement_reason) = split(known.clone().and_then(agreement));
    let (pairs, pairs_reason) = split(known.map(|wins| per_pair(&items, wins)));
    let preference = per_item(&items, &votes, &trials_per_item);
    let source = match &preferences.judgements {
        Judgements::Judges(_) => Source::Responses,
        Judgements::Pooled { .. } => Source::Matrix,
        Judgements::Votes { .. } => Source::Votes,
    };
    let data_quality = preferences.data_quality.clone();
    let unknown =
        |what: &str| data_quality.is_none().then(|| format!("only the responses tell {what}"));
    let mut notes = preferences.notes.clone();
    notes.extend(notes_on(preferences, pairs.as_ref().map_or(0, Vec::len)));
    Ok(Analysis {
        source,
        simulated: data_quality.as_ref().map(|data| data.simulated),
        simulated_reason: unknown("whether the observers were simulated"),
        items,
        trials: trials_per_item.iter().sum::<u64>() / 2,
        votes,
        observers,
        grouping,
        grouping_reason,
        score_equality,
        score_equality_reason,
        consistency,
        consistency_reason,
        agreement,
        agreement_reason,
        preference,
        pairs,
        matrix: wins.map(|wins| wins.rows()),
        pairs_reason,
        data_quality_reason: unknown("how the answers were given"),
        data_quality,
        notes,
    })
}

fn consistency_of(judges: &[Judge], t: usize, alpha: f64) -> Result<Consistency, String> {
    if t < 3 {
        return Err("circular triads need at least 3 stimuli".into());
    }
    let chance = TriadsByChance::new(t);
    let triads: Vec<u64> = judges.iter().map(|j| circular_triads(&j.wins.scores())).collect();
    let TriadsTest { p, chi_square } = chance.test_pooled(&triads);
    let per_observer: Vec<ObserverConsistency> = judges
        .iter()
        .zip(&triads)
        .map(|(judge, d)| {
            let TriadsTest { p, chi_square } = chance.test(*d);
            ObserverConsistency {
                subject: judge.subject.clone(),
                session: judge.session,
                repetition: judge.repetition,
                circular_triads: *d,
                zeta: consistency(*d, 1, t),
                p,
                exact: chi_square.is_none(),
                chi2: chi_square.map(|(chi2, _)| chi2),
                df: chi_square.map(|(_, df)| df),
            }
        })
        .collect();
    let total = triads.iter().sum();
    let n = judges.len() as u64;
    let smallest = chance.test(0).p;
    let per_observer_not_testable = (smallest.value() > alpha).then(|| {
        format!(
            "not testable: with t = {t} even an observer without any circular triad has p = \
             {smallest}, above α = {alpha}"
        )
    });
    Ok(Consistency {
        circular_triads: total,
        max_circular_triads: n * max_circular_triads(t),
        zeta: consistency(total, n, t),
        zeta_mean: per_observer.iter().map(|o| o.zeta).sum::<f64>() / n as f64,
        p,
        exact: chi_square.is_none(),
        chi2: chi_square.map(|(chi2, _)| chi2),
        df: chi_square.map(|(_, df)| df),
        tail: "lower tail of the number of circular triads",
        per_observer,
        per_observer_not_testable,
    })
}

/// What holds for every result of this kind and is easily read over.
fn notes_on(preferences: &Preferences, pairs: usize) -> Vec<String> {
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
    let tests = match pairs {
        0 => format!("{} stimuli", preferences.items.len()),
        _ => format!("{} stimuli and {pairs} pairs", preferences.items.len()),
    };
    notes.push(format!(
        "The preference tables hold tests of {tests}; their p-values are not corrected for their \
         number, and the answers of one observer about a stimulus are counted as independent."
    ));
    notes
}

fn split<T>(result: Result<T, String>) -> (Option<T>, Option<String>) {
    match result {
        Ok(value) => (Some(value), None),
        Err(reason) => (None, Some(reason)),
    }
}
