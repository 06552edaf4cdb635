//! The study folder: one protocol, its participants, and a data file, a journal and claims per session.
//!
//! Several stations may write into one study at once, also on a network share: what they share is
//! either created by one of them, or made anew from what is there until nothing has changed meanwhile.

use super::frame_times::FrameTimes;
use super::heartbeat::{self, CLAIMS, Claim, Heartbeat};
use super::log::{self, Log, Story};
use super::participants::{self, NewParticipant, NewRecord, PARTICIPANT};
use super::rows::{self, RowFile};
use super::{RecordError, Recorder, withdraw};
use crate::stimuli_set::StimulusSet;
use serde_json::Value;
use sha2::{Digest, Sha256};
use shutterlab_data_schema::definition;
use shutterlab_data_schema::files::{create_atomically, create_folder, named, write_atomically};
use shutterlab_data_schema::study::{StudyKind, data_file_name, write_descriptions};
use shutterlab_data_schema::{Participant, ParticipantCode, Protocol, Response};
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// A study folder that is open for sessions of one protocol.
#[derive(Clone, Debug)]
pub struct Study {
    pub(super) folder: PathBuf,
    pub(super) protocol: Protocol,
    pub(super) kind: StudyKind,
    pub(super) station: String,
    consent_sha256: Option<String>,
}

impl Study {
    /// Opens the study in `folder`, or begins it there; one of pilot or simulated answers is a study
    /// inside that study.
    ///
    /// # Errors
    /// The folder cannot be made or written; it was begun with another protocol.
    pub fn open(folder: &Path, protocol: &Protocol, kind: StudyKind) -> Result<Self, RecordError> {
        let folder = kind.folder(folder);
        let parts = ["data", "thumbnails", CLAIMS, participants::RECORDS, participants::ORDINALS];
        for part in parts.into_iter().chain([withdraw::RECORDS]) {
            create_folder(&folder.join(part))?;
        }
        if let Some(banner) = kind.banner() {
            create_atomically(&folder.join("README.md"), format!("# {banner}\n").as_bytes())?;
        }
        let file = folder.join("protocol.toml");
        let text = toml::to_string(protocol).map_err(io::Error::other)?;
        if file.exists() || !create_atomically(&file, text.as_bytes())? {
            // Not `Protocol::read`: what a later version refuses may have been run by an earlier one.
            let there: Protocol = definition::read(&file)?;
            if there != *protocol {
                return Err(other_protocol(file, &there, protocol));
            }
        }
        let consent = protocol.text.consent.as_ref();
        let consent_sha256 = consent
            .map(|text| Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect());
        let (protocol, station) = (protocol.clone(), heartbeat::station_name());
        Ok(Self { folder, protocol, kind, station, consent_sha256 })
    }

    /// Opens the study in `folder` with the protocol that it was begun with.
    ///
    /// # Errors
    /// There is none; a file cannot be read or written.
    pub fn existing(folder: &Path, kind: StudyKind) -> Result<Self, RecordError> {
        let protocol = definition::read(&kind.folder(folder).join("protocol.toml"))?;
        Self::open(folder, &protocol, kind)
    }

    /// The same study as seen from the computer called `station`.
    pub fn at_station(self, station: &str) -> Self {
        Self { station: station.into(), ..self }
    }

    /// Name of this computer.
    pub fn station(&self) -> &str {
        &self.station
    }

    /// Where the study lies.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The participant called `subject`, if there is one already.
    ///
    /// # Errors
    /// The record cannot be read; the code belongs to somebody who was withdrawn.
    pub fn find(&self, subject: &ParticipantCode) -> Result<Option<Participant>, RecordError> {
        withdraw::refuse_withdrawn(&self.folder, subject)?;
        Ok(participants::find(&self.folder, subject)?.map(|record| record.participant))
    }

    /// Enters a participant, the first time only, and says who it is.
    ///
    /// # Errors
    /// A record cannot be read or written; the code belongs to another observer, or to somebody who was
    /// withdrawn; an answer is none of the options that the protocol gives; the study holds people and
    /// the observer is simulated, or the other way round.
    pub fn enter(&self, new: &NewParticipant) -> Result<Participant, RecordError> {
        withdraw::refuse_withdrawn(&self.folder, &new.subject)?;
        self.check_fields(new)?;
        self.check_observer(new)?;
        let participant = participants::enter(&self.folder, self.record(new))?;
        participants::write_table(&self.folder, &self.protocol)?;
        Ok(participant)
    }

    /// `new` and what the study adds.
    pub(super) fn record<'a>(&'a self, new: &'a NewParticipant) -> NewRecord<'a> {
        NewRecord { new, station: &self.station, consent_sha256: self.consent_sha256.as_deref() }
    }

    fn check_fields(&self, new: &NewParticipant) -> Result<(), RecordError> {
        for (key, value) in &new.fields {
            let field = self.protocol.participant.iter().find(|field| field.key == *key);
            let allowed = field.map_or(&[][..], |field| &field.options);
            if !allowed.contains(value) {
                return Err(RecordError::NoOption {
                    subject: new.subject.clone(),
                    key: key.clone(),
                    value: value.clone(),
                    allowed: allowed.to_vec(),
                });
            }
        }
        Ok(())
    }

    fn check_observer(&self, new: &NewParticipant) -> Result<(), RecordError> {
        let is_person = new.observer == PARTICIPANT;
        let mixed = |holds: String| {
            let (file, observer) = (self.folder.clone(), new.observer.clone());
            Err(RecordError::Mixed { file, observer, holds })
        };
        match self.kind {
            StudyKind::Real if !is_person => return mixed("people".into()),
            StudyKind::Simulated if is_person => return mixed("simulated observers".into()),
            StudyKind::Real | StudyKind::Simulated => return Ok(()),
            // Either may answer, but not both.
            StudyKind::Pilot => {}
        }
        for file in participants::files(&self.folder)? {
            let observer = participants::read(&file)?.participant.observer;
            match (observer == PARTICIPANT, is_person) {
                (true, false) => return mixed("people".into()),
                (false, true) => return mixed(format!("simulated observers ({observer})")),
                _ => {}
            }
        }
        Ok(())
    }

    /// Opens session number `session` of `subject`, of `trials` trials, for writing, and returns what it
    /// holds already. If the program that claimed it on another computer gives no sign of life, this takes
    /// some seconds.
    ///
    /// # Errors
    /// Another program runs it; the participant was withdrawn; a file cannot be read or written, or is
    /// damaged.
    pub fn session(
        &self,
        subject: &ParticipantCode,
        session: u32,
        trials: u32,
    ) -> Result<(Recorder, Vec<Response>), RecordError> {
        withdraw::refuse_withdrawn(&self.folder, subject)?;
        let files = self.files(subject, session);
        let (claim, crashed, lock) = files.claim(&self.station, subject, session, trials)?;
        // Once more, since a withdrawal claims the sessions after it has said that it begins.
        withdraw::refuse_withdrawn(&self.folder, subject)?;
        let story = Story::read(&files.journal)?;
        let mut log = Log::open(&files.journal)?;
        if crashed.is_some() || story.is_open() {
            let last = crashed.map_or("nothing was heard of it".into(), |last| {
                let Heartbeat { station, process, trial, of, updated_at, .. } = last;
                format!(
                    "{station}, process {process}, trial {trial} of {of}, last heard {updated_at}"
                )
            });
            log.note(log::CRASHED, &last)?;
        }
        let is_new = !files.data.exists();
        let found = rows::read(&files.data, &self.protocol.name, subject)?;
        if let Some(torn) = &found.torn {
            log.note_for_good(log::TORN_ROW, torn)?;
        }
        let rows = RowFile::open(&files.data, &found)?;
        log.note(if is_new { log::BEGAN } else { log::RESUMED }, env!("CARGO_PKG_VERSION"))?;
        write_descriptions(&self.folder, &self.protocol, self.kind)?;
        let Story { trials_begun: begun, set_aside, .. } = story;
        let frame_times = FrameTimes::new(&files.frame_times);
        let (written, closed) = (0, false);
        let recorder = Recorder {
            rows,
            log,
            frame_times,
            begun,
            set_aside,
            written,
            closed,
            claim,
            _lock: lock,
        };
        Ok((recorder, found.rows))
    }

    /// The files of session number `session` of `subject`.
    pub(super) fn files(&self, subject: &ParticipantCode, session: u32) -> SessionFiles {
        SessionFiles::new(&self.folder, &data_file_name(&self.protocol, subject, session))
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
}

/// Where the records of a session lie.
#[derive(Clone, Debug)]
pub(super) struct SessionFiles {
    pub data: PathBuf,
    pub journal: PathBuf,
    pub frame_times: PathBuf,
    pub claims: PathBuf,
}

impl SessionFiles {
    /// Those of the session whose answers are in the file `name` of the study in `folder`.
    pub fn new(folder: &Path, name: &str) -> Self {
        let stem = name.trim_end_matches("_data.csv");
        Self {
            data: folder.join("data").join(name),
            journal: folder.join("log").join(format!("{stem}.log")),
            frame_times: folder.join("log").join(format!("{stem}_frames.csv")),
            claims: folder.join(CLAIMS).join(stem),
        }
    }

    /// The lock that keeps the programs of the computer called `station` apart. Each computer has one of
    /// its own, since on a network share a common one may not work.
    pub fn lock(&self, station: &str) -> PathBuf {
        self.claims.join(format!(".{}.lock", heartbeat::in_file_name(station)))
    }

    /// Whether a program of the computer called `station` runs the session. Only to be asked if its last
    /// heartbeat is from here.
    pub fn runs_here(&self, station: &str) -> bool {
        let lock = File::options().write(true).open(self.lock(station));
        lock.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
    }

    /// Claims the session; see [`Claim::take`]. Returns also the lock, where locks work.
    pub fn claim(
        &self,
        station: &str,
        subject: &ParticipantCode,
        session: u32,
        trials: u32,
    ) -> Result<(Claim, Option<Heartbeat>, Option<File>), RecordError> {
        create_folder(&self.claims)?;
        let path = self.lock(station);
        let file = File::options().write(true).create(true).truncate(false).open(&path);
        let file = file.map_err(|e| named(&path, &e))?;
        let lock = match file.try_lock() {
            Ok(()) => Some(file),
            Err(TryLockError::WouldBlock) => {
                let running = heartbeat::latest(&self.claims).ok().flatten();
                let running = running.and_then(|look| look.heartbeat);
                let since = running.map_or("just now".into(), |running| running.began_at);
                let (subject, station) = (subject.clone(), station.into());
                return Err(RecordError::Locked { file: path, subject, station, since });
            }
            // A share without locks: the claim is enough, but a crash takes longer to tell.
            Err(TryLockError::Error(_)) => None,
        };
        let mine = Heartbeat::new(station, subject, session, trials);
        let (claim, crashed) = Claim::take(&self.claims, mine, lock.is_some())?;
        Ok((claim, crashed, lock))
    }
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
