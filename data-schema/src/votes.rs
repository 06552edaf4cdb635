//! Votes: how often each item of a paired-comparison experiment was chosen over another, summed
//! over all observers. CSV with the columns `item` and `votes`.

use crate::item_table::{self, TableError};
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

impl Votes {
    /// Reads the table at `path`. Lines that begin with `#` are comments.
    ///
    /// # Errors
    /// The file cannot be read; lacks the column `item` or `votes`; a count is not a whole number
    /// from 0; an item is empty or comes twice; there are fewer than two items.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        item_table::read(path, "votes", |text| text.parse().ok(), NEEDED).map(Self::new)
    }

    /// Parses a table; `file` is what an error calls it.
    ///
    /// # Errors
    /// As [`Votes::read`].
    pub fn parse(text: &str, file: &str) -> Result<Self, TableError> {
        item_table::parse(text, file, "votes", |text| text.parse().ok(), NEEDED).map(Self::new)
    }

    fn new(rows: Vec<(String, u64)>) -> Self {
        Self { rows: rows.into_iter().map(|(item, votes)| VoteRow { item, votes }).collect() }
    }
}

/// What a number of votes is.
const NEEDED: &str = "a whole number from 0";

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
