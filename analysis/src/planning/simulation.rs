//! Simulated studies: how often the groups, ζ and u find what is there.
//!
//! Each observer judges every pair by the Bradley–Terry model, with log-worths that deviate from the typical
//! ones as much as people differ. One study is drawn with as many observers as the largest number asks for;
//! its first n are the study of n, so that the numbers of observers are compared on the same chance.

use super::critical::{agreement_excess, circular_triads};
use crate::maths::random::stream;
use crate::outcome::Outcome;
use crate::paired::circular_triads::{TriadsByChance, circular_triads as triads_of};
use crate::paired::score_groups::{critical_difference, runs};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::Serialize;

/// More answers than this are not drawn: about a minute on two cores.
const MAX_ANSWERS: u64 = 1_000_000_000;

/// A complete design: every pair of stimuli, so often by each observer.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting<'a> {
    /// Log-worth of each stimulus for the typical observer.
    pub worths: &'a [f64],
    /// Standard deviation between observers of each log-worth.
    pub spread: f64,
    /// How often each observer judges each pair.
    pub times: u64,
    /// Numbers of observers, ascending.
    pub observers: &'a [u64],
    /// Level of significance.
    pub alpha: f64,
    /// Number of studies.
    pub studies: u64,
    /// Seed of all chance.
    pub seed: u64,
}

/// A mean over simulated studies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The mean.
    pub value: f64,
    /// Its Monte Carlo standard error.
    pub monte_carlo_error: f64,
}

/// What studies of so many observers find.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// Number of observers.
    pub observers: u64,
    /// Probability that any two stimuli fall into different groups. With equal worths, the level.
    pub any: Estimate,
    /// Share of the stimuli next to each other in worth that are told apart.
    pub neighbours: Estimate,
    /// Probability that the best and the worst are told apart.
    pub ends: Estimate,
    /// Probability that all neighbours are told apart.
    pub all: Estimate,
    /// Number of groups.
    pub groups: Estimate,
    /// Power of the pooled test of ζ: exact up to ten stimuli, χ² above.
    pub zeta: Outcome<Estimate>,
    /// Power of the exact test of u.
    pub u: Outcome<Estimate>,
}

/// What decides at one number of observers.
struct Critical {
    observers: u64,
    r_c: u64,
    triads: Option<u64>,
    excess: Outcome<Option<u64>>,
    least_sigma: u64,
}

const MEASURES: usize = 7;

/// Simulates studies of `setting`, one result per number of observers.
///
/// # Errors
/// Says how much would have to be drawn if that is too much.
pub fn simulate(setting: &Setting<'_>) -> Outcome<Vec<Found>> {
    let t = setting.worths.len();
    let pairs = t * (t - 1) / 2;
    let most = setting.observers.iter().max().copied().unwrap_or(0);
    let answers = [pairs as u64, setting.times, most, setting.studies];
    let answers = answers.into_iter().fold(1, u64::saturating_mul);
    if answers > MAX_ANSWERS {
        return Err(format!(
            "the simulation would draw {answers} answers, at most {MAX_ANSWERS} are drawn; ask for fewer \
             studies or observers"
        ));
    }
    let chance = (t >= 3).then(|| TriadsByChance::new(t));
    let critical: Vec<Critical> = setting
        .observers
        .iter()
        .map(|&observers| {
            let sets = observers * setting.times;
            Critical {
                observers,
                r_c: critical_difference(sets, t, setting.alpha),
                triads: chance.as_ref().and_then(|c| circular_triads(c, sets, t, setting.alpha)),
                excess: agreement_excess(sets, pairs, setting.alpha),
                least_sigma: pairs as u64 * agreeing(sets, sets / 2),
            }
        })
        .collect();
    let mut order: Vec<usize> = (0..t).collect();
    order.sort_by(|a, b| setting.worths[*b].total_cmp(&setting.worths[*a]));
    let studies: Vec<Vec<[f64; MEASURES]>> = (0..setting.studies)
        .into_par_iter()
        .map(|study| one_study(setting, &order, &critical, study))
        .collect();
    let found = |(place, critical): (usize, &Critical)| {
        let of = |measure: usize| mean(studies.iter().map(|study| study[place][measure]));
        let sets = critical.observers * setting.times;
        Found {
            observers: critical.observers,
            any: of(0),
            neighbours: of(1),
            ends: of(2),
            all: of(3),
            groups: of(4),
            zeta: if t >= 3 { Ok(of(5)) } else { Err("ζ needs at least 3 stimuli".into()) },
            u: match &critical.excess {
                _ if sets < 2 => Err("u needs at least 2 observers".into()),
                Ok(_) => Ok(of(6)),
                Err(reason) => Err(reason.clone()),
            },
        }
    };
    Ok(critical.iter().enumerate().map(found).collect())
}

/// One study, looked at after each number of observers.
fn one_study(
    setting: &Setting<'_>,
    order: &[usize],
    critical: &[Critical],
    study: u64,
) -> Vec<[f64; MEASURES]> {
    let t = setting.worths.len();
    let random = &mut stream(setting.seed, study);
    let mut votes = vec![0; t];
    // How often the first of each pair was chosen.
    let mut chosen = vec![0; t * (t - 1) / 2];
    let (mut triads, mut observers) = (0, 0);
    let mut found = Vec::with_capacity(critical.len());
    for critical in critical {
        for _ in observers..critical.observers {
            let own: Vec<f64> = setting
                .worths
                .iter()
                .map(|worth| {
                    let deviation: f64 = StandardNormal.sample(random);
                    libm::exp(worth + setting.spread * deviation)
                })
                .collect();
            for _ in 0..setting.times {
                let mut scores = vec![0; t];
                let mut pair = 0;
                for i in 0..t {
                    for j in i + 1..t {
                        let first = random.random::<f64>() * (own[i] + own[j]) < own[i];
                        chosen[pair] += u64::from(first);
                        scores[if first { i } else { j }] += 1;
                        pair += 1;
                    }
                }
                triads += if t >= 3 { triads_of(&scores) } else { 0 };
                votes.iter_mut().zip(&scores).for_each(|(sum, score)| *sum += score);
            }
        }
        observers = critical.observers;
        found.push(look(setting, order, critical, &votes, &chosen, triads));
    }
    found
}

/// What the analysis finds in a study.
fn look(
    setting: &Setting<'_>,
    order: &[usize],
    critical: &Critical,
    votes: &[u64],
    chosen: &[u64],
    triads: u64,
) -> [f64; MEASURES] {
    let apart = |a: usize, b: usize| votes[a].abs_diff(votes[b]) >= critical.r_c;
    // Stimuli of one worth are nobody's neighbours.
    let neighbours: Vec<bool> = order
        .windows(2)
        .filter(|two| setting.worths[two[0]] > setting.worths[two[1]])
        .map(|two| apart(two[0], two[1]))
        .collect();
    let mut sorted = votes.to_vec();
    sorted.sort_unstable_by(|a, b| b.cmp(a));
    let any = sorted[0] - sorted[sorted.len() - 1] >= critical.r_c;
    let sets = critical.observers * setting.times;
    let sigma: u64 = chosen.iter().map(|count| agreeing(sets, *count)).sum();
    let share = neighbours.iter().filter(|apart| **apart).count() as f64;
    let flag = |yes: bool| f64::from(u8::from(yes));
    [
        flag(any),
        share / neighbours.len().max(1) as f64,
        flag(apart(order[0], order[order.len() - 1])),
        flag(!neighbours.is_empty() && neighbours.iter().all(|apart| *apart)),
        runs(&sorted, critical.r_c).len() as f64,
        flag(critical.triads.is_some_and(|critical| triads <= critical)),
        flag(matches!(critical.excess, Ok(Some(excess)) if sigma - critical.least_sigma >= excess)),
    ]
}

/// Pairs of judgements that agree when `chosen` of `judges` choose one and the others the other.
fn agreeing(judges: u64, chosen: u64) -> u64 {
    let pairs = |n: u64| n * n.saturating_sub(1) / 2;
    pairs(chosen) + pairs(judges - chosen)
}

fn mean(values: impl Iterator<Item = f64>) -> Estimate {
    let values: Vec<f64> = values.collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    Estimate { value: mean, monte_carlo_error: libm::sqrt(squares / n / n) }
}

#[cfg(test)]
mod tests {
    use super::super::separability::separation;
    use super::*;

    fn setting<'a>(worths: &'a [f64], observers: &'a [u64], spread: f64) -> Setting<'a> {
        Setting { worths, spread, times: 1, observers, alpha: 0.05, studies: 2000, seed: 3 }
    }

    fn near(estimate: Estimate, expected: f64) {
        let error = (estimate.value - expected).abs();
        assert!(error <= 4.0 * estimate.monte_carlo_error + 1e-9, "{estimate:?}: {expected}");
    }

    #[test]
    fn two_stimuli_far_from_the_others_are_found_as_the_exact_probability_says() {
        // The best and the worst, with the others halfway between them.
        let theta = libm::log(4.0);
        let worths = [0.5 * theta, 0.0, 0.0, 0.0, -0.5 * theta];
        for found in simulate(&setting(&worths, &[10, 20], 0.0)).unwrap() {
            let r_c = critical_difference(found.observers, 5, 0.05);
            near(found.ends, separation(found.observers, 5, r_c, theta));
            // Four different worths need no fewer groups than are found.
            assert!(found.all.value <= found.neighbours.value && found.groups.value >= 1.0);
        }
    }

    #[test]
    fn guesses_keep_every_level_and_people_who_differ_do_not() {
        let [alike, differ] = [0.0, 1.5]
            .map(|spread| simulate(&setting(&[0.0; 5], &[20], spread)).unwrap().remove(0));
        for estimate in [alike.any, alike.zeta.unwrap(), alike.u.unwrap()] {
            assert!(estimate.value <= 0.05 + 4.0 * estimate.monte_carlo_error, "{estimate:?}");
        }
        assert!(differ.any.value > 0.1, "{:?}", differ.any);
        assert_eq!(alike.neighbours.value, 0.0);
    }

    #[test]
    fn the_order_of_the_stimuli_and_of_the_numbers_changes_nothing_but_chance() {
        let forward = simulate(&setting(&[1.0, 0.5, 0.0], &[8, 16], 0.3)).unwrap();
        let backward = simulate(&setting(&[0.0, 0.5, 1.0], &[8, 16], 0.3)).unwrap();
        for (one, other) in forward.iter().zip(&backward) {
            let error = one.ends.monte_carlo_error + other.ends.monte_carlo_error;
            assert!((one.ends.value - other.ends.value).abs() < 4.0 * error);
        }
        // A study of 8 is the same whether or not 16 are drawn as well.
        let alone = simulate(&setting(&[1.0, 0.5, 0.0], &[8], 0.3)).unwrap();
        assert_eq!(alone[0], forward[0]);
    }

    #[test]
    fn two_stimuli_have_no_zeta_and_one_observer_no_u() {
        let found = simulate(&setting(&[1.0, 0.0], &[1], 0.0)).unwrap().remove(0);
        assert!(found.zeta.is_err() && found.u.is_err());
        assert!(found.any.value == 0.0 && found.groups.value == 1.0);
    }

    #[test]
    fn too_many_answers_are_refused_in_words() {
        let error = simulate(&setting(&[0.0; 225], &[10_000], 0.0)).unwrap_err();
        assert!(error.contains("at most 1000000000 are drawn"), "{error}");
    }
}
