//! Reading a preference matrix: CSV with a header row and a header column of the same items; a cell
//! says how many observers chose the item of its row over the item of its column.

use crate::error::InputError;
use crate::input::preferences::{Preferences, WinMatrix, check_items};
use shutterlab_data_schema::item_table::plain;
use std::path::Path;

/// Reads the matrix at `path`, judged by so many `observers`. Lines that begin with `#` are comments.
///
/// # Errors
/// The file cannot be read, or as [`parse`].
pub fn read(path: &Path, observers: u64) -> Result<Preferences, InputError> {
    let file = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => parse(&text, observers, &file),
        Err(source) => Err(InputError::Unreadable { file, source }),
    }
}

/// Parses a matrix; `file` is what an error calls it.
///
/// # Errors
/// It is not square; header row and header column differ; an item is empty or comes twice; a cell
/// is no whole number from 0; the diagonal is not 0 or empty; or as [`Preferences::from_matrix`].
pub fn parse(text: &str, observers: u64, file: &str) -> Result<Preferences, InputError> {
    let text = plain(text);
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let malformed = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        InputError::line(file, line, "row", error, "a row of a CSV is needed")
    };
    let header = reader.headers().map_err(malformed)?.clone();
    let items: Vec<String> = header.iter().skip(1).map(str::to_string).collect();
    check_items(items.len(), file)?;
    for (i, item) in items.iter().enumerate() {
        if item.is_empty() {
            return Err(InputError::line(file, 1, "item", "empty", "a name is needed"));
        }
        if items[..i].contains(item) {
            let (value, allowed) = (format!("`{item}`"), "each item may come once");
            return Err(InputError::line(file, 1, "item", value, allowed));
        }
    }
    let mut wins = WinMatrix::new(items.len());
    let mut rows = 0;
    for record in reader.records() {
        let record = record.map_err(malformed)?;
        let line = record.position().map_or(0, csv::Position::line);
        let name = &record[0];
        if items.get(rows).is_none_or(|item| item != name) {
            let expected = match items.get(rows) {
                Some(item) => format!("`{item}` is needed, as in the header row"),
                None => format!("the header row has {} items", items.len()),
            };
            return Err(InputError::line(file, line, "row", format!("`{name}`"), expected));
        }
        if record.len() != items.len() + 1 {
            return Err(InputError::line(
                file,
                line,
                format!("row `{name}`"),
                format!("{} cells", record.len() - 1),
                format!("one for each of {} items is needed", items.len()),
            ));
        }
        for (column, cell) in record.iter().skip(1).enumerate() {
            let field = || format!("`{name}` over `{}`", items[column]);
            if column == rows {
                if !matches!(cell, "" | "0") {
                    let value = format!("`{cell}`");
                    let allowed = "0 or nothing is allowed: no item is compared with itself";
                    return Err(InputError::line(file, line, field(), value, allowed));
                }
                continue;
            }
            match cell.parse() {
                Ok(count) => wins.add(rows, column, count),
                Err(_) => {
                    let value = format!("`{cell}`");
                    let allowed = "a whole number from 0 is needed";
                    return Err(InputError::line(file, line, field(), value, allowed));
                }
            }
        }
        rows += 1;
    }
    if rows != items.len() {
        let found = format!("{rows} rows, {} columns", items.len());
        return Err(InputError::value(file, "matrix", found, "as many rows as columns are needed"));
    }
    Preferences::from_matrix(items, wins, observers, file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::preferences::Judgements;

    #[test]
    fn a_row_is_chosen_over_a_column() {
        let matrix = parse("# made up\n,A,B\nA,,7\nB,3,0\n", 10, "m").unwrap();
        let Judgements::Pooled { wins, observers: 10 } = matrix.judgements() else { panic!() };
        assert_eq!((wins.get(0, 1), wins.get(1, 0)), (7, 3));
        assert!(matrix.notes.is_empty());
    }

    #[test]
    fn missing_judgements_are_said_in_words() {
        let matrix = parse("item,A,B,C\nA,0,7,2\nB,3,0,5\nC,2,5,0\n", 10, "m").unwrap();
        assert_eq!(
            matrix.notes,
            [
                "The matrix is incomplete: 1 of 3 pairs were judged by fewer than 10 observers (A–C 4)."
            ]
        );
    }

    #[test]
    fn bad_matrices_are_refused_by_name() {
        for (text, expect) in [
            (
                ",A,B\nA,0,7\nB,4,0\n",
                "m.csv: `A` and `B`: 7 + 4 judgements: at most one by each of 10",
            ),
            (",A,B\nA,0,-7\nB,3,0\n", "m.csv: line 2: `A` over `B`: `-7`: a whole number from 0"),
            (",A,B\nA,0,7\nB,0.3,0\n", "m.csv: line 3: `B` over `A`: `0.3`: a whole number from 0"),
            (",A,B\nA,0,7\nB,3,1\n", "m.csv: line 3: `B` over `B`: `1`: 0 or nothing"),
            (",A,B\nA,0,7\n", "m.csv: matrix: 1 rows, 2 columns: as many rows"),
            (",A,B\nA,0,7\nB,3,0\nC,1,2\n", "m.csv: line 4: row: `C`: the header row has 2 items"),
            (",A,B\nB,0,7\nA,3,0\n", "m.csv: line 2: row: `B`: `A` is needed"),
            (",A,B\nA,0\nB,3,0\n", "m.csv: line 2: row `A`: 1 cells: one for each of 2 items"),
            (",A,A\nA,0,7\nA,3,0\n", "m.csv: line 1: item: `A`: each item may come once"),
            (",A,\nA,0,7\n,3,0\n", "m.csv: line 1: item: empty: a name is needed"),
            (",A\nA,0\n", "m.csv: items: 1: 2 to 1000 are allowed"),
            (",A,B,C\nA,0,7,0\nB,3,0,0\nC,0,0,0\n", "m.csv: `C`: never judged: "),
            (
                ",A,B\nA,0,18446744073709551615\nB,18446744073709551615,0\n",
                "m.csv: `A` and `B`: 18446744073709551615 + 18446744073709551615 judgements",
            ),
            ("", "m.csv: items: 0: 2 to 1000 are allowed"),
        ] {
            let error = parse(text, 10, "m.csv").unwrap_err().to_string();
            assert!(error.starts_with(expect), "{text:?} gave {error}");
        }
    }
}
