//! Statistics of paired comparisons against the reference values of other people's data, which are not
//! part of this project: the folder of the values is named by the environment variable SHUTTERLAB_GOLDEN.

#![allow(clippy::print_stdout, reason = "the differences are what is looked for")]

use crate::close;
use serde_json::Value;
use shutterlab_analysis::input::preferences::WinMatrix;
use shutterlab_analysis::maths::studentized_range::{upper_quantile, upper_tail};
use shutterlab_analysis::paired::agreement::agreement;
use shutterlab_analysis::paired::circular_triads::{
    Alternative, TriadsByChance, circular_triads, consistency, max_circular_triads,
};
use shutterlab_analysis::paired::score_equality::score_equality;
use shutterlab_analysis::paired::score_groups::{critical_difference, score_groups};
use shutterlab_analysis::paired::transitivity::transitivity;

fn text(file: &str) -> String {
    let folder = std::env::var("SHUTTERLAB_GOLDEN").expect("SHUTTERLAB_GOLDEN=FOLDER");
    std::fs::read_to_string(std::path::Path::new(&folder).join(file)).unwrap()
}

fn json(file: &str) -> Value {
    serde_json::from_str(&text(file)).unwrap()
}

fn members(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    value.as_object().unwrap().iter()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect()
}

fn whole(value: &Value) -> u64 {
    value.as_f64().unwrap() as u64
}

fn matrix(rows: &Value) -> WinMatrix {
    let rows: Vec<Vec<f64>> = rows.as_array().unwrap().iter().map(numbers).collect();
    let mut wins = WinMatrix::new(rows.len());
    for (i, row) in rows.iter().enumerate() {
        for (j, count) in row.iter().enumerate() {
            wins.add(i, j, *count as u64);
        }
    }
    wins
}

/// Keeps the largest relative difference of each quantity, and refuses one above the limit.
#[derive(Default)]
struct Differences(std::collections::BTreeMap<String, f64>);

impl Differences {
    fn meet(&mut self, ours: f64, theirs: &Value, within: f64, what: &str) {
        let theirs = theirs.as_f64().unwrap();
        close(ours, theirs, within, what);
        let difference = if ours == theirs { 0.0 } else { (ours / theirs - 1.0).abs() };
        let largest = self.0.entry(what.into()).or_default();
        *largest = largest.max(difference);
    }

    fn print(&self, file: &str) {
        for (what, largest) in &self.0 {
            println!("{file}: {what}: largest relative difference {largest:.1e}");
        }
    }
}

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn agreement_scores_groups_and_transitivity_of_real_data() {
    let mut found = Differences::default();
    let exact = json("kendall_u_real_exact_p.json");
    for (name, data) in members(&json("kendall_u_real_datasets.json")) {
        let wins = matrix(&data["wins"]);
        let theirs = &data["result"];
        let (m, t) = (whole(&theirs["n_judges"]), whole(&theirs["n_objects"]) as usize);
        let scores = wins.scores();
        assert_eq!(
            scores.iter().map(|s| *s as f64).collect::<Vec<_>>(),
            numbers(&theirs["scores"])
        );
        let ours = transitivity(&wins).unwrap();
        assert_eq!((ours.triples, ours.untested_triples), (whole(&theirs["n_triples"]), 0));
        for (ours, key) in [(ours.weak, "wst"), (ours.moderate, "mst"), (ours.strong, "sst")] {
            let theirs = whole(&theirs[format!("{key}_violations")]);
            assert_eq!(ours.violations, theirs, "{name}, {key}");
        }
        let ours = agreement(&wins).unwrap();
        assert_eq!(ours.sigma, whole(&theirs["Sigma"]), "{name}");
        if wins.pairs().any(|(i, j)| wins.trials(i, j) != m) {
            // eba takes m from one pair; two of these matrices have a pair with one answer more.
            println!("{name}: unequal counts: u = {:.6} for {}", ours.u, theirs["u"]);
            assert!(ours.chi2.is_none() && ours.chi2_reason.is_some());
            continue;
        }
        found.meet(ours.u, &theirs["u"], 1e-9, "u");
        found.meet(ours.u_min, &theirs["u_min"], 1e-9, "u_min");
        found.meet(ours.chi2.unwrap(), &theirs["chi2_nocorr"], 1e-9, "χ²");
        found.meet(ours.chi2_corrected.unwrap(), &theirs["chi2_corr"], 1e-9, "χ² corrected");
        found.meet(ours.df.unwrap(), &theirs["df"], 1e-9, "df");
        // A p of 0 is R's way to say that it is below the range of f64.
        for (p, key) in [(ours.p, "p_nocorr"), (ours.p_corrected, "p_corr")] {
            match theirs[key].as_f64().unwrap() {
                0.0 => assert!(p.unwrap().value() < 1e-300),
                _ => found.meet(p.unwrap().value(), &theirs[key], 1e-9, key),
            }
        }
        if let Some(p) = exact.get(name) {
            match p.as_f64().unwrap() {
                0.0 => assert!(ours.p_exact.unwrap().value() < 1e-300),
                _ => found.meet(ours.p_exact.unwrap().value(), p, 1e-9, "exact p"),
            }
        }
        let equality = score_equality(&scores, m);
        found.meet(equality.d, &theirs["D_equality"], 1e-9, "D");
        assert_eq!(equality.df, whole(&theirs["D_df"]));
        match theirs["D_p"].as_f64().unwrap() {
            0.0 => assert!(equality.p.value() < 1e-300),
            _ => found.meet(equality.p.value(), &theirs["D_p"], 1e-9, "p of D"),
        }
        // The W of R's qtukey has seven digits.
        for (alpha, w, r_c) in [(0.05, "W_05", "Rc_05"), (0.01, "W_01", "Rc_01")] {
            found.meet(upper_quantile(alpha, t), &theirs[w], 1e-6, "W of R's qtukey");
            assert_eq!(critical_difference(m, t, alpha), whole(&theirs[r_c]), "{name}");
        }
    }
    found.print("kendall_u_real_datasets.json");
}

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn groups_of_real_data() {
    for (name, data) in members(&json("score_groups.json")["data"]) {
        for (alpha, key) in [(0.05, "alpha_05"), (0.01, "alpha_01")] {
            let theirs = &data[key];
            let items: Vec<String> = serde_json::from_value(theirs["order"].clone()).unwrap();
            let votes: Vec<u64> = serde_json::from_value(theirs["scores"].clone()).unwrap();
            let ours = score_groups(&items, &votes, whole(&data["n"]), alpha);
            assert_eq!(ours.r_c, whole(&theirs["Rc"]), "{name}");
            let groups: Vec<Vec<String>> =
                serde_json::from_value(theirs["homogeneous_groups"].clone()).unwrap();
            assert_eq!(ours.groups, groups, "{name}, α = {alpha}");
            let different: Vec<[String; 2]> =
                serde_json::from_value(theirs["different_pairs"].clone()).unwrap();
            let apart = |a: &String, b: &String| {
                !groups.iter().any(|group| group.contains(a) && group.contains(b))
            };
            let pairs = items.iter().enumerate();
            let pairs = pairs.flat_map(|(i, a)| items[i + 1..].iter().map(move |b| (a, b)));
            assert_eq!(pairs.filter(|(a, b)| apart(a, b)).count(), different.len(), "{name}");
            assert!(different.iter().all(|[a, b]| apart(a, b)), "{name}");
        }
    }
}

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn raw_sessions_of_sharpened_images() {
    let theirs = json("sureal_sharpened_images_kendall.json");
    let mut found = Differences::default();
    let raw = text("sureal_sharpened_images_pc_long.csv");
    for (content, theirs) in members(&theirs["contents"]) {
        let t = whole(&theirs["t"]) as usize;
        let assets: Vec<u64> = serde_json::from_value(theirs["assets"].clone()).unwrap();
        let place = |asset: &str| assets.iter().position(|a| a.to_string() == asset).unwrap();
        let mut judges = std::collections::BTreeMap::new();
        for line in raw.lines().skip(1) {
            let [of, observer, winner, loser, count] =
                line.split(',').collect::<Vec<_>>().try_into().unwrap();
            if of == content {
                let wins: &mut WinMatrix =
                    judges.entry(observer).or_insert_with(|| WinMatrix::new(t));
                wins.add(place(winner), place(loser), count.parse().unwrap());
            }
        }
        judges.retain(|_, wins| wins.pairs().all(|(i, j)| wins.trials(i, j) == 1));
        assert_eq!(judges.len() as u64, whole(&theirs["m_complete"]));
        let mut pooled = WinMatrix::new(t);
        for wins in judges.values() {
            for (i, j) in wins.pairs() {
                pooled.add(i, j, wins.get(i, j));
                pooled.add(j, i, wins.get(j, i));
            }
        }
        assert_eq!(pooled, matrix(&theirs["wins"]));
        let ours = agreement(&pooled).unwrap();
        found.meet(ours.sigma as f64, &theirs["Sigma"], 1e-10, "Σ");
        found.meet(ours.u, &theirs["u"], 1e-10, "u");
        found.meet(ours.chi2.unwrap(), &theirs["chi2"], 1e-10, "χ²");
        found.meet(ours.df.unwrap(), &theirs["df"], 1e-10, "df");
        for zeta in theirs["zetas"].as_array().unwrap() {
            let d = circular_triads(&judges[zeta["observer"].as_str().unwrap()].scores());
            found.meet(d as f64, &zeta["d"], 1e-10, "d");
            found.meet(consistency(d, 1, t), &zeta["zeta"], 1e-10, "ζ");
        }
    }
    found.print("sureal_sharpened_images");
}

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn circular_triads_of_every_example() {
    let mut found = Differences::default();
    for (name, theirs) in members(&json("zeta_worked_examples.json")) {
        let scores = matrix(&theirs["wins"]).scores();
        let t = scores.len();
        let d = circular_triads(&scores);
        assert_eq!(d, whole(&theirs["T"]), "{name}");
        assert_eq!(max_circular_triads(t), whole(&theirs["T_max"]), "{name}");
        found.meet(consistency(d, 1, t), &theirs["zeta"], 1e-10, "ζ");
        for (alternative, key) in [
            (Alternative::Less, "less"),
            (Alternative::Greater, "greater"),
            (Alternative::TwoSided, "two.sided"),
        ] {
            let theirs = &theirs["tests"][key];
            let ours = TriadsByChance::new(t).test(&[d], alternative);
            let corrected = ours.chi_square_corrected;
            let p = ours.p_exact.or(corrected.map(|test| test.p)).unwrap().value();
            found.meet(p, &theirs["p_default"], 1e-10, "p");
            let (Some(plain), Some(corrected)) = (ours.chi_square, corrected) else {
                assert!(theirs["df"].is_null(), "{name}");
                continue;
            };
            found.meet(corrected.df, &theirs["df"], 1e-10, "df");
            found.meet(corrected.chi2, &theirs["chi2_corr"], 1e-10, "χ² corrected");
            found.meet(corrected.p.value(), &theirs["p_chi2_corr"], 1e-10, "p of χ² corrected");
            found.meet(plain.chi2, &theirs["chi2_nocorr"], 1e-10, "χ²");
            found.meet(plain.p.value(), &theirs["p_chi2_nocorr"], 1e-10, "p of χ²");
        }
    }
    for theirs in json("circular_triads_exact_null.json")["dist"].as_array().unwrap() {
        let counts: Vec<u64> = serde_json::from_value(theirs["count"].clone()).unwrap();
        let chance = TriadsByChance::new(whole(&theirs["t"]) as usize);
        assert_eq!(chance.tournaments(), Some(&counts[..]));
    }
    found.print("zeta_worked_examples.json");
}

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn every_row_of_the_distributions() {
    let mut found = Differences::default();
    for table in json("kendall_u_exact_null.json")["tables"].as_array().unwrap() {
        let (m, t) = (whole(&table["m"]), whole(&table["t"]) as usize);
        for row in table["rows"].as_array().unwrap() {
            let row = row.as_array().unwrap();
            let ours = crate::agreement::result(m, t, whole(&row[0]));
            found.meet(ours.u, &row[1], 1e-9, "u");
            let p = ours.p_exact.unwrap().value();
            found.meet(p, &row[2], 1e-9, "exact p");
            assert!((p - row[2].as_f64().unwrap()).abs() < 1e-12);
            found.meet(ours.p.unwrap().value(), &row[3], 1e-9, "p of χ²");
            found.meet(ours.p_corrected.unwrap().value(), &row[4], 1e-9, "p of χ² corrected");
        }
    }
    for (key, w) in members(&json("studentized_range_exact_dfinf.json")["W"]) {
        let (t, alpha) = key.split_once(',').unwrap();
        let ours = upper_quantile(alpha.parse().unwrap(), t.parse().unwrap());
        found.meet(ours, w, 1e-9, "W");
    }
    let mut furthest: f64 = 0.0;
    for line in text("studentized_range_p.csv").lines().skip(1) {
        let [q, t, p] = line.split(',').collect::<Vec<_>>().try_into().unwrap();
        let ours = upper_tail(q.parse().unwrap(), t.parse().unwrap());
        furthest = furthest.max((ours - p.parse::<f64>().unwrap()).abs());
    }
    println!("studentized_range_p.csv: largest absolute difference {furthest:.1e}");
    assert!(furthest < 2e-8, "R's ptukey is off by 1.2e-8 at most");
    for line in text("rc_score_difference.csv").lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let ours = critical_difference(row[0] as u64, row[1] as usize, row[2]);
        assert_eq!(ours as f64, row[5], "{line}");
    }
    found.print("distributions");
}

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn agreement_of_incomplete_data() {
    let mut found = Differences::default();
    let scenes = json("incomplete_video_tmo_bt.json");
    for (scene, theirs) in members(&json("kendall_u_incomplete_exact.json")["data"]) {
        let ours = agreement(&matrix(&scenes["scenes"][scene]["wins"])).unwrap();
        assert_eq!(ours.sigma, whole(&theirs["Sigma"]));
        found.meet(ours.u, &theirs["u_generalised"], 1e-9, "u");
        found.meet(ours.p_exact.unwrap().value(), &theirs["p_exact"], 1e-9, "exact p");
    }
    found.print("kendall_u_incomplete_exact.json");
}
