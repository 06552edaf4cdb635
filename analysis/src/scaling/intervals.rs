//! Likelihood intervals of scale values: Wald's, and those of the profile likelihood.

use super::comparisons::Comparisons;
use super::fit::{Estimate, Estimation, Scale};
use super::model::Model;
use super::solver::Solver;
use crate::maths::distributions::Z_975;
use crate::outcome::Outcome;
use nalgebra::DVector;

impl Estimate {
    /// Wald's 95 % interval: the estimate ± Φ⁻¹(0.975) standard errors.
    pub fn wald_95(&self) -> [f64; 2] {
        [self.value - Z_975 * self.se, self.value + Z_975 * self.se]
    }

    /// The same in a larger unit.
    pub(super) fn in_units_of(&self, unit: f64) -> Self {
        Self { value: self.value / unit, se: self.se / unit }
    }
}

/// The 95 % interval of the profile likelihood of the contrast Σ cₖ·sₖ (Σ cₖ = 0) of a scale fitted to
/// `comparisons`.
///
/// # Formula
/// ```text
/// all v with 2·[ℓ(ŝ) − max {ℓ(s) : Σ cₖ·sₖ = v}] ≤ χ²₁(0.95)
/// ```
/// For bias-reduced Bradley–Terry values, ℓ is the log-likelihood plus ½·ln det I (Heinze and Schemper
/// 2002).
///
/// # Errors
/// In words: it is no contrast; bias-reduced Thurstone values maximise no likelihood; a bound lies too far out to compute.
pub fn profile_95(comparisons: &Comparisons, scale: &Scale, contrast: &[f64]) -> Outcome<[f64; 2]> {
    if (scale.model, scale.estimation) == (Model::ThurstoneV, Estimation::BiasReduced) {
        return Err(
            "bias-reduced Thurstone values maximise no likelihood, so they have no profile".into(),
        );
    }
    let t = scale.items.len();
    if contrast.len() != t || contrast.iter().sum::<f64>().abs() > 1e-9 {
        return Err(format!("a contrast needs {t} numbers with sum zero"));
    }
    let contrast = DVector::from_column_slice(contrast);
    let spread = &scale.covariance * &contrast;
    let variance = contrast.dot(&spread);
    let estimate = contrast.dot(&DVector::from_column_slice(&scale.values));
    let (mut solver, counts) = Solver::of(comparisons, scale.model, scale.estimation);
    solver.start(&scale.values);
    solver.solve(&counts, None)?;
    let least = solver.objective(&counts);
    // √(2·[ℓ(ŝ) − ℓ]) at a distance from the estimate; near a straight line through zero.
    let mut root = |distance: f64| -> Outcome<f64> {
        let shifted: Vec<f64> =
            (0..t).map(|k| scale.values[k] + spread[k] * distance / variance).collect();
        solver.start(&shifted);
        solver.solve(&counts, Some(&contrast))?;
        Ok(libm::sqrt((solver.objective(&counts) - least).max(0.0)))
    };
    let mut bound = |direction: f64| -> Outcome<f64> {
        // Secants, of which the first begins at the estimate; none leads across it or too far.
        let (mut last, mut last_root) = (0.0, 0.0);
        let mut distance = direction * Z_975 * libm::sqrt(variance);
        for _ in 0..100 {
            let root = root(distance)?;
            if (root / Z_975 - 1.0).abs() < 1e-8 {
                return Ok(estimate + distance);
            }
            let ratio = 1.0 + (Z_975 - root) / (root - last_root) * (1.0 - last / distance);
            (last, last_root) = (distance, root);
            distance *= ratio.clamp(0.25, 4.0);
        }
        Err("the profile of the likelihood is too flat to find its bounds".into())
    };
    Ok([bound(-1.0)?, bound(1.0)?])
}
