//! Human ratings of candidates of any kind: how often each was called the same as its ground truth.

use super::rating::{Share, THRESHOLD};
use crate::report::plot::{Axis, Dot, dots};
use crate::report::section::{Cell, Column, Figure, Kind, Section, Table, ZHANG};
use serde::Serialize;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::response::Answer;
use std::collections::BTreeMap;

/// The rating of one candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CandidateRating {
    /// Id of the stimulus that was compared with its ground truth.
    pub candidate: String,
    /// u₁: how often the answer was "same".
    pub same: u64,
    /// u₂: how often it was "different".
    pub different: u64,
    /// How often it was "not sure"; these answers are left out.
    pub not_sure: u64,
    /// The rating and its tests; none without an answer.
    #[serde(flatten)]
    pub share: Option<Share>,
    /// Why there is no rating.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rating_reason: Option<&'static str>,
}

/// The ratings of the candidates in `rows`; pairs of identical stimuli are none.
pub fn candidates(rows: &[&Response]) -> Vec<CandidateRating> {
    let mut counts: BTreeMap<&str, [u64; 3]> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.stimulus_a != row.stimulus_b) {
        let candidate = match row.reference.as_ref() == Some(&row.stimulus_a) {
            true => &row.stimulus_b,
            false => &row.stimulus_a,
        };
        let [same, different, not_sure] = counts.entry(candidate).or_default();
        match row.answer {
            Answer::Same => *same += 1,
            Answer::Different => *different += 1,
            _ => *not_sure += 1,
        }
    }
    let mut found: Vec<CandidateRating> = counts
        .into_iter()
        .map(|(candidate, [same, different, not_sure])| {
            let trials = same + different;
            CandidateRating {
                candidate: candidate.into(),
                same,
                different,
                not_sure,
                share: (trials > 0).then(|| Share::of(same, trials)),
                rating_reason: (trials == 0).then_some("nobody answered same or different"),
            }
        })
        .collect();
    Share::correct(found.iter_mut().filter_map(|rating| rating.share.as_mut()));
    found
}

/// The ratings in words, as a table and as a figure.
pub fn section(ratings: &[CandidateRating]) -> Section {
    let reach = ratings.iter().filter(|r| r.share.as_ref().is_some_and(|s| s.reaches)).count();
    let clear =
        ratings.iter().filter(|r| r.share.as_ref().is_some_and(|s| s.wilson_clears)).count();
    let columns = vec![
        Column::new(
            "candidate",
            "candidate",
            Kind::Text,
            "Id of the stimulus beside its ground truth.",
        ),
        Column::new("same", "same", Kind::Integer, "u₁: how often the answer was \"same\"."),
        Column::new("different", "different", Kind::Integer, "u₂: how often it was \"different\"."),
        Column::new(
            "not_sure",
            "not sure",
            Kind::Integer,
            "How often it was \"not sure\"; left out.",
        ),
        Column::new("rating", "rating", Kind::Number(3), "u₁/(u₁ + u₂), from 0 to 1."),
        Column::new(
            "wilson_95_low",
            "Wilson",
            Kind::Number(3),
            "Lower bound of Wilson's 95 % interval.",
        ),
        Column::new(
            "wilson_95_high",
            "to",
            Kind::Number(3),
            "Upper bound of Wilson's 95 % interval.",
        ),
        Column::new(
            "clopper_pearson_95_low",
            "Clopper–Pearson",
            Kind::Number(3),
            "Lower bound of Clopper and Pearson's exact 95 % interval.",
        ),
        Column::new(
            "clopper_pearson_95_high",
            "to",
            Kind::Number(3),
            "Upper bound of Clopper and Pearson's exact 95 % interval.",
        ),
        Column::new(
            "reaches",
            "≥ 0.8",
            Kind::Flag,
            "Whether the rating is 0.8 or more: the papers' rule.",
        ),
        Column::new(
            "clears",
            "clears 0.8",
            Kind::Flag,
            "Whether Wilson's interval lies above 0.8.",
        ),
        Column::new(
            "p_above",
            "p (> 0.8)",
            Kind::P,
            "Exact binomial test against 0.8, upper tail.",
        ),
        Column::new(
            "p_above_holm",
            "p (Holm)",
            Kind::P,
            "The same by Holm's correction for the candidates.",
        ),
    ];
    let rows = ratings.iter().map(|rating| {
        let share = rating.share.as_ref();
        vec![
            Cell::from(rating.candidate.as_str()),
            rating.same.into(),
            rating.different.into(),
            rating.not_sure.into(),
            share.map(|s| s.rating).into(),
            share.map(|s| s.wilson_95[0]).into(),
            share.map(|s| s.wilson_95[1]).into(),
            share.map(|s| s.clopper_pearson_95[0]).into(),
            share.map(|s| s.clopper_pearson_95[1]).into(),
            share.map(|s| s.reaches).into(),
            share.map(|s| s.wilson_clears).into(),
            share.map(|s| s.p_above).into(),
            share.map(|s| s.p_above_holm).into(),
        ]
    });
    let drawn: Vec<Dot> = ratings
        .iter()
        .map(|rating| Dot {
            label: rating.candidate.clone(),
            value: rating.share.as_ref().map(|share| share.rating),
            interval: rating.share.as_ref().map(|share| share.wilson_95),
        })
        .collect();
    let axis = Axis { title: "human rating".into(), range: [0.0, 1.0], logarithmic: false };
    Section {
        heading: "Human ratings of the candidates".into(),
        sentences: vec![format!(
            "{reach} of {} candidates have a rating u₁/(u₁ + u₂) of {THRESHOLD} or more, the papers' rule for \
             \"visually equivalent\"; of {clear} Wilson's 95 % interval lies above it.",
            ratings.len()
        )],
        tables: vec![Table {
            name: "candidate-ratings".into(),
            caption: "How often each candidate was called the same as its ground truth. Answers are taken as \
                      independent."
                .into(),
            columns,
            rows: rows.collect(),
        }],
        figures: vec![Figure {
            name: "candidate-ratings".into(),
            caption: "Human rating of each candidate with Wilson's 95 % interval. The line is at 0.8.".into(),
            svg: dots("Human rating of each candidate", &axis, &drawn, &[THRESHOLD]),
        }],
        method: vec![
            "The human rating of a candidate is u₁/(u₁ + u₂), where u₁ answers call it the same as the ground \
             truth and u₂ different (Zhang et al. 2014, Appendix A)."
                .into(),
        ],
        references: vec![ZHANG],
    }
}
