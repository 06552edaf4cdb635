//! `simplify`: meshes of every format in and out, with what the words ask for.

use crate::support::{fail, run_in, succeed, tree};
use serde_json::Value;
use shutterlab::scene::import;
use shutterlab_stimuli::frames::EncodedImage;
use std::fmt::Write;
use std::path::Path;

/// A sphere of radius 1 with texture coordinates whose half with x > 0 is red; `size` scales it along y.
fn sphere(size: f64) -> String {
    const ROWS: usize = 24;
    const COLUMNS: usize = 48;
    let mut text = String::from("mtllib sphere.mtl\n");
    for row in 0..=ROWS {
        for column in 0..COLUMNS {
            // Not at the poles themselves, where the last row would be one point.
            let up = (row as f64 + 0.05) / (ROWS as f64 + 0.1) * std::f64::consts::PI;
            let around = column as f64 / COLUMNS as f64 * std::f64::consts::TAU;
            let (x, z) = (up.sin() * around.cos(), up.sin() * around.sin());
            writeln!(text, "v {x} {} {z}\nvt {} {}", size * up.cos(), x * 0.5, z * 0.5).unwrap();
        }
    }
    let vertex = |row: usize, column: usize| {
        let index = 1 + row * COLUMNS + column % COLUMNS;
        format!("{index}/{index}")
    };
    for half in ["white", "red"] {
        writeln!(text, "usemtl {half}").unwrap();
        for column in 0..COLUMNS {
            let is_red = !(COLUMNS / 4..COLUMNS * 3 / 4).contains(&column);
            for row in (0..ROWS).filter(|_| is_red == (half == "red")) {
                let [a, b] = [column, column + 1].map(|column| vertex(row, column));
                let [c, d] = [column + 1, column].map(|column| vertex(row + 1, column));
                writeln!(text, "f {a} {b} {c} {d}").unwrap();
            }
        }
    }
    text
}

const FACES: u64 = 2 * 24 * 48;

/// A folder with the sphere, its materials and a tetrahedron.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("sphere.obj", &sphere(1.0));
    write("sphere.mtl", "newmtl white\nKd 1 1 1\nnewmtl red\nKd 1 0 0\n");
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    write("tetrahedron.obj", tetrahedron);
    folder
}

/// The JSON that `simplify` prints of the sphere with `words`.
fn json(folder: &Path, words: &[&str]) -> Value {
    let words = [&["simplify", "sphere.obj", "-o", "out.ply", "--json"], words].concat();
    serde_json::from_str(&succeed(folder, &words)).unwrap()
}

/// How many faces it leaves.
fn faces_after(folder: &Path, words: &[&str]) -> usize {
    succeed(folder, &[&["simplify", "sphere.obj", "-o", "out.ply"], words].concat());
    import::model(&folder.join("out.ply")).unwrap().mesh.triangles.len()
}

#[test]
fn every_format_goes_in_and_out() {
    let folder = folder();
    let folder = folder.path();
    let mut from = "sphere.obj".to_string();
    for (ending, faces) in [("ply", 1200), ("gltf", 1000), ("stl", 800), ("glb", 600), ("obj", 400)]
    {
        let to = format!("out.{ending}");
        succeed(folder, &["simplify", &from, "-o", &to, "--faces", &faces.to_string()]);
        let mesh = import::model(&folder.join(&to)).unwrap().mesh;
        assert!(
            (faces - 10..=faces).contains(&mesh.triangles.len()),
            "{to}: {}",
            mesh.triangles.len()
        );
        succeed(folder, &["validate", &to]);
        from = to;
    }
    let names: Vec<_> = tree(folder).into_keys().collect();
    let expected =
        ["out.bin", "out.glb", "out.gltf", "out.obj", "out.ply", "out.stl", "sphere.mtl"];
    assert_eq!(names[..7], expected.map(std::path::PathBuf::from));
}

#[test]
fn the_goals_are_reached() {
    let folder = folder();
    let folder = folder.path();
    let report = json(folder, &["--ratio", "0.25"]);
    let after = report["after"]["faces"].as_u64().unwrap();
    assert!((FACES / 4 - 10..=FACES / 4).contains(&after), "{after}");
    assert_eq!(report["before"]["faces"], FACES);
    assert_eq!(report["asked"]["faces"], FACES / 4);
    assert_eq!(report["goal_reached"], true);
    for when in ["before", "after"] {
        let of = &report[when];
        assert_eq!((&of["shells"], &of["non_manifold_edges"]), (&1.into(), &0.into()), "{of}");
    }
    let number = |of: &Value, key: &str| of[key].as_f64().unwrap();
    let (distance, relative) = (&report["distance"], &report["distance_of_diagonal"]);
    let [mean, rms, most] = ["mean", "rms", "hausdorff"].map(|key| number(distance, key));
    assert!(0.0 < mean && mean < rms && rms < most && most < 0.1, "{distance}");
    let diagonal = number(&report, "diagonal");
    assert!((diagonal - 12.0_f64.sqrt()).abs() < 0.02, "{diagonal}");
    assert!((number(relative, "rms") * diagonal / rms - 1.0).abs() < 1e-9);
    assert_eq!(report["left_out"], serde_json::json!(["materials"]));

    // A larger error leaves fewer faces; the percentage is of the diagonal.
    let counts = ["0.0001", "0.001", "0.01"].map(|error| faces_after(folder, &["--error", error]));
    assert!(counts[0] > counts[1] && counts[1] > counts[2] && counts[2] > 8, "{counts:?}");
    let part = 100.0 * 0.001 / diagonal;
    assert_eq!(faces_after(folder, &["--error", &format!("{part}%")]), counts[1]);
}

#[test]
fn what_cannot_be_reached_is_said() {
    let folder = folder();
    let words = ["simplify", "tetrahedron.obj", "-o", "out.stl", "--faces", "1"];
    let output = run_in(folder.path(), &words);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("out.stl: 4 faces, and 1 asked for"), "{stderr}");
    let report = succeed(folder.path(), &[&words[..], &["--json"]].concat());
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!((&report["goal_reached"], &report["after"]["faces"]), (&false.into(), &4.into()));
}

#[test]
fn faces_keep_their_materials() {
    let folder = folder();
    succeed(folder.path(), &["simplify", "sphere.obj", "-o", "out.glb", "--faces", "500"]);
    let model = import::model(&folder.path().join("out.glb")).unwrap();
    let mesh = &model.mesh;
    let coordinates = mesh.texture_coordinates.as_ref().unwrap();
    for (triangle, &material) in mesh.triangles.iter().zip(&model.face_materials) {
        let middle = mesh.corners(*triangle, 0.0).iter().map(|corner| corner.x).sum::<f32>() / 3.0;
        let is_red = model.materials[material as usize].base_color.y == 0.0;
        assert!(middle.abs() < 1e-3 || is_red == (middle > 0.0), "{middle}");
        for &vertex in triangle {
            let [at, position] = [coordinates[vertex as usize], {
                let p = mesh.positions[vertex as usize];
                glam::Vec2::new(p.x, p.z) * 0.5
            }];
            assert!(at.distance(position) < 0.05, "{at} {position}");
        }
    }
}

/// Without another goal a motion brings the published law, or that of a file.
#[test]
fn a_motion_and_a_law_are_a_goal() {
    let folder = folder();
    let folder = folder.path();
    let moving = |speed| ["--motion", "x", "--speed", speed];
    let [slow, fast] = ["20", "60"].map(|speed| faces_after(folder, &moving(speed)));
    assert!(fast < slow && slow < FACES as usize, "{fast} {slow}");
    let weighed =
        json(folder, &[&moving("2")[..], &["--faces", "500", "--weight", "printed"]].concat());
    let expected = serde_json::json!({ "kind": "printed", "r": 4.0, "epsilon": 0.5 });
    assert_eq!(weighed["asked"]["weight"], expected);
    assert_eq!(weighed["asked"]["largest_perimeter"], Value::Null);

    let head = "schema = 1\nprogram_version = \"0\"\n[fitted_to]\nsource = \"a\"\nmodels = []\n";
    let law = "[law]\nsigma_1 = { value = 73.0 }\nsigma_2 = { value = 3.6 }\nvelocity_unit = \
               \"pixels-per-shutter\"\nfrequency_unit = \"per-perimeter-pixel\"\n";
    std::fs::write(folder.join("law.toml"), format!("{head}{law}")).unwrap();
    let own = faces_after(folder, &[&moving("6")[..], &["--parameters", "law.toml"]].concat());
    assert!(own < (fast + slow) / 2, "{own} {fast} {slow}");
    std::fs::write(folder.join("r.toml"), format!("{head}[weight]\nr = 2.0\n")).unwrap();
    let words = ["--weight", "mirrored", "--epsilon", "0.25", "--parameters", "r.toml"];
    let own = json(folder, &[&moving("2")[..], &words].concat());
    let expected = serde_json::json!({ "kind": "mirrored", "r": 2.0, "epsilon": 0.25 });
    assert_eq!(own["asked"]["weight"], expected);
    let limit = &own["asked"]["largest_perimeter"];
    assert!((limit["px_per_px_per_shutter"].as_f64().unwrap() - 7.3).abs() < 1e-6, "{limit}");
}

/// A model that deforms becomes two models with the same faces, which a scene can take.
#[test]
fn both_poses_are_written() {
    let folder = folder();
    let folder = folder.path();
    std::fs::write(folder.join("end.obj"), sphere(2.0)).unwrap();
    let words =
        ["--end-mesh", "end.obj", "--faces", "400", "-o", "out.obj", "--end-out", "out2.obj"];
    succeed(folder, &[&["simplify", "sphere.obj"], &words[..]].concat());
    let first = import::model(&folder.join("out.obj")).unwrap().mesh;
    let second = import::second_pose(&folder.join("out2.obj"), &first).unwrap();
    for (start, end) in first.positions.iter().zip(second) {
        assert!(
            (end.y - 2.0 * start.y).abs() < 0.1 && (end.x - start.x).abs() < 0.1,
            "{start} {end}"
        );
    }
}

#[test]
fn both_are_drawn_side_by_side() {
    let folder = folder();
    let words = ["sphere.obj", "-o", "out.ply", "--faces", "300", "--picture", "out.png"];
    succeed(folder.path(), &[&["simplify"], &words[..]].concat());
    let picture = EncodedImage::read_png(&folder.path().join("out.png")).unwrap();
    // The sphere's red half in the left and in the right panel.
    let is_red = |x: u32| {
        let at = 3 * (picture.height / 4 * picture.width + x) as usize;
        let [r, g, _] = [0, 1, 2].map(|channel| picture.bytes[at + channel]);
        r > 100 && g < 50
    };
    let quarter = picture.width / 4;
    for middle in [quarter, 3 * quarter] {
        assert!(is_red(middle + quarter / 3) && !is_red(middle - quarter / 3), "{middle}");
    }
}

#[test]
fn wrong_words_are_told() {
    let folder = folder();
    let folder = folder.path();
    let before = tree(folder);
    let motion = ["--motion", "x", "--speed", "10"];
    let with_motion = |words: &[&'static str]| [&motion[..], words].concat();
    for (words, expected) in [
        (vec![], "one of --faces, --ratio, --error and --motion is needed"),
        (vec!["--faces", "0"], "a whole number from 1 is needed"),
        (vec!["--faces", "-5"], "a whole number from 1 is needed"),
        (vec!["--faces", "10", "--ratio", "0.5"], "cannot be used with"),
        (vec!["--ratio", "0"], "a number above 0 and up to 1 is needed"),
        (vec!["--ratio", "1.5"], "a number above 0 and up to 1 is needed"),
        (vec!["--ratio", "nan"], "a number above 0 and up to 1 is needed"),
        (vec!["--error", "-1"], "a number from 0 to 1e9 is needed, or a percentage such as 0.1%"),
        (vec!["--error", "NaN%"], "a number from 0 to 1e9 is needed"),
        (vec!["--faces", "9", "--weight", "mirrored"], "--motion is needed"),
        (
            vec!["--faces", "9", "--r", "4"],
            "--r and --epsilon are of --weight printed and mirrored",
        ),
        (vec!["--faces", "9", "--end-out", "a.ply"], "--end-out: the model does not deform"),
        (vec!["--faces", "9", "--picture", "a.jpg"], "--picture: a.jpg: it ends in .png"),
        (vec!["--faces", "9", "--picture", "sphere.mtl"], "sphere.mtl: it ends in .png"),
        (vec!["--faces", "9", "--attributes", "none"], "one of quadrics, averaged is needed"),
        (with_motion(&["--weight", "sideways"]), "one of isotropic, printed, mirrored is needed"),
        (with_motion(&["--r", "-1"]), "a number from 0 to 1000000 is needed"),
        (with_motion(&["--epsilon", "-0.1"]), "a number from 0 to 1000000 is needed"),
        (with_motion(&["--r", "0", "--epsilon", "0"]), "--epsilon: 0: above 0 where r is 0"),
        (with_motion(&["--end-out", "a.stl", "--end-mesh", "sphere.obj"]), "not .stl"),
    ] {
        let all = [&["simplify", "sphere.obj", "-o", "out.ply"], &words[..]].concat();
        let error = fail(folder, 2, &all);
        assert!(error.contains(expected), "{words:?}: {error}");
    }
    for (out, expected) in [
        ("sphere.obj", "sphere.obj: it is read or written already: another name is needed"),
        ("./sphere.obj", "sphere.obj: it is read or written already"),
        ("Sphere.off", "Sphere.off: ending: off: models are written as"),
        (".", "the name of a file, in UTF-8, is needed"),
    ] {
        let error = fail(folder, 2, &["simplify", "sphere.obj", "-o", out, "--faces", "9"]);
        assert!(error.contains(expected), "{out}: {error}");
    }
    assert_eq!(tree(folder), before);
}

#[test]
fn bad_files_are_told() {
    let folder = folder();
    let folder = folder.path();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("none.obj", "v 0 0 0\n");
    // Its library has the name that the output's would have.
    write("library.obj", "mtllib out.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("out.mtl", "newmtl a\n");
    write("parameters.toml", "schema = 2\n");
    let before = tree(folder);
    for (status, words, expected) in [
        (1, ["missing.ply", "-o", "out.ply", "--faces", "9"], "missing.ply: cannot be read: "),
        (
            1,
            ["nan.obj", "-o", "out.ply", "--faces", "9"],
            "nan.obj: position of vertex 0: [0, 0, NaN]",
        ),
        (1, ["none.obj", "-o", "out.ply", "--faces", "9"], "none.obj: vertices: 0: 1 to"),
        (1, ["sphere.obj", "-o", "no/out.ply", "--faces", "9"], "no: an existing folder is needed"),
        (1, ["out.mtl", "-o", "out.ply", "--faces", "9"], "out.mtl: ending: mtl: models are"),
        (
            2,
            ["library.obj", "-o", "out.obj", "--faces", "9"],
            "out.mtl: it is read or written already",
        ),
    ] {
        let error = fail(folder, status, &[&["simplify"], &words[..]].concat());
        assert!(error.contains(expected), "{words:?}: {error}");
    }
    let moving = ["simplify", "sphere.obj", "-o", "out.ply", "--motion", "x", "--speed", "1"];
    let error = fail(folder, 1, &[&moving[..], &["--parameters", "parameters.toml"]].concat());
    assert!(error.contains("parameters.toml"), "{error}");
    assert_eq!(tree(folder), before);
}
