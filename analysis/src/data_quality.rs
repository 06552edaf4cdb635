//! Quality of the data of an experiment: what was left out, and what the answers look like apart
//! from what they prefer.

use crate::preference::Proportion;
use serde::Serialize;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::response::{Answer, TrialKind};
use std::collections::BTreeSet;

/// Where the answers came from and how they were given. All but `excluded` is over the analysed
/// trials.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DataQuality {
    /// Name of the protocol.
    pub study: String,
    /// The question as it was shown.
    pub question: String,
    /// Whether the observers were simulated: a check of the tool, never a finding.
    pub simulated: bool,
    /// Number of different subjects.
    pub subjects: u64,
    /// Who answered: `participant`, or the names of simulated observers.
    pub observers: Vec<String>,
    /// The displays.
    pub displays: Vec<String>,
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
    /// Side bias: how often the sequence shown first was chosen.
    pub first_chosen: Proportion,
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
    /// Trials of sets of pairs that are not complete.
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
    /// The quality of the analysed `rows`, of which there is at least one, beside what was left out.
    pub(crate) fn of(rows: &[&Response], excluded: Excluded) -> Self {
        let count =
            |has: &dyn Fn(&Response) -> bool| rows.iter().filter(|row| has(row)).count() as u64;
        let sum = |of: &dyn Fn(&Response) -> u32| rows.iter().map(|row| u64::from(of(row))).sum();
        let late = Response::untimely_frames;
        let replays = |row: &Response| row.replays_a.saturating_add(row.replays_b);
        let first = count(&|row| row.answer == Answer::First);
        Self {
            study: rows[0].study.clone(),
            question: rows[0].question.clone(),
            simulated: rows[0].kind == TrialKind::Simulated,
            subjects: distinct(rows, |row| row.subject.to_string()).len() as u64,
            observers: distinct(rows, |row| row.observer.clone()),
            displays: distinct(rows, |row| row.display.clone()),
            program_versions: distinct(rows, |row| row.program_version.clone()),
            excluded,
            trials_with_late_frames: count(&|row| late(row) > 0),
            late_frames: sum(&late),
            trials_with_replays: count(&|row| replays(row) > 0),
            replays: sum(&replays),
            response_time_s: Quartiles::of(rows.iter().map(|row| row.response_time_s)),
            first_chosen: Proportion::new(first, rows.len() as u64),
        }
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
