//! Frictionless Table Schema for a CSV, made from the JSON Schema of its row type, so that names,
//! types, units, constraints and descriptions are written once: on the Rust struct.

use schemars::{JsonSchema, SchemaGenerator, generate::SchemaSettings};
use serde_json::{Map, Value, json};

/// The Table Schema of a CSV whose rows are `T`. `primary_key` names the columns that identify a row.
pub fn table_schema<T: JsonSchema>(primary_key: &[&str]) -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    let root = SchemaGenerator::new(settings).into_root_schema_for::<T>();
    let required: Vec<&str> = root
        .get("required")
        .and_then(Value::as_array)
        .map_or(vec![], |names| names.iter().filter_map(Value::as_str).collect());
    let fields: Vec<Value> =
        root.get("properties").and_then(Value::as_object).map_or(vec![], |properties| {
            properties
                .iter()
                .map(|(name, schema)| field(name, schema, required.contains(&name.as_str())))
                .collect()
        });
    json!({ "fields": fields, "primaryKey": primary_key, "missingValues": [""] })
}

fn field(name: &str, schema: &Value, required: bool) -> Value {
    let mut constraints = Map::new();
    if required {
        constraints.insert("required".into(), true.into());
    }
    for key in ["minimum", "maximum", "pattern"] {
        if let Some(value) = schema.get(key) {
            constraints.insert(key.into(), value.clone());
        }
    }
    let variants = variants(schema);
    if !variants.is_empty() {
        constraints.insert("enum".into(), variants.iter().map(|(name, _)| json!(name)).collect());
    }
    let mut field = Map::new();
    field.insert("name".into(), name.into());
    field.insert("type".into(), field_type(schema).into());
    field.insert("description".into(), one_line(schema.get("description")).into());
    if let Some(unit) = schema.get("unit") {
        field.insert("unit".into(), unit.clone());
    }
    if !variants.is_empty() {
        let category = |(name, meaning)| json!({ "value": name, "label": meaning });
        field.insert("categories".into(), variants.into_iter().map(category).collect());
    }
    field.insert("constraints".into(), constraints.into());
    field.into()
}

fn one_line(text: Option<&Value>) -> String {
    text.and_then(Value::as_str).unwrap_or_default().replace('\n', " ")
}

/// The values of an enum and what each means.
fn variants(schema: &Value) -> Vec<(&str, String)> {
    schema.get("oneOf").and_then(Value::as_array).map_or(vec![], |options| {
        options
            .iter()
            .filter_map(|option| {
                let name = option.get("const")?.as_str()?;
                Some((name, one_line(option.get("description"))))
            })
            .collect()
    })
}

fn field_type(schema: &Value) -> &'static str {
    if schema.get("format").and_then(Value::as_str) == Some("date-time") {
        return "datetime";
    }
    let kind = match schema.get("type") {
        Some(Value::String(kind)) => kind.as_str(),
        Some(Value::Array(kinds)) => {
            kinds.iter().filter_map(Value::as_str).find(|k| *k != "null").unwrap_or("string")
        }
        _ => "string",
    };
    match kind {
        "integer" => "integer",
        "number" => "number",
        "boolean" => "boolean",
        _ => "string",
    }
}
