//! The study that is exported, read whole and checked.

use super::table::{Table, cells, columns_before};
use crate::error::InputError;
use crate::input::responses::rows_of;
use schemars::JsonSchema;
use serde::Serialize;
use shutterlab_data_schema::response::TrialKind;
use shutterlab_data_schema::study::{StudyKind, data_files, participants_schema, responses_schema};
use shutterlab_data_schema::{Protocol, Response, definition};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::io;
use std::path::Path;

/// A study folder, read.
#[derive(Clone, Debug)]
pub struct Study {
    pub(super) protocol: Protocol,
    /// `protocol.toml` as it stands in the study.
    pub(super) protocol_text: String,
    pub(super) kind: StudyKind,
    /// The sessions with answers, in the order of their files.
    pub(super) sessions: Vec<Session>,
    /// `participants.csv` as it stands in the study.
    pub(super) participants: Table,
    /// An image (PNG) of each stimulus, by its id.
    pub(super) thumbnails: BTreeMap<String, Vec<u8>>,
    /// What the reader of the study has to tell the reader of the export.
    pub(super) notes: Vec<String>,
}

/// The answers of one session; at least one.
#[derive(Clone, Debug)]
pub(super) struct Session {
    /// Name of the data file.
    pub file: String,
    pub rows: Vec<Response>,
}

/// What every table of an export begins with.
#[derive(Serialize, JsonSchema)]
struct Stamp {
    /// Whose answers the study holds.
    study_kind: StudyKind,
}

/// What a table of answers begins with.
#[derive(Serialize, JsonSchema)]
struct AnswerStamp {
    /// Whose answers the study holds.
    study_kind: StudyKind,
    /// Whether an analysis uses the answer: those to practice, catch and pilot trials never count.
    counts: bool,
}

/// Columns that an export adds: no question about the participant can have their names.
const ADDED: [&str; 2] = ["study_kind", "participant_id"];

impl Study {
    /// Reads the study in `folder`; `thumbnails` are images (PNG) of its stimuli, by id.
    ///
    /// # Errors
    /// It is no study, or has no answers; a file cannot be read; a row is no [`Response`] of this study,
    /// is there twice, or is by nobody among its participants; people and simulated observers, or pilot
    /// and other answers, are mixed.
    pub fn read(folder: &Path, thumbnails: BTreeMap<String, Vec<u8>>) -> Result<Self, InputError> {
        let name = folder.display().to_string();
        let files = data_files(folder).map_err(|source| unreadable(folder, source))?;
        let file = folder.join("protocol.toml");
        let protocol_text = text(&file)?;
        // Not `Protocol::parse`: what a later version refuses may have been run by an earlier one.
        let protocol: Protocol = definition::parse(&protocol_text, &file.display().to_string())?;
        if let Some(field) = protocol.participant.iter().find(|field| ADDED.contains(&&*field.key))
        {
            let file = file.display().to_string();
            let allowed = "an export has a column of this name: another key is needed";
            return Err(InputError::value(&file, "participant.key", &field.key, allowed));
        }
        let participants = read_participants(folder, &protocol)?;
        let mut study = Self {
            protocol,
            protocol_text,
            kind: StudyKind::Real,
            sessions: Vec::new(),
            participants,
            thumbnails,
            notes: Vec::new(),
        };
        for path in &files {
            study.read_session(path)?;
        }
        study.kind = study.kind_of_rows(&name)?;
        let answered = study.answered();
        let codes = study.participants.rows.iter().map(|row| row[0].as_str());
        let silent: Vec<&str> = codes.filter(|code| !answered.contains(*code)).collect();
        if !silent.is_empty() {
            study.notes.push(format!("Entered, but without answers: {}.", silent.join(", ")));
        }
        Ok(study)
    }

    /// Adds the answers in the file at `path`, if there are any.
    fn read_session(&mut self, path: &Path) -> Result<(), InputError> {
        let file = path.display().to_string();
        let rows = rows_of(&text(path)?, &file)?;
        let Some((first, _)) = rows.first() else {
            self.notes.push(format!("Left out, as it has no answers: {}.", file_name(path)));
            return Ok(());
        };
        let known = self.participants.rows.iter().any(|row| row[0] == first.subject.to_string());
        let whose = |row: &Response| (row.subject.clone(), row.session);
        let earlier = self.sessions.iter().find(|other| whose(&other.rows[0]) == whose(first));
        let study = &self.protocol.name;
        let mut trials = HashSet::new();
        for (row, line) in &rows {
            let place = format!("subject {}, session {}", row.subject, row.session);
            let (field, value, allowed) = if row.study != *study {
                ("study", format!("`{}`", row.study), format!("the study's protocol is `{study}`"))
            } else if !known {
                let allowed = "participants.csv has nobody of this code";
                ("subject", format!("`{}`", row.subject), allowed.into())
            } else if whose(row) != whose(first) {
                ("session", place, "a file has the answers of one session".into())
            } else if let Some(earlier) = earlier {
                ("session", place, format!("{} has its answers already", earlier.file))
            } else if !trials.insert(row.trial) {
                ("trial", format!("{place}, trial {}", row.trial), "answered twice".into())
            } else {
                continue;
            };
            return Err(InputError::line(&file, *line, field, value, allowed));
        }
        let rows = rows.into_iter().map(|(row, _)| row).collect();
        self.sessions.push(Session { file: file_name(path), rows });
        Ok(())
    }

    /// Whose answers they are.
    fn kind_of_rows(&self, name: &str) -> Result<StudyKind, InputError> {
        let total = self.rows().count();
        let refuse = |field: &str, value: String, allowed: &str| {
            Err(InputError::value(name, field, value, allowed))
        };
        if total == 0 {
            return refuse("data", "no answers".into(), "at least one answer is needed");
        }
        let count = |is: &dyn Fn(&Response) -> bool| self.rows().filter(|row| is(row)).count();
        let simulated = count(&|row| row.observer.starts_with("simulated:"));
        let pilot = count(&|row| row.pilot);
        if ![0, total].contains(&simulated) {
            let value = format!("{simulated} of {total} answers are simulated");
            return refuse("observer", value, "people and simulated observers are never mixed");
        }
        if ![0, total].contains(&pilot) {
            let value = format!("{pilot} of {total} answers are of trial runs");
            return refuse("pilot", value, "trial runs and others are never mixed");
        }
        Ok(match (simulated, pilot) {
            (0, 0) => StudyKind::Real,
            (0, _) => StudyKind::Pilot,
            _ => StudyKind::Simulated,
        })
    }

    /// Its title, after what everybody has to know.
    pub(super) fn title(&self) -> String {
        self.kind.title(&self.protocol)
    }

    /// All answers.
    pub(super) fn rows(&self) -> impl Iterator<Item = &Response> {
        self.sessions.iter().flat_map(|session| &session.rows)
    }

    /// The codes of everybody with answers.
    pub(super) fn answered(&self) -> BTreeSet<String> {
        self.sessions.iter().map(|session| session.rows[0].subject.to_string()).collect()
    }

    /// The answers in `rows` as a table.
    pub(super) fn responses<'a>(&self, rows: impl Iterator<Item = &'a Response>) -> Table {
        let row = |row: &Response| {
            let stamp = AnswerStamp { study_kind: self.kind, counts: counts(row) };
            [cells(&stamp), cells(row)].concat()
        };
        Table {
            schema: columns_before::<AnswerStamp>(responses_schema()),
            rows: rows.map(row).collect(),
        }
    }

    /// `table`, with whose answers the study holds in every row.
    pub(super) fn stamped(&self, table: Table) -> Table {
        let stamp = cells(&Stamp { study_kind: self.kind });
        let rows = table.rows.into_iter().map(|row| [stamp.clone(), row].concat()).collect();
        Table { schema: columns_before::<Stamp>(table.schema), rows }
    }
}

/// Whether the answer counts.
pub(super) fn counts(row: &Response) -> bool {
    matches!(row.kind, TrialKind::Real | TrialKind::Simulated)
}

/// Reads `participants.csv`, whose columns depend on the protocol.
fn read_participants(folder: &Path, protocol: &Protocol) -> Result<Table, InputError> {
    let path = folder.join("participants.csv");
    let file = path.display().to_string();
    let mut table = Table { schema: participants_schema(&protocol.participant), rows: vec![] };
    let names: Vec<String> = table.fields().into_iter().map(|field| field.name).collect();
    let text = text(&path)?;
    let mut records = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
    for (index, record) in records.records().enumerate() {
        let record = record.map_err(|error| {
            let line = error.position().map_or(0, csv::Position::line);
            InputError::line(&file, line, "row", &error, "a row of a CSV is needed")
        })?;
        let cells: Vec<String> = record.iter().map(String::from).collect();
        match index {
            0 if cells != names => {
                let allowed = format!("`{}` is needed", names.join(","));
                return Err(InputError::line(
                    &file,
                    1,
                    "header",
                    format!("`{}`", cells.join(",")),
                    allowed,
                ));
            }
            0 => {}
            _ => table.rows.push(cells),
        }
    }
    Ok(table)
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn text(path: &Path) -> Result<String, InputError> {
    std::fs::read_to_string(path).map_err(|source| unreadable(path, source))
}

fn unreadable(path: &Path, source: io::Error) -> InputError {
    InputError::Unreadable { file: path.display().to_string(), source }
}
