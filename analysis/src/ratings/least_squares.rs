//! The search for the least sum of squares of ρ = 1/(σ₁v + σ₂), by the method of Levenberg and Marquardt
//! (Moré 1978), over both σ or with one of them given.

use super::points::Point;
use crate::maths::distributions::bisect;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn, Matrix2, Vector2};

/// The distinct speeds, ascending.
pub(super) fn speeds(points: &[Point]) -> Vec<f64> {
    let mut speeds: Vec<f64> = points.iter().map(|point| point.speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    speeds
}

pub(super) fn law([sigma_1, sigma_2]: [f64; 2], v: f64) -> f64 {
    1.0 / (sigma_1 * v + sigma_2)
}

/// ∂ρ/∂σ = −ρ²·(v, 1).
pub(super) fn gradient(sigma: [f64; 2], v: f64) -> Vector2<f64> {
    let slope = -square(law(sigma, v));
    Vector2::new(slope * v, slope)
}

/// A least sum of squares.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solution {
    pub sigma: [f64; 2],
    pub rss: f64,
    /// JᵀJ.
    pub information: Matrix2<f64>,
}

/// The least sum of squares with ρ > 0 at all points; the σ may be negative. None if the search fails.
pub(super) fn solve(points: &[Point]) -> Option<Solution> {
    let starts = [4, 0].map(|power| linearised(points, power));
    let mean = points.iter().map(|point| point.frequency).sum::<f64>() / points.len() as f64;
    let solutions = starts
        .into_iter()
        .flatten()
        .chain([[0.0, 1.0 / mean]])
        .filter_map(|start| descend(Problem { points, sigma: start, free: vec![0, 1] }));
    let best = solutions
        .min_by(|a, b| sum_of_squares(points, *a).total_cmp(&sum_of_squares(points, *b)))?;
    let gradients = points.iter().map(|point| gradient(best, point.speed));
    Some(Solution {
        sigma: best,
        rss: sum_of_squares(points, best),
        information: gradients.map(|gradient| gradient * gradient.transpose()).sum(),
    })
}

/// Weighted least squares of 1/ρ = σ₁v + σ₂, the weights being ρ to the `power`; none if it is negative
/// at a point.
fn linearised(points: &[Point], power: i32) -> Option<[f64; 2]> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for Point { speed, frequency, .. } in points {
        let weight = frequency.powi(power);
        let row = Vector2::new(*speed, 1.0);
        normal += row * row.transpose() * weight;
        right += row * (weight / frequency);
    }
    let sigma: [f64; 2] = (normal.try_inverse()? * right).into();
    positive(points, sigma).then_some(sigma)
}

fn positive(points: &[Point], [sigma_1, sigma_2]: [f64; 2]) -> bool {
    points.iter().all(|point| sigma_1 * point.speed + sigma_2 > 0.0)
}

fn sum_of_squares(points: &[Point], sigma: [f64; 2]) -> f64 {
    points.iter().map(|point| square(point.frequency - law(sigma, point.speed))).sum()
}

/// Least squares over the free ones of σ₁ and σ₂.
struct Problem<'a> {
    points: &'a [Point],
    sigma: [f64; 2],
    free: Vec<usize>,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, parameters: &DVector<f64>) {
        for (i, value) in self.free.iter().zip(parameters.iter()) {
            self.sigma[*i] = *value;
        }
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_iterator(self.free.len(), self.free.iter().map(|i| self.sigma[*i]))
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residual = |point: &Point| law(self.sigma, point.speed) - point.frequency;
        Some(DVector::from_iterator(self.points.len(), self.points.iter().map(residual)))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let cell = |i: usize, j: usize| gradient(self.sigma, self.points[i].speed)[self.free[j]];
        Some(DMatrix::from_fn(self.points.len(), self.free.len(), cell))
    }
}

fn descend(problem: Problem) -> Option<[f64; 2]> {
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    let ended = report.termination.was_successful()
        || matches!(report.termination, TerminationReason::NoImprovementPossible(_));
    (ended && positive(problem.points, problem.sigma)).then_some(problem.sigma)
}

/// The bounds within which the least sum of squares over the other σ stays up to `limit`.
pub(super) fn profile(
    points: &[Point],
    best: [f64; 2],
    i: usize,
    se: Option<f64>,
    limit: f64,
) -> [Option<f64>; 2] {
    // Points that lie on the law leave nothing to vary.
    let Some(se) = se.filter(|se| *se > 0.0) else { return [Some(best[i]); 2] };
    [-1.0, 1.0].map(|side| {
        let beyond = |distance: f64| {
            let mut start = best;
            start[i] += side * distance;
            // Where the law has a pole among the points, the sum of squares has no bound.
            let start = reachable(points, start, 1 - i);
            descend(Problem { points, sigma: start, free: vec![1 - i] })
                .is_none_or(|sigma| sum_of_squares(points, sigma) > limit)
        };
        let mut outside = se;
        while !beyond(outside) {
            outside *= 1.6;
            if outside > 1e4 * se {
                return None;
            }
        }
        Some(best[i] + side * bisect(0.0, outside, beyond))
    })
}

/// `sigma` with the `free` one so large that ρ > 0 at all points.
fn reachable(points: &[Point], mut sigma: [f64; 2], free: usize) -> [f64; 2] {
    if !positive(points, sigma) {
        // A start from which the search comes down to where the law is: ρ as small as the smallest.
        let least = points.iter().map(|point| point.frequency).fold(f64::INFINITY, f64::min);
        let needed = |point: &Point| match free {
            0 => (1.0 / least - sigma[1]) / point.speed,
            _ => 1.0 / least - sigma[0] * point.speed,
        };
        sigma[free] =
            points.iter().map(needed).filter(|s| s.is_finite()).fold(f64::NEG_INFINITY, f64::max);
    }
    sigma
}

fn square(x: f64) -> f64 {
    x * x
}
