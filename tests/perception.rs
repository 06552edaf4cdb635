//! The tests of simplified models, from the pictures to a simplified mesh: the commands of docs/guide/perception-tests.md,
//! on two small models of the lab's own.

use crate::support::{fail, read_table, succeed, tree};
use serde_json::Value;
use std::path::Path;

/// A bent sheet of 2·n² faces with ripples.
fn sheet(n: u32, ripples: f64) -> String {
    let mut text = String::new();
    let part = |k: u32| f64::from(k) / f64::from(n) - 0.5;
    for (i, j) in (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))) {
        let (x, y) = (part(i), part(j));
        let z = 0.3 * (3.0 * x).cos() * (4.0 * y).cos() + 0.03 * (ripples * (x + y)).sin();
        text += &format!("v {x} {y} {z}\n");
    }
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let a = 1 + i + j * (n + 1);
        text += &format!("f {a} {} {} {}\n", a + 1, a + n + 2, a + n + 1);
    }
    text
}

/// The first block of TOML in the guide.
fn cohort() -> &'static str {
    let guide = include_str!("../docs/guide/perception-tests.md");
    guide.split_once("```toml\n").unwrap().1.split_once("```").unwrap().0
}

/// Renders `grid` with both models into `out`, screens it, and lets the guide's cohort answer `grid`'s protocol; returns
/// the rows.
fn study(folder: &Path, grid: &str, select: &str) -> Vec<crate::support::Row> {
    let out = format!("out/{grid}");
    succeed(
        folder,
        &[
            "render", grid, "-o", &out, "--models", "models", "--size", "120x90", "--device",
            "cpu", "--select", select,
        ],
    );
    assert_eq!(succeed(folder, &["screen", &out]), format!("{out}/screen.csv\n"));
    std::fs::write(folder.join("cohort.toml"), cohort().replace("zhang-r", grid)).unwrap();
    let study = format!("study-{grid}");
    succeed(
        folder,
        &["run", grid, "--stimuli", &out, "--study", &study, "--cohort", "cohort.toml"],
    );
    let simulated = folder.join(&study).join("simulated");
    let files = tree(&simulated).into_keys().filter(|name| name.starts_with("data/"));
    files.flat_map(|name| read_table(&simulated.join(name))).collect()
}

fn models(folder: &Path) {
    std::fs::create_dir(folder.join("models")).unwrap();
    for (name, text) in [("smooth-sheet.obj", sheet(40, 0.0)), ("rippled.obj", sheet(50, 8.0))] {
        std::fs::write(folder.join("models").join(name), text).unwrap();
    }
}

#[test]
fn answers_become_a_law_that_simplifies() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    models(folder);
    let rows = study(folder, "zhang-lod", "speed=S1,speed=S2,speed=S3,speed=S4");
    // 2 models × 4 speeds × 7 levels, and each original four times beside itself.
    assert_eq!(rows.len(), 20 * (2 * 4 * 7 + 2 * 4 * 4));
    let identical = rows.iter().filter(|row| row["stimulus_a"] == row["stimulus_b"]);
    assert!(identical.clone().all(|row| row["r"].is_empty() && !row["model"].is_empty()));
    assert_eq!(identical.count(), 20 * 2 * 4 * 4);
    let rated = rows.iter().find(|row| row["stimulus_b"] == "rippled-G-S3-T-A-R4-L16").unwrap();
    assert_eq!(
        (rated["stimulus_a"].as_str(), rated["model"].as_str(), rated["r"].as_str()),
        ("rippled-G-S3-T-A-L100", "rippled", "4.0")
    );
    assert_eq!(
        (rated["level_of_detail"].as_str(), rated["speed_deg_per_s"].as_str()),
        ("0.16", "90.0")
    );

    let study = "study-zhang-lod/simulated";
    let one = succeed(folder, &["fit", "r", study]);
    assert!(one.contains("models were simplified with r = 4 only"), "{one}");
    let words = ["fit", "lod", study, "--frequency-unit", "per-perimeter-degree"];
    assert!(fail(folder, 1, &words).contains("--stimuli DIR is needed"));
    let with = |more: &[&'static str]| [&words[..], &["--stimuli", "out/zhang-lod"], more].concat();
    let other = fail(folder, 2, &with(&["--epsilon", "9"]));
    assert!(
        other.contains("--epsilon: 9: the models in out/zhang-lod were simplified with 0.5"),
        "{other}"
    );
    let none = fail(folder, 1, &with(&["--r", "2"]));
    assert!(none.contains("r: 2: there are ratings with r = 4"), "{none}");
    let fitted: Value =
        serde_json::from_str(&succeed(folder, &with(&["--json", "-o", "law.toml"]))).unwrap();
    let law = std::fs::read_to_string(folder.join("law.toml")).unwrap();
    assert!(law.contains("simulated = true") && law.contains("degrees-per-second"), "{law}");
    assert!(fitted["joint"]["images"] == 56 && law.contains("epsilon = 0.5"), "{fitted}");
    // Another rendering of the same grid is not what was shown.
    succeed(
        folder,
        &[
            "render",
            "zhang-lod",
            "-o",
            "out/other",
            "--models",
            "models",
            "--size",
            "60x45",
            "--device",
            "cpu",
        ],
    );
    let words =
        ["fit", "lod", study, "--frequency-unit", "per-perimeter-pixel", "--stimuli", "out/other"];
    assert!(
        fail(folder, 1, &words).contains("out/other: none of its stimuli is a simplified model")
    );
    let told = fitted["left_out"].as_array().unwrap();
    assert!(told.iter().all(|line| line.as_str().unwrap().contains(" at speed ")), "{told:?}");

    let simplified = |stimulus: &str| -> u64 {
        let words = [
            "simplify",
            "models/rippled.obj",
            "-o",
            "simple.ply",
            "--parameters",
            "law.toml",
            "--grid",
            "zhang-lod",
            "--stimulus",
            stimulus,
            "--json",
        ];
        let report: Value = serde_json::from_str(&succeed(folder, &words)).unwrap();
        report["after"]["faces"].as_u64().unwrap()
    };
    let [slow, fast] = ["S1", "S4"].map(|s| simplified(&format!("knot23-G-{s}-T-A-L100")));
    assert!(fast < slow && slow <= 5000, "{slow} {fast}");
}

/// The originals are rendered once, whatever r there are, and all simplified models are beside them.
#[test]
fn r_is_chosen_among_eight() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    models(folder);
    let rows = study(folder, "zhang-r", "speed=S2,speed=S3");
    // 2 models × 2 speeds × 8 r × 4 levels, and each original eight times beside itself.
    assert_eq!(rows.len(), 20 * (2 * 2 * 8 * 4 + 2 * 2 * 8));
    let found: Value =
        serde_json::from_str(&succeed(folder, &["fit", "r", "study-zhang-r/simulated", "--json"]))
            .unwrap();
    let bins = found["histogram"]["bins"].as_array().unwrap();
    let rs: Vec<f64> = bins.iter().map(|bin| bin["r"].as_f64().unwrap()).collect();
    assert_eq!(rs, [0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0]);
    assert!(bins.iter().all(|bin| bin["images"] == 16), "{bins:?}");
}

#[test]
fn models_that_cannot_take_the_place_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    models(folder);
    let refused = |grid: &str, models: &str| {
        fail(folder, 1, &["render", grid, "-o", "out", "--models", models])
    };
    assert!(refused("demo", "models").contains("demo: the grid has no axis model"));
    assert!(refused("zhang-r", "none").contains("a folder is needed"));
    std::fs::create_dir(folder.join("empty")).unwrap();
    assert!(refused("zhang-r", "empty").contains("it holds no model: .ply, .obj"));
    std::fs::copy(folder.join("models/rippled.obj"), folder.join("models/rip_pled.obj")).unwrap();
    let twice = refused("zhang-r", "models");
    assert!(twice.contains("rip_pled.obj is called rippled, too"), "{twice}");
    std::fs::rename(folder.join("models/rip_pled.obj"), folder.join("models/__.obj")).unwrap();
    assert!(refused("zhang-r", "models").contains("letters and digits are needed in a name"));
}
