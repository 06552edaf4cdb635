//! Do the intervals and tests of matching and same/different answers keep what they promise? Coverage,
//! bias and false positives over simulated studies whose truth is known, as Markdown tables.
//!
//! `cargo run --release -p shutterlab-analysis --example calibrate_categories [STUDIES]`

#![allow(clippy::print_stdout, reason = "the tables are what it is for")]

use rand::RngExt;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use shutterlab_analysis::categories::discrimination::{Counts, Model, Strategy};
use shutterlab_analysis::categories::forced_choice::ForcedChoice;
use shutterlab_analysis::categories::observers::observers;
use shutterlab_analysis::categories::resampled;
use shutterlab_analysis::maths::random::stream;

const DIFFERENCING: Strategy = Strategy::Differencing;
const INDEPENDENT: Strategy = Strategy::IndependentObservations;

fn main() {
    let studies = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(2000);
    let error = 100.0 * (0.95 * 0.05 / studies as f64).sqrt();
    println!(
        "{studies} simulated studies per row; standard error of a coverage of 95 %: {error:.2} %.\n"
    );
    accuracies(studies);
    likelihood_intervals(studies);
    forced_choices(studies);
    println!(
        "Bias of d′: at d′ = 0 estimates of all tasks but yes/no and m alternatives cannot fall below it; \
         at large d′ with few errors d′ is a steep function of the shares, and the log-linear correction \
         does not undo that. Near d′ = 0 the delta method does not hold, as the table shows; intervals by \
         likelihood do. Exact intervals hold more than 95 % because answers are counted.\n"
    );
    observer_intervals(studies);
}

/// Results of each simulated study.
fn simulate<T: Send>(studies: u64, seed: u64, study: impl Fn(&mut Pcg64) -> T + Sync) -> Vec<T> {
    (0..studies).into_par_iter().map(|index| study(&mut stream(seed, index))).collect()
}

fn answers(trials: u64, p: f64, random: &mut Pcg64) -> u64 {
    (0..trials).filter(|_| random.random::<f64>() < p).count() as u64
}

fn normal(sd: f64, random: &mut Pcg64) -> f64 {
    Normal::new(0.0, sd).map_or(0.0, |law| law.sample(random))
}

/// Percent of the intervals that hold `truth`, and how many there are.
fn coverage(intervals: &[Option<[f64; 2]>], truth: f64) -> (f64, usize) {
    let known: Vec<&[f64; 2]> = intervals.iter().flatten().collect();
    let hold = known.iter().filter(|[low, high]| (*low..=*high).contains(&truth)).count();
    (100.0 * hold as f64 / known.len() as f64, known.len())
}

/// An end that the answers do not set is beyond every truth.
fn open([low, high]: [Option<f64>; 2]) -> [f64; 2] {
    [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]
}

/// Accuracy of matching 10 pairs by observers who are alike or differ in d′.
fn accuracies(studies: u64) {
    println!("### Accuracy: coverage of 95 % intervals, in percent\n");
    println!(
        "| observers | trials each | d′ | SD of ln d′ | true accuracy | Clopper–Pearson | Wilson | \
         cluster-robust | bootstrap | observers differ (p ≤ .05) |"
    );
    println!("|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let task = ForcedChoice::Abx(DIFFERENCING);
    for (people, trials, d, sd) in [
        (8, 10, 2.0, 0.0),
        (16, 10, 2.0, 0.0),
        (16, 10, 2.0, 0.5),
        (16, 40, 1.0, 0.5),
        (16, 40, 2.0, 0.5),
        (32, 40, 2.0, 0.5),
    ] {
        let of_one = |random: &mut Pcg64| task.share_right(d * normal(sd, random).exp());
        let mut many = stream(1, 0);
        let truth = (0..200_000).map(|_| of_one(&mut many)).sum::<f64>() / 200_000.0;
        let found = simulate(studies, 2, |random| {
            let by: Vec<(u64, u64)> =
                (0..people).map(|_| (answers(trials, of_one(random), random), trials)).collect();
            observers(&by, 0.5).ok()
        });
        let found: Vec<_> = found.into_iter().flatten().collect();
        let of = |interval: &dyn Fn(usize) -> Option<[f64; 2]>| {
            coverage(&(0..found.len()).map(interval).collect::<Vec<_>>(), truth).0
        };
        let tests: Vec<f64> = found
            .iter()
            .filter_map(|study| Some(study.heterogeneity.as_ref().ok()?.p_permutation.value()))
            .collect();
        let differ = tests.iter().filter(|p| **p <= 0.05).count() as f64 / tests.len() as f64;
        println!(
            "| {people} | {trials} | {d} | {sd} | {truth:.4} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |",
            of(&|i| Some(found[i].pooled.clopper_pearson_95)),
            of(&|i| Some(found[i].pooled.wilson_95)),
            of(&|i| found[i].robust_95.clone().ok()),
            of(&|i| found[i].bootstrap_95.clone().ok()),
            100.0 * differ
        );
    }
    println!();
}

/// d′ from hits and false alarms of independent answers.
fn likelihood_intervals(studies: u64) {
    println!("### d′ from hits and false alarms, independent answers\n");
    println!(
        "| task | trials of each kind | d′ | criterion | coverage, likelihood | coverage, d′ ± 1.96 SE | \
         mean of d′ | SD of d′ | bias/SD |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    for model in [
        Model::YesNo,
        Model::SameDifferent(DIFFERENCING),
        Model::SameDifferent(INDEPENDENT),
        Model::Abx(DIFFERENCING),
        Model::Abx(INDEPENDENT),
    ] {
        let criterion = if model == Model::SameDifferent(DIFFERENCING) { 1.8 } else { 0.3 };
        for (trials, d) in [(30, 0.0), (30, 1.5), (100, 0.0), (100, 1.5), (100, 3.0), (400, 2.0)] {
            let [[hit, _], [false_alarm, _]] = model.probabilities(d, criterion);
            let found: Vec<_> = simulate(studies, 3, |random| {
                let counts = Counts {
                    hits: answers(trials, hit, random),
                    signals: trials,
                    false_alarms: answers(trials, false_alarm, random),
                    noises: trials,
                };
                model.d_prime(counts).ok()
            })
            .into_iter()
            .flatten()
            .collect();
            let likelihood: Vec<_> = found.iter().map(|d| Some(open(d.interval_95))).collect();
            let delta: Vec<_> = found
                .iter()
                .map(|d| {
                    let se = d.se.as_ref().ok()?;
                    Some([d.d_prime - 1.96 * se, d.d_prime + 1.96 * se])
                })
                .collect();
            let (with_se, known) = coverage(&delta, d);
            let few = if known < found.len() { format!(" (of {known})") } else { String::new() };
            let (mean, sd) = mean_and_sd(&found.iter().map(|d| d.d_prime).collect::<Vec<_>>());
            println!(
                "| {model:?} | {trials} | {d} | {criterion} | {:.1} | {with_se:.1}{few} | {mean:.3} | \
                 {sd:.3} | {:.2} |",
                coverage(&likelihood, d).0,
                (mean - d) / sd
            );
        }
    }
    println!();
}

/// d′ from shares of right answers.
fn forced_choices(studies: u64) {
    println!("### d′ from a share of right answers\n");
    println!("| task | trials | d′ | coverage (exact) | mean of d′ | SD of d′ | bias/SD |");
    println!("|---|--:|--:|--:|--:|--:|--:|");
    for task in [
        ForcedChoice::Alternatives(2),
        ForcedChoice::Alternatives(4),
        ForcedChoice::Abx(DIFFERENCING),
    ] {
        for (trials, d) in [(16, 1.0), (64, 0.0), (64, 2.0), (256, 2.0)] {
            let share = task.share_right(d);
            let found: Vec<_> = simulate(studies, 4, |random| {
                task.d_prime(answers(trials, share, random), trials).ok()
            })
            .into_iter()
            .flatten()
            .collect();
            let intervals: Vec<_> = found.iter().map(|d| Some(open(d.interval_95))).collect();
            let (mean, sd) = mean_and_sd(&found.iter().map(|d| d.d_prime).collect::<Vec<_>>());
            println!(
                "| {task:?} | {trials} | {d} | {:.1} | {mean:.3} | {sd:.3} | {:.2} |",
                coverage(&intervals, d).0,
                (mean - d) / sd
            );
        }
    }
    println!();
}

/// Same/different by observers who differ in d′ and criterion: the truth is the d′ of the mean shares.
fn observer_intervals(studies: u64) {
    println!("### d′ of same/different (differencing) by observers who differ\n");
    println!(
        "| observers | trials of each kind | d′ | SD of d′ and criterion | d′ of the mean shares | \
         coverage, bootstrap by observer | coverage, likelihood |"
    );
    println!("|--:|--:|--:|--:|--:|--:|--:|");
    let model = Model::SameDifferent(DIFFERENCING);
    for (people, trials, d, sd) in [
        (10, 12, 2.0, 0.0),
        (20, 12, 2.0, 0.0),
        (10, 12, 2.0, 0.6),
        (20, 12, 2.0, 0.6),
        (40, 12, 2.0, 0.6),
    ] {
        let of_one = |random: &mut Pcg64| {
            let d = (d + normal(sd, random)).max(0.0);
            let criterion = (1.8 + normal(sd, random)).max(0.1);
            model.probabilities(d, criterion).map(|[yes, _]| yes)
        };
        let mut many = stream(5, 0);
        let mean = (0..200_000).map(|_| of_one(&mut many)).fold([0.0; 2], |sum, rates| {
            [sum[0] + rates[0] / 200_000.0, sum[1] + rates[1] / 200_000.0]
        });
        let of_mean = mean.map(|rate| (1e9 * rate).round() as u64);
        let million = Counts {
            hits: of_mean[0],
            signals: 1_000_000_000,
            false_alarms: of_mean[1],
            noises: 1_000_000_000,
        };
        let truth = model.d_prime(million).map_or(f64::NAN, |d| d.d_prime);
        let found: Vec<_> = simulate(studies, 6, |random| {
            let by: Vec<Counts> = (0..people)
                .map(|_| {
                    let [hit, false_alarm] = of_one(random);
                    Counts {
                        hits: answers(trials, hit, random),
                        signals: trials,
                        false_alarms: answers(trials, false_alarm, random),
                        noises: trials,
                    }
                })
                .collect();
            resampled::d_prime(model, &by).ok()
        })
        .into_iter()
        .flatten()
        .collect();
        let bootstrap: Vec<_> = found.iter().map(|d| d.bootstrap_95.clone().ok()).collect();
        let likelihood: Vec<_> = found.iter().map(|d| Some(open(d.estimate.interval_95))).collect();
        println!(
            "| {people} | {trials} | {d} | {sd} | {truth:.3} | {:.1} | {:.1} |",
            coverage(&bootstrap, truth).0,
            coverage(&likelihood, truth).0
        );
    }
    println!();
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (mean, (squares / (n - 1.0)).sqrt())
}
