//! Scenes in files of one's own, and the light maps that they name.

use crate::support::{fail, succeed, tree};
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

/// A manifest tells of a lens where there is one, and of none where there is not, as it did before there were any.
#[test]
fn manifests_name_the_lens() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = |to: &str| {
        grid_with(folder.path(), "focal_length_mm", to);
        succeed(folder.path(), WORDS);
        std::fs::read_to_string(folder.path().join("out/M2-S2-T3-A3/sequence.json")).unwrap()
    };
    let pinhole = manifest("focal_length_mm");
    assert!(!pinhole.contains("aperture") && !pinhole.contains("focus_distance"), "{pinhole}");
    std::fs::remove_dir_all(folder.path().join("out")).unwrap();
    let lens = manifest("aperture_f_number = 0.5\nfocal_length_mm");
    assert!(lens.contains("\"aperture_f_number\": 0.5"), "{lens}");
    let frames = |text: &str| text.split("\"frames\"").nth(1).map(str::to_string);
    assert_ne!(frames(&pinhole), frames(&lens));
}

#[test]
fn scenes_that_cannot_be_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (from, to, expect) in [
        (
            "albedo = [0.5",
            "albedo = [1.5",
            "mine.toml: objects[1].material.albedo: 1.5: a reflectance is 0 to 1",
        ),
        ("albedo = [0.5", "albdo = [0.5", "line 29: unknown field `albdo`"),
        (
            "focal_length_mm",
            "aperture_f_number = 0.0\nfocal_length_mm",
            "camera.aperture_f_number: 0: f-numbers of 0.01 to 1000000 are allowed",
        ),
        (
            "focal_length_mm",
            "aperture_f_number = 2.0\nfocus_distance_m = -1.0\nfocal_length_mm",
            "camera.focus_distance_m: -1: 0.01 to 1000000 m are allowed",
        ),
        (
            "focal_length_mm",
            "focus_distance_m = 1.0\nfocal_length_mm",
            "camera.focus_distance_m: 1: only with camera.aperture_f_number",
        ),
        ("radius_m = 0.1", "radius_m = nan", "objects[0].shape.radius_m: NaN"),
        (
            "[0.0, 0.5, 3.0]",
            "[1.0, 0.15, 0.05]",
            "camera.position_m: [1.0, 0.15, 0.05]: the sphere",
        ),
        (
            "translation = [1.0, 0.0, 0.0]",
            "translation = [0.0, 0.0, 0.0]",
            "objects[0].motion.translation: [0.0, 0.0, 0.0]: a vector whose largest component",
        ),
        (
            "translation = [1.0, 0.0, 0.0]",
            "translation = [1.0, 0.0, 1.0]",
            "trajectory: wrap: sphere does not move straight across the view: once is allowed",
        ),
        (
            "[objects.motion]",
            "[objects.motion]\ndeformation = { file = \"a.ply\", distance_m = 1.0 }",
            "objects[0].motion.deformation.file: a.ply: only a mesh has poses",
        ),
        (
            "kind = \"sphere\",",
            "kind = \"mesh\", file = \"none.ply\",",
            "objects[0].shape.file: none.ply: ",
        ),
        (
            "[0.5, 0.5, 0.5] }",
            "[0.5, 0.5, 0.5], coat = { kind = \"metal\", roughness = 0 } }",
            "objects[1].material.coat.roughness: 0: 0.02 to 1 is allowed",
        ),
        (
            "kind = \"constant\", albedo = [0.5, 0.5, 0.5]",
            "kind = \"model\"",
            "objects[1].material.kind: model: only a mesh has a model's file",
        ),
        (
            "[[objects]]\nname = \"sphere\"",
            "[[lights]]\nkind = \"directional\"\ndirection = [0, 0, 0]\nirradiance = [1, 1, 1]\n\
             [[objects]]\nname = \"sphere\"",
            "lights[0].direction: [0.0, 0.0, 0.0]: a vector whose largest component",
        ),
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

/// A square in the xy-plane, textured by `red.png` through a library of materials.
fn textured_square(folder: &Path) {
    let red = image::RgbImage::from_pixel(2, 2, image::Rgb([255, 0, 0]));
    red.save(folder.join("red.png")).unwrap();
    std::fs::write(folder.join("square.mtl"), "newmtl red\nmap_Kd red.png\n").unwrap();
    let square = "mtllib square.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n\
                  vt 0 0\nusemtl red\nf 1/1 2/1 3/1 4/1\n";
    std::fs::write(folder.join("square.obj"), square).unwrap();
}

const MESH: &str = "kind = \"mesh\", file = \"square.obj\",";

/// A model with its library and picture is seen in its colours; and the folder of sequences alone is enough
/// to render it again.
#[test]
fn a_model_travels_with_its_sequences() {
    let folder = tempfile::tempdir().unwrap();
    let own = format!("material = {{ kind = \"model\" }}\nshape = {{ {MESH}");
    grid_with(folder.path(), "shape = { kind = \"sphere\",", &own);
    textured_square(&folder.path().join("scenes"));
    succeed(folder.path(), WORDS);
    std::fs::rename(folder.path().join("out"), folder.path().join("moved")).unwrap();
    std::fs::remove_dir_all(folder.path().join("scenes")).unwrap();
    let found = succeed(folder.path(), &["validate", "moved", "--device", "cpu"]);
    assert!(found.contains("the same bytes"), "{found}");
    let sequence = Sequence::open(&folder.path().join("moved/M2-S2-T3-A3")).unwrap();
    let image = sequence.read_frame(&sequence.manifest.frames[0]).unwrap();
    // From within a sequence, too.
    let inside = folder.path().join("moved/M2-S2-T3-A3");
    let found = succeed(&inside, &["validate", ".", "--device", "cpu"]);
    assert!(found.contains("the same bytes"), "{found}");
    let model = tree(&folder.path().join("moved/assets"))
        .into_keys()
        .find(|file| file.ends_with("square.mtl"))
        .unwrap();
    let model = folder.path().join("moved/assets").join(model);
    std::fs::write(&model, "newmtl red\nKd 0 1 0\n").unwrap();
    let error = fail(folder.path(), 1, &["validate", "moved", "--device", "cpu"]);
    assert!(error.contains("square.obj: it hashes to"), "{error}");
    std::fs::rename(inside.join("sequence.json"), inside.join("unfinished.json")).unwrap();
    let error = fail(folder.path(), 1, &["validate", "moved", "--device", "cpu"]);
    assert!(error.contains("M2-S2-T3-A3: unfinished: the same `render` command"), "{error}");
    std::fs::rename(inside.join("unfinished.json"), inside.join("sequence.json")).unwrap();
    let is_red = |pixel: &[u8]| pixel[0] > 60 && pixel[1] < 20 && pixel[2] < 20;
    assert!(image.bytes.chunks(3).any(is_red));
}

#[test]
fn models_that_cannot_be_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    grid_with(folder.path(), "kind = \"sphere\",", MESH);
    let square = |text: &str| {
        std::fs::write(folder.path().join("scenes/square.obj"), text).unwrap();
        let error = fail(folder.path(), 1, WORDS);
        assert!(!folder.path().join("out").exists(), "{text}");
        error
    };
    for (text, expect) in [
        ("v 0 0 0\n", "scenes/square.obj: vertices: 0: 1 to"),
        (
            "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            "scenes/square.obj: position of vertex 0: [0, 0, NaN]",
        ),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "scenes/square.obj: line 4"),
        ("", "scenes/square.obj: vertices: 0"),
    ] {
        let error = square(text);
        assert!(error.contains(expect), "{text}: {error}");
    }
    // A file of another kind is told of, too, before anything is written.
    textured_square(&folder.path().join("scenes"));
    grid_with(folder.path(), "kind = \"sphere\",", "kind = \"mesh\", file = \"red.png\",");
    assert!(fail(folder.path(), 1, WORDS).contains("scenes/red.png: ending: png: models are"));
    grid_with(folder.path(), BUILT_IN, "map = { file = \"red.png\" }");
    assert!(fail(folder.path(), 1, WORDS).contains("scenes/red.png: first bytes"));
    assert!(!folder.path().join("out").exists());
    // Without a radius it is not known when it has left the view.
    grid_with(folder.path(), "kind = \"sphere\", radius_m = 0.1", MESH.trim_end_matches(','));
    let error = square("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(error.contains("trajectory: wrap: sphere has no shape.radius_m"), "{error}");
}

#[test]
fn the_scene_of_the_guide_holds() {
    let guide = include_str!("../docs/guide/scenes.md");
    let example = guide.split("```").nth(1).unwrap().trim_start_matches("toml");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("guide.toml"), example).unwrap();
    let found = succeed(folder.path(), &["validate", "guide.toml"]);
    assert!(found.contains("scene turning-wheel"), "{found}");
}
