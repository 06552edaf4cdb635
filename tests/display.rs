//! What a display profile says is what is to be seen on the screen.

use crate::support::{shutterlab, small_stimuli};
use crate::window::{Screen, wait_until};
use shutterlab_experiments::display::fusion::FusionCard;
use shutterlab_stimuli::Sequence;
use shutterlab_stimuli::frames::{EncodedImage, Transfer};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// A profile in a folder.
fn profile(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("display.toml");
    std::fs::write(&path, format!("schema = 1\nname = \"lab\"\n{text}")).unwrap();
    path
}

/// The command on a screen.
fn on(screen: &Screen, args: &[&str]) -> Command {
    let mut command = shutterlab();
    command
        .args(args)
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .stdin(Stdio::null());
    command
}

/// The virtual screen shows frames whenever they come: the check must not take it for a display.
#[test]
fn a_screen_that_paces_nothing_does_not_pass() {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let profile = profile(folder.path(), "refresh_hz = 60.0\n");
    let profile = profile.to_str().unwrap();
    let args = ["display", "check", "--profile", profile, "--frames", "200", "--json"];
    let output = on(&screen, &args).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    let check: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&check["pacing"], &check["refresh_hz"]), (&"timer".into(), &().into()), "{check}");
    assert_eq!(check["intervals"]["count"], 199);
    // Without a window manager, too, the window is the screen, in physical pixels.
    assert_eq!(check["window_px"], serde_json::json!([1280, 800]));
    let faults = check["faults"].as_array().unwrap();
    let tells = |start: &str| faults.iter().any(|f| f.as_str().unwrap().starts_with(start));
    assert!(tells("pacing timer"), "{check}");
    assert_eq!(check["software"] == true, tells("adapter "), "{check}");
    assert!(stderr.contains("error: display check: "), "{stderr}");
}

/// The command in its window, ended when this is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// The window, once it is there.
fn window(screen: &Screen) -> String {
    let mut window = String::new();
    let is_there = || {
        let found = screen.xdotool(&["search", "--onlyvisible", "--name", "^Shutterlab"]);
        let mut lines = found.lines().map(String::from);
        // The right eye's window, if there is one, gets no keys.
        lines.find(|id| !screen.xdotool(&["getwindowname", id]).contains("right eye")).is_some_and(
            |id| {
                window = id;
                true
            },
        )
    };
    wait_until("a window", || {}, is_there);
    window
}

/// Turns the cards over to the last one and waits until the screen shows each image at its place there,
/// of which the rows from `from_row` on are looked at.
fn shows_stereo_card(text: &str, expected: &[([usize; 2], EncodedImage)], from_row: usize) {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let profile = profile(folder.path(), text);
    let args = ["display", "cards", "--profile", profile.to_str().unwrap()];
    let _running = Running(on(&screen, &args).spawn().unwrap());
    let window = window(&screen);
    // Keys before the window has them are lost, and those after the last card end it: go there and back.
    let turn = || {
        screen.xdotool(&["windowfocus", "--sync", &window]);
        screen.xdotool(&["key", "Left", "Left", "Right", "Right"]);
    };
    wait_until("the stereo card", turn, || {
        let picture = screen.picture();
        expected.iter().all(|([left, top], image)| {
            let width = image.width as usize;
            let rows = image.bytes.chunks_exact(3 * width).enumerate().skip(from_row);
            let mut rows =
                rows.filter(|(y, row)| picture.part([*left, top + y], [width, 1]) != *row);
            rows.next().is_none()
        })
    });
}

/// The left or right half of a side-by-side frame.
fn eye(frame: &EncodedImage, number: usize) -> EncodedImage {
    let width = frame.width as usize / 2;
    let rows = frame.bytes.chunks_exact(6 * width);
    let bytes = rows.flat_map(|row| &row[3 * width * number..][..3 * width]).copied().collect();
    EncodedImage { width: frame.width / 2, height: frame.height, bytes }
}

#[test]
fn each_eye_has_its_window() {
    let frame = FusionCard::new(1).frame;
    // Two windows of 600 × 700 beside each other in the middle of 1280 × 800.
    let text = "[window]\nwidth_px = 600\nheight_px = 700\n[stereo]\nmode = \"two-windows\"\n";
    let expected = [([180, 240], eye(&frame, 0)), ([780, 240], eye(&frame, 1))];
    shows_stereo_card(text, &expected, 0);
}

#[test]
fn rows_alternate_between_the_eyes_and_pixels_are_doubled() {
    let frame = FusionCard::new(1).frame;
    let eyes = [eye(&frame, 0), eye(&frame, 1)];
    let (top, side) = (80, 640);
    let pixel = |x: usize, y: usize| {
        let at = 3 * (y / 2 * 320 + x / 2);
        &eyes[(top + y) % 2].bytes[at..at + 3]
    };
    let places = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let bytes = places.flat_map(|(x, y)| pixel(x, y)).copied().collect();
    let expected = EncodedImage { width: side as u32, height: side as u32, bytes };
    let text = "magnification = 2.0\n[stereo]\nmode = \"row-interleaved\"\n";
    // The words at the top reach into the picture.
    shows_stereo_card(text, &[([320, top], expected)], 120);
}

const PROTOCOL: &str = r#"
schema = 1
name = "still"
title = "Two stills"
task = "2afc"
question = "Which one?"
seed = 1

[stimuli]
shutter = ["T3", "T5"]
samples = ["A5"]

[design]
pairs = "all"
repetitions = 1

[timeline]
fixation_s = 0.0
gap_s = 0.0
eye = "follow"
replays = false
still = { frame = 7, seconds = 3600.0 }

[text]
instructions = "Look."
after_practice = "Now it counts."
pause = "Rest."
end = "Thank you."
"#;

/// What a session shows of a frame by this profile, if `fits` knows what it should be: the frame magnified
/// by three in the middle of the screen.
fn shows_frame(text: &str, fits: impl Fn(u8, u8) -> bool) {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let profile = profile(folder.path(), text);
    std::fs::write(place("still.toml"), PROTOCOL).unwrap();
    let frames: Vec<EncodedImage> = ["M2-S2-T3-A5", "M2-S2-T5-A5"]
        .iter()
        .map(|id| {
            let sequence = Sequence::open(&small_stimuli().join(id)).unwrap();
            sequence.read_frame(&sequence.manifest.frames[7]).unwrap()
        })
        .collect();
    let (stimuli, study) = (small_stimuli().to_str().unwrap(), place("study"));
    let args = ["run", &place("still.toml"), "--stimuli", stimuli, "--study", &study];
    let args =
        [&args[..], &["--participant", "P1", "--display", profile.to_str().unwrap()]].concat();
    let _running = Running(on(&screen, &args).spawn().unwrap());
    let window = window(&screen);
    let go_on = || {
        screen.xdotool(&["windowfocus", "--sync", &window]);
        screen.xdotool(&["key", "Return"]);
    };
    wait_until("one of the frames", go_on, || {
        let picture = screen.picture();
        frames.iter().any(|frame| {
            let (left, top) = ((1280 - 48) / 2, (800 - 27) / 2);
            (0..48 * 27).all(|i| {
                let (x, y) = (i % 48, i / 48);
                let at = 3 * (y / 3 * 16 + x / 3);
                let shown = picture.part([left + x, top + y], [1, 1]);
                shown.iter().zip(&frame.bytes[at..at + 3]).all(|(shown, code)| fits(*code, *shown))
            })
        })
    });
}

#[test]
fn a_magnified_frame_is_its_pixels_repeated() {
    shows_frame("magnification = 3.0\n", |code, shown| shown == code);
}

/// The display makes light of gamma 1.8, the frames are sRGB.
#[test]
fn a_session_corrects_for_the_display() {
    let text = "magnification = 3.0\n[transfer]\nkind = \"gamma\"\ngamma = 1.8\n";
    shows_frame(text, |code, shown| {
        let light = Transfer::Srgb.decode(f32::from(code) / 255.0);
        // Half a code by rounding, and what the curve bends in a code.
        (255.0 * light.powf(1.0 / 1.8) - f32::from(shown)).abs() < 0.6
    });
}
