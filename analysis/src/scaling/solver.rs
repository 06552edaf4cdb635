//! Fisher scoring for scale values, on buffers that many fits to the same pairs share.

use super::comparisons::Comparisons;
use super::fit::Estimation;
use super::model::Model;
use crate::outcome::Outcome;
use nalgebra::{DMatrix, DVector};

pub(super) const MOST_STEPS: usize = 1000;
pub(super) const UNSETTLED: &str = "the scale values did not settle";
pub(super) const TOO_FAR: &str = "the scale values lie too far apart to compute";

/// How much of each step of an iteration is taken, and when to stop.
pub(super) struct Pace {
    last: DVector<f64>,
    last_largest: f64,
    relaxation: f64,
}

impl Pace {
    /// For steps of so many numbers.
    pub fn new(size: usize) -> Self {
        Self { last: DVector::zeros(size), last_largest: f64::INFINITY, relaxation: 1.0 }
    }

    /// The part of `step` to take, which moves a linear predictor by `largest`, and whether it is the
    /// last.
    ///
    /// A step damped by ln(1 + r)/r never overshoots for a logistic likelihood, whose third derivative is
    /// bounded by its second (Bach 2010). For the others, a step back is a sign of having overshot.
    pub fn take(&mut self, step: &DVector<f64>, largest: f64) -> (f64, bool) {
        let back = step.dot(&self.last) < 0.0;
        self.relaxation =
            if back { 0.5 * self.relaxation } else { (1.5 * self.relaxation).min(1.0) };
        // With extreme counts, rounding keeps steps from vanishing.
        let settled = largest < 1e-10 || (largest < 1e-6 && largest >= self.last_largest);
        let damping = if settled { 1.0 } else { libm::log1p(largest) / largest };
        self.last.copy_from(step);
        self.last_largest = largest;
        (damping * self.relaxation, settled)
    }
}

/// The equations of a fit and their solution. The first item is held at zero.
pub(super) struct Solver {
    model: Model,
    estimation: Estimation,
    pairs: Vec<(usize, usize)>,
    /// Scale values.
    values: DVector<f64>,
    /// Per pair: residual, weight and f′/f.
    terms: Vec<[f64; 3]>,
    /// Inverse of the information without the first item, in a frame of zeros for it.
    inverse: DMatrix<f64>,
    /// Logarithm of the determinant of that information.
    ln_det: f64,
    gradient: DVector<f64>,
    step: DVector<f64>,
}

impl Solver {
    /// For `comparisons`, and the wins of each of their pairs with half a win for every tie.
    pub fn of(
        comparisons: &Comparisons,
        model: Model,
        estimation: Estimation,
    ) -> (Self, Vec<[f64; 2]>) {
        let (pairs, counts): (Vec<_>, Vec<_>) = comparisons.answers().unzip();
        let t = comparisons.items().len();
        let solver = Self {
            model,
            estimation,
            values: DVector::zeros(t),
            terms: vec![[0.0; 3]; pairs.len()],
            pairs,
            inverse: DMatrix::zeros(t, t),
            ln_det: 0.0,
            gradient: DVector::zeros(t),
            step: DVector::zeros(t),
        };
        (solver, counts)
    }

    /// Starts from these values.
    pub fn start(&mut self, values: &[f64]) {
        self.values.copy_from_slice(values);
    }

    /// The values with sum zero.
    pub fn centred(&self) -> Vec<f64> {
        centred(&self.values)
    }

    /// The covariance of the values with sum zero.
    pub fn covariance(&self) -> DMatrix<f64> {
        centred_covariance(&self.inverse)
    }

    /// Twice the negative log-likelihood of the values, less a constant of the `counts`; with bias
    /// reduction less ln det I.
    pub fn objective(&self, counts: &[[f64; 2]]) -> f64 {
        let penalty = match self.estimation {
            Estimation::MaximumLikelihood => 0.0,
            Estimation::BiasReduced => self.ln_det,
        };
        self.deviance(counts) - penalty
    }

    /// The deviance of the values from the `counts`.
    pub fn deviance(&self, counts: &[[f64; 2]]) -> f64 {
        let answers = self.pairs.iter().copied().zip(counts.iter().copied());
        deviance(self.model, self.values.as_slice(), answers)
    }

    /// Solves the equations for the `counts` of each pair, from where the values are. With a contrast
    /// `held` (sum zero), among the values at which it is what it is now.
    pub fn solve(&mut self, counts: &[[f64; 2]], held: Option<&DVector<f64>>) -> Outcome<()> {
        let mut pace = Pace::new(self.values.len());
        for _ in 0..MOST_STEPS {
            self.find_step(counts)?;
            if let Some(held) = held {
                let direction = &self.inverse * held;
                let excess = held.dot(&self.step) / held.dot(&direction);
                self.step.axpy(-excess, &direction, 1.0);
            }
            let moves = self.pairs.iter().map(|(i, j)| (self.step[*i] - self.step[*j]).abs());
            let largest = moves.fold(0.0, f64::max);
            let (part, settled) = pace.take(&self.step, largest);
            self.values.axpy(part, &self.step, 1.0);
            if !self.values.iter().chain(&self.inverse).all(|value| value.is_finite()) {
                return Err(TOO_FAR.into());
            }
            if settled {
                return Ok(());
            }
        }
        Err(UNSETTLED.into())
    }

    /// Computes the step of Fisher scoring at the values, and the inverse information.
    fn find_step(&mut self, counts: &[[f64; 2]]) -> Outcome<()> {
        let information = &mut self.inverse;
        information.fill(0.0);
        for (((i, j), [i_wins, j_wins]), term) in self.pairs.iter().zip(counts).zip(&mut self.terms)
        {
            let p = self.model.preference(self.values[*i] - self.values[*j]);
            let ratio = p.density / (p.chosen * p.rejected);
            let weight = (i_wins + j_wins) * p.density * ratio;
            *term = [ratio * (i_wins * p.rejected - j_wins * p.chosen), weight, p.log_slope];
            information[(*i, *i)] += weight;
            information[(*j, *j)] += weight;
            information[(*i, *j)] -= weight;
            information[(*j, *i)] -= weight;
        }
        // The first item stands still: one in its place of the diagonal, zeros beside it.
        information.row_mut(0).fill(0.0);
        information.column_mut(0).fill(0.0);
        information[(0, 0)] = 1.0;
        let row = self.step.as_mut_slice();
        self.ln_det = invert(information.as_mut_slice(), row).ok_or(TOO_FAR)?;
        self.inverse[(0, 0)] = 0.0;
        self.gradient.fill(0.0);
        let v = &self.inverse;
        for ((i, j), [residual, weight, log_slope]) in self.pairs.iter().zip(&self.terms) {
            let adjustment = match self.estimation {
                Estimation::MaximumLikelihood => 0.0,
                Estimation::BiasReduced => {
                    let leverage = weight * (v[(*i, *i)] + v[(*j, *j)] - 2.0 * v[(*i, *j)]);
                    0.5 * leverage * log_slope
                }
            };
            self.gradient[*i] += residual + adjustment;
            self.gradient[*j] -= residual + adjustment;
        }
        self.step.gemv(1.0, v, &self.gradient, 0.0);
        Ok(())
    }
}

/// Inverts a symmetric positive definite matrix in its place by Gauss and Jordan's method, on slices and
/// so several times as fast as a factorisation of a small matrix; gives the logarithm of its determinant.
/// `row` holds a row on the way.
fn invert(matrix: &mut [f64], row: &mut [f64]) -> Option<f64> {
    let t = row.len();
    let mut ln_det = 0.0;
    for k in 0..t {
        let pivot = matrix[k * t + k];
        if pivot.is_nan() || pivot <= 0.0 {
            return None;
        }
        ln_det += libm::log(pivot);
        matrix[k * t + k] = 1.0;
        matrix[k * t..(k + 1) * t].iter_mut().for_each(|entry| *entry /= pivot);
        row.copy_from_slice(&matrix[k * t..(k + 1) * t]);
        for (_, other) in matrix.chunks_exact_mut(t).enumerate().filter(|(i, _)| *i != k) {
            let factor = std::mem::replace(&mut other[k], 0.0);
            other.iter_mut().zip(&*row).for_each(|(entry, own)| *entry -= factor * own);
        }
    }
    Some(ln_det)
}

/// `values` less their mean.
pub(super) fn centred(values: &DVector<f64>) -> Vec<f64> {
    let mean = values.mean();
    values.iter().map(|value| value - mean).collect()
}

/// The covariance of values less their mean, from that of the values.
pub(super) fn centred_covariance(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let means = covariance.row_mean();
    let mean = means.mean();
    DMatrix::from_fn(means.len(), means.len(), |i, j| {
        covariance[(i, j)] - means[i] - means[j] + mean
    })
}

/// The deviance of scale `values` from `answers`: the places of each pair's items, and the wins of either.
///
/// # Formula
/// ```text
/// 2 Σ [y ln(y/nF) + (n−y) ln((n−y)/n(1−F))], 0 ln 0 = 0
/// ```
pub(super) fn deviance(
    model: Model,
    values: &[f64],
    answers: impl Iterator<Item = ((usize, usize), [f64; 2])>,
) -> f64 {
    let term = |observed: f64, expected: f64| match observed > 0.0 {
        true => 2.0 * observed * libm::log(observed / expected),
        false => 0.0,
    };
    answers
        .map(|((i, j), [i_wins, j_wins])| {
            let p = model.preference(values[i] - values[j]);
            let trials = i_wins + j_wins;
            term(i_wins, trials * p.chosen) + term(j_wins, trials * p.rejected)
        })
        .sum()
}
