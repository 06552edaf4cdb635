//! Quality of the data of an experiment: what was left out, and what the answers look like apart
//! from what they say.

use super::responses::Responses;
use crate::maths::proportion::Proportion;
use serde::Serialize;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::{Answer, TrialKind};
use std::collections::{BTreeMap, BTreeSet};

/// Where the answers came from and how they were given. All but `excluded` and `catch` is over the
/// trials that count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DataQuality {
    /// Names of the protocols.
    pub studies: Vec<String>,
    /// The question as it was shown, in all its wordings.
    pub questions: Vec<String>,
    /// Number of trials.
    pub trials: u64,
    /// Whether the observers were simulated: a check of the tool, never a finding.
    pub simulated: bool,
    /// Number of different subjects.
    pub subjects: u64,
    /// Who answered: `participant`, or the names of simulated observers.
    pub observers: Vec<String>,
    /// The displays, each with its profile.
    pub displays: Vec<String>,
    /// What did not pass the check of a display, with the number of trials seen on it.
    pub display_faults: Vec<(String, u64)>,
    /// Versions of the program that ran the sessions.
    pub program_versions: Vec<String>,
    /// What was read and left out.
    pub excluded: Excluded,
    /// Trials with frames that were shown late or not at all.
    pub trials_with_late_frames: u64,
    /// Frames that were shown late or not at all.
    pub late_frames: u64,
    /// Trials in which a sequence was shown again.
    pub trials_with_replays: u64,
    /// How often a sequence was shown again.
    pub replays: u64,
    /// Response time in seconds.
    pub response_time_s: Quartiles,
    /// Answers given before the last interval had been shown once.
    pub early_answers: u64,
    /// Side bias: how often the sequence shown first, or the candidate on the left, was chosen among the
    /// answers that choose; none if none does.
    pub first_chosen: Option<Proportion>,
    /// Right answers to catch trials; none if none was asked.
    pub catch: Option<Catch>,
}

/// Answers to trials with a right answer, spread over the session: a wrong one is a lapse of attention.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Catch {
    /// Right answers of all observers.
    pub right: Proportion,
    /// Right answers and trials of each observer who gave a wrong one.
    pub lapses: Vec<(String, u64, u64)>,
}

/// Rows that were read and left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Excluded {
    /// Practice trials.
    pub practice: u64,
    /// Catch trials.
    pub catch: u64,
    /// Trials of pilot sessions.
    pub pilot: u64,
    /// Trials of sets of pairs that are not complete (2afc).
    pub incomplete_sets: u64,
}

/// The quartiles of a sample, by linear interpolation between order statistics (Hyndman and Fan
/// 1996, type 7).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quartiles {
    /// A quarter of the values is below it.
    pub first: f64,
    /// Half of the values is below it.
    pub median: f64,
    /// Three quarters of the values are below it.
    pub third: f64,
}

impl Quartiles {
    /// The quartiles of `values`, of which there is at least one.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let at = |quarter: f64| {
            let place = quarter * (values.len() - 1) as f64;
            let (below, above) = (values[place.floor() as usize], values[place.ceil() as usize]);
            below + place.fract() * (above - below)
        };
        Self { first: at(0.25), median: at(0.5), third: at(0.75) }
    }
}

impl DataQuality {
    /// The quality of `responses`, of which at least one counts.
    pub(crate) fn of(responses: &Responses) -> Self {
        let rows: Vec<&Response> = responses.counted().collect();
        let count =
            |has: &dyn Fn(&Response) -> bool| rows.iter().filter(|row| has(row)).count() as u64;
        let sum = |of: &dyn Fn(&Response) -> u32| rows.iter().map(|row| u64::from(of(row))).sum();
        let late = Response::untimely_frames;
        let replays = |row: &Response| {
            let of_reference = row.replays_reference.unwrap_or(0);
            row.replays_a.saturating_add(row.replays_b).saturating_add(of_reference)
        };
        let first = count(&|row| row.answer == Answer::First);
        let chosen = first + count(&|row| row.answer == Answer::Second);
        let mut faults: BTreeMap<&str, u64> = BTreeMap::new();
        for row in &rows {
            let of_row = row.display_faults.as_deref().unwrap_or_default().split(';');
            for fault in of_row.map(str::trim).filter(|fault| !fault.is_empty()) {
                *faults.entry(fault).or_default() += 1;
            }
        }
        Self {
            studies: distinct(&rows, |row| row.study.clone()),
            questions: distinct(&rows, |row| row.question.clone()),
            trials: rows.len() as u64,
            simulated: rows.iter().any(|row| row.kind == TrialKind::Simulated),
            subjects: distinct(&rows, |row| format!("{} {}", row.study, row.subject)).len() as u64,
            observers: distinct(&rows, |row| row.observer.clone()),
            displays: distinct(&rows, |row| {
                format!("{}, profile {}", row.display, row.display_profile)
            }),
            display_faults: faults.into_iter().map(|(fault, n)| (fault.to_string(), n)).collect(),
            program_versions: distinct(&rows, |row| row.program_version.clone()),
            excluded: responses.excluded,
            trials_with_late_frames: count(&|row| late(row) > 0),
            late_frames: sum(&late),
            trials_with_replays: count(&|row| replays(row) > 0),
            replays: sum(&replays),
            response_time_s: Quartiles::of(rows.iter().map(|row| row.response_time_s)),
            early_answers: count(&|row| row.response_time_s < 0.0),
            first_chosen: (chosen > 0 && rows.iter().all(|row| row.task != Task::SameDifferent))
                .then(|| Proportion::new(first, chosen)),
            catch: Catch::of(&responses.catch),
        }
    }
}

impl Catch {
    fn of(rows: &[Response]) -> Option<Self> {
        let mut observers: BTreeMap<String, (u64, u64)> = BTreeMap::new();
        for row in rows {
            let (right, trials) = observers.entry(row.subject.to_string()).or_default();
            *right += u64::from(row.correct == Some(true));
            *trials += 1;
        }
        let right = observers.values().map(|(right, _)| right).sum();
        let lapses = observers.into_iter().map(|(who, (right, trials))| (who, right, trials));
        (!rows.is_empty()).then(|| Self {
            right: Proportion::new(right, rows.len() as u64),
            lapses: lapses.filter(|(_, right, trials)| right < trials).collect(),
        })
    }
}

/// The different values of `field`, in alphabetical order.
pub(crate) fn distinct(rows: &[&Response], field: impl Fn(&Response) -> String) -> Vec<String> {
    let values: BTreeSet<String> = rows.iter().map(|row| field(row)).collect();
    values.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_those_of_r() {
        // R 4.2.2: quantile(c(7, 1, 4, 2), c(.25, .5, .75)) is 1.75 3.00 4.75.
        let quartiles = Quartiles::of([7.0, 1.0, 4.0, 2.0]);
        assert_eq!(quartiles, Quartiles { first: 1.75, median: 3.0, third: 4.75 });
        assert_eq!(Quartiles::of([-0.5]), Quartiles { first: -0.5, median: -0.5, third: -0.5 });
    }
}
