//! Who takes part in a study: a record of its own for each participant, and a number.
//!
//! No lock is shared, since locks do not work on every network share. A record is a file that only one
//! of several stations can create, named by the participant's code; so is a number, which holds the
//! code of whom it was given to. `participants.csv` is made from the records.

use super::{RecordError, damaged, list, unreadable};
use indexmap::IndexMap;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::files::{create_atomically, named, write_atomically};
use shutterlab_data_schema::study::until_settled;
use shutterlab_data_schema::{Participant, ParticipantCode, Protocol};
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

/// Name in the records of an observer who is a person.
pub const PARTICIPANT: &str = "participant";

/// Folder of the records.
pub(super) const RECORDS: &str = "log/participants";

/// Folder of the numbers.
pub(super) const ORDINALS: &str = "log/ordinals";

/// Who is to be entered.
#[derive(Clone, Debug)]
pub struct NewParticipant {
    /// The code.
    pub subject: ParticipantCode,
    /// [`PARTICIPANT`], or `simulated:NAME`.
    pub observer: String,
    /// Seed of the order of pairs.
    pub seed: u64,
    /// What was answered to the protocol's questions about the participant, by key.
    pub fields: IndexMap<String, String>,
    /// When the participant agreed to the protocol's consent text.
    pub consented_at: Option<Timestamp>,
}

/// All that is kept of a participant beside the answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParticipantRecord {
    /// The row in `participants.csv`.
    pub participant: Participant,
    /// What was answered to the protocol's questions about the participant, by key.
    pub fields: IndexMap<String, String>,
    /// Station at which the participant was entered.
    pub station: String,
    /// SHA-256 of the text that the participant agreed to.
    pub consent_sha256: Option<String>,
}

/// The record of `subject` in the study in `folder`, if there is one.
pub(super) fn find(
    folder: &Path,
    subject: &ParticipantCode,
) -> Result<Option<ParticipantRecord>, RecordError> {
    let path = path(folder, subject);
    match std::fs::read(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(named(&path, &error).into()),
        Ok(bytes) => parse(&path, &bytes).map(Some),
    }
}

/// The file of the record of `subject`.
pub(super) fn path(folder: &Path, subject: &ParticipantCode) -> PathBuf {
    folder.join(RECORDS).join(format!("{}.json", subject.file_name()))
}

/// Reads the record in `file`.
pub(super) fn read(file: &Path) -> Result<ParticipantRecord, RecordError> {
    parse(file, &std::fs::read(file).map_err(|e| named(file, &e))?)
}

fn parse(file: &Path, bytes: &[u8]) -> Result<ParticipantRecord, RecordError> {
    serde_json::from_slice(bytes).map_err(|error| unreadable(file, &error))
}

/// The files of all records.
pub(super) fn files(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    list(&folder.join(RECORDS), ".json")
}

/// Makes `participants.csv` from the records.
pub(super) fn write_table(folder: &Path, protocol: &Protocol) -> Result<(), RecordError> {
    until_settled(
        || files(folder),
        |files| {
            let mut records = Vec::with_capacity(files.len());
            for file in files {
                match read(file) {
                    // Withdrawn since the files were listed.
                    Err(RecordError::Io(e)) if e.kind() == io::ErrorKind::NotFound => {}
                    other => records.push(other?),
                }
            }
            records.sort_by_key(|record| record.participant.ordinal);
            Ok(write_atomically(&folder.join("participants.csv"), &table(&records, protocol)?)?)
        },
    )
}

fn table(records: &[ParticipantRecord], protocol: &Protocol) -> io::Result<Vec<u8>> {
    let names = shutterlab_data_schema::study::participants_schema(&protocol.participant);
    let names = names["fields"].as_array().cloned().unwrap_or_default();
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(vec![]);
    writer.write_record(names.iter().filter_map(|field| field["name"].as_str()))?;
    for record in records {
        let own = protocol.participant.iter().map(|field| record.fields.get(&field.key));
        let own: Vec<Option<&String>> = own.collect();
        writer.serialize((&record.participant, own))?;
    }
    writer.into_inner().map_err(|error| io::Error::other(error.to_string()))
}

/// The numbers that have been given, and to whom.
#[derive(Debug)]
pub(super) struct Ordinals {
    folder: PathBuf,
    last: u32,
    by_code: HashMap<String, u32>,
}

impl Ordinals {
    /// Reads those of the study in `folder`.
    pub fn read(folder: &Path) -> Result<Self, RecordError> {
        let folder = folder.join(ORDINALS);
        let mut ordinals = Self { folder, last: 0, by_code: HashMap::new() };
        for file in list(&ordinals.folder, "")? {
            let number = file.file_name().and_then(|name| name.to_str()?.parse().ok());
            let Some(number) = number else {
                return Err(damaged(&file, "the name of a number that was given is a number"));
            };
            ordinals.note(number, code(&file)?);
        }
        Ok(ordinals)
    }

    fn note(&mut self, number: u32, code: String) {
        self.last = self.last.max(number);
        self.by_code.insert(code, number);
    }

    /// Gives `subject` the next number, or the one that a program which was killed, or another station at
    /// this moment, has given already. `create` makes a file that nobody else can make.
    pub fn give(
        &mut self,
        subject: &ParticipantCode,
        create: fn(&Path, &[u8]) -> io::Result<bool>,
    ) -> Result<u32, RecordError> {
        let mine = subject.file_name();
        if let Some(number) = self.by_code.get(&mine) {
            return Ok(*number);
        }
        let mut number = self.last + 1;
        loop {
            let file = self.folder.join(number.to_string());
            if create(&file, mine.as_bytes())? || code(&file)? == mine {
                self.note(number, mine);
                return Ok(number);
            }
            number += 1;
        }
    }
}

fn code(file: &Path) -> io::Result<String> {
    std::fs::read_to_string(file).map_err(|e| named(file, &e))
}

/// Enters one participant in the study in `folder`.
pub(super) fn enter(folder: &Path, record: NewRecord<'_>) -> Result<Participant, RecordError> {
    if let Some(there) = find(folder, &record.new.subject)? {
        return same(folder, record.new, there);
    }
    let ordinal = Ordinals::read(folder)?.give(&record.new.subject, create_atomically)?;
    let made = record.made(ordinal);
    let path = path(folder, &record.new.subject);
    if create_atomically(&path, &record_bytes(&made)?)? {
        return Ok(made.participant);
    }
    // Entered elsewhere at the same time.
    same(folder, record.new, read(&path)?)
}

/// A participant to be entered, and what the study adds.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewRecord<'a> {
    pub new: &'a NewParticipant,
    pub station: &'a str,
    pub consent_sha256: Option<&'a str>,
}

impl NewRecord<'_> {
    pub fn made(&self, ordinal: u32) -> ParticipantRecord {
        let new = self.new;
        ParticipantRecord {
            participant: Participant {
                subject: new.subject.clone(),
                observer: new.observer.clone(),
                seed: new.seed,
                ordinal,
                first_session: format!("{:.3}", Timestamp::now()),
                consented_at: new.consented_at.map(|at| format!("{at:.3}")),
            },
            fields: new.fields.clone(),
            station: self.station.into(),
            consent_sha256: new.consented_at.and(self.consent_sha256).map(String::from),
        }
    }
}

pub(super) fn record_bytes(record: &ParticipantRecord) -> io::Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec_pretty(record)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// The participant that is there already, who must be the one to be entered.
pub(super) fn same(
    folder: &Path,
    new: &NewParticipant,
    there: ParticipantRecord,
) -> Result<Participant, RecordError> {
    let there = there.participant;
    let fields = [
        ("code", there.subject.to_string(), new.subject.to_string()),
        ("observer", there.observer.clone(), new.observer.clone()),
        ("seed", there.seed.to_string(), new.seed.to_string()),
    ];
    match fields.into_iter().find(|(_, there, now)| there != now) {
        None => Ok(there),
        Some((field, there, now)) => Err(RecordError::OtherParticipant {
            file: path(folder, &new.subject),
            subject: new.subject.clone(),
            field,
            there,
            now,
        }),
    }
}

#[cfg(test)]
pub(super) mod tests;
