//! Bootstrap intervals of scale values: what if other observers of the same kind had answered?

use super::comparisons::Comparisons;
use super::connection::{check_connected, separation};
use super::fit::Estimation;
use super::model::Model;
use super::solver::{Solver, deviance};
use crate::maths::bootstrap::{MIN_OBSERVERS, expanded_percentile_95};
use crate::maths::random::stream;
use crate::outcome::Outcome;
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde::Serialize;

/// Scale values of studies made of resampled observers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bootstrap {
    /// What the values say about choices.
    pub model: Model,
    /// How many observers were drawn for each replicate, as many as there were.
    pub observers: usize,
    /// How many replicates were drawn.
    pub replicates: usize,
    /// In how many of them the groups of items are separated, so that no maximum-likelihood values exist.
    pub separated: usize,
    /// How many were left out because they lack the pairs that connect the items.
    pub unconnected: usize,
    /// The number that the draws follow from.
    pub seed: u64,
    /// Scale values of each replicate that was not left out, with sum zero.
    #[serde(skip)]
    pub values: Vec<Vec<f64>>,
}

/// Draws `replicates` times as many of the `observers` as there are, with replacement, and fits
/// bias-reduced scale values to their answers. The result does not depend on the number of threads.
///
/// All replicates are fitted by bias reduction because it gives values for separated replicates too, and
/// because maximum-likelihood values of resampled answers would be biased away from each other twice.
///
/// # Errors
/// In words: the comparisons are not connected, or they are separated, so that no resampled study holds
/// the choice that would bound the values; or there are fewer than five observers.
pub fn bootstrap(
    observers: &[Comparisons],
    model: Model,
    replicates: usize,
    seed: u64,
) -> Outcome<Bootstrap> {
    let pooled = Comparisons::pooled(observers);
    check_connected(&pooled)?;
    if separation(&pooled).is_some() {
        return Err(
            "groups of items are separated, and resampling makes no choice that nobody made".into(),
        );
    }
    let n = observers.len();
    if n < MIN_OBSERVERS {
        return Err(format!(
            "at least {MIN_OBSERVERS} observers are needed to resample them, not {n}"
        ));
    }
    let (mut solver, counts) = Solver::of(&pooled, model, Estimation::BiasReduced);
    solver.solve(&counts, None)?;
    let start = solver.centred();
    let study = Study { answers: answers(observers, &pooled, model, &start), start, pooled };
    let drawn: Vec<Replicate> = (0..replicates as u64)
        .into_par_iter()
        .map_init(
            || (Solver::of(&study.pooled, model, Estimation::BiasReduced), vec![]),
            |((solver, counts), reached), index| {
                study.replicate(&mut stream(seed, index), solver, counts, reached)
            },
        )
        .collect();
    let unconnected = drawn.iter().filter(|drawn| drawn.values.is_none()).count();
    if unconnected > replicates / 20 {
        return Err(format!(
            "in {unconnected} of {replicates} replicates pairs that connect the items are missing"
        ));
    }
    Ok(Bootstrap {
        model,
        observers: n,
        replicates,
        separated: drawn.iter().filter(|drawn| drawn.separated).count(),
        unconnected,
        seed,
        values: drawn.into_iter().filter_map(|drawn| drawn.values).collect(),
    })
}

impl Bootstrap {
    /// The 95 % interval of what `of` computes from scale values: Hesterberg's (2015) expanded percentiles.
    pub fn interval_95(&self, of: impl Fn(&[f64]) -> f64) -> [f64; 2] {
        let values = self.values.iter().map(|values| of(values)).collect();
        expanded_percentile_95(values, self.observers)
    }
}

/// What replicates are drawn from.
struct Study {
    pooled: Comparisons,
    /// Per observer, the wins of either side of each pair of `pooled`.
    answers: Vec<Vec<[f64; 2]>>,
    /// Where the fits start.
    start: Vec<f64>,
}

struct Replicate {
    separated: bool,
    values: Option<Vec<f64>>,
}

/// The answers of the `observers` in an order that follows from what they answered, so that neither the
/// order of observers nor that of items changes what is drawn: by their likelihood at the `values` of all.
fn answers(
    observers: &[Comparisons],
    pooled: &Comparisons,
    model: Model,
    values: &[f64],
) -> Vec<Vec<[f64; 2]>> {
    let mut observers: Vec<(f64, &Comparisons)> = observers
        .iter()
        .map(|observer| (deviance(model, values, observer.answers()), observer))
        .collect();
    observers.sort_by(|a, b| a.0.total_cmp(&b.0));
    let place = |i, j| pooled.pairs().partition_point(|pair| (pair.i, pair.j) < (i, j));
    let of_one = |(_, observer): (f64, &Comparisons)| {
        let mut answers = vec![[0.0; 2]; pooled.pairs().len()];
        for ((i, j), wins) in observer.answers() {
            answers[place(i, j)] = wins;
        }
        answers
    };
    observers.into_iter().map(of_one).collect()
}

impl Study {
    fn replicate(
        &self,
        random: &mut Pcg64,
        solver: &mut Solver,
        counts: &mut [[f64; 2]],
        reached: &mut Vec<bool>,
    ) -> Replicate {
        counts.fill([0.0; 2]);
        for _ in &self.answers {
            let observer = &self.answers[random.random_range(0..self.answers.len())];
            for (sum, wins) in counts.iter_mut().zip(observer) {
                sum[0] += wins[0];
                sum[1] += wins[1];
            }
        }
        let mut all_reached = |edge: fn(&[f64; 2]) -> [bool; 2]| {
            reached.clear();
            reached.resize(self.pooled.items().len(), false);
            reached[0] = true;
            loop {
                let mut more = false;
                for (pair, wins) in self.pooled.pairs().iter().zip(&*counts) {
                    let [forward, backward] = edge(wins);
                    let (i, j) = (reached[pair.i], reached[pair.j]);
                    if i != j && (if i { forward } else { backward }) {
                        (reached[pair.i], reached[pair.j]) = (true, true);
                        more = true;
                    }
                }
                if !more {
                    return reached.iter().all(|reached| *reached);
                }
            }
        };
        let separated = !all_reached(|wins| [wins[0] > 0.0, wins[1] > 0.0])
            || !all_reached(|wins| [wins[1] > 0.0, wins[0] > 0.0]);
        if separated && !all_reached(|wins| [wins[0] + wins[1] > 0.0; 2]) {
            return Replicate { separated, values: None };
        }
        solver.start(&self.start);
        let values = solver.solve(counts, None).ok().map(|()| solver.centred());
        Replicate { separated, values }
    }
}
