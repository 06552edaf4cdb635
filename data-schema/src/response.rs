//! A response: one row, written when the answer is given.

use crate::participant::ParticipantCode;
use crate::protocol::Task;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One answered trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Response {
    /// Name of the protocol.
    pub study: String,
    /// The participant's code.
    pub subject: ParticipantCode,
    /// The participant's sitting, from 1.
    #[schemars(range(min = 1))]
    pub session: u32,
    /// Name of the computer the session ran on.
    pub station: String,
    /// Run of trials between two breaks, from 1; 0 for practice.
    pub block: u32,
    /// Place in the session's order, from 1, practice included.
    #[schemars(range(min = 1))]
    pub trial: u32,
    /// How often this pair has been asked in the session, from 1.
    #[schemars(range(min = 1))]
    pub repetition: u32,
    /// How often this trial was begun: 1, or more after an interrupted session.
    #[schemars(range(min = 1))]
    pub attempt: u32,
    /// Whether the answer counts, and as what.
    pub kind: TrialKind,
    /// `participant`, or `simulated:NAME` for a simulated observer.
    pub observer: String,
    /// What was asked.
    pub task: Task,
    /// The question as it was shown.
    pub question: String,
    /// Id of the reference stimulus, where the task has one.
    pub reference: Option<String>,
    /// Id of stimulus A (the first of the two in the order of the grid).
    pub stimulus_a: String,
    /// Noise realisation of A, from 0.
    pub exemplar_a: u32,
    /// Hash of the sequence shown as A, as in its manifest.
    pub hash_a: String,
    /// Id of stimulus B.
    pub stimulus_b: String,
    /// Noise realisation of B, from 0.
    pub exemplar_b: u32,
    /// Hash of the sequence shown as B, as in its manifest.
    pub hash_b: String,
    /// Which of the two was shown first.
    pub first: Side,
    /// What the observer said.
    pub answer: Answer,
    /// Id of the stimulus that the answer selects.
    pub selected: String,
    /// Whether the answer was the right one; empty where nothing is right or wrong.
    pub correct: Option<bool>,
    /// From the end of the second sequence's first showing to the answer, in seconds; negative
    /// for an answer given earlier.
    pub response_time_s: f64,
    /// How often A was shown again.
    pub replays_a: u32,
    /// How often B was shown again.
    pub replays_b: u32,
    /// When the first frame of A was first shown, in seconds since the session was opened.
    pub onset_a_s: f64,
    /// When the first frame of B was first shown, in seconds since the session was opened.
    pub onset_b_s: f64,
    /// Frames of A that were shown later than they were due or not at all, over all showings.
    pub late_frames_a: u32,
    /// Frames of B that were shown later than they were due or not at all, over all showings.
    pub late_frames_b: u32,
    /// What the times above were read from.
    pub clock: Clock,
    /// The display: its name, physical pixels and scale factor.
    pub display: String,
    /// Pixels per degree of visual angle that the stimuli were made for.
    #[schemars(range(min = 0.0))]
    pub pixels_per_degree: f64,
    /// When the answer was given (UTC, RFC 3339).
    #[schemars(extend("format" = "date-time"))]
    pub answered_at: String,
    /// Version of the program that ran the session.
    pub program_version: String,
}

/// Whether an answer counts, and as what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TrialKind {
    /// A participant's answer that counts.
    Real,
    /// A trial run of the experiment: never a result.
    Pilot,
    /// Asked so that the question is understood: never a result.
    Practice,
    /// Given by a simulated observer: a check of the tool, never a finding.
    Simulated,
}

/// One of the two stimuli of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Stimulus A.
    A,
    /// Stimulus B.
    B,
}

/// What an observer said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// The sequence shown first.
    First,
    /// The sequence shown second.
    Second,
}

/// What presentation times were read from, and so what they can prove.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// The program's monotonic clock when a frame was handed to the system: it says nothing about
    /// when light left the screen.
    Submission,
    /// The clock of a simulated display.
    Simulated,
}
