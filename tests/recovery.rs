//! From simulated answers back to what they were drawn from.

use crate::support::{read_table, small_stimuli, succeed, tree};
use serde_json::Value;
use shutterlab_analysis::maths::studentized_range::upper_quantile;
use shutterlab_analysis::replication::published;
use shutterlab_data_schema::Votes;
use shutterlab_experiments::{SessionRequest, SimulatedObserver, protocols, run_simulated};
use std::collections::BTreeMap;
use std::path::Path;
use tempfile::TempDir;

/// Observers of a cohort.
const COHORT: u32 = 60;
/// Stimuli of the shipped protocol, each compared with each other one.
const STIMULI: usize = 9;

/// A study in the folder `study` in which a cohort of observers like `observer` answered the shipped
/// protocol.
fn cohort(observer: &SimulatedObserver) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let protocol = protocols::load("demo").unwrap();
    for number in 1..=COHORT {
        let request = SessionRequest {
            protocol: protocol.clone(),
            stimuli: small_stimuli().into(),
            study: folder.path().join("study"),
            participant: Some(format!("S{number:02}").parse().unwrap()),
            pilot: false,
        };
        assert!(run_simulated(&request, observer).unwrap().finished);
    }
    folder
}

/// What the command says about the study.
fn analysis(folder: &Path) -> Value {
    serde_json::from_str(&succeed(folder, &["analyze", "study/simulated", "--json"])).unwrap()
}

fn strings(list: &Value) -> Vec<String> {
    list.as_array().unwrap().iter().map(|item| item.as_str().unwrap().to_string()).collect()
}

/// Items and votes, best first, as the analysis prints them.
fn votes(analysis: &Value) -> Vec<(String, u64)> {
    let counts = analysis["votes"].as_array().unwrap().iter().map(|count| count.as_u64().unwrap());
    strings(&analysis["items"]).into_iter().zip(counts).collect()
}

/// How often each stimulus was chosen in trials that count, counted in the files.
fn votes_in_files(folder: &Path) -> BTreeMap<String, u64> {
    let study = folder.join("study/simulated");
    let mut counts = BTreeMap::new();
    for name in tree(&study).into_keys().filter(|name| name.starts_with("data")) {
        for row in read_table(&study.join(name)) {
            if row["kind"] == "simulated" {
                *counts.entry(row["selected"].clone()).or_default() += 1;
            }
        }
    }
    counts
}

/// Observers who follow a published table give its votes, and the analysis finds the groups that
/// these votes have.
#[test]
fn a_cohort_gives_the_votes_of_the_table_it_follows() {
    let table = published::find("mono-shutter-sampling").unwrap();
    let published = Votes::parse(table.csv, table.name).unwrap();
    let observers = u32::try_from(table.observers).unwrap();
    let observer = SimulatedObserver::from_votes(table.name, &published, observers).unwrap();
    let folder = cohort(&observer);
    let analysis = analysis(folder.path());
    let found = votes(&analysis);
    assert_eq!(found.iter().cloned().collect::<BTreeMap<_, _>>(), votes_in_files(folder.path()));

    for row in &published.rows {
        // An item of the table like A4T3 is the stimulus M2-S2-T3-A4.
        let levels = format!("-{}-{}", &row.item[2..], &row.item[..2]);
        let (_, count) = found.iter().find(|(item, _)| item.ends_with(&levels)).unwrap();
        // The published share q is the mean of the eight probabilities p with which the item is
        // chosen over the others, and COHORT observers answer independently: the expectation is
        // 8·COHORT·q, the variance COHORT·Σ p(1 − p), at most 8·COHORT·q(1 − q) as p(1 − p) is concave.
        let judged = 8.0 * f64::from(COHORT);
        let share = row.votes as f64 / (8.0 * f64::from(observers));
        let deviation = *count as f64 - judged * share;
        let standard_error = (judged * share * (1.0 - share)).sqrt();
        assert!(
            deviation.abs() < 5.0 * standard_error,
            "{}: {count} votes, expected {:.1} ± {standard_error:.1}",
            row.item,
            judged * share
        );
    }

    assert_eq!(analysis["simulated"], true);
    assert!(
        succeed(folder.path(), &["analyze", "study/simulated"]).starts_with("Simulated observers.")
    );
    assert_eq!(analysis["observers"], COHORT);
    assert_eq!(analysis["data_quality"]["excluded"]["practice"], 2 * COHORT);
    assert!(analysis["score_equality"]["p"].as_f64().unwrap() < 1e-4);
    check_groups(&analysis, &found, 0.01);
}

/// Computes the groups anew from the votes and holds them against the printed ones.
fn check_groups(analysis: &Value, votes: &[(String, u64)], alpha: f64) {
    let w = upper_quantile(alpha, STIMULI);
    let r_c = (0.5 * w * (f64::from(COHORT) * STIMULI as f64).sqrt() + 0.25).ceil() as u64;
    assert_eq!(analysis["grouping"]["r_c"], r_c);
    assert!(votes.is_sorted_by(|better, worse| better.1 >= worse.1));
    let all_runs = (0..STIMULI).flat_map(|start| (start..STIMULI).map(move |end| (start, end)));
    let runs: Vec<(usize, usize)> =
        all_runs.filter(|(start, end)| votes[*start].1 - votes[*end].1 < r_c).collect();
    let is_maximal = |(start, end): &(usize, usize)| {
        runs.iter().all(|(s, e)| (s, e) == (start, end) || s > start || e < end)
    };
    let groups: Vec<Vec<String>> = runs
        .iter()
        .filter(|run| is_maximal(run))
        .map(|(start, end)| votes[*start..=*end].iter().map(|(item, _)| item.clone()).collect())
        .collect();
    let printed: Vec<Vec<String>> =
        analysis["grouping"]["groups"].as_array().unwrap().iter().map(strings).collect();
    assert_eq!(printed, groups);
    // The thesis finds several: this cohort is large enough to tell them apart as well.
    assert!(groups.len() > 1, "{groups:?}");
}

/// Observers who guess prefer nothing and agree no more than coins do.
#[test]
fn a_guessing_cohort_shows_no_preference() {
    let folder = cohort(&SimulatedObserver::guess());
    let analysis = analysis(folder.path());
    let found = votes(&analysis);
    assert_eq!(found.iter().cloned().collect::<BTreeMap<_, _>>(), votes_in_files(folder.path()));
    let p = |test: &str, tail: &str| analysis[test][tail].as_f64().unwrap();
    assert!(p("score_equality", "p") > 1e-4, "{:#}", analysis["score_equality"]);
    assert!(p("agreement", "p_exact") > 1e-4, "{:#}", analysis["agreement"]);
    assert!(p("consistency", "p") > 1e-4, "{:#}", analysis["consistency"]["p"]);
    // Not less either, as it would be if the observers' answers were made to balance: chance gives
    // u = 0 with the variance 2/(C(t,2)·m(m − 1)).
    let (pairs, m) = ((STIMULI * (STIMULI - 1) / 2) as f64, f64::from(COHORT));
    let standard_error = (2.0 / (pairs * m * (m - 1.0))).sqrt();
    assert!(p("agreement", "u").abs() < 5.0 * standard_error, "{:#}", analysis["agreement"]);
}
