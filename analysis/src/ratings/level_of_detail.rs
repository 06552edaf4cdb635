//! The coarsest level of detail that looks like the original, for each model and speed: by the paper's
//! rule on single ratings, and by a psychometric function through all of them.

use super::answers::Ratings;
use super::images::{Counts, Image};
use super::rating::{THRESHOLD, reaches};
use crate::outcome::{Outcome, entry};
use crate::psychometric::fit::{Level, PsychometricFit, fit};
use crate::psychometric::function::{Model, Shape};
use crate::psychometric::threshold::threshold;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// How the coarsest level is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// The coarsest level tested whose rating is 0.8 or more (Zhang et al. 2014).
    Point,
    /// The level at which a psychometric function through the ratings is 0.8.
    Smoothed,
}

/// The coarsest level of one model at one speed.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarsestLevel {
    /// Name of the model.
    pub model: String,
    /// The weight's exponent that it was simplified with.
    pub r: f64,
    /// Its speed.
    pub speed: f64,
    /// The levels that have a rating, ascending.
    pub levels: Vec<f64>,
    /// By the point rule.
    pub point: Outcome<f64>,
    /// Levels finer than that whose rating is below 0.8 all the same.
    pub finer_below: Vec<f64>,
    /// By the smoothed rule.
    pub smoothed: Outcome<SmoothedLevel>,
}

/// The level at which the psychometric function is 0.8.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SmoothedLevel {
    /// The level.
    pub level: f64,
    /// Its standard error, by the delta method.
    pub se: f64,
    /// 95 % interval by the profile likelihood; `null` where it is open.
    pub interval_95: [Option<f64>; 2],
    /// Value of η at the original, where ln level is 0.
    pub intercept: f64,
    /// How much η rises per unit of ln level.
    pub slope: f64,
    /// Deviance of the function.
    pub deviance: f64,
    /// Degrees of freedom of `deviance`.
    pub df: usize,
}

impl CoarsestLevel {
    /// The level by `rule`.
    pub fn level(&self, rule: Rule) -> Outcome<f64> {
        match rule {
            Rule::Point => self.point.clone(),
            Rule::Smoothed => self.smoothed.as_ref().map(|found| found.level).map_err(Clone::clone),
        }
    }
}

/// The coarsest level of every model, r and speed.
pub fn coarsest_levels(answers: &Ratings) -> Vec<CoarsestLevel> {
    coarsest(answers, &answers.counts())
}

/// As [`coarsest_levels`], of `counts` in the order of the images.
pub(super) fn coarsest(answers: &Ratings, counts: &[Counts]) -> Vec<CoarsestLevel> {
    by_speed(answers, counts).into_iter().map(|(first, levels)| one(first, &levels)).collect()
}

/// The levels of the coarsest of each model, r and speed by `rule`, without anything else.
pub(super) fn only_levels(answers: &Ratings, counts: &[Counts], rule: Rule) -> Vec<Option<f64>> {
    let level = |levels: &[Level]| match rule {
        Rule::Point => point(levels).ok(),
        Rule::Smoothed => smoothed_level(levels).ok().map(|(_, level)| level),
    };
    by_speed(answers, counts).iter().map(|(_, levels)| level(levels)).collect()
}

/// The answers of each model, r and speed, by ascending level; those without answers are left out.
fn by_speed<'a>(answers: &'a Ratings, counts: &[Counts]) -> Vec<(&'a Image, Vec<Level>)> {
    let rows: Vec<(&Image, Counts)> = answers.images().iter().zip(counts.iter().copied()).collect();
    rows.chunk_by(|(a, _), (b, _)| (&a.model, a.r, a.speed) == (&b.model, b.r, b.speed))
        .map(|rows| {
            let levels = rows.iter().filter(|(_, counts)| counts.trials() > 0);
            let levels = levels.map(|(image, counts)| Level {
                level: image.level_of_detail,
                chosen: counts.same,
                trials: counts.trials(),
            });
            (rows[0].0, levels.collect())
        })
        .collect()
}

fn one(image: &Image, levels: &[Level]) -> CoarsestLevel {
    let point = point(levels);
    let finer = |level: &&Level| point.as_ref().is_ok_and(|coarsest| level.level > *coarsest);
    let below = levels.iter().filter(finer).filter(|l| !reaches(l.chosen, l.trials));
    CoarsestLevel {
        model: image.model.clone(),
        r: image.r,
        speed: image.speed,
        levels: levels.iter().map(|level| level.level).collect(),
        finer_below: below.map(|level| level.level).collect(),
        smoothed: smoothed(levels),
        point,
    }
}

/// The coarsest of `levels`, ascending, that reaches 0.8.
fn point(levels: &[Level]) -> Outcome<f64> {
    let coarsest = levels.iter().position(|level| reaches(level.chosen, level.trials));
    match (coarsest, levels) {
        (_, []) => Err("no level has a rating".into()),
        (None, [.., finest]) => Err(format!(
            "no level reaches 0.8, and the finest tested is {}: the level is finer than that",
            finest.level
        )),
        (Some(0), [coarsest, ..]) => Err(format!(
            "the coarsest level tested, {}, reaches 0.8: the level may be coarser than that",
            coarsest.level
        )),
        (Some(place), _) => Ok(levels[place].level),
    }
}

/// # Formula
/// ```text
/// ψ(l) = 1/(1 + exp(−(intercept + slope·ln l))),  ψ(level) = 0.8
/// ```
fn smoothed(levels: &[Level]) -> Outcome<SmoothedLevel> {
    let (fit, level) = smoothed_level(levels)?;
    let found = threshold(&fit, THRESHOLD)?;
    Ok(SmoothedLevel {
        level,
        se: level * found.se,
        interval_95: found.profile_95.map(|bound| bound.map(libm::exp)),
        intercept: fit.intercept.estimate,
        slope: fit.slope.estimate,
        deviance: fit.deviance,
        df: fit.df,
    })
}

fn smoothed_level(levels: &[Level]) -> Outcome<(PsychometricFit, f64)> {
    let by_logarithm: Vec<Level> =
        levels.iter().map(|level| Level { level: libm::log(level.level), ..*level }).collect();
    let fit = fit(&by_logarithm, Model::yes_no(Shape::Logistic))?;
    let [intercept, slope] = [fit.intercept.estimate, fit.slope.estimate];
    if slope <= 0.0 {
        return Err("the ratings do not rise with the level of detail".into());
    }
    let logit = libm::log(THRESHOLD / (1.0 - THRESHOLD));
    let level = libm::exp((logit - intercept) / slope);
    let [coarsest, finest] = [levels.first(), levels.last()].map(|l| l.map_or(level, |l| l.level));
    match () {
        () if level < coarsest => Err(format!(
            "the ratings are at 0.8 only below the coarsest level tested, {coarsest}: the level is \
             coarser than that"
        )),
        () if level > finest => Err(format!(
            "the ratings are at 0.8 only above the finest level tested, {finest}: the level is \
             finer than that"
        )),
        () => Ok((fit, level)),
    }
}

impl Serialize for CoarsestLevel {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("model", &self.model)?;
        map.serialize_entry("r", &self.r)?;
        map.serialize_entry("speed", &self.speed)?;
        map.serialize_entry("levels", &self.levels)?;
        entry(&mut map, "point", &self.point)?;
        map.serialize_entry("finer_below", &self.finer_below)?;
        entry(&mut map, "smoothed", &self.smoothed)?;
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(same: &[(f64, u64)]) -> Vec<Level> {
        same.iter().map(|&(level, chosen)| Level { level, chosen, trials: 20 }).collect()
    }

    #[test]
    fn the_coarsest_level_that_will_do_is_found() {
        let found = one(
            &Image { model: "bunny".into(), r: 4.0, speed: 5.0, level_of_detail: 0.01 },
            &levels(&[(0.01, 3), (0.02, 9), (0.05, 16), (0.1, 15), (0.3, 19)]),
        );
        assert_eq!((found.point, found.finer_below), (Ok(0.05), vec![0.1]));
        let smoothed = found.smoothed.unwrap();
        assert!(smoothed.level > 0.05 && smoothed.level < 0.1, "{smoothed:?}");
        let [low, high] = smoothed.interval_95.map(Option::unwrap);
        assert!(low < smoothed.level && smoothed.level < high && high < 0.3);
    }

    #[test]
    fn where_none_or_all_will_do_it_is_said_in_words() {
        for (same, by_point, by_function) in [
            (
                &[(0.01, 3), (0.1, 15)][..],
                "no level reaches 0.8, and the finest",
                "the ratings are at 0.8 only above",
            ),
            (
                &[(0.01, 17), (0.1, 19)],
                "the coarsest level tested, 0.01, reaches",
                "the ratings are at 0.8 only below",
            ),
            (&[(0.01, 0), (0.1, 20)], "", "the answers are separated"),
            (
                &[(0.01, 20), (0.1, 20)],
                "the coarsest level",
                "all answers are alike: it was always",
            ),
            (&[(0.01, 18), (0.1, 15)], "the coarsest level", "the ratings do not rise"),
            (&[], "no level has a rating", "no level has a trial"),
        ] {
            let levels = levels(same);
            let point = point(&levels).map_or_else(|reason| reason, |_| String::new());
            assert!(point.starts_with(by_point), "{same:?}: {point}");
            let function = smoothed(&levels).unwrap_err();
            assert!(function.starts_with(by_function), "{same:?}: {function}");
        }
    }
}
