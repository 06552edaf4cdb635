//! Tables of items: a CSV with the column `item` and one of numbers. Lines that begin with `#` are
//! comments.

use std::path::Path;

/// The table could not be read. Every message names the file.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {what}")]
pub struct TableError {
    file: String,
    what: String,
}

/// Reads the table in the file at `path`; see [`parse`].
///
/// # Errors
/// The file cannot be read, or as [`parse`].
pub fn read<T>(
    path: &Path,
    column: &str,
    number: impl Fn(&str) -> Option<T>,
    needed: &str,
) -> Result<Vec<(String, T)>, TableError> {
    let file = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => parse(&text, &file, column, number, needed),
        Err(error) => Err(TableError { file, what: format!("cannot be read: {error}") }),
    }
}

/// The text of a table as other programs write it, with lines that end as ours do and without the mark that some
/// put before it (U+FEFF), so that lines are counted and columns found.
pub fn plain(text: &str) -> String {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // Line breaks within a cell stay as they are in a file of our own.
    match text.split_once('\n') {
        Some((header, _)) if header.ends_with('\r') => text.replace("\r\n", "\n"),
        _ => text.to_string(),
    }
}

/// The items of a table and their numbers in `column`, in the order of the file. `file` is what an error
/// calls it; `number` reads a number, and `needed` says what it accepts.
///
/// # Errors
/// The column `item` or `column` is missing; a number is none; an item is empty or comes twice; there are
/// fewer than two items.
pub fn parse<T>(
    text: &str,
    file: &str,
    column: &str,
    number: impl Fn(&str) -> Option<T>,
    needed: &str,
) -> Result<Vec<(String, T)>, TableError> {
    let fail = |what: String| TableError { file: file.into(), what };
    let text = plain(text);
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let headers = reader.headers().map_err(|e| fail(e.to_string()))?.clone();
    let place = |name: &str| {
        headers.iter().position(|header| header == name).ok_or_else(|| {
            let found = headers.iter().collect::<Vec<_>>().join(", ");
            fail(format!("column `{name}` is missing: found `{found}`, needed `item,{column}`"))
        })
    };
    let (item_place, number_place) = (place("item")?, place(column)?);
    let mut rows: Vec<(String, T)> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| fail(e.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let (item, text) = (&record[item_place], &record[number_place]);
        let number = number(text).ok_or_else(|| {
            fail(format!("line {line}: {column} of `{item}`: `{text}`: {needed} is needed"))
        })?;
        if item.is_empty() {
            return Err(fail(format!("line {line}: item: empty: a name is needed")));
        }
        if rows.iter().any(|(other, _)| other == item) {
            return Err(fail(format!("line {line}: item: `{item}`: each item may come once")));
        }
        rows.push((item.into(), number));
    }
    match rows.len() {
        0 | 1 => Err(fail(format!("{} items: at least two are needed", rows.len()))),
        _ => Ok(rows),
    }
}
