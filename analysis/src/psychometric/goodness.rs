//! Goodness of fit of a psychometric function: its deviance against that of answers drawn from it.

use super::fit::{Level, PsychometricFit, fit};
use crate::PValue;
use crate::maths::distributions::chi_square_tail;
use crate::maths::resampling::{binomial, replicates};
use crate::outcome::Outcome;
use serde::Serialize;

/// Tests of the deviance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoodnessOfFit {
    /// The deviance of the fit.
    pub deviance: f64,
    /// Its degrees of freedom.
    pub df: usize,
    /// Upper tail of χ²(df), approximate.
    pub p: PValue,
    /// Share of simulated deviances at least as large, by Monte Carlo.
    pub p_monte_carlo: PValue,
    /// How many sets of answers were drawn.
    pub replicates: usize,
    /// How many of them could not be fitted; they are left out.
    pub failed: usize,
}

/// Tests whether the answers scatter about the function as binomial answers do (Wichmann and Hill 2001).
///
/// # Formula
/// ```text
/// p = (1 + #{D* ≥ D}) / (1 + B)
/// ```
/// over B refitted sets of answers drawn from the function.
///
/// # Errors
/// There are as many parameters as levels; or more than one in twenty of those drawn could not be fitted.
pub fn goodness_of_fit(
    original: &PsychometricFit,
    count: usize,
    seed: u64,
) -> Outcome<GoodnessOfFit> {
    if original.df == 0 {
        return Err(
            "there are as many parameters as levels: the function meets the shares exactly".into(),
        );
    }
    let deviances: Vec<Option<f64>> = replicates(count, seed, |random| {
        let levels: Vec<Level> = original
            .levels
            .iter()
            .map(|level| Level {
                chosen: binomial(level.answers.trials, level.fitted, random),
                ..level.answers
            })
            .collect();
        fit(&levels, original.model).ok().map(|fit| fit.deviance)
    });
    let drawn: Vec<f64> = deviances.iter().copied().flatten().collect();
    let failed = count - drawn.len();
    // What cannot be fitted is no random part of what was drawn.
    if drawn.is_empty() || 20 * failed > count {
        return Err(format!(
            "{failed} of {count} sets of answers drawn from the function could not be fitted, and at \
             most one in twenty may be left out"
        ));
    }
    let above = drawn.iter().filter(|deviance| **deviance >= original.deviance).count();
    Ok(GoodnessOfFit {
        deviance: original.deviance,
        df: original.df,
        p: PValue::new(chi_square_tail(original.deviance, original.df as f64)),
        p_monte_carlo: PValue::new((1 + above) as f64 / (1 + drawn.len()) as f64),
        replicates: count,
        failed,
    })
}

#[cfg(test)]
mod tests {
    use super::super::function::{Model, Shape};
    use super::*;

    #[test]
    fn too_many_sets_without_a_fit_are_said_in_words() {
        let levels = [(1.0, 0), (2.0, 1), (3.0, 2), (4.0, 3)].map(|(level, chosen)| Level {
            level,
            chosen,
            trials: 3,
        });
        let fit = fit(&levels, Model::yes_no(Shape::Logistic)).unwrap();
        let reason = goodness_of_fit(&fit, 199, 1).unwrap_err();
        assert!(reason.contains("of 199 sets of answers drawn from the function"), "{reason}");
    }

    #[test]
    fn answers_that_jump_about_do_not_fit() {
        let levels = |shares: [u64; 6]| -> Vec<Level> {
            (1..)
                .zip(shares)
                .map(|(x, chosen)| Level { level: f64::from(x), chosen, trials: 40 })
                .collect()
        };
        let model = Model::yes_no(Shape::Logistic);
        let smooth = fit(&levels([3, 7, 14, 26, 33, 38]), model).unwrap();
        let jumps = fit(&levels([3, 27, 4, 36, 13, 38]), model).unwrap();
        let [smooth, jumps] = [smooth, jumps].map(|fit| goodness_of_fit(&fit, 499, 3).unwrap());
        assert!(smooth.p_monte_carlo.value() > 0.2 && smooth.p.value() > 0.2);
        assert!(jumps.p_monte_carlo.value() <= 0.002 && jumps.p.value() < 1e-6);
    }
}
