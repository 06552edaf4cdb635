//! Every word that a participant reads, in the participant's language.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The texts of an experiment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// What the participant agrees to before anything else; without it no consent is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub consent: Option<String>,
    /// Shown once the participant is known.
    pub instructions: String,
    /// Shown between practice and the trials that count.
    pub after_practice: String,
    /// Shown in each break.
    pub pause: String,
    /// Shown when the session is over.
    pub end: String,
}

/// A question about the participant, answered by one of its options, as statistics need it and no more:
/// never a name or an address.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticipantField {
    /// Its column in `participants.csv`: lower-case letters, digits and underscores.
    #[schemars(extend("pattern" = "^[a-z][a-z0-9_]{0,31}$"))]
    pub key: String,
    /// The question, in the participant's language.
    pub label: String,
    /// The answers there are, two or more.
    #[schemars(length(min = 2))]
    pub options: Vec<String>,
}

macro_rules! words {
    ($($(#[doc = $doc:literal])+ $name:ident = $english:literal,)*) => {
        /// The words on buttons and pages. Each is English unless the protocol has another.
        /// Where words have `{trial}`, `{of}` or `{minutes}` in them, the number takes its place.
        #[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Words {
            $($(#[doc = $doc])+ pub $name: String,)*
        }

        impl Default for Words {
            fn default() -> Self {
                Self { $($name: $english.into(),)* }
            }
        }
    };
}

words! {
    /// Leaves a page.
    go_on = "Continue",
    /// Leaves the last page.
    close = "Close",
    /// Agrees to the consent text.
    agree = "I agree",
    /// Does not agree to it: the session ends.
    decline = "I do not agree",
    /// Answer: the sequence shown first.
    first = "The first",
    /// Answer: the sequence shown second.
    second = "The second",
    /// Answer: the candidate on the left matches the reference.
    left = "The left one",
    /// Answer: the candidate on the right matches the reference.
    right = "The right one",
    /// Answer: both look the same.
    same = "The same",
    /// Answer: they look different.
    different = "Different",
    /// Shows the first sequence again.
    again_first = "See the first again",
    /// Shows the second sequence again.
    again_second = "See the second again",
    /// Shows the reference again.
    again_reference = "See the upper one again",
    /// Shows the candidate on the left again.
    again_left = "See the left one again",
    /// Shows the candidate on the right again.
    again_right = "See the right one again",
    /// Shows both images again.
    again_both = "See both again",
    /// How far the practice is.
    practice_of = "Practice {trial} of {of}",
    /// How far the trials are.
    trial_of = "Trial {trial} of {of}",
    /// In a break: how many trials are done.
    done_of = "{trial} of {of} are done.",
    /// In a break: how long the rest will take.
    minutes_left = "About {minutes} minutes are left.",
    /// After a trial whose time to answer was up.
    too_slow = "The time to answer was up. This pair will come again later.",
    /// Asks whether to leave.
    leave_question = "Leave the session?",
    /// What leaving means.
    leave_hint = "All answers so far are saved, and the session can be continued later.",
    /// Does not leave.
    stay = "Stay",
    /// Leaves.
    leave = "Leave",
    /// Something failed.
    problem = "Something went wrong. Please call the experimenter.",
    /// What leaving means when something failed.
    problem_hint = "All earlier answers are saved. If you leave now, this pair will be asked again.",
    /// Tries again what failed.
    try_again = "Try again",
    /// The window is smaller than the films.
    too_small = "This window is too small for the films. Please make it larger.",
    /// On the stereo fusion card.
    fusion = "Which square stands out in front of the page? Press the arrow key that points to it.",
}
