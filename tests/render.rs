//! `render`: manifests, resuming after `kill -9`, and the same bytes again.

use crate::support::{fail, run_in, shutterlab, small_stimuli, succeed, tree};
use shutterlab_stimuli::Sequence;
use shutterlab_stimuli::frames::EncodedImage;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

const SMALL: [&str; 6] = ["--size", "32x18", "--device", "cpu", "--select", "samples=A3"];

fn render<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "demo", "-o", out], SMALL.as_slice(), more].concat()
}

/// Everything that a render leaves in its sequence folders, without the time it took.
fn pixels_and_manifests(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let without_time = |name: &Path, bytes: Vec<u8>| {
        if !name.ends_with("sequence.json") {
            return bytes;
        }
        let mut manifest: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        manifest.as_object_mut().unwrap().remove("render_seconds");
        manifest.to_string().into_bytes()
    };
    tree(folder)
        .into_iter()
        .filter(|(name, _)| name.components().count() > 1)
        .map(|(name, bytes)| (name.display().to_string(), without_time(&name, bytes)))
        .collect()
}

/// Killed again and again at other moments, a render goes on and ends with the same bytes as one that
/// was left alone, and nothing else in its folders.
#[test]
fn a_killed_render_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &render("whole", &[]));
    let mut kills = 0;
    for attempt in 0..200_u64 {
        let mut child = shutterlab();
        child
            .current_dir(folder.path())
            .args(render("killed", &[]))
            .stderr(Stdio::null())
            .stdout(Stdio::null());
        let mut child = child.spawn().unwrap();
        // Moments that have no common rhythm with the frames.
        std::thread::sleep(Duration::from_millis(20 + attempt * 37 % 150));
        if child.try_wait().unwrap().is_some() {
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
    }
    succeed(folder.path(), &render("killed", &[]));
    assert!(kills >= 3, "only {kills} kills hit a render under way");
    let (whole, mut killed) = (
        pixels_and_manifests(&folder.path().join("whole")),
        pixels_and_manifests(&folder.path().join("killed")),
    );
    // A kill in the middle of a write leaves its temporary file, which no reader takes for a frame.
    killed.retain(|(name, _)| !name.ends_with(".partial"));
    assert!(whole == killed);
}

#[test]
fn what_is_finished_is_not_rendered_again() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &render("out", &["--frames", "0..2"]));
    let before = tree(folder.path());
    let again = run_in(folder.path(), &render("out", &["--frames", "0..2"]));
    assert!(String::from_utf8_lossy(&again.stderr).contains("was finished"));
    assert_eq!(before, tree(folder.path()));
    // More frames are added to what is there.
    succeed(folder.path(), &render("out", &["--frames", "1..4"]));
    let sequence = Sequence::open(&folder.path().join("out/M2-S2-T3-A3")).unwrap();
    let frames: Vec<u32> = sequence.manifest.frames.iter().map(|frame| frame.index).collect();
    assert_eq!(frames, [0, 1, 2, 3]);
}

/// A frame rendered alone is the frame of the whole sequence.
#[test]
fn a_frame_alone_is_the_same_frame() {
    let folder = tempfile::tempdir().unwrap();
    succeed(
        folder.path(),
        &["render", "demo", "-o", "one", "--size", "16x9", "--device", "cpu", "--frames", "7..8"],
    );
    for sequence in Sequence::open_all(&folder.path().join("one")).unwrap() {
        let id = &sequence.manifest.stimulus.id;
        let whole = Sequence::open(&small_stimuli().join(id)).unwrap();
        assert_eq!(sequence.manifest.frames[0], whole.manifest.frames[7], "{id}");
    }
}

/// A changed definition never mixes with what is there.
#[test]
fn another_definition_is_refused_by_its_field() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &render("out", &["--frames", "0..1"]));
    let grid = include_str!("../stimuli/grids/demo.toml").replace("seed = 2012", "seed = 2013");
    std::fs::write(folder.path().join("demo2.toml"), grid).unwrap();
    let mut args = render("out", &["--frames", "0..1"]);
    args[1] = "demo2.toml";
    let error = fail(folder.path(), 1, &args);
    assert!(error.contains("seed: 2012, now 2013"), "{error}");
}

/// The shipped grid of the thesis has its 225 sequences, of four seconds each.
#[test]
fn the_thesis_grid_is_whole() {
    let grid = shutterlab_stimuli::Grid::load("rolling-sphere-mono").unwrap();
    let stimuli = grid.stimuli(&Default::default()).unwrap();
    assert_eq!(stimuli.len(), 225);
    assert!(stimuli.iter().all(|s| f64::from(s.image.frames) / s.image.fps == 4.0));
    let ids: std::collections::BTreeSet<&str> = stimuli.iter().map(|s| s.id.as_str()).collect();
    assert_eq!(ids.len(), 225);
}

/// While one process makes a sequence, another is told so and disturbs nothing.
#[test]
fn two_renders_into_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    let sequence = folder.path().join("out/M2-S2-T3-A3");
    std::fs::create_dir_all(&sequence).unwrap();
    let lock = std::fs::File::create(sequence.join(".lock")).unwrap();
    lock.lock().unwrap();
    let error = fail(folder.path(), 1, &render("out", &["--frames", "0..1"]));
    assert!(error.contains("another running program is making this sequence"), "{error}");
    drop(lock);
    succeed(folder.path(), &render("out", &["--frames", "0..1"]));
}

/// One pass over the samples yields every level, and each is what rendering it alone gives.
#[test]
fn nested_levels_are_those_rendered_alone() {
    let folder = tempfile::tempdir().unwrap();
    let cell = "--size 16x9 --device cpu --frames 11..13 --select shutter=T5";
    for (out, select) in [("all", ""), ("alone", ",samples=A4")] {
        let words = format!("render demo -o {out} {cell}{select}");
        succeed(folder.path(), &words.split(' ').collect::<Vec<_>>());
    }
    let alone = pixels_and_manifests(&folder.path().join("alone"));
    let all = pixels_and_manifests(&folder.path().join("all"));
    assert!(alone.len() >= 3 && alone.iter().all(|file| all.contains(file)));
    let distinct: std::collections::BTreeSet<_> =
        all.iter().filter(|(name, _)| name.ends_with("0012.png")).map(|(_, png)| png).collect();
    assert_eq!(distinct.len(), 3);
}

/// The shards of a grid are disjoint and make up the whole, also as the tasks of a job array.
#[test]
fn shards_make_up_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &render("whole", &["--frames", "0..2"]));
    let whole = pixels_and_manifests(&folder.path().join("whole"));
    let mut parts = vec![];
    for shard in ["1/2", "2/2"] {
        let out = format!("part {}", &shard[..1]);
        succeed(folder.path(), &render(&out, &["--frames", "0..2", "--shard", shard]));
        parts.extend(pixels_and_manifests(&folder.path().join(&out)));
    }
    parts.sort();
    assert!(parts == whole);

    let script = succeed(folder.path(), &render("array", &["--frames", "0..2", "--slurm"]));
    let text = std::fs::read_to_string(script.trim()).unwrap();
    assert!(text.contains("#SBATCH --array=1-3\n"), "{text}");
    for task in ["1", "2", "3"] {
        run_task(script.trim(), task);
    }
    assert!(pixels_and_manifests(&folder.path().join("array")) == whole);
}

/// Runs one task of a job array, without Slurm.
fn run_task(script: &str, task: &str) {
    let mut job = std::process::Command::new("sh");
    let output = job.arg(script).env("SLURM_ARRAY_TASK_ID", task).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// What Slurm reads of a job array bears any name of a folder or grid, and a shipped grid stays the
/// shipped one where a file or folder has its name.
#[test]
#[cfg(unix)]
fn a_job_array_bears_awkward_names() {
    let folder = tempfile::tempdir().unwrap();
    let head = |script: &str, key: &str| {
        let text = std::fs::read_to_string(script.trim()).unwrap();
        let line = text.lines().find_map(|line| line.strip_prefix(&format!("#SBATCH --{key}=")));
        line.unwrap().to_string()
    };
    let one = ["--frames", "0..1", "--slurm"];

    let script = succeed(folder.path(), &render("demo", &one));
    run_task(script.trim(), "1");
    assert!(folder.path().join("demo/M2-S2-T3-A3/sequence.json").exists());

    let grid = include_str!("../stimuli/grids/demo.toml");
    let name = r#"name = "my \"grid\" #1""#;
    std::fs::write(folder.path().join("it's.toml"), grid.replace("name = \"demo\"", name)).unwrap();
    let mut words = render("100 %a 'x' \"y\" #z", &one);
    words[1] = "it's.toml";
    let script = succeed(folder.path(), &words);
    assert_eq!(head(&script, "job-name"), r#""my \"grid\" #1""#);
    // What sbatch 22.05 takes for this folder and the task's log in it.
    let log = head(&script, "output");
    assert!(log.starts_with("\"/"), "{log}");
    assert!(log.ends_with(r#"/100 %%a 'x' \"y\" #z/slurm-%A-%a.log""#), "{log}");
    run_task(script.trim(), "2");
    assert!(folder.path().join("100 %a 'x' \"y\" #z/M2-S2-T4-A3/sequence.json").exists());

    let error = fail(folder.path(), 1, &render("a\\b", &one));
    assert!(error.contains("Slurm allows no backslash in a log file's path"), "{error}");
    let error = fail(folder.path(), 1, &render("a\nb", &one));
    assert!(error.contains("a path of printable UTF-8 is needed"), "{error}");
    assert!(!folder.path().join("a\nb").exists());
}

/// Two eyes in one place see what one eye sees, the right one with noise of its own if it may; two
/// eyes apart do not.
#[test]
fn stereo_frames_hold_two_eyes() {
    let folder = tempfile::tempdir().unwrap();
    let stereo = |millimetres: f64, noise: &str, convergence: &str| {
        let text = include_str!("../stimuli/grids/demo.toml");
        let table = format!(
            "[stereo]\ninterocular_mm = {millimetres:.1}\nconvergence = \"{convergence}\"\n\
             noise = \"{noise}\"\nlayout = \"side-by-side\"\n\n[image]"
        );
        text.replace("[image]", &table)
    };
    let frame = |name: &str, grid: &str, more: &[&str]| {
        let file = format!("{name}.toml");
        std::fs::write(folder.path().join(&file), grid).unwrap();
        let words = "--size 32x18 --device cpu --frames 13..14 --select shutter=T3,samples=A3";
        let words: Vec<&str> = ["render", &file, "-o", name]
            .into_iter()
            .chain(words.split(' '))
            .chain(more.iter().copied())
            .collect();
        succeed(folder.path(), &words);
        let sequence = Sequence::open(&folder.path().join(name).join("M2-S2-T3-A3")).unwrap();
        sequence.read_frame(&sequence.manifest.frames[0]).unwrap()
    };
    let halves = |image: &EncodedImage| {
        assert_eq!([image.width, image.height], [64, 18]);
        let side = |from: usize| {
            image.bytes.chunks(3 * 64).flat_map(|row| &row[from..from + 3 * 32]).copied().collect()
        };
        let (left, right): (Vec<u8>, Vec<u8>) = (side(0), side(3 * 32));
        (left, right)
    };
    let mono = frame("mono", include_str!("../stimuli/grids/demo.toml"), &[]);
    let (left, right) = halves(&frame("shared", &stereo(0.0, "shared", "toe-in"), &[]));
    assert!(left == mono.bytes && right == mono.bytes);
    let (left, right) = halves(&frame("own", &stereo(0.0, "independent", "off-axis"), &[]));
    assert!(left == mono.bytes && right != mono.bytes);
    let apart = stereo(65.0, "shared", "toe-in");
    let (left, right) = halves(&frame("apart", &apart, &[]));
    assert!(left != right);
    for (layout, size) in [
        ("half-width", [32, 18]),
        ("top-bottom", [32, 36]),
        ("anaglyph", [32, 18]),
        ("difference", [32, 18]),
    ] {
        let image = frame(layout, &apart, &["--layout", layout]);
        assert_eq!([image.width, image.height], size, "{layout}");
    }
    let error = fail(folder.path(), 2, &render("mono", &["--layout", "anaglyph"]));
    assert!(error.contains("--layout: anaglyph: demo: the grid is not stereo"), "{error}");
    let error = fail(folder.path(), 2, &render("mono", &["--shard", "3/2"]));
    assert!(error.contains("with I from 1 to N"), "{error}");
}

/// Beside the sequences lie a contact sheet and a page; linear images and a lossless video on request.
#[test]
fn what_people_look_at_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let said = succeed(folder.path(), &render("o", &["--frames", "0..3", "--exr"]));
    assert_eq!(said.lines().count(), 3, "{said}");
    let out = folder.path().join("o");
    let page = std::fs::read_to_string(out.join("index.html")).unwrap();
    assert!(page.contains(r#""folder":"M2-S2-T4-A3""#) && page.contains(r#""size":[32,18]"#));
    let sheet = EncodedImage::read_png(&out.join("contact-sheet.png")).unwrap();
    // Three columns of whole frames in a single row, and their names.
    assert!(sheet.width > 3 * 32 && sheet.height > 18, "{}×{}", sheet.width, sheet.height);
    let linear = std::fs::metadata(out.join("M2-S2-T4-A3/frame-0002.exr")).unwrap();
    assert!(linear.len() > 1000);

    if shutterlab_stimuli::video::is_available() {
        succeed(folder.path(), &render("o", &["--frames", "0..3", "--video"]));
        let video = out.join("M2-S2-T4-A3/sequence.mkv");
        let mut ffmpeg = std::process::Command::new("ffmpeg");
        ffmpeg.args(["-loglevel", "error", "-i"]).arg(&video);
        let decoded = ffmpeg.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]).output().unwrap();
        let frames: Vec<u8> = (0..3)
            .flat_map(|n| {
                let file = out.join(format!("M2-S2-T4-A3/frame-{n:04}.png"));
                EncodedImage::read_png(&file).unwrap().bytes
            })
            .collect();
        assert!(decoded.stdout == frames, "{} bytes", decoded.stdout.len());
    } else {
        let error = fail(folder.path(), 1, &render("o", &["--frames", "0..3", "--video"]));
        assert!(error.contains("--video: ffmpeg: not found"), "{error}");
    }
}
