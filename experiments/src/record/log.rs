//! The log of a session: one line per event, only ever appended. Time (UTC), event and detail are
//! separated by tabs.
//!
//! How often a trial was begun is known from here: its line is written before its first frame is
//! shown. The line is not synced, since that would hold up the display, so a power cut can lose it; a
//! killed program cannot.

use jiff::Timestamp;
use shutterlab_data_schema::files::named;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Event: a trial was begun. The detail is its number.
pub const TRIAL_BEGUN: &str = "trial-begun";

/// An open log.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: File,
}

impl Log {
    /// Opens the log at `path`, made if it is not there.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = File::options().append(true).create(true).open(path);
        Ok(Self { path: path.into(), file: file.map_err(|e| named(path, &e))? })
    }

    /// Appends a line. Control characters in `detail` are escaped.
    ///
    /// # Errors
    /// The line cannot be written.
    pub fn note(&mut self, event: &str, detail: &str) -> io::Result<()> {
        let line = format!("{:.3}\t{event}\t{}\n", Timestamp::now(), detail.escape_debug());
        self.file.write_all(line.as_bytes()).map_err(|e| named(&self.path, &e))
    }

    /// Sees to it that what was noted survives a power cut.
    ///
    /// # Errors
    /// The system cannot say so.
    pub fn sync(&mut self) -> io::Result<()> {
        self.file.sync_data().map_err(|e| named(&self.path, &e))
    }
}

/// How often each trial was begun according to the log at `path`.
///
/// # Errors
/// The file cannot be read.
pub fn trials_begun(path: &Path) -> io::Result<HashMap<u32, u32>> {
    let bytes = std::fs::read(path).map_err(|e| named(path, &e))?;
    let mut begun = HashMap::new();
    for line in String::from_utf8_lossy(&bytes).lines() {
        let mut parts = line.split('\t').skip(1);
        if parts.next() == Some(TRIAL_BEGUN)
            && let Some(trial) = parts.next().and_then(|text| text.parse().ok())
        {
            *begun.entry(trial).or_default() += 1;
        }
    }
    Ok(begun)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attempts_are_counted_from_the_log_even_with_a_torn_line_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.log");
        let mut log = Log::open(&path).unwrap();
        log.note("began", "session\t1\nnew line").unwrap();
        log.note(TRIAL_BEGUN, "3").unwrap();
        log.file.write_all(b"2026-11-2").unwrap();
        log.note(TRIAL_BEGUN, "4").unwrap();
        log.note(TRIAL_BEGUN, "3").unwrap();
        let begun = trials_begun(&path).unwrap();
        assert_eq!(begun.get(&3), Some(&2));
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.lines().next().unwrap().ends_with("\tbegan\tsession\\t1\\nnew line"));
    }
}
