//! Bootstrap intervals of σ₁ and σ₂: by observer where the answers are known, of the residuals where only
//! the points are.

use super::answers::Ratings;
use super::least_squares::{Solution, gradient, law, solve, speeds};
use super::level_of_detail::{CoarsestLevel, Rule, only_levels};
use super::points::{Frequencies, Point};
use super::reciprocal::{FittedPoint, ReciprocalFit};
use crate::maths::bootstrap::quantile;
use crate::maths::resampling::{Bootstrap, replicates};
use crate::outcome::Outcome;
use nalgebra::Matrix2;
use rand::RngExt;

/// Bootstrap by observer: of as many observers drawn with replacement (or of the answers to each image
/// drawn anew, where observers are not told apart) the coarsest levels are found and the law is fitted
/// again, to those points that `levels`, the ones of `answers`, give; a resample without all of them
/// gives no law.
///
/// # Errors
/// There are too few observers; or as [`Bootstrap::percentile`].
pub fn by_observer(
    answers: &Ratings,
    levels: &[CoarsestLevel],
    rule: Rule,
    frequencies: &Frequencies,
    count: usize,
    seed: u64,
) -> Outcome<[Bootstrap; 2]> {
    answers.enough_to_draw()?;
    let used: Vec<bool> = levels
        .iter()
        .map(|level| level.level(rule).and_then(|l| frequencies.at(&level.model, l)).is_ok())
        .collect();
    let drawn = replicates(count, seed, |random| {
        let found = only_levels(answers, &answers.draw(random), rule);
        let points: Option<Vec<Point>> = levels
            .iter()
            .zip(found)
            .zip(&used)
            .filter(|(_, used)| **used)
            .map(|((CoarsestLevel { model, speed, .. }, level), _)| {
                let frequency = frequencies.at(model, level?).ok()?;
                Some(Point { model: Some(model.clone()), speed: *speed, frequency })
            })
            .collect();
        points.filter(|points| speeds(points).len() > 1).and_then(|points| solve(&points))
    });
    let of = |i: usize| {
        let values: Vec<Option<f64>> =
            drawn.iter().map(|found| found.map(|found| found.sigma[i])).collect();
        Bootstrap::percentile(&values, answers.observers()).map_err(|reason| {
            format!("{reason}; a resample that lacks a point of the fit gives none")
        })
    };
    Ok([of(0)?, of(1)?])
}

/// Bootstrap of the residuals, studentised (Efron and Tibshirani 1993, §12.5): residuals, each divided by
/// √(1 − leverage), are drawn with replacement and added to the law.
///
/// # Formula
/// ```text
/// t* = (σ* − σ)/se*,  interval: [σ − t*(0.975)·se, σ − t*(0.025)·se]
/// ```
///
/// # Errors
/// The points are met exactly; or as [`Bootstrap::percentile`].
pub fn of_residuals(fit: &ReciprocalFit, count: usize, seed: u64) -> Outcome<[Bootstrap; 2]> {
    let (Some(covariance), Some(variance)) = (fit.covariance, fit.residual_se.map(|se| se * se))
    else {
        return Err("the points are met exactly: there are no residuals to draw".into());
    };
    let sigma = fit.sigma();
    let covariance = Matrix2::from(covariance);
    let spread = |point: &FittedPoint| {
        let gradient = gradient(sigma, point.point.speed);
        let leverage = (gradient.transpose() * covariance * gradient)[0] / variance;
        point.residual / libm::sqrt((1.0 - leverage).max(1e-12))
    };
    let mut residuals: Vec<f64> = fit.points.iter().map(spread).collect();
    let mean = residuals.iter().sum::<f64>() / residuals.len() as f64;
    residuals.iter_mut().for_each(|residual| *residual -= mean);
    let drawn: Vec<Option<([f64; 2], [f64; 2])>> = replicates(count, seed, |random| {
        let draw = |point: &FittedPoint| {
            let residual = residuals[random.random_range(0..residuals.len())];
            let frequency = law(sigma, point.point.speed) + residual;
            Point { frequency, ..point.point.clone() }
        };
        let points: Vec<Point> = fit.points.iter().map(draw).collect();
        let Solution { sigma: found, rss, information } = solve(&points)?;
        let inverse = information.try_inverse()?;
        let scale = rss / fit.df as f64;
        let t = [0, 1].map(|i| (found[i] - sigma[i]) / libm::sqrt(scale * inverse[(i, i)]));
        t.iter().all(|t| t.is_finite()).then_some((found, t))
    });
    let of = |i: usize| -> Outcome<Bootstrap> {
        let values: Vec<Option<f64>> = drawn.iter().map(|d| d.map(|(found, _)| found[i])).collect();
        let percentile = Bootstrap::percentile(&values, None)?;
        let mut t: Vec<f64> = drawn.iter().flatten().map(|(_, t)| t[i]).collect();
        t.sort_by(f64::total_cmp);
        let se = libm::sqrt(covariance[(i, i)]);
        let interval_95 = [0.975, 0.025].map(|p| sigma[i] - quantile(&t, p) * se);
        Ok(Bootstrap { interval_95, ..percentile })
    };
    Ok([of(0)?, of(1)?])
}

#[cfg(test)]
mod tests {
    use super::super::answers::RatingTrial;
    use super::super::level_of_detail::coarsest_levels;
    use super::super::reciprocal::fit;
    use super::*;
    use shutterlab_data_schema::fitted::VelocityUnit;

    #[test]
    fn a_resample_that_lacks_a_point_gives_no_law() {
        let mut frequencies = Frequencies::default();
        let mut trials = Vec::new();
        for (speed, counts) in [(1.0, [1, 4, 9]), (2.0, [2, 6, 9]), (4.0, [4, 8, 10])] {
            for (level_of_detail, count) in [0.1, 0.3, 0.8].into_iter().zip(counts) {
                frequencies.insert("bunny", level_of_detail, level_of_detail).unwrap();
                trials.extend((0..10).map(|observer| RatingTrial {
                    observer,
                    model: "bunny".into(),
                    r: 4.0,
                    level_of_detail,
                    speed,
                    same: Some(observer < count),
                }));
            }
        }
        let answers = Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap();
        let levels = coarsest_levels(&answers);
        assert!(levels.iter().all(|level| level.smoothed.is_ok()));
        let reason = by_observer(&answers, &levels, Rule::Smoothed, &frequencies, 199, 1);
        assert!(reason.unwrap_err().contains("lacks a point of the fit"));
    }

    #[test]
    fn residuals_scatter_the_law_by_its_standard_error() {
        let noise = [0.01, -0.02, 0.004, 0.016, -0.011, 0.002, -0.006, 0.013, -0.008, 0.0];
        let points: Vec<Point> = (1..)
            .zip(noise)
            .map(|(v, noise)| {
                let speed = f64::from(v);
                Point { model: None, speed, frequency: law([0.2, 0.8], speed) + noise }
            })
            .collect();
        let fit = fit(&points).unwrap();
        let drawn = of_residuals(&fit, 1999, 1).unwrap();
        for (drawn, parameter) in drawn.iter().zip([&fit.sigma_1, &fit.sigma_2]) {
            assert!((drawn.sd / parameter.se.unwrap() - 1.0).abs() < 0.15, "{drawn:?}");
            let [low, high] = drawn.interval_95;
            let [wald_low, wald_high] = parameter.wald_95.unwrap();
            assert!(((high - low) / (wald_high - wald_low) - 1.0).abs() < 0.3, "{drawn:?}");
        }
    }

    #[test]
    fn without_residuals_there_is_nothing_to_draw() {
        let points = [(1.0, 1.0), (4.0, 0.5)].map(|(speed, frequency)| Point {
            model: None,
            speed,
            frequency,
        });
        assert!(of_residuals(&fit(&points).unwrap(), 99, 1).unwrap_err().contains("exactly"));
    }
}
