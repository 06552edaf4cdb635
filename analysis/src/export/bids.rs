//! Export as a BIDS dataset of behaviour (<https://bids-specification.readthedocs.io>): a table of answers
//! for each session, and one description of its columns for all.

use super::json;
use super::study::Study;
use super::table::{Field, Table};
use serde_json::{Map, Value, json};
use shutterlab_data_schema::Response;

/// The version of the specification.
const BIDS_VERSION: &str = "1.10.0";

pub(super) fn files(study: &Study) -> Vec<(String, Vec<u8>)> {
    let task = study.protocol.task.name().replace('-', "");
    let mut files = Vec::new();
    for session in &study.sessions {
        let (subject, number) = (&session.rows[0].subject, session.rows[0].session);
        let name = format!("sub-{subject}_ses-{number}_task-{task}_beh.tsv");
        let table = answers(study, &session.rows);
        files.push((format!("sub-{subject}/ses-{number}/beh/{name}"), table.tsv()));
    }
    let mut about = json!({
        "TaskName": task,
        "TaskDescription": format!("{} {}", study.title(), study.protocol.question),
        "Instructions": study.protocol.text.instructions,
    });
    if let (Some(about), Value::Object(columns)) =
        (about.as_object_mut(), columns(&answers(study, &[])))
    {
        about.extend(columns);
    }
    // At the root it describes the tables of all sessions.
    files.push(json(&format!("task-{task}_beh.json"), &about));
    let participants = participants(study);
    files.push(("participants.tsv".into(), participants.tsv()));
    files.push(json("participants.json", &columns(&participants)));
    let dataset = json!({
        "Name": study.title(), "BIDSVersion": BIDS_VERSION, "DatasetType": "raw",
        "GeneratedBy": [{ "Name": "Shutterlab", "Version": env!("CARGO_PKG_VERSION") }],
    });
    files.push(json("dataset_description.json", &dataset));
    files
}

/// The answers in `rows`, with the name that BIDS has for the response time.
fn answers(study: &Study, rows: &[Response]) -> Table {
    let mut table = study.responses(rows.iter());
    rename(&mut table, "response_time_s", "response_time");
    table
}

/// Everybody with answers, first of all under the name of their folder.
fn participants(study: &Study) -> Table {
    let mut table = study.participants.clone();
    rename(&mut table, "subject", "participant_id");
    let answered = study.answered();
    table.rows.retain(|row| answered.contains(&row[0]));
    table.rows.iter_mut().for_each(|row| row[0].insert_str(0, "sub-"));
    let mut table = study.stamped(table);
    if let Some(fields) = table.schema["fields"].as_array_mut() {
        fields.swap(0, 1);
    }
    table.rows.iter_mut().for_each(|row| row.swap(0, 1));
    table
}

fn rename(table: &mut Table, from: &str, to: &str) {
    let fields = table.schema["fields"].as_array_mut().into_iter().flatten();
    fields.filter(|field| field["name"] == from).for_each(|field| field["name"] = to.into());
}

/// What BIDS says of the columns of `table`.
fn columns(table: &Table) -> Value {
    let about = |field: &Field| {
        let mut about = Map::new();
        about.insert("Description".into(), field.description.clone().into());
        if let Some(unit) = &field.unit {
            about.insert("Units".into(), unit.clone().into());
        }
        let levels = field.levels();
        if !levels.is_empty() {
            let levels = levels.into_iter().map(|(value, label)| (value.into(), label.into()));
            about.insert("Levels".into(), Value::Object(levels.collect()));
        }
        (field.name.clone(), about.into())
    };
    Value::Object(table.fields().iter().map(about).collect())
}
