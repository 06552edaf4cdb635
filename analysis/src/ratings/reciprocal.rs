//! The law of the level of detail, ρ = 1/(σ₁v + σ₂) (Zhang et al. 2014, Eq. 8), fitted by least squares
//! with the method of Levenberg and Marquardt (Moré 1978).

use super::least_squares::{Solution, gradient, law, profile, solve, speeds};
use super::points::Point;
use crate::maths::student::t_975;
use crate::outcome::Outcome;
use nalgebra::Matrix2;
use serde::Serialize;

/// The fitted law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReciprocalFit {
    /// σ₁, in 1/(frequency·velocity).
    pub sigma_1: Parameter,
    /// σ₂, in 1/frequency.
    pub sigma_2: Parameter,
    /// Covariance of σ₁ and σ₂; `null` where the points are met exactly.
    pub covariance: Option<[[f64; 2]; 2]>,
    /// Sum of squared residuals.
    pub rss: f64,
    /// Degrees of freedom: points less 2.
    pub df: usize,
    /// √(rss/df), in the unit of the frequency.
    pub residual_se: Option<f64>,
    /// 1 − rss/Σ(ρ − ρ̄)².
    pub r_squared: Option<f64>,
    /// Logarithm of the normal likelihood.
    pub log_likelihood: Option<f64>,
    /// −2·log-likelihood + 6: two parameters and the variance.
    pub aic: Option<f64>,
    /// Why there is no standard error, or no interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<&'static str>,
    /// The points, what the law says and what remains.
    pub points: Vec<FittedPoint>,
}

/// σ₁ or σ₂.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Its estimate.
    pub estimate: f64,
    /// Standard error.
    pub se: Option<f64>,
    /// 95 % interval by Student's t (Wald).
    pub wald_95: Option<[f64; 2]>,
    /// 95 % interval by the profile of the sum of squares; `null` where it is open.
    pub profile_95: Option<[Option<f64>; 2]>,
}

/// A point and its residual.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedPoint {
    /// The point.
    #[serde(flatten)]
    pub point: Point,
    /// ρ by the law.
    pub fitted: f64,
    /// Its frequency less `fitted`.
    pub residual: f64,
}

/// What the law says at a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// ρ.
    pub frequency: f64,
    /// Standard error of ρ, by the delta method.
    pub se: Option<f64>,
    /// 95 % interval of ρ by Student's t.
    pub interval_95: Option<[f64; 2]>,
}

impl ReciprocalFit {
    /// σ₁ and σ₂.
    pub fn sigma(&self) -> [f64; 2] {
        [self.sigma_1.estimate, self.sigma_2.estimate]
    }

    /// The same law without standard errors and intervals, because of `reason`.
    pub(super) fn without_intervals(self, reason: &'static str) -> Self {
        let bare = |parameter: Parameter| Parameter {
            se: None,
            wald_95: None,
            profile_95: None,
            ..parameter
        };
        Self {
            sigma_1: bare(self.sigma_1),
            sigma_2: bare(self.sigma_2),
            covariance: None,
            reason: Some(reason),
            ..self
        }
    }

    /// What the law says at the speed `v`.
    pub fn predict(&self, v: f64) -> Prediction {
        let frequency = law(self.sigma(), v);
        let se = self.covariance.map(|covariance| {
            let gradient = gradient(self.sigma(), v);
            libm::sqrt((gradient.transpose() * Matrix2::from(covariance) * gradient)[0])
        });
        let interval_95 = se.map(|se| interval(frequency, t_975(self.df as f64) * se));
        Prediction { frequency, se, interval_95 }
    }
}

/// Up to this part of the sum of squared frequencies a sum of squared residuals is rounding.
const EXACT: f64 = 1e-20;

/// Fits the law to `points`.
///
/// # Formula
/// ```text
/// (σ₁, σ₂) = argmin Σ (ρᵢ − 1/(σ₁vᵢ + σ₂))²,  cov = rss/(n − 2)·(JᵀJ)⁻¹
/// Wald:     σ ± t(0.975; n − 2)·se
/// profile:  {σ₁: min over σ₂ of rss(σ₁, σ₂) ≤ rss·(1 + t²(0.975; n − 2)/(n − 2))}, and so for σ₂
/// ```
///
/// # Errors
/// Says in words why no law follows: too few points or speeds; frequencies that do not fall with the
/// speed; a search without end.
pub fn fit(points: &[Point]) -> Outcome<ReciprocalFit> {
    for Point { speed, frequency, .. } in points {
        if !(speed.is_finite() && *speed >= 0.0 && frequency.is_finite() && *frequency > 0.0) {
            return Err(format!(
                "a point at speed {speed} with frequency {frequency}: a speed from 0 and a \
                 frequency above 0 are needed"
            ));
        }
    }
    let speeds = speeds(points);
    if speeds.len() < 2 {
        return Err(match (points.len(), speeds.first()) {
            (_, None) => "no points: σ₁ and σ₂ need two speeds at least".into(),
            (n, Some(v)) => format!(
                "{n} points at the speed {v} only: σ₁ and σ₂ need two speeds at least, and \
                 cannot be told apart at one"
            ),
        });
    }
    let Solution { sigma, rss, information } = solve(points)
        .ok_or("the search for σ₁ and σ₂ found no least sum of squares (not converged)")?;
    let [sigma_1, sigma_2] = sigma;
    if sigma_1 <= 0.0 {
        return Err(format!(
            "σ₁ = {sigma_1:.4} is not above 0: the frequencies do not fall with the speed, and \
             the law says that they do"
        ));
    }
    // A σ₂ this small beside the reciprocals of the frequencies has its sign from rounding.
    let highest = points.iter().map(|point| point.frequency).fold(0.0, f64::max);
    if sigma_2 <= 1e-9 / highest {
        return Err(format!(
            "σ₂ = {sigma_2:.4} is not above 0 (with σ₁ = {sigma_1:.4}): the law would have no \
             value at low speeds; slower points are needed"
        ));
    }
    let n = points.len();
    let df = n - 2;
    let inverse = information
        .try_inverse()
        .filter(identified)
        .ok_or("σ₁ and σ₂ cannot be told apart: the speeds are too much alike")?;
    // Points that lie exactly on the law have no scatter, whatever their number.
    let squares: f64 = points.iter().map(|point| square(point.frequency)).sum();
    let exact = df == 0 || rss <= EXACT * squares;
    let variance = (!exact).then(|| rss / df as f64);
    let covariance = variance.map(|variance| inverse * variance);
    let quantile = t_975(df.max(1) as f64);
    let parameter = |i: usize| {
        let se = covariance.map(|covariance| libm::sqrt(covariance[(i, i)]));
        Parameter {
            estimate: sigma[i],
            se,
            wald_95: se.map(|se| interval(sigma[i], quantile * se)),
            profile_95: variance.map(|variance| {
                profile(points, sigma, i, se, rss + quantile * quantile * variance)
            }),
        }
    };
    let mean = points.iter().map(|point| point.frequency).sum::<f64>() / n as f64;
    let total: f64 = points.iter().map(|point| square(point.frequency - mean)).sum();
    let log_likelihood = (!exact).then(|| {
        let n = n as f64;
        -0.5 * n * (libm::log(2.0 * std::f64::consts::PI * rss / n) + 1.0)
    });
    Ok(ReciprocalFit {
        sigma_1: parameter(0),
        sigma_2: parameter(1),
        covariance: covariance.map(|c| [[c[(0, 0)], c[(0, 1)]], [c[(1, 0)], c[(1, 1)]]]),
        rss,
        df,
        residual_se: variance.map(libm::sqrt),
        r_squared: (!exact && total > 0.0).then(|| 1.0 - rss / total),
        log_likelihood,
        aic: log_likelihood.map(|l| 6.0 - 2.0 * l),
        reason: exact.then_some(match df {
            0 => {
                "two points determine σ₁ and σ₂ exactly: nothing is left to estimate an error from"
            }
            _ => "all points lie exactly on the law: there is no scatter to estimate an error from",
        }),
        points: points
            .iter()
            .map(|point| {
                let fitted = law(sigma, point.speed);
                FittedPoint { point: point.clone(), fitted, residual: point.frequency - fitted }
            })
            .collect(),
    })
}

/// Whether the correlation of σ₁ and σ₂ is below 1 by more than rounding.
fn identified(inverse: &Matrix2<f64>) -> bool {
    square(inverse[(0, 1)]) < inverse[(0, 0)] * inverse[(1, 1)] * (1.0 - 1e-12)
}

fn interval(centre: f64, half: f64) -> [f64; 2] {
    [centre - half, centre + half]
}

fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(rows: &[(f64, f64)]) -> Vec<Point> {
        rows.iter().map(|&(speed, frequency)| Point { model: None, speed, frequency }).collect()
    }

    fn on_the_law(sigma: [f64; 2], speeds: &[f64]) -> Vec<Point> {
        points(&speeds.iter().map(|v| (*v, law(sigma, *v))).collect::<Vec<_>>())
    }

    #[test]
    fn points_on_a_law_give_it_back() {
        for sigma in [[7.3, 0.36], [0.05, 0.9], [1e-4, 20.0], [300.0, 1.0]] {
            let fit = fit(&on_the_law(sigma, &[1.0, 3.0, 9.0, 27.0])).unwrap();
            for (found, sigma) in fit.sigma().into_iter().zip(sigma) {
                assert!((found / sigma - 1.0).abs() < 1e-6, "{sigma} {fit:?}");
            }
        }
    }

    #[test]
    fn points_exactly_on_the_law_have_no_error() {
        let fit = fit(&on_the_law([0.4, 2.0], &[1.0, 3.0, 9.0, 27.0])).unwrap();
        for sigma in [&fit.sigma_1, &fit.sigma_2] {
            assert_eq!((sigma.se, sigma.wald_95, sigma.profile_95), (None, None, None));
        }
        assert_eq!((fit.covariance, fit.log_likelihood, fit.aic), (None, None, None));
        assert_eq!((fit.residual_se, fit.r_squared), (None, None));
        assert!(fit.reason.unwrap().starts_with("all points lie exactly"));
    }

    #[test]
    fn two_points_are_met_without_an_error() {
        let fit = fit(&on_the_law([0.4, 2.0], &[1.0, 9.0])).unwrap();
        assert!((fit.sigma_1.estimate - 0.4).abs() < 1e-9);
        assert_eq!((fit.sigma_1.se, fit.covariance, fit.predict(3.0).se), (None, None, None));
        assert!(fit.reason.unwrap().starts_with("two points determine"));
        let json = serde_json::to_string(&fit).unwrap();
        assert!(!json.contains("NaN") && json.contains("\"se\":null"), "{json}");
    }

    #[test]
    fn what_cannot_be_fitted_is_said_in_words() {
        for (rows, expected) in [
            (&[][..], "no points"),
            (&[(2.0, 0.3), (2.0, 0.4)], "2 points at the speed 2 only"),
            (&[(1.0, 0.3), (2.0, 0.4), (3.0, 0.5)], "σ₁ = -"),
            (&[(1.0, 0.5), (2.0, 0.22), (3.0, 0.13)], "σ₂ = -"),
            (&[(1.0, 0.3), (2.0, 0.15)], "σ₂ = "),
            (&[(1.0, 0.3), (2.0, -0.1)], "a point at speed 2 with frequency -0.1"),
            (&[(1.0, 0.3), (f64::NAN, 0.1)], "a point at speed NaN"),
            (&[(1.0, 0.3), (1.0 + 1e-15, 0.2), (1.0, 0.31)], ""),
        ] {
            let reason = fit(&points(rows)).unwrap_err();
            assert!(reason.starts_with(expected), "{rows:?}: {reason}");
        }
    }

    #[test]
    fn other_units_give_the_same_law() {
        let rows = [(1.0, 0.9), (2.0, 0.71), (4.0, 0.52), (8.0, 0.31), (16.0, 0.2)];
        let ours = fit(&points(&rows)).unwrap();
        // Speeds in a unit a tenth as large, frequencies in one a third as large.
        let theirs = fit(&points(&rows.map(|(v, f)| (10.0 * v, 3.0 * f)))).unwrap();
        for (ours, theirs, factor) in
            [(&ours.sigma_1, &theirs.sigma_1, 30.0), (&ours.sigma_2, &theirs.sigma_2, 3.0)]
        {
            let same = |a: f64, b: f64| assert!((a / (factor * b) - 1.0).abs() < 1e-7, "{a} {b}");
            same(ours.estimate, theirs.estimate);
            same(ours.se.unwrap(), theirs.se.unwrap());
            for bound in 0..2 {
                let bounds = |p: &Parameter| p.profile_95.unwrap()[bound].unwrap();
                same(bounds(ours), bounds(theirs));
            }
        }
    }
}
