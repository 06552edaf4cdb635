//! A response: one row, written when the answer is given.

use crate::participant::ParticipantCode;
use crate::protocol::{Eye, Task};
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
    /// How often this pair has been asked in the session among the trials that count, from 1; 1 in
    /// practice and catch trials.
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
    /// Id of the reference or ground truth, which is A or B; empty where the task has none.
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
    /// Which of the two was shown first, or on the left.
    pub first: Side,
    /// What the observer said.
    pub answer: Answer,
    /// Id of the stimulus that the answer selects; empty if it selects none.
    pub selected: Option<String>,
    /// Whether the answer was the right one; empty where nothing is right or wrong.
    pub correct: Option<bool>,
    /// From the end of the last interval's first showing to the answer, in seconds; negative for an
    /// answer given earlier.
    #[schemars(extend("unit" = "s"))]
    pub response_time_s: f64,
    /// How often the reference was shown again by itself (matching).
    pub replays_reference: Option<u32>,
    /// How often A was shown again.
    pub replays_a: u32,
    /// How often B was shown again.
    pub replays_b: u32,
    /// When the first frame of the reference was first shown by itself (matching), in seconds since
    /// the session was opened.
    #[schemars(extend("unit" = "s"))]
    pub onset_reference_s: Option<f64>,
    /// When the first frame of A was first shown, in seconds since the session was opened.
    #[schemars(extend("unit" = "s"))]
    pub onset_a_s: f64,
    /// When the first frame of B was first shown, in seconds since the session was opened.
    #[schemars(extend("unit" = "s"))]
    pub onset_b_s: f64,
    /// From the reference's onset to the first screen after it.
    #[schemars(extend("unit" = "s"))]
    pub duration_reference_s: Option<f64>,
    /// From A's first onset to the first screen after its first showing.
    #[schemars(extend("unit" = "s"))]
    pub duration_a_s: f64,
    /// From B's first onset to the first screen after its first showing.
    #[schemars(extend("unit" = "s"))]
    pub duration_b_s: f64,
    /// Frames of the reference shown later than they were due, over all showings.
    pub late_frames_reference: Option<u32>,
    /// Frames of A shown later than they were due, over all showings.
    pub late_frames_a: u32,
    /// Frames of B shown later than they were due, over all showings.
    pub late_frames_b: u32,
    /// Frames of the reference that were never shown, over all showings.
    pub dropped_frames_reference: Option<u32>,
    /// Frames of A that were never shown, over all showings.
    pub dropped_frames_a: u32,
    /// Frames of B that were never shown, over all showings.
    pub dropped_frames_b: u32,
    /// Frames of the reference that stayed longer than they should, over all showings.
    pub repeated_frames_reference: Option<u32>,
    /// Frames of A that stayed longer than they should, over all showings.
    pub repeated_frames_a: u32,
    /// Frames of B that stayed longer than they should, over all showings.
    pub repeated_frames_b: u32,
    /// What the times above were read from.
    pub clock: Clock,
    /// What decided when the next frame was shown.
    pub pacing: Pacing,
    /// The display's refreshes per second as measured; empty if it does not pace the program.
    #[schemars(range(min = 0.0))]
    #[schemars(extend("unit" = "Hz"))]
    pub refresh_hz: Option<f64>,
    /// Refreshes that each frame was to stay: a whole number if the rates fit; empty if the display
    /// does not pace the program.
    #[schemars(range(min = 0.0))]
    pub refreshes_per_frame: Option<f64>,
    /// The display: its name, physical pixels and scale factor.
    pub display: String,
    /// Name of the display profile; `identity` if none was given.
    pub display_profile: String,
    /// SHA-256 of the display profile and its table; empty if none was given.
    pub display_profile_sha256: Option<String>,
    /// What did not pass the check of the display, separated by semicolons; empty if all did.
    pub display_faults: Option<String>,
    /// How the two eyes' images reached the eyes; `mono` if the stimuli are not stereo.
    pub stereo_mode: String,
    /// Physical pixels per image pixel.
    #[schemars(range(min = 0.0))]
    pub magnification: f64,
    /// How image pixels became physical ones.
    pub resampling: Resampling,
    /// What the eye was asked to do.
    pub eye: Eye,
    /// Pixels per degree of visual angle that the stimuli were made for.
    #[schemars(range(min = 0.0))]
    #[schemars(extend("unit" = "px/deg"))]
    pub pixels_per_degree: f64,
    /// Image pixels per degree on this display, by its profile; empty if none was given.
    #[schemars(range(min = 0.0))]
    #[schemars(extend("unit" = "px/deg"))]
    pub viewed_pixels_per_degree: Option<f64>,
    /// Of a simplified model: its name, if the stimuli have the axis `model`.
    pub model: Option<String>,
    /// Of a simplified model: the weight's exponent, if the stimuli have the axis `r`.
    pub r: Option<f64>,
    /// Of a simplified model: its part of the original's faces, if the stimuli have the axis
    /// `level_of_detail`.
    pub level_of_detail: Option<f64>,
    /// Screen velocity of what moves in B, the candidate where there is a ground truth, in degrees of
    /// visual angle per second.
    #[schemars(extend("unit" = "deg/s"))]
    pub speed_deg_per_s: f64,
    /// Whether this is a trial run, whose answers never count.
    pub pilot: bool,
    /// When the answer was given (UTC, RFC 3339).
    #[schemars(extend("format" = "date-time"))]
    pub answered_at: String,
    /// Version of the program that ran the session.
    pub program_version: String,
}

impl Response {
    /// Frames that were shown late or not at all, over all showings of the trial.
    pub fn untimely_frames(&self) -> u32 {
        // Side by side, one frame shows both: it is in the counts of A and of B.
        let of_b = match self.task {
            Task::SameDifferent => 0,
            Task::TwoAfc | Task::Matching => {
                self.late_frames_b.saturating_add(self.dropped_frames_b)
            }
        };
        [
            self.late_frames_a,
            self.late_frames_reference.unwrap_or(0),
            self.dropped_frames_a,
            self.dropped_frames_reference.unwrap_or(0),
            of_b,
        ]
        .into_iter()
        .fold(0, u32::saturating_add)
    }
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
    /// Asked to see whether the observer attends: no result but the false alarms of same/different.
    Catch,
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

impl Side {
    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// What an observer said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// The sequence shown first, or the candidate on the left.
    First,
    /// The sequence shown second, or the candidate on the right.
    Second,
    /// Both look the same.
    Same,
    /// They look different.
    Different,
    /// The observer cannot tell.
    NotSure,
}

impl Answer {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::Second => "second",
            Self::Same => "same",
            Self::Different => "different",
            Self::NotSure => "not-sure",
        }
    }
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

/// What decided when the next frame was shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Pacing {
    /// The display: it refreshes at a steady rate, and frames were handed over one per refresh.
    FixedRefresh,
    /// The program: the display refreshes when it gets a frame.
    VariableRefresh,
    /// The program: the display does not say when it refreshes.
    Timer,
}

/// How image pixels became physical ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Resampling {
    /// One to one.
    None,
    /// Each physical pixel shows the nearest image pixel.
    Nearest,
    /// Each physical pixel mixes the four nearest image pixels.
    Linear,
}
