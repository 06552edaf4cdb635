//! What a design comes to, said before anybody sits down.

use super::{Part, Trial};
use serde::Serialize;
use shutterlab_data_schema::Protocol;
use shutterlab_data_schema::response::Side;
use std::fmt;

/// How much one session asks, and how balanced it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignReport {
    /// Stimuli that are compared.
    pub stimuli: usize,
    /// Different pairs of them.
    pub pairs: usize,
    /// Trials that count.
    pub trials: usize,
    /// Practice trials.
    pub practice: usize,
    /// Catch trials.
    pub catch: usize,
    /// Runs of trials between breaks.
    pub blocks: usize,
    /// How often a stimulus comes first, or on the left: the least and the most.
    pub first: [usize; 2],
    /// How long it takes if each answer takes [`ASSUMED_RESPONSE_S`] and nothing is seen again.
    pub seconds: f64,
}

/// Response time that the estimate of a session's length assumes.
pub const ASSUMED_RESPONSE_S: f64 = 2.0;

impl DesignReport {
    /// The report about `trials`, whose sequences last `sequence_s`.
    pub fn new(protocol: &Protocol, trials: &[Trial], sequence_s: f64) -> Self {
        let of = |part: Part| trials.iter().filter(move |trial| trial.part == part);
        let mut pairs: Vec<(usize, usize)> = of(Part::Test).map(|t| (t.a, t.b)).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut stimuli: Vec<usize> = pairs.iter().flat_map(|&(a, b)| [a, b]).collect();
        stimuli.sort_unstable();
        stimuli.dedup();
        let first = |item: &usize| of(Part::Test).filter(|t| t.stimulus(t.first) == *item).count();
        let counts: Vec<usize> = stimuli.iter().map(first).collect();
        Self {
            stimuli: stimuli.len(),
            pairs: pairs.len(),
            trials: of(Part::Test).count(),
            practice: of(Part::Practice).count(),
            catch: of(Part::Catch).count(),
            blocks: trials.iter().map(|t| t.block as usize).max().unwrap_or(0),
            first: [
                counts.iter().min().copied().unwrap_or(0),
                counts.iter().max().copied().unwrap_or(0),
            ],
            seconds: trials.len() as f64 * (shown_s(protocol, sequence_s) + ASSUMED_RESPONSE_S),
        }
    }
}

/// How long a trial is before its question.
pub fn shown_s(protocol: &Protocol, sequence_s: f64) -> f64 {
    let timeline = &protocol.timeline;
    let trial = Trial {
        number: 1,
        block: 1,
        repetition: 1,
        part: Part::Test,
        a: 0,
        b: 1,
        first: Side::A,
        reference: None,
        right: None,
    };
    let intervals = trial.intervals(protocol.task).len() as f64;
    let interval_s = timeline.still.map_or(sequence_s, |still| still.seconds);
    timeline.fixation_s + intervals * (timeline.gap_s + interval_s)
}

impl fmt::Display for DesignReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { stimuli, pairs, trials, practice, catch, blocks, first: [least, most], seconds } =
            self;
        let block = if *blocks == 1 { "block" } else { "blocks" };
        let times = if least == most { least.to_string() } else { format!("{least} to {most}") };
        let minutes = (seconds / 60.0).round().max(1.0);
        let minute = if minutes > 1.0 { "minutes" } else { "minute" };
        write!(
            f,
            "{stimuli} stimuli, {pairs} pairs, {trials} trials in {blocks} {block}, {practice} of \
             practice and {catch} to catch; each stimulus comes first {times} times; about {minutes} \
             {minute}"
        )
    }
}
