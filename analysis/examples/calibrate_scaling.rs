//! How far the intervals and tests of scale values can be trusted: simulated studies with known values.
//!
//! `cargo run --release -p shutterlab-analysis --example calibrate_scaling -- [STUDIES] [SEED]` prints two
//! Markdown tables, for 1000 studies and seed 1 unless told otherwise.
#![expect(clippy::print_stdout, reason = "its table goes to the standard output")]

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use shutterlab_analysis::Outcome;
use shutterlab_analysis::maths::distributions::normal_tail;
use shutterlab_analysis::maths::random::stream;
use shutterlab_analysis::scaling::bootstrap::bootstrap;
use shutterlab_analysis::scaling::comparisons::{Comparisons, Pair};
use shutterlab_analysis::scaling::differences::differences;
use shutterlab_analysis::scaling::fit::{Estimation, Scale, fit};
use shutterlab_analysis::scaling::goodness_of_fit::goodness_of_fit;
use shutterlab_analysis::scaling::intervals::profile_95;
use shutterlab_analysis::scaling::model::Model;
use shutterlab_analysis::scaling::simulated_fit::simulated_fit;

const OBSERVERS: u64 = 21;
const REPLICATES: usize = 1000;
const SIMULATED: usize = 399;
/// Observers whose answers stand for those of all people where people differ.
const ALL_PEOPLE: u64 = 40_000;

/// Values in logits; for Thurstone's model they are converted by the just-objectionable difference.
const WORLDS: [World; 6] = [
    World { name: "5, near", values: &[0.8, 0.4, 0.1, -0.4, -0.9], spread: 0.0 },
    World { name: "5, one far below", values: &[0.9, 0.6, 0.4, 0.1, -2.0], spread: 0.0 },
    World { name: "5, often separated", values: &[3.6, 0.2, -0.4, -1.4, -2.0], spread: 0.0 },
    World { name: "5, people differ", values: &[0.8, 0.4, 0.1, -0.4, -0.9], spread: 0.7 },
    World {
        name: "9, near",
        values: &[1.0, 0.8, 0.5, 0.2, 0.0, -0.2, -0.5, -0.8, -1.0],
        spread: 0.0,
    },
    World {
        name: "9, wide",
        values: &[2.0, 1.5, 1.0, 0.5, 0.0, -0.5, -1.0, -1.5, -2.0],
        spread: 0.0,
    },
];

/// What is known of a simulated study.
struct World {
    name: &'static str,
    values: &'static [f64],
    /// Standard deviation of each person's own values about these.
    spread: f64,
}

/// What one study gives.
struct Study {
    separated: bool,
    /// Per item, whether the Wald, profile and bootstrap interval of its value hold the truth.
    held: Vec<[Option<bool>; 3]>,
    /// The same of the differences between neighbours: Wald and bootstrap.
    differences_held: Vec<[Option<bool>; 2]>,
    likeliest: Option<Vec<f64>>,
    bias_reduced: Vec<f64>,
}

fn main() -> Outcome<()> {
    let mut arguments = std::env::args().skip(1).map(|number| number.parse::<u64>());
    let mut next = |default| match arguments.next() {
        Some(number) => number.map_err(|_| "STUDIES and SEED are whole numbers".to_string()),
        None => Ok(default),
    };
    let (studies, seed) = (next(1000)?, next(1)?);
    println!(
        "{studies} studies of n = {OBSERVERS} observers who judge each pair once, {REPLICATES} bootstrap \
         replicates, seed {seed}. Monte Carlo error of a coverage of 95 %: {:.1} % if the values of a \
         study were one.\n",
        100.0 * (0.95_f64 * 0.05 / studies as f64).sqrt()
    );
    println!(
        "| t, values | model | separated % | Wald % | profile % | bootstrap % | difference: Wald % | \
         bootstrap % | bias/SD, likeliest | bias/SD, bias-reduced |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for world in &WORLDS {
        for model in [Model::BradleyTerry, Model::ThurstoneV] {
            coverage(world, model, studies, seed)?;
        }
    }
    println!(
        "\n| t, all alike | model | equality % | fit, deviance % | fit, Pearson % | fit, simulated % | any difference, Holm % |"
    );
    println!("|---|---|---|---|---|---|---|");
    for t in [5, 9] {
        for model in [Model::BradleyTerry, Model::ThurstoneV] {
            false_positives(t, model, studies, seed)?;
        }
    }
    Ok(())
}

fn coverage(world: &World, model: Model, studies: u64, seed: u64) -> Outcome<()> {
    let unit =
        model.just_objectionable_difference() / Model::BradleyTerry.just_objectionable_difference();
    let values: Vec<f64> = world.values.iter().map(|value| value * unit).collect();
    let spread = world.spread * unit;
    let truth = match spread > 0.0 {
        false => values.clone(),
        true => {
            // What the answers of all people together follow.
            let all = Comparisons::pooled(&simulate(
                &values,
                spread,
                model,
                ALL_PEOPLE,
                &mut stream(seed, 0),
            ));
            fit(&all, model, Estimation::MaximumLikelihood)?.values
        }
    };
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let truth: Vec<f64> = truth.iter().map(|value| value - mean).collect();
    let results: Vec<Study> = (1..=studies)
        .into_par_iter()
        .map(|index| {
            let observers = simulate(&values, spread, model, OBSERVERS, &mut stream(seed, index));
            study(&observers, &truth, model, index)
        })
        .collect::<Outcome<_>>()?;
    let percent = |held: &mut dyn Iterator<Item = bool>| {
        let held: Vec<bool> = held.collect();
        100.0 * held.iter().filter(|held| **held).count() as f64 / held.len() as f64
    };
    let of_values = |kind: usize| {
        percent(&mut results.iter().flat_map(|study| &study.held).filter_map(|held| held[kind]))
    };
    let of_differences = |kind: usize| {
        let held = results.iter().flat_map(|study| &study.differences_held);
        percent(&mut held.filter_map(|held| held[kind]))
    };
    let likeliest: Vec<&Vec<f64>> =
        results.iter().filter_map(|study| study.likeliest.as_ref()).collect();
    let reduced: Vec<&Vec<f64>> = results.iter().map(|study| &study.bias_reduced).collect();
    println!(
        "| {} | {} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.2} | {:.2} |",
        world.name,
        model.name(),
        percent(&mut results.iter().map(|study| study.separated)),
        of_values(0),
        of_values(1),
        of_values(2),
        of_differences(0),
        of_differences(1),
        largest_bias(&likeliest, &truth),
        largest_bias(&reduced, &truth),
    );
    Ok(())
}

/// The largest bias of any item in standard deviations of its estimates.
fn largest_bias(estimates: &[&Vec<f64>], truth: &[f64]) -> f64 {
    let of_item = |i: usize| {
        let n = estimates.len() as f64;
        let mean = estimates.iter().map(|values| values[i]).sum::<f64>() / n;
        let squares: f64 =
            estimates.iter().map(|values| (values[i] - mean) * (values[i] - mean)).sum();
        (mean - truth[i]).abs() / libm::sqrt(squares / (n - 1.0))
    };
    (0..truth.len()).map(of_item).fold(0.0, f64::max)
}

/// What the program says of a study: maximum likelihood or, where the study is separated, bias reduction.
fn study(observers: &[Comparisons], truth: &[f64], model: Model, seed: u64) -> Outcome<Study> {
    let pooled = Comparisons::pooled(observers);
    let likeliest = fit(&pooled, model, Estimation::MaximumLikelihood).ok();
    let bias_reduced = fit(&pooled, model, Estimation::BiasReduced)?;
    let scale: &Scale = likeliest.as_ref().unwrap_or(&bias_reduced);
    let drawn = bootstrap(observers, model, REPLICATES, seed).ok();
    let t = truth.len();
    let holds = |[low, high]: [f64; 2], value: f64| low <= value && value <= high;
    let of_item = |i: usize| {
        let mut contrast = vec![-1.0 / t as f64; t];
        contrast[i] += 1.0;
        let profile = profile_95(&pooled, scale, &contrast).ok();
        let drawn = drawn.as_ref().map(|drawn| drawn.interval_95(|values| values[i]));
        [Some(scale.centred(i).wald_95()), profile, drawn]
            .map(|interval| interval.map(|interval| holds(interval, truth[i])))
    };
    let of_neighbours = |i: usize| {
        let drawn = drawn.as_ref();
        let drawn = drawn.map(|drawn| drawn.interval_95(|values| values[i] - values[i + 1]));
        [Some(scale.difference(i, i + 1).wald_95()), drawn]
            .map(|interval| interval.map(|interval| holds(interval, truth[i] - truth[i + 1])))
    };
    Ok(Study {
        separated: likeliest.is_none(),
        held: (0..t).map(of_item).collect(),
        differences_held: (0..t - 1).map(of_neighbours).collect(),
        likeliest: likeliest.map(|scale| scale.values),
        bias_reduced: bias_reduced.values,
    })
}

fn false_positives(t: usize, model: Model, studies: u64, seed: u64) -> Outcome<()> {
    let rejections: Vec<[bool; 5]> = (1..=studies)
        .into_par_iter()
        .map(|index| {
            let observers =
                simulate(&vec![0.0; t], 0.0, model, OBSERVERS, &mut stream(seed, index));
            let pooled = Comparisons::pooled(&observers);
            let scale = fit(&pooled, model, Estimation::MaximumLikelihood)?;
            let goodness = goodness_of_fit(&pooled, &scale);
            let simulated = simulated_fit(&pooled, model, SIMULATED, index)?.p;
            let tests = [goodness.equal_worth.p, goodness.p, goodness.p_pearson, Some(simulated)];
            let [equality, deviance, pearson, simulated] =
                tests.map(|p| p.is_some_and(|p| p.value() <= 0.05));
            let any = differences(&scale).iter().any(|d| d.p_holm.value() <= 0.05);
            Ok([equality, deviance, pearson, simulated, any])
        })
        .collect::<Outcome<_>>()?;
    let share = |test: usize| {
        100.0 * rejections.iter().filter(|study| study[test]).count() as f64 / studies as f64
    };
    println!(
        "| {t} | {} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |",
        model.name(),
        share(0),
        share(1),
        share(2),
        share(3),
        share(4)
    );
    Ok(())
}

/// The answers of `observers`, each of whom has values of their own about `values`.
fn simulate(
    values: &[f64],
    spread: f64,
    model: Model,
    observers: u64,
    random: &mut Pcg64,
) -> Vec<Comparisons> {
    let t = values.len();
    let items: Vec<String> = (1..=t).map(|i| format!("item {i}")).collect();
    let mut of_one = |_| {
        let own: Vec<f64> = values
            .iter()
            .map(|value| {
                let deviation: f64 = StandardNormal.sample(random);
                value + spread * deviation
            })
            .collect();
        let places = (0..t).flat_map(|i| (i + 1..t).map(move |j| (i, j)));
        let pairs = places.map(|(i, j)| {
            let chosen = match model {
                Model::BradleyTerry => 1.0 / (1.0 + libm::exp(own[j] - own[i])),
                Model::ThurstoneV => normal_tail(own[j] - own[i]),
            };
            let wins = if random.random_bool(chosen) { [1.0, 0.0] } else { [0.0, 1.0] };
            Pair { i, j, wins, ties: 0.0 }
        });
        Comparisons::of_pairs(&items, pairs.collect())
    };
    (0..observers).filter_map(|observer| of_one(observer).ok()).collect()
}
