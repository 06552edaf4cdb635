//! Cohorts of simulated observers, from the file to the rows.

use crate::support::{Row, fail, read_table, small_stimuli, succeed, tree};
use std::path::Path;
use tempfile::TempDir;

/// The guide's page, whose examples are run here.
const GUIDE: &str = include_str!("../docs/guide/simulated-observers.md");

/// What the guide shows in its first block of `language`.
fn shown(language: &str) -> &'static str {
    let start = format!("```{language}\n");
    let (_, rest) = GUIDE.split_once(&start).unwrap();
    rest.split_once("```").unwrap().0
}

/// A folder with the guide's table of worths and `cohort` as its cohort.
fn folder(cohort: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cohort.toml"), cohort).unwrap();
    std::fs::write(folder.path().join("worths.csv"), shown("csv")).unwrap();
    folder
}

fn run_args() -> [&'static str; 8] {
    let stimuli = small_stimuli().to_str().unwrap();
    ["run", "demo", "--stimuli", stimuli, "--study", "study", "--cohort", "cohort.toml"]
}

/// Every row of the cohort's study.
fn rows(folder: &Path) -> Vec<Row> {
    let data = folder.join("study/simulated");
    let files = tree(&data).into_keys().filter(|name| name.starts_with("data"));
    files.flat_map(|name| read_table(&data.join(name))).collect()
}

/// A share of `n` draws is within five standard deviations of `p`.
fn assert_share(count: usize, n: usize, p: f64) {
    let share = count as f64 / n as f64;
    let bound = 5.0 * (p * (1.0 - p) / n as f64).sqrt();
    assert!((share - p).abs() < bound, "{share} of {n}, expected {p} ± {bound}");
}

#[test]
fn the_cohort_of_the_guide_answers_and_is_analysed() {
    let folder = folder(shown("toml"));
    let said = succeed(folder.path(), &run_args());
    assert_eq!(said, "24 sessions now, 0 before; 912 answers, in study/simulated\n");
    let rows = rows(folder.path());
    assert_eq!(rows.len(), 24 * 38);
    let of = |observer: &str| rows.iter().filter(|row| row["observer"] == observer).count();
    assert_eq!(of("simulated:attentive"), 20 * 38);
    assert_eq!(of("simulated:careless"), 4 * 38);
    assert!(rows.iter().all(|row| ["simulated", "practice"].contains(&row["kind"].as_str())));
    let before = tree(&folder.path().join("study/simulated/data"));
    let again = succeed(folder.path(), &run_args());
    assert_eq!(again, "0 sessions now, 24 before; 0 answers, in study/simulated\n");
    assert!(tree(&folder.path().join("study/simulated/data")) == before);
    let analysis = succeed(folder.path(), &["analyze", "study/simulated"]);
    assert!(analysis.starts_with("Simulated observers."), "{analysis}");
}

/// The rows have the worths, the bias and the lapses that they were drawn from.
#[test]
fn what_observers_are_like_is_found_again_in_their_rows() {
    let observers = |name: &str, prefix: &str, keys: &str| {
        format!(
            "[[observers]]\nname = \"{name}\"\ncount = 150\ncode_prefix = \"{prefix}\"\n{keys}\n\
             response_s = {{ median = 0.5, log_sd = 0.1 }}\n"
        )
    };
    let worths = "model = { kind = \"bradley-terry\", worths = \"worths.csv\" }";
    // Far beyond its noise: this one errs by lapses only.
    let sharp = "model = { kind = \"thurstone\", scale_values = \"scale.csv\", sd = 0.001 }";
    let cohort = [
        "schema = 1\nseed = 11\n".to_string(),
        observers("plain", "P", worths),
        observers("biased", "B", &format!("side_bias = -0.25\n{worths}")),
        observers("tired", "T", &format!("lapse_rate = 0.1\nfatigue = 0.8\n{sharp}")),
    ];
    let folder = folder(&cohort.concat());
    let scale = "item,scale_value\nT3,3\nT4,2\nT5,1\n";
    std::fs::write(folder.path().join("scale.csv"), scale).unwrap();
    succeed(folder.path(), &run_args());
    let rows: Vec<Row> =
        rows(folder.path()).into_iter().filter(|row| row["kind"] == "simulated").collect();
    let level = |id: &str| id.split('-').nth(2).unwrap().to_string();
    let worth = |id: &str| -> f64 {
        match level(id).as_str() {
            "T3" => 4.0,
            "T4" => 2.0,
            _ => 1.0,
        }
    };
    for (observer, bias) in [("simulated:plain", 0.0), ("simulated:biased", -0.25)] {
        for (better, worse) in [("T3", "T4"), ("T3", "T5"), ("T4", "T5")] {
            for better_first in [true, false] {
                let about = |row: &&Row| {
                    let (a, b) = (&row["stimulus_a"], &row["stimulus_b"]);
                    let (first, second) = if row["first"] == "a" { (a, b) } else { (b, a) };
                    let (one, other) = if better_first { (first, second) } else { (second, first) };
                    row["observer"] == observer && level(one) == better && level(other) == worse
                };
                let asked: Vec<&Row> = rows.iter().filter(about).collect();
                let chosen = asked.iter().filter(|row| level(&row["selected"]) == better).count();
                let (i, j) = (worth(&asked[0]["stimulus_a"]), worth(&asked[0]["stimulus_b"]));
                let p = i.max(j) / (i + j);
                // The bias is for the second.
                let p = (1.0 + bias) * p - if better_first { 0.0 } else { bias };
                assert_share(chosen, asked.len(), p);
            }
        }
    }
    // Half of the lapses are errors where there is a better one, and their rate grows from 0.1 to 0.9.
    for trials in [3..=14, 15..=26, 27..=38] {
        let number = |row: &Row| row["trial"].parse::<u32>().unwrap();
        let asked: Vec<&Row> = rows
            .iter()
            .filter(|row| row["observer"] == "simulated:tired" && trials.contains(&number(row)))
            .filter(|row| level(&row["stimulus_a"]) != level(&row["stimulus_b"]))
            .collect();
        let errs = |row: &&&Row| {
            let best = row["stimulus_a"].clone().min(row["stimulus_b"].clone());
            level(&row["selected"]) != level(&best)
        };
        let rates = asked.iter().map(|row| 0.1 + 0.8 * f64::from(number(row) - 1) / 37.0);
        let expected = rates.sum::<f64>() / asked.len() as f64 / 2.0;
        assert_share(asked.iter().filter(errs).count(), asked.len(), expected);
    }
}

/// Every fault is told by file and field before anything is written.
#[test]
fn bad_cohorts_are_refused_and_nothing_is_written() {
    let good = shown("toml");
    let rename = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        good.replacen(from, to, 1)
    };
    for (cohort, expected) in [
        (String::new(), "cohort.toml: line 1: missing field `schema`"),
        (rename("schema = 1", "schema = 2"), "cohort.toml: schema: 2: this version reads"),
        (rename("lapse_rate", "lapses"), "cohort.toml: line 8: unknown field `lapses`"),
        (rename("0.02", "2.0"), "cohort.toml: observers.attentive.lapse_rate: 2: 0 to 1"),
        (rename("count = 20", "count = 0"), "cohort.toml: observers.attentive.count: 0"),
        (rename("\"C\"", "\"A\""), "cohort.toml: observers.careless.code_prefix: A: gives"),
        (rename("\"C\"", "\"C/\""), "cohort.toml: observers.careless.code_prefix: \"C/\""),
        (rename("\"guess\"", "\"gues\""), "did you mean `guess`?"),
        (rename("worths.csv", "none.csv"), "simulated:attentive: none.csv: cannot be read"),
        (rename("worths.csv", "cohort.toml"), "simulated:attentive: cohort.toml: column `item`"),
        (
            rename("worths = \"worths.csv\"", "votes = \"worths.csv\"\nobservers = 3"),
            "simulated:attentive: worths.csv: column `votes` is missing",
        ),
    ] {
        let folder = folder(&cohort);
        let error = fail(folder.path(), 1, &run_args());
        assert!(error.contains(expected), "{error}");
        assert!(!folder.path().join("study").exists(), "{error}");
    }
    let folder = folder(good);
    std::fs::write(folder.path().join("worths.csv"), "item,worth\nT3,2\nT4,1\n").unwrap();
    let error = fail(folder.path(), 1, &run_args());
    assert!(error.contains("simulated:attentive: stimulus M2-S2-T5-A3: 0 of the items"), "{error}");
    let missing = [&run_args()[..7], &["none.toml"]].concat();
    assert!(fail(folder.path(), 1, &missing).contains("none.toml: cannot be read"));
    assert!(!folder.path().join("study").exists());

    let both = [run_args().as_slice(), &["--observer", "simulated:guess"]].concat();
    let refused = crate::support::run_in(folder.path(), &both);
    assert_eq!(refused.status.code(), Some(2));
}
