//! A preference model that allows for people who differ: logistic, with observers as clusters.
//!
//! The pooled tests count the answers of one observer as independent. Here the coefficients are those of
//! the same logistic model (Bradley and Terry 1952), of all observers together, but their standard errors
//! rest on how much the observers differ.

use super::axes::{Axis, axes};
use crate::input::preferences::Choice;
use crate::maths::corrections::holm;
use crate::maths::f_ratio::f_tail;
use crate::maths::logistic::{Fit, Method, Trials, fit};
use crate::maths::p_value::PValue;
use crate::maths::student::{t_975, t_tail};
use crate::outcome::{Outcome, serialize_outcomes};
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::Serialize;
use shutterlab_data_schema::response::Side;
use std::collections::{BTreeMap, BTreeSet};

/// Below this part of the naive variance the observers do not differ at all.
const NO_DIFFERENCE: f64 = 1e-9;

/// A preference model with standard errors that allow for differences between observers.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusteredPreference {
    /// Number G of observers.
    pub observers: u64,
    /// Number of answers.
    pub trials: u64,
    /// Answers that chose neither, which count as half a choice of each.
    pub not_sure: u64,
    /// How the coefficients were estimated: by Firth's (1993) method if some stimuli (or groups of them)
    /// were always or never chosen over the others, so that maximum likelihood has no finite coefficients.
    /// Each standard error is then the larger one of the two.
    pub method: Method,
    /// Each two stimuli, or each two levels of an axis.
    pub contrasts: Vec<Contrast>,
    /// Are all stimuli (or all levels of an axis) alike?
    pub tests: Vec<ClusteredTest>,
    /// Mean of the contrasts' design effects.
    pub design_effect: Outcome<f64>,
}

serialize_outcomes!(
    ClusteredPreference,
    [observers, trials, not_sure, method, contrasts, tests],
    [design_effect]
);

/// How much better a stimulus or level is than another.
#[derive(Clone, Debug, PartialEq)]
pub struct Contrast {
    /// The stimulus or level that is preferred.
    pub item: String,
    /// The other.
    pub over: String,
    /// The difference in logits, not below 0.
    pub estimate: f64,
    /// Its standard error if all answers were independent.
    pub se_naive: f64,
    /// With observers as clusters.
    pub clustered: Outcome<ClusteredContrast>,
}

serialize_outcomes!(Contrast, [item, over, estimate, se_naive], [clustered]);

/// A contrast with observers as clusters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClusteredContrast {
    /// Standard error.
    pub se: f64,
    /// Student's t: the estimate in standard errors.
    pub t: f64,
    /// Degrees of freedom: observers − 1.
    pub df: u64,
    /// Two-sided p of t, approximate.
    pub p: PValue,
    /// `p` corrected for the number of contrasts by Holm (1979).
    pub p_holm: PValue,
    /// 95 % interval of the estimate.
    pub interval_95: [f64; 2],
    /// Variance with clusters over variance without: 1 if answers of one observer are independent. None for
    /// separated data, whose variance is the larger of the two.
    pub design_effect: Option<f64>,
}

/// A test of several coefficients at once.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusteredTest {
    /// What is alike if nothing is to be found: the stimuli, or the levels of an axis.
    pub of: String,
    /// The test.
    pub test: Outcome<FTest>,
}

serialize_outcomes!(ClusteredTest, [of], [test]);

/// An F test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FTest {
    /// F.
    pub f: f64,
    /// Degrees of freedom: the number q of coefficients.
    pub df: u64,
    /// Degrees of freedom of the error: G − q.
    pub df_error: u64,
    /// Upper tail, approximate.
    pub p: PValue,
}

/// One set of coefficients, one per stimulus or level but the first.
struct Block {
    name: String,
    /// The stimuli or levels.
    levels: Vec<String>,
    /// The level of each stimulus, as a place in `levels`.
    of_item: Vec<usize>,
    /// Place of the first coefficient.
    start: usize,
}

/// The preferences between `items`, by logit P(a over b) = βₐ − β_b.
///
/// # Errors
/// In words: nothing was compared, the pairs do not connect the stimuli, or there is one observer only.
pub fn by_item(items: &[String], choices: &[Choice]) -> Outcome<ClusteredPreference> {
    let (levels, of_item) = (items.to_vec(), (0..items.len()).collect());
    clustered(&[Block { name: "stimuli".into(), levels, of_item, start: 0 }], choices)
}

/// The preferences between the levels of each axis, by logit P(a over b) = Σ over the axes of
/// γ(level of a) − γ(level of b).
///
/// # Errors
/// In words: as [`by_item`], or the ids of `items` do not tell levels.
pub fn by_level(items: &[String], choices: &[Choice]) -> Outcome<ClusteredPreference> {
    let mut start = 0;
    let mut blocks = Vec::new();
    for axis in axes(items)? {
        let name = axis.name();
        let Axis { levels, of_item } = axis;
        start += levels.len() - 1;
        blocks.push(Block { name, start: start + 1 - levels.len(), levels, of_item });
    }
    clustered(&blocks, choices)
}

fn credit(chosen: Option<Side>, side: Side) -> f64 {
    chosen.map_or(0.5, |chosen| f64::from(u8::from(chosen == side)))
}

fn clustered(blocks: &[Block], choices: &[Choice]) -> Outcome<ClusteredPreference> {
    let present: BTreeSet<usize> = choices.iter().map(|choice| choice.observer).collect();
    let observers = present.len();
    if observers < 2 {
        return Err(format!(
            "a model with observers as clusters needs at least 2 observers; there {} {observers}",
            if observers == 1 { "is" } else { "are" }
        ));
    }
    let trials = trials(blocks, choices, &present);
    let size: usize = blocks.iter().map(|block| block.levels.len() - 1).sum();
    let fit = fit(size, &trials)?;
    let covariance = fit.clustered_covariance(&trials, observers)?;
    let mut contrasts: Vec<Contrast> =
        blocks.iter().flat_map(|block| contrasts(block, &fit, &covariance, observers)).collect();
    correct(&mut contrasts);
    let tests = blocks.iter().map(|block| ClusteredTest {
        of: block.name.clone(),
        test: test(block, &fit, &covariance, observers),
    });
    let effects: Vec<f64> =
        contrasts.iter().flat_map(|c| &c.clustered).filter_map(|c| c.design_effect).collect();
    Ok(ClusteredPreference {
        observers: observers as u64,
        trials: choices.len() as u64,
        not_sure: choices.iter().filter(|choice| choice.chosen.is_none()).count() as u64,
        method: fit.method,
        tests: tests.collect(),
        design_effect: match (fit.method, effects.len()) {
            (Method::Firth, _) => Err("maximum likelihood has no finite coefficients".into()),
            (_, 0) => Err("no contrast has a standard error with clusters".into()),
            (_, n) => Ok(effects.iter().sum::<f64>() / n as f64),
        },
        contrasts,
    })
}

/// The answers of each observer to each pair.
fn trials(blocks: &[Block], choices: &[Choice], observers: &BTreeSet<usize>) -> Vec<Trials> {
    let mut counts: BTreeMap<(usize, usize, usize), [f64; 2]> = BTreeMap::new();
    for choice in choices {
        let (a, b, side) = match choice.a < choice.b {
            true => (choice.a, choice.b, Side::A),
            false => (choice.b, choice.a, Side::B),
        };
        let [chosen, trials] = counts.entry((choice.observer, a, b)).or_default();
        *chosen += credit(choice.chosen, side);
        *trials += 1.0;
    }
    let clusters: BTreeMap<usize, usize> = observers.iter().copied().zip(0..).collect();
    counts
        .into_iter()
        .map(|((observer, a, b), [successes, trials])| {
            let mut regressors = Vec::new();
            for block in blocks.iter().filter(|block| block.of_item[a] != block.of_item[b]) {
                for (item, sign) in [(a, 1.0), (b, -1.0)] {
                    regressors.extend(block.coefficient(block.of_item[item]).map(|c| (c, sign)));
                }
            }
            Trials { cluster: clusters[&observer], regressors, successes, trials }
        })
        .collect()
}

impl Block {
    /// Place of the coefficient of a level; that of the first is 0 and has none.
    fn coefficient(&self, level: usize) -> Option<usize> {
        level.checked_sub(1).map(|place| self.start + place)
    }
}

/// The contrasts of each two levels of `block`, best first.
fn contrasts(
    block: &Block,
    fit: &Fit,
    covariance: &DMatrix<f64>,
    observers: usize,
) -> Vec<Contrast> {
    let value = |level: usize| block.coefficient(level).map_or(0.0, |c| fit.coefficients[c]);
    let variance = |matrix: &DMatrix<f64>, a: usize, b: usize| {
        let entry = |a: usize, b: usize| match (block.coefficient(a), block.coefficient(b)) {
            (Some(a), Some(b)) => matrix[(a, b)],
            _ => 0.0,
        };
        entry(a, a) + entry(b, b) - 2.0 * entry(a, b)
    };
    let df = observers - 1;
    let half_in_se = t_975(df as f64);
    let mut best_first: Vec<usize> = (0..block.levels.len()).collect();
    best_first.sort_by(|a, b| value(*b).total_cmp(&value(*a)));
    let pairs = best_first
        .iter()
        .enumerate()
        .flat_map(|(place, a)| best_first[place + 1..].iter().map(move |b| (*a, *b)));
    pairs
        .map(|(a, b)| {
            let estimate = value(a) - value(b);
            let naive = variance(&fit.covariance, a, b);
            let robust = variance(covariance, a, b);
            let variance = match fit.method {
                Method::MaximumLikelihood => robust,
                Method::Firth => robust.max(naive),
            };
            let clustered = if variance > NO_DIFFERENCE * naive {
                let se = libm::sqrt(variance);
                let t = estimate / se;
                let p = PValue::new(2.0 * t_tail(t, df as f64));
                Ok(ClusteredContrast {
                    se,
                    t,
                    df: df as u64,
                    p,
                    p_holm: p,
                    interval_95: [estimate - half_in_se * se, estimate + half_in_se * se],
                    design_effect: match fit.method {
                        Method::MaximumLikelihood => Some(robust / naive),
                        Method::Firth => None,
                    },
                })
            } else {
                Err("the contrast is the same for every observer, so there is no difference between them to rest \
                     a standard error on"
                    .into())
            };
            let (item, over) = (block.levels[a].clone(), block.levels[b].clone());
            Contrast { item, over, estimate, se_naive: libm::sqrt(naive), clustered }
        })
        .collect()
}

/// Corrects the contrasts' p for their number.
fn correct(contrasts: &mut [Contrast]) {
    let mut known: Vec<&mut ClusteredContrast> =
        contrasts.iter_mut().flat_map(|contrast| &mut contrast.clustered).collect();
    let p: Vec<f64> = known.iter().map(|contrast| contrast.p.value()).collect();
    for (contrast, p_holm) in known.iter_mut().zip(holm(&p)) {
        contrast.p_holm = PValue::new(p_holm);
    }
}

/// Tests all coefficients of a block at once (Hotelling 1931).
///
/// # Formula
/// ```text
/// F = (G − q)/(q (G − 1)) · βᵀ V⁻¹ β  ~  F(q, G − q)
/// ```
fn test(block: &Block, fit: &Fit, covariance: &DMatrix<f64>, observers: usize) -> Outcome<FTest> {
    let q = block.levels.len() - 1;
    if fit.method == Method::Firth {
        return Err("maximum likelihood has no finite coefficients".into());
    }
    if observers <= q {
        return Err(format!(
            "{q} coefficients need more than {q} observers to be tested at once; there are {observers}"
        ));
    }
    let beta: DVector<f64> = fit.coefficients.rows(block.start, q).into_owned();
    let part = covariance.view((block.start, block.start), (q, q)).into_owned();
    let naive = fit.covariance.view((block.start, block.start), (q, q)).into_owned();
    let pivots = |matrix: &DMatrix<f64>| Cholesky::new(matrix.clone()).map(|c| c.l().diagonal());
    let differ = pivots(&part).zip(pivots(&naive)).is_some_and(|(part, naive)| {
        part.iter().zip(&naive).all(|(p, n)| p * p > NO_DIFFERENCE * n * n)
    });
    let factors = Cholesky::new(part).filter(|_| differ);
    let Some(factors) = factors else {
        return Err(
            "the observers differ too little from each other in some of the coefficients".into()
        );
    };
    let (g, df) = (observers as f64, q as f64);
    let f = (g - df) / (df * (g - 1.0)) * beta.dot(&factors.solve(&beta));
    let p = PValue::new(f_tail(f, df, g - df));
    Ok(FTest { f, df: q as u64, df_error: (observers - q) as u64, p })
}
