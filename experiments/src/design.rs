//! The design: which stimuli are compared, in which order, and which of the two comes first.
//!
//! All of it follows from the protocol, a seed, and the participant's number in the study. Which of a
//! pair comes first is balanced: the pairs are the edges of a graph, which closed walks run through,
//! and each pair has the direction in which it was walked. So each stimulus is first as often as
//! second, or once more or less where its pairs are odd in number: the best there is.

mod order;
pub mod report;

pub use report::DesignReport;

use crate::random::Stream;
use indexmap::IndexMap;
use order::{balanced_flags, orient, rounds, williams_row};
use shutterlab_data_schema::Protocol;
use shutterlab_data_schema::protocol::{Orders, Pairs, Sequence, Task};
use shutterlab_data_schema::response::{Answer, Side};

/// The axes of simplified models. Their originals have no r.
const LEVEL_OF_DETAIL: &str = "level_of_detail";
pub(crate) const R: &str = "r";

/// What a design is made of: the stimuli 0..n by their levels, and the pairs with a right answer.
#[derive(Clone, Debug, Default)]
pub struct Pool {
    /// Level per axis of each compared stimulus.
    pub levels: Vec<IndexMap<String, String>>,
    /// Practice pairs: indices of better and worse, which need not be among the compared.
    pub practice: Vec<(usize, usize)>,
    /// Catch pairs.
    pub catch: Vec<(usize, usize)>,
}

impl Pool {
    /// The stimuli that `protocol` names, before any is rendered: all combinations of its levels, as if
    /// every axis that it does not name had one level. Which stimuli practice and catch pairs show is left open.
    /// Where the ground truth is the original of a model, it is there once for all r.
    pub fn named_by(protocol: &Protocol) -> Self {
        let levels: Vec<IndexMap<String, String>> =
            protocol.stimuli.iter().fold(vec![IndexMap::new()], |cells, (axis, levels)| {
                let with = |cell: &IndexMap<String, String>, level: &String| {
                    let mut cell = cell.clone();
                    cell.insert(axis.clone(), level.clone());
                    cell
                };
                cells.iter().flat_map(|cell| levels.iter().map(|l| with(cell, l))).collect()
            });
        let original = protocol.design.ground_truth.get(LEVEL_OF_DETAIL);
        let mut different: Vec<IndexMap<String, String>> = vec![];
        for mut cell in levels {
            if original.is_some() && cell.get(LEVEL_OF_DETAIL) == original {
                cell.shift_remove(R);
            }
            if !different.contains(&cell) {
                different.push(cell);
            }
        }
        let levels = different;
        let other = (levels.len(), levels.len() + 1);
        Self {
            practice: vec![other; protocol.practice.len()],
            catch: vec![other; protocol.catch.len()],
            levels,
        }
    }
}

/// The stimuli do not make the design.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum DesignError {
    /// No two stimuli differ in one axis only.
    #[error(
        "protocol {0}: design.pairs: one-axis: no two of the stimuli differ in exactly one axis; name more levels of an axis"
    )]
    NoPairs(String),
    /// A stimulus has no ground truth among the others.
    #[error(
        "protocol {protocol}: design.ground_truth: {truth}: there is no such stimulus to compare {stimulus} with; add its levels to `stimuli`"
    )]
    NoTruth {
        /// Name of the protocol.
        protocol: String,
        /// Levels of the ground truth.
        truth: String,
        /// Levels of the stimulus.
        stimulus: String,
    },
}

/// What a trial is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Asked first, so that the question is understood.
    Practice,
    /// What the session is about.
    Test,
    /// Asked in between, with a right answer, to see whether the observer attends.
    Catch,
}

/// One question of a session. Stimuli are indices into a [`StimulusSet`](crate::stimuli_set::StimulusSet).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Place in the session, from 1, practice included.
    pub number: u32,
    /// Run of trials between two breaks, from 1; 0 for practice.
    pub block: u32,
    /// How often this pair has been asked in the session among the trials that count, from 1; 1 in
    /// practice and catch trials.
    pub repetition: u32,
    /// What it is for.
    pub part: Part,
    /// Stimulus A: the one of the two that comes first in the set.
    pub a: usize,
    /// Stimulus B.
    pub b: usize,
    /// Which of the two is shown first, or on the left.
    pub first: Side,
    /// The reference (matching) or ground truth (same-different).
    pub reference: Option<Side>,
    /// The right answer, where there is one.
    pub right: Option<Answer>,
}

/// What is shown at once in one interval of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// One stimulus in the middle.
    Middle(Side),
    /// The reference, above the middle.
    Reference(Side),
    /// A candidate, below the middle on the left.
    Left(Side),
    /// A candidate, below the middle on the right.
    Right(Side),
    /// Two side by side, this one on the left.
    Both(Side),
}

impl Trial {
    /// What it shows, interval after interval.
    pub fn intervals(&self, task: Task) -> Vec<Shows> {
        let (first, second) = (self.first, self.first.other());
        match task {
            Task::TwoAfc => vec![Shows::Middle(first), Shows::Middle(second)],
            Task::Matching => vec![
                Shows::Reference(self.reference.unwrap_or(first)),
                Shows::Left(first),
                Shows::Right(second),
            ],
            Task::SameDifferent => vec![Shows::Both(first)],
        }
    }

    /// The side that `answer` selects, if it selects one.
    pub fn selected(&self, answer: Answer) -> Option<Side> {
        match answer {
            Answer::First => Some(self.first),
            Answer::Second => Some(self.first.other()),
            Answer::Same | Answer::Different | Answer::NotSure => None,
        }
    }

    /// The answer that selects `side`.
    pub fn selecting(&self, side: Side) -> Answer {
        if side == self.first { Answer::First } else { Answer::Second }
    }

    /// The stimulus on `side`.
    pub fn stimulus(&self, side: Side) -> usize {
        match side {
            Side::A => self.a,
            Side::B => self.b,
        }
    }
}

/// A pair and which of the two is named: first, reference or ground truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pair {
    a: usize,
    b: usize,
    named: Side,
    /// Whether the named one stands left, where two are shown side by side.
    left: bool,
}

impl Pair {
    fn turned(self) -> Self {
        Self { named: self.named.other(), ..self }
    }

    /// The trial that asks it.
    fn trial(self, task: Task) -> Trial {
        let Self { a, b, named, left } = self;
        let (first, reference, right) = match task {
            Task::TwoAfc => (named, None, None),
            Task::Matching | Task::SameDifferent => {
                let first = if left { named } else { named.other() };
                let right = match task {
                    Task::SameDifferent if a == b => Answer::Same,
                    Task::SameDifferent => Answer::Different,
                    _ if left => Answer::First,
                    _ => Answer::Second,
                };
                (first, Some(named), Some(right))
            }
        };
        let part = Part::Test;
        Trial { number: 0, block: 0, repetition: 1, part, a, b, first, reference, right }
    }
}

/// The trials of one session: practice, then the pairs of the design with the catch trials among them.
/// `ordinal` is the participant's number in the study, from 1.
///
/// # Errors
/// The stimuli do not make the design.
pub fn plan(
    protocol: &Protocol,
    pool: &Pool,
    seed: u64,
    ordinal: u32,
) -> Result<Vec<Trial>, DesignError> {
    let design = &protocol.design;
    let mut stream = Stream::new(seed);
    let blocks = match design.pairs {
        Pairs::GroundTruth => vec![ground_truth_pairs(protocol, pool, &mut stream)?],
        Pairs::All | Pairs::OneAxis => {
            let mut blocks = compared_pairs(protocol, pool, &mut stream, ordinal)?;
            place(blocks.iter_mut().flatten(), &mut stream);
            blocks
        }
    };
    let practice = obvious(protocol.task, &pool.practice, Part::Practice, &mut stream);
    let catch = obvious(protocol.task, &pool.catch, Part::Catch, &mut stream);
    let mut tests = Vec::new();
    for (block, pairs) in (1..).zip(blocks) {
        tests.extend(pairs.iter().map(|pair| Trial { block, ..pair.trial(protocol.task) }));
    }
    count_repetitions(&mut tests);
    spread(&mut tests, catch, &mut stream);
    if let (Some(length), Sequence::Random) = (design.trials_between_breaks, design.sequence) {
        for (counting, trial) in (0..).zip(&mut tests) {
            trial.block = 1 + counting / length;
        }
    }
    let trials = practice.into_iter().chain(tests);
    Ok((1..).zip(trials).map(|(number, trial)| Trial { number, ..trial }).collect())
}

/// The pairs of stimuli with stimuli, block by block, all repetitions.
fn compared_pairs(
    protocol: &Protocol,
    pool: &Pool,
    stream: &mut Stream,
    ordinal: u32,
) -> Result<Vec<Vec<Pair>>, DesignError> {
    let design = &protocol.design;
    let rounds = rounds(&pool.levels, design.pairs);
    let edges: Vec<(usize, usize)> = rounds.iter().flatten().copied().collect();
    if edges.is_empty() {
        return Err(DesignError::NoPairs(protocol.name.clone()));
    }
    let directions = orient(&edges, pool.levels.len(), stream);
    let named: IndexMap<(usize, usize), Side> = edges.into_iter().zip(directions).collect();
    let pair = |&(a, b): &(usize, usize)| Pair { a, b, named: named[&(a, b)], left: false };
    let rounds: Vec<Vec<Pair>> =
        rounds.iter().map(|round| round.iter().map(pair).collect()).collect();
    let turned: Vec<Vec<Pair>> =
        rounds.iter().map(|round| round.iter().map(|pair| pair.turned()).collect()).collect();

    let mut order = Vec::new();
    for repetition in 0..design.repetitions {
        // What one repetition asks: every pair in one order, or in both.
        let pass: Vec<Vec<Pair>> = match (design.orders, repetition % 2) {
            (Orders::Balanced, 0) => rounds.clone(),
            (Orders::Balanced, _) => turned.clone(),
            (Orders::Both, _) => rounds.iter().chain(&turned).cloned().collect(),
        };
        match design.sequence {
            Sequence::Random => {
                let mut pairs = pass.concat();
                stream.shuffle(&mut pairs);
                order.push(pairs);
            }
            Sequence::RoundRobin | Sequence::LatinSquare => {
                let mut pass = pass;
                if design.sequence == Sequence::RoundRobin {
                    stream.shuffle(&mut pass);
                } else {
                    let row = williams_row(pass.len(), ordinal.saturating_sub(1) as usize);
                    pass = row.into_iter().map(|round| pass[round].clone()).collect();
                }
                for round in &mut pass {
                    stream.shuffle(round);
                }
                order.extend(pass);
            }
        }
    }
    Ok(match design.sequence {
        Sequence::Random => vec![order.concat()],
        Sequence::RoundRobin | Sequence::LatinSquare => {
            whole_rounds(order, design.trials_between_breaks)
        }
    })
}

/// Puts rounds together into blocks of at least `length` pairs, or all into one.
fn whole_rounds(rounds: Vec<Vec<Pair>>, length: Option<u32>) -> Vec<Vec<Pair>> {
    let mut blocks: Vec<Vec<Pair>> = Vec::new();
    for round in rounds {
        match blocks.last_mut() {
            Some(block) if length.is_none_or(|length| block.len() < length as usize) => {
                block.extend(round);
            }
            _ => blocks.push(round),
        }
    }
    blocks
}

/// Every stimulus with its ground truth, and each ground truth with itself, all repetitions.
fn ground_truth_pairs(
    protocol: &Protocol,
    pool: &Pool,
    stream: &mut Stream,
) -> Result<Vec<Pair>, DesignError> {
    let design = &protocol.design;
    let mut pairs = Vec::new();
    for (candidate, levels) in pool.levels.iter().enumerate() {
        let mut wanted = levels.clone();
        for (axis, level) in &design.ground_truth {
            wanted.insert(axis.clone(), level.clone());
        }
        let names = |levels: &IndexMap<String, String>| {
            levels.values().map(String::as_str).collect::<Vec<_>>().join("-")
        };
        // The original of a model has no r.
        let is_wanted = |levels: &IndexMap<String, String>| {
            let is_level = |(axis, level): (&String, &String)| match levels.get(axis) {
                Some(own) => own == level,
                None => axis == R,
            };
            levels.keys().all(|axis| wanted.contains_key(axis)) && wanted.iter().all(is_level)
        };
        let truth = pool.levels.iter().position(is_wanted);
        let truth = truth.ok_or_else(|| DesignError::NoTruth {
            protocol: protocol.name.clone(),
            truth: names(&wanted),
            stimulus: names(levels),
        })?;
        let named = if truth <= candidate { Side::A } else { Side::B };
        let (a, b) = (truth.min(candidate), truth.max(candidate));
        let pair = Pair { a, b, named, left: false };
        let times = if truth == candidate { design.identical_pairs } else { 1 };
        pairs.extend(std::iter::repeat_n(pair, times as usize));
    }
    place(pairs.iter_mut(), stream);
    let other_way = |pairs: &[Pair]| -> Vec<Pair> {
        pairs.iter().map(|pair| Pair { left: !pair.left, ..*pair }).collect()
    };
    let mut all = Vec::new();
    for repetition in 0..design.repetitions {
        let mut pass = match (design.orders, repetition % 2) {
            (Orders::Balanced, 0) => pairs.clone(),
            (Orders::Balanced, _) => other_way(&pairs),
            (Orders::Both, _) => [pairs.clone(), other_way(&pairs)].concat(),
        };
        stream.shuffle(&mut pass);
        all.extend(pass);
    }
    Ok(all)
}

/// Lets the named one stand left in half of the pairs.
fn place<'a>(pairs: impl Iterator<Item = &'a mut Pair>, stream: &mut Stream) {
    let pairs: Vec<&mut Pair> = pairs.collect();
    let flags = balanced_flags(pairs.len(), stream);
    for (pair, left) in pairs.into_iter().zip(flags) {
        pair.left = left;
    }
}

/// The trials about pairs of better and worse.
fn obvious(task: Task, pairs: &[(usize, usize)], part: Part, stream: &mut Stream) -> Vec<Trial> {
    let pair = |&(better, worse): &(usize, usize)| Pair {
        a: better.min(worse),
        b: better.max(worse),
        named: if better <= worse { Side::A } else { Side::B },
        left: false,
    };
    let mut pairs: Vec<Pair> = pairs.iter().map(pair).collect();
    place(pairs.iter_mut(), stream);
    let trial = |pair: &Pair| {
        let mut trial = Trial { part, ..pair.trial(task) };
        if task == Task::TwoAfc {
            trial.first = if pair.left { pair.named } else { pair.named.other() };
            trial.right = Some(trial.selecting(pair.named));
        }
        trial
    };
    pairs.iter().map(trial).collect()
}

/// Numbers how often each pair has come.
fn count_repetitions(trials: &mut [Trial]) {
    let mut times = std::collections::HashMap::new();
    for trial in trials {
        let count = times.entry((trial.a, trial.b)).or_insert(0);
        *count += 1;
        trial.repetition = *count;
    }
}

/// Puts the catch trials among the others, one into each equal part, never as the very first.
fn spread(tests: &mut Vec<Trial>, catch: Vec<Trial>, stream: &mut Stream) {
    let (all, parts) = (tests.len(), catch.len().max(1));
    let mut places: Vec<usize> = (0..catch.len())
        .map(|part| {
            let (start, end) = (all * part / parts, all * (part + 1) / parts);
            start + 1 + stream.below((end - start).max(1))
        })
        .collect();
    places.reverse();
    let mut catch = catch;
    stream.shuffle(&mut catch);
    for (place, trial) in places.into_iter().zip(catch) {
        let place = place.min(tests.len());
        let block = tests.get(place.saturating_sub(1)).map_or(1, |before| before.block);
        tests.insert(place, Trial { block, ..trial });
    }
}

#[cfg(test)]
mod tests;
