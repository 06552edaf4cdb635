//! How long bootstrap intervals of scale values take: 10,000 replicates of a study of 21 observers who
//! judge all 36 pairs of 9 items, a bias-reduced Bradley–Terry fit each; and how long R takes for a fit.
//!
//! `cargo bench -p shutterlab-analysis --bench bootstrap`. Where `Rscript` is installed, `bootstrap.R`
//! beside this file resamples the same answers.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use rand::RngExt;
use shutterlab_analysis::maths::random::stream;
use shutterlab_analysis::scaling::bootstrap::bootstrap;
use shutterlab_analysis::scaling::comparisons::{Comparisons, Pair};
use shutterlab_analysis::scaling::model::Model;
use std::fmt::Write;
use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

const VALUES: [f64; 9] = [1.2, 0.9, 0.6, 0.3, 0.0, -0.3, -0.6, -0.9, -1.2];
const OBSERVERS: u64 = 21;
const REPLICATES: usize = 10_000;
const RUNS: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let observers = observers()?;
    println!(
        "{REPLICATES} replicates of {OBSERVERS} observers, 36 pairs, a fit each, and all intervals:"
    );
    let mut fastest = f64::INFINITY;
    for threads in [1, std::thread::available_parallelism()?.get()] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let mut seconds: Vec<f64> = (0..RUNS).map(|_| pool.install(|| time(&observers))).collect();
        seconds.sort_by(f64::total_cmp);
        let median = seconds[RUNS / 2];
        println!("  {threads} threads: {median:.3} s (median of {RUNS} runs)");
        fastest = fastest.min(median);
    }
    let answers = tempfile::NamedTempFile::new()?;
    std::fs::write(answers.path(), csv(&observers)?)?;
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/bootstrap.R");
    let Ok(output) = Command::new("Rscript").arg(script).arg(answers.path()).output() else {
        println!("Rscript is not installed: no comparison with R.");
        return Ok(());
    };
    println!("R, per replicate:");
    for line in String::from_utf8(output.stdout)?.lines() {
        let Some((name, seconds)) = line.split_once('\t') else { continue };
        let seconds: f64 = seconds.parse()?;
        let ratio = seconds * REPLICATES as f64 / fastest;
        println!("  {name}: {:.3} ms, {ratio:.0} times as long", 1000.0 * seconds);
    }
    print!("{}", String::from_utf8_lossy(&output.stderr));
    Ok(())
}

/// Seconds for the replicates, and for the intervals of all values and differences.
fn time(observers: &[Comparisons]) -> f64 {
    let start = Instant::now();
    if let Ok(drawn) = bootstrap(observers, Model::BradleyTerry, REPLICATES, 1) {
        for i in 0..VALUES.len() {
            black_box(drawn.interval_95(|values| values[i]));
            for j in i + 1..VALUES.len() {
                black_box(drawn.interval_95(|values| values[i] - values[j]));
            }
        }
    }
    start.elapsed().as_secs_f64()
}

fn observers() -> Result<Vec<Comparisons>, String> {
    let items: Vec<String> = (1..=VALUES.len()).map(|i| format!("item {i}")).collect();
    let places = || (0..VALUES.len()).flat_map(|i| (i + 1..VALUES.len()).map(move |j| (i, j)));
    let of_one = |observer| {
        let mut random = stream(1, observer);
        let answer = |(i, j): (usize, usize)| {
            let chosen = 1.0 / (1.0 + libm::exp(VALUES[j] - VALUES[i]));
            let wins = if random.random_bool(chosen) { [1.0, 0.0] } else { [0.0, 1.0] };
            Pair { i, j, wins, ties: 0.0 }
        };
        Comparisons::of_pairs(&items, places().map(answer).collect())
    };
    (0..OBSERVERS).map(of_one).collect()
}

fn csv(observers: &[Comparisons]) -> Result<String, std::fmt::Error> {
    let mut text = String::from("observer,i,j,i_chosen\n");
    for (observer, answers) in observers.iter().enumerate() {
        for Pair { i, j, wins, .. } in answers.pairs() {
            writeln!(text, "{observer},{i},{j},{}", wins[0])?;
        }
    }
    Ok(text)
}
