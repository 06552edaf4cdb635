//! How far a session is, and how long it may still take.

use super::Session;
use crate::design::report::{ASSUMED_RESPONSE_S, shown_s};
use crate::design::{Part, Trial};

/// How far a session is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Whether this is about practice trials.
    pub practice: bool,
    /// Place of the present or coming trial among those of its sort, from 1.
    pub trial: u32,
    /// How many of its sort there are.
    pub of: u32,
    /// How long the rest will take, practice included, at the participant's own pace.
    pub remaining_s: f64,
}

/// The participant's own pace.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    answers: u32,
    seconds: f64,
}

impl Pace {
    /// Takes in a trial that was shown in `shown_s` and answered `response_s` later.
    pub(super) fn take(&mut self, response_s: f64, shown_s: f64) {
        self.answers += 1;
        self.seconds += response_s + shown_s;
    }
}

impl Session {
    /// How far the session is; none after the last trial.
    pub fn progress(&self) -> Option<Progress> {
        let practice = self.trial()?.part == Part::Practice;
        let of_its_sort = |trial: &Trial| (trial.part == Part::Practice) == practice;
        let of = self.plan.iter().filter(|trial| of_its_sort(trial)).count() as u32;
        let left = self.queue.iter().filter(|&&place| of_its_sort(&self.plan[place])).count();
        // Until there are some answers, the protocol's own course and an assumed response time.
        let assumed = shown_s(&self.protocol, self.set.sequence_s());
        let known = f64::from(self.pace.answers);
        let each_s = (self.pace.seconds + assumed + ASSUMED_RESPONSE_S) / (known + 1.0);
        let remaining_s = self.queue.len() as f64 * each_s;
        Some(Progress { practice, trial: of - left as u32 + 1, of, remaining_s })
    }
}
