//! `fit` on made-up ratings and points: known parameters come back, and what does not follow is words.

use crate::support::{fail, run_in, succeed};
use serde_json::Value;
use shutterlab_data_schema::FittedParameters;
use std::path::Path;
use tempfile::TempDir;

const UNITS: [&str; 4] =
    ["--velocity-unit", "pixels-per-shutter", "--frequency-unit", "per-perimeter-pixel"];

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, &[args, &["--json"]].concat())).unwrap()
}

/// A table of ratings in which 40 observers answer as often as chance has it: the rating is 0.8 where the
/// frequency is 1/(0.4·v + 2).
fn ratings(r: &[f64]) -> String {
    let mut text =
        "# made up\nmodel,r,level_of_detail,speed,same,different,frequency\n".to_string();
    for (model, original) in [("bunny", 0.5), ("igea", 0.6), ("dragon", 0.7)] {
        for speed in [1.0, 3.0, 9.0, 27.0] {
            for level in [0.005_f64, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0] {
                let frequency = original * level.sqrt();
                let excess: f64 = (frequency * (0.4 * speed + 2.0_f64)).ln();
                for r in r {
                    let better = if *r == 4.0 { 1.2 } else { 0.0 };
                    let chance = 1.0 / (1.0 + (-(4.0_f64.ln()) - better - 3.0 * excess).exp());
                    let same = (40.0 * chance).round();
                    text += &format!(
                        "{model},{r},{level},{speed},{same},{},{frequency}\n",
                        40.0 - same
                    );
                }
            }
        }
    }
    text
}

#[test]
fn the_law_comes_back_from_ratings() {
    let folder = folder(&[("ratings.csv", &ratings(&[2.0]))]);
    let args = [&["fit", "lod", "ratings.csv", "-o", "fitted.toml"][..], &UNITS].concat();
    let refit = json(folder.path(), &args);
    assert_eq!(refit["drawn"], "answers");
    for (name, truth) in [("sigma_1", 0.4), ("sigma_2", 2.0)] {
        let found = refit["fit"][name]["estimate"].as_f64().unwrap();
        assert!((found / truth - 1.0).abs() < 0.1, "{name}: {found}");
        assert!(refit[format!("{name}_less_published")].is_number(), "{name}");
    }
    assert_eq!(
        (&refit["published"]["sigma_1"]["value"], &refit["published_r"]),
        (&7.3.into(), &4.0.into())
    );
    let fitted = FittedParameters::read(&folder.path().join("fitted.toml")).unwrap();
    let law = fitted.law.unwrap();
    let said = succeed(folder.path(), &["validate", "fitted.toml"]);
    assert!(said.contains("parameters fitted to ratings.csv"), "{said}");
    let [low, high] = law.sigma_1.interval_95.unwrap();
    assert!(low < law.sigma_1.value && law.sigma_1.value < high);
    assert_eq!(fitted.weight.unwrap().r, 2.0);
    assert_eq!(fitted.fitted_to.models, ["bunny", "dragon", "igea"]);
    assert_eq!(fitted.fitted_to.simulated, None);
}

#[test]
fn several_r_need_one_and_a_share_of_faces_needs_a_frequency() {
    let table = ratings(&[2.0, 4.0]);
    let without: String = table
        .lines()
        .map(|line| format!("{}\n", line.rsplit_once(',').map_or(line, |(l, _)| l)))
        .collect();
    let folder = folder(&[("ratings.csv", &table), ("shares.csv", &without)]);
    let lod = |file| [&["fit", "lod", file][..], &UNITS].concat();
    let error = fail(folder.path(), 1, &lod("ratings.csv"));
    assert!(error.contains("r = 2, 4: one of them is needed; choose it with --r"), "{error}");
    let error = fail(folder.path(), 1, &[&lod("ratings.csv")[..], &["--r", "3"]].concat());
    assert!(error.contains("ratings.csv: r: 3: there are ratings with r = 2, 4"), "{error}");
    succeed(folder.path(), &[&lod("ratings.csv")[..], &["--r", "4"]].concat());
    let error = fail(folder.path(), 1, &lod("shares.csv"));
    assert!(error.contains("a share of faces and no spatial frequency"), "{error}");
    let error = fail(
        folder.path(),
        2,
        &["fit", "lod", "ratings.csv", "--velocity-unit", "degrees-per-second"],
    );
    assert!(error.contains("--frequency-unit"), "{error}");
    let error = fail(folder.path(), 2, &["fit", "r", "ratings.csv"]);
    assert!(error.contains("needs --velocity-unit"), "{error}");
}

#[test]
fn r_is_chosen_where_it_is_clear_and_not_where_it_is_not() {
    let folder =
        folder(&[("clear.csv", &ratings(&[0.0, 4.0])), ("alike.csv", &ratings(&[0.0, 2.0]))]);
    let r = |file| ["fit", "r", file, UNITS[0], UNITS[1], "-o", "r.toml"];
    let analysis = json(folder.path(), &r("clear.csv"));
    assert_eq!(analysis["histogram"]["chosen"], 4.0);
    let fitted = FittedParameters::read(&folder.path().join("r.toml")).unwrap();
    assert_eq!((fitted.weight.as_ref().unwrap().r, fitted.weight.unwrap().epsilon), (4.0, None));
    assert_eq!(fitted.law, None);
    std::fs::remove_file(folder.path().join("r.toml")).unwrap();
    let error = fail(folder.path(), 1, &r("alike.csv"));
    assert!(error.contains("r.toml: not written: r is hardly identifiable"), "{error}");
    assert!(!folder.path().join("r.toml").exists());
}

#[test]
fn two_speeds_give_a_law_and_one_gives_words() {
    let folder = folder(&[
        ("two.csv", "speed,frequency\n1,0.4\n9,0.18\n"),
        ("one.csv", "speed,frequency\n1,0.4\n1,0.41\n"),
        ("bad.csv", "speed,frequency\n1,fast\n"),
    ]);
    let lod = |file| [&["fit", "lod", "--points", file][..], &UNITS].concat();
    let two = json(folder.path(), &lod("two.csv"));
    assert!(two["fit"]["sigma_1"]["se"].is_null());
    assert!(two["fit"]["reason"].as_str().unwrap().starts_with("two points determine"));
    assert!(two["bootstrap"].is_null() && two["bootstrap_reason"].is_string());
    let one = json(folder.path(), &lod("one.csv"));
    assert!(one["fit"].is_null());
    assert!(one["fit_reason"].as_str().unwrap().contains("at the speed 1 only"));
    let said = succeed(folder.path(), &lod("one.csv"));
    assert!(said.contains("No law through points follows: 2 points at the speed 1 only"), "{said}");
    let error = fail(folder.path(), 1, &[&lod("one.csv")[..], &["-o", "f.toml"]].concat());
    assert!(error.contains("f.toml: not written: 2 points at the speed 1 only"), "{error}");
    let error = fail(folder.path(), 1, &lod("bad.csv"));
    assert!(error.contains("bad.csv: line 2: frequency: `fast`"), "{error}");
}

#[test]
fn a_threshold_is_found_with_its_report() {
    let table = "level,chosen,trials\n1,2,20\n2,5,20\n3,12,20\n4,17,20\n6,20,20\n";
    let folder =
        folder(&[("answers.csv", table), ("step.csv", "level,chosen,trials\n1,0,9\n2,9,9\n")]);
    let args = ["fit", "psychometric", "answers.csv", "--threshold", "0.5", "--report", "out"];
    let found = json(folder.path(), &args);
    let level = found["threshold"]["level"].as_f64().unwrap();
    assert!(level > 2.0 && level < 3.5, "{level}");
    assert!(found["goodness_of_fit"]["p_monte_carlo"].is_number());
    for file in ["report.html", "psychometric-levels.csv", "figures/psychometric.svg"] {
        assert!(folder.path().join("out").join(file).exists(), "{file}");
    }
    let error = fail(folder.path(), 1, &["fit", "psychometric", "step.csv"]);
    assert!(error.contains("step.csv: the answers are separated"), "{error}");
    let output = run_in(folder.path(), &["fit", "psychometric", "answers.csv", "--lapse", "maybe"]);
    assert_eq!(output.status.code(), Some(2));
}

/// The shipped study shows no simplified models: `fit` says so.
#[test]
fn a_study_without_models_has_no_ratings() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &crate::support::guess("study", "S01"));
    let error = fail(folder.path(), 1, &["fit", "r", "study/simulated"]);
    assert!(error.contains("no answer says of which simplified model it is"), "{error}");
}
