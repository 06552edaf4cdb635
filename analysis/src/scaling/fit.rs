//! Scale values by maximum likelihood or, for data to which no finite values are likeliest, by Firth's
//! bias-reduced likelihood; with standard errors.

use super::comparisons::Comparisons;
use super::connection::{check_connected, separation};
use super::model::Model;
use super::solver::Solver;
use crate::outcome::Outcome;
use nalgebra::DMatrix;
use serde::Serialize;

/// By which rule scale values follow from the answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Estimation {
    /// The likeliest values.
    MaximumLikelihood,
    /// Values whose bias of first order is removed (Firth 1993); they are finite for all data.
    BiasReduced,
}

impl Estimation {
    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::MaximumLikelihood => "maximum likelihood",
            Self::BiasReduced => "bias-reduced",
        }
    }
}

/// An estimate and its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub se: f64,
}

/// Scale values of t items.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scale {
    /// The items.
    pub items: Vec<String>,
    /// What the values say about choices.
    pub model: Model,
    /// How they were estimated.
    pub estimation: Estimation,
    /// Scale values with sum zero, in the unit of the model.
    pub values: Vec<f64>,
    /// Their standard errors.
    pub se: Vec<f64>,
    /// Their covariance from the expected information; its rows have sum zero.
    #[serde(skip)]
    pub covariance: DMatrix<f64>,
}

/// Fits scale values to connected comparisons; a tie is half a win for each.
///
/// # Formula
/// ```text
/// maximum likelihood: Σ over pairs of (f/F(1−F))·[y(1−F) − (n−y)F]·x = 0
/// bias-reduced:       Σ over pairs of {(f/F(1−F))·[y(1−F) − (n−y)F] + ½·h·f′/f}·x = 0
/// covariance:         I⁻¹, I = Σ over pairs of n·f²/F(1−F)·x xᵀ
/// ```
/// with x = +1 for item i, −1 for item j of a pair, y wins of i in n answers, F and f the model's chance
/// and density at sᵢ − sⱼ, and h = n·f²/F(1−F)·xᵀI⁻¹x the leverage of the pair (Firth 1993; Kosmidis and
/// Firth 2009). For Bradley–Terry the bias-reduced values maximise the likelihood times √det I.
///
/// # Errors
/// In words: the comparisons are not connected; maximum likelihood of separated data, with the items
/// that separate them; values too far apart for the arithmetic.
pub fn fit(comparisons: &Comparisons, model: Model, estimation: Estimation) -> Outcome<Scale> {
    check_connected(comparisons)?;
    if estimation == Estimation::MaximumLikelihood {
        separation(comparisons).map_or(Ok(()), Err)?;
    }
    let (mut solver, counts) = Solver::of(comparisons, model, estimation);
    solver.solve(&counts, None)?;
    let (values, covariance) = (solver.centred(), solver.covariance());
    Ok(Scale::new(comparisons.items(), model, estimation, values, covariance))
}

impl Scale {
    pub(super) fn new(
        items: &[String],
        model: Model,
        estimation: Estimation,
        values: Vec<f64>,
        covariance: DMatrix<f64>,
    ) -> Self {
        let se = covariance.diagonal().iter().map(|v| libm::sqrt(v.max(0.0))).collect();
        Self { items: items.to_vec(), model, estimation, values, se, covariance }
    }

    /// The places of the items from the highest value to the lowest.
    pub fn best_first(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.values.len()).collect();
        order.sort_by(|a, b| self.values[*b].total_cmp(&self.values[*a]));
        order
    }

    /// The value of item `i` against the mean of all.
    pub fn centred(&self, i: usize) -> Estimate {
        Estimate { value: self.values[i], se: self.se[i] }
    }

    /// How far item `i` is above item `j`.
    pub fn difference(&self, i: usize, j: usize) -> Estimate {
        let c = &self.covariance;
        let variance = c[(i, i)] + c[(j, j)] - 2.0 * c[(i, j)];
        let value = self.values[i] - self.values[j];
        Estimate { value, se: libm::sqrt(variance.max(0.0)) }
    }

    /// The worths π = exp(s)/Σ exp(s) of the Bradley–Terry model, with sum 1.
    pub fn worths(&self) -> Vec<f64> {
        let largest = self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let worths: Vec<f64> = self.values.iter().map(|s| libm::exp(s - largest)).collect();
        let sum: f64 = worths.iter().sum();
        worths.into_iter().map(|worth| worth / sum).collect()
    }
}
