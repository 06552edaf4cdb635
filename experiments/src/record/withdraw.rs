//! Taking a participant out of a study.
//!
//! First a trace is written that says so, last it is marked as completed. Killed in between, the
//! withdrawal can be run again and completes. The trace keeps the code, times and counts, nothing else;
//! the code is never used again.

use super::heartbeat::CLAIMS;
use super::study::{SessionFiles, Study};
use super::{RecordError, list, participants, unreadable};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::ParticipantCode;
use shutterlab_data_schema::files::{create_atomically, named, write_atomically};
use shutterlab_data_schema::study::{until_settled, write_descriptions};
use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

/// Folder of the traces.
pub(super) const RECORDS: &str = "log/withdrawn";

/// What is left of a participant who was withdrawn: a row of `log/withdrawn.csv`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Withdrawal {
    /// The code.
    pub subject: ParticipantCode,
    /// When the withdrawal began (UTC, RFC 3339).
    pub withdrawn_at: String,
    /// Answers removed.
    pub rows: u64,
    /// Files removed, claims and locks not counted.
    pub files: u64,
    /// When everything was removed; empty if the withdrawal was interrupted and has to be run again.
    pub completed_at: Option<String>,
}

/// The traces in the study in `folder`.
///
/// # Errors
/// One cannot be read.
pub(super) fn traces(folder: &Path) -> Result<Vec<Withdrawal>, RecordError> {
    list(&folder.join(RECORDS), ".json")?.iter().map(|file| read(file)).collect()
}

/// Refuses a code that was withdrawn.
pub(super) fn refuse_withdrawn(
    folder: &Path,
    subject: &ParticipantCode,
) -> Result<(), RecordError> {
    match find(folder, subject)? {
        None => Ok(()),
        Some(trace) => Err(RecordError::Withdrawn {
            file: path(folder, subject),
            subject: subject.clone(),
            at: trace.withdrawn_at,
        }),
    }
}

fn path(folder: &Path, subject: &ParticipantCode) -> PathBuf {
    folder.join(RECORDS).join(format!("{}.json", subject.file_name()))
}

fn find(folder: &Path, subject: &ParticipantCode) -> Result<Option<Withdrawal>, RecordError> {
    let path = path(folder, subject);
    if path.exists() { read(&path).map(Some) } else { Ok(None) }
}

fn read(file: &Path) -> Result<Withdrawal, RecordError> {
    let bytes = std::fs::read(file).map_err(|e| named(file, &e))?;
    serde_json::from_slice(&bytes).map_err(|error| unreadable(file, &error))
}

fn bytes(trace: &Withdrawal) -> io::Result<Vec<u8>> {
    Ok(serde_json::to_vec_pretty(trace)?)
}

impl Study {
    /// Removes the answers, the record and the journals of `subject`, and leaves a trace. If that is
    /// interrupted, it can be done again and completes.
    ///
    /// # Errors
    /// There is no such participant; a session of the participant runs; the withdrawal was completed
    /// before; a file cannot be read, written or removed.
    pub fn withdraw(&self, subject: &ParticipantCode) -> Result<Withdrawal, RecordError> {
        self.withdraw_with(subject, &mut remove)
    }

    fn withdraw_with(
        &self,
        subject: &ParticipantCode,
        remove: &mut dyn FnMut(&Path) -> io::Result<()>,
    ) -> Result<Withdrawal, RecordError> {
        let folder = &self.folder;
        let begun = find(folder, subject)?;
        if begun.as_ref().is_some_and(|trace| trace.completed_at.is_some()) {
            refuse_withdrawn(folder, subject)?;
        }
        let record = participants::find(folder, subject)?;
        let other = record.is_some_and(|record| record.participant.subject != *subject);
        let sessions = self.sessions(subject)?;
        let record = participants::path(folder, subject);
        if other || begun.is_none() && sessions.is_empty() && !record.exists() {
            let (folder, subject) = (folder.clone(), subject.clone());
            return Err(RecordError::Unknown { folder, subject });
        }
        // Refused before there is a trace; and then again, for a session that began meanwhile.
        self.claim_all(subject, &sessions)?;
        let mut trace = match begun {
            Some(trace) => trace,
            None => {
                let files = sessions
                    .iter()
                    .flat_map(|files| [&files.data, &files.journal, &files.frame_times]);
                let files = files.chain([&record]).filter(|file| file.exists()).count() as u64;
                let trace = Withdrawal {
                    subject: subject.clone(),
                    withdrawn_at: format!("{:.3}", Timestamp::now()),
                    rows: sessions
                        .iter()
                        .map(|files| rows(&files.data))
                        .sum::<io::Result<u64>>()?,
                    files,
                    completed_at: None,
                };
                create_atomically(&path(folder, subject), &bytes(&trace)?)?;
                trace
            }
        };
        let sessions = self.sessions(subject)?;
        self.claim_all(subject, &sessions)?;
        for files in &sessions {
            [&files.data, &files.journal, &files.frame_times, &files.claims]
                .into_iter()
                .try_for_each(|f| remove(f))?;
        }
        remove(&record)?;
        participants::write_table(folder, &self.protocol)?;
        write_descriptions(folder, &self.protocol, self.kind)?;
        trace.completed_at = Some(format!("{:.3}", Timestamp::now()));
        write_atomically(&path(folder, subject), &bytes(&trace)?)?;
        write_table(folder)?;
        Ok(trace)
    }

    /// Claims `sessions` for a moment: nobody runs them.
    fn claim_all(
        &self,
        subject: &ParticipantCode,
        sessions: &[SessionFiles],
    ) -> Result<(), RecordError> {
        sessions.iter().try_for_each(|files| files.claim(&self.station, subject, 0, 0).map(drop))
    }

    /// The files of every session of `subject` of which there is any.
    fn sessions(&self, subject: &ParticipantCode) -> Result<Vec<SessionFiles>, RecordError> {
        let mut names = BTreeSet::new();
        for (folder, ending) in [("data", "_data.csv"), ("log", ".log"), (CLAIMS, "")] {
            for file in list(&self.folder.join(folder), ending)? {
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let name = name.trim_end_matches(ending);
                if name.contains(&format!("_subject-{subject}_")) {
                    names.insert(format!("{name}_data.csv"));
                }
            }
        }
        Ok(names.iter().map(|name| SessionFiles::new(&self.folder, name)).collect())
    }
}

/// Removes a file or a folder; what is not there is removed.
fn remove(path: &Path) -> io::Result<()> {
    let removed =
        if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(named(path, &error)),
        _ => Ok(()),
    }
}

/// Rows in the file of answers, damaged ones included.
fn rows(file: &Path) -> io::Result<u64> {
    if !file.exists() {
        return Ok(0);
    }
    let reader = csv::ReaderBuilder::new().flexible(true).from_path(file);
    let mut reader = reader.map_err(|e| named(file, &e.into()))?;
    Ok(reader.byte_records().filter(Result::is_ok).count() as u64)
}

/// Makes `log/withdrawn.csv` from the traces.
fn write_table(folder: &Path) -> Result<(), RecordError> {
    until_settled(
        || traces(folder),
        |traces| {
            let mut writer = csv::Writer::from_writer(vec![]);
            for trace in traces {
                writer.serialize(trace).map_err(io::Error::from)?;
            }
            let bytes = writer.into_inner().map_err(|e| io::Error::other(e.to_string()))?;
            Ok(write_atomically(&folder.join("log/withdrawn.csv"), &bytes)?)
        },
    )
}

#[cfg(test)]
mod tests;
