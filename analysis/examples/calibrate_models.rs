//! How often the tests of simplified models find the truth: simulated studies of the designs of `zhang-r` and `zhang-lod`
//! with 20 viewers and 16 models, as Markdown tables.
//!
//! `cargo run --release -p shutterlab-analysis --example calibrate_models [STUDIES]`, 200 studies if nothing else is said.
//!
//! A viewer calls an image the same as the original with the probability
//!
//! ```text
//! P = λ/2 + (1 − λ) L(ln 4 + 3·ln(ρ/ρ(v)) − κ·|steps from the best r| + strictness)      L(x) = 1/(1 + e^−x)
//! ```
//!
//! with the spatial frequency ρ of the image, the law ρ(v) = 1/(σ₁v + σ₂), and steps in the order 0, ⅛, ¼, … 8 of r.

#![expect(clippy::print_stdout, reason = "a program that prints a table")]
#![expect(clippy::unwrap_used, reason = "what a simulation cannot do should stop it")]

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use shutterlab_analysis::maths::resampling::replicates;
use shutterlab_analysis::ratings::answers::{RatingTrial, Ratings};
use shutterlab_analysis::ratings::histogram::histogram;
use shutterlab_analysis::ratings::law::{Refit, from_ratings};
use shutterlab_analysis::ratings::level_of_detail::{Rule, coarsest_levels};
use shutterlab_analysis::ratings::points::Frequencies;
use shutterlab_data_schema::fitted::{FrequencyUnit, VelocityUnit};

const SEED: u64 = 2_014;
const RESAMPLES: usize = 499;
const VIEWERS: usize = 20;
const MODELS: usize = 16;
/// Lapses: either answer by a fair coin.
const LAPSES: f64 = 0.02;
/// Standard deviation between viewers, in the logit.
const SPREAD: f64 = 0.4;
/// σ₁ and σ₂, in pixels of perimeter, of speeds in pixels per shutter.
const SIGMA: [f64; 2] = [0.05, 4.0];
const RS: [f64; 8] = [0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];

/// Which images a design has.
struct Design {
    speeds: &'static [f64],
    levels: &'static [f64],
    rs: &'static [f64],
    /// Mean perimeter of the triangles of each original, in pixels.
    originals: [f64; MODELS],
}

fn main() {
    let studies = std::env::args().nth(1).map_or(200, |text| text.parse().unwrap());
    println!(
        "{studies} studies each of {VIEWERS} viewers and {MODELS} models, {RESAMPLES} resamples, seed {SEED}.\n"
    );
    choices_of_r(studies);
    laws(studies);
}

/// Mean perimeters from `finest` to twice as much.
fn originals(finest: f64) -> [f64; MODELS] {
    std::array::from_fn(|model| finest * 2.0f64.powf(model as f64 / (MODELS - 1) as f64))
}

impl Design {
    /// The answers of a study in which the place `best` of [`RS`] is better by `kappa` for each step.
    fn answers(&self, best: usize, kappa: f64, missing: f64, random: &mut Pcg64) -> Ratings {
        let mut trials = Vec::new();
        for observer in 0..VIEWERS {
            let strict: f64 = StandardNormal.sample(random);
            for (model, original) in self.originals.iter().enumerate() {
                for &speed in self.speeds {
                    for &level_of_detail in self.levels {
                        for &r in self.rs {
                            let steps = RS.iter().position(|other| *other == r).unwrap();
                            let excess = excess(*original, level_of_detail, speed);
                            let logit = 4.0_f64.ln() + 3.0 * excess + SPREAD * strict
                                - kappa * steps.abs_diff(best) as f64;
                            let p = 0.5 * LAPSES + (1.0 - LAPSES) / (1.0 + (-logit).exp());
                            let same = random.random::<f64>() < p;
                            if random.random::<f64>() >= missing {
                                trials.push(RatingTrial {
                                    observer,
                                    model: model.to_string(),
                                    r,
                                    level_of_detail,
                                    speed,
                                    same: Some(same),
                                });
                            }
                        }
                    }
                }
            }
        }
        Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap()
    }

    /// The frequencies of all models.
    fn frequencies(&self) -> Frequencies {
        let mut frequencies = Frequencies::default();
        for (model, original) in self.originals.iter().enumerate() {
            for &level in self.levels {
                frequencies.insert(&model.to_string(), level, level.sqrt() / original).unwrap();
            }
        }
        frequencies
    }
}

/// How much finer an image is than the law asks for, as a logarithm.
fn excess(original: f64, level: f64, speed: f64) -> f64 {
    (level.sqrt() / original * (SIGMA[0] * speed + SIGMA[1])).ln()
}

fn percent(of: impl Iterator<Item = bool>) -> String {
    let all: Vec<bool> = of.collect();
    if all.is_empty() {
        return "–".into();
    }
    format!("{:.1}", 100.0 * all.iter().filter(|is| **is).count() as f64 / all.len() as f64)
}

/// The design of `zhang-r`: how often r is found, whichever it is. The r that is ahead has the most images over 0.8; it is
/// chosen where it is ahead in 95 % of the resamples, too.
fn choices_of_r(studies: usize) {
    let design = Design {
        speeds: &[30.0, 90.0],
        levels: &[0.4, 0.2, 0.1, 0.04],
        rs: &RS,
        originals: originals(1.3),
    };
    println!(
        "| κ, logit per step of r | the r ahead is the best, % | or a step beside it, % | where the best is 0, % | \
         r is chosen, % | of these the best, % | or a step beside it, % |"
    );
    println!("|---|---|---|---|---|---|---|");
    for kappa in [0.1, 0.2, 0.4, 0.8] {
        let found = replicates(studies, SEED, |random| {
            let best = random.random_range(0..RS.len());
            let found =
                histogram(&design.answers(best, kappa, 0.0, random), RESAMPLES, random.random());
            let place = |r: f64| RS.iter().position(|other| *other == r).unwrap();
            // Where two are ahead, none is.
            let most = found.bins.iter().map(|bin| bin.over).max();
            let mut winners = found.bins.iter().filter(|bin| Some(bin.over) == most);
            let ahead = winners.next().filter(|_| winners.next().is_none());
            (best, ahead.map(|bin| place(bin.r)), found.chosen.ok().map(place))
        });
        let ahead =
            |steps: usize, only: Option<usize>| {
                let of = found.iter().filter(|(best, ..)| only.is_none_or(|only| only == *best));
                percent(of.map(|(best, ahead, _)| {
                    ahead.is_some_and(|ahead| ahead.abs_diff(*best) <= steps)
                }))
            };
        let chosen = percent(found.iter().map(|(.., chosen)| chosen.is_some()));
        let right = |steps: usize| {
            let of =
                found.iter().filter_map(|(best, _, chosen)| Some(chosen.as_ref()?.abs_diff(*best)));
            percent(of.map(|off| off <= steps))
        };
        println!(
            "| {kappa} | {} | {} | {} | {chosen} | {} | {} |",
            ahead(0, None),
            ahead(1, None),
            ahead(0, Some(0)),
            right(0),
            right(1)
        );
    }
    println!();
}

/// What the viewers' answers together are at 0.8 at, as a factor of the law: they differ, and they lapse.
fn shift() -> f64 {
    let together = |excess: f64| {
        let weights = (-60..=60).map(|k| (f64::from(k) / 10.0, (-0.005 * f64::from(k * k)).exp()));
        let (sum, total) = weights.fold((0.0, 0.0), |(sum, total), (z, weight)| {
            let logit = 4.0_f64.ln() + 3.0 * excess + SPREAD * z;
            let p = 0.5 * LAPSES + (1.0 - LAPSES) / (1.0 + (-logit).exp());
            (sum + weight * p, total + weight)
        });
        sum / total
    };
    let mut shift = 0.0;
    for _ in 0..80 {
        shift += 0.5 * (0.8 - together(shift));
    }
    (-shift).exp()
}

/// The design of `zhang-lod`: how often the intervals of σ₁ and σ₂ hold the truth.
fn laws(studies: usize) {
    for (what, finest, missing) in [
        ("Every viewer answers to every image", 1.8, 0.0),
        ("A tenth of the answers is missing", 1.8, 0.1),
        ("Models so coarse that some never reach 0.8", 3.2, 0.0),
    ] {
        let design = Design {
            speeds: &[10.0, 30.0, 90.0, 270.0],
            levels: &[0.64, 0.32, 0.16, 0.08, 0.04, 0.02, 0.01],
            rs: &[4.0],
            originals: originals(finest),
        };
        let frequencies = design.frequencies();
        let found = replicates(studies, SEED, |random| {
            let answers = design.answers(6, 0.0, missing, random);
            let levels = coarsest_levels(&answers);
            let unit = FrequencyUnit::PerPerimeterPixel;
            let drawn = (RESAMPLES, random.random());
            from_ratings(&answers, &levels, Rule::Smoothed, &frequencies, unit, drawn).unwrap()
        });
        report(what, &found);
    }
}

/// An estimate of σ₁ or σ₂, and an interval, where there are.
type Estimator = fn(&Refit, usize) -> Option<(f64, Option<[f64; 2]>)>;

fn report(what: &str, found: &[Refit]) {
    let truth = SIGMA.map(|sigma| sigma * shift());
    let estimators: [(&str, Estimator); 4] = [
        ("all answers at once, jackknife", |refit, i| {
            let sigma = refit.joint.as_ref().ok()?.sigma[i];
            Some((sigma.estimate, Some(sigma.interval_95)))
        }),
        ("points, Wald t", |refit, i| {
            let fit = refit.fit.as_ref().ok()?;
            let sigma = [&fit.sigma_1, &fit.sigma_2][i];
            Some((sigma.estimate, sigma.wald_95))
        }),
        ("points, profile", |refit, i| {
            let fit = refit.fit.as_ref().ok()?;
            let sigma = [&fit.sigma_1, &fit.sigma_2][i];
            let open = |[low, high]: [Option<f64>; 2]| {
                [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]
            };
            Some((sigma.estimate, sigma.profile_95.map(open)))
        }),
        ("points, bootstrap by observer", |refit, i| {
            let fit = refit.fit.as_ref().ok()?;
            let drawn = refit.bootstrap.as_ref().ok();
            Some((fit.sigma()[i], drawn.map(|drawn| drawn[i].interval_95)))
        }),
    ];
    let points = found.iter().filter_map(|refit| Some(refit.fit.as_ref().ok()?.points.len()));
    let points: Vec<usize> = points.collect();
    println!(
        "{what}: {:.1} points of 64.\n",
        points.iter().sum::<usize>() as f64 / points.len() as f64
    );
    println!(
        "| σ₁ and σ₂ from | studies with an interval, % | it holds σ₁, % | σ₂, % | bias/SD of σ₁ | σ₂ | SD/σ₁ | SD/σ₂ |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, estimator) in estimators {
        let with = |refit: &Refit| estimator(refit, 0).is_some_and(|(_, known)| known.is_some());
        let with = percent(found.iter().map(with));
        let of = [0, 1].map(|i| {
            let known: Vec<_> = found.iter().filter_map(|refit| estimator(refit, i)).collect();
            let n = known.len() as f64;
            let mean = known.iter().map(|(estimate, _)| estimate).sum::<f64>() / n;
            let squares: f64 = known.iter().map(|(estimate, _)| (estimate - mean).powi(2)).sum();
            let sd = (squares / (n - 1.0)).sqrt();
            let intervals = known.iter().filter_map(|(_, interval)| *interval);
            let held = percent(intervals.map(|[low, high]| low <= truth[i] && truth[i] <= high));
            (held, (mean - truth[i]) / sd, sd / truth[i])
        });
        let [one, two] = of;
        println!(
            "| {name} | {with} | {} | {} | {:+.2} | {:+.2} | {:.3} | {:.3} |",
            one.0, two.0, one.1, two.1, one.2, two.2
        );
    }
    println!();
}
