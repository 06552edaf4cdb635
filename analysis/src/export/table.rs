//! A table of an export: its schema and its cells, as CSV or as the TSV of BIDS.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use shutterlab_data_schema::table_schema::table_schema;

/// A table. A cell that is empty is a missing value.
#[derive(Clone, Debug)]
pub(super) struct Table {
    /// Its Table Schema.
    pub schema: Value,
    /// The cells, row by row, in the order of the schema's fields.
    pub rows: Vec<Vec<String>>,
}

/// What a Table Schema says of a column.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Field {
    pub name: String,
    #[serde(rename = "type")]
    pub kind: String,
    pub description: String,
    pub unit: Option<String>,
    #[serde(default)]
    categories: Vec<Category>,
    constraints: Option<Constraints>,
}

#[derive(Clone, Debug, Deserialize)]
struct Category {
    value: String,
    label: String,
}

#[derive(Clone, Debug, Deserialize)]
struct Constraints {
    #[serde(default, rename = "enum")]
    values: Vec<String>,
}

impl Field {
    /// The values that the column can have, each with its meaning; none if they cannot be listed.
    pub fn levels(&self) -> Vec<(&str, &str)> {
        if self.categories.is_empty() {
            let values = self.constraints.iter().flat_map(|constraints| &constraints.values);
            return values.map(|value| (value.as_str(), value.as_str())).collect();
        }
        self.categories.iter().map(|level| (level.value.as_str(), level.label.as_str())).collect()
    }
}

impl Table {
    /// The columns.
    pub fn fields(&self) -> Vec<Field> {
        let fields = self.schema["fields"].as_array().into_iter().flatten();
        fields.filter_map(|field| Field::deserialize(field).ok()).collect()
    }

    /// The table as CSV (RFC 4180).
    pub fn csv(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        {
            let mut writer = csv::Writer::from_writer(&mut bytes);
            // Writing to memory cannot fail, and every row has a cell for each field.
            let _ = writer.write_record(self.fields().iter().map(|field| &field.name));
            for row in &self.rows {
                let _ = writer.write_record(row);
            }
            let _ = writer.flush();
        }
        bytes
    }

    /// The table as BIDS has it: tabs, `n/a` for what is missing, nothing quoted.
    pub fn tsv(&self) -> Vec<u8> {
        let names = self.fields().into_iter().map(|field| field.name).collect();
        let mut text = String::new();
        for row in std::iter::once(&names).chain(&self.rows) {
            let cell = |cell: &String| match cell.as_str() {
                "" => "n/a".into(),
                text => text.replace(['\t', '\r', '\n'], " "),
            };
            text += &row.iter().map(cell).collect::<Vec<String>>().join("\t");
            text.push('\n');
        }
        text.into_bytes()
    }
}

/// `schema` with the columns of `T` before its own.
pub(super) fn columns_before<T: JsonSchema>(mut schema: Value) -> Value {
    let mut fields = table_schema::<T>(&[])["fields"].take();
    if let (Some(all), Value::Array(own)) = (fields.as_array_mut(), schema["fields"].take()) {
        all.extend(own);
    }
    schema["fields"] = fields;
    schema
}

/// A column of the names in `levels`.
pub(super) fn column_of_levels(name: &str, description: &str, levels: &[&str]) -> Value {
    json!({
        "name": name, "type": "string", "description": description,
        "constraints": { "enum": levels },
    })
}

/// The cells of a row.
pub(super) fn cells(row: &impl Serialize) -> Vec<String> {
    let text = |value: Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text,
        other => other.to_string(),
    };
    match serde_json::to_value(row) {
        Ok(Value::Object(fields)) => fields.into_iter().map(|(_, value)| text(value)).collect(),
        _ => vec![],
    }
}
