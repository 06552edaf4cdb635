//! What matching tells about observers: their accuracy, habits and response times.

use super::{Answer, CHANCE, right_by_observer};
use crate::categories::accuracy::Accuracy;
use crate::categories::quality::{Runs, runs};
use crate::categories::response_times::{Comparison, Condition, Timed, compare, conditions};
use crate::categories::trials::{MatchingTrial, Trials};
use crate::outcome::{Outcome, serialize_outcomes};

/// Accuracy and habits of an observer.
#[derive(Clone, Debug, PartialEq)]
pub struct PerObserver {
    /// The observer's code.
    pub observer: String,
    /// Right answers against chance.
    pub accuracy: Accuracy,
    /// How often the candidate shown first was chosen, in percent.
    pub first_percent: f64,
    /// Runs of choosing the same side.
    pub runs: Outcome<Runs>,
}

serialize_outcomes!(PerObserver, [observer, accuracy, first_percent], [runs]);

pub(super) fn per_observer(
    study: &Trials<MatchingTrial>,
    answers: &[Answer],
) -> Outcome<Vec<PerObserver>> {
    let right = right_by_observer(study, answers);
    let observers = right.iter().zip(&study.observers).enumerate();
    observers
        .filter(|(_, ((_, n), _))| *n > 0)
        .map(|(place, ((k, n), code))| {
            let own = answers.iter().filter(|answer| answer.observer == place);
            let first: Vec<bool> = own.map(|answer| answer.first_chosen).collect();
            let chosen = first.iter().filter(|first| **first).count();
            Ok(PerObserver {
                observer: code.clone(),
                accuracy: Accuracy::new(*k, *n, CHANCE)?,
                first_percent: 100.0 * chosen as f64 / *n as f64,
                runs: runs(&first),
            })
        })
        .collect()
}

/// Response times of all, right and wrong answers and by reference, and what is compared: wrong with right
/// answers, and each reference with the others.
pub(super) fn times(
    study: &Trials<MatchingTrial>,
    answers: &[Answer],
) -> (Vec<Condition>, Vec<Comparison>) {
    let of = |name: String, wanted: &dyn Fn(&Answer) -> bool| -> (String, Vec<Timed>) {
        let wanted = answers.iter().filter(|answer| wanted(answer));
        (name, wanted.map(|answer| (answer.observer, answer.response_time_s)).collect())
    };
    let all = of("all answers".into(), &|_| true);
    let right = of("right answers".into(), &Answer::correct);
    let wrong = of("wrong answers".into(), &|answer| !answer.correct());
    let levels = || study.levels.iter().enumerate();
    let references =
        || levels().map(|(level, name)| of(format!("reference {name}"), &|a| a.reference == level));
    let others =
        levels().map(|(level, _)| of("other references".into(), &|a| a.reference != level));
    let compared: Vec<[(String, Vec<Timed>); 2]> = [[right.clone(), wrong.clone()]]
        .into_iter()
        .chain(others.zip(references()).map(|(others, reference)| [others, reference]))
        .collect();
    let listed: Vec<(String, Vec<Timed>)> =
        [all, right, wrong].into_iter().chain(references()).collect();
    (conditions(&listed), compare(&compared))
}
