//! Logistic regression: maximum likelihood, Firth's bias reduction, and a covariance that allows for
//! clusters of answers.

use crate::outcome::Outcome;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use serde::Serialize;

/// Steps of the linear predictor below this end the iteration.
const SETTLED: f64 = 1e-10;
/// A fit that exists settles in about ten steps of Newton's method. Where the likelihood grows without
/// end, each step adds about one to the linear predictor.
const MOST_STEPS: usize = 60;
const MOST_STEPS_FIRTH: usize = 1000;
/// Below this part of the information that even answers would give, a coefficient is at infinity.
const NO_INFORMATION: f64 = 1e-7;
/// Below this part of a variable's variance it depends on the others.
const DEPENDENT: f64 = 1e-9;

/// Trials of one cluster with equal regressors.
#[derive(Clone, Debug, PartialEq)]
pub struct Trials {
    /// Place of who answered among the clusters.
    pub cluster: usize,
    /// Regressors that are not zero: place of the coefficient and value.
    pub regressors: Vec<(usize, f64)>,
    /// Successes; a half answer counts ½.
    pub successes: f64,
    /// How many trials.
    pub trials: f64,
}

/// How the coefficients are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Maximum likelihood.
    MaximumLikelihood,
    /// Firth's (1993) penalised likelihood, which is finite where that has no maximum.
    Firth,
}

/// A logistic regression.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// How it was estimated.
    pub method: Method,
    /// The coefficients, in logits.
    pub coefficients: DVector<f64>,
    /// Their covariance if all answers were independent: the inverse of the information.
    pub covariance: DMatrix<f64>,
}

/// Fits `coefficients` coefficients to `trials`, by Firth's method where maximum likelihood has none.
///
/// # Formula
/// ```text
/// logit πᵣ = xᵣ·β,  Σᵣ xᵣ [yᵣ − nᵣ πᵣ + hᵣ (½ − πᵣ)] = 0,  A = Σᵣ nᵣ πᵣ (1 − πᵣ) xᵣ xᵣᵀ
/// ```
/// with hᵣ = 0 for maximum likelihood and hᵣ = nᵣ πᵣ (1 − πᵣ) xᵣᵀ A⁻¹ xᵣ for Firth's.
///
/// # Errors
/// In words: the trials do not tell all coefficients.
pub fn fit(coefficients: usize, trials: &[Trials]) -> Outcome<Fit> {
    let even = DVector::zeros(coefficients);
    let most = Equations::at(&even, trials).information;
    let scale = cholesky(&most)
        .ok_or("the pairs that were compared do not tell all coefficients apart")?
        .l()
        .map_diagonal(|pivot| pivot * pivot);
    let solution = solve(&even, trials, Method::MaximumLikelihood, MOST_STEPS);
    let finite = solution.filter(|fit| {
        let information = Equations::at(&fit.coefficients, trials).information;
        let pivots = Cholesky::new(information).map(|factors| factors.l().diagonal());
        pivots.is_some_and(|p| p.iter().zip(&scale).all(|(p, s)| p * p > NO_INFORMATION * s))
    });
    finite
        .or_else(|| solve(&even, trials, Method::Firth, MOST_STEPS_FIRTH))
        .ok_or_else(|| "the coefficients did not settle".into())
}

/// The equations of a fit at some coefficients.
struct Equations {
    /// Chance of success in each row.
    chances: Vec<f64>,
    information: DMatrix<f64>,
}

impl Equations {
    fn at(beta: &DVector<f64>, trials: &[Trials]) -> Self {
        let chances: Vec<f64> =
            trials.iter().map(|row| 1.0 / (1.0 + libm::exp(-predictor(row, beta)))).collect();
        let mut information = DMatrix::zeros(beta.len(), beta.len());
        for (row, p) in trials.iter().zip(&chances) {
            add_information(&mut information, row, *p);
        }
        Self { chances, information }
    }
}

fn predictor(row: &Trials, beta: &DVector<f64>) -> f64 {
    row.regressors.iter().map(|(place, x)| x * beta[*place]).sum()
}

fn add_information(information: &mut DMatrix<f64>, row: &Trials, p: f64) {
    let weight = row.trials * p * (1.0 - p);
    for (i, x) in &row.regressors {
        for (j, y) in &row.regressors {
            information[(*i, *j)] += weight * x * y;
        }
    }
}

/// What `row` adds to the equations: its residual, with Firth's adjustment.
fn residual(row: &Trials, p: f64, method: Method, covariance: &DMatrix<f64>) -> f64 {
    let plain = row.successes - row.trials * p;
    match method {
        Method::MaximumLikelihood => plain,
        Method::Firth => {
            let mut leverage = 0.0;
            for (i, x) in &row.regressors {
                for (j, y) in &row.regressors {
                    leverage += row.trials * p * (1.0 - p) * x * y * covariance[(*i, *j)];
                }
            }
            plain + leverage * (0.5 - p)
        }
    }
}

fn solve(
    start: &DVector<f64>,
    trials: &[Trials],
    method: Method,
    most_steps: usize,
) -> Option<Fit> {
    let mut coefficients = start.clone();
    for _ in 0..most_steps {
        let Equations { chances, information } = Equations::at(&coefficients, trials);
        let covariance = Cholesky::new(information)?.inverse();
        let mut gradient = DVector::zeros(start.len());
        for (row, p) in trials.iter().zip(chances) {
            let residual = residual(row, p, method, &covariance);
            row.regressors.iter().for_each(|(place, x)| gradient[*place] += x * residual);
        }
        let step = &covariance * gradient;
        let largest = trials.iter().map(|row| predictor(row, &step).abs()).fold(0.0, f64::max);
        // Damped like this a step never overshoots: the third derivative of the logistic likelihood is
        // bounded by its second (Bach 2010).
        let damping = if largest < SETTLED { 1.0 } else { libm::log1p(largest) / largest };
        coefficients.axpy(damping, &step, 1.0);
        if largest < SETTLED {
            return Some(Fit { method, coefficients, covariance });
        }
    }
    None
}

impl Fit {
    /// The covariance that allows for answers of one cluster being alike: each of the `clusters` is left
    /// out in turn, in one step from the estimate (the linearised jackknife, CR3 or CV3).
    ///
    /// # Formula
    /// ```text
    /// V = (G−1)/G Σ_g δ_g δ_gᵀ,  δ_g = (A − A_g)⁻¹ s_g
    /// ```
    /// with A_g and s_g the shares of cluster g in the information and in the equations.
    ///
    /// # Errors
    /// In words: there are fewer than two clusters, or one that the coefficients rest on alone.
    pub fn clustered_covariance(
        &self,
        trials: &[Trials],
        clusters: usize,
    ) -> Outcome<DMatrix<f64>> {
        if clusters < 2 {
            return Err("one observer alone does not tell how much observers differ".into());
        }
        let size = self.coefficients.len();
        let Equations { chances, information } = Equations::at(&self.coefficients, trials);
        let mut shares = vec![(DMatrix::zeros(size, size), DVector::zeros(size)); clusters];
        for (row, p) in trials.iter().zip(chances) {
            let (information, equations) = &mut shares[row.cluster];
            add_information(information, row, p);
            let residual = residual(row, p, self.method, &self.covariance);
            row.regressors.iter().for_each(|(place, x)| equations[*place] += x * residual);
        }
        let mut sum = DMatrix::zeros(size, size);
        for (of_cluster, equations) in shares {
            let factors = cholesky(&(&information - of_cluster)).ok_or(
                "without one of the observers the pairs do not tell all coefficients apart",
            )?;
            let change = factors.solve(&equations);
            sum.ger(1.0, &change, &change, 1.0);
        }
        Ok(sum * ((clusters as f64 - 1.0) / clusters as f64))
    }
}

/// The factors of `matrix`, if no variable depends on the others.
fn cholesky(matrix: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let factors = Cholesky::new(matrix.clone())?;
    let pivots = factors.l_dirty().diagonal();
    let independent =
        pivots.iter().zip(matrix.diagonal().iter()).all(|(p, v)| p * p > DEPENDENT * v);
    independent.then_some(factors)
}
