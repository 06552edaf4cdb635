//! The journal of a session: one line per event, only ever appended. Time (UTC), event and detail are
//! separated by tabs.
//!
//! How often a trial was begun is known from here: its line is written before its first frame is
//! shown. The line is not synced, since that would hold up the display, so a power cut can lose it; a
//! killed program cannot.

use jiff::Timestamp;
use serde_json::{Value, json};
use shutterlab_data_schema::Response;
use shutterlab_data_schema::files::named;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Event: the session was opened for the first time. The detail is the program's version.
pub const BEGAN: &str = "began";
/// Event: the session was opened again. The detail is the program's version.
pub const RESUMED: &str = "resumed";
/// Event: the session was left before its end. The detail says how far it was.
pub const LEFT: &str = "left";
/// Event: the session came to its end.
pub const FINISHED: &str = "finished";
/// Event: the program that ran the session before had neither left nor finished it. The detail is what
/// was last heard of it.
pub const CRASHED: &str = "crashed";
/// Event: a trial was begun. The detail is its number.
pub const TRIAL_BEGUN: &str = "trial-begun";
/// Event: a trial will be asked again at the end. The detail is JSON: its number, why, and the answer
/// that is not kept.
pub const SET_ASIDE: &str = "set-aside";
/// Event: half a row was cut off the answers. The detail is the half row.
pub const TORN_ROW: &str = "torn-row";
/// Event: the program failed: a crash that could still be noted.
pub const PANIC: &str = "panic";

/// An open journal.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: File,
    /// Part of a line may lie at the end.
    torn: bool,
    /// Detail of a line that is written, but could not be synced.
    unsynced: Option<String>,
}

impl Log {
    /// Opens the journal at `path`, made if it is not there.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        let open = || {
            let file = File::options().append(true).create(true).open(path)?;
            let bytes = std::fs::read(path)?;
            let torn = bytes.last().is_some_and(|b| *b != b'\n');
            Ok(Self { path: path.into(), file, torn, unsynced: None })
        };
        open().map_err(|e: io::Error| named(path, &e))
    }

    /// Where it is.
    #[cfg(test)]
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Appends a line. Control characters in `detail` are escaped.
    ///
    /// # Errors
    /// The line cannot be written.
    pub fn note(&mut self, event: &str, detail: &str) -> io::Result<()> {
        // A field too many, so that half a number is not read as a whole one.
        let end_of_torn = if self.torn { "\t(torn)\n" } else { "" };
        let text = format!("{end_of_torn}{}", line(event, detail));
        let written = self.file.write_all(text.as_bytes());
        self.torn = written.is_err();
        written.map_err(|e| named(&self.path, &e))
    }

    /// Appends a line that survives a power cut.
    ///
    /// # Errors
    /// The line cannot be written, or the system cannot say that it is safe. The same can be tried again,
    /// and is there once.
    pub fn note_for_good(&mut self, event: &str, detail: &str) -> io::Result<()> {
        if self.unsynced.as_deref() != Some(detail) {
            self.note(event, detail)?;
            self.unsynced = Some(detail.into());
        }
        self.file.sync_data().map_err(|e| named(&self.path, &e))?;
        self.unsynced = None;
        Ok(())
    }
}

/// A line of a journal.
pub(super) fn line(event: &str, detail: &str) -> String {
    let mut line = format!("{:.3}\t{event}\t", Timestamp::now());
    for character in detail.chars() {
        match character.is_control() {
            true => line.extend(character.escape_default()),
            false => line.push(character),
        }
    }
    line.push('\n');
    line
}

/// The detail of [`SET_ASIDE`].
pub(super) fn set_aside(trial: u32, why: &str, response: Option<&Response>) -> String {
    json!({ "trial": trial, "why": why, "response": response }).to_string()
}

/// What a journal says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Story {
    /// How often each trial was begun.
    pub trials_begun: HashMap<u32, u32>,
    /// The last event that is about the whole session: time, event and detail.
    pub last: Option<[String; 3]>,
    /// The trials that were set aside, in that order.
    pub set_aside: Vec<u32>,
    /// How often the session crashed.
    pub crashes: u32,
}

impl Story {
    /// Reads the journal at `path`; one that is not there says nothing. Torn lines are passed over.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(path: &Path) -> io::Result<Self> {
        let bytes = match std::fs::read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            other => other.map_err(|e| named(path, &e))?,
        };
        let text = String::from_utf8_lossy(&bytes);
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut story = Self::default();
        for line in whole.lines() {
            let [time, event, detail] = line.split('\t').collect::<Vec<_>>()[..] else { continue };
            match event {
                TRIAL_BEGUN => {
                    if let Ok(trial) = detail.parse() {
                        *story.trials_begun.entry(trial).or_default() += 1;
                    }
                }
                SET_ASIDE => {
                    let detail: Value = serde_json::from_str(detail).unwrap_or_default();
                    story.set_aside.extend(detail["trial"].as_u64().map(|trial| trial as u32));
                }
                BEGAN | RESUMED | LEFT | FINISHED | CRASHED => {
                    story.crashes += u32::from(event == CRASHED);
                    story.last = Some([time, event, detail].map(String::from));
                }
                _ => {}
            }
        }
        Ok(story)
    }

    /// The last event that is about the whole session.
    pub fn last_event(&self) -> Option<&str> {
        self.last.as_ref().map(|[_, event, _]| event.as_str())
    }

    /// Whether the program that last opened the session neither left nor finished it.
    pub fn is_open(&self) -> bool {
        matches!(self.last_event(), Some(BEGAN | RESUMED))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attempts_are_counted_even_with_torn_lines() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.log");
        let mut log = Log::open(&path).unwrap();
        log.note(BEGAN, "session\t1\nnew line").unwrap();
        log.note(TRIAL_BEGUN, "3").unwrap();
        // Torn within the time, within the event, and within the number of trial 12.
        for torn in
            ["2026-11-2", "2026-11-22T06:00:00Z\ttrial-be", "2026-11-22T06:00:00Z\ttrial-begun\t1"]
        {
            log.file.write_all(torn.as_bytes()).unwrap();
            log = Log::open(&path).unwrap();
            log.note(TRIAL_BEGUN, "3").unwrap();
        }
        log.file.write_all(b"2026-11-22T06:00:00Z\ttrial-begun\t4").unwrap();
        let story = Story::read(&path).unwrap();
        assert_eq!(story.trials_begun, HashMap::from([(3, 4)]));
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.lines().next().unwrap().ends_with("\tbegan\tsession\\t1\\nnew line"));
    }

    /// A pipe takes what is written and cannot be synced.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_line_that_could_not_be_synced_is_not_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.log");
        let mut log = Log::open(&path).unwrap();
        let (mut reader, writer) = io::pipe().unwrap();
        let disk = std::mem::replace(&mut log.file, File::from(std::os::fd::OwnedFd::from(writer)));
        for _ in 0..2 {
            let error = log.note_for_good(SET_ASIDE, "late").unwrap_err().to_string();
            assert!(error.contains("s.log"), "{error}");
        }
        log.file = disk;
        // The disk can be synced again: the same is safe now, and what comes next is another line.
        log.note_for_good(SET_ASIDE, "late").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "");
        log.note_for_good(SET_ASIDE, "late").unwrap();
        let text =
            [io::read_to_string(&mut reader).unwrap(), std::fs::read_to_string(&path).unwrap()];
        assert!(text.iter().all(|text| text.lines().count() == 1), "{text:?}");
    }

    #[test]
    fn the_last_word_about_the_session_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.log");
        assert_eq!(Story::read(&path).unwrap(), Story::default());
        let mut log = Log::open(&path).unwrap();
        for (event, open) in [(BEGAN, true), (LEFT, false), (RESUMED, true), (CRASHED, false)] {
            log.note(event, "").unwrap();
            log.note(SET_ASIDE, r#"{"trial":7,"why":"late \"frames\""}"#).unwrap();
            let story = Story::read(&path).unwrap();
            assert_eq!((story.last_event(), story.is_open()), (Some(event), open));
        }
        let story = Story::read(&path).unwrap();
        assert_eq!((story.set_aside.clone(), story.crashes), (vec![7; 4], 1));
    }
}
