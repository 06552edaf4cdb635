//! The threshold: the level at which the psychometric function reaches a value, with intervals.

use super::fit::{Level, PsychometricFit};
use super::function::{Form, Model, form, inverse};
use super::scoring::{Chance, Maximum, maximise};
use crate::maths::distributions::{Z_975, bisect};
use crate::outcome::Outcome;
use crate::report::labels::significant;
use nalgebra::{Matrix4, Vector4};
use serde::Serialize;

/// A threshold with its standard error and likelihood intervals.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Threshold {
    /// The chance that the function has there, from 0 to 1.
    pub chance: f64,
    /// The level.
    pub level: f64,
    /// That it lies outside the levels tested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outside: Option<&'static str>,
    /// Its standard error, by the delta method.
    pub se: f64,
    /// 95 % interval by the delta method on the axis of the function (for Weibull functions ln level).
    pub delta_95: [f64; 2],
    /// 95 % interval by the profile likelihood; `null` where it is open.
    pub profile_95: [Option<f64>; 2],
    /// Why the profile interval is open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile_95_reason: Option<&'static str>,
}

/// Half of the 95 % quantile of χ² with one degree of freedom.
const HALF_CHI2: f64 = 0.5 * Z_975 * Z_975;

/// Where `fit` reaches `chance`.
///
/// # Formula
/// ```text
/// t = (η_p − intercept)/slope,  η_p = F⁻¹((p − γ)/(1 − γ − λ))
/// delta:    var(t) = ∇tᵀ·V·∇t
/// profile:  {t: 2[ℓ(fit) − max ℓ given t] ≤ χ²(0.95; 1)}
/// ```
/// with the covariance V of the fit; γ and λ are varied where they are fitted.
///
/// # Errors
/// Says in words why there is no threshold: the function does not reach the value, or it does not rise.
pub fn threshold(fit: &PsychometricFit, chance: f64) -> Outcome<Threshold> {
    let abscissa = place(fit, chance)?;
    if fit.slope.estimate < 0.0 {
        return Err(format!(
            "the function falls with the level (slope {}); count the other answer, for one that rises",
            significant(fit.slope.estimate)
        ));
    }
    let [_, slope, guess, lapse] = fit.parameters().into();
    let [by_guess, by_lapse] = shifts(&fit.model, guess, lapse, chance);
    let gradient = Vector4::new(-1.0, -abscissa, by_guess, by_lapse) / slope;
    let covariance = Matrix4::from(fit.covariance);
    let se = libm::sqrt((gradient.transpose() * covariance * gradient)[0]);
    let level = |abscissa: f64| fit.model.level(abscissa);
    let profile_95 = profile(fit, chance, abscissa, se).map(|bound| bound.map(level));
    let is_open = profile_95.iter().any(Option::is_none);
    let [lowest, highest] = ends(fit);
    let scale = if level(2.0) == 2.0 { 1.0 } else { level(abscissa) };
    Ok(Threshold {
        chance,
        level: level(abscissa),
        outside: match () {
            () if abscissa < lowest => Some("below all levels tested"),
            () if abscissa > highest => Some("above all levels tested"),
            () => None,
        },
        se: se * scale,
        delta_95: [level(abscissa - Z_975 * se), level(abscissa + Z_975 * se)],
        profile_95,
        profile_95_reason: is_open.then_some(
            "however far the threshold lies on that side, the likelihood stays near its maximum",
        ),
    })
}

/// A function whose η changes by less than this from end to end of the levels is flat.
const FLAT: f64 = 1e-6;

/// The lowest and the highest level on the axis.
fn ends(fit: &PsychometricFit) -> [f64; 2] {
    let places = || fit.levels.iter().map(|level| fit.model.abscissa(level.answers.level));
    [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)]
}

/// The place of the threshold on the axis; the function may fall.
pub(super) fn place(fit: &PsychometricFit, chance: f64) -> Outcome<f64> {
    let [intercept, slope, guess, lapse] = fit.parameters().into();
    if !(guess < chance && chance < 1.0 - lapse) {
        return Err(format!(
            "the function runs from {guess} to {} and never is {chance}",
            1.0 - lapse
        ));
    }
    let abscissa = (eta(&fit.model, guess, lapse, chance) - intercept) / slope;
    let level = fit.model.level(abscissa);
    let [lowest, highest] = ends(fit);
    let flat = slope.abs() * (highest - lowest) < FLAT;
    match level.is_finite() && abscissa.is_finite() && !flat {
        true => Ok(abscissa),
        false => Err("the function does not change with the level".into()),
    }
}

/// The η at which ψ is `chance`.
fn eta(model: &Model, guess: f64, lapse: f64, chance: f64) -> f64 {
    inverse(model.shape, (chance - guess) / (1.0 - guess - lapse))
}

/// How η_p moves with γ and λ.
fn shifts(model: &Model, guess: f64, lapse: f64, chance: f64) -> [f64; 2] {
    let height = 1.0 - guess - lapse;
    let steep = form(model.shape, eta(model, guess, lapse, chance)).derivative * height * height;
    [-(1.0 - chance - lapse) / steep, (chance - guess) / steep]
}

/// The bounds of the profile interval, on the axis.
fn profile(fit: &PsychometricFit, chance: f64, best: f64, se: f64) -> [Option<f64>; 2] {
    let levels = fit.answers();
    let top = Profile::at(fit, &levels, chance, best, fit.parameters()).log_likelihood;
    [-1.0, 1.0].map(|side| {
        let place = |distance: f64| best + side * distance;
        let mut warm = fit.parameters();
        let mut drop = |distance: f64| {
            let maximum = Profile::at(fit, &levels, chance, place(distance), warm);
            warm = maximum.parameters;
            top - maximum.log_likelihood
        };
        // Steps grow from the standard error until the likelihood has fallen far enough.
        let mut inside = 0.0;
        let mut outside = se;
        while drop(outside) < HALF_CHI2 {
            inside = outside;
            outside *= 1.6;
            if outside > 1e3 * se {
                return None;
            }
        }
        let warm = warm;
        let reached = |distance: f64| {
            let maximum = Profile::at(fit, &levels, chance, place(distance), warm);
            top - maximum.log_likelihood >= HALF_CHI2
        };
        // Half a thousandth of a standard error would do; bisection to the last bit costs little more.
        Some(place(bisect(inside, outside, reached)))
    })
}

/// The likelihood where the threshold is given: intercept gives way to it.
struct Profile;

impl Profile {
    /// The maximum given that ψ is `chance` at `abscissa`. Parameters: the place, slope, γ, λ.
    fn at(
        fit: &PsychometricFit,
        levels: &[Level],
        chance: f64,
        abscissa: f64,
        warm: Vector4<f64>,
    ) -> Maximum {
        let model = &fit.model;
        let mut start = warm;
        start[0] = abscissa;
        let [guess, lapse] = [model.guess.bounds(), model.lapse.bounds()];
        // The function has to reach the value.
        let guess = [guess[0], guess[1].min(chance - 1e-9)];
        let lapse = [lapse[0], lapse[1].min(1.0 - chance - 1e-9)];
        let open = [f64::NEG_INFINITY, f64::INFINITY];
        let bounds = [[abscissa, abscissa], open, guess, lapse];
        maximise(levels, start, &bounds, |parameters, level| {
            let [place, slope, guess, lapse] = (*parameters).into();
            let distance = model.abscissa(level) - place;
            let eta = eta(model, guess, lapse, chance) + slope * distance;
            let Form { value, complement, derivative } = form(model.shape, eta);
            let height = 1.0 - guess - lapse;
            let steep = height * derivative;
            let [by_guess, by_lapse] = shifts(model, guess, lapse, chance).map(|by| steep * by);
            Chance {
                value: guess + height * value,
                complement: lapse + height * complement,
                gradient: Vector4::new(
                    0.0,
                    steep * distance,
                    complement + by_guess,
                    by_lapse - value,
                ),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::fit;
    use super::super::function::{Rate, Shape};
    use super::*;

    fn levels() -> Vec<Level> {
        [(1.0, 11, 20), (2.0, 14, 20), (3.0, 17, 20), (4.0, 19, 20), (6.0, 20, 20)]
            .map(|(level, chosen, trials)| Level { level, chosen, trials })
            .to_vec()
    }

    #[test]
    fn the_function_has_the_value_at_its_threshold() {
        for shape in [Shape::Logistic, Shape::Probit, Shape::Weibull] {
            for lapse in [Rate::Fixed(0.0), Rate::Fitted([0.0, 0.1])] {
                let model = Model { lapse, ..Model::forced_choice(shape, 2) };
                let fit = fit(&levels(), model).unwrap();
                let found = threshold(&fit, 0.75).unwrap();
                assert!((fit.chance(found.level) - 0.75).abs() < 1e-12);
                let [Some(low), Some(high)] = found.profile_95 else { panic!("{found:?}") };
                assert!(low < found.level && found.level < high, "{found:?}");
                assert!(
                    threshold(&fit, 0.5).unwrap_err().starts_with("the function runs from 0.5")
                );
            }
        }
    }

    #[test]
    fn levels_in_another_unit_give_the_threshold_in_that_unit() {
        let tenfold: Vec<Level> = levels()
            .into_iter()
            .map(|level| Level { level: 10.0 * level.level, ..level })
            .collect();
        for shape in [Shape::Logistic, Shape::Probit, Shape::Weibull] {
            let [ours, theirs] = [levels(), tenfold.clone()].map(|levels| {
                threshold(&fit(&levels, Model::forced_choice(shape, 2)).unwrap(), 0.75).unwrap()
            });
            let same = |a: f64, b: f64| assert!((10.0 * a / b - 1.0).abs() < 1e-7, "{a} {b}");
            same(ours.level, theirs.level);
            same(ours.se, theirs.se);
            for i in 0..2 {
                same(ours.delta_95[i], theirs.delta_95[i]);
                same(ours.profile_95[i].unwrap(), theirs.profile_95[i].unwrap());
            }
        }
    }

    #[test]
    fn a_function_that_does_not_rise_has_words_and_no_threshold() {
        for (chosen, expected) in [
            ([18, 13, 6, 2], "the function falls"),
            ([9, 11, 11, 9], "the function does not change"),
        ] {
            let levels: Vec<Level> = (1..)
                .zip(chosen)
                .map(|(x, chosen)| Level { level: f64::from(x), chosen, trials: 20 })
                .collect();
            let fit = fit(&levels, Model::yes_no(Shape::Logistic)).unwrap();
            let reason = threshold(&fit, 0.6).unwrap_err();
            assert!(reason.starts_with(expected), "{reason}");
        }
    }

    #[test]
    fn a_threshold_outside_the_levels_is_said() {
        let fit = fit(&levels(), Model::yes_no(Shape::Logistic)).unwrap();
        let outside = |chance| threshold(&fit, chance).unwrap().outside;
        assert_eq!(outside(0.1), Some("below all levels tested"));
        assert_eq!(outside(0.75), None);
        assert_eq!(outside(0.9999), Some("above all levels tested"));
    }

    #[test]
    fn a_flat_function_has_an_open_interval() {
        let flat: Vec<Level> = [(1.0, 10, 20), (2.0, 9, 20), (3.0, 11, 20), (4.0, 11, 20)]
            .map(|(level, chosen, trials)| Level { level, chosen, trials })
            .to_vec();
        let fit = fit(&flat, Model::yes_no(Shape::Logistic)).unwrap();
        let found = threshold(&fit, 0.8).unwrap();
        assert_eq!(found.profile_95[1], None);
        assert!(found.profile_95_reason.unwrap().starts_with("however far"));
    }
}
