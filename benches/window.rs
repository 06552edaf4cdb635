//! How exactly the window shows frames and times answers, on an X server without a screen (Xvfb) and with
//! whatever adapter draws there.
//!
//! `script/bench window [--short] [--check]` runs the shipped protocol `mono3` twice, first with sequences
//! of 8×8 pixels, which leave the window as good as empty, then with those of full size, and answers all its
//! questions with keys injected into the server. Both have the protocol's ids, lengths and levels, but only
//! up to five samples: what is on the pictures does not matter here. It prints how long after it was due
//! each frame was submitted, and how long after its injection the key of each answer was taken down.
//!
//! `--short` leaves four pairs and nothing else of the protocol. Exit status 1: a row or a frame is missing or
//! doubled or answers something else than was pressed; with `--check`, a time is longer than it may be, too.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use jiff::Timestamp;
use shutterlab_data_schema::response::{Answer, Response, TrialKind};
use shutterlab_experiments::random::Stream;
use std::collections::BTreeMap;
use std::error::Error;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::CURRENT_TIME;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    ConnectionExt as _, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, MapState,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

type Failure = Box<dyn Error>;

const GRID: &str = include_str!("../stimuli/grids/rolling-sphere-mono.toml");
const PROTOCOL: &str = include_str!("../experiments/protocols/mono3.toml");

/// What the protocol compares, practises and catches with.
const WHOLE: [&str; 3] = [
    "material=M2,speed=S2,shutter=T3,shutter=T4,shutter=T5,samples=A3,samples=A4,samples=A5",
    "material=M2,speed=S2,shutter=T5,samples=A1",
    "material=M1,speed=S3,shutter=T1,shutter=T3,shutter=T5,samples=A1,samples=A5",
];
const SHORT: [&str; 1] = ["material=M2,speed=S2,shutter=T3,shutter=T5,samples=A3,samples=A5"];

const FRAMES: usize = 120;
const FPS: f64 = 30.0;

/// From one answer to when the next one is given, at least: the trial's grey, mark and films take 9.5 s, and
/// nobody answers at once. Where a page lies between, keys come from the question's first moment.
const FILMS: Duration = Duration::from_millis(10_000);

/// The last press before a row that says the same as the key made it, unless it is as long ago as this: from
/// one press of a key to its next are 60 ms or more.
const SAME_KEY_US: i64 = 200_000;

fn main() -> Result<(), Failure> {
    let is_given = |flag: &str| std::env::args().any(|argument| argument == flag);
    let is_short = is_given("--short");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("target/bench/window")
        .join(if is_short { "short" } else { "whole" });
    std::fs::create_dir_all(&folder)?;
    prepare(&folder, is_short)?;

    let server = Server::start()?;
    let empty = sit(&server, &folder, "empty", is_short)?;
    let full = sit(&server, &folder, "full", is_short)?;
    let lines = [
        ("frames submitted late, ms", &empty.late_ms, &full.late_ms),
        ("answers taken late, ms", &empty.answers_ms, &full.answers_ms),
    ];
    println!(
        "{:28} {:>6} {:>8} {:>8} {:>8} {:>8}",
        "", "number", "median", "99 %", "99.9 %", "worst"
    );
    for (name, empty, full) in lines {
        for (window, times) in [("empty", empty), ("full", full)] {
            let [median, most, nearly_all, worst] =
                [0.5, 0.99, 0.999, 1.0].map(|part| quantile(times, part));
            let name = format!("{name}: {window}");
            println!(
                "{name:34} {:6} {median:8.3} {most:8.3} {nearly_all:8.3} {worst:8.3}",
                times.len()
            );
        }
    }
    println!("frames late, dropped, repeated: empty {:?}, full {:?}", empty.faults, full.faults);
    let (allowed, reached) =
        (quantile(&empty.late_ms, 0.999) + 2.0, quantile(&full.late_ms, 0.999));
    let criteria = [
        ("frames late, 99.9th percentile, ms, no more than empty + 2", reached, allowed),
        ("answers late, median, ms", quantile(&full.answers_ms, 0.5), 2.0),
        (
            "answers late, 99th percentile, ms, one frame",
            quantile(&full.answers_ms, 0.99),
            1000.0 / FPS,
        ),
    ];
    let mut holds = true;
    for (name, reached, allowed) in criteria {
        let verdict = if reached <= allowed { "holds" } else { "DOES NOT HOLD" };
        println!("{name}: {reached:.3} of {allowed:.3}: {verdict}");
        holds &= reached <= allowed;
    }
    if is_given("--check") && !holds {
        Err("a time is longer than it may be".into())
    } else {
        Ok(())
    }
}

/// Grid, protocol and both sets of sequences; what is rendered already stays.
fn prepare(folder: &Path, is_short: bool) -> Result<(), Failure> {
    let (axes, _) = GRID.split_once("[axes.samples]").ok_or("the grid has no samples")?;
    let grid = format!("{axes}[axes.samples]\nA1 = 1\nA2 = 2\nA3 = 3\nA4 = 4\nA5 = 5\n");
    std::fs::write(folder.join("grid.toml"), grid)?;
    let mut protocol = PROTOCOL.to_string();
    if is_short {
        let (head, rest) = PROTOCOL.split_once("[[participant]]").ok_or("no participant")?;
        let (_, text) = rest.split_once("[text]").ok_or("no text")?;
        protocol = format!("{head}[text]{text}")
            .replace(r#""T4", "#, "")
            .replace(r#""A4", "#, "")
            .replace(r#"pairs = "all""#, r#"pairs = "one-axis""#);
    }
    std::fs::write(folder.join("protocol.toml"), protocol)?;
    let selections: &[&str] = if is_short { &SHORT } else { &WHOLE };
    for (window, size) in [("empty", "8x8"), ("full", "640x360")] {
        let mut command = shutterlab(folder);
        command.args(["render", "grid.toml", "--size", size, "-o", window]);
        for selection in selections {
            command.args(["--select", selection]);
        }
        if !command.status()?.success() {
            return Err("the sequences could not be rendered".into());
        }
    }
    Ok(())
}

fn shutterlab(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_shutterlab"));
    command.current_dir(folder).stdin(Stdio::null());
    command
}

/// What one session yielded.
struct Sitting {
    /// From when each frame was due to its submission; the first of a film sets when the others are due.
    late_ms: Vec<f64>,
    /// From the injection of each answer's key to when the program says that it came.
    answers_ms: Vec<f64>,
    /// Frames late, dropped and repeated, by the rows.
    faults: [u32; 3],
}

/// Runs a whole session with the sequences called `window`.
fn sit(server: &Server, folder: &Path, window: &str, is_short: bool) -> Result<Sitting, Failure> {
    let study = folder.join(format!("study-{window}"));
    if study.exists() {
        std::fs::remove_dir_all(&study)?;
    }
    let mut command = shutterlab(folder);
    command
        .args(["run", "protocol.toml", "--participant", "B1", "--stimuli", window, "--study"])
        .arg(&study)
        .env("DISPLAY", &server.display)
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET");
    let mut program = Program(command.spawn()?);
    let keys = press_keys(server, &study, &mut program)?;

    let reader = csv::Reader::from_path(find(&study.join("data"), "_data.csv")?)?;
    let rows = reader.into_deserialize().collect::<Result<Vec<Response>, _>>()?;
    let frames = csv::Reader::from_path(find(&study.join("log"), "_frames.csv")?)?;
    let frames = frames.into_deserialize().collect::<Result<Vec<Frame>, _>>()?;
    check(&rows, &frames, if is_short { (4, 4) } else { (36, 41) })?;
    let mut answers_ms = vec![];
    for row in &rows {
        let at_us = row.answered_at.parse::<Timestamp>()?.as_microsecond();
        let is_pressed = |key: &&Key| key.before_us <= at_us && key.answer == row.answer;
        let key = keys.iter().rfind(is_pressed).filter(|key| at_us - key.before_us < SAME_KEY_US);
        let no_key = || format!("{window}: trial {}: no key was pressed for it", row.trial);
        let key = key.ok_or_else(no_key)?;
        answers_ms.push((at_us - key.before_us) as f64 / 1e3);
    }
    let later = frames.iter().filter(|frame| frame.frame > 0);
    let late_ms = later.map(|frame| 1e3 * (frame.shown_s - frame.due_s)).collect();
    let sum = |faults: fn(&Response) -> u32| rows.iter().map(faults).sum();
    let faults = [
        sum(|row| row.late_frames_a + row.late_frames_b),
        sum(|row| row.dropped_frames_a + row.dropped_frames_b),
        sum(|row| row.repeated_frames_a + row.repeated_frames_b),
    ];
    let trips =
        keys.iter().map(|key| (key.after_us - key.before_us) as f64 / 1e3).collect::<Vec<_>>();
    let (middle, most) = (quantile(&trips, 0.5), quantile(&trips, 0.99));
    println!(
        "{window}: {} keys; to the server and back {middle:.3} ms, 99 % {most:.3} ms",
        keys.len()
    );
    Ok(Sitting { late_ms, answers_ms, faults })
}

/// A line of the file with the times of frames.
#[derive(serde::Deserialize)]
struct Frame {
    trial: u32,
    interval: u32,
    frame: u32,
    due_s: f64,
    shown_s: f64,
}

/// Each trial was answered once and each film's frames are there once, but for those that were dropped.
fn check(rows: &[Response], frames: &[Frame], (real, all): (usize, usize)) -> Result<(), Failure> {
    let numbers: Vec<usize> = rows.iter().map(|row| row.trial as usize).collect();
    let is_real = |row: &&Response| row.kind == TrialKind::Real;
    if numbers != (1..=all).collect::<Vec<_>>() || rows.iter().filter(is_real).count() != real {
        return Err(
            format!("{all} trials, {real} of them real, but these rows: {numbers:?}").into()
        );
    }
    for row in rows {
        let mut seen: Vec<_> = frames.iter().filter(|frame| frame.trial == row.trial).collect();
        seen.sort_by_key(|frame| (frame.interval, frame.frame));
        let count = seen.len();
        seen.dedup_by_key(|frame| (frame.interval, frame.frame));
        let dropped = (row.dropped_frames_a + row.dropped_frames_b) as usize;
        if seen.len() != count || count + dropped != 2 * FRAMES {
            let what = format!("trial {}: {count} times of frames, {dropped} dropped", row.trial);
            return Err(what.into());
        }
    }
    Ok(())
}

/// A key that answers, and between which moments the server had it.
struct Key {
    answer: Answer,
    before_us: i64,
    after_us: i64,
}

/// Presses keys until the program ends, which it must do well: what the operator's form and the consent need;
/// then Enter now and then, for the pages, and, while a question may be there, an answer about every 50 ms.
fn press_keys(server: &Server, study: &Path, program: &mut Program) -> Result<Vec<Key>, Failure> {
    let mut random = Stream::new(20121122);
    let (mut keys, mut length, mut answered) = (vec![], 0, None::<Instant>);
    let (mut has_keys, participants) = (false, study.join("participants.csv"));
    for turn in 0.. {
        if let Some(status) = program.0.try_wait()? {
            return if status.success() { Ok(keys) } else { Err(format!("run: {status}").into()) };
        }
        std::thread::sleep(Duration::from_secs_f64(0.030 + 0.040 * random.uniform()));
        has_keys = has_keys || server.focus()?;
        if !has_keys {
            continue;
        }
        if !participants.exists() {
            server.press(ENTERING[turn % ENTERING.len()])?;
            continue;
        }
        let rows =
            find(&study.join("data"), "_data.csv").and_then(|file| Ok(file.metadata()?.len()));
        let before = std::mem::replace(&mut length, rows.unwrap_or(0));
        if length > before {
            answered = Some(Instant::now());
        }
        if turn % 8 == 0 {
            server.press(RETURN)?;
        } else if answered.is_none_or(|at| at.elapsed() > FILMS) {
            let answer = if turn % 2 == 0 { Answer::First } else { Answer::Second };
            let before_us = Timestamp::now().as_microsecond();
            server.press(if answer == Answer::First {
                u32::from(b'1')
            } else {
                u32::from(b'2')
            })?;
            keys.push(Key { answer, before_us, after_us: Timestamp::now().as_microsecond() });
        }
    }
    Ok(keys)
}

/// The session's program, which does not outlive this value.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

const RETURN: u32 = 0xff0d;
const RIGHT: u32 = 0xff53;

/// Enter leads to the field without a choice, an arrow chooses, and in the end Enter sends the form off; Y
/// consents, or lengthens the participant's code.
const ENTERING: [u32; 3] = [RIGHT, RETURN, b'y' as u32];

/// An X server with a screen that nobody sees, and the bench's own connection to it.
struct Server {
    _process: Program,
    display: String,
    connection: RustConnection,
    root: u32,
    /// The key for each symbol (X's `keysym`) that needs no other key held.
    codes: BTreeMap<u32, u8>,
}

impl Server {
    fn start() -> Result<Self, Failure> {
        let mut process = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1920x1080x24"])
            .args(["-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map(Program)?;
        let mut number = String::new();
        let stdout = process.0.stdout.take().ok_or("no output of Xvfb")?;
        BufReader::new(stdout).read_line(&mut number)?;
        let display = format!(":{}", number.trim());
        let (connection, screen) = RustConnection::connect(Some(&display))?;
        let root = connection.setup().roots[screen].root;
        let (least, most) = (connection.setup().min_keycode, connection.setup().max_keycode);
        let map = connection.get_keyboard_mapping(least, most - least + 1)?.reply()?;
        let symbols = map.keysyms.chunks(usize::from(map.keysyms_per_keycode));
        let codes = (least..=most).zip(symbols).map(|(code, symbols)| (symbols[0], code)).collect();
        Ok(Self { _process: process, display, connection, root, codes })
    }

    /// Lets the window that is to be seen have the keys; returns whether there is one.
    fn focus(&self) -> Result<bool, Failure> {
        for window in self.connection.query_tree(self.root)?.reply()?.children {
            // It may be gone by now.
            let attributes = self.connection.get_window_attributes(window)?.reply();
            if attributes.is_ok_and(|attributes| attributes.map_state == MapState::VIEWABLE) {
                self.connection.set_input_focus(InputFocus::PARENT, window, CURRENT_TIME)?;
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Presses and releases the key with that symbol; when it returns, the server has
    /// the press.
    fn press(&self, symbol: u32) -> Result<(), Failure> {
        let code = *self.codes.get(&symbol).ok_or("the keyboard lacks a key")?;
        let fake = |kind| self.connection.xtest_fake_input(kind, code, 0, x11rb::NONE, 0, 0, 0);
        fake(KEY_PRESS_EVENT)?;
        self.connection.get_input_focus()?.reply()?;
        fake(KEY_RELEASE_EVENT)?;
        self.connection.flush()?;
        Ok(())
    }
}

/// The file in `folder` whose name ends so.
fn find(folder: &Path, end: &str) -> Result<PathBuf, Failure> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.to_string_lossy().ends_with(end) {
            return Ok(path);
        }
    }
    Err(format!("{}: no file ends in {end}", folder.display()).into())
}

/// The time that so large a part of the times does not exceed.
fn quantile(times: &[f64], part: f64) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = (part * sorted.len() as f64).ceil() as usize;
    sorted.get(place.max(1) - 1).copied().unwrap_or(f64::NAN)
}
