//! The record: the study folder, the rows of answers, and the log.
//!
//! [`Study`](study::Study) is the folder. [`rows`] reads and appends a session's answers, [`log`]
//! keeps what happened in it. A [`Recorder`] is both for one session, under a lock, and what a
//! [`Session`](crate::session::Session) writes to.

pub mod log;
pub mod rows;
pub mod study;

use log::Log;
use rows::RowFile;
use shutterlab_data_schema::definition::DefinitionError;
use shutterlab_data_schema::{ParticipantCode, Response};
use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::path::PathBuf;

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
    /// It is not written; the same answer can be tried again.
    fn write(&mut self, response: &Response) -> Result<(), RecordError>;
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
    /// Another process runs this very session.
    #[error("{}: locked: subject {subject} is being asked by another running session", file.display())]
    Locked {
        /// The lock file.
        file: PathBuf,
        /// The participant's code.
        subject: ParticipantCode,
    },
    /// People and simulated observers may not share a study.
    #[error("{}: observer: {observer}: the study holds answers of {holds}, and people and simulated observers never share one; choose another study folder", file.display())]
    Mixed {
        /// The table of participants.
        file: PathBuf,
        /// Who was to be asked.
        observer: String,
        /// Whose answers the study holds.
        holds: String,
    },
    /// The code belongs to somebody else.
    #[error("{}: subject {subject}: {field}: {there}, now {now}: a code belongs to one observer; choose another one", file.display())]
    OtherParticipant {
        /// The table of participants.
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

/// Writes the rows and the log of one session. While it lives, the session is locked.
#[derive(Debug)]
pub struct Recorder {
    rows: RowFile<File>,
    log: Log,
    begun: HashMap<u32, u32>,
    written: u32,
    _lock: File,
}

impl Recorder {
    /// Answers written by this recorder.
    pub fn written(&self) -> u32 {
        self.written
    }

    /// The file that the answers are in.
    pub fn data_file(&self) -> &std::path::Path {
        self.rows.path()
    }

    /// Adds a line to the session's log.
    ///
    /// # Errors
    /// The log cannot be written.
    pub fn note(&mut self, event: &str, detail: &str) -> Result<(), RecordError> {
        Ok(self.log.note(event, detail)?)
    }
}

impl ResponseWriter for Recorder {
    fn begin(&mut self, trial: u32) -> Result<u32, RecordError> {
        self.log.note(log::TRIAL_BEGUN, &trial.to_string())?;
        let count = self.begun.entry(trial).or_default();
        *count += 1;
        Ok(*count)
    }

    fn write(&mut self, response: &Response) -> Result<(), RecordError> {
        self.rows.append(response)?;
        self.written += 1;
        Ok(())
    }
}
