//! Reading what is known of the participants of a study: the protocol's own columns of
//! `participants.csv`.

use crate::error::InputError;
use shutterlab_data_schema::item_table::plain;
use std::collections::BTreeMap;
use std::path::Path;

/// Columns that every study has and that tell observers apart, not what they have in common.
const EVERY_STUDY: [&str; 6] =
    ["subject", "observer", "seed", "ordinal", "first_session", "consented_at"];

/// Adds what `file` says of the participants of `study` to `traits`, by (study, subject).
///
/// # Errors
/// The file cannot be read, is no CSV, has no column `subject`, or has a subject twice.
pub(super) fn read(
    file: &Path,
    study: &str,
    traits: &mut BTreeMap<(String, String), BTreeMap<String, String>>,
) -> Result<(), InputError> {
    let name = file.display().to_string();
    let malformed = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        InputError::line(&name, line, "row", &error, "a row of a CSV is needed")
    };
    let text = std::fs::read_to_string(file)
        .map_err(|source| InputError::Unreadable { file: name.clone(), source })?;
    let text = plain(&text);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().map_err(malformed)?.clone();
    let Some(subject) = header.iter().position(|column| column == "subject") else {
        let found = header.iter().collect::<Vec<_>>().join(", ");
        return Err(InputError::line(&name, 1, "header", found, "a column subject is needed"));
    };
    for record in reader.records() {
        let record = record.map_err(malformed)?;
        let own = header
            .iter()
            .zip(&record)
            .filter(|(column, value)| !EVERY_STUDY.contains(column) && !value.is_empty());
        let own = own.map(|(column, value)| (column.to_string(), value.to_string())).collect();
        let who = (study.to_string(), record[subject].to_string());
        if traits.insert(who, own).is_some() {
            let line = record.position().map_or(0, csv::Position::line);
            let value = format!("`{}`", &record[subject]);
            return Err(InputError::line(&name, line, "subject", value, "each may come once"));
        }
    }
    Ok(())
}
