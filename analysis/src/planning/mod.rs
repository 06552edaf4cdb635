//! Planning: what a study of so many observers can find, before the first of them comes.
//!
//! [`plan`] goes from a [`Design`] (the pairs that each observer judges) and stated [`Assumptions`] to power,
//! precision and the groups to be expected, against the number of observers. It is exact where that is
//! possible, an approximation where said, and simulates the rest with Monte Carlo errors beside it.

mod advice;
pub mod critical;
pub mod design;
pub mod power;
pub mod precision;
pub mod rating;
mod scores;
mod section;
mod section_scores;
pub mod separability;
pub mod share;
pub mod simulation;

pub use design::{AskedPair, Assumptions, Comparison, Design};
pub use scores::{ScaleRow, ScoreRow};
pub use section::sections;

use crate::error::InputError;
use crate::outcome::{Outcome, entry};
use power::Sides;
use rating::RatingRow;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use share::ShareTest;
use shutterlab_data_schema::protocol::Task;
use simulation::{Found, Setting, simulate};
use std::collections::BTreeMap;

/// What a protocol can find, against the number of observers. What does not apply to its task or design
/// says why.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What is asked.
    pub design: Design,
    /// What is assumed.
    pub assumptions: Assumptions,
    /// The answers to one pair: a preference, or how often the match is found.
    pub pair: Outcome<ShareTest>,
    /// The comparisons of two levels of an axis over all pairs that differ in nothing else.
    pub levels: Outcome<Vec<(Vec<Comparison>, ShareTest)>>,
    /// All answers that are right or wrong, together.
    pub accuracy: Outcome<ShareTest>,
    /// Ratings: how often a pair is called the same.
    pub rating: Outcome<Vec<RatingRow>>,
    /// Groups by score differences.
    pub scores: Outcome<Vec<ScoreRow>>,
    /// The Bradley–Terry scale.
    pub scale: Outcome<Vec<ScaleRow>>,
    /// Simulated studies of the assumed worths.
    pub simulated: Outcome<Simulated>,
    /// What to do, in one sentence.
    pub advice: String,
}

/// How each part is computed.
const HOW: [(&str, &str); 7] = [
    ("pair", "exact; if people differ, by design effect: approximate"),
    ("levels", "exact; if people differ, by design effect: approximate"),
    ("accuracy", "exact; if people differ, by design effect: approximate"),
    ("rating", "exact, answers independent"),
    ("scores", "exact, answers independent"),
    ("scale", "Fisher information; tests by normal approximation"),
    ("simulated", "simulated, Monte Carlo errors beside"),
];

/// Simulated studies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Simulated {
    /// With the assumed worths, all observers alike.
    pub alike: Vec<Found>,
    /// With the assumed worths, and observers who differ.
    pub differ: Vec<Found>,
    /// With equal worths, all observers alike: what is found is false.
    pub equal_alike: Vec<Found>,
    /// With worths that are equal on the whole, and observers who differ.
    pub equal_differ: Vec<Found>,
    /// Two stimuli at the assumed effect, the others halfway between them, and observers who differ.
    pub effect_differ: Vec<Found>,
}

/// Plans a study of `design` under `assumptions`.
///
/// # Errors
/// A number is out of range, or the design asks nothing.
pub fn plan(design: &Design, assumptions: &Assumptions) -> Result<Plan, InputError> {
    assumptions.check(design)?;
    design.check()?;
    let Assumptions { observers, alpha, spread, .. } = assumptions;
    let test = |answers: u64, sides: Sides, sd: f64| {
        ShareTest::new(observers, answers, *alpha, &assumptions.shares(), sides, sd)
    };
    // The log-odds of a preference are the difference of two log-worths.
    let preference = |answers| test(answers, Sides::Two, std::f64::consts::SQRT_2 * spread);
    let right = |answers| test(answers, Sides::One, *spread);
    let is_2afc = design.task == Task::TwoAfc;
    let only_2afc = || format!("the task {} tells no preferences", design.task.name());
    let pair = match (design.task, design.times()) {
        (Task::SameDifferent, _) => {
            Err("\"the same\" about one pair has no chance level; see its rating".into())
        }
        (_, Err(reason)) => Err(reason),
        (Task::TwoAfc, Ok(times)) => Ok(preference(times)),
        (Task::Matching, Ok(times)) => Ok(right(times)),
    };
    let levels = if is_2afc { design.comparisons() } else { Err(only_2afc()) };
    let levels = levels
        .map(|groups| groups.into_iter().map(|(answers, of)| (of, preference(answers))).collect());
    let accuracy = match is_2afc {
        true => Err("a preference is neither right nor wrong".into()),
        false => Ok(right(design.answers())),
    };
    let rating = match design.task {
        Task::SameDifferent => design.times().map(|times| rating::rows(observers, times)),
        _ => Err("only the task same-different has ratings".into()),
    };
    let worths = assumptions.log_worths(design);
    let complete = if is_2afc { design.complete() } else { Err(only_2afc()) };
    let scores = complete.clone().map(|times| scores::score_rows(design, assumptions, times));
    let scale = match is_2afc {
        true => scores::scale_rows(design, assumptions, &worths),
        false => Err(only_2afc()),
    };
    let simulated = complete.and_then(|times| simulate_all(assumptions, &worths, times));
    let mut plan = Plan {
        design: design.clone(),
        assumptions: assumptions.clone(),
        pair,
        levels,
        accuracy,
        rating,
        scores,
        scale,
        simulated,
        advice: String::new(),
    };
    plan.advice = advice::advice(&plan);
    Ok(plan)
}

fn simulate_all(assumptions: &Assumptions, worths: &[f64], times: u64) -> Outcome<Simulated> {
    let equal = vec![0.0; worths.len()];
    let mut effect = equal.clone();
    let theta = scores::log_odds(assumptions.effect);
    (effect[0], effect[worths.len() - 1]) = (0.5 * theta, -0.5 * theta);
    let run = |worths: &[f64], spread: f64| {
        simulate(&Setting {
            worths,
            spread,
            times,
            observers: &assumptions.observers,
            alpha: assumptions.alpha,
            studies: assumptions.studies,
            seed: assumptions.seed,
        })
    };
    Ok(Simulated {
        alike: run(worths, 0.0)?,
        differ: run(worths, assumptions.spread)?,
        equal_alike: run(&equal, 0.0)?,
        equal_differ: run(&equal, assumptions.spread)?,
        effect_differ: run(&effect, assumptions.spread)?,
    })
}

impl Serialize for Plan {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("advice", &self.advice)?;
        map.serialize_entry("design", &self.design)?;
        map.serialize_entry("assumptions", &self.assumptions)?;
        map.serialize_entry("how", &BTreeMap::from(HOW))?;
        entry(&mut map, "pair", &self.pair)?;
        entry(&mut map, "levels", &self.levels)?;
        entry(&mut map, "accuracy", &self.accuracy)?;
        entry(&mut map, "rating", &self.rating)?;
        entry(&mut map, "scores", &self.scores)?;
        entry(&mut map, "scale", &self.scale)?;
        entry(&mut map, "simulated", &self.simulated)?;
        map.end()
    }
}
