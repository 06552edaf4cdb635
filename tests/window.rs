//! A session in a real window, driven by keys.

use crate::support::{Row, read_table, shutterlab, skip, succeed, table, whole_lines};
use shutterlab_stimuli::Sequence;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Windows that are killed.
mod kills;

/// Width and height of the frames.
const FRAME_PX: [usize; 2] = [64, 36];
/// Frames of a sequence, and how many of them are shown per second: few enough to catch one.
const FRAMES: u32 = 8;
const FPS: f64 = 10.0;
/// Grey before and between the sequences.
const GAP_S: f64 = 0.1;
/// The window's neutral grey.
const GREY: [u8; 3] = [128; 3];
/// The grey of buttons.
pub const BUTTON: [u8; 3] = [158; 3];
const TITLE: &str = "Shutterlab – Three pairs";

const GRID: &str = r#"
schema = 1
name = "three"
title = "Three shutter times, small"
scene = "rolling-sphere"
method = "distribution-ray-tracing"
trajectory = "wrap"
sampler = "sobol"
sampling = "nested"
seed = 7

[image]
width_px = 64
height_px = 36
fps = 10.0
frames = 8
exposure_stops = 0.0
transfer = "srgb"

[viewing]
image_width_deg = 14.4

[materials.checker]
kind = "checker"
cells = 8
light = 0.8
dark = 0.1

[axes.material]
M2 = "checker"

[axes.speed_deg_per_s]
S2 = 10.0

[axes.shutter_open_fraction]
T1 = 0.0
T3 = 0.5
T5 = 1.0

[axes.samples]
A1 = 4
"#;

const PROTOCOL: &str = r#"
schema = 1
name = "three"
title = "Three pairs"
task = "2afc"
question = "Which one?"
seed = 5

[stimuli]

[design]
pairs = "all"
repetitions = 1

[timeline]
fixation_s = 0.1
gap_s = 0.1
eye = "follow"
replays = true

[[practice]]
better = "M2-S2-T1-A1"
worse = "M2-S2-T5-A1"

[text]
instructions = "Answer with 1 or 2."
after_practice = "From now on it counts."
pause = "There is no break."
end = "That was all."
"#;

/// The protocol and the sequences of its three stimuli, rendered once for all tests.
fn material() -> &'static Path {
    static MATERIAL: OnceLock<TempDir> = OnceLock::new();
    let folder = MATERIAL.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("grid.toml"), GRID).unwrap();
        std::fs::write(folder.path().join("protocol.toml"), PROTOCOL).unwrap();
        succeed(folder.path(), &["render", "grid.toml", "-o", "stimuli", "--device", "cpu"]);
        folder
    });
    folder.path()
}

fn sequences() -> Vec<Sequence> {
    Sequence::open_all(&material().join("stimuli")).unwrap()
}

/// The whole screen, red, green and blue per pixel.
pub struct Picture {
    width: usize,
    bytes: Vec<u8>,
}

impl Picture {
    pub fn holds(&self, colour: [u8; 3]) -> bool {
        self.bytes.chunks_exact(3).any(|pixel| pixel == colour)
    }

    /// The rectangle whose top left is at (x, y).
    pub fn part(&self, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> Vec<u8> {
        let row = |y: usize| &self.bytes[3 * (y * self.width + x)..][..3 * width];
        (y..y + height).flat_map(row).copied().collect()
    }
}

/// A screen that nobody sees: an X server that lives as long as this value.
pub struct Screen {
    server: Child,
    pub display: String,
}

impl Screen {
    /// The screen, if the tools that it and the keys need are there. They must be if
    /// `SHUTTERLAB_REQUIRE_WINDOW` is set.
    pub fn open() -> Option<Self> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let is_there = |tool: &str| std::env::split_paths(&path).any(|dir| dir.join(tool).exists());
        if let Some(tool) = ["Xvfb", "xdotool", "import"].into_iter().find(|tool| !is_there(tool)) {
            skip("SHUTTERLAB_REQUIRE_WINDOW", &format!("{tool} is not on the PATH"));
            return None;
        }
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24"])
            .args(["-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // The server says which display it found free once it takes connections.
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let screen = Self { server, display: format!(":{}", number.trim()) };
        assert_ne!(screen.display, ":", "Xvfb did not start");
        Some(screen)
    }

    /// `program` on this screen.
    pub fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("DISPLAY", &self.display).stdin(Stdio::null());
        command
    }

    /// What xdotool prints, or nothing if it fails.
    pub fn xdotool(&self, args: &[&str]) -> String {
        let output = self.command("xdotool").args(args).output().unwrap();
        if output.status.success() {
            String::from_utf8(output.stdout).unwrap()
        } else {
            String::new()
        }
    }

    pub fn picture(&self) -> Picture {
        let output = self
            .command("import")
            .args(["-silent", "-window", "root", "-depth", "8", "ppm:-"])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        // P6, width, height and largest value, each followed by one white space.
        let mut rest = output.stdout.as_slice();
        let mut word = || {
            let end = rest.iter().position(u8::is_ascii_whitespace).unwrap();
            let word = String::from_utf8(rest[..end].to_vec()).unwrap();
            rest = &rest[end + 1..];
            word
        };
        let [kind, width, height, largest] = [word(), word(), word(), word()];
        assert_eq!([kind.as_str(), &largest], ["P6", "255"]);
        let (width, height) = (width.parse().unwrap(), height.parse::<usize>().unwrap());
        assert_eq!(rest.len(), 3 * width * height);
        Picture { width, bytes: rest.to_vec() }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        self.server.kill().ok();
        self.server.wait().ok();
    }
}

/// Asks `is_so` again and again until it is, a long time; now and then does `nudge`.
pub fn wait_until(what: &str, mut nudge: impl FnMut(), mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    let mut nudged = None;
    while !is_so() {
        assert!(start.elapsed() < Duration::from_secs(120), "waited in vain: {what}");
        if nudged.is_none_or(|at: Instant| at.elapsed() > Duration::from_millis(500)) {
            nudge();
            nudged = Some(Instant::now());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Runs a session of `protocol` on `screen`, with the study in `folder`, where it also leaves what it prints.
fn run(screen: &Screen, protocol: &Path, folder: &Path) -> Command {
    let mut command = shutterlab();
    command
        .arg("run")
        .arg(protocol)
        .arg("--stimuli")
        .arg(material().join("stimuli"))
        .arg("--study")
        .arg(folder.join("study"))
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .stdin(Stdio::null())
        .stdout(File::create(folder.join("stdout")).unwrap())
        .stderr(File::create(folder.join("stderr")).unwrap());
    command
}

/// The command in its window.
struct Sitting<'a> {
    screen: &'a Screen,
    /// Where it writes: the folder that holds the study and what was printed.
    folder: &'a Path,
    program: Child,
    window: String,
    data_file: PathBuf,
}

impl<'a> Sitting<'a> {
    /// Runs a session of `code` and waits for its window. If `types` is set, the code is typed there.
    fn begin(screen: &'a Screen, folder: &'a Path, code: &str, pilot: bool, types: bool) -> Self {
        let mut command = run(screen, &material().join("protocol.toml"), folder);
        command.args(if pilot { vec!["--pilot"] } else { vec![] }).args(if types {
            vec![]
        } else {
            vec!["--participant", code]
        });
        let program = command.spawn().unwrap();
        let study = if pilot { folder.join("study/pilot") } else { folder.join("study") };
        let data_file =
            study.join(format!("data/study-three_subject-{code}_session-1_task-2afc_data.csv"));
        let mut sitting = Self { screen, folder, program, window: String::new(), data_file };
        sitting.find_window();
        if types {
            sitting.enter_code(code, &study.join("participants.csv"));
        }
        sitting
    }

    /// Waits until the window is there and something was drawn in it, and lets it have the keys.
    fn find_window(&mut self) {
        let (screen, mut window) = (self.screen, String::new());
        wait_until(
            "a window",
            || {},
            || {
                assert!(self.program.try_wait().unwrap().is_none(), "{}", self.printed("stderr"));
                let found = screen.xdotool(&["search", "--onlyvisible", "--name", "^Shutterlab"]);
                window = found.lines().next().unwrap_or_default().to_string();
                !window.is_empty()
            },
        );
        self.window = window;
        assert_eq!(screen.xdotool(&["getwindowname", &self.window]).trim_end(), TITLE);
        let focus = || drop(screen.xdotool(&["windowfocus", &self.window]));
        wait_until("the window has the keys", focus, || {
            screen.xdotool(&["getwindowfocus"]).trim() == self.window
        });
        // The check of the display shows no button; every page that waits for a key does.
        wait_until("a page", || {}, || screen.picture().holds(BUTTON));
    }

    /// Types the code and Enter while the program is held up, so that all keys reach it at once: what
    /// was typed before Enter counts, however slowly the window is drawn.
    fn enter_code(&self, code: &str, participants: &Path) {
        let signal = |name: &str| {
            let kill = format!("kill -{name} {}", self.program.id());
            assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        };
        signal("STOP");
        self.screen.xdotool(&["type", code]);
        self.press(&["Return"]);
        signal("CONT");
        wait_until("a code is taken", || {}, || participants.exists());
        let subjects = read_table(participants).into_iter().map(|row| row["subject"].clone());
        assert_eq!(subjects.collect::<Vec<_>>(), [code]);
    }

    /// The window's top left and size.
    fn place(&self) -> ([usize; 2], [usize; 2]) {
        let text = self.screen.xdotool(&["getwindowgeometry", "--shell", &self.window]);
        let value = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
            line.unwrap().parse().unwrap()
        };
        ([value("X"), value("Y")], [value("WIDTH"), value("HEIGHT")])
    }

    fn press(&self, keys: &[&str]) {
        self.screen.xdotool(&[&["key"], keys].concat());
    }

    /// The whole rows that are there.
    fn rows(&self) -> Vec<Row> {
        table(&std::fs::read_to_string(&self.data_file).unwrap_or_default())
    }

    /// Answers one trial after the other with `keys`, leaving every page on the way.
    ///
    /// Keys before a question mean nothing, so they can be sent until they do.
    fn answer(&self, keys: &[&str]) {
        for key in keys {
            let there = self.rows().len();
            let answer = || self.press(&["Return", key]);
            wait_until("a row", answer, || self.rows().len() > there);
            assert_eq!(self.rows().len(), there + 1);
        }
    }

    /// Presses `keys` until the program ends; it must do so without an error. Returns what it printed.
    fn leave(mut self, keys: &[&str]) -> String {
        let (screen, program) = (self.screen, &mut self.program);
        let mut status = None;
        let press = || drop(screen.xdotool(&[&["key"], keys].concat()));
        wait_until("the program ends", press, || {
            status = program.try_wait().unwrap();
            status.is_some()
        });
        assert!(status.unwrap().success(), "{}", self.printed("stderr"));
        self.printed("stdout")
    }

    /// Takes the window away from the program, which cannot go on without it.
    fn crash(mut self) {
        let (screen, window, program) = (self.screen, self.window.clone(), &mut self.program);
        let kill = || drop(screen.xdotool(&["windowkill", &window]));
        let mut status = None;
        wait_until("the program ends", kill, || {
            status = program.try_wait().unwrap();
            status.is_some()
        });
        assert!(!status.unwrap().success());
    }

    fn printed(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.join(name)).unwrap()
    }
}

impl Drop for Sitting<'_> {
    /// Ends the program. If something went wrong, keeps a picture of the screen and says where.
    #[expect(clippy::print_stdout, reason = "what a failed test leaves to look at")]
    fn drop(&mut self) {
        if std::thread::panicking() {
            let name =
                format!("shutterlab-window-{}-{}.png", std::process::id(), self.program.id());
            let file = std::env::temp_dir().join(name);
            let mut import = self.screen.command("import");
            import.args(["-silent", "-window", "root"]).arg(&file);
            if import.status().is_ok_and(|status| status.success()) {
                println!("the screen as it was: {}", file.display());
            }
            println!("{}", std::fs::read_to_string(self.folder.join("stderr")).unwrap_or_default());
        }
        self.program.kill().ok();
        self.program.wait().ok();
    }
}

/// Holds the rows of a whole session against the keys that answered it.
fn check_rows(rows: &[Row], keys: &[&str]) {
    let manifests: BTreeMap<String, String> =
        sequences().into_iter().map(|s| (s.manifest.stimulus.id, s.manifest.sha256)).collect();
    let number = |row: &Row, column: &str| row[column].parse::<f64>().unwrap();
    let column = |name: &str| rows.iter().map(|row| row[name].as_str()).collect::<Vec<_>>();
    assert_eq!(column("trial"), ["1", "2", "3", "4"]);
    assert_eq!(column("kind"), ["practice", "real", "real", "real"]);
    let pairs: BTreeSet<_> =
        rows[1..].iter().map(|row| (&row["stimulus_a"], &row["stimulus_b"])).collect();
    assert_eq!(pairs.len(), 3);
    for (row, key) in rows.iter().zip(keys) {
        assert_eq!(
            (row["observer"].as_str(), row["clock"].as_str()),
            ("participant", "submission")
        );
        for side in ["a", "b"] {
            assert_eq!(row[&format!("hash_{side}")], manifests[&row[&format!("stimulus_{side}")]]);
            assert_eq!(row[&format!("replays_{side}")], "0");
            let late = number(row, &format!("late_frames_{side}"));
            assert!((0.0..=f64::from(FRAMES)).contains(&late), "{late}");
        }
        let (first, second) = if row["first"] == "a" { ("a", "b") } else { ("b", "a") };
        let (answer, selected) = if *key == "1" { ("first", first) } else { ("second", second) };
        assert_eq!(row["answer"], answer);
        assert_eq!(row["selected"], row[&format!("stimulus_{selected}")]);
        // The second begins when the first is over and the grey between them as well.
        let onset = |side| number(row, &format!("onset_{side}_s"));
        let between = onset(second) - onset(first);
        // A frame may be handed over a little early where that usually takes a little longer.
        let least = f64::from(FRAMES) / FPS + GAP_S - 0.002;
        assert!((least..120.0).contains(&between), "{between}");
        let time = number(row, "response_time_s");
        assert!((0.0..120.0).contains(&time), "{time}");
    }
    let correct = (rows[0]["selected"] == "M2-S2-T1-A1").to_string();
    assert_eq!(column("correct"), [correct.as_str(), "", "", ""]);
}

#[test]
fn a_session_is_answered_with_keys() {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let keys = ["1", "2", "2", "1"];
    let sitting = Sitting::begin(&screen, folder.path(), "P7", false, true);
    sitting.answer(&keys);
    let rows = sitting.rows();
    let printed = sitting.leave(&["Return"]);
    assert!(printed.starts_with("P7: finished; 4 answers now, 0 before, in "), "{printed}");
    check_rows(&rows, &keys);
    let onsets: Vec<f64> = rows.iter().map(|row| row["onset_a_s"].parse().unwrap()).collect();
    assert!(onsets.is_sorted(), "{onsets:?}");
    assert!(rows.iter().all(|row| row["attempt"] == "1"));
}

/// The window is lost after one answer and left after another; the session goes on each time.
#[test]
fn a_session_that_was_closed_goes_on() {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let begin = || Sitting::begin(&screen, folder.path(), "P8", false, false);
    let sitting = begin();
    sitting.answer(&["2"]);
    sitting.crash();

    let sitting = begin();
    let crashed = sitting.rows();
    sitting.answer(&["1"]);
    let left = sitting.rows();
    assert_eq!((crashed.len(), &left[..1]), (1, crashed.as_slice()));
    let printed = sitting.leave(&["Escape", "l"]);
    let stopped =
        "P8: stopped at 2 of 4 trials; run the same again to go on; 1 answers now, 1 before";
    assert!(printed.starts_with(stopped), "{printed}");

    let sitting = begin();
    sitting.answer(&["1", "2"]);
    let rows = sitting.rows();
    assert_eq!(rows[..2], left);
    let printed = sitting.leave(&["Return"]);
    assert!(printed.starts_with("P8: finished; 2 answers now, 2 before, in "), "{printed}");
    check_rows(&rows, &["2", "1", "1", "2"]);
}

/// What is on the screen while a film runs is a frame of it, in the middle of the window, each pixel
/// with its very code values, and grey around it. The session is a pilot, which stays apart.
#[test]
fn frames_reach_the_screen_unchanged() {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut frames = BTreeMap::new();
    for sequence in sequences() {
        for frame in &sequence.manifest.frames {
            let image = sequence.read_frame(frame).unwrap();
            assert_eq!([image.width, image.height].map(|side| side as usize), FRAME_PX);
            let is_new =
                frames.insert(image.bytes, sequence.manifest.stimulus.id.clone()).is_none();
            assert!(is_new, "two frames look the same, so one seen says little");
        }
    }

    let sitting = Sitting::begin(&screen, folder.path(), "P9", true, false);
    let ([left, top], [width, height]) = sitting.place();
    let [x, y] = [left + (width - FRAME_PX[0]) / 2, top + (height - FRAME_PX[1]) / 2];
    let mut seen = BTreeMap::new();
    // Through the instructions; then, once the question is asked, see either film again.
    let mut film = ["q", "w"].into_iter().cycle();
    let watch = || sitting.press(&["Return", film.next().unwrap()]);
    wait_until("frames of both films", watch, || {
        let picture = screen.picture();
        let Some(id) = frames.get(&picture.part([x, y], FRAME_PX)) else {
            return false;
        };
        let around = picture.part([x - 1, y - 1], FRAME_PX.map(|side| side + 2));
        let grey = around.chunks(3).filter(|pixel| *pixel == GREY).count();
        assert!(grey >= 2 * (FRAME_PX[0] + FRAME_PX[1]) + 4, "{grey} grey pixels around the frame");
        seen.insert(id.clone(), ());
        seen.len() == 2
    });
    sitting.answer(&["1", "2"]);
    let rows = sitting.rows();
    let shown = [&rows[0]["stimulus_a"], &rows[0]["stimulus_b"]];
    assert!(seen.keys().eq(shown), "{seen:?}, but {shown:?} were to be seen");
    assert_eq!([&rows[0]["kind"], &rows[1]["kind"]], ["practice", "pilot"]);
    sitting.leave(&["Escape", "l"]);
    assert!(!folder.path().join("study/data").exists());
}
