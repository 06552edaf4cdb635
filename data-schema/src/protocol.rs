//! The protocol: one experiment, one TOML file. What is asked about which stimuli, in which
//! design, on which timeline, in which words.

mod design;
mod text;
mod timeline;

pub use design::{Design, Orders, Pairs, Sequence};
pub use text::{ParticipantField, Text, Words};
pub use timeline::{Eye, LateFrames, Presentation, Still, Timeline, Unfit};

use crate::definition::{self, DefinitionError};
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Version of this format: 1.
    pub schema: u32,
    /// Name of the experiment: letters and digits; it becomes part of file names.
    #[schemars(extend("pattern" = "^[A-Za-z0-9]{1,32}$"))]
    pub name: String,
    /// One line that says what the experiment is about.
    pub title: String,
    /// What is asked in each trial.
    pub task: Task,
    /// The question, in the participant's language.
    pub question: String,
    /// The words for an optional third answer ("I cannot tell"); left out, one of the two must be
    /// chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_sure: Option<String>,
    /// Seed of every random choice: order of pairs, order within a pair, simulated observers.
    pub seed: u64,
    /// Levels per axis; the stimuli are all their combinations. An axis left out is not restricted.
    pub stimuli: IndexMap<String, Vec<String>>,
    /// How the stimuli are paired.
    pub design: Design,
    /// What is to be seen when.
    pub timeline: Timeline,
    /// What is done when the presentation is not as it should be.
    #[serde(default)]
    pub presentation: Presentation,
    /// What is asked about the participant before the session.
    #[serde(default)]
    pub participant: Vec<ParticipantField>,
    /// Practice pairs, asked first and excluded from results.
    #[serde(default)]
    pub practice: Vec<ObviousPair>,
    /// Pairs with a right answer, spread over the session to see whether the participant still
    /// attends; excluded from results.
    #[serde(default)]
    pub catch: Vec<ObviousPair>,
    /// The texts that the participant reads.
    pub text: Text,
    /// The words on buttons and pages.
    #[serde(default)]
    pub words: Words,
}

/// What is asked in a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// Two-interval, two-alternative forced choice: two sequences one after the other, one is chosen.
    #[serde(rename = "2afc")]
    TwoAfc,
    /// A reference above, then two candidates below it, one after the other: which one matches the
    /// reference (Navarro 2012, §5.6).
    Matching,
    /// The ground truth and a candidate side by side: do they look the same (the fourth work's
    /// Appendix A)?
    SameDifferent,
}

/// A pair with an answer that anybody would give.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObviousPair {
    /// Id of the better stimulus: the one to be chosen (2afc), the reference (matching), or the
    /// ground truth (same-different).
    pub better: String,
    /// Id of the other. In the task same-different it may be the same: then so is the right answer.
    pub worse: String,
}

impl Task {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::TwoAfc => "2afc",
            Self::Matching => "matching",
            Self::SameDifferent => "same-different",
        }
    }
}

impl Protocol {
    /// Reads and checks the protocol at `path`.
    ///
    /// # Errors
    /// As [`definition::read`] and [`Protocol::check`].
    pub fn read(path: &Path) -> Result<Self, DefinitionError> {
        let protocol: Self = definition::read(path)?;
        protocol.check(&path.display().to_string())?;
        Ok(protocol)
    }

    /// Parses and checks a protocol; `file` is what an error calls it.
    ///
    /// # Errors
    /// As [`definition::parse`] and [`Protocol::check`].
    pub fn parse(text: &str, file: &str) -> Result<Self, DefinitionError> {
        let protocol: Self = definition::parse(text, file)?;
        protocol.check(file)?;
        Ok(protocol)
    }

    /// Refuses values that no experiment can have.
    ///
    /// # Errors
    /// The first field that does not fit, by name.
    pub fn check(&self, file: &str) -> Result<(), DefinitionError> {
        definition::check_schema(self.schema, file)?;
        if !(1..=32).contains(&self.name.len())
            || !self.name.bytes().all(|b| b.is_ascii_alphanumeric())
        {
            let allowed = "1 to 32 letters and digits are allowed";
            return value(file, "name", format!("{:?}", self.name), allowed);
        }
        if let Some((axis, _)) = self.stimuli.iter().find(|(_, levels)| levels.is_empty()) {
            return value(file, format!("stimuli.{axis}"), "[]", "at least one level is needed");
        }
        for (axis, levels) in &self.stimuli {
            if let Some(level) = twice(levels) {
                return value(file, format!("stimuli.{axis}"), level, "each level may come once");
            }
        }
        for (key, pairs) in [("practice", &self.practice), ("catch", &self.catch)] {
            let pair = pairs.iter().find(|pair| pair.better == pair.worse);
            if let (Some(pair), true) = (pair, self.task != Task::SameDifferent) {
                return value(file, key, &pair.better, "two different stimuli are needed");
            }
        }
        self.check_participant(file)?;
        self.timeline.check(file)?;
        self.design.check(self.task, file)
    }

    fn check_participant(&self, file: &str) -> Result<(), DefinitionError> {
        /// Columns of `participants.csv` that every study has.
        const TAKEN: [&str; 6] =
            ["subject", "observer", "seed", "ordinal", "first_session", "consented_at"];
        let keys: Vec<String> = self.participant.iter().map(|field| field.key.clone()).collect();
        for field in &self.participant {
            let key = &field.key;
            let fits = key.starts_with(|c: char| c.is_ascii_lowercase())
                && key.len() <= 32
                && key.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
            if !fits || TAKEN.contains(&key.as_str()) {
                let allowed = format!(
                    "1 to 32 lower-case letters, digits and underscores are allowed, but none of {}",
                    TAKEN.join(", ")
                );
                return value(file, "participant.key", format!("{key:?}"), allowed);
            }
            let place = format!("participant.{key}.options");
            if field.options.len() < 2 {
                let found = format!("{:?}", field.options);
                return value(file, place, found, "at least two options are needed");
            }
            if let Some(option) = twice(&field.options) {
                return value(file, place, option, "each option may come once");
            }
        }
        match twice(&keys) {
            Some(key) => value(file, "participant.key", key, "each key may come once"),
            None => Ok(()),
        }
    }
}

/// The first of `items` that comes a second time.
fn twice(items: &[String]) -> Option<&String> {
    items.iter().enumerate().find(|(i, item)| items[..*i].contains(item)).map(|(_, item)| item)
}

fn value<T>(
    file: &str,
    field: impl Into<String>,
    value: impl ToString,
    allowed: impl Into<String>,
) -> Result<T, DefinitionError> {
    Err(DefinitionError::value(file, field, value, allowed))
}
