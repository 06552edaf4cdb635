//! Bad input of every kind: one error line that names the file, the field, the value and what was
//! allowed; exit status 2 for wrong words, 1 for bad files; nothing half-written that looks whole.

use crate::support::{copy_stimuli, fail, small_stimuli, succeed, tree};
use std::path::Path;

fn in_folder(check: impl FnOnce(&Path)) {
    let folder = tempfile::tempdir().unwrap();
    check(folder.path());
}

#[test]
fn words_that_name_nothing() {
    in_folder(|folder| {
        let render =
            |more: &[&str]| fail(folder, 2, &[&["render", "demo", "-o", "out"], more].concat());
        for (words, expect) in [
            (
                &["--select", "shuter=T5"] as &[&str],
                "shuter: the axes are material, speed, shutter, samples; did you mean shutter?",
            ),
            (&["--select", "shutter=T9"], "shutter=T9: the levels of shutter are T3, T4, T5"),
            (&["--select", "shutter"], "shutter: AXIS=LEVEL is needed"),
            (&["--size", "0x90"], "0x90"),
            (&["--size", "big"], "640x360"),
            (&["--frames", "20..99"], "20..99: a range of at least one frame within 0..24"),
            (&["--frames", "5..5"], "5..5"),
            (&["--frames", "7"], "58..60"),
            (&["--device", "abacus"], "abacus"),
        ] {
            let error = render(words);
            assert!(error.contains(expect), "{words:?}: {error}");
        }
        let error = fail(folder, 2, &["render", "nowhere.toml", "-o", "out"]);
        assert!(
            error.contains("nowhere.toml: neither a file nor one of the shipped grids"),
            "{error}"
        );
        assert!(tree(folder).is_empty(), "{:?}", tree(folder).keys());
    });
}

#[test]
fn grids_with_a_wrong_value() {
    let demo = include_str!("../stimuli/grids/demo.toml");
    for (from, to, expect) in [
        ("frames = 24", "frames = 0", "image.frames: 0: 1 to 9999 frames are allowed"),
        ("width_px = 160", "width_px = 0", "image.width_px: 0"),
        ("width_px", "widht_px", "line 16: unknown field `widht_px`"),
        ("width_px", "widht_px", "did you mean `width_px`?"),
        ("[axes.samples]", "[axes.sample]", "did you mean `samples`?"),
        ("A3 = 256", "A3 = 0", "axes.samples.A3: 0"),
        ("A3 = 256", "A3 = 1000000000", "axes.samples.A3: 1000000000: 1 to 1048576"),
        ("light = 0.8", "light = 1.5", "materials.checker.light: 1.5: a reflectance is 0 to 1"),
        ("A3 = 256", "A3 = -4", "line 44: invalid value: integer `-4`"),
        ("T5 = 1.0", "T5 = 1.5", "axes.shutter_open_fraction.T5: 1.5: 0 to 1"),
        (
            "M2 = \"checker\"",
            "M2 = \"chequer\"",
            "axes.material.M2: chequer: the grid's materials are checker",
        ),
        ("cells = 8", "cells = 7", "materials.checker.cells: 7"),
        ("schema = 1", "schema = 2", "schema: 2: this version reads schema 1"),
        (
            "scene = \"rolling-sphere\"",
            "scene = \"rolling-cube\"",
            "rolling-cube: neither a file nor one of the shipped scenes: rolling-sphere",
        ),
        ("seed = 2012", "seed = ", "line"),
        ("\"sobol\"", "\"halton\"", "unknown variant `halton`, expected one of `random`"),
        ("\"sobol\"", "\"stratified\"", "sampling: nested: the sampler stratified needs to know"),
        (
            "[image]",
            "[shutter_profile]\nkind = \"box\"\nramp = 0.1\n[image]",
            "unknown field `ramp`",
        ),
        ("seed = 2012", "seed = 2012\nexemplars = 0", "exemplars: 0: 1 to 1000 are allowed"),
        (
            "[image]",
            "[shutter_profile]\nkind = \"trapezoid\"\nramp_fraction = 0.6\n[image]",
            "shutter_profile.ramp_fraction: 0.6: above 0 to 0.5",
        ),
        (
            "[image]",
            "[shutter_profile]\nkind = \"gaussian\"\nsigma_fraction = 0.0\n[image]",
            "shutter_profile.sigma_fraction: 0: 0.01 to 10",
        ),
        (
            "[image]",
            "[stereo]\ninterocular_mm = -3.0\nconvergence = \"toe-in\"\nnoise = \"shared\"\n\
             layout = \"anaglyph\"\n[image]",
            "stereo.interocular_mm: -3: 0 to 1000 mm",
        ),
        ("image_width_deg = 14.4", "", "viewing: neither: either image_width_deg or display"),
        ("T3 = 0.5", "\"../T3\" = 0.5", "letters and digits"),
        (
            "T3 = 0.5",
            "TheShutterIsOpenForHalfTheFrameTi = 0.5",
            "axes.shutter_open_fraction: \"TheShutterIsOpenForHalfTheFrameTi\": 1 to 32 letters",
        ),
        ("\"demo\"", "\"\"", "grid.toml: name: \"\": 1 to 64 printable characters"),
        ("\"demo\"", "\"demo \"", "grid.toml: name: \"demo \": 1 to 64 printable"),
        (
            "image_width_deg = 14.4",
            "display = { width_cm = 50.0, resolution_px = [1920, 80], distance_cm = 70.0 }",
            "image.height_px: 90: at most the 80 pixels of viewing.display.resolution_px",
        ),
    ] {
        in_folder(|folder| {
            assert!(demo.contains(from), "{from}");
            std::fs::write(folder.join("grid.toml"), demo.replacen(from, to, 1)).unwrap();
            let error = fail(folder, 1, &["render", "grid.toml", "-o", "out"]);
            assert!(error.contains(expect), "{to}: {error}");
            assert!(!folder.join("out").exists(), "{to}");
        });
    }
}

#[test]
fn an_output_folder_under_a_regular_file() {
    in_folder(|folder| {
        std::fs::write(folder.join("plain"), "text").unwrap();
        let error = fail(
            folder,
            1,
            &["render", "demo", "-o", "plain/out", "--size", "16x9", "--device", "cpu"],
        );
        assert!(error.contains("plain/out"), "{error}");
        assert_eq!(std::fs::read(folder.join("plain")).unwrap(), b"text");
    });
}

/// A simulated session with the stimuli in the folder `s`.
const SIMULATED_SESSION: &[&str] = &[
    "run",
    "demo",
    "--stimuli",
    "s",
    "--study",
    "study",
    "--participant",
    "P1",
    "--observer",
    "simulated:guess",
];

#[test]
fn damaged_stimuli_are_refused_by_name() {
    in_folder(|folder| {
        copy_stimuli(&folder.join("s"));
        let manifest = folder.join("s/M2-S2-T4-A4/sequence.json");
        let text = std::fs::read(&manifest).unwrap();
        std::fs::write(&manifest, &text[..text.len() / 2]).unwrap();
        let error = fail(folder, 1, SIMULATED_SESSION);
        assert!(error.contains("M2-S2-T4-A4/sequence.json: not a whole manifest"), "{error}");
        // `render` does not take it for finished either, nor does it overwrite it.
        let error =
            fail(folder, 1, &["render", "demo", "-o", "s", "--size", "16x9", "--device", "cpu"]);
        assert!(
            error.contains("M2-S2-T4-A4/sequence.json") && error.contains("remove its folder"),
            "{error}"
        );
    });
    in_folder(|folder| {
        copy_stimuli(&folder.join("s"));
        // The middle frame becomes the thumbnail.
        let frame = folder.join("s/M2-S2-T3-A3/frame-0012.png");
        let bytes = std::fs::read(&frame).unwrap();
        std::fs::write(&frame, &bytes[..bytes.len() / 2]).unwrap();
        let error = fail(folder, 1, SIMULATED_SESSION);
        assert!(error.contains("frame-0012.png: not a whole PNG"), "{error}");
        let other = std::fs::read(folder.join("s/M2-S2-T5-A3/frame-0012.png")).unwrap();
        std::fs::write(&frame, other).unwrap();
        let error = fail(folder, 1, SIMULATED_SESSION);
        assert!(error.contains("frame-0012.png: its pixels hash to"), "{error}");
    });
    in_folder(|folder| {
        copy_stimuli(&folder.join("s"));
        std::fs::remove_dir_all(folder.join("s/M2-S2-T5-A5")).unwrap();
        let error = fail(folder, 1, SIMULATED_SESSION);
        assert!(error.contains("T5") && error.contains("A5"), "{error}");
    });
}

#[test]
fn participants_are_codes() {
    in_folder(|folder| {
        for code in ["../up", "a/b", "Ada Lovelace", "ada@lab.org", ""] {
            let stimuli = small_stimuli().display().to_string();
            let args = [
                "run",
                "demo",
                "--stimuli",
                &stimuli,
                "--study",
                "study",
                "--participant",
                code,
                "--observer",
                "simulated:guess",
            ];
            let error = fail(folder, 2, &args);
            assert!(error.contains(code) && error.contains("'--participant"), "{code}: {error}");
        }
        assert!(tree(folder).is_empty());
    });
}

#[test]
fn vote_tables_that_cannot_be() {
    for (text, expect) in [
        ("item,count\nA,1\nB,2\n", "votes.csv: column `votes` is missing"),
        ("item,votes\nA,-1\nB,2\n", "votes.csv: line 2: votes of `A`: `-1`"),
        ("item,votes\nA,1.5\nB,2\n", "votes.csv: line 2: votes of `A`: `1.5`"),
        ("item,votes\nA,5\nB,6\n", "their sum is 11"),
        ("item,votes\nA,5\nA,5\n", "each item may come once"),
        ("\u{0}\u{1}\u{2}", "votes.csv: column"),
    ] {
        in_folder(|folder| {
            std::fs::write(folder.join("votes.csv"), text).unwrap();
            let error = fail(
                folder,
                1,
                &["analyze", "--votes", "votes.csv", "--observers", "10", "-o", "out"],
            );
            assert!(error.contains(expect), "{text:?}: {error}");
            assert!(!folder.join("out").exists());
        });
    }
    in_folder(|folder| {
        let error = fail(folder, 1, &["analyze", "--votes", "none.csv", "--observers", "10"]);
        assert!(error.contains("none.csv: cannot be read"), "{error}");
        let error = fail(folder, 2, &["analyze", "--votes", "none.csv"]);
        assert!(error.contains("--observers"), "{error}");
        let error = fail(folder, 1, &["analyze", "nothing-here"]);
        assert!(error.contains("nothing-here"), "{error}");
    });
}

/// Whatever has happened to a data file, a session that would go on from it loses nothing and says
/// what is wrong.
#[test]
fn data_files_that_were_meddled_with() {
    let stimuli = small_stimuli().display().to_string();
    let run = |code| {
        let study = ["run", "demo", "--stimuli", &stimuli, "--study", "study"];
        [study.as_slice(), &["--participant", code, "--observer", "simulated:guess"]].concat()
    };
    in_folder(|folder| {
        succeed(folder, &run("P1"));
        let file =
            folder.join("study/simulated/data/study-demo_subject-P1_session-1_task-2afc_data.csv");
        let whole = std::fs::read_to_string(&file).unwrap();
        let lines: Vec<&str> = whole.lines().collect();
        let joined = whole.replacen(&format!("{}\n", lines[3]), lines[3], 1);
        let doubled = whole.replacen(lines[4], &format!("{}\n{}", lines[4], lines[4]), 1);
        let columns = lines[0].split(',').count();
        // Of two rows run together, the last field of one and the first of the other are one.
        let joined_fields = format!("line 4: {} fields: {columns} are needed", 2 * columns - 1);
        for (text, expect) in [(joined, joined_fields), (doubled, "trial 4: is there twice".into())]
        {
            std::fs::write(&file, &text).unwrap();
            let error = fail(folder, 1, &run("P1"));
            assert!(error.contains(&expect), "{error}");
            assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
        }
        let error = fail(folder, 1, &run("p1"));
        assert!(error.contains("code: P1, now p1"), "{error}");
    });
}

#[test]
fn sequences_that_were_meddled_with() {
    let render = [
        "render",
        "demo",
        "-o",
        "s",
        "--size",
        "16x9",
        "--device",
        "cpu",
        "--select",
        "shutter=T3",
    ];
    in_folder(|folder| {
        succeed(folder, &render);
        std::fs::copy(
            folder.join("s/M2-S2-T3-A3/frame-0001.png"),
            folder.join("s/M2-S2-T3-A3/frame-0002.png"),
        )
        .unwrap();
        let error = fail(folder, 1, &render);
        assert!(
            error.contains("frame-0002.png: its pixels hash to")
                && error.contains("remove its folder"),
            "{error}"
        );
        std::fs::remove_file(folder.join("s/M2-S2-T3-A3/frame-0002.png")).unwrap();
        let error = fail(folder, 1, &render);
        assert!(error.contains("frame-0002.png: cannot be read"), "{error}");
    });
    in_folder(|folder| {
        copy_stimuli(&folder.join("s"));
        copy_stimuli(&folder.join("t"));
        std::fs::rename(folder.join("t/M2-S2-T4-A4"), folder.join("s/again")).unwrap();
        let error = fail(folder, 1, SIMULATED_SESSION);
        assert!(error.contains("each stimulus may be compared once"), "{error}");
        assert!(!folder.join("study").exists());
    });
}

/// A full disk in the middle of a render: the frames that were whole stay, no manifest says that the
/// sequence is finished, and the next run goes on.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk() {
    in_folder(|folder| {
        let limited = |limit: &str| {
            let command = format!(
                "ulimit -f {limit}; trap '' XFSZ; exec \"$0\" render demo -o out --size 160x90 --device cpu --select shutter=T3,samples=A3 --frames 0..2"
            );
            let output = std::process::Command::new("bash")
                .args(["-c", &command, env!("CARGO_BIN_EXE_shutterlab")])
                .current_dir(folder)
                .output()
                .unwrap();
            (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
        };
        // Files of at most 4 KiB: a frame of 160×90 pixels needs more.
        let (status, stderr) = limited("4");
        assert_eq!(status, Some(1), "{stderr}");
        assert!(
            stderr.contains("error: ") && stderr.contains("frame-0000.png: File too large"),
            "{stderr}"
        );
        let left = tree(folder);
        assert!(
            left.keys().all(|name| !name.ends_with("sequence.json")
                && name.extension().is_none_or(|e| e != "png"))
        );
        assert!(
            left.keys().all(|name| !name.to_string_lossy().ends_with(".partial")),
            "{:?}",
            left.keys()
        );
        let (status, stderr) = limited("unlimited");
        assert_eq!(status, Some(0), "{stderr}");
    });
}
