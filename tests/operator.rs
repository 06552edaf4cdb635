//! The operator's pages in a real window: what is typed and chosen there, consent, and displays that are
//! refused.

use crate::support::{fail, guess, read_table, shutterlab, small_stimuli, succeed};
use crate::window::{BUTTON, Screen, wait_until};
use std::fs::File;
use std::path::Path;
use std::process::{Child, Stdio};

const PROTOCOL: &str = r#"
schema = 1
name = "asks"
title = "Asks about people"
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

[[participant]]
key = "age"
label = "Age"
options = ["18 to 29", "30 or more"]

[[participant]]
key = "vision"
label = "Vision"
options = ["normal", "corrected"]

[text]
consent = "Do you agree?"
instructions = "Look."
after_practice = "Now it counts."
pause = "Rest."
end = "Thank you."
"#;

/// A session of `protocol` without a code, in a window on `screen`.
struct Session<'a> {
    screen: &'a Screen,
    program: Child,
    folder: &'a Path,
}

impl<'a> Session<'a> {
    fn begin(screen: &'a Screen, folder: &'a Path, protocol: &str) -> Self {
        std::fs::write(folder.join("protocol.toml"), protocol).unwrap();
        let mut command = shutterlab();
        command
            .current_dir(folder)
            .args(["run", "protocol.toml", "--study", "study", "--stimuli"])
            .arg(small_stimuli())
            .env("DISPLAY", &screen.display)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .stdin(Stdio::null())
            .stdout(File::create(folder.join("stdout")).unwrap())
            .stderr(File::create(folder.join("stderr")).unwrap());
        Self { screen, program: command.spawn().unwrap(), folder }
    }

    /// Waits for the form, which comes after the check of the display, and presses `keys` there.
    fn fill_in(&self, keys: &[&str]) {
        wait_until("the form", || {}, || self.screen.picture().holds(BUTTON));
        press(self.screen, keys);
    }

    /// Presses `keys` until the program ends; returns its status and what it said.
    fn leave(mut self, keys: &[&str]) -> (Option<i32>, String) {
        let (screen, program, mut status) = (self.screen, &mut self.program, None);
        wait_until(
            "the program ends",
            || press(screen, keys),
            || {
                status = program.try_wait().unwrap();
                status.is_some()
            },
        );
        let said = std::fs::read_to_string(self.folder.join("stderr")).unwrap();
        (status.unwrap().code(), said)
    }
}

/// Presses `keys` in the window, if it is there.
fn press(screen: &Screen, keys: &[&str]) {
    let found = screen.xdotool(&["search", "--onlyvisible", "--name", "^Shutterlab"]);
    if let Some(window) = found.lines().next() {
        screen.xdotool(&["windowfocus", window]);
        screen.xdotool(&[&["key"], keys].concat());
    }
}

impl Drop for Session<'_> {
    fn drop(&mut self) {
        self.program.kill().ok();
        self.program.wait().ok();
    }
}

#[test]
fn the_form_and_the_consent_are_recorded() {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let session = Session::begin(&screen, folder.path(), PROTOCOL);
    let participants = folder.path().join("study/participants.csv");
    session.fill_in(&["P", "7", "Down", "Right", "Right", "Down", "Right", "Return"]);
    wait_until("somebody is entered", || press(&screen, &["y"]), || participants.exists());
    let rows = read_table(&participants);
    assert_eq!(rows.len(), 1);
    assert_eq!(rows[0]["subject"], "P7");
    assert_eq!((rows[0]["age"].as_str(), rows[0]["vision"].as_str()), ("30 or more", "normal"));
    // It is asked for before anything is recorded.
    let [consent, session_at] = ["consented_at", "first_session"].map(|column| &rows[0][column]);
    assert!(!consent.is_empty() && consent <= session_at, "{rows:?}");
    assert_eq!(rows[0]["ordinal"], "1");
    let (status, said) = session.leave(&["Escape", "l"]);
    assert_eq!(status, Some(0), "{said}");
}

#[test]
fn without_consent_nothing_is_recorded() {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let session = Session::begin(&screen, folder.path(), PROTOCOL);
    session.fill_in(&["P", "7", "Down", "Right", "Down", "Right", "Return"]);
    let (status, said) = session.leave(&["n"]);
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("nothing was recorded"), "{said}");
    assert!(!folder.path().join("study/participants.csv").exists());
}

#[test]
fn a_display_that_does_not_fit_is_refused_if_the_protocol_says_so() {
    let Some(screen) = Screen::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let protocol = PROTOCOL.replace("[[participant]]\nkey = \"age\"", "[presentation]\ndisplay_check = \"refuse\"\nrefresh = \"refuse\"\n\n[[participant]]\nkey = \"age\"");
    let session = Session::begin(&screen, folder.path(), &protocol);
    // The virtual screen paces nothing.
    let (status, said) = session.leave(&["Return"]);
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("error: run: display: ") && said.contains("refresh: unknown"), "{said}");
    assert!(!folder.path().join("study/participants.csv").exists());
}

/// Whoever would analyse people's answers never gets those of simulated observers.
#[test]
fn simulated_answers_are_analysed_only_by_name() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &guess("study", "S01"));
    let error = fail(folder.path(), 1, &["analyze", "study"]);
    assert!(error.contains("study"), "{error}");
    assert!(succeed(folder.path(), &["analyze", "study/simulated"]).contains("Simulated"));
}
