//! The trials of matching and same/different, and how responses become them.

use crate::error::InputError;
use crate::input::responses::Responses;
use crate::report::labels::labels;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::{Answer, Side, TrialKind};

/// The answers of a study; observers and levels are named by their places.
#[derive(Clone, Debug, PartialEq)]
pub struct Trials<T> {
    /// What was compared: the levels in which the stimuli differ.
    pub levels: Vec<String>,
    /// Whether the stimuli differ in one axis only, so that their order means something.
    pub ordered: bool,
    /// Codes of the observers.
    pub observers: Vec<String>,
    /// The trials, each observer's in the order of asking.
    pub trials: Vec<T>,
    /// Whether each trial with an answer that anybody would give was answered right.
    pub catch: Vec<bool>,
    /// Whether the observers were simulated: a check of the tool, never a finding.
    pub simulated: bool,
}

/// Which of two candidates matches the reference?
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchingTrial {
    /// Who answered.
    pub observer: usize,
    /// Level of the reference.
    pub reference: usize,
    /// Levels of the candidates in the order shown; one is the reference's.
    pub candidates: [usize; 2],
    /// The candidate that was chosen, 0 or 1; none for "not sure".
    pub chosen: Option<usize>,
    /// From the end of what was shown last to the answer, in seconds; negative for an earlier answer.
    pub response_time_s: f64,
    /// From the beginning of what was shown last to the answer, in seconds.
    pub since_onset_s: f64,
}

/// Does the candidate look the same as the reference (the ground truth)?
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SameDifferentTrial {
    /// Who answered.
    pub observer: usize,
    /// Level of the reference.
    pub reference: usize,
    /// Level of the candidate: the reference's in a pair of identical stimuli.
    pub candidate: usize,
    /// Whether the observer said "the same"; none for "not sure".
    pub said_same: Option<bool>,
    /// As in [`MatchingTrial`].
    pub response_time_s: f64,
    /// As in [`MatchingTrial`].
    pub since_onset_s: f64,
}

impl Trials<MatchingTrial> {
    /// The matching trials of a study.
    ///
    /// # Errors
    /// Nothing counts, the task is another, or there are too few or too many stimuli.
    pub fn matching(responses: &Responses) -> Result<Self, InputError> {
        collect(responses, Task::Matching, |row, observer, [a, b, reference]| MatchingTrial {
            observer,
            reference,
            candidates: if row.first == Side::A { [a, b] } else { [b, a] },
            chosen: match row.answer {
                Answer::First => Some(0),
                Answer::Second => Some(1),
                _ => None,
            },
            response_time_s: row.response_time_s,
            since_onset_s: since_onset(row),
        })
    }
}

impl Trials<SameDifferentTrial> {
    /// The same/different trials of a study. Identical pairs among the catch trials are trials, too: they
    /// tell of false alarms as others do.
    ///
    /// # Errors
    /// As [`Trials::matching`].
    pub fn same_different(responses: &Responses) -> Result<Self, InputError> {
        collect(responses, Task::SameDifferent, |row, observer, [a, b, reference]| {
            SameDifferentTrial {
                observer,
                reference,
                candidate: if reference == a { b } else { a },
                said_same: match row.answer {
                    Answer::Same => Some(true),
                    Answer::Different => Some(false),
                    _ => None,
                },
                response_time_s: row.response_time_s,
                since_onset_s: since_onset(row),
            }
        })
    }
}

/// From the beginning of what was shown last to the answer, in seconds.
fn since_onset(row: &Response) -> f64 {
    // Side by side, both are shown as long.
    let last = if row.first == Side::A { row.duration_b_s } else { row.duration_a_s };
    row.response_time_s + last
}

/// The trials of `task`, each made by `trial` from its observer and the places of A, B and the reference.
fn collect<T>(
    responses: &Responses,
    task: Task,
    trial: impl Fn(&Response, usize, [usize; 3]) -> T,
) -> Result<Trials<T>, InputError> {
    responses.check_not_empty()?;
    if let Some(other) = responses.task().filter(|other| *other != task) {
        let allowed = format!("answers to {} are needed", task.name());
        return Err(InputError::value(&responses.source, "task", other.name(), allowed));
    }
    let items = responses.items()?;
    let observers = responses.observers();
    let identical = responses.catch.iter().filter(|row| row.stimulus_a == row.stimulus_b);
    let mut rows: Vec<(usize, &Response)> = responses
        .counted()
        .chain(identical)
        .filter_map(|row| {
            let who = (row.study.clone(), row.subject.to_string());
            Some((observers.binary_search_by(|(key, _)| key.cmp(&who)).ok()?, row))
        })
        .collect();
    rows.sort_by_key(|(observer, row)| (*observer, row.session, row.trial));
    let place = |id: &String| items.binary_search(id).ok();
    let trials = rows.into_iter().filter_map(|(observer, row)| {
        let places =
            [place(&row.stimulus_a)?, place(&row.stimulus_b)?, place(row.reference.as_ref()?)?];
        Some(trial(row, observer, places))
    });
    Ok(Trials {
        levels: labels(&items),
        ordered: varying_axes(&items) == Some(1),
        trials: trials.collect(),
        catch: responses.catch.iter().filter_map(|row| row.correct).collect(),
        simulated: responses.counted().any(|row| row.kind == TrialKind::Simulated),
        observers: observers.into_iter().map(|(_, observer)| observer.code).collect(),
    })
}

/// In how many axes the ids of `items` differ, which join one level per axis by `-`; none for ids of
/// another form.
fn varying_axes(items: &[String]) -> Option<usize> {
    let levels: Vec<Vec<&str>> = items.iter().map(|item| item.split('-').collect()).collect();
    let first = levels.first()?;
    let alike = levels.iter().all(|item| item.len() == first.len());
    alike.then(|| (0..first.len()).filter(|a| levels.iter().any(|l| l[*a] != first[*a])).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_that_vary_are_counted() {
        let of = |items: &[&str]| {
            varying_axes(&items.iter().map(ToString::to_string).collect::<Vec<_>>())
        };
        assert_eq!(of(&["M3-T1-A5", "M3-T2-A5"]), Some(1));
        assert_eq!(of(&["M3-T1-A5", "M3-T2-A4"]), Some(2));
        assert_eq!((of(&["a-b", "c"]), of(&[])), (None, None));
    }
}
