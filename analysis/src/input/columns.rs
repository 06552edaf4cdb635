//! Reading a CSV by the names of its columns. Lines that begin with `#` are comments.

use crate::error::InputError;
use csv::StringRecord;
use shutterlab_data_schema::item_table::plain;
use std::path::Path;

/// A CSV whose columns are known by name.
pub(crate) struct Columns {
    file: String,
    names: StringRecord,
    records: Vec<(u64, StringRecord)>,
}

/// A row of a CSV.
pub(crate) struct Row<'a> {
    table: &'a Columns,
    line: u64,
    cells: &'a StringRecord,
}

/// The text of the file at `path`.
pub(crate) fn text_of(path: &Path) -> Result<String, InputError> {
    std::fs::read_to_string(path)
        .map_err(|source| InputError::Unreadable { file: path.display().to_string(), source })
}

impl Columns {
    /// Parses a table with the columns `needed`, in any order, and of the `optional` ones some; `file`
    /// is what an error calls it.
    ///
    /// # Errors
    /// A column is missing, unknown or there twice; a row has too few or too many cells; there is no
    /// row.
    pub fn parse(
        text: &str,
        file: &str,
        needed: &[&str],
        optional: &[&str],
    ) -> Result<Self, InputError> {
        let malformed = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            InputError::line(file, line, "row", error, "a row of a CSV is needed")
        };
        let text = plain(text);
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let names = reader.headers().map_err(malformed)?.clone();
        let known = || needed.iter().chain(optional);
        let allowed =
            || format!("the columns are {}", known().copied().collect::<Vec<_>>().join(", "));
        for (place, name) in names.iter().enumerate() {
            let twice = names.iter().take(place).any(|earlier| earlier == name);
            if twice || !known().any(|known| *known == name) {
                let value = format!("`{name}`{}", if twice { " twice" } else { "" });
                return Err(InputError::line(file, 1, "header", value, allowed()));
            }
        }
        if let Some(missing) = needed.iter().find(|name| !names.iter().any(|n| n == **name)) {
            let value = format!("no column `{missing}`");
            return Err(InputError::line(file, 1, "header", value, allowed()));
        }
        let records: Vec<(u64, StringRecord)> = reader
            .records()
            .map(|record| {
                let record = record.map_err(malformed)?;
                Ok((record.position().map_or(0, csv::Position::line), record))
            })
            .collect::<Result<_, InputError>>()?;
        if records.is_empty() {
            return Err(InputError::value(file, "rows", 0, "at least one is needed"));
        }
        Ok(Self { file: file.into(), names, records })
    }

    /// Whether it has the optional column `name`.
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|column| column == name)
    }

    /// Its rows.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.records.iter().map(|(line, cells)| Row { table: self, line: *line, cells })
    }
}

impl Row<'_> {
    /// The cell in the column `name`; empty if there is no such column.
    pub fn text(&self, name: &str) -> &str {
        let place = self.table.names.iter().position(|column| column == name);
        place.and_then(|place| self.cells.get(place)).unwrap_or_default()
    }

    /// The cell in the column `name`, which has to be a name.
    pub fn name(&self, name: &str) -> Result<&str, InputError> {
        match self.text(name) {
            "" => Err(self.refuse(name, "empty", "a name is needed")),
            text => Ok(text),
        }
    }

    /// The number in the column `name`, which has to be `allowed`, in words `needed`.
    pub fn number(
        &self,
        name: &str,
        allowed: impl Fn(f64) -> bool,
        needed: &str,
    ) -> Result<f64, InputError> {
        let number = self.text(name).parse().ok();
        number.filter(|n: &f64| n.is_finite() && allowed(*n)).ok_or_else(|| {
            self.refuse(name, format!("`{}`", self.text(name)), format!("{needed} is needed"))
        })
    }

    /// The count in the column `name`.
    pub fn count(&self, name: &str) -> Result<u64, InputError> {
        let count = self.text(name).parse().ok().filter(|count| *count <= MOST);
        count.ok_or_else(|| {
            let needed = format!("a whole number from 0 to {MOST} is needed");
            self.refuse(name, format!("`{}`", self.text(name)), needed)
        })
    }

    /// Why the column `name` of this row is refused.
    pub fn refuse(
        &self,
        name: &str,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> InputError {
        InputError::line(&self.table.file, self.line, name, value, allowed)
    }
}

/// The largest count; sums of counts keep well within 64 bits.
const MOST: u64 = 1_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        let table = match Columns::parse(text, "t.csv", &["model", "speed"], &["note"]) {
            Ok(table) => table,
            Err(error) => return error.to_string(),
        };
        let check = |row: Row| {
            row.name("model")?;
            row.number("speed", |speed| speed > 0.0, "a number above 0")?;
            row.count("note")
        };
        table.rows().find_map(|row| check(row).err()).unwrap().to_string()
    }

    #[test]
    fn rows_are_read_by_name() {
        let text = "# made up\nspeed, model\n2.5,bunny\n";
        let table = Columns::parse(text, "t.csv", &["model", "speed"], &["note"]).unwrap();
        let row = table.rows().next().unwrap();
        assert_eq!((row.name("model").unwrap(), row.text("note")), ("bunny", ""));
        assert_eq!(row.number("speed", |_| true, "a number").unwrap(), 2.5);
        assert!(!table.has("note"));
    }

    #[test]
    fn bad_tables_are_refused_by_name() {
        for (text, expected) in [
            (
                "model\nbunny\n",
                "t.csv: line 1: header: no column `speed`: the columns are model, speed, note",
            ),
            ("model,speed,sped\n", "t.csv: line 1: header: `sped`: the columns are"),
            ("model,speed,model\n", "t.csv: line 1: header: `model` twice: the columns"),
            ("model,speed\n", "t.csv: rows: 0: at least one"),
            ("model,speed\nbunny\n", "t.csv: line 2: row: "),
            ("model,speed\n,2\n", "t.csv: line 2: model: empty: a name is needed"),
            (
                "model,speed\nbunny,fast\n",
                "t.csv: line 2: speed: `fast`: a number above 0 is needed",
            ),
            ("model,speed\nbunny,inf\n", "t.csv: line 2: speed: `inf`: a number above 0 is needed"),
            ("model,speed,note\nbunny,1,-1\n", "t.csv: line 2: note: `-1`: a whole number from 0"),
            ("", "t.csv: line 1: header: no column `model`"),
        ] {
            let error = error(text);
            assert!(error.starts_with(expected), "{text:?} gave {error}");
        }
    }
}
