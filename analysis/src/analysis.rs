//! The analysis of a study, whatever its task: everything that follows from the answers, and a reason in
//! words for everything that does not.

use crate::categories::section;
use crate::categories::trials::Trials;
use crate::categories::{Matching, SameDifferent, analyze_matching, analyze_same_different};
use crate::error::InputError;
use crate::input::data_quality::DataQuality;
use crate::input::responses::Responses;
use crate::maths::bootstrap::REPLICATES;
use crate::outcome::{Outcome, entry};
use crate::paired::{self, Options, PairedComparison};
use crate::ratings;
use crate::ratings::analysis::RatingAnalysis;
use crate::ratings::answers::Ratings;
use crate::ratings::candidates::{CandidateRating, candidates};
use crate::report::{Document, quality};
use serde::ser::{Serialize, SerializeMap, Serializer};
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Task;

/// Seed of every random draw of an analysis, so that it can be repeated.
pub(crate) const SEED: u64 = 2012;

/// What the answers mean.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Analysis {
    /// Of paired comparisons (2afc).
    PairedComparison(Box<PairedComparison>),
    /// Of right and wrong answers (matching, same-different).
    Categories(Box<Categories>),
}

/// What answers mean that are right or wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Categories {
    /// Where the answers came from and how they were given.
    pub data_quality: DataQuality,
    /// What a reader of the results has to know.
    pub notes: Vec<String>,
    /// The results of the task.
    pub results: Results,
}

/// The results of a task.
#[derive(Clone, Debug, PartialEq)]
pub enum Results {
    /// Which of two candidates matches the reference?
    Matching(Box<Outcome<Matching>>),
    /// Do the candidate and the ground truth look the same? And how are simplified models rated, if the
    /// candidates are such?
    SameDifferent(Box<SameDifferentResults>),
}

/// What same/different answers mean.
#[derive(Clone, Debug, PartialEq)]
pub struct SameDifferentResults {
    /// Are the candidates told from their ground truth?
    pub told: Outcome<SameDifferent>,
    /// Human ratings of the candidates.
    pub candidates: Vec<CandidateRating>,
    /// Ratings of simplified models.
    pub models: Outcome<RatingAnalysis>,
}

impl Serialize for Categories {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match &self.results {
            Results::Matching(results) => entry(&mut map, "matching", results)?,
            Results::SameDifferent(results) => {
                entry(&mut map, "same_different", &results.told)?;
                map.serialize_entry("candidate_ratings", &results.candidates)?;
                entry(&mut map, "ratings", &results.models)?;
            }
        }
        map.serialize_entry("data_quality", &self.data_quality)?;
        map.serialize_entry("notes", &self.notes)?;
        map.end()
    }
}

/// Analyses `responses`.
///
/// # Errors
/// Nothing counts; the answers cannot be analysed; an option is out of range.
pub fn analyze(responses: &Responses, options: impl Into<Options>) -> Result<Analysis, InputError> {
    let options = options.into();
    let alpha = options.alpha;
    responses.check_not_empty()?;
    let results = match responses.task() {
        Some(Task::Matching) => {
            let trials = Trials::matching(responses)?;
            Results::Matching(Box::new(analyze_matching(&trials, alpha)))
        }
        Some(Task::SameDifferent) => {
            let trials = Trials::same_different(responses)?;
            let rows: Vec<&Response> = responses.counted().collect();
            Results::SameDifferent(Box::new(SameDifferentResults {
                told: analyze_same_different(&trials, alpha),
                candidates: candidates(&rows),
                models: Ratings::from_responses(&rows)
                    .map(|rated| ratings::analysis::analyze(&rated, REPLICATES as usize, SEED)),
            }))
        }
        Some(Task::TwoAfc) | None => {
            let analysis = paired::analyze(&responses.preferences()?, options)?;
            return Ok(Analysis::PairedComparison(Box::new(analysis)));
        }
    };
    let data_quality = DataQuality::of(responses);
    let notes = responses.notes.clone();
    Ok(Analysis::Categories(Box::new(Categories { data_quality, notes, results })))
}

impl Analysis {
    /// The analysis for people.
    pub fn document(&self) -> Document {
        match self {
            Self::PairedComparison(analysis) => analysis.document(),
            Self::Categories(analysis) => analysis.document(),
        }
    }
}

impl Categories {
    fn document(&self) -> Document {
        let data = &self.data_quality;
        let (task, levels, results) = match &self.results {
            Results::Matching(results) => (
                "Matching with a reference",
                results.as_ref().as_ref().map_or(&[][..], |found| &found.levels),
                vec![section::matching(results)],
            ),
            Results::SameDifferent(results) => (
                "Same as the ground truth, or different",
                results.told.as_ref().map_or(&[][..], |found| &found.levels),
                // Candidates that are no simplified models have no such ratings, and nobody misses them.
                std::iter::once(section::same_different(&results.told))
                    .chain([ratings::candidates::section(&results.candidates)])
                    .chain(results.models.iter().map(ratings::section::section))
                    .collect(),
            ),
        };
        let mut design = vec![
            ("Task".into(), task.into()),
            ("Levels".into(), levels.join(", ")),
            ("Trials".into(), data.trials.to_string()),
        ];
        design.extend(Document::design_of(data));
        Document {
            lead: format!(
                "{task}: {} trials by {} observer{}",
                data.trials,
                data.subjects,
                if data.subjects == 1 { "" } else { "s" }
            ),
            simulated: data.simulated,
            questions: Ok(data.questions.clone()),
            design,
            stimuli: vec![],
            summary: String::new(),
            sections: std::iter::once(quality::section(&Ok(data.clone()))).chain(results).collect(),
            notes: self.notes.clone(),
        }
    }
}
