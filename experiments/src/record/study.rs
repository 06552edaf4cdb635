//! The study folder: one protocol, its participants, and a data file, a log and a lock per session.
//!
//! Several stations may write into one study at once: what they share (protocol, participants,
//! descriptions) is written whole, by rename, under the study's lock.

use super::log::{self, Log};
use super::rows::{self, RowFile};
use super::{RecordError, Recorder};
use crate::stimuli_set::StimulusSet;
use jiff::Timestamp;
use serde_json::Value;
use shutterlab_data_schema::definition;
use shutterlab_data_schema::files::{create_folder, named, write_atomically};
use shutterlab_data_schema::study::{data_file_name, write_descriptions};
use shutterlab_data_schema::{Participant, ParticipantCode, Protocol, Response};
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Name in the records of an observer who is a person.
pub const PARTICIPANT: &str = "participant";

/// Folder inside a study that holds its pilot: a study of its own.
const PILOT_FOLDER: &str = "pilot";

/// A study folder that is open for sessions of one protocol.
#[derive(Clone, Debug)]
pub struct Study {
    folder: PathBuf,
    protocol: Protocol,
}

impl Study {
    /// Opens the study in `folder`, or begins it there; a pilot is a study inside that study.
    ///
    /// # Errors
    /// The folder cannot be made or written; it was begun with another protocol.
    pub fn open(folder: &Path, protocol: &Protocol, pilot: bool) -> Result<Self, RecordError> {
        let folder = if pilot { folder.join(PILOT_FOLDER) } else { folder.to_path_buf() };
        for part in ["data", "log", "thumbnails"] {
            create_folder(&folder.join(part))?;
        }
        let study = Self { folder, protocol: protocol.clone() };
        let _lock = study.lock()?;
        let file = study.folder.join("protocol.toml");
        if file.exists() {
            // Not `Protocol::read`: what a later version refuses may have been run by an earlier one.
            let there: Protocol = definition::read(&file)?;
            if there != *protocol {
                return Err(other_protocol(file, &there, protocol));
            }
        } else {
            let text = toml::to_string(protocol).map_err(io::Error::other)?;
            write_atomically(&file, text.as_bytes())?;
        }
        Ok(study)
    }

    /// Enters `subject`, who answers as `observer`, among the participants; the first time only.
    ///
    /// # Errors
    /// The table cannot be read or written; the code belongs to another observer; the study holds
    /// people and the observer is simulated, or the other way round.
    pub fn enter(
        &self,
        subject: &ParticipantCode,
        observer: &str,
        seed: u64,
    ) -> Result<(), RecordError> {
        let _lock = self.lock()?;
        let file = self.folder.join("participants.csv");
        let mut participants = read_participants(&file)?;
        if let Some(other) =
            participants.iter().find(|p| (p.observer == PARTICIPANT) != (observer == PARTICIPANT))
        {
            let holds = match other.observer.as_str() {
                PARTICIPANT => "people".into(),
                simulated => format!("simulated observers ({simulated})"),
            };
            return Err(RecordError::Mixed { file, observer: observer.into(), holds });
        }
        if let Some(there) = participants.iter().find(|p| p.subject == *subject) {
            let differing = if there.observer != observer {
                Some(("observer", there.observer.clone(), observer.to_string()))
            } else if there.seed != seed {
                Some(("seed", there.seed.to_string(), seed.to_string()))
            } else {
                None
            };
            let Some((field, there, now)) = differing else { return Ok(()) };
            let subject = subject.clone();
            return Err(RecordError::OtherParticipant { file, subject, field, there, now });
        }
        let alike =
            |p: &&Participant| p.subject.to_string().eq_ignore_ascii_case(&subject.to_string());
        if let Some(other) = participants.iter().find(alike) {
            let (subject, there) = (subject.clone(), other.subject.to_string());
            let (field, now) = ("code", subject.to_string());
            return Err(RecordError::OtherParticipant { file, subject, field, there, now });
        }
        participants.push(Participant {
            subject: subject.clone(),
            observer: observer.into(),
            seed,
            first_session: format!("{:.3}", Timestamp::now()),
        });
        let mut writer = csv::Writer::from_writer(vec![]);
        for participant in &participants {
            writer.serialize(participant).map_err(io::Error::other)?;
        }
        let bytes = writer.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
        Ok(write_atomically(&file, &bytes)?)
    }

    /// Opens session number `session` of `subject` for writing, and returns what it holds already.
    ///
    /// # Errors
    /// Another process runs it; a file cannot be read or written, or is damaged.
    pub fn session(
        &self,
        subject: &ParticipantCode,
        session: u32,
    ) -> Result<(Recorder, Vec<Response>), RecordError> {
        let name = data_file_name(&self.protocol, subject, session);
        let lock = self.lock_session(subject, name.trim_end_matches(".csv"))?;
        let log_path = self.folder.join("log").join(name.replace("_data.csv", ".log"));
        let mut log = Log::open(&log_path)?;
        let begun = log::trials_begun(&log_path)?;

        let path = self.folder.join("data").join(&name);
        let is_new = !path.exists();
        let found = rows::read(&path, &self.protocol.name, subject)?;
        if let Some(torn) = &found.torn {
            log.note("torn-row", torn)?;
            log.sync()?;
        }
        let rows = RowFile::open(&path, &found)?;
        log.note(if is_new { "began" } else { "resumed" }, env!("CARGO_PKG_VERSION"))?;
        let _lock = self.lock()?;
        write_descriptions(&self.folder, &self.protocol)?;
        Ok((Recorder { rows, log, begun, written: 0, _lock: lock }, found.rows))
    }

    /// Keeps the middle frame of every stimulus of `set` beside the data.
    ///
    /// # Errors
    /// A frame cannot be read or a file cannot be written.
    pub fn keep_thumbnails(&self, set: &StimulusSet) -> Result<(), RecordError> {
        for sequence in &set.sequences {
            let manifest = &sequence.manifest;
            let file = self.folder.join("thumbnails").join(format!("{}.png", manifest.stimulus.id));
            let middle = manifest.frames.get(manifest.frames.len() / 2);
            if let (false, Some(frame)) = (file.exists(), middle) {
                let image = sequence.read_frame(frame).map_err(io::Error::other)?;
                write_atomically(&file, &image.to_png()?)?;
            }
        }
        Ok(())
    }

    /// Waits for the study's lock, which goes with the file that is returned.
    fn lock(&self) -> io::Result<File> {
        let path = self.folder.join("log").join(".study.lock");
        let file = open_lock(&path)?;
        file.lock().map_err(|e| named(&path, &e))?;
        Ok(file)
    }

    fn lock_session(&self, subject: &ParticipantCode, name: &str) -> Result<File, RecordError> {
        let path = self.folder.join("log").join(format!(".{name}.lock"));
        let file = open_lock(&path)?;
        match file.try_lock() {
            Ok(()) => Ok(file),
            Err(TryLockError::WouldBlock) => {
                Err(RecordError::Locked { file: path, subject: subject.clone() })
            }
            Err(TryLockError::Error(error)) => Err(named(&path, &error).into()),
        }
    }
}

fn open_lock(path: &Path) -> io::Result<File> {
    let file = File::options().write(true).create(true).truncate(false).open(path);
    file.map_err(|e| named(path, &e))
}

fn read_participants(file: &Path) -> Result<Vec<Participant>, RecordError> {
    if !file.exists() {
        return Ok(vec![]);
    }
    let bytes = std::fs::read(file).map_err(|e| named(file, &e))?;
    let damaged = |error: csv::Error| RecordError::Damaged {
        file: file.into(),
        line: error.position().map_or(1, csv::Position::line),
        what: error.to_string(),
    };
    csv::Reader::from_reader(bytes.as_slice())
        .deserialize()
        .map(|row| row.map_err(damaged))
        .collect()
}

fn other_protocol(file: PathBuf, there: &Protocol, now: &Protocol) -> RecordError {
    let value = |protocol| serde_json::to_value(protocol).unwrap_or_default();
    let (key, there, now) = first_difference("", &value(there), &value(now))
        .unwrap_or_else(|| ("order of keys".into(), Value::Null, Value::Null));
    let text = |value: Value| match value {
        Value::Null => "left out".into(),
        other => other.to_string(),
    };
    RecordError::OtherProtocol { file, key, there: text(there), now: text(now) }
}

/// The path of the first key, in the order of `there`, whose values differ; and both values.
fn first_difference(path: &str, there: &Value, now: &Value) -> Option<(String, Value, Value)> {
    let (Value::Object(left), Value::Object(right)) = (there, now) else {
        return (there != now).then(|| (path.into(), there.clone(), now.clone()));
    };
    let keys = left.keys().chain(right.keys().filter(|key| !left.contains_key(*key)));
    keys.into_iter().find_map(|key| {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let value =
            |map: &serde_json::Map<String, Value>| map.get(key).cloned().unwrap_or_default();
        first_difference(&path, &value(left), &value(right))
    })
}

#[cfg(test)]
mod tests;
