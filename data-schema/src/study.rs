//! The study folder: a Frictionless data package and a Psych-DS dataset.
//!
//! `datapackage.json` and `dataset_description.json` describe what lies in the folder and are made
//! anew from it whenever a session begins, so several stations can write into one study.

use crate::files::{named, write_atomically};
use crate::participant::{Participant, ParticipantCode};
use crate::protocol::{ParticipantField, Protocol};
use crate::response::Response;
use crate::table_schema::table_schema;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};
use std::io;
use std::path::{Path, PathBuf};

/// Whose answers a study holds. Pilot and simulated answers lie in studies of their own inside the
/// study's folder, where no analysis of the study sees them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StudyKind {
    /// Participants' answers that count.
    Real,
    /// Answers of trial runs.
    Pilot,
    /// Answers of simulated observers.
    Simulated,
}

impl StudyKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Real, Self::Pilot, Self::Simulated];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Real => "real",
            Self::Pilot => "pilot",
            Self::Simulated => "simulated",
        }
    }

    /// Where the answers lie in the study in `study`.
    pub fn folder(self, study: &Path) -> PathBuf {
        match self {
            Self::Real => study.to_path_buf(),
            Self::Pilot => study.join("pilot"),
            Self::Simulated => study.join("simulated"),
        }
    }

    /// The title of the protocol, after what everybody has to know.
    pub fn title(self, protocol: &Protocol) -> String {
        match self.banner() {
            Some(banner) => format!("{banner}: {}", protocol.title),
            None => protocol.title.clone(),
        }
    }

    /// What everybody who opens the folder has to know.
    pub fn banner(self) -> Option<&'static str> {
        match self {
            Self::Real => None,
            Self::Pilot => Some("PILOT: answers of trial runs, never a result"),
            Self::Simulated => Some("SIMULATED OBSERVERS: a check of the tool, never a finding"),
        }
    }
}

/// Name of a session's data file inside the study's `data` folder, in the form of Psych-DS.
pub fn data_file_name(protocol: &Protocol, subject: &ParticipantCode, session: u32) -> String {
    // Psych-DS allows letters and digits only.
    let task = protocol.task.name().replace('-', "");
    format!("study-{}_subject-{subject}_session-{session}_task-{task}_data.csv", protocol.name)
}

/// The data files of the study in `folder`, in the order of their names.
///
/// # Errors
/// The `data` folder cannot be read.
pub fn data_files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let data = folder.join("data");
    if !data.is_dir() {
        let mut what = format!("{}: not a study: it has no folder `data`", folder.display());
        for kind in [StudyKind::Simulated, StudyKind::Pilot] {
            let other = kind.folder(folder);
            if other.join("data").is_dir() {
                what += &format!("; there is one in {}", other.display());
            }
        }
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

/// Table Schema of the participants, with the protocol's own `fields`.
pub fn participants_schema(fields: &[ParticipantField]) -> Value {
    let mut schema = table_schema::<Participant>(&["subject"]);
    let own = fields.iter().map(|field| {
        json!({
            "name": field.key, "type": "string", "description": field.label,
            "constraints": { "enum": field.options },
        })
    });
    if let Some(all) = schema["fields"].as_array_mut() {
        all.extend(own);
    }
    schema
}

/// A table of a data package: its name, its path in the package, and its schema or the path of that.
pub fn resource(name: &str, path: &str, schema: Value) -> Value {
    json!({
        "name": name, "path": path, "profile": "tabular-data-resource",
        "format": "csv", "mediatype": "text/csv", "encoding": "utf-8", "schema": schema,
    })
}

/// A data package of tables; see [`resource`].
pub fn data_package(protocol: &Protocol, title: &str, resources: &[Value]) -> Value {
    json!({
        "profile": "tabular-data-package",
        "name": protocol.name.to_lowercase(), "title": title, "resources": resources,
    })
}

/// Repeats `write` with what `list` gives until that is the same after as before, so that of several
/// stations that write at once the last one has seen everything.
///
/// # Errors
/// Those of `list` and `write`.
pub fn until_settled<T: PartialEq, E>(
    list: impl Fn() -> Result<T, E>,
    mut write: impl FnMut(&T) -> Result<(), E>,
) -> Result<(), E> {
    let mut listed = list()?;
    loop {
        write(&listed)?;
        let now = list()?;
        if now == listed {
            return Ok(());
        }
        listed = now;
    }
}

/// Writes the two descriptions of the study in `folder`, which is of the kind `kind`, and the schemas that
/// they refer to.
///
/// # Errors
/// The folder cannot be read or a file cannot be written.
pub fn write_descriptions(folder: &Path, protocol: &Protocol, kind: StudyKind) -> io::Result<()> {
    until_settled(|| data_files(folder), |files| describe(folder, protocol, kind, files))
}

fn describe(
    folder: &Path,
    protocol: &Protocol,
    kind: StudyKind,
    files: &[PathBuf],
) -> io::Result<()> {
    let title = kind.title(protocol);
    let (participants, responses) = ("participants.schema.json", "responses.schema.json");
    let mut resources = vec![resource("participants", "participants.csv", participants.into())];
    for path in files {
        let Some(file) = path.file_name().map(|name| name.to_string_lossy().into_owned()) else {
            continue;
        };
        let name = file.trim_end_matches(".csv").to_lowercase();
        resources.push(resource(&name, &format!("data/{file}"), responses.into()));
    }
    let package = data_package(protocol, &title, &resources);
    let schema = responses_schema();
    let variables: Vec<&Value> =
        schema["fields"].as_array().into_iter().flatten().map(|f| &f["name"]).collect();
    let dataset = json!({
        "@context": "https://schema.org/", "@type": "Dataset",
        "name": protocol.name, "description": title, "variableMeasured": variables,
    });
    for (file, value) in [
        (participants, participants_schema(&protocol.participant)),
        (responses, schema),
        ("datapackage.json", package),
        ("dataset_description.json", dataset),
    ] {
        write_atomically(&folder.join(file), format!("{value:#}\n").as_bytes())?;
    }
    Ok(())
}
