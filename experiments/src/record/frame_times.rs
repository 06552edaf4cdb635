//! When each frame of a session was due and when it was shown: a CSV beside the journal, so that anybody
//! can count late frames in their own way. It says no more than the rows do, so it is not synced, and a
//! frame that could not be noted stops no answer.

use crate::playback::FrameTime;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Columns of the file. Times are in seconds since the session was opened.
const HEADER: &str = "trial,attempt,interval,replay,frame,due_s,shown_s\n";

/// The file of one session; it is made with its first frame.
#[derive(Debug)]
pub(super) struct FrameTimes {
    path: PathBuf,
    file: Option<File>,
}

impl FrameTimes {
    pub(super) fn new(path: &Path) -> Self {
        Self { path: path.into(), file: None }
    }

    /// Appends the frames of a trial.
    pub(super) fn append(
        &mut self,
        trial: u32,
        attempt: u32,
        times: &[FrameTime],
    ) -> io::Result<()> {
        let mut lines = String::new();
        let file = match &mut self.file {
            Some(file) => file,
            none => {
                let file = File::options().append(true).create(true).open(&self.path)?;
                if file.metadata()?.len() == 0 {
                    lines.push_str(HEADER);
                }
                none.insert(file)
            }
        };
        for FrameTime { interval, replay, frame, due_s, shown_s } in times {
            lines +=
                &format!("{trial},{attempt},{interval},{replay},{frame},{due_s:.6},{shown_s:.6}\n");
        }
        file.write_all(lines.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_comes_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames.csv");
        let time = FrameTime { interval: 1, replay: 0, frame: 3, due_s: 1.1, shown_s: 1.125 };
        for attempt in [1, 2] {
            FrameTimes::new(&path).append(7, attempt, &[time]).unwrap();
        }
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            format!("{HEADER}7,1,1,0,3,1.100000,1.125000\n7,2,1,0,3,1.100000,1.125000\n")
        );
    }
}
