//! Do the tests of paired comparisons keep their level? False positives over simulated studies in which
//! nothing is to be found, as Markdown tables.
//!
//! `cargo run --release -p shutterlab-analysis --example calibrate_paired [STUDIES]`

#![allow(clippy::print_stdout, reason = "the tables are what it is for")]

use rand::RngExt;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use shutterlab_analysis::input::preferences::{Choice, Observer};
use shutterlab_analysis::maths::binomial::upper_tail;
use shutterlab_analysis::maths::random::stream;
use shutterlab_analysis::paired::clustered::by_item;
use shutterlab_analysis::paired::equivalence::equivalence;
use shutterlab_analysis::paired::friedman::friedman;
use shutterlab_analysis::paired::level_check::level_check;
use shutterlab_analysis::paired::observer_groups::observer_groups;
use shutterlab_analysis::paired::order_effects::order_effects;
use shutterlab_data_schema::response::Side;
use std::collections::BTreeMap;

const ALPHA: f64 = 0.05;

fn main() {
    let studies = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(10_000);
    let error = (ALPHA * (1.0 - ALPHA) / studies as f64).sqrt();
    println!(
        "{studies} simulated studies per row without anything to be found; standard error of a share of \
         {ALPHA}: {error:.4}. SD is that of the observers' own preferences, in logits: with 0 every answer \
         is a fair coin, above it the answers of one observer are alike.\n"
    );
    score_differences(studies);
    clusters(studies);
    groups_and_orders(studies);
    equivalences();
}

/// One simulated study: every observer judges every pair of `t` stimuli once.
fn study(observers: usize, t: usize, sd: f64, random: &mut Pcg64) -> Vec<Choice> {
    let mut choices = Vec::new();
    for observer in 0..observers {
        let law = Normal::new(0.0, sd).ok();
        let own: Vec<f64> =
            (0..t).map(|_| law.as_ref().map_or(0.0, |law| law.sample(random))).collect();
        for a in 0..t {
            for b in a + 1..t {
                let p = 1.0 / (1.0 + (own[b] - own[a]).exp());
                let side = |first: bool| if first { Side::A } else { Side::B };
                let chosen = Some(side(random.random::<f64>() < p));
                choices.push(Choice { observer, a, b, chosen, first: Some(side(random.random())) });
            }
        }
    }
    choices
}

fn names(t: usize) -> Vec<String> {
    (0..t).map(|i| format!("S{i}")).collect()
}

/// Shares of p-values that reach α, of those that are known.
fn reached<const N: usize>(p: &[[Option<f64>; N]]) -> String {
    let cells = (0..N).map(|test| {
        let known: Vec<f64> = p.iter().filter_map(|p| p[test]).collect();
        match known.len() {
            0 => "–".to_string(),
            n => {
                let share = known.iter().filter(|p| **p <= ALPHA).count() as f64 / n as f64;
                format!("{share:.4}")
            }
        }
    });
    cells.collect::<Vec<_>>().join(" | ")
}

fn simulate<const N: usize>(
    studies: u64,
    run: impl Fn(&mut Pcg64) -> [Option<f64>; N] + Sync,
) -> Vec<[Option<f64>; N]> {
    (0..studies).into_par_iter().map(|index| run(&mut stream(2012, index))).collect()
}

fn score_differences(studies: u64) {
    println!("### Groups by score differences and Friedman's test\n");
    println!(
        "| observers | stimuli | SD | α | R_c | largest difference ≥ R_c | 95 % interval | Friedman p ≤ .05 |"
    );
    println!("|--:|--:|--:|--:|--:|--:|--:|--:|");
    for (n, t) in [(10, 5), (21, 5), (21, 9)] {
        for sd in [0.0, 1.0] {
            let p = simulate(studies, |random| {
                let mut scores = vec![vec![0; t]; n];
                for choice in study(n, t, sd, random) {
                    let chosen = if choice.chosen == Some(Side::A) { choice.a } else { choice.b };
                    scores[choice.observer][chosen] += 1;
                }
                [friedman(&scores).ok().map(|test| test.p.value())]
            });
            for alpha in [0.05, 0.01] {
                let Ok(check) = level_check(n as u64, t, alpha, sd, studies, 2012) else {
                    continue;
                };
                let [low, high] = check.interval_95;
                println!(
                    "| {n} | {t} | {sd} | {alpha} | {} | {:.4} | {low:.4}–{high:.4} | {} |",
                    check.r_c,
                    check.level,
                    reached(&p)
                );
            }
        }
    }
    println!();
}

fn clusters(studies: u64) {
    println!("### Observers as clusters\n");
    println!(
        "| observers | stimuli | SD | contrast of two stimuli | all stimuli (F) | the same contrast, answers \
         as independent |"
    );
    println!("|--:|--:|--:|--:|--:|--:|");
    for n in [5, 10, 21] {
        for t in [2, 5, 9] {
            for sd in [0.0, 1.0, 2.0] {
                let p = simulate(studies, |random| {
                    let Ok(found) = by_item(&names(t), &study(n, t, sd, random)) else {
                        return [None; 3];
                    };
                    let named = |name: &str| name == "S0" || name == "S1";
                    let contrast =
                        found.contrasts.iter().find(|c| named(&c.item) && named(&c.over));
                    let clustered = contrast.and_then(|c| c.clustered.as_ref().ok());
                    let naive =
                        contrast.map(|c| libm::erfc(c.estimate / c.se_naive / 2_f64.sqrt()));
                    let overall = found.tests.first().and_then(|test| test.test.as_ref().ok());
                    [clustered.map(|c| c.p.value()), overall.map(|f| f.p.value()), naive]
                });
                println!("| {n} | {t} | {sd} | {} |", reached(&p));
            }
        }
    }
    println!();
}

fn groups_and_orders(studies: u64) {
    // Each study draws 19,999 groupings.
    let studies = studies.min(1000);
    println!("### Two groups of observers, and order effects ({studies} studies per row)\n");
    println!(
        "| observers | stimuli | SD | all stimuli, permutation | any stimulus, Holm | any pair, Holm | first \
         shown, binomial | any pair's order, Holm |"
    );
    println!("|--:|--:|--:|--:|--:|--:|--:|--:|");
    for (n, t) in [(10, 5), (21, 5), (21, 9)] {
        for sd in [0.0, 1.0] {
            let observers: Vec<Observer> = (0..n)
                .map(|i| Observer {
                    code: format!("P{i}"),
                    traits: BTreeMap::from([("group".into(), (i % 2).to_string())]),
                })
                .collect();
            let smallest = |p: &mut dyn Iterator<Item = f64>| p.reduce(f64::min);
            let p = simulate(studies, |random| {
                let choices = study(n, t, sd, random);
                let groups = observer_groups(&names(t), &observers, &choices);
                let groups = groups.first().and_then(|group| group.comparison.as_ref().ok());
                let overall = groups.and_then(|g| g.overall.as_ref().ok());
                let order = order_effects(&names(t), &observers, &choices).ok();
                [
                    overall.map(|test| test.p.value()),
                    groups.and_then(|g| {
                        smallest(&mut g.shares.iter().filter_map(|s| Some(s.p_holm?.value())))
                    }),
                    groups.and_then(|g| {
                        smallest(&mut g.pairs.iter().filter_map(|p| Some(p.p_holm?.value())))
                    }),
                    order.as_ref().map(|order| order.first_chosen.p_binomial.value()),
                    order.and_then(|o| {
                        smallest(&mut o.pairs.iter().filter_map(|p| Some(p.p_holm?.value())))
                    }),
                ]
            });
            println!("| {n} | {t} | {sd} | {} |", reached(&p));
        }
    }
    println!();
}

/// The exact chance to call a share of ½ + margin equivalent, and one of ½.
fn equivalences() {
    println!("### Equivalence within ½ ± 0.10 at α = 0.05, exactly\n");
    println!("| trials | shown if the share is 0.60 | if it is 0.50 |");
    println!("|--:|--:|--:|");
    for n in [21, 63, 150, 300, 600] {
        let shown = |share: f64| -> f64 {
            let rejects =
                |k: &u64| equivalence(*k, n, 0.10, ALPHA).is_ok_and(|t| t.p.value() <= ALPHA);
            let chance = |k: u64| upper_tail(k, n, share) - upper_tail(k + 1, n, share);
            (0..=n).filter(rejects).map(chance).fold(0.0, |sum, p| sum + p)
        };
        println!("| {n} | {:.4} | {:.4} |", shown(0.60), shown(0.50));
    }
}
