//! Goodness of fit where χ² is rough: is the deviance of the data one that the model makes?

use super::comparisons::Comparisons;
use super::fit::Estimation;
use super::goodness_of_fit::NOTHING_LEFT;
use super::model::Model;
use super::solver::Solver;
use crate::maths::p_value::PValue;
use crate::maths::random::stream;
use crate::outcome::Outcome;
use rand_distr::{Binomial, Distribution};
use rayon::prelude::*;
use serde::Serialize;

/// The test of the fit against studies simulated from the scale itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SimulatedFit {
    /// How many studies were simulated.
    pub studies: usize,
    /// The number that they follow from.
    pub seed: u64,
    /// Upper tail of the simulated deviances at the observed one, exact but for the estimated scale.
    pub p: PValue,
}

/// Simulates `studies` with the same numbers of answers from a scale fitted to connected `comparisons`, fits
/// each, and compares deviances.
///
/// # Formula
/// ```text
/// p = (1 + number of simulated deviances at or above the observed)/(1 + studies)
/// ```
/// All deviances are those of bias-reduced values, which separated studies have too (Efron and Tibshirani
/// 1993, §16.4, parametric bootstrap test).
///
/// # Errors
/// In words: ties, or other counts that are not whole; no more pairs than scale values.
pub fn simulated_fit(
    comparisons: &Comparisons,
    model: Model,
    studies: usize,
    seed: u64,
) -> Outcome<SimulatedFit> {
    let pairs = comparisons.pairs();
    if pairs.len() < comparisons.items().len() {
        return Err(NOTHING_LEFT.into());
    }
    if pairs.iter().any(|pair| pair.wins.iter().any(|count| count.fract() != 0.0))
        || comparisons.ties() > 0.0
    {
        return Err("the scale makes wins and losses only, not ties or parts of counts".into());
    }
    let (mut solver, counts) = Solver::of(comparisons, model, Estimation::BiasReduced);
    solver.solve(&counts, None)?;
    let start = solver.centred();
    let observed = solver.deviance(&counts);
    let chances: Vec<f64> =
        pairs.iter().map(|pair| model.preference(start[pair.i] - start[pair.j]).chosen).collect();
    let reaches = |(solver, counts): &mut (Solver, Vec<[f64; 2]>), index| {
        let mut random = stream(seed, index);
        for ((count, pair), chance) in counts.iter_mut().zip(pairs).zip(&chances) {
            let trials = pair.trials();
            // Whole numbers of trials and chances between 0 and 1 are always allowed.
            let wins =
                Binomial::new(trials as u64, *chance).map_or(0, |law| law.sample(&mut random));
            *count = [wins as f64, trials - wins as f64];
        }
        solver.start(&start);
        // What does not settle counts against the scale being refused.
        solver.solve(counts, None).is_err() || solver.deviance(counts) >= observed * (1.0 - 1e-9)
    };
    let reached = (0..studies as u64)
        .into_par_iter()
        .map_init(|| Solver::of(comparisons, model, Estimation::BiasReduced), reaches)
        .filter(|reached| *reached)
        .count();
    let p = PValue::new((1 + reached) as f64 / (1 + studies) as f64);
    Ok(SimulatedFit { studies, seed, p })
}
