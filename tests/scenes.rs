//! Scenes in files of one's own, and the light maps that they name.

use crate::support::{fail, succeed};
use shutterlab_stimuli::{LinearImage, Sequence};
use std::path::Path;

const SCENE: &str = include_str!("../stimuli/scenes/rolling-sphere.toml");

/// A grid in `folder` whose scene, in a folder below, is the shipped one with `from` replaced by `to`.
fn grid_with(folder: &Path, from: &str, to: &str) {
    let grid = include_str!("../stimuli/grids/demo.toml");
    let grid = grid.replace("scene = \"rolling-sphere\"", "scene = \"scenes/mine.toml\"");
    std::fs::write(folder.join("grid.toml"), grid).unwrap();
    std::fs::create_dir_all(folder.join("scenes")).unwrap();
    assert!(SCENE.contains(from), "{from}");
    std::fs::write(folder.join("scenes/mine.toml"), SCENE.replace(from, to)).unwrap();
}

/// A light map of 16×8 texels.
fn light_map(pixel: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
    let places = (0..8).flat_map(|j| (0..16).map(move |i| (i, j)));
    let pixels = places.map(|(i, j)| pixel(i, j)).collect();
    LinearImage { width: 16, height: 8, pixels }.to_exr().unwrap()
}

const WORDS: &[&str] = &[
    "render",
    "grid.toml",
    "-o",
    "out",
    "--size",
    "32x18",
    "--device",
    "cpu",
    "--select",
    "shutter=T3,samples=A3",
    "--frames",
    "0..1",
];

const MAP: &str = "map = { file = \"sky.exr\" }";
const BUILT_IN: &str = "built-in = \"clear-sky\"";

/// The mean of the lowest rows, where the floor is, in code values.
fn floor(folder: &Path) -> f64 {
    let sequence = Sequence::open(&folder.join("out/M2-S2-T3-A3")).unwrap();
    let image = sequence.read_frame(&sequence.manifest.frames[0]).unwrap();
    let rows = &image.bytes[3 * 32 * 14..];
    rows.iter().map(|&code| f64::from(code)).sum::<f64>() / rows.len() as f64
}

/// Under a map of the same radiance everywhere the floor is its albedo times that radiance: half of ½
/// is the code 137. The folder of sequences holds all that rendering them again needs.
#[test]
fn a_light_map_lights_the_scene_and_travels_with_it() {
    let folder = tempfile::tempdir().unwrap();
    grid_with(folder.path(), BUILT_IN, MAP);
    std::fs::write(folder.path().join("scenes/sky.exr"), light_map(|_, _| [0.5; 3])).unwrap();
    succeed(folder.path(), WORDS);
    assert!((floor(folder.path()) - 137.0).abs() < 1.0, "{}", floor(folder.path()));
    std::fs::remove_dir_all(folder.path().join("scenes")).unwrap();
    std::fs::rename(folder.path().join("out"), folder.path().join("moved")).unwrap();
    let said = succeed(folder.path(), &["validate", "moved", "--device", "cpu"]);
    assert!(said.contains("the same bytes"), "{said}");

    // Light from below is not seen by the floor.
    grid_with(folder.path(), BUILT_IN, MAP);
    let from_below = light_map(|_, j| if j < 4 { [0.0; 3] } else { [0.5; 3] });
    std::fs::write(folder.path().join("scenes/sky.exr"), from_below).unwrap();
    succeed(folder.path(), WORDS);
    assert!(floor(folder.path()) < 1.0, "{}", floor(folder.path()));
}

#[test]
fn scenes_that_cannot_be_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (from, to, expect) in [
        ("albedo = 0.5", "albedo = 1.5", "mine.toml: floor.albedo: 1.5: 0 to 1 is allowed"),
        ("albedo = 0.5", "albdo = 0.5", "line 17: unknown field `albdo`"),
        ("radius_m = 0.1", "radius_m = nan", "sphere.radius_m: NaN"),
        (
            "[0.0, 0.5, 3.0]",
            "[1.0, 0.15, 0.05]",
            "camera.position_m: [1.0, 0.15, 0.05]: the sphere",
        ),
        ("[0.0, 0.5, 3.0]", "[0.0, -0.5, 3.0]", "a place above the floor is needed"),
        ("[0.0, 0.5, 3.0]", "[0.0, 0.1, 0.0]", "another point than camera.look_at_m"),
        ("[0.0, 0.5, 3.0]", "[0.0, 0.5, inf]", "camera.position_m: [0.0, 0.5, inf]: coordinates"),
        (BUILT_IN, MAP, "environment.map.file: sky.exr: "),
        (BUILT_IN, "uniform = [1.0, -1.0, 0.0]", "environment.uniform: [1.0, -1.0, 0.0]"),
    ] {
        grid_with(folder.path(), from, to);
        let error = fail(folder.path(), 1, WORDS);
        assert!(error.contains(expect), "{to}: {error}");
        assert!(!folder.path().join("out").exists(), "{to}");
    }
    grid_with(folder.path(), BUILT_IN, MAP);
    let whole = light_map(|i, j| [i as f32, j as f32, 1.0]);
    for (bytes, expect) in [
        (&whole[..whole.len() / 2], "a whole picture"),
        (b"P6 1 1", "one of the formats"),
        (&light_map(|_, _| [0.0; 3])[..], "radiance: 0 everywhere: a light map needs"),
        (&light_map(|_, _| [f32::NAN; 3])[..], "finite numbers are needed"),
    ] {
        std::fs::write(folder.path().join("scenes/sky.exr"), bytes).unwrap();
        let error = fail(folder.path(), 1, WORDS);
        assert!(error.contains("scenes/sky.exr: ") && error.contains(expect), "{error}");
        assert!(!folder.path().join("out").exists());
    }
    std::fs::remove_file(folder.path().join("scenes/mine.toml")).unwrap();
    let error = fail(folder.path(), 1, WORDS);
    assert!(error.contains("mine.toml: neither a file nor one of the shipped scenes"), "{error}");
}
