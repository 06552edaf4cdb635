//! Fitting a psychometric function by binomial maximum likelihood (Wichmann and Hill 2001).

pub use super::scoring::Level;

use super::function::{Form, Model, Rate, Shape, form, inverse};
use super::scoring::{Chance, Maximum, maximise, term};
use super::separation::refuse_step;
use crate::outcome::Outcome;
use nalgebra::Vector4;
use serde::Serialize;
use statrs::function::factorial::ln_binomial;

/// A fitted psychometric function.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PsychometricFit {
    /// What was fitted.
    pub model: Model,
    /// Value of η where the axis (level, or ln level) is 0.
    pub intercept: Coefficient,
    /// How much η rises per unit of the axis.
    pub slope: Coefficient,
    /// Guess rate γ.
    pub guess_rate: Coefficient,
    /// Lapse rate λ.
    pub lapse_rate: Coefficient,
    /// Covariance of intercept, slope, γ and λ, from the expected information; rows and columns of what
    /// is fixed or at its bound are 0.
    pub covariance: [[f64; 4]; 4],
    /// Twice the log-likelihood by which the observed shares exceed the function.
    pub deviance: f64,
    /// Its degrees of freedom: levels with trials less parameters fitted.
    pub df: usize,
    /// Logarithm of the likelihood, binomial coefficients included.
    pub log_likelihood: f64,
    /// −2·log-likelihood + 2·parameters fitted.
    pub aic: f64,
    /// The answers and what the function says.
    pub levels: Vec<FittedLevel>,
}

/// A parameter of a psychometric function.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coefficient {
    /// Its estimate, or the value it was given.
    pub estimate: f64,
    /// Standard error.
    pub se: Option<f64>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub se_reason: Option<&'static str>,
}

/// One level and what the function says of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedLevel {
    /// The answers.
    #[serde(flatten)]
    pub answers: Level,
    /// Share of the answers.
    pub share: f64,
    /// Chance of the answer by the function.
    pub fitted: f64,
    /// Signed square root of what the level adds to the deviance.
    pub deviance_residual: f64,
}

impl PsychometricFit {
    pub(super) fn parameters(&self) -> Vector4<f64> {
        Vector4::from(
            [&self.intercept, &self.slope, &self.guess_rate, &self.lapse_rate].map(|c| c.estimate),
        )
    }

    /// ψ: the chance of the answer at `level`.
    pub fn chance(&self, level: f64) -> f64 {
        at(&self.model, &self.parameters(), self.model.abscissa(level)).value
    }

    /// The answers that it was fitted to.
    pub fn answers(&self) -> Vec<Level> {
        self.levels.iter().map(|level| level.answers).collect()
    }
}

/// Fits `model` to the answers at two or more levels; levels without trials are left out.
///
/// # Errors
/// Says in words why there is no such function: too few levels; answers all alike or no better than
/// guessing; answers that a step separates, so that no slope is steep enough.
pub fn fit(levels: &[Level], model: Model) -> Outcome<PsychometricFit> {
    model.check()?;
    let levels = checked(levels, &model)?;
    let is_fitted = |rate: Rate| matches!(rate, Rate::Fitted(_));
    let parameters = 2 + [model.guess, model.lapse].into_iter().filter(|r| is_fitted(*r)).count();
    let df = levels.len().checked_sub(parameters).ok_or_else(|| {
        format!("{} levels with trials do not determine {parameters} parameters", levels.len())
    })?;
    let maximum = maximum(&levels, &model)?;
    let inverse = maximum.information.try_inverse().ok_or("the parameters cannot be told apart")?;
    let coefficient = |i: usize, fitted: bool| Coefficient {
        estimate: maximum.parameters[i],
        se: maximum.free[i].then(|| libm::sqrt(inverse[(i, i)])),
        se_reason: match (maximum.free[i], fitted) {
            (true, _) => None,
            (false, true) => Some("it is at the end of the range that it may be in"),
            (false, false) => Some("it was given, not fitted"),
        },
    };
    let covariance = std::array::from_fn(|i| {
        std::array::from_fn(|j| match maximum.free[i] && maximum.free[j] {
            true => inverse[(i, j)],
            false => 0.0,
        })
    });
    let constant: f64 = levels.iter().map(|level| ln_binomial(level.trials, level.chosen)).sum();
    let log_likelihood = maximum.log_likelihood + constant;
    let fitted: Vec<FittedLevel> =
        levels.iter().map(|level| fitted_level(*level, &model, &maximum.parameters)).collect();
    Ok(PsychometricFit {
        model,
        intercept: coefficient(0, true),
        slope: coefficient(1, true),
        guess_rate: coefficient(2, is_fitted(model.guess)),
        lapse_rate: coefficient(3, is_fitted(model.lapse)),
        covariance,
        deviance: fitted.iter().map(|l| l.deviance_residual * l.deviance_residual).sum(),
        df,
        log_likelihood,
        aic: 2.0 * parameters as f64 - 2.0 * log_likelihood,
        levels: fitted,
    })
}

/// The levels with trials.
fn checked(levels: &[Level], model: &Model) -> Outcome<Vec<Level>> {
    let asked: Vec<Level> = levels.iter().copied().filter(|level| level.trials > 0).collect();
    for Level { level, chosen, trials } in &asked {
        if chosen > trials {
            return Err(format!("{chosen} answers of {trials} trials at level {level}"));
        }
        if !model.abscissa(*level).is_finite() {
            let needed = match model.shape {
                Shape::Weibull => "a Weibull function needs levels above 0",
                _ => "levels are finite numbers",
            };
            return Err(format!("level {level}: {needed}"));
        }
    }
    let mut distinct: Vec<f64> = asked.iter().map(|level| level.level).collect();
    distinct.sort_by(f64::total_cmp);
    distinct.dedup();
    match distinct.len() {
        0 => Err("no level has a trial".into()),
        1 => Err(format!("all trials are at the level {}; a slope needs two levels", distinct[0])),
        _ => Ok(asked),
    }
}

/// Where the likelihood of checked levels is largest.
pub(super) fn maximum(levels: &[Level], model: &Model) -> Outcome<Maximum> {
    let [guess, lapse] = [model.guess.bounds(), model.lapse.bounds()];
    let open = [f64::NEG_INFINITY, f64::INFINITY];
    let bounds = [open, open, guess, lapse];
    // Rates that are fitted are begun at both ends and between: the likelihood can have several tops.
    let begins = |[low, high]: [f64; 2]| match low < high {
        true => vec![low, 0.5 * (low + high), high],
        false => vec![low],
    };
    let starts =
        begins(guess).into_iter().flat_map(|g| begins(lapse).into_iter().map(move |l| (g, l)));
    let tops = starts.map(|(guess, lapse)| {
        let start = start(levels, model, guess, lapse);
        maximise(levels, start, &bounds, |parameters, level| {
            at(model, parameters, model.abscissa(level))
        })
    });
    let highest = tops.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood));
    let maximum = highest.ok_or("there is nothing to fit")?;
    refuse_step(levels, guess, lapse, maximum.log_likelihood)?;
    match maximum.converged {
        true => Ok(maximum),
        false => Err("the likelihood has no maximum that the search could find".into()),
    }
}

/// ψ and its derivatives after intercept, slope, γ and λ.
fn at(model: &Model, parameters: &Vector4<f64>, abscissa: f64) -> Chance {
    let [intercept, slope, guess, lapse] = (*parameters).into();
    let Form { value, complement, derivative } = form(model.shape, intercept + slope * abscissa);
    let height = 1.0 - guess - lapse;
    let steep = height * derivative;
    Chance {
        value: guess + height * value,
        complement: lapse + height * complement,
        gradient: Vector4::new(steep, steep * abscissa, complement, -value),
    }
}

/// A weighted line through the inverted shares, corrected for guesses and lapses.
fn start(levels: &[Level], model: &Model, guess: f64, lapse: f64) -> Vector4<f64> {
    let points = levels.iter().map(|level| {
        let share = (level.chosen as f64 + 0.5) / (level.trials as f64 + 1.0);
        let value = ((share - guess) / (1.0 - guess - lapse)).clamp(0.05, 0.95);
        (model.abscissa(level.level), inverse(model.shape, value), level.trials as f64)
    });
    let [mut w, mut wx, mut wy, mut wxx, mut wxy] = [0.0; 5];
    for (x, y, weight) in points {
        w += weight;
        wx += weight * x;
        wy += weight * y;
        wxx += weight * x * x;
        wxy += weight * x * y;
    }
    let slope = (w * wxy - wx * wy) / (w * wxx - wx * wx);
    let slope = if slope.is_finite() { slope } else { 0.0 };
    Vector4::new((wy - slope * wx) / w, slope, guess, lapse)
}

fn fitted_level(level: Level, model: &Model, parameters: &Vector4<f64>) -> FittedLevel {
    let chance = at(model, parameters, model.abscissa(level.level));
    let [k, n] = [level.chosen as f64, level.trials as f64];
    let share = k / n;
    let half = term(level.chosen, share / chance.value)
        + term(level.trials - level.chosen, (1.0 - share) / chance.complement);
    FittedLevel {
        answers: level,
        share,
        fitted: chance.value,
        deviance_residual: libm::sqrt((2.0 * half).max(0.0)).copysign(share - chance.value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(rows: &[(f64, u64, u64)]) -> Vec<Level> {
        rows.iter().map(|&(level, chosen, trials)| Level { level, chosen, trials }).collect()
    }

    fn reason(rows: &[(f64, u64, u64)], model: Model) -> String {
        fit(&levels(rows), model).unwrap_err()
    }

    #[test]
    fn what_cannot_be_fitted_is_said_in_words() {
        let yes_no = Model::yes_no(Shape::Logistic);
        let forced = Model::forced_choice(Shape::Weibull, 2);
        for (rows, model, expected) in [
            (&[][..], yes_no, "no level has a trial"),
            (&[(1.0, 0, 0), (2.0, 0, 0)], yes_no, "no level has a trial"),
            (&[(1.0, 3, 5), (2.0, 0, 0)], yes_no, "all trials are at the level 1; a slope"),
            (&[(1.0, 0, 5), (2.0, 0, 5)], yes_no, "all answers are alike: it was never chosen"),
            (&[(1.0, 5, 5), (2.0, 5, 5)], forced, "all answers are alike: it was always chosen"),
            (&[(1.0, 0, 5), (2.0, 5, 5)], yes_no, "the answers are separated: a step at"),
            (
                &[(1.0, 0, 5), (2.0, 3, 5), (3.0, 5, 5)],
                yes_no,
                "the answers are separated: a step at one of the levels",
            ),
            (
                &[(1.0, 5, 5), (2.0, 3, 5), (3.0, 0, 5)],
                yes_no,
                "the answers are separated: a step at one of the levels",
            ),
            (
                &[(1.0, 4, 10), (2.0, 5, 10), (3.0, 3, 10)],
                forced,
                "the answers are nowhere above guessing (12 of 30",
            ),
            (
                &[(0.0, 4, 10), (2.0, 5, 10)],
                forced,
                "level 0: a Weibull function needs levels above 0",
            ),
            (&[(1.0, 6, 5), (2.0, 5, 10)], yes_no, "6 answers of 5 trials"),
            (&[(f64::NAN, 4, 10), (2.0, 5, 10)], yes_no, "level NaN: levels are finite"),
        ] {
            let reason = reason(rows, model);
            assert!(reason.starts_with(expected), "{rows:?}: {reason}");
        }
        let lapses = Model { lapse: Rate::Fitted([0.0, 0.06]), ..yes_no };
        let few = reason(&[(1.0, 2, 10), (2.0, 8, 10)], lapses);
        assert!(few.starts_with("2 levels with trials do not determine 3 parameters"), "{few}");
    }

    #[test]
    fn the_other_answer_is_the_mirror() {
        let rows = [(1.0, 2, 20), (2.0, 9, 20), (3.0, 15, 20), (4.0, 19, 20)];
        let mirrored: Vec<_> = rows.iter().map(|(x, k, n)| (*x, n - k, *n)).collect();
        for shape in [Shape::Logistic, Shape::Probit] {
            let ours = fit(&levels(&rows), Model::yes_no(shape)).unwrap();
            let theirs = fit(&levels(&mirrored), Model::yes_no(shape)).unwrap();
            assert!((ours.slope.estimate + theirs.slope.estimate).abs() < 1e-9);
            assert!((ours.deviance - theirs.deviance).abs() < 1e-9);
        }
    }

    #[test]
    fn two_levels_are_met_exactly() {
        let fit =
            fit(&levels(&[(1.0, 2, 10), (3.0, 7, 10)]), Model::yes_no(Shape::Probit)).unwrap();
        assert_eq!(fit.df, 0);
        assert!(fit.deviance < 1e-12);
        assert!((fit.chance(1.0) - 0.2).abs() < 1e-6 && (fit.chance(3.0) - 0.7).abs() < 1e-6);
    }

    #[test]
    fn fitted_rates_raise_the_likelihood_and_keep_their_bounds() {
        let rows =
            levels(&[(1.0, 1, 40), (2.0, 8, 40), (3.0, 30, 40), (4.0, 38, 40), (6.0, 38, 40)]);
        let plain = fit(&rows, Model::yes_no(Shape::Logistic)).unwrap();
        let model = Model { lapse: Rate::Fitted([0.0, 0.1]), ..plain.model };
        let lapses = fit(&rows, model).unwrap();
        assert!(lapses.log_likelihood > plain.log_likelihood + 1.0);
        assert!(lapses.lapse_rate.estimate > 0.01 && lapses.lapse_rate.estimate < 0.1);
        assert!(lapses.lapse_rate.se.is_some() && lapses.guess_rate.se.is_none());
        let tight = Model { lapse: Rate::Fitted([0.0, 0.01]), ..model };
        let tight = fit(&rows, tight).unwrap().lapse_rate;
        assert_eq!((tight.estimate, tight.se), (0.01, None));
        assert!(tight.se_reason.unwrap().contains("end of the range"));
    }
}
