//! Export as tables: one CSV each for answers, participants and stimuli, a codebook made from their
//! schemas, and scripts that load them into R and pandas with types and labels.

use super::json;
use super::study::Study;
use super::table::{Field, Table, cells};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use shutterlab_data_schema::study::{data_package, resource};
use shutterlab_data_schema::table_schema::table_schema;

/// A row of the codebook.
#[derive(Serialize, JsonSchema)]
struct Variable {
    /// File of the table.
    file: &'static str,
    /// Name of the column.
    variable: String,
    /// Type of its values: string, integer, number, boolean (true or false) or datetime (UTC, ISO 8601).
    #[serde(rename = "type")]
    kind: String,
    /// Unit of its values; empty if they have none.
    unit: Option<String>,
    /// The values it can have, one in a line; empty if they cannot be listed.
    levels: Option<String>,
    /// What each of these values means, one in a line, in the same order.
    labels: Option<String>,
    /// What it holds.
    description: String,
}

pub(super) fn files(study: &Study) -> Vec<(String, Vec<u8>)> {
    let mut tables = vec![
        ("responses.csv", study.responses(study.rows())),
        ("participants.csv", study.stamped(study.participants.clone())),
        ("stimuli.csv", study.stimuli()),
    ];
    let variables = tables
        .iter()
        .flat_map(|(file, table)| table.fields().into_iter().map(|field| variable(file, field)));
    let rows = variables.map(|variable| cells(&variable)).collect();
    let schema = table_schema::<Variable>(&["file", "variable"]);
    tables.push(("codebook.csv", study.stamped(Table { schema, rows })));

    let resources: Vec<Value> = tables
        .iter()
        .map(|(file, table)| resource(file.trim_end_matches(".csv"), file, table.schema.clone()))
        .collect();
    let package = data_package(&study.protocol, &study.title(), &resources);
    let mut files: Vec<(String, Vec<u8>)> =
        tables.iter().map(|(file, table)| (file.to_string(), table.csv())).collect();
    files.push(json("datapackage.json", &package));
    let title = study.title().split_whitespace().collect::<Vec<_>>().join(" ");
    for (name, script) in [("load.R", include_str!("load.R")), ("load.py", include_str!("load.py"))]
    {
        let script = script.replace("# STUDY\n", &format!("# {title}\n"));
        files.push((name.into(), script.into_bytes()));
    }
    files
}

fn variable(file: &'static str, field: Field) -> Variable {
    let levels = field.levels();
    // One in a line: what does not fit into a line is read as text.
    let fit = !levels.iter().any(|(level, label)| level.contains('\n') || label.contains('\n'));
    let (levels, labels): (Vec<&str>, Vec<&str>) = levels.into_iter().unzip();
    let lines = |names: Vec<&str>| (fit && !names.is_empty()).then(|| names.join("\n"));
    Variable {
        file,
        levels: lines(levels),
        labels: lines(labels),
        variable: field.name,
        kind: field.kind,
        unit: field.unit,
        description: field.description,
    }
}
