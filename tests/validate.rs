//! `validate`: whatever is not what it says is found, and what is passes.

use crate::support::{copy_stimuli, fail, run_in, succeed};

#[test]
fn whole_sequences_grids_and_protocols_pass() {
    let folder = tempfile::tempdir().unwrap();
    copy_stimuli(&folder.path().join("s"));
    let grid = include_str!("../stimuli/grids/rolling-sphere-stereo.toml");
    let protocol = include_str!("../experiments/protocols/demo.toml");
    std::fs::write(folder.path().join("grid.toml"), grid).unwrap();
    std::fs::write(folder.path().join("protocol.toml"), protocol).unwrap();
    std::fs::write(
        folder.path().join("two.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n",
    )
    .unwrap();
    let scene = include_str!("../stimuli/scenes/rolling-sphere.toml");
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let files = ["grid.toml", "protocol.toml", "two.obj", "scene.toml"];
    let words = [&["validate", "s"], files.as_slice(), &["--device", "cpu"]].concat();
    let said = succeed(folder.path(), &words);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 13, "{said}");
    assert!(lines[12].ends_with("scene rolling-sphere"), "{said}");
    assert!(lines[11].ends_with("model, 2 triangles, 4 vertices"), "{said}");
    assert!(
        lines[..9].iter().all(|line| line.ends_with("rendered anew is the same bytes")),
        "{said}"
    );
    assert!(lines[9].ends_with("grid, 225 sequences") && lines[10].ends_with("protocol demo"));
}

/// Of one sequence, as many as can be read.
#[test]
fn all_faults_of_a_sequence_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    copy_stimuli(folder.path());
    for frame in 3..15 {
        let file = format!("M2-S2-T3-A3/frame-{frame:04}.png");
        std::fs::remove_file(folder.path().join(file)).unwrap();
    }
    let output = run_in(folder.path(), &["validate", "M2-S2-T3-A3", "--device", "cpu"]);
    let said = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines.len() == 12 && lines[0] == "M2-S2-T3-A3  NOT VALID", "{said}");
    assert!(lines[1].contains("frame-0003.png") && lines[10].contains("frame-0012.png"), "{said}");
    assert_eq!(lines[11], "  and 2 more faults");
}

/// Each fault is found in its own sequence, the others are still checked, and the exit says so.
#[test]
fn faults_are_found_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    copy_stimuli(&folder.path().join("s"));
    let file = |name: &str| folder.path().join("s").join(name);
    std::fs::remove_file(file("M2-S2-T3-A3/frame-0007.png")).unwrap();
    std::fs::copy(file("M2-S2-T4-A4/frame-0001.png"), file("M2-S2-T4-A4/frame-0002.png")).unwrap();
    // Frames and hashes that fit one another, of another stimulus than the manifest's.
    let manifest = std::fs::read_to_string(file("M2-S2-T5-A5/sequence.json")).unwrap();
    let mut forged: shutterlab_stimuli::Manifest = serde_json::from_str(&manifest).unwrap();
    forged.stimulus.seed += 1;
    forged.sha256 = shutterlab_stimuli::Manifest::hash(&forged.stimulus, &forged.frames);
    forged.write(&file("M2-S2-T5-A5")).unwrap();

    let error = fail(folder.path(), 1, &["validate", "s", "--device", "cpu"]);
    assert!(
        error.contains("3 of 9 not valid; the first: ") && error.contains("frame-0007"),
        "{error}"
    );
    let error = fail(folder.path(), 1, &["validate", "s/M2-S2-T4-A4", "--device", "cpu"]);
    assert!(error.contains("frame-0002.png: its pixels hash to"), "{error}");
    let error = fail(folder.path(), 1, &["validate", "s/M2-S2-T5-A5", "--device", "cpu"]);
    assert!(error.contains("it is not the same bytes"), "{error}");
    for (path, expected) in [
        ("s/M2-S2-T5-A4/frame-0000.png", "frame-0000.png: ending: \"png\": grids, scenes"),
        ("s/M2-S2-T5-A4/sequence.json", "and a sequence or a study by its folder"),
        ("demo", "demo: no such file or folder; a shipped grid needs no check"),
        ("nowhere", "nowhere: cannot be read"),
    ] {
        let error = fail(folder.path(), 1, &["validate", path]);
        assert!(error.contains(expected), "{error}");
    }
    let scene = include_str!("../stimuli/scenes/rolling-sphere.toml").replace("albedo", "albdo");
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let error = fail(folder.path(), 1, &["validate", "scene.toml"]);
    assert!(
        error.contains("scene.toml: line") && error.contains("did you mean `albedo`"),
        "{error}"
    );
    std::fs::write(folder.path().join("no.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let error = fail(folder.path(), 1, &["validate", "no.obj"]);
    assert!(error.contains("no.obj: "), "{error}");
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let error = fail(folder.path(), 1, &["validate", "empty"]);
    assert!(error.contains("empty: holds no sequence"), "{error}");
}
