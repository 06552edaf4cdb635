//! How often the intervals of ratings, thresholds and the law of the level of detail hold the truth: simulated
//! studies with known parameters, as a Markdown table.
//!
//! `cargo run --release -p shutterlab-analysis --example calibrate_ratings [STUDIES]`, 1,000 studies if nothing
//! else is said.

#![expect(clippy::print_stdout, reason = "a program that prints a table")]
#![expect(clippy::unwrap_used, reason = "what a simulation cannot do should stop it")]

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use shutterlab_analysis::maths::resampling::{binomial, replicates};
use shutterlab_analysis::psychometric::bootstrap::{by_observer, parametric};
use shutterlab_analysis::psychometric::fit::{Level, fit};
use shutterlab_analysis::psychometric::function::{Model, Rate, Shape};
use shutterlab_analysis::psychometric::goodness::goodness_of_fit;
use shutterlab_analysis::psychometric::threshold::threshold;
use shutterlab_analysis::ratings::answers::{RatingTrial, Ratings};
use shutterlab_analysis::ratings::histogram::histogram;
use shutterlab_analysis::ratings::law::{Setting, from_points, from_ratings};
use shutterlab_analysis::ratings::level_of_detail::{Rule, coarsest_levels};
use shutterlab_analysis::ratings::over_models::over_models;
use shutterlab_analysis::ratings::points::{Frequencies, Point};
use shutterlab_analysis::ratings::rating::ratings;
use shutterlab_data_schema::fitted::{FrequencyUnit, VelocityUnit};

const SEED: u64 = 20_261_201;
const RESAMPLES: usize = 499;

/// One number in one study: its estimate, and intervals by name. An interval that is missing was refused.
struct Found {
    estimate: f64,
    intervals: Vec<(&'static str, Option<[f64; 2]>)>,
}

fn main() {
    let studies = std::env::args().nth(1).map_or(1000, |text| text.parse().unwrap());
    println!("{studies} studies each, {RESAMPLES} resamples for a bootstrap, seed {SEED}.\n");
    println!("| what | interval | studies with it | coverage, % | bias/SD |");
    println!("|---|---|---|---|---|");
    thresholds(studies);
    laws_of_points(studies);
    laws_over_models(studies);
    laws_of_answers(studies);
    rating_intervals(studies);
    let decisions = choices_of_r(studies);
    println!("\n| false positives and decisions | share of studies, % |");
    println!("|---|---|");
    deviances(studies);
    rating_tests(studies);
    for (what, of) in decisions {
        share(&what, &of);
    }
}

/// Prints how often each interval of `found` holds the `truth`.
fn report(what: &str, truth: f64, found: &[Option<&Found>]) {
    let known: Vec<&Found> = found.iter().copied().flatten().collect();
    let n = known.len() as f64;
    let mean = known.iter().map(|found| found.estimate).sum::<f64>() / n;
    let squares: f64 = known.iter().map(|f| (f.estimate - mean).powi(2)).sum();
    let bias = (mean - truth) / (squares / (n - 1.0)).sqrt();
    for (i, (name, _)) in known[0].intervals.iter().enumerate() {
        let intervals: Vec<[f64; 2]> =
            known.iter().filter_map(|found| found.intervals[i].1).collect();
        let held = intervals.iter().filter(|[low, high]| *low <= truth && truth <= *high).count();
        let coverage = 100.0 * held as f64 / intervals.len() as f64;
        println!("| {what} | {name} | {} | {coverage:.1} | {bias:+.3} |", intervals.len());
    }
}

/// An interval with open sides.
fn open([low, high]: [Option<f64>; 2]) -> [f64; 2] {
    [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]
}

fn normal(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}

fn thresholds(studies: usize) {
    let forced = Model::forced_choice(Shape::Weibull, 2);
    let lapses = Model { lapse: Rate::Fitted([0.0, 0.06]), ..forced };
    let cases = [
        (
            "threshold at 50 %, logistic, yes/no, 7 levels × 20",
            Model::yes_no(Shape::Logistic),
            20,
            0.0,
            0.5,
        ),
        (
            "threshold at 80 %, logistic, yes/no, 7 levels × 20",
            Model::yes_no(Shape::Logistic),
            20,
            0.0,
            0.8,
        ),
        ("threshold at 75 %, Weibull, 2AFC, 7 levels × 40", forced, 40, 0.0, 0.75),
        (
            "threshold at 75 %, Weibull, 2AFC, 7 levels × 40, λ = 0.02 fitted",
            lapses,
            40,
            0.02,
            0.75,
        ),
    ];
    let levels = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0];
    for (what, model, trials, lapse, chance) in cases {
        let weibull = model.shape == Shape::Weibull;
        let (intercept, slope) = if weibull { (-1.7, 2.0) } else { (-3.0, 1.5) };
        let bottom = if weibull { 0.5 } else { 0.0 };
        let height = 1.0 - bottom - lapse;
        let truth = {
            let value = (chance - bottom) / height;
            match weibull {
                true => ((-(1.0_f64 - value).ln()).ln() - intercept).exp().powf(1.0 / slope),
                false => ((value / (1.0 - value)).ln() - intercept) / slope,
            }
        };
        let answer = |x: f64, random: &mut Pcg64| {
            let form = match weibull {
                true => 1.0 - (-(intercept + slope * x.ln()).exp()).exp(),
                false => 1.0 / (1.0 + (-intercept - slope * x).exp()),
            };
            Level { level: x, chosen: binomial(trials, bottom + height * form, random), trials }
        };
        let found = replicates(studies, SEED, |random| {
            let levels = levels.map(|x| answer(x, random));
            let fit = fit(&levels, model).ok()?;
            let found = threshold(&fit, chance).ok()?;
            let drawn = parametric(&fit, chance, RESAMPLES, random.random());
            let intervals = vec![
                ("delta", Some(found.delta_95)),
                ("profile", Some(open(found.profile_95))),
                ("bootstrap, parametric", drawn.ok().map(|drawn| drawn.interval_95)),
            ];
            Some(Found { estimate: found.level, intervals })
        });
        report(what, truth, &found.iter().map(Option::as_ref).collect::<Vec<_>>());
    }
    // Probit observers whose thresholds differ: pooled they are probit with a flatter slope.
    let [slope, spread, observers] = [1.2, 0.6, 20.0];
    let found = replicates(studies, SEED, |random| {
        let of_one = |_| {
            let place = 2.5 + spread * normal(random);
            let level = |x: f64| {
                let value = normal_below(slope * (x - place));
                Level { level: x, chosen: binomial(4, value, random), trials: 4 }
            };
            levels.map(level).to_vec()
        };
        let observers: Vec<Vec<Level>> = (0..observers as usize).map(of_one).collect();
        let pooled = shutterlab_analysis::psychometric::bootstrap::pooled(&observers.concat());
        let fit = fit(&pooled, Model::yes_no(Shape::Probit)).ok()?;
        let found = threshold(&fit, 0.5).ok()?;
        let drawn = by_observer(&fit, &observers, 0.5, RESAMPLES, random.random());
        let intervals = vec![
            ("profile, as if all answers were of one", Some(open(found.profile_95))),
            ("bootstrap, by observer", drawn.ok().map(|drawn| drawn.interval_95)),
        ];
        Some(Found { estimate: found.level, intervals })
    });
    let what = "threshold at 50 %, probit, 20 observers who differ × 7 levels × 4";
    report(what, 2.5, &found.iter().map(Option::as_ref).collect::<Vec<_>>());
}

/// Φ(z) to 1.5·10⁻⁷ (Abramowitz and Stegun 1964, 7.1.26).
fn normal_below(z: f64) -> f64 {
    let x = z.abs() / std::f64::consts::SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let sum = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    let tail = 0.5 * sum.into_iter().fold(0.0, |acc, a| (acc + a) * t) * (-x * x).exp();
    if z < 0.0 { tail } else { 1.0 - tail }
}

const SIGMA: [f64; 2] = [0.4, 2.0];
const NAMES: [&str; 2] = ["σ₁", "σ₂"];

fn law([sigma_1, sigma_2]: [f64; 2], v: f64) -> f64 {
    1.0 / (sigma_1 * v + sigma_2)
}

fn setting() -> Setting {
    Setting {
        velocity_unit: VelocityUnit::PixelsPerShutter,
        frequency_unit: FrequencyUnit::PerPerimeterPixel,
        rule: None,
        r: None,
        observers: None,
        simulated: Some(true),
        unnamed: 0,
    }
}

/// Normal noise of standard deviation 0.01 about the law, at 1 to 30 pixels per shutter.
fn laws_of_points(studies: usize) {
    for (n, speeds) in [
        (6, &[1.0, 2.0, 5.0, 10.0, 20.0, 30.0][..]),
        (12, &[1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0]),
    ] {
        let found = replicates(studies, SEED, |random| {
            let point = |speed: &f64| Point {
                model: None,
                speed: *speed,
                frequency: law(SIGMA, *speed) + 0.01 * normal(random),
            };
            let points: Vec<Point> = speeds.iter().map(point).collect();
            let refit = from_points(&points, setting(), RESAMPLES, random.random());
            let fit = refit.fit.ok()?;
            Some([0, 1].map(|i| {
                let parameter = [&fit.sigma_1, &fit.sigma_2][i];
                let drawn = refit.bootstrap.as_ref().ok().map(|drawn| drawn[i].interval_95);
                let intervals = vec![
                    ("Wald, t", parameter.wald_95),
                    ("profile", parameter.profile_95.map(open)),
                    ("bootstrap of residuals, studentised", drawn),
                ];
                Found { estimate: parameter.estimate, intervals }
            }))
        });
        for (i, name) in NAMES.into_iter().enumerate() {
            let found: Vec<_> = found.iter().map(|f| f.as_ref().map(|f| &f[i])).collect();
            report(&format!("{name}, {n} points with normal noise"), SIGMA[i], &found);
        }
    }
}

/// Models whose σ₁ and σ₂ differ by a standard deviation of 15 %.
fn laws_over_models(studies: usize) {
    for models in [5, 12] {
        let found = replicates(studies, SEED, |random| {
            let mut points = Vec::new();
            for model in 0..models {
                let sigma = SIGMA.map(|sigma| sigma * (1.0 + 0.15 * normal(random)));
                for speed in [1.0, 2.0, 5.0, 10.0, 20.0, 30.0] {
                    let frequency = law(sigma, speed) + 0.005 * normal(random);
                    points.push(Point { model: Some(model.to_string()), speed, frequency });
                }
            }
            let found = over_models(&points).ok()?;
            Some([&found.sigma_1, &found.sigma_2].map(|mean| Found {
                estimate: mean.estimate,
                intervals: vec![("t, between models", Some(mean.interval_95))],
            }))
        });
        for (i, name) in NAMES.into_iter().enumerate() {
            let found: Vec<_> = found.iter().map(|f| f.as_ref().map(|f| &f[i])).collect();
            report(&format!("mean {name} of {models} models × 6 points"), SIGMA[i], &found);
        }
    }
}

/// The whole way from the answers of observers to the law.
fn laws_of_answers(studies: usize) {
    const SPEEDS: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 30.0];
    const LEVELS: [f64; 8] = [0.003, 0.008, 0.02, 0.04, 0.08, 0.16, 0.4, 0.9];
    // A model's triangles: the frequency of the original, which falls with the root of the faces.
    let originals = [0.5, 0.6, 0.7, 0.8];
    let mut frequencies = Frequencies::default();
    for (model, original) in originals.iter().enumerate() {
        for level in LEVELS {
            frequencies.insert(&model.to_string(), level, original * level.sqrt()).unwrap();
        }
    }
    for (what, spread) in [("24 observers", 0.0), ("24 observers who differ", 0.4)] {
        let found = replicates(studies, SEED, |random| {
            let mut trials = Vec::new();
            for observer in 0..24 {
                // In units of the logit; all images alike.
                let strict = spread * normal(random);
                for (model, original) in originals.iter().enumerate() {
                    for speed in SPEEDS {
                        for level in LEVELS {
                            let excess = (original * level.sqrt() / law(SIGMA, speed)).ln();
                            let logit = 4.0_f64.ln() + 3.0 * excess + strict;
                            let same = random.random::<f64>() < 1.0 / (1.0 + (-logit).exp());
                            trials.push(RatingTrial {
                                observer,
                                model: model.to_string(),
                                r: 4.0,
                                level_of_detail: level,
                                speed,
                                same: Some(same),
                            });
                        }
                    }
                }
            }
            let answers = Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap();
            let levels = coarsest_levels(&answers);
            let rule = |rule, resamples| {
                let drawn = (resamples, 1);
                let unit = FrequencyUnit::PerPerimeterPixel;
                from_ratings(&answers, &levels, rule, &frequencies, unit, drawn).unwrap()
            };
            let smoothed = rule(Rule::Smoothed, RESAMPLES);
            let point = rule(Rule::Point, RESAMPLES);
            let of = |refit: &shutterlab_analysis::ratings::law::Refit| {
                let fit = refit.fit.as_ref().ok()?;
                Some([0, 1].map(|i| {
                    let parameter = [&fit.sigma_1, &fit.sigma_2][i];
                    let drawn = refit.bootstrap.as_ref().ok().map(|drawn| drawn[i].interval_95);
                    let intervals = vec![
                        ("Wald, t", parameter.wald_95),
                        ("profile", parameter.profile_95.map(open)),
                        ("bootstrap, by observer", drawn),
                    ];
                    Found { estimate: parameter.estimate, intervals }
                }))
            };
            [of(&smoothed), of(&point)]
        });
        // Where observers differ, their answers together are at 0.8 elsewhere than those of the median one.
        let together = |excess: f64| {
            let weights =
                (-60..=60).map(|k| (f64::from(k) / 10.0, (-0.005 * f64::from(k * k)).exp()));
            let (sum, total) = weights.fold((0.0, 0.0), |(sum, total), (z, weight)| {
                let logit = 4.0_f64.ln() + 3.0 * excess + spread * z;
                (sum + weight / (1.0 + (-logit).exp()), total + weight)
            });
            sum / total
        };
        let mut shift = 0.0;
        for _ in 0..60 {
            shift += 0.5 * (0.8 - together(shift));
        }
        for (rule, place) in [("smoothed", 0), ("point rule", 1)] {
            for (i, name) in NAMES.into_iter().enumerate() {
                let found: Vec<_> =
                    found.iter().map(|f| f[place].as_ref().map(|f| &f[i])).collect();
                let what = format!(
                    "{name} from answers ({rule}), {what} × 4 models × 6 speeds × 8 levels"
                );
                report(&what, SIGMA[i] * (-shift).exp(), &found);
            }
        }
    }
}

fn one_image(observers: usize, chance: f64, random: &mut Pcg64) -> Ratings {
    let trials: Vec<RatingTrial> = (0..observers)
        .map(|observer| RatingTrial {
            observer,
            model: "one".into(),
            r: 4.0,
            level_of_detail: 0.1,
            speed: 1.0,
            same: Some(random.random::<f64>() < chance),
        })
        .collect();
    Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap()
}

fn rating_intervals(studies: usize) {
    for chance in [0.6, 0.8, 0.9] {
        let found = replicates(20 * studies, SEED, |random| {
            let share = ratings(&one_image(20, chance, random))[0].share.clone()?;
            let intervals = vec![
                ("Wilson", Some(share.wilson_95)),
                ("Clopper and Pearson", Some(share.clopper_pearson_95)),
            ];
            Some(Found { estimate: share.rating, intervals })
        });
        let found: Vec<_> = found.iter().map(Option::as_ref).collect();
        report(&format!("rating of 20 observers, truth {chance}"), chance, &found);
    }
}

fn share(what: &str, of: &[bool]) {
    let yes = of.iter().filter(|yes| **yes).count();
    println!("| {what} | {:.1} |", 100.0 * yes as f64 / of.len() as f64);
}

fn deviances(studies: usize) {
    let below = replicates(studies, SEED, |random| {
        let levels = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0].map(|x: f64| {
            let chance = 1.0 / (1.0 + (3.0 - 1.5 * x).exp());
            Level { level: x, chosen: binomial(20, chance, random), trials: 20 }
        });
        let fit = fit(&levels, Model::yes_no(Shape::Logistic)).ok()?;
        let tests = goodness_of_fit(&fit, RESAMPLES, random.random()).ok()?;
        Some([tests.p, tests.p_monte_carlo].map(|p| p.value() <= 0.05))
    });
    let of = |i: usize| below.iter().flatten().map(|both| both[i]).collect::<Vec<_>>();
    share("deviance by χ², p ≤ 0.05 where the function is true", &of(0));
    share("deviance by Monte Carlo, p ≤ 0.05 where the function is true", &of(1));
}

fn rating_tests(studies: usize) {
    let below = replicates(20 * studies, SEED, |random| {
        let share = ratings(&one_image(20, 0.8, random))[0].share.clone();
        share.is_some_and(|share| share.p_above.value() <= 0.05)
    });
    share("exact test above 0.8, p ≤ 0.05 where the chance is 0.8, 20 observers", &below);
}

/// Images whose chance of "same" does not depend on r, or is best at r = 4.
fn choices_of_r(studies: usize) -> Vec<(String, Vec<bool>)> {
    let rs = [0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
    let mut decisions = Vec::new();
    for (what, gain) in [("no r is better", 0.0), ("r = 4 is better by 1.5 in the logit", 1.5)] {
        let found = replicates(studies, SEED, |random| {
            let mut trials = Vec::new();
            for observer in 0..20 {
                let strict = 0.4 * normal(random);
                for image in 0..24 {
                    for r in rs {
                        let better = if r == 4.0 { gain } else { 0.0 };
                        let logit = f64::from(image) / 6.0 - 0.5 + better + strict;
                        let same = random.random::<f64>() < 1.0 / (1.0 + (-logit).exp());
                        trials.push(RatingTrial {
                            observer,
                            model: image.to_string(),
                            r,
                            level_of_detail: 0.1,
                            speed: 1.0,
                            same: Some(same),
                        });
                    }
                }
            }
            let answers = Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap();
            histogram(&answers, RESAMPLES, 1)
        });
        let bins = found.iter().map(|found| &found.bins[6]);
        let shares = bins.filter_map(|bin| {
            let intervals = vec![("bootstrap, by observer", bin.share_95)];
            Some(Found { estimate: bin.share?, intervals })
        });
        let shares: Vec<Found> = shares.collect();
        // What the share is on average is what it estimates.
        let truth = shares.iter().map(|found| found.estimate).sum::<f64>() / shares.len() as f64;
        let what_share = format!("share of 24 images over 0.8 with r = 4, 20 observers; {what}");
        report(&what_share, truth, &shares.iter().map(Some).collect::<Vec<_>>());
        let of = |is: &dyn Fn(&Result<f64, String>) -> bool| {
            found.iter().map(|f| is(&f.chosen)).collect()
        };
        decisions.push((
            format!("an r of 8 is chosen, 24 images each, 20 observers; {what}"),
            of(&|c| c.is_ok()),
        ));
        decisions.push((format!("r = 4 is chosen; {what}"), of(&|c| *c == Ok(4.0))));
    }
    decisions
}
