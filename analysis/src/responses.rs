//! Reading responses: a responses CSV, or every data file of a study folder.
//!
//! Only real answers are analysed, or only simulated ones; practice, catch and pilot trials are counted
//! and left out. A judge is one complete set of pairs: what one subject answered in one repetition
//! of one session. Sets that are not complete (a session still under way) are left out by name.

use crate::data_quality::{DataQuality, Excluded, distinct};
use crate::error::InputError;
use crate::preferences::{Judge, Judgements, Preferences, WinMatrix, check_items};
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::{Answer, Side, TrialKind};
use shutterlab_data_schema::study::data_files;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// A row and where it stands.
struct Row {
    response: Response,
    file: String,
    line: u64,
}

/// Reads the responses at `path`: a CSV, or a study folder with all its data files.
///
/// # Errors
/// A file cannot be read; a row is no [`Response`] or contradicts itself; a trial or a pair was
/// answered twice; real and simulated answers, or several protocols, are mixed; nothing counts; no
/// set of pairs is complete.
pub fn read(path: &Path) -> Result<Preferences, InputError> {
    let name = path.display().to_string();
    let unreadable = |file: String| move |source| InputError::Unreadable { file, source };
    let files = match path.is_dir() {
        true => data_files(path).map_err(unreadable(name.clone()))?,
        false => vec![path.to_path_buf()],
    };
    let mut rows = Vec::new();
    for path in files {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(&path).map_err(unreadable(file.clone()))?;
        read_rows(&text, &file, &mut rows)?;
    }
    preferences(rows, &name)
}

/// Parses one responses CSV; `file` is what an error calls it.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, file: &str) -> Result<Preferences, InputError> {
    let mut rows = Vec::new();
    read_rows(text, file, &mut rows)?;
    preferences(rows, file)
}

fn read_rows(text: &str, file: &str, rows: &mut Vec<Row>) -> Result<(), InputError> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let headers = reader
        .headers()
        .map_err(|error| InputError::line(file, 1, "header", error, "a CSV is needed"))?
        .clone();
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
        let response: Response = record
            .deserialize(Some(&headers))
            .map_err(|error| no_response(&error, &headers, &record, file, line, torn))?;
        check_row(&response, file, line)?;
        rows.push(Row { response, file: file.into(), line });
    }
    Ok(())
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
        return InputError::line(file, 1, "header", format!("`{quoted}`"), what);
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
    if row.task != Task::TwoAfc {
        let value = format!("`{}`", row.task.name());
        return refuse("task", value, "answers of the task 2afc are analysed".into());
    }
    if row.stimulus_a == row.stimulus_b {
        let value = format!("`{}`", row.stimulus_b);
        return refuse("stimulus_b", value, "another stimulus than stimulus_a is needed".into());
    }
    let (first, second) = match row.first {
        Side::A => (&row.stimulus_a, &row.stimulus_b),
        Side::B => (&row.stimulus_b, &row.stimulus_a),
    };
    let answered = match row.answer {
        Answer::First => Some(first),
        Answer::Second => Some(second),
        Answer::NotSure => None,
        Answer::Same | Answer::Different => {
            let value = format!("`{}`", row.answer.name());
            return refuse("answer", value, "first, second or not-sure are answers to 2afc".into());
        }
    };
    if row.selected.as_ref() != answered {
        let quoted = |id: Option<&String>| id.map_or("nothing".into(), |id| format!("`{id}`"));
        let allowed = format!("the answer selects {}", quoted(answered));
        return refuse("selected", quoted(row.selected.as_ref()), allowed);
    }
    if !row.response_time_s.is_finite() {
        let allowed = "a number of seconds is needed".into();
        return refuse("response_time_s", row.response_time_s.to_string(), allowed);
    }
    if row.kind == TrialKind::Real && row.observer.starts_with("simulated:") {
        let allowed = "a real answer is given by a participant".into();
        return refuse("observer", format!("`{}`", row.observer), allowed);
    }
    Ok(())
}

fn preferences(rows: Vec<Row>, source: &str) -> Result<Preferences, InputError> {
    let mut trials = HashMap::new();
    for row in &rows {
        let key = (&row.response.subject, row.response.session, row.response.trial);
        if let Some(earlier) = trials.insert(key, row) {
            let allowed = format!("answered before in {}, line {}", earlier.file, earlier.line);
            let (subject, session, trial) = key;
            let value = format!("subject {subject}, session {session}, trial {trial}");
            return Err(repeated(row, "trial", value, allowed));
        }
    }
    let of_kind = |kind: TrialKind| rows.iter().filter(move |row| row.response.kind == kind);
    let count = |kind: TrialKind| of_kind(kind).count() as u64;
    let (real, simulated) = (count(TrialKind::Real), count(TrialKind::Simulated));
    let (practice, pilot) = (count(TrialKind::Practice), count(TrialKind::Pilot));
    let catch = count(TrialKind::Catch);
    let kind = match (real, simulated) {
        (0, 0) => {
            return Err(InputError::value(
                source,
                "kind",
                format!("{practice} practice, {catch} catch and {pilot} pilot rows"),
                "rows that are real or simulated are needed",
            ));
        }
        (_, 0) => TrialKind::Real,
        (0, _) => TrialKind::Simulated,
        _ => {
            return Err(InputError::value(
                source,
                "kind",
                format!("{real} real and {simulated} simulated rows"),
                "people and simulated observers are never analysed together",
            ));
        }
    };
    let counted: Vec<&Row> = of_kind(kind).collect();
    if let Some(other) = counted.iter().find(|row| row.response.study != counted[0].response.study)
    {
        let allowed =
            format!("all rows are needed to be of one protocol, `{}`", counted[0].response.study);
        return Err(repeated(other, "study", format!("`{}`", other.response.study), allowed));
    }
    let items: Vec<String> = counted
        .iter()
        .flat_map(|row| [&row.response.stimulus_a, &row.response.stimulus_b])
        .collect::<BTreeSet<_>>()
        .into_iter()
        .cloned()
        .collect();
    check_items(items.len(), source)?;

    let mut sets: BTreeMap<(String, u32, u32), Vec<&Row>> = BTreeMap::new();
    for row in counted {
        let response = &row.response;
        let key = (response.subject.to_string(), response.session, response.repetition);
        sets.entry(key).or_default().push(row);
    }
    let pairs = items.len() * (items.len() - 1) / 2;
    let mut judges = Vec::new();
    let mut analysed = Vec::new();
    let mut excluded = Excluded { practice, catch, pilot, incomplete_sets: 0 };
    let mut notes = Vec::new();
    let mut fullest = 0;
    for ((subject, session, repetition), set) in sets {
        let set: Vec<&Row> =
            set.into_iter().filter(|row| row.response.selected.is_some()).collect();
        let wins = wins(&items, &set)?;
        if set.len() == pairs {
            analysed.extend(set.iter().map(|row| &row.response));
            judges.push(Judge { subject, session, repetition, wins });
        } else {
            excluded.incomplete_sets += set.len() as u64;
            fullest = fullest.max(set.len());
            notes.push(format!(
                "Left out: subject {subject}, session {session}, repetition {repetition}, \
                 who chose in {} of {pairs} pairs.",
                set.len()
            ));
        }
    }
    if judges.is_empty() {
        return Err(InputError::value(
            source,
            "pairs",
            format!(
                "no set has all {pairs} pairs of {} stimuli, the fullest has {fullest}",
                items.len()
            ),
            "at least one complete set is needed",
        ));
    }
    notes.extend(differences(&analysed));
    let data_quality = Some(DataQuality::of(&analysed, excluded));
    Ok(Preferences { items, judgements: Judgements::Judges(judges), data_quality, notes })
}

/// The choices of one set of pairs.
fn wins(items: &[String], set: &[&Row]) -> Result<WinMatrix, InputError> {
    let mut wins = WinMatrix::new(items.len());
    let mut seen: HashMap<(usize, usize), &Row> = HashMap::new();
    for row in set {
        let response = &row.response;
        // Every id of a counted row is among the sorted items.
        let place = |id: &String| items.partition_point(|item| item < id);
        let (a, b) = (place(&response.stimulus_a), place(&response.stimulus_b));
        if let Some(earlier) = seen.insert((a.min(b), a.max(b)), row) {
            let value = format!("`{}` and `{}`", response.stimulus_a, response.stimulus_b);
            let allowed = format!(
                "once in a repetition, and answered before in {}, line {}",
                earlier.file, earlier.line
            );
            return Err(repeated(row, "pair", value, allowed));
        }
        let a_selected = response.selected.as_ref() == Some(&response.stimulus_a);
        let (winner, loser) = if a_selected { (a, b) } else { (b, a) };
        wins.add(winner, loser, 1);
    }
    Ok(wins)
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

fn repeated(row: &Row, field: &str, value: String, allowed: String) -> InputError {
    InputError::line(&row.file, row.line, field, value, allowed)
}
