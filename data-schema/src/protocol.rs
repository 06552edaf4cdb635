//! The protocol: one experiment, one TOML file. What is asked about which stimuli, in which
//! design, in which words.

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
    /// Seed of every random choice: order of pairs, order within a pair, simulated observers.
    pub seed: u64,
    /// Levels per axis; the stimuli are all their combinations. An axis left out is not restricted.
    pub stimuli: IndexMap<String, Vec<String>>,
    /// How the stimuli are paired.
    pub design: Design,
    /// Practice pairs, asked first and excluded from results.
    #[serde(default)]
    pub practice: Vec<PracticePair>,
    /// The texts that the participant reads.
    pub text: Text,
}

/// What is asked in a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Task {
    /// Two-interval, two-alternative forced choice: two sequences one after the other, one is chosen.
    #[serde(rename = "2afc")]
    TwoAfc,
}

/// How the stimuli are paired.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Which pairs are asked.
    pub pairs: Pairs,
    /// How often each pair is asked, 1 to 1000.
    #[schemars(range(min = 1, max = 1000))]
    pub repetitions: u32,
    /// Trials between two breaks; no breaks if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub trials_between_breaks: Option<u32>,
    /// Neutral grey between the two sequences, in seconds.
    #[schemars(range(min = 0.0))]
    pub gap_s: f64,
}

/// Which pairs are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Pairs {
    /// Every pair of two different stimuli.
    All,
}

/// An obvious pair, asked first so that the question is understood.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PracticePair {
    /// Id of the stimulus that anybody would choose.
    pub better: String,
    /// Id of the other.
    pub worse: String,
}

/// The texts that the participant reads, in the participant's language.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// Shown once the code is given.
    pub instructions: String,
    /// Shown between practice and the trials that count.
    pub after_practice: String,
    /// Shown in each break.
    pub pause: String,
    /// Shown when the session is over.
    pub end: String,
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
        let refuse = |field: &str, value: String, allowed: &str| {
            Err(DefinitionError::value(file, field, value, allowed))
        };
        definition::check_schema(self.schema, file)?;
        if !(1..=32).contains(&self.name.len())
            || !self.name.bytes().all(|b| b.is_ascii_alphanumeric())
        {
            return refuse(
                "name",
                format!("{:?}", self.name),
                "1 to 32 letters and digits are allowed",
            );
        }
        if let Some((axis, _)) = self.stimuli.iter().find(|(_, levels)| levels.is_empty()) {
            return refuse(&format!("stimuli.{axis}"), "[]".into(), "at least one level is needed");
        }
        for (axis, levels) in &self.stimuli {
            if let Some((_, level)) =
                levels.iter().enumerate().find(|(index, level)| levels[..*index].contains(level))
            {
                return refuse(
                    &format!("stimuli.{axis}"),
                    level.clone(),
                    "each level may come once",
                );
            }
        }
        if let Some(pair) = self.practice.iter().find(|pair| pair.better == pair.worse) {
            return refuse("practice", pair.better.clone(), "two different stimuli are needed");
        }
        if !(1..=1000).contains(&self.design.repetitions) {
            let repetitions = self.design.repetitions.to_string();
            return refuse("design.repetitions", repetitions, "1 to 1000 are allowed");
        }
        if self.design.trials_between_breaks == Some(0) {
            return refuse(
                "design.trials_between_breaks",
                "0".into(),
                "at least 1, or leave the key out",
            );
        }
        if !(0.0..=60.0).contains(&self.design.gap_s) {
            return refuse(
                "design.gap_s",
                self.design.gap_s.to_string(),
                "0 to 60 seconds are allowed",
            );
        }
        Ok(())
    }
}
