//! An analysis as files: every table as CSV, one data package that describes them all, and every figure as
//! SVG and PNG.

use super::document::Document;
use super::picture;
use super::section::{Cell, Kind, Section, Table};
use serde_json::{Value, json};

/// Names and contents of the files, whose names begin with `simulated-` where the observers were
/// simulated. Figures lie in the folder `figures`.
pub fn files(document: &Document) -> Vec<(String, Vec<u8>)> {
    let prefix = if document.simulated { "simulated-" } else { "" };
    let tables = || document.sections.iter().flat_map(|section| &section.tables);
    let mut files: Vec<(String, Vec<u8>)> = tables()
        .map(|table| (format!("{prefix}{}.csv", table.name), csv_text(table).into_bytes()))
        .collect();
    let package = json!({
        "profile": "tabular-data-package",
        "name": format!("{prefix}analysis"),
        "title": match document.simulated {
            true => format!("SIMULATED OBSERVERS: a check of the tool, never a finding. {}", document.lead),
            false => document.lead.clone(),
        },
        "resources": tables().map(|table| resource(table, prefix)).collect::<Vec<_>>(),
        "figures": document.sections.iter().flat_map(|section| &section.figures)
            .flat_map(|figure| ["png", "svg"].map(|e| format!("figures/{prefix}{}.{e}", figure.name)))
            .collect::<Vec<_>>(),
    });
    if tables().next().is_some() {
        files.push((format!("{prefix}datapackage.json"), format!("{package:#}\n").into_bytes()));
    }
    for figure in document.sections.iter().flat_map(|section| &section.figures) {
        let svg = picture::standalone(&figure.svg, document.simulated);
        let name = format!("figures/{prefix}{}", figure.name);
        if let Some(png) = picture::png(&svg) {
            files.push((format!("{name}.png"), png));
        }
        files.push((format!("{name}.svg"), svg.into_bytes()));
    }
    files
}

/// The files of which the text of a `datapackage.json` of [`files`] says that they were written with it; none
/// if it is another's.
pub fn files_of(package: &str) -> Vec<String> {
    let package: Value = serde_json::from_str(package).unwrap_or_default();
    let of = |list: &Value, name: &dyn Fn(&Value) -> Option<String>| -> Vec<String> {
        list.as_array().into_iter().flatten().filter_map(name).collect()
    };
    if !["analysis", "simulated-analysis"].iter().any(|name| package["name"] == *name) {
        return Vec::new();
    }
    let text = |value: &Value| value.as_str().map(str::to_string);
    let mut names = of(&package["resources"], &|resource| text(&resource["path"]));
    names.extend(of(&package["figures"], &text));
    // Never a file outside the folder.
    names.retain(|name| !name.contains("..") && !name.starts_with('/') && !name.contains(':'));
    names
}

/// The table with that name, as CSV.
pub fn csv(sections: &[Section], name: &str) -> Option<String> {
    sections
        .iter()
        .flat_map(|section| &section.tables)
        .find(|table| table.name == name)
        .map(csv_text)
}

fn resource(table: &Table, prefix: &str) -> Value {
    let fields: Vec<Value> = table
        .columns
        .iter()
        .map(|column| {
            let kind = match column.kind {
                Kind::Text => "string",
                Kind::Integer => "integer",
                Kind::Number(_) | Kind::P => "number",
                Kind::Flag => "boolean",
            };
            let description = match column.kind {
                Kind::P => format!("{} 1e-300 stands for any smaller probability.", column.description),
                _ => column.description.clone(),
            };
            json!({
                "name": column.name, "title": column.title, "type": kind, "description": description,
            })
        })
        .collect();
    json!({
        "name": format!("{prefix}{}", table.name), "path": format!("{prefix}{}.csv", table.name),
        "description": table.caption, "profile": "tabular-data-resource", "format": "csv",
        "mediatype": "text/csv", "encoding": "utf-8",
        "schema": { "fields": fields, "missingValues": [""] },
    })
}

fn csv_text(table: &Table) -> String {
    let mut bytes = Vec::new();
    {
        let mut writer = csv::Writer::from_writer(&mut bytes);
        // Writing to memory cannot fail, and every row has the fields of its header.
        let _ = writer.write_record(table.columns.iter().map(|column| &column.name));
        for row in &table.rows {
            let _ = writer.write_record(row.iter().map(field));
        }
        let _ = writer.flush();
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A value with all its digits, as R and pandas read it.
fn field(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Integer(value) => value.to_string(),
        Cell::Number(value) => number(*value),
        Cell::P(p) => number(p.value().max(1e-300)),
        Cell::Flag(value) => value.to_string(),
        Cell::Missing => String::new(),
    }
}

/// The shortest digits that give the same number again, small and large ones with an exponent.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if (1e-4..1e15).contains(&size) => value.to_string(),
        _ => format!("{value:e}"),
    }
}
