//! What is to be seen when, and what is done if it was not.

use crate::definition::DefinitionError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::value;

/// The course of a trial: `gap_s` of neutral grey, the fixation mark, the first interval, `gap_s` of
/// grey, the next interval, and so on, then the question.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Timeline {
    /// How long a fixation mark is shown before the first interval, in seconds; 0 for none.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub fixation_s: f64,
    /// Neutral grey before the trial and between its intervals, in seconds.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub gap_s: f64,
    /// What the eye is asked to do while a sequence plays.
    pub eye: Eye,
    /// Whether the participant may see the intervals again before answering.
    pub replays: bool,
    /// How long the question waits for an answer, in seconds; for ever if left out. A trial without an
    /// answer is asked again at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.1, max = 3600.0))]
    pub response_window_s: Option<f64>,
    /// Shows one frame of each sequence instead of the sequence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub still: Option<Still>,
}

/// One frame in place of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Still {
    /// Number of the frame, from 0.
    pub frame: u32,
    /// How long it is shown, in seconds.
    #[schemars(range(min = 0.01, max = 3600.0))]
    pub seconds: f64,
}

/// What the eye is asked to do while a sequence plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Eye {
    /// Follow what moves. The fixation mark goes when the sequence begins.
    Follow,
    /// Keep to the fixation mark, which stays over the middle of the image.
    Fixate,
}

/// What is done when the presentation is not as it should be.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Presentation {
    /// A trial with frames that came late, were dropped or stayed too long.
    pub late_frames: LateFrames,
    /// A display whose refresh rate is no whole multiple of the frame rate.
    pub refresh: Unfit,
    /// A display that does not pass the check.
    pub display_check: Unfit,
}

/// What becomes of a trial with late frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LateFrames {
    /// Its answer is kept; the row says how many frames were late.
    #[default]
    Keep,
    /// It is asked once more at the end, its first answer is noted in the log only.
    Repeat,
}

/// What becomes of a session on a display that does not fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Unfit {
    /// It takes place, and every row says what did not fit.
    #[default]
    Stamp,
    /// It does not begin.
    Refuse,
}

impl Timeline {
    pub(super) fn check(&self, file: &str) -> Result<(), DefinitionError> {
        for (key, seconds) in
            [("timeline.fixation_s", self.fixation_s), ("timeline.gap_s", self.gap_s)]
        {
            if !(0.0..=60.0).contains(&seconds) {
                return value(file, key, seconds, "0 to 60 seconds are allowed");
            }
        }
        if let Some(seconds) = self.response_window_s
            && !(0.1..=3600.0).contains(&seconds)
        {
            let allowed = "0.1 to 3600 seconds are allowed";
            return value(file, "timeline.response_window_s", seconds, allowed);
        }
        if let Some(still) = self.still
            && !(0.01..=3600.0).contains(&still.seconds)
        {
            let allowed = "0.01 to 3600 seconds are allowed";
            return value(file, "timeline.still.seconds", still.seconds, allowed);
        }
        Ok(())
    }
}
