//! Reading answers by level: a CSV `level,chosen,trials`, with a column `observer` where each observer
//! has rows of their own.

use super::bootstrap::pooled;
use super::fit::Level;
use crate::error::InputError;
use crate::input::columns::{Columns, text_of};
use std::collections::BTreeMap;
use std::path::Path;

/// Answers by level.
#[derive(Clone, Debug, PartialEq)]
pub struct Answers {
    /// The answers of all observers together, in the order of the levels.
    pub levels: Vec<Level>,
    /// The answers of each observer, if the table tells them apart.
    pub observers: Option<Vec<Vec<Level>>>,
}

/// Reads the table at `path`.
///
/// # Errors
/// The file cannot be read, or as [`parse`].
pub fn read(path: &Path) -> Result<Answers, InputError> {
    parse(&text_of(path)?, &path.display().to_string())
}

/// Parses a table; `file` is what an error calls it.
///
/// # Errors
/// A column is missing or unknown; a level is no number; more answers than trials; a level comes twice
/// (for one observer).
pub fn parse(text: &str, file: &str) -> Result<Answers, InputError> {
    let table = Columns::parse(text, file, &["level", "chosen", "trials"], &["observer"])?;
    let mut observers: BTreeMap<&str, Vec<Level>> = BTreeMap::new();
    let rows: Vec<_> = table.rows().collect();
    for row in &rows {
        let level = row.number("level", |_| true, "a number")?;
        let (chosen, trials) = (row.count("chosen")?, row.count("trials")?);
        if chosen > trials {
            return Err(row.refuse("chosen", chosen, format!("at most the {trials} trials")));
        }
        let observer = if table.has("observer") { row.name("observer")? } else { "" };
        let levels = observers.entry(observer).or_default();
        if levels.iter().any(|other| other.level == level) {
            return Err(row.refuse("level", level, "each level may come once (for each observer)"));
        }
        levels.push(Level { level, chosen, trials });
    }
    let observers: Vec<Vec<Level>> = observers.into_values().collect();
    Ok(Answers {
        levels: pooled(&observers.concat()),
        observers: table.has("observer").then_some(observers),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn observers_are_kept_and_pooled() {
        let text = "observer,level,chosen,trials\nb,2,3,5\na,1,0,4\na,2,4,4\n";
        let answers = parse(text, "t").unwrap();
        assert_eq!(answers.levels[1], Level { level: 2.0, chosen: 7, trials: 9 });
        assert_eq!(answers.observers.unwrap().len(), 2);
        assert_eq!(parse("level,chosen,trials\n1,0,4\n", "t").unwrap().observers, None);
    }

    #[test]
    fn bad_tables_are_refused_by_name() {
        for (text, expected) in [
            ("level,chosen,trials\n1,5,4\n", "t.csv: line 2: chosen: 5: at most the 4 trials"),
            (
                "level,chosen,trials\n1,1,4\n1,1,4\n",
                "t.csv: line 3: level: 1: each level may come once",
            ),
            ("level,chosen,trials,observer\n1,1,4,\n", "t.csv: line 2: observer: empty"),
            ("level,chosen\n", "t.csv: line 1: header: no column `trials`"),
        ] {
            let error = parse(text, "t.csv").unwrap_err().to_string();
            assert!(error.starts_with(expected), "{text:?} gave {error}");
        }
    }
}
