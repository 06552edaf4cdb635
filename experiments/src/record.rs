//! The record: the study folder, the rows of answers, and the log.
//!
//! [`Study`](study::Study) is the folder, [`participants`] who is in it. [`rows`] reads and appends a
//! session's answers, [`log`] keeps what happened in it, [`heartbeat`] says who runs it. A [`Recorder`]
//! is all three for one session, and what a [`Session`](crate::session::Session) writes to. [`cohort`]
//! writes many simulated sessions at once, [`status`] looks at everything, [`withdraw`] takes a
//! participant out.

pub mod cohort;
mod frame_times;
pub mod heartbeat;
pub mod log;
pub mod participants;
pub mod rows;
pub mod status;
pub mod study;
pub mod withdraw;

use crate::playback::FrameTime;
use frame_times::FrameTimes;
use heartbeat::{Claim, State};
use log::Log;
use rows::RowFile;
use shutterlab_data_schema::definition::DefinitionError;
use shutterlab_data_schema::files::named;
use shutterlab_data_schema::{ParticipantCode, Response};
use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Takes down what happens in a session. What it has accepted survives a crash.
pub trait ResponseWriter {
    /// Notes that `trial` begins; returns the how-manieth time that is.
    ///
    /// # Errors
    /// It could not be noted.
    fn begin(&mut self, trial: u32) -> Result<u32, RecordError>;

    /// Writes an answer for good.
    ///
    /// # Errors
    /// It is not written, and can be tried again; or another program has taken the session over.
    fn write(&mut self, response: &Response) -> Result<(), RecordError>;

    /// Notes that `trial` will be asked again at the end, because of `why`, and the answer that is not
    /// kept, if there was one.
    ///
    /// # Errors
    /// It could not be noted; the same can be tried again.
    fn set_aside(
        &mut self,
        trial: u32,
        why: &str,
        response: Option<&Response>,
    ) -> Result<(), RecordError>;

    /// Notes when the frames of an attempt at `trial` were shown, as far as that can be done without
    /// holding anything up.
    fn frame_times(&mut self, trial: u32, attempt: u32, times: &[FrameTime]);
}

/// Something cannot be recorded, or what is there already does not fit. Nothing was lost.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// A file or folder cannot be read or written; the message names it.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The study's protocol cannot be read.
    #[error(transparent)]
    Protocol(#[from] DefinitionError),
    /// The study was begun with another protocol.
    #[error("{}: {key}: {there}, now {now}: a study is run with one protocol from its first session to its last; choose another study folder", file.display())]
    OtherProtocol {
        /// The study's protocol file.
        file: PathBuf,
        /// The first key that differs.
        key: String,
        /// Its value in the study.
        there: String,
        /// Its value now.
        now: String,
    },
    /// A file of the study is damaged.
    #[error("{}: line {line}: {what}; mend or move the file by hand, nothing was changed", file.display())]
    Damaged {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong.
        what: String,
    },
    /// Another program runs this very session.
    #[error("{}: locked: subject {subject} is being asked by another running session, at station {station} since {since}; leave that one first", file.display())]
    Locked {
        /// The lock, or the folder of the claims.
        file: PathBuf,
        /// The participant's code.
        subject: ParticipantCode,
        /// Where it runs.
        station: String,
        /// When it began, by the clock there.
        since: String,
    },
    /// Another program has taken the session over while this one stood still.
    #[error("{}: subject {subject}: this program stood still and another one has taken the session over; go on there, nothing more is written here", file.display())]
    TakenOver {
        /// The other one's claim.
        file: PathBuf,
        /// The participant's code.
        subject: ParticipantCode,
    },
    /// The code belongs to somebody who was withdrawn from the study.
    #[error("{}: subject {subject}: withdrawn at {at}: the code is not used again; choose another one", file.display())]
    Withdrawn {
        /// The trace of the withdrawal.
        file: PathBuf,
        /// The participant's code.
        subject: ParticipantCode,
        /// When the withdrawal began.
        at: String,
    },
    /// There is no such participant.
    #[error("{}: subject {subject}: no participant of this study has this code", folder.display())]
    Unknown {
        /// The study folder.
        folder: PathBuf,
        /// The participant's code.
        subject: ParticipantCode,
    },
    /// An answer to a question about the participant is none of its options.
    #[error("subject {subject}: {key}: {value:?}: allowed by the protocol: {}", allowed.join(", "))]
    NoOption {
        /// The participant's code.
        subject: ParticipantCode,
        /// The question's key.
        key: String,
        /// What was answered.
        value: String,
        /// The options; none if the protocol has no such question.
        allowed: Vec<String>,
    },
    /// People and simulated observers may not share a study.
    #[error("{}: observer: {observer}: the study holds answers of {holds}, and people and simulated observers never share one; choose another study folder", file.display())]
    Mixed {
        /// The study folder.
        file: PathBuf,
        /// Who was to be asked.
        observer: String,
        /// Whose answers the study holds.
        holds: String,
    },
    /// The code belongs to somebody else.
    #[error("{}: subject {subject}: {field}: {there}, now {now}: a code belongs to one observer; choose another one", file.display())]
    OtherParticipant {
        /// The record of the participant who has the code.
        file: PathBuf,
        /// The code.
        subject: ParticipantCode,
        /// What differs.
        field: &'static str,
        /// Its value in the study.
        there: String,
        /// Its value now.
        now: String,
    },
}

fn damaged(file: &Path, what: impl ToString) -> RecordError {
    RecordError::Damaged { file: file.into(), line: 1, what: what.to_string() }
}

/// `error` in the JSON of `file`.
fn unreadable(file: &Path, error: &serde_json::Error) -> RecordError {
    RecordError::Damaged {
        file: file.into(),
        line: error.line().max(1) as u64,
        what: error.to_string(),
    }
}

/// The files in `folder` whose names end in `ending`, in the order of their names; none if there is no
/// such folder. Files that are still being written are left out.
fn list(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, RecordError> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(vec![]),
        other => other.map_err(|e| named(folder, &e))?,
    };
    let mut files = Vec::new();
    for entry in entries {
        let name = entry.map_err(|e| named(folder, &e))?.file_name();
        if name.to_str().is_some_and(|name| !name.starts_with('.') && name.ends_with(ending)) {
            files.push(folder.join(name));
        }
    }
    files.sort();
    Ok(files)
}

/// Writes the rows and the journal of one session. While it lives, the session is claimed.
#[derive(Debug)]
pub struct Recorder {
    rows: RowFile<File>,
    log: Log,
    frame_times: FrameTimes,
    begun: HashMap<u32, u32>,
    set_aside: Vec<u32>,
    written: u32,
    /// Whether the journal says how the session ended.
    closed: bool,
    claim: Claim,
    /// Goes last: whoever gets it finds the claim ended.
    _lock: Option<File>,
}

impl Recorder {
    /// Answers written by this recorder.
    pub fn written(&self) -> u32 {
        self.written
    }

    /// The trials that were set aside so far, in that order.
    pub fn trials_set_aside(&self) -> &[u32] {
        &self.set_aside
    }

    /// The file that the answers are in.
    pub fn data_file(&self) -> &Path {
        self.rows.path()
    }

    /// The file of the journal.
    #[cfg(test)]
    pub(crate) fn journal(&self) -> &Path {
        self.log.path()
    }

    /// Adds a line to the session's journal.
    ///
    /// # Errors
    /// The journal cannot be written.
    pub fn note(&mut self, event: &str, detail: &str) -> Result<(), RecordError> {
        self.log.note(event, detail)?;
        self.closed |= matches!(event, log::LEFT | log::FINISHED);
        Ok(())
    }

    /// Lets the station's heartbeat say that no trial is being asked, as it does after every answer; the
    /// next trial ends that.
    fn pause(&self) {
        self.claim.tell(|heartbeat| heartbeat.state = State::Paused);
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.log.note(log::PANIC, "the program failed").ok();
        } else if !self.closed {
            // A program that ends with an error has not crashed.
            self.log.note(log::LEFT, "an error ended it").ok();
        }
    }
}

impl ResponseWriter for Recorder {
    fn begin(&mut self, trial: u32) -> Result<u32, RecordError> {
        self.claim.check()?;
        self.log.note(log::TRIAL_BEGUN, &trial.to_string())?;
        self.claim.tell(|heartbeat| {
            (heartbeat.trial, heartbeat.state) = (trial, State::Running);
        });
        let count = self.begun.entry(trial).or_default();
        *count += 1;
        Ok(*count)
    }

    fn write(&mut self, response: &Response) -> Result<(), RecordError> {
        self.claim.check()?;
        self.rows.append(response)?;
        self.written += 1;
        // Once more: if the program stood still just now, there may be an answer from elsewhere too.
        self.claim.check()?;
        self.pause();
        self.claim.tell(|heartbeat| heartbeat.late_frames += response.untimely_frames());
        Ok(())
    }

    fn set_aside(
        &mut self,
        trial: u32,
        why: &str,
        response: Option<&Response>,
    ) -> Result<(), RecordError> {
        self.claim.check()?;
        self.log.note_for_good(log::SET_ASIDE, &log::set_aside(trial, why, response))?;
        self.set_aside.push(trial);
        self.pause();
        Ok(())
    }

    fn frame_times(&mut self, trial: u32, attempt: u32, times: &[FrameTime]) {
        if let Err(error) = self.frame_times.append(trial, attempt, times) {
            // If the journal cannot be written either, the next answer will say so.
            self.log.note("no-frame-times", &error.to_string()).ok();
        }
    }
}
