//! Same/different: does a candidate look the same as the ground truth (Zhang et al. 2014, Appendix A)?
//!
//! "Different" to different stimuli is a hit, to identical ones a false alarm. The false alarms of a
//! candidate are those of its own ground truth, since an observer may judge each of them by another
//! criterion.

use super::confusion::{Confusion, confusion};
use super::discrimination::{Counts, DPrime, Model, Strategy};
use super::observers::{Observers, observers};
use super::quality::{Lapses, lapses, too_fast};
use super::resampled::{Resampled, d_prime};
use super::response_times::{Comparison, Condition, Timed, compare, conditions};
use super::trials::{SameDifferentTrial, Trials};
use crate::maths::corrections::holm;
use crate::maths::fisher_exact::fisher_upper;
use crate::maths::p_value::PValue;
use crate::maths::proportion::Proportion;
use crate::outcome::{Outcome, serialize_outcomes};

/// The share of right answers of an observer who tosses a coin.
const CHANCE: f64 = 0.5;

/// Why accuracy is not tested against [`CHANCE`].
const UNBALANCED: &str = "an observer judged more pairs of one kind, identical or different, than of the \
                          other, and gets more than half of them right by always giving one answer";

/// What same/different answers say.
#[derive(Clone, Debug, PartialEq)]
pub struct SameDifferent {
    /// The levels.
    pub levels: Vec<String>,
    /// Level of significance of "told apart".
    pub alpha: f64,
    /// Whether the observers were simulated.
    pub simulated: bool,
    /// Answers "not sure", which count nowhere else.
    pub undecided: u64,
    /// Accuracy of all answers, with intervals that allow for observers who differ. It rises with the share
    /// of different pairs where observers prefer to say "different": d′ does not.
    pub accuracy: Observers,
    /// Each candidate against its ground truth, where there are answers.
    pub candidates: Vec<Candidate>,
    /// Response times by condition.
    pub response_times: Vec<Condition>,
    /// Response times compared.
    pub comparisons: Vec<Comparison>,
    /// Answers that came too soon after the beginning of the films.
    pub too_fast: u64,
    /// Identical or different pairs (row) × "the same" or "different" (column).
    pub answers: Outcome<Confusion>,
    /// d′ over all candidates by differencing.
    pub d_prime: Outcome<Resampled<DPrime>>,
    /// The same by independent observations.
    pub d_prime_independent: Outcome<Resampled<DPrime>>,
    /// Lapses in catch trials.
    pub lapses: Outcome<Lapses>,
}

serialize_outcomes!(
    SameDifferent,
    [
        levels,
        alpha,
        simulated,
        undecided,
        accuracy,
        candidates,
        response_times,
        comparisons,
        too_fast
    ],
    [answers, d_prime, d_prime_independent, lapses]
);

/// How well a candidate is told from its ground truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Level of the candidate.
    pub candidate: String,
    /// Level of the ground truth.
    pub reference: String,
    /// "Different" as an answer to the two (hits) and to the ground truth beside itself (false alarms).
    pub counts: Counts,
    /// How often the two were called different.
    pub called_different: Proportion,
    /// p by Holm's correction over the candidates that could be tested.
    pub p_holm: Option<PValue>,
    /// Whether the two were told apart: `p_holm` is at most alpha; none if that could not be tested.
    pub told_apart: Option<bool>,
    /// Fisher's exact test, upper tail: "different" is said more often to the two than to the ground truth
    /// beside itself.
    pub p: Outcome<PValue>,
    /// d′ by differencing.
    pub d_prime: Outcome<Resampled<DPrime>>,
    /// d′ by independent observations.
    pub d_prime_independent: Outcome<Resampled<DPrime>>,
}

serialize_outcomes!(
    Candidate,
    [candidate, reference, counts, called_different, p_holm, told_apart],
    [p, d_prime, d_prime_independent]
);

/// A trial that was answered.
#[derive(Clone, Copy, Debug)]
struct Answer {
    observer: usize,
    reference: usize,
    candidate: usize,
    said_different: bool,
    response_time_s: f64,
}

impl Answer {
    fn different(&self) -> bool {
        self.reference != self.candidate
    }

    fn correct(&self) -> bool {
        self.different() == self.said_different
    }
}

/// What the answers of `study` say; a candidate is told from its ground truth if calling it different as
/// often by chance has a probability of at most `alpha`, by Holm's correction for the number of candidates.
///
/// # Errors
/// In words: there are no answers, or a trial that cannot be.
pub fn analyze_same_different(
    study: &Trials<SameDifferentTrial>,
    alpha: f64,
) -> Outcome<SameDifferent> {
    let (people, levels) = (study.observers.len(), study.levels.len());
    if let Some(trial) = study
        .trials
        .iter()
        .find(|trial| trial.observer >= people || trial.reference.max(trial.candidate) >= levels)
    {
        return Err(format!("{trial:?} is no trial of these levels and observers"));
    }
    let answered = || study.trials.iter().filter_map(|trial| Some((trial, trial.said_same?)));
    let answers: Vec<Answer> = answered()
        .map(|(trial, said_same)| Answer {
            observer: trial.observer,
            reference: trial.reference,
            candidate: trial.candidate,
            said_different: !said_same,
            response_time_s: trial.response_time_s,
        })
        .collect();
    let mut right = vec![(0, 0); people];
    let mut table = vec![vec![0; 2]; 2];
    for answer in &answers {
        let (k, n) = &mut right[answer.observer];
        (*k, *n) = (*k + u64::from(answer.correct()), *n + 1);
        table[usize::from(answer.different())][usize::from(answer.said_different)] += 1;
    }
    let counts = counts(study, &answers, |_| true);
    let mut accuracy = observers(&right, CHANCE)?;
    let mut table = confusion(&table);
    if counts.iter().any(|of| of.signals != of.noises) {
        accuracy.pooled = accuracy.pooled.untested(UNBALANCED);
        table = table.map(|of| Confusion { accuracy: of.accuracy.untested(UNBALANCED), ..of });
    }
    let (response_times, comparisons) = times(&answers);
    let onsets: Vec<f64> = answered().map(|(trial, _)| trial.since_onset_s).collect();
    Ok(SameDifferent {
        levels: study.levels.clone(),
        alpha,
        simulated: study.simulated,
        undecided: (study.trials.len() - answers.len()) as u64,
        accuracy,
        candidates: candidates(study, &answers, alpha),
        response_times,
        comparisons,
        too_fast: too_fast(&onsets),
        answers: table,
        d_prime: d_prime(Model::SameDifferent(Strategy::Differencing), &counts),
        d_prime_independent: d_prime(
            Model::SameDifferent(Strategy::IndependentObservations),
            &counts,
        ),
        lapses: lapses(&study.catch, CHANCE),
    })
}

/// Each observer's hits and false alarms in the answers that are `wanted`.
fn counts(
    study: &Trials<SameDifferentTrial>,
    answers: &[Answer],
    wanted: impl Fn(&Answer) -> bool,
) -> Vec<Counts> {
    let mut counts = vec![Counts::default(); study.observers.len()];
    for answer in answers.iter().filter(|answer| wanted(answer)) {
        counts[answer.observer].add(answer.different(), answer.said_different);
    }
    counts
}

fn candidates(
    study: &Trials<SameDifferentTrial>,
    answers: &[Answer],
    alpha: f64,
) -> Vec<Candidate> {
    let mut asked: Vec<(usize, usize)> = answers
        .iter()
        .filter(|answer| answer.different())
        .map(|answer| (answer.reference, answer.candidate))
        .collect();
    asked.sort_unstable();
    asked.dedup();
    let mut candidates: Vec<Candidate> = asked
        .into_iter()
        .map(|(reference, candidate)| {
            let by = counts(study, answers, |answer| {
                answer.reference == reference && [reference, candidate].contains(&answer.candidate)
            });
            let counts = by.iter().copied().fold(Counts::default(), Counts::and);
            let of = |strategy| d_prime(Model::SameDifferent(strategy), &by);
            Candidate {
                candidate: study.levels[candidate].clone(),
                reference: study.levels[reference].clone(),
                called_different: Proportion::new(counts.hits, counts.signals),
                p_holm: None,
                told_apart: None,
                p: fisher_upper(
                    (counts.hits, counts.signals),
                    (counts.false_alarms, counts.noises),
                ),
                d_prime: of(Strategy::Differencing),
                d_prime_independent: of(Strategy::IndependentObservations),
                counts,
            }
        })
        .collect();
    let tested: Vec<f64> =
        candidates.iter().filter_map(|c| Some(c.p.as_ref().ok()?.value())).collect();
    let places = candidates.iter_mut().filter(|candidate| candidate.p.is_ok());
    for (candidate, p) in places.zip(holm(&tested)) {
        candidate.p_holm = Some(PValue::new(p));
        candidate.told_apart = Some(p <= alpha);
    }
    candidates
}

/// Response times of all answers, by pair, by answer and by whether it was right, and each compared.
fn times(answers: &[Answer]) -> (Vec<Condition>, Vec<Comparison>) {
    let of = |name: &str, wanted: &dyn Fn(&Answer) -> bool| -> (String, Vec<Timed>) {
        let wanted = answers.iter().filter(|answer| wanted(answer));
        (name.into(), wanted.map(|answer| (answer.observer, answer.response_time_s)).collect())
    };
    let compared = [
        [of("right answers", &Answer::correct), of("wrong answers", &|a| !a.correct())],
        [of("different pairs", &Answer::different), of("identical pairs", &|a| !a.different())],
        [
            of("said \"different\"", &|a| a.said_different),
            of("said \"the same\"", &|a| !a.said_different),
        ],
    ];
    let all = [of("all answers", &|_| true)];
    (conditions(&[&all[..], &compared.concat()].concat()), compare(&compared))
}
