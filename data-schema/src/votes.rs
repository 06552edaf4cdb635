//! Votes: how often each item of a paired-comparison experiment was chosen over another, summed
//! over all observers. CSV with the columns `item` and `votes`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A table of votes, in the order of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Votes {
    /// Items and their votes; at least two, no item twice.
    pub rows: Vec<VoteRow>,
}

/// A row of a table of votes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct VoteRow {
    /// What was voted for.
    pub item: String,
    /// How often it was chosen over another item.
    pub votes: u64,
}

/// The table could not be read. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {what}")]
pub struct VotesError {
    file: String,
    what: String,
}

impl Votes {
    /// Reads the table at `path`. Lines that begin with `#` are comments.
    ///
    /// # Errors
    /// The file cannot be read; lacks the column `item` or `votes`; a count is not a whole number
    /// from 0; an item is empty or comes twice; there are fewer than two items.
    pub fn read(path: &Path) -> Result<Self, VotesError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &file),
            Err(error) => Err(VotesError { file, what: format!("cannot be read: {error}") }),
        }
    }

    /// Parses a table; `file` is what an error calls it.
    ///
    /// # Errors
    /// As [`Votes::read`].
    pub fn parse(text: &str, file: &str) -> Result<Self, VotesError> {
        let fail = |what: String| VotesError { file: file.into(), what };
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let headers = reader.headers().map_err(|e| fail(e.to_string()))?.clone();
        let column = |name: &str| {
            headers.iter().position(|header| header == name).ok_or_else(|| {
                let found = headers.iter().collect::<Vec<_>>().join(", ");
                fail(format!("column `{name}` is missing: found `{found}`, needed `item,votes`"))
            })
        };
        let (item_column, votes_column) = (column("item")?, column("votes")?);
        let mut rows: Vec<VoteRow> = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| fail(e.to_string()))?;
            let line = record.position().map_or(0, csv::Position::line);
            let (item, votes) = (&record[item_column], &record[votes_column]);
            let votes = votes.parse().map_err(|_| {
                fail(format!(
                    "line {line}: votes of `{item}`: `{votes}`: a whole number from 0 is needed"
                ))
            })?;
            if item.is_empty() {
                return Err(fail(format!("line {line}: item: empty: a name is needed")));
            }
            if rows.iter().any(|row| row.item == item) {
                return Err(fail(format!("line {line}: item: `{item}`: each item may come once")));
            }
            rows.push(VoteRow { item: item.into(), votes });
        }
        match rows.len() {
            0 | 1 => Err(fail(format!("{} items: at least two are needed", rows.len()))),
            _ => Ok(Self { rows }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_in_its_order() {
        let votes = Votes::parse("# source\nitem,votes\nA5,59\nA1, 8\n", "t").unwrap();
        assert_eq!(votes.rows[1], VoteRow { item: "A1".into(), votes: 8 });
    }

    #[test]
    fn bad_tables_are_refused_by_name() {
        for (text, expect) in [
            ("item,count\nA,1\n", "t.csv: column `votes` is missing: found `item, count`"),
            ("item,votes\nA,-1\nB,2\n", "t.csv: line 2: votes of `A`: `-1`"),
            ("item,votes\nA,1.5\nB,2\n", "t.csv: line 2: votes of `A`: `1.5`"),
            ("item,votes\nA,1\nA,2\n", "t.csv: line 3: item: `A`"),
            ("item,votes\n,1\n", "t.csv: line 2: item: empty"),
            ("item,votes\nA,1\n", "t.csv: 1 items"),
            ("item,votes\nA\n", "t.csv: "),
            ("", "t.csv: column `item` is missing"),
        ] {
            let error = Votes::parse(text, "t.csv").unwrap_err().to_string();
            assert!(error.starts_with(expect), "{text:?} gave {error}");
        }
    }
}
