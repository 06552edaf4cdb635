//! Accuracy of matching by reference and foil, by pair, and by level.

use super::{Answer, CHANCE, right_by_observer};
use crate::categories::accuracy::Accuracy;
use crate::categories::discrimination::Strategy;
use crate::categories::forced_choice::{ForcedChoice, ForcedChoiceDPrime};
use crate::categories::merged;
use crate::categories::resampled::{Resampled, forced_choice};
use crate::categories::trials::{MatchingTrial, Trials};
use crate::maths::corrections::holm;
use crate::maths::p_value::PValue;
use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;
use std::collections::BTreeSet;

/// Accuracy for one reference and one foil.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Level of the reference.
    pub reference: String,
    /// Level of the other candidate.
    pub foil: String,
    /// Right answers against chance.
    #[serde(flatten)]
    pub accuracy: Accuracy,
    /// p by Holm's correction over the cells.
    pub p_holm: PValue,
}

/// Accuracy for a pair of levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// The two levels.
    pub levels: [String; 2],
    /// Right answers against chance.
    pub accuracy: Accuracy,
    /// p by Holm's correction over the pairs.
    pub p_holm: PValue,
    /// Whether the levels were told apart: `p_holm` is at most alpha.
    pub told_apart: bool,
    /// d′ by differencing, for observers without side bias.
    pub d_prime: Outcome<Resampled<ForcedChoiceDPrime>>,
    /// d′ by independent observations, for the same.
    pub d_prime_independent: Outcome<Resampled<ForcedChoiceDPrime>>,
}

serialize_outcomes!(Pair, [levels, accuracy, p_holm, told_apart], [d_prime, d_prime_independent]);

/// Accuracy for a level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Level {
    /// The level.
    pub level: String,
    /// Trials in which it was the reference (recall); none without answers.
    pub as_reference: Option<Accuracy>,
    /// Trials in which it was the foil.
    pub as_foil: Option<Accuracy>,
    /// Of the trials in which it was chosen, those in which it was right (precision).
    pub when_chosen: Option<Accuracy>,
}

/// Accuracy of the answers that are `wanted`; none without answers.
fn accuracy(answers: &[Answer], wanted: impl Fn(&Answer) -> bool) -> Option<Accuracy> {
    let of = answers.iter().filter(|answer| wanted(answer));
    let right = of.clone().filter(|answer| answer.correct()).count();
    Accuracy::new(right as u64, of.count() as u64, CHANCE).ok()
}

/// p against chance by Holm's correction over all of them.
fn corrected<'a>(accuracies: impl Iterator<Item = &'a Accuracy>) -> Vec<PValue> {
    let p: Vec<f64> = accuracies.filter_map(|of| Some(of.p_above_chance?.value())).collect();
    holm(&p).into_iter().map(PValue::new).collect()
}

pub(super) fn cells(study: &Trials<MatchingTrial>, answers: &[Answer]) -> Vec<Cell> {
    let asked: BTreeSet<(usize, usize)> = answers.iter().map(|a| (a.reference, a.foil)).collect();
    let found: Vec<(usize, usize, Accuracy)> = asked
        .into_iter()
        .filter_map(|(reference, foil)| {
            let of = accuracy(answers, |a| (a.reference, a.foil) == (reference, foil))?;
            Some((reference, foil, of))
        })
        .collect();
    let p = corrected(found.iter().map(|(.., accuracy)| accuracy));
    found
        .into_iter()
        .zip(p)
        .map(|((reference, foil, accuracy), p_holm)| Cell {
            reference: study.levels[reference].clone(),
            foil: study.levels[foil].clone(),
            accuracy,
            p_holm,
        })
        .collect()
}

/// The pairs with answers, for people and for merging.
pub(super) fn pairs(
    study: &Trials<MatchingTrial>,
    answers: &[Answer],
    alpha: f64,
) -> (Vec<Pair>, Vec<merged::Pair>) {
    let pair = |a: &Answer| [a.reference.min(a.foil), a.reference.max(a.foil)];
    let asked: BTreeSet<[usize; 2]> = answers.iter().map(pair).collect();
    let found: Vec<([usize; 2], Accuracy)> = asked
        .into_iter()
        .filter_map(|levels| Some((levels, accuracy(answers, |a| pair(a) == levels)?)))
        .collect();
    let p = corrected(found.iter().map(|(_, accuracy)| accuracy));
    found
        .into_iter()
        .zip(p)
        .map(|((levels, accuracy), p_holm)| {
            let of = answers.iter().filter(|a| pair(a) == levels);
            let right = right_by_observer(study, of);
            let d_prime = |strategy| forced_choice(ForcedChoice::Abx(strategy), &right);
            let told_apart = p_holm.value() <= alpha;
            let Accuracy { correct, trials, .. } = accuracy;
            let of_people = Pair {
                levels: levels.map(|level| study.levels[level].clone()),
                accuracy,
                p_holm,
                told_apart,
                d_prime: d_prime(Strategy::Differencing),
                d_prime_independent: d_prime(Strategy::IndependentObservations),
            };
            (of_people, merged::Pair { levels, correct, trials, told_apart })
        })
        .unzip()
}

pub(super) fn per_level(study: &Trials<MatchingTrial>, answers: &[Answer]) -> Vec<Level> {
    let names = study.levels.iter().enumerate();
    names
        .map(|(level, name)| Level {
            level: name.clone(),
            as_reference: accuracy(answers, |answer| answer.reference == level),
            as_foil: accuracy(answers, |answer| answer.foil == level),
            when_chosen: accuracy(answers, |answer| answer.chosen() == level),
        })
        .collect()
}
