//! Export as a Psych-DS dataset (<https://psych-ds.github.io>): the study's data files, every column
//! described in the words of schema.org, and what the study was run with as materials.

use super::readme::mark;
use super::study::Study;
use super::table::{Field, Table, cells};
use super::{Format, json};
use serde_json::{Map, Value, json};
use shutterlab_data_schema::study::{data_package, resource, responses_schema};

pub(super) fn files(study: &Study) -> Vec<(String, Vec<u8>)> {
    let schema = responses_schema();
    let mut resources =
        vec![resource("participants", "participants.csv", study.participants.schema.clone())];
    let mut files = vec![("participants.csv".to_string(), study.participants.csv())];
    for session in &study.sessions {
        let table =
            Table { schema: schema.clone(), rows: session.rows.iter().map(cells).collect() };
        // Psych-DS knows the keyword `description`.
        let name = match study.kind.banner() {
            Some(_) => {
                let ending = format!("_description-{}_data.csv", study.kind.name());
                session.file.replace("_data.csv", &ending)
            }
            None => session.file.clone(),
        };
        let path = format!("data/{name}");
        resources.push(resource(
            &name.trim_end_matches(".csv").to_lowercase(),
            &path,
            "responses.schema.json".into(),
        ));
        files.push((path, table.csv()));
    }
    let fields = Table { schema: schema.clone(), rows: vec![] }.fields();
    let variables: Vec<Value> = fields.iter().map(variable).collect();
    let dataset = json!({
        "@context": "https://schema.org/", "@type": "Dataset",
        "name": study.protocol.name, "description": study.title(),
        "variableMeasured": variables,
    });
    files.push(json("dataset_description.json", &dataset));
    files
        .push(json("datapackage.json", &data_package(&study.protocol, &study.title(), &resources)));
    files.push(json("responses.schema.json", &schema));
    let last = study.rows().map(|row| row.answered_at.as_str()).max().unwrap_or_default();
    let changes = format!(
        "# Changes\n\n## 1.0.0\n\n- {} {}; the last answer was given at {last}.\n",
        mark(study, Format::PsychDs),
        env!("CARGO_PKG_VERSION"),
    );
    files.push(("CHANGES.md".into(), changes.into_bytes()));
    files.push(("materials/protocol.toml".into(), study.protocol_text.clone().into_bytes()));
    for (id, png) in &study.thumbnails {
        files.push((format!("materials/thumbnails/{id}.png"), png.clone()));
    }
    files
}

/// A column in the words of schema.org.
fn variable(field: &Field) -> Value {
    let mut about = Map::new();
    about.insert("@type".into(), "PropertyValue".into());
    about.insert("name".into(), field.name.clone().into());
    about.insert("description".into(), field.description.clone().into());
    if let Some(unit) = &field.unit {
        about.insert("unitText".into(), unit.clone().into());
    }
    let levels = field.levels();
    if !levels.is_empty() {
        let level = |(value, label)| json!({ "@type": "PropertyValue", "value": value, "description": label });
        about.insert("valueReference".into(), levels.into_iter().map(level).collect());
    }
    about.into()
}
