//! The study folder: a Frictionless data package and a Psych-DS dataset.
//!
//! `datapackage.json` and `dataset_description.json` describe what lies in the folder and are made
//! anew from it whenever a session begins, so several stations can write into one study.

use crate::files::{named, write_atomically};
use crate::participant::{Participant, ParticipantCode};
use crate::protocol::{Protocol, Task};
use crate::response::Response;
use crate::table_schema::table_schema;
use serde_json::{Value, json};
use std::io;
use std::path::{Path, PathBuf};

/// Name of a session's data file inside the study's `data` folder, in the form of Psych-DS.
pub fn data_file_name(protocol: &Protocol, subject: &ParticipantCode, session: u32) -> String {
    let task = match protocol.task {
        Task::TwoAfc => "2afc",
    };
    format!("study-{}_subject-{subject}_session-{session}_task-{task}_data.csv", protocol.name)
}

/// The data files of the study in `folder`, in the order of their names.
///
/// # Errors
/// The `data` folder cannot be read.
pub fn data_files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let data = folder.join("data");
    if !data.is_dir() {
        let what = format!("{}: not a study: it has no folder `data`", folder.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, what));
    }
    let mut files = Vec::new();
    for entry in std::fs::read_dir(&data).map_err(|e| named(&data, &e))? {
        let path = entry?.path();
        if path.file_name().is_some_and(|name| name.to_string_lossy().ends_with("_data.csv")) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// Table Schema of the responses.
pub fn responses_schema() -> Value {
    table_schema::<Response>(&["subject", "session", "trial"])
}

/// Table Schema of the participants.
pub fn participants_schema() -> Value {
    table_schema::<Participant>(&["subject"])
}

/// Writes the two descriptions of the study in `folder`.
///
/// # Errors
/// The folder cannot be read or a file cannot be written.
pub fn write_descriptions(folder: &Path, protocol: &Protocol) -> io::Result<()> {
    let resource = |name: String, path: String, schema: Value| {
        json!({
            "name": name, "path": path, "profile": "tabular-data-resource",
            "format": "csv", "mediatype": "text/csv", "encoding": "utf-8", "schema": schema,
        })
    };
    let mut resources =
        vec![resource("participants".into(), "participants.csv".into(), participants_schema())];
    for path in data_files(folder)? {
        let Some(file) = path.file_name().map(|name| name.to_string_lossy().into_owned()) else {
            continue;
        };
        let name = file.trim_end_matches(".csv").to_lowercase();
        resources.push(resource(name, format!("data/{file}"), responses_schema()));
    }
    let package = json!({
        "profile": "tabular-data-package",
        "name": protocol.name.to_lowercase(), "title": protocol.title, "resources": resources,
    });
    let schema = responses_schema();
    let variables: Vec<&Value> =
        schema["fields"].as_array().into_iter().flatten().map(|f| &f["name"]).collect();
    let dataset = json!({
        "@context": "https://schema.org/", "@type": "Dataset",
        "name": protocol.name, "description": protocol.title, "variableMeasured": variables,
    });
    for (file, value) in [("datapackage.json", package), ("dataset_description.json", dataset)] {
        write_atomically(&folder.join(file), format!("{value:#}\n").as_bytes())?;
    }
    Ok(())
}
