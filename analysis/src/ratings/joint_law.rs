//! The law of the level of detail from all answers at once, by maximum likelihood.
//!
//! Where the coarsest level of a model lies beyond those tested, it gives no point, and a law through the points that are
//! left is drawn towards the levels tested. Here every answer counts, also those to images that nearly all or
//! nearly none call the same.

use super::answers::Ratings;
use super::images::Counts;
use super::points::Frequencies;
use crate::maths::student::t_975;
use crate::outcome::Outcome;
use crate::psychometric::function::MOST_LAPSES;
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

/// Most steps of the search.
const STEPS: usize = 200;

/// The shares of lapses among which the likeliest is taken: from none to the most that psychometric functions may have.
const LAPSES: [f64; 13] =
    [0.0, 0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.035, 0.04, 0.045, 0.05, 0.055, MOST_LAPSES];

/// The law that all answers are most likely under.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointLaw {
    /// σ₁ and σ₂.
    pub sigma: [JointParameter; 2],
    /// How the log-odds of "same" grow with the logarithm of the frequency.
    pub slope: f64,
    /// Share of answers that are given by chance.
    pub lapses: f64,
    /// The models, in alphabetic order.
    pub models: Vec<ModelUnderLaw>,
    /// How many images have answers.
    pub images: usize,
    /// How many answers say "same" or "different".
    pub answers: u64,
}

/// How well the law, which is one for all models, holds for one of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelUnderLaw {
    /// Its name.
    pub model: String,
    /// The share of its answers that say "same".
    pub same: f64,
    /// The share that is to be expected by the law.
    pub expected: f64,
}

/// σ₁ or σ₂.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JointParameter {
    /// The estimate.
    pub estimate: f64,
    /// Its standard error.
    pub se: f64,
    /// Student's interval on the logarithmic scale.
    pub interval_95: [f64; 2],
}

/// An image that was rated: its model, its spatial frequency, its speed and its answers.
struct Rated<'a> {
    model: &'a str,
    log_frequency: f64,
    speed: f64,
    counts: Counts,
}

/// Fits the law to the `answers` to images whose spatial frequencies are those of `frequencies`. Standard errors are those
/// of the jackknife over observers, who answer to many images each.
///
/// # Formula
/// ```text
/// P(same) = λ/2 + (1 − λ)·L(c + s·(ln ρ + ln(σ₁v + σ₂))),  L(x) = 1/(1 + e⁻ˣ),  c such that P = 0.8 at ρ = 1/(σ₁v + σ₂)
/// se² = (n − 1)/n Σ (ln σ₍ₖ₎ − mean)², interval: σ·exp(±t₀.₉₇₅(n − 1)·se); in place of se the file says σ·se
/// ```
///
/// # Errors
/// Observers are few or not told apart, a frequency is not known, or no law is the most likely.
pub fn joint_law(answers: &Ratings, frequencies: &Frequencies) -> Outcome<JointLaw> {
    let observers = answers.observers().ok_or("observers are not told apart")?;
    answers.enough_to_draw()?;
    let images = answers.images();
    let log_frequencies: Vec<f64> = images
        .iter()
        .map(|image| frequencies.at(&image.model, image.level_of_detail).map(libm::log))
        .collect::<Outcome<_>>()?;
    let rated = |counts: Vec<Counts>| -> Vec<Rated<'_>> {
        let of = images.iter().zip(&log_frequencies).zip(counts);
        of.filter(|(_, counts)| counts.trials() > 0)
            .map(|((image, &log_frequency), counts)| Rated {
                model: &image.model,
                log_frequency,
                speed: image.speed,
                counts,
            })
            .collect()
    };
    let all = rated(answers.counts());
    if all.iter().all(|image| image.speed == all[0].speed) {
        return Err(
            "the answers are to images at one speed only, at which σ₁ and σ₂ cannot be told apart"
                .into(),
        );
    }
    let (lapses, best) = likeliest(&all, None).ok_or(NO_LAW)?;
    let others = (0..observers)
        .map(|observer| {
            let found = likeliest(&rated(answers.counts_without(observer)), Some(best));
            found
                .map(|(_, found)| found)
                .ok_or("without one of the observers no law is the most likely")
        })
        .collect::<Result<Vec<_>, _>>()?;
    let n = observers as f64;
    let sigma = [0, 1].map(|i| {
        let mean = others.iter().map(|other| other[i]).sum::<f64>() / n;
        let squares: f64 = others.iter().map(|other| (other[i] - mean).powi(2)).sum();
        let se = libm::sqrt(squares * (n - 1.0) / n);
        let estimate = libm::exp(best[i]);
        let aside = libm::exp(t_975(n - 1.0) * se);
        JointParameter {
            estimate,
            se: estimate * se,
            interval_95: [estimate / aside, estimate * aside],
        }
    });
    let count = all.iter().map(|image| image.counts.trials()).sum();
    Ok(JointLaw {
        sigma,
        slope: libm::exp(best[2]),
        lapses,
        models: all
            .chunk_by(|a, b| a.model == b.model)
            .map(|images| under_law(images, lapses, &best))
            .collect(),
        images: all.len(),
        answers: count,
    })
}

/// How well the law holds for the model of these `images`.
fn under_law(images: &[Rated<'_>], lapses: f64, best: &Vector3<f64>) -> ModelUnderLaw {
    let sum = |of: &dyn Fn(&Rated<'_>) -> f64| images.iter().map(of).sum::<f64>();
    let trials = |image: &Rated<'_>| image.counts.trials() as f64;
    let expected = sum(&|image| trials(image) * chances(image, lapses, best).0[0]);
    let all = sum(&trials);
    ModelUnderLaw {
        model: images[0].model.into(),
        same: sum(&|image| image.counts.same as f64) / all,
        expected: expected / all,
    }
}

/// The share of lapses and ln σ₁, ln σ₂ and ln s with the largest likelihood, if there is a law.
fn likeliest(rated: &[Rated<'_>], start: Option<Vector3<f64>>) -> Option<(f64, Vector3<f64>)> {
    let fits = LAPSES.into_iter().filter_map(|lapses| {
        let found = most_likely(rated, lapses, start)?;
        Some((lapses, found, log_likelihood(rated, lapses, &found)))
    });
    fits.max_by(|a, b| a.2.total_cmp(&b.2)).map(|(lapses, found, _)| (lapses, found))
}

/// ln σ₁, ln σ₂ and ln s with the largest likelihood, searched by Fisher scoring with the damping of Levenberg.
fn most_likely(
    rated: &[Rated<'_>],
    lapses: f64,
    start: Option<Vector3<f64>>,
) -> Option<Vector3<f64>> {
    let mut best = start.unwrap_or_else(|| {
        // The law through the middle of the frequencies, half of it at rest.
        let n = rated.len() as f64;
        let middle = -rated.iter().map(|image| image.log_frequency).sum::<f64>() / n;
        let speed = rated.iter().map(|image| image.speed).sum::<f64>() / n;
        let half = middle - std::f64::consts::LN_2;
        Vector3::new(half - libm::log(speed.max(1e-9)), half, 0.5)
    });
    let mut likelihood = log_likelihood(rated, lapses, &best);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let (gradient, information) = derivatives(rated, lapses, &best);
        let damped = information
            + Matrix3::from_diagonal(&(information.diagonal() * damping).add_scalar(1e-12));
        let Some(step) = damped.lu().solve(&gradient) else { break };
        let next = best + step;
        let found = log_likelihood(rated, lapses, &next);
        if found.is_finite() && found >= likelihood {
            (best, likelihood, damping) = (next, found, damping * 0.2);
            if step.amax() < 1e-9 {
                let is_a_law = best.iter().all(|value| value.abs() < 25.0);
                return is_a_law.then_some(best);
            }
        } else {
            damping *= 8.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    None
}

const NO_LAW: &str = "no law with σ₁ and σ₂ above 0 is the most likely: what looks the same has to get coarser with the \
                      speed, and finer images have to look the same more often";

/// How likely "same" and "different" are, and how the first changes with the parameters.
fn chances(image: &Rated<'_>, lapses: f64, parameters: &Vector3<f64>) -> ([f64; 2], Vector3<f64>) {
    let [moving, still, slope] = [0, 1, 2].map(|i| libm::exp(parameters[i]));
    let moving = moving * image.speed;
    let excess = slope * (image.log_frequency + libm::log(moving + still));
    let at_threshold = (0.8 - 0.5 * lapses) / (1.0 - lapses);
    let x = libm::log(at_threshold / (1.0 - at_threshold)) + excess;
    let [same, different] = [x, -x].map(|x| 1.0 / (1.0 + libm::exp(-x)));
    let part = slope / (moving + still);
    let by = Vector3::new(part * moving, part * still, excess);
    let chance = |of: f64| 0.5 * lapses + (1.0 - lapses) * of;
    ([chance(same), chance(different)], by * ((1.0 - lapses) * same * different))
}

fn log_likelihood(rated: &[Rated<'_>], lapses: f64, parameters: &Vector3<f64>) -> f64 {
    let of = |image: &Rated<'_>| {
        let ([same, different], _) = chances(image, lapses, parameters);
        // What is not to be is not answered.
        let answered = |count: u64, chance: f64| count as f64 * libm::log(chance.max(1e-300));
        answered(image.counts.same, same) + answered(image.counts.different, different)
    };
    rated.iter().map(of).sum()
}

/// The gradient of the log-likelihood and the expected information.
fn derivatives(
    rated: &[Rated<'_>],
    lapses: f64,
    parameters: &Vector3<f64>,
) -> (Vector3<f64>, Matrix3<f64>) {
    let mut sum = (Vector3::zeros(), Matrix3::zeros());
    for image in rated {
        let ([same, different], by) = chances(image, lapses, parameters);
        let trials = image.counts.trials() as f64;
        let variance = (same * different).max(1e-300);
        sum.0 += by * ((image.counts.same as f64 - trials * same) / variance);
        sum.1 += by * by.transpose() * (trials / variance);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::answers::RatingTrial;
    use super::*;
    use shutterlab_data_schema::fitted::VelocityUnit;

    /// The law 1/(0.05·v + 4) with the slope 3, by observers whose answers together have these odds.
    fn rated(observers: usize, levels: &[f64], slope: f64) -> (Ratings, Frequencies) {
        let (mut trials, mut frequencies) = (vec![], Frequencies::default());
        for &level_of_detail in levels {
            let frequency = 0.5 * level_of_detail.sqrt();
            frequencies.insert("knot", level_of_detail, frequency).unwrap();
            for speed in [10.0, 30.0, 90.0, 270.0] {
                let excess: f64 = frequency * (0.05 * speed + 4.0);
                let same = observers as f64 / (1.0 + 0.25 / excess.powf(slope));
                trials.extend((0..observers).map(|observer| RatingTrial {
                    observer,
                    model: "knot".into(),
                    r: 4.0,
                    level_of_detail,
                    speed,
                    same: Some(observer as f64 + 0.5 < same),
                }));
            }
        }
        (Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap(), frequencies)
    }

    #[test]
    fn the_law_of_the_answers_is_found() {
        let levels: Vec<f64> = (0..12).map(|k| 0.64 * 0.6f64.powi(k)).collect();
        let (answers, frequencies) = rated(400, &levels, 3.0);
        let found = joint_law(&answers, &frequencies).unwrap();
        assert!((found.slope - 3.0).abs() < 0.05, "{found:?}");
        for (parameter, truth) in found.sigma.iter().zip([0.05, 4.0]) {
            assert!((parameter.estimate / truth - 1.0).abs() < 0.02, "{found:?}");
            let [low, high] = parameter.interval_95;
            assert!(low < parameter.estimate && parameter.estimate < high && low > 0.0);
        }
        assert_eq!((found.images, found.answers), (48, 48 * 400));
    }

    /// Levels that are all too coarse, or all fine enough, tell where the law is all the same.
    #[test]
    fn images_on_one_side_of_the_threshold_count() {
        for levels in [[0.02, 0.03, 0.05], [0.64, 0.8, 0.95]] {
            let (answers, frequencies) = rated(400, &levels, 1.0);
            let found = joint_law(&answers, &frequencies).unwrap();
            for (parameter, truth) in found.sigma.iter().zip([0.05, 4.0]) {
                assert!((parameter.estimate / truth - 1.0).abs() < 0.1, "{levels:?} {found:?}");
            }
        }
    }

    #[test]
    fn what_makes_no_law_is_told() {
        let (answers, frequencies) = rated(4, &[0.1, 0.2], 3.0);
        let few = joint_law(&answers, &frequencies).unwrap_err();
        assert!(few.contains("at least 5 observers"), "{few}");
        // The coarser the more alike.
        let (answers, frequencies) = rated(20, &[0.05, 0.1, 0.2, 0.4], -3.0);
        assert_eq!(joint_law(&answers, &frequencies), Err(NO_LAW.into()));
        // One speed does not tell σ₁ from σ₂.
        let (mut trials, mut frequencies) = (vec![], Frequencies::default());
        for level_of_detail in [0.1, 0.2, 0.4] {
            frequencies.insert("knot", level_of_detail, level_of_detail).unwrap();
            trials.extend((0..20).map(|observer| RatingTrial {
                observer,
                model: "knot".into(),
                r: 4.0,
                level_of_detail,
                speed: 30.0,
                same: Some(f64::from(observer as u32) < 40.0 * level_of_detail),
            }));
        }
        let answers = Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap();
        let alone = joint_law(&answers, &frequencies).unwrap_err();
        assert!(alone.contains("at one speed only"), "{alone}");
        let (answers, _) = rated(20, &[0.1, 0.2], 3.0);
        let unknown = joint_law(&answers, &Frequencies::default()).unwrap_err();
        assert!(unknown.contains("has no spatial frequencies"), "{unknown}");
    }
}
