//! Thousands of simulated sessions at once.
//!
//! A session's rows are kept in memory and written whole at its end. A run that is killed leaves whole
//! sessions only, and can be run again. Nothing waits for the disk: what a power cut takes away is
//! made again by running the cohort into a new folder.

use super::log;
use super::participants::{self, NewParticipant, Ordinals, PARTICIPANT};
use super::rows::header;
use super::study::{SessionFiles, Study};
use super::{RecordError, ResponseWriter, withdraw};
use crate::playback::FrameTime;
use shutterlab_data_schema::files::create_unsynced;
use shutterlab_data_schema::study::{StudyKind, write_descriptions};
use shutterlab_data_schema::{Participant, ParticipantCode, Response};
use std::collections::HashMap;
use std::io;

/// Simulated observers of a study, entered together. Their sessions can be written from several threads.
#[derive(Debug)]
pub struct Cohort<'a> {
    study: &'a Study,
    participants: Vec<Participant>,
}

impl Study {
    /// Enters `observers`, who must be simulated, in this order; those already entered stay as they are.
    ///
    /// # Errors
    /// As [`Study::enter`]; the study is not one of simulated observers.
    pub fn cohort(&self, observers: &[NewParticipant]) -> Result<Cohort<'_>, RecordError> {
        let mut ordinals = Ordinals::read(&self.folder)?;
        let mut participants = Vec::with_capacity(observers.len());
        for new in observers {
            if self.kind != StudyKind::Simulated || new.observer == PARTICIPANT {
                let (file, observer) = (self.folder.clone(), new.observer.clone());
                let holds = "others than simulated observers".into();
                return Err(RecordError::Mixed { file, observer, holds });
            }
            withdraw::refuse_withdrawn(&self.folder, &new.subject)?;
            if let Some(there) = participants::find(&self.folder, &new.subject)? {
                participants.push(participants::same(&self.folder, new, there)?);
                continue;
            }
            let ordinal = ordinals.give(&new.subject, create_unsynced)?;
            let made = self.record(new).made(ordinal);
            let path = participants::path(&self.folder, &new.subject);
            participants.push(if create_unsynced(&path, &participants::record_bytes(&made)?)? {
                made.participant
            } else {
                participants::same(&self.folder, new, participants::read(&path)?)?
            });
        }
        Ok(Cohort { study: self, participants })
    }
}

impl Cohort<'_> {
    /// The observers, in the order in which they were given.
    pub fn participants(&self) -> &[Participant] {
        &self.participants
    }

    /// What takes down session number `session` of `subject`; none if the session is there already.
    pub fn writer(&self, subject: &ParticipantCode, session: u32) -> Option<SessionWriter> {
        let files = self.study.files(subject, session);
        let is_new = !files.data.exists();
        let journal = log::line(log::BEGAN, env!("CARGO_PKG_VERSION"));
        is_new.then(|| SessionWriter {
            files,
            journal,
            rows: csv::WriterBuilder::new().has_headers(false).from_writer(header().to_vec()),
            begun: HashMap::new(),
        })
    }

    /// Writes the table of participants and the descriptions, and then waits for the disk, once.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub fn finish(self) -> Result<(), RecordError> {
        participants::write_table(&self.study.folder, &self.study.protocol)?;
        write_descriptions(&self.study.folder, &self.study.protocol, self.study.kind)?;
        #[cfg(unix)]
        rustix::fs::sync();
        Ok(())
    }
}

/// Takes down one session of a cohort.
#[derive(Debug)]
pub struct SessionWriter {
    files: SessionFiles,
    journal: String,
    rows: csv::Writer<Vec<u8>>,
    begun: HashMap<u32, u32>,
}

impl SessionWriter {
    /// Writes the session, which is finished.
    ///
    /// # Errors
    /// A file cannot be written; or the session was written elsewhere meanwhile, and is left as it is.
    pub fn finish(mut self) -> Result<(), RecordError> {
        self.journal += &log::line(log::FINISHED, "");
        // The answers last: without them the session is not there, and is written again.
        create_unsynced(&self.files.journal, self.journal.as_bytes())?;
        let rows = self.rows.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
        create_unsynced(&self.files.data, &rows)?;
        Ok(())
    }
}

impl ResponseWriter for SessionWriter {
    fn begin(&mut self, trial: u32) -> Result<u32, RecordError> {
        let count = self.begun.entry(trial).or_default();
        *count += 1;
        Ok(*count)
    }

    fn write(&mut self, response: &Response) -> Result<(), RecordError> {
        Ok(self.rows.serialize(response).map_err(io::Error::from)?)
    }

    // The simulated display is in time.
    fn frame_times(&mut self, _: u32, _: u32, _: &[FrameTime]) {}

    fn set_aside(
        &mut self,
        trial: u32,
        why: &str,
        response: Option<&Response>,
    ) -> Result<(), RecordError> {
        self.journal += &log::line(log::SET_ASIDE, &log::set_aside(trial, why, response));
        Ok(())
    }
}

#[cfg(test)]
mod tests;
