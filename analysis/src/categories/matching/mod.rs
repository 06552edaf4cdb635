//! Matching: which of two candidates matches the reference (Navarro 2012, §5.6)?
//!
//! Two candidates are offered, so guessing is right in ½ of the trials however many levels there are. The
//! table of reference × chosen level is therefore not one of free choice: its diagonal is ½ by design, and
//! κ, χ² or information computed from it would find guessers in agreement. They are computed from the side
//! of the reference × the side chosen, where guessing is independence.

mod levels;
mod people;

pub use levels::{Cell, Level, Pair};
pub use people::PerObserver;

use super::confusion::{Confusion, confusion};
use super::discrimination::{Counts, DPrime, Model, Strategy};
use super::merged::{Merged, merged};
use super::observers::{Observers, observers};
use super::quality::{Lapses, lapses, too_fast};
use super::resampled::{Resampled, d_prime};
use super::response_times::{Comparison, Condition};
use super::trials::{MatchingTrial, Trials};
use crate::outcome::{Outcome, serialize_outcomes};

/// The share of right answers that guessing reaches.
const CHANCE: f64 = 0.5;

/// What matching answers say.
#[derive(Clone, Debug, PartialEq)]
pub struct Matching {
    /// The levels.
    pub levels: Vec<String>,
    /// Level of significance of "told apart".
    pub alpha: f64,
    /// Whether the observers were simulated.
    pub simulated: bool,
    /// Answers "not sure", which count nowhere else.
    pub undecided: u64,
    /// Accuracy of all answers, with intervals that allow for observers who differ.
    pub accuracy: Observers,
    /// Accuracy and habits of each observer who answered.
    pub per_observer: Vec<PerObserver>,
    /// Answers: level of the reference (row) × chosen level (column).
    pub chosen: Vec<Vec<u64>>,
    /// Accuracy by reference and foil (the candidate that is not the reference), where there are answers.
    pub cells: Vec<Cell>,
    /// Accuracy by pair of levels, whichever was the reference, where there are answers.
    pub pairs: Vec<Pair>,
    /// Accuracy by level.
    pub per_level: Vec<Level>,
    /// Response times by condition.
    pub response_times: Vec<Condition>,
    /// Response times compared.
    pub comparisons: Vec<Comparison>,
    /// Answers that came too soon after the beginning of the last film.
    pub too_fast: u64,
    /// Levels that were not told apart.
    pub merged: Outcome<Merged>,
    /// Which candidate was the reference, first or second (row) × which was chosen (column).
    pub sides: Outcome<Confusion>,
    /// d′ over all pairs by differencing, with side bias taken out (ABX: "the first" is a hit where the
    /// reference was first).
    pub d_prime: Outcome<Resampled<DPrime>>,
    /// The same by independent observations.
    pub d_prime_independent: Outcome<Resampled<DPrime>>,
    /// Lapses in catch trials.
    pub lapses: Outcome<Lapses>,
}

serialize_outcomes!(
    Matching,
    [
        levels,
        alpha,
        simulated,
        undecided,
        accuracy,
        per_observer,
        chosen,
        cells,
        pairs,
        per_level,
        response_times,
        comparisons,
        too_fast
    ],
    [merged, sides, d_prime, d_prime_independent, lapses]
);

/// A trial that was answered.
#[derive(Clone, Copy, Debug)]
struct Answer {
    observer: usize,
    reference: usize,
    foil: usize,
    /// Whether the reference was the first candidate, and whether the first was chosen.
    reference_first: bool,
    first_chosen: bool,
    response_time_s: f64,
}

impl Answer {
    fn correct(&self) -> bool {
        self.reference_first == self.first_chosen
    }

    fn chosen(&self) -> usize {
        if self.correct() { self.reference } else { self.foil }
    }
}

/// What the answers of `study` say; two levels are told apart if guessing as well has a probability of at
/// most `alpha`, by Holm's correction for the number of pairs.
///
/// # Errors
/// In words: there are no answers, or a trial that cannot be.
pub fn analyze_matching(study: &Trials<MatchingTrial>, alpha: f64) -> Outcome<Matching> {
    let mut answers = Vec::new();
    for trial in &study.trials {
        answers.extend(answer(study, trial)?);
    }
    let right = right_by_observer(study, &answers);
    let accuracy = observers(&right, CHANCE)?;
    let mut chosen = vec![vec![0; study.levels.len()]; study.levels.len()];
    let mut sides = vec![vec![0; 2]; 2];
    let mut counts = vec![Counts::default(); study.observers.len()];
    for answer in &answers {
        chosen[answer.reference][answer.chosen()] += 1;
        sides[usize::from(!answer.reference_first)][usize::from(!answer.first_chosen)] += 1;
        counts[answer.observer].add(answer.reference_first, answer.first_chosen);
    }
    let (pairs, of_levels) = levels::pairs(study, &answers, alpha);
    let (response_times, comparisons) = people::times(study, &answers);
    let onsets = study.trials.iter().filter(|trial| trial.chosen.is_some());
    let onsets: Vec<f64> = onsets.map(|trial| trial.since_onset_s).collect();
    Ok(Matching {
        levels: study.levels.clone(),
        alpha,
        simulated: study.simulated,
        undecided: (study.trials.len() - answers.len()) as u64,
        per_observer: people::per_observer(study, &answers)?,
        chosen,
        cells: levels::cells(study, &answers),
        pairs,
        per_level: levels::per_level(study, &answers),
        response_times,
        comparisons,
        too_fast: too_fast(&onsets),
        merged: match study.ordered {
            true => Ok(merged(study.levels.len(), &of_levels)),
            false => Err("levels are merged along one axis; these stimuli differ in more".into()),
        },
        sides: confusion(&sides),
        d_prime: d_prime(Model::Abx(Strategy::Differencing), &counts),
        d_prime_independent: d_prime(Model::Abx(Strategy::IndependentObservations), &counts),
        lapses: lapses(&study.catch, CHANCE),
        accuracy,
    })
}

/// The answer to `trial`, if there is one.
fn answer(study: &Trials<MatchingTrial>, trial: &MatchingTrial) -> Outcome<Option<Answer>> {
    let [first, second] = trial.candidates;
    let known = trial.observer < study.observers.len() && first.max(second) < study.levels.len();
    let one_matches = first != second && trial.candidates.contains(&trial.reference);
    if !known || !one_matches || trial.chosen.is_some_and(|chosen| chosen > 1) {
        return Err(format!("{trial:?} is no matching trial of these levels and observers"));
    }
    let reference_first = first == trial.reference;
    Ok(trial.chosen.map(|chosen| Answer {
        observer: trial.observer,
        reference: trial.reference,
        foil: if reference_first { second } else { first },
        reference_first,
        first_chosen: chosen == 0,
        response_time_s: trial.response_time_s,
    }))
}

/// Each observer's right answers and answers.
fn right_by_observer<'a>(
    study: &Trials<MatchingTrial>,
    answers: impl IntoIterator<Item = &'a Answer>,
) -> Vec<(u64, u64)> {
    let mut right = vec![(0, 0); study.observers.len()];
    for answer in answers {
        let (k, n) = &mut right[answer.observer];
        (*k, *n) = (*k + u64::from(answer.correct()), *n + 1);
    }
    right
}
