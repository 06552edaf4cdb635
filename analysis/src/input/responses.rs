//! Reading responses: a responses CSV, every data file of a study folder, or several of either.
//!
//! Only real answers are analysed, or only simulated ones; practice, catch and pilot trials are counted
//! and set apart.

use super::data_quality::{Excluded, distinct};
use super::participants;
use crate::error::InputError;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::item_table::plain;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::{Answer, Side, TrialKind};
use shutterlab_data_schema::study::data_files;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// A row and where it stands.
pub(crate) struct Row {
    pub response: Response,
    pub file: String,
    pub line: u64,
}

/// The answers of one task, checked.
pub struct Responses {
    /// What an error calls them all.
    pub(crate) source: String,
    /// The answers that count: all real, or all simulated; maybe none.
    pub(crate) counted: Vec<Row>,
    /// The catch trials of the same observers.
    pub(crate) catch: Vec<Response>,
    /// What was read and does not count.
    pub(crate) excluded: Excluded,
    /// What `participants.csv` says of each (study, subject), beyond the columns that every study has.
    pub(crate) traits: BTreeMap<(String, String), BTreeMap<String, String>>,
    /// What the reader of the data has to tell the reader of the results.
    pub(crate) notes: Vec<String>,
}

/// Reads the responses at `paths`, each a CSV or a study folder with all its data files.
///
/// # Errors
/// A file cannot be read; a row is no [`Response`] or contradicts itself; a trial was answered twice;
/// tasks, or real and simulated answers, are mixed; one path holds several studies.
pub fn read<P: AsRef<Path>>(paths: &[P]) -> Result<Responses, InputError> {
    let names: Vec<String> = paths.iter().map(|path| path.as_ref().display().to_string()).collect();
    let mut rows = Vec::new();
    let mut traits = BTreeMap::new();
    for (path, name) in paths.iter().map(AsRef::as_ref).zip(&names) {
        let unreadable = |file: String| move |source| InputError::Unreadable { file, source };
        let folder = path.is_dir();
        let files = match folder {
            true => data_files(path).map_err(unreadable(name.clone()))?,
            false => vec![path.to_path_buf()],
        };
        let before = rows.len();
        for path in files {
            let file = path.display().to_string();
            let text = std::fs::read_to_string(&path).map_err(unreadable(file.clone()))?;
            read_rows(&text, &file, &mut rows)?;
        }
        one_study(&rows[before..])?;
        let Some(row) = rows.get(before).filter(|_| folder) else { continue };
        // Two folders are two studies, even of one protocol.
        let mut study = row.response.study.clone();
        if rows[..before].iter().any(|other| other.response.study == study) {
            study = format!("{study} in {name}");
            rows[before..].iter_mut().for_each(|row| row.response.study.clone_from(&study));
        }
        let participants = path.join("participants.csv");
        if participants.exists() {
            participants::read(&participants, &study, &mut traits)?;
        }
    }
    responses(rows, traits, names.join(", "))
}

/// Parses one responses CSV; `file` is what an error calls it.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, file: &str) -> Result<Responses, InputError> {
    let mut rows = Vec::new();
    read_rows(text, file, &mut rows)?;
    one_study(&rows)?;
    responses(rows, BTreeMap::new(), file.into())
}

fn read_rows(text: &str, file: &str, rows: &mut Vec<Row>) -> Result<(), InputError> {
    for (response, line) in rows_of(text, file)? {
        check_row(&response, file, line)?;
        rows.push(Row { response, file: file.into(), line });
    }
    Ok(())
}

/// The rows of a responses CSV, whatever the task, and their lines.
pub(crate) fn rows_of(text: &str, file: &str) -> Result<Vec<(Response, u64)>, InputError> {
    let mut rows = Vec::new();
    let text = plain(text);
    if text.is_empty() {
        return Err(InputError::line(
            file,
            1,
            "header",
            "an empty file",
            "a CSV of responses is needed",
        ));
    }
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let mut headers = reader
        .headers()
        .map_err(|error| InputError::line(file, 1, "header", error, "a CSV is needed"))?
        .clone();
    // An export says in a column of its own whose answers they are, as `kind` does.
    let export = headers.iter().position(|name| name == "study_kind");
    let own = |record: &csv::StringRecord| -> csv::StringRecord {
        let cells = record.iter().enumerate();
        cells.filter(|(place, _)| Some(*place) != export).map(|(_, cell)| cell).collect()
    };
    headers = own(&headers);
    // A writer that dies in the middle of a row leaves a last line without its end.
    let torn = if text.ends_with('\n') { "" } else { "; the file ends in the middle of a line" };
    for record in reader.records() {
        let record = record.map_err(|error| match error.kind() {
            csv::ErrorKind::UnequalLengths { pos, expected_len, len } => InputError::line(
                file,
                pos.as_ref().map_or(0, csv::Position::line),
                "row",
                format!("{len} fields"),
                format!("{expected_len} are needed, as in the header{torn}"),
            ),
            _ => {
                let line = error.position().map_or(0, csv::Position::line);
                InputError::line(file, line, "row", &error, "a row of a CSV is needed")
            }
        })?;
        let line = record.position().map_or(0, csv::Position::line);
        let record = own(&record);
        let response: Response = record
            .deserialize(Some(&headers))
            .map_err(|error| no_response(&error, &headers, &record, file, line, torn))?;
        rows.push((response, line));
    }
    Ok(rows)
}

/// Why a record is no [`Response`], with the column it is about.
fn no_response(
    error: &csv::Error,
    headers: &csv::StringRecord,
    record: &csv::StringRecord,
    file: &str,
    line: u64,
    torn: &str,
) -> InputError {
    let (index, what) = match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => (err.field(), err.kind().to_string()),
        _ => (None, error.to_string()),
    };
    // serde quotes what it is about; without a column it is the name of one, or a value.
    let quoted = what.split('`').nth(1).unwrap_or_default();
    if ["unknown field", "missing field"].iter().any(|start| what.starts_with(start)) {
        let what = what.split(", expected").next().unwrap_or_default();
        let allowed = format!(
            "{what}: the columns of responses are needed; tables of votes and matrices are read with \
             --votes and --matrix"
        );
        return InputError::line(file, 1, "header", format!("`{quoted}`"), allowed);
    }
    let index = index
        .map(|index| index as usize)
        .or_else(|| record.iter().position(|value| value == quoted))
        .unwrap_or(usize::MAX);
    let name = headers.get(index).unwrap_or("row");
    let value = record.get(index).unwrap_or(quoted);
    InputError::line(file, line, name, format!("`{value}`"), format!("{what}{torn}"))
}

/// Refuses a row that contradicts itself.
fn check_row(row: &Response, file: &str, line: u64) -> Result<(), InputError> {
    let refuse = |field: &str, value: String, allowed: String| {
        Err(InputError::line(file, line, field, value, allowed))
    };
    if row.stimulus_a == row.stimulus_b && row.task != Task::SameDifferent {
        let value = format!("`{}`", row.stimulus_b);
        return refuse("stimulus_b", value, "another stimulus than stimulus_a is needed".into());
    }
    let (first, second) = match row.first {
        Side::A => (&row.stimulus_a, &row.stimulus_b),
        Side::B => (&row.stimulus_b, &row.stimulus_a),
    };
    let answered = match (row.task, row.answer) {
        (Task::TwoAfc | Task::Matching, Answer::First) => Some(first),
        (Task::TwoAfc | Task::Matching, Answer::Second) => Some(second),
        (Task::SameDifferent, Answer::Same | Answer::Different) | (_, Answer::NotSure) => None,
        (task, answer) => {
            let allowed = match task {
                Task::SameDifferent => "same, different or not-sure",
                Task::TwoAfc | Task::Matching => "first, second or not-sure",
            };
            let allowed = format!("{allowed} are answers to {}", task.name());
            return refuse("answer", format!("`{}`", answer.name()), allowed);
        }
    };
    let of_two = [&row.stimulus_a, &row.stimulus_b];
    match (&row.reference, row.task) {
        (Some(reference), _) if !of_two.contains(&reference) => {
            let allowed = "stimulus_a or stimulus_b is needed".into();
            return refuse("reference", format!("`{reference}`"), allowed);
        }
        (None, Task::Matching | Task::SameDifferent) => {
            let allowed = format!("the task {} needs one", row.task.name());
            return refuse("reference", "nothing".into(), allowed);
        }
        _ => (),
    }
    if row.selected.as_ref() != answered {
        let quoted = |id: Option<&String>| id.map_or("nothing".into(), |id| format!("`{id}`"));
        let allowed = format!("the answer selects {}", quoted(answered));
        return refuse("selected", quoted(row.selected.as_ref()), allowed);
    }
    let numbers = [
        ("response_time_s", Some(row.response_time_s)),
        ("onset_reference_s", row.onset_reference_s),
        ("onset_a_s", Some(row.onset_a_s)),
        ("onset_b_s", Some(row.onset_b_s)),
        ("duration_reference_s", row.duration_reference_s),
        ("duration_a_s", Some(row.duration_a_s)),
        ("duration_b_s", Some(row.duration_b_s)),
        ("refresh_hz", row.refresh_hz),
        ("refreshes_per_frame", row.refreshes_per_frame),
        ("magnification", Some(row.magnification)),
        ("pixels_per_degree", Some(row.pixels_per_degree)),
        ("viewed_pixels_per_degree", row.viewed_pixels_per_degree),
        ("r", row.r),
        ("level_of_detail", row.level_of_detail),
        ("speed_deg_per_s", Some(row.speed_deg_per_s)),
    ];
    for (name, number) in numbers {
        if let Some(number) = number.filter(|number| !number.is_finite()) {
            return refuse(name, number.to_string(), "a finite number is needed".into());
        }
    }
    if row.kind == TrialKind::Real && row.observer.starts_with("simulated:") {
        let allowed = "a real answer is given by a participant".into();
        return refuse("observer", format!("`{}`", row.observer), allowed);
    }
    Ok(())
}

/// Refuses rows of several studies in one place.
fn one_study(rows: &[Row]) -> Result<(), InputError> {
    let Some(first) = rows.first() else { return Ok(()) };
    match rows.iter().find(|row| row.response.study != first.response.study) {
        None => Ok(()),
        Some(other) => {
            let allowed =
                format!("all rows are needed to be of one protocol, `{}`", first.response.study);
            Err(other.refuse("study", format!("`{}`", other.response.study), allowed))
        }
    }
}

fn responses(
    rows: Vec<Row>,
    traits: BTreeMap<(String, String), BTreeMap<String, String>>,
    source: String,
) -> Result<Responses, InputError> {
    let mut trials = HashMap::new();
    for row in &rows {
        let Response { study, subject, session, trial, .. } = &row.response;
        if let Some(earlier) = trials.insert((study, subject, session, trial), row) {
            let Row { file, line, .. } = earlier;
            let allowed = format!("answered before in {file}, line {line}");
            let value = format!("subject {subject}, session {session}, trial {trial}");
            return Err(row.refuse("trial", value, allowed));
        }
    }
    if let Some(other) = rows.iter().find(|row| row.response.task != rows[0].response.task) {
        let allowed =
            format!("all rows are needed to be of one task, `{}`", rows[0].response.task.name());
        return Err(other.refuse("task", format!("`{}`", other.response.task.name()), allowed));
    }
    let count = |kind: TrialKind| rows.iter().filter(|r| r.response.kind == kind).count() as u64;
    let (real, simulated) = (count(TrialKind::Real), count(TrialKind::Simulated));
    if real > 0 && simulated > 0 {
        return Err(InputError::value(
            &source,
            "kind",
            format!("{real} real and {simulated} simulated rows"),
            "people and simulated observers are never analysed together",
        ));
    }
    let excluded = Excluded {
        practice: count(TrialKind::Practice),
        catch: count(TrialKind::Catch),
        pilot: count(TrialKind::Pilot),
        incomplete_sets: 0,
    };
    let (mut counted, mut catch) = (Vec::new(), Vec::new());
    for row in rows {
        match row.response.kind {
            TrialKind::Real | TrialKind::Simulated => counted.push(row),
            // Of a trial run, catch trials do not count either.
            TrialKind::Catch if !row.response.pilot => catch.push(row.response),
            TrialKind::Catch | TrialKind::Practice | TrialKind::Pilot => (),
        }
    }
    let responses: Vec<&Response> = counted.iter().map(|row| &row.response).collect();
    let mut notes = differences(&responses);
    let answered: BTreeSet<(String, String)> = counted
        .iter()
        .map(|r| (r.response.study.clone(), r.response.subject.to_string()))
        .collect();
    let silent: Vec<&str> =
        traits.keys().filter(|who| !answered.contains(who)).map(|who| who.1.as_str()).collect();
    if !silent.is_empty() {
        notes.push(format!(
            "Entered in participants.csv, but without answers that count: {}.",
            silent.join(", ")
        ));
    }
    let unknown: BTreeSet<String> = responses
        .iter()
        .map(|row| (row.study.clone(), row.subject.to_string()))
        .filter(|who| traits.keys().any(|(study, _)| *study == who.0) && !traits.contains_key(who))
        .map(|(_, subject)| subject)
        .collect();
    if !unknown.is_empty() {
        let unknown: Vec<String> = unknown.into_iter().collect();
        notes.push(format!(
            "participants.csv does not know {}, whose answers count all the same.",
            unknown.join(", ")
        ));
    }
    Ok(Responses { source, counted, catch, excluded, traits, notes })
}

impl Responses {
    /// The answers that count.
    pub fn counted(&self) -> impl Iterator<Item = &Response> {
        self.counted.iter().map(|row| &row.response)
    }

    /// What was asked; none if nothing counts.
    pub fn task(&self) -> Option<Task> {
        self.counted().next().map(|row| row.task)
    }

    /// Refuses to go on if nothing counts.
    pub(crate) fn check_not_empty(&self) -> Result<(), InputError> {
        let Excluded { practice, catch, pilot, .. } = self.excluded;
        match self.counted.is_empty() {
            false => Ok(()),
            true => Err(InputError::value(
                &self.source,
                "kind",
                format!(
                    "no answer counts yet: {practice} practice, {catch} catch and {pilot} pilot rows"
                ),
                "rows that are real or simulated are needed",
            )),
        }
    }
}

impl Row {
    /// An error about this row.
    pub(crate) fn refuse(&self, field: &str, value: String, allowed: String) -> InputError {
        InputError::line(&self.file, self.line, field, value, allowed)
    }
}

/// What changed during the experiment although it should not have.
fn differences(rows: &[&Response]) -> Vec<String> {
    let mut notes = Vec::new();
    let mut several = |what: &str, values: Vec<String>| {
        if values.len() > 1 {
            notes.push(format!("The answers have {} {what}: {}.", values.len(), values.join("; ")));
        }
    };
    several("different questions", distinct(rows, |row| row.question.clone()));
    several(
        "viewing geometries (pixels per degree)",
        distinct(rows, |row| row.pixels_per_degree.to_string()),
    );
    several("clocks", distinct(rows, |row| format!("{:?}", row.clock).to_lowercase()));
    let mut hashes: BTreeMap<(&str, u32), BTreeSet<&str>> = BTreeMap::new();
    for row in rows {
        hashes.entry((&row.stimulus_a, row.exemplar_a)).or_default().insert(&row.hash_a);
        hashes.entry((&row.stimulus_b, row.exemplar_b)).or_default().insert(&row.hash_b);
    }
    for ((stimulus, exemplar), hashes) in hashes {
        if hashes.len() > 1 {
            notes.push(format!(
                "Stimulus {stimulus}, exemplar {exemplar}, was shown in {} versions: its hash changed.",
                hashes.len()
            ));
        }
    }
    notes
}
