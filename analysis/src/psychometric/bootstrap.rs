//! Bootstrap intervals of a threshold.

use super::fit::{Level, PsychometricFit, fit};
use super::threshold::place;
use crate::maths::bootstrap::enough_observers;
use crate::maths::resampling::{Bootstrap, binomial, drawn, replicates};
use crate::outcome::Outcome;

/// Parametric bootstrap (Wichmann and Hill 2001b): answers are drawn from the fitted function, which is
/// fitted to them again.
///
/// # Errors
/// As [`Bootstrap::percentile`]; resamples that no function fits, or one that runs the other way, give no
/// number.
pub fn parametric(
    fit: &PsychometricFit,
    chance: f64,
    count: usize,
    seed: u64,
) -> Outcome<Bootstrap> {
    let drawn = replicates(count, seed, |random| {
        let redrawn = |level: &super::fit::FittedLevel| Level {
            chosen: binomial(level.answers.trials, level.fitted, random),
            ..level.answers
        };
        refit(&fit.levels.iter().map(redrawn).collect::<Vec<_>>(), fit, chance)
    });
    Bootstrap::percentile(&drawn, None)
}

/// Bootstrap by observer: `observers[i]` are the answers of one of them at the levels of the fit.
/// Whole observers are drawn, so that differences between them are in the interval.
///
/// # Errors
/// There are too few observers; or as [`Bootstrap::percentile`].
pub fn by_observer(
    fit: &PsychometricFit,
    observers: &[Vec<Level>],
    chance: f64,
    count: usize,
    seed: u64,
) -> Outcome<Bootstrap> {
    enough_observers(observers.len())?;
    let drawn = replicates(count, seed, |random| {
        let times = drawn(observers.len(), random);
        let levels: Vec<Level> = observers
            .iter()
            .zip(times)
            .flat_map(|(levels, times)| levels.iter().map(move |level| (level, times)))
            .map(|(level, times)| Level {
                chosen: times * level.chosen,
                trials: times * level.trials,
                ..*level
            })
            .collect();
        refit(&pooled(&levels), fit, chance)
    });
    Bootstrap::percentile(&drawn, Some(observers.len()))
}

/// The answers at each level together, in the order of the levels.
pub fn pooled(levels: &[Level]) -> Vec<Level> {
    let mut sorted = levels.to_vec();
    sorted.sort_by(|a, b| a.level.total_cmp(&b.level));
    sorted
        .chunk_by(|a, b| a.level == b.level)
        .map(|same| Level {
            level: same[0].level,
            chosen: same.iter().map(|level| level.chosen).sum(),
            trials: same.iter().map(|level| level.trials).sum(),
        })
        .collect()
}

fn refit(levels: &[Level], original: &PsychometricFit, chance: f64) -> Option<f64> {
    let fit = fit(levels, original.model).ok()?;
    if fit.slope.estimate * original.slope.estimate <= 0.0 {
        return None;
    }
    place(&fit, chance).ok().map(|abscissa| fit.model.level(abscissa))
}

#[cfg(test)]
mod tests {
    use super::super::function::{Model, Shape};
    use super::super::threshold::threshold;
    use super::*;

    #[test]
    fn a_function_that_runs_the_other_way_is_no_replicate() {
        let levels = |chosen: [u64; 3]| {
            [0, 1, 2].map(|i| Level { level: i as f64, chosen: chosen[i], trials: 20 })
        };
        let rising = fit(&levels([8, 10, 13]), Model::yes_no(Shape::Logistic)).unwrap();
        assert!(refit(&levels([8, 11, 12]), &rising, 0.7).is_some());
        assert_eq!(refit(&levels([13, 10, 8]), &rising, 0.7), None);
        assert_eq!(refit(&levels([10, 11, 10]), &rising, 0.7), None);
        assert!(parametric(&rising, 0.7, 199, 1).is_err());
    }

    #[test]
    fn replicates_scatter_by_the_standard_error() {
        let levels = [(1.0, 12, 100), (2.0, 35, 100), (3.0, 65, 100), (4.0, 92, 100)]
            .map(|(level, chosen, trials)| Level { level, chosen, trials });
        let fit = fit(&levels, Model::yes_no(Shape::Logistic)).unwrap();
        let se = threshold(&fit, 0.5).unwrap().se;
        let drawn = parametric(&fit, 0.5, 999, 1).unwrap();
        assert!((drawn.sd / se - 1.0).abs() < 0.1, "{} {se}", drawn.sd);
        assert_eq!(drawn, parametric(&fit, 0.5, 999, 1).unwrap());
        // A hundred observers with one trial at each level.
        let one = |i: u64| {
            levels.map(|level| Level { trials: 1, chosen: u64::from(i < level.chosen), ..level })
        };
        let observers: Vec<Vec<Level>> = (0..100).map(|i| one(i).to_vec()).collect();
        assert_eq!(pooled(&observers.concat()), levels);
        let found = by_observer(&fit, &observers, 0.5, 999, 1).unwrap();
        // Those who answer at one level answer at all higher ones: observers differ by more than chance.
        assert!(found.sd > 1.3 * se, "{} {se}", found.sd);
        assert!(by_observer(&fit, &observers[..4], 0.5, 99, 1).is_err());
    }
}
