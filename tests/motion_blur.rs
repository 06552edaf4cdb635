//! Methods as an axis of a grid, and the measurement of what simplified models save.

use crate::support::{fail, run_in, succeed};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A bent sheet of more faces than it needs.
fn model() -> String {
    let mut text = String::new();
    const N: i32 = 12;
    for j in 0..=N {
        for i in 0..=N {
            let (x, y) = (f64::from(i) / f64::from(N) - 0.5, f64::from(j) / f64::from(N) - 0.5);
            text += &format!("v {x} {y} {}\n", 0.3 * (3.0 * x).cos() * (4.0 * y).cos());
        }
    }
    for j in 0..N {
        for i in 0..N {
            let a = 1 + i + j * (N + 1);
            text += &format!("f {a} {} {} {}\n", a + 1, a + N + 2, a + N + 1);
        }
    }
    text
}

const SCENE: &str = r#"
schema = 1
name = "crossing"
illumination = "local"
[camera]
position_m = [0.0, 0.0, 3.0]
look_at_m = [0.0, 0.0, 0.0]
focal_length_mm = 50.0
sensor_width_mm = 36.0
[environment]
uniform = [0.0, 0.0, 0.0]
[[lights]]
kind = "directional"
direction = [0.3, -0.4, -1.0]
irradiance = [2.0, 2.0, 2.0]
[[objects]]
name = "model"
shape = { kind = "mesh", file = "model.obj" }
motion = { translation = [1.0, 0.0, 0.0] }
"#;

const GRID: &str = r#"
schema = 1
name = "methods"
title = "One model by three methods"
scene = "scene.toml"
method = "distribution-ray-tracing"
trajectory = "once"
seed = 1
sampler = "sobol"
sampling = "nested"
[image]
width_px = 80
height_px = 60
fps = 30.0
frames = 2
exposure_stops = 0.0
transfer = "srgb"
[viewing]
image_width_deg = 14.4
[materials.grey]
kind = "constant"
albedo = [0.7, 0.7, 0.7]
[axes.method]
D = "distribution-ray-tracing"
A = "accumulation-buffer"
S = "stochastic-rasterization"
[axes.material]
M = "grey"
[axes.speed_deg_per_s]
V = 20.0
[axes.shutter_open_fraction]
T = 1.0
[axes.samples]
N = 256
AA = "adaptive"
"#;

fn pixels(folder: &Path, sequence: &str) -> Vec<f64> {
    let file = folder.join("out").join(sequence).join("frame-0001.png");
    let image = image::open(file).unwrap().into_rgb8();
    image.into_raw().into_iter().map(f64::from).collect()
}

#[test]
fn a_grid_renders_one_scene_by_all_methods() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("model.obj"), model()).unwrap();
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    std::fs::write(folder.join("grid.toml"), GRID).unwrap();
    succeed(folder, &["render", "grid.toml", "-o", "out", "--device", "cpu"]);
    let rays = pixels(folder, "D-M-V-T-N");
    assert!(rays.iter().sum::<f64>() > 1e5);
    for method in ["A", "S"] {
        let found = pixels(folder, &format!("{method}-M-V-T-N"));
        let mean: f64 = rays.iter().zip(&found).map(|(a, b)| (a - b).abs()).sum::<f64>();
        assert!(mean / (rays.len() as f64) < 0.5, "{method}: {mean}");
    }
    let manifest = std::fs::read_to_string(folder.join("out/S-M-V-T-AA/sequence.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!(manifest["stimulus"]["method"], "stochastic-rasterization");
    assert_eq!(manifest["stimulus"]["samples"], 16);
    assert_eq!(manifest["device"]["kind"], "cpu");
    succeed(folder, &["validate", "out"]);

    std::fs::write(folder.join("scene.toml"), SCENE.replace("\"local\"", "\"global\"")).unwrap();
    let error = fail(folder, 1, &["render", "grid.toml", "-o", "other"]);
    assert!(error.contains("accumulation-buffer") && error.contains("illumination"), "{error}");
    let error = fail(folder, 2, &["render", "grid.toml", "-o", "other", "--select", "method=B"]);
    assert!(error.contains("levels of method are D, A, S"), "{error}");
}

#[test]
fn models_that_are_not_simplified_save_nothing_and_look_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("model.obj"), model()).unwrap();
    let words = ["bench", "motion-blur", "model.obj", "--size", "64x48", "-o", "out"];
    let text = succeed(folder, &[&words[..], &["--ratios", "1,1,1,0.1"]].concat());
    assert_eq!(text.lines().count(), 13, "{text}");
    let mut table = csv::Reader::from_path(folder.join("out/motion-blur.csv")).unwrap();
    let rows: Vec<BTreeMap<String, Value>> = table.deserialize().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 12);
    for row in &rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        assert!(number("seconds") > 0.0 && number("simplified_seconds") > 0.0);
        let error = number("relative_rmse");
        match number("px_per_shutter") {
            270.0 => assert!(number("simplified_faces") <= 28.0 && error > 1e-3, "{row:?}"),
            _ => assert!(number("simplified_faces") == 288.0 && error < 1e-6, "{row:?}"),
        }
    }
    for method in ["distribution-ray-tracing", "accumulation-buffer", "stochastic-rasterization"] {
        let file = folder.join(format!("out/motion-blur-{method}.svg"));
        assert!(std::fs::read_to_string(file).unwrap().contains("speed-up ratio"));
    }
    for (words, expected) in [
        (&["--ratios", "1,1,1,0"][..], "four parts, above 0 and up to 1"),
        (&["--ratios", "1,1"], "four parts"),
        (&["--size", "0x1"], "WIDTHxHEIGHT"),
    ] {
        let error = fail(folder, 2, &[&["bench", "motion-blur", "model.obj"], words].concat());
        assert!(error.contains(expected), "{error}");
    }
    let absent = run_in(folder, &["bench", "motion-blur", "absent.ply"]);
    assert_eq!(absent.status.code(), Some(1));
}
