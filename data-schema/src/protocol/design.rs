//! Which pairs are asked, in which order, and how often.

use crate::definition::DefinitionError;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Task, value};

/// How the stimuli are paired.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Which pairs are asked.
    pub pairs: Pairs,
    /// Which of a pair comes first (2afc), is the reference (matching) or stands left
    /// (same-different).
    #[serde(default)]
    pub orders: Orders,
    /// In which order the pairs are asked.
    #[serde(default)]
    pub sequence: Sequence,
    /// How often each pair is asked, 1 to 1000.
    #[schemars(range(min = 1, max = 1000))]
    pub repetitions: u32,
    /// Trials between two breaks; no breaks if left out. Round-robin and Latin-square designs break
    /// after whole rounds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub trials_between_breaks: Option<u32>,
    /// The levels that make a stimulus the ground truth (`samples = "A5"`): with
    /// `pairs = "ground-truth"`, every other stimulus is compared with the one that differs from it in
    /// these levels only.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub ground_truth: IndexMap<String, String>,
    /// How often each ground truth is compared with itself, with `pairs = "ground-truth"`: without
    /// such pairs nobody can tell seeing a difference from always saying so.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(max = 1000))]
    pub identical_pairs: u32,
}

/// Which pairs are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Pairs {
    /// Every pair of two different stimuli.
    All,
    /// Every pair of stimuli that differ in exactly one axis.
    OneAxis,
    /// Every stimulus with its ground truth.
    GroundTruth,
}

impl Pairs {
    /// Its name in a protocol.
    pub fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::OneAxis => "one-axis",
            Self::GroundTruth => "ground-truth",
        }
    }
}

/// Which member of a pair comes first, is the reference or stands left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Orders {
    /// Either, by chance, but each stimulus as often as possible; the next repetition turns all
    /// pairs round.
    #[default]
    Balanced,
    /// Both: each pair is asked twice in a repetition.
    Both,
}

/// In which order the pairs are asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sequence {
    /// By chance.
    #[default]
    Random,
    /// In rounds in which no stimulus comes twice, the rounds and the pairs in them by chance.
    RoundRobin,
    /// In the same rounds, whose order over the participants is a Latin square balanced for
    /// carry-over: each round stands at each place, and after each other round, equally often.
    LatinSquare,
}

impl Sequence {
    /// Its name in a protocol.
    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::RoundRobin => "round-robin",
            Self::LatinSquare => "latin-square",
        }
    }
}

impl Design {
    pub(super) fn check(&self, task: Task, file: &str) -> Result<(), DefinitionError> {
        if !(1..=1000).contains(&self.repetitions) {
            return value(file, "design.repetitions", self.repetitions, "1 to 1000 are allowed");
        }
        if self.trials_between_breaks == Some(0) {
            let allowed = "at least 1, or leave the key out";
            return value(file, "design.trials_between_breaks", 0, allowed);
        }
        if self.identical_pairs > 1000 {
            let allowed = "0 to 1000 are allowed";
            return value(file, "design.identical_pairs", self.identical_pairs, allowed);
        }
        let with_truth = self.pairs == Pairs::GroundTruth;
        if with_truth != (task == Task::SameDifferent) {
            let allowed = "ground-truth pairs are for the task same-different, which needs them";
            return value(file, "design.pairs", self.pairs.name(), allowed);
        }
        if with_truth == self.ground_truth.is_empty() {
            let allowed = "the levels of the ground truth are needed with ground-truth pairs, \
                           and with no others";
            return value(file, "design.ground_truth", format!("{:?}", self.ground_truth), allowed);
        }
        if self.identical_pairs > 0 && !with_truth {
            let allowed = "only ground-truth pairs can be of identical members";
            return value(file, "design.identical_pairs", self.identical_pairs, allowed);
        }
        if with_truth && self.sequence != Sequence::Random {
            let allowed = "ground-truth pairs are asked in random order";
            return value(file, "design.sequence", self.sequence.name(), allowed);
        }
        Ok(())
    }
}

fn is_zero(count: &u32) -> bool {
    *count == 0
}
