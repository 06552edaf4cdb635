//! Reading the table of choices of pwcmp (Perez-Ortiz and Mantiuk 2017, arXiv:1712.03686): CSV with a
//! row per trial, in which conditions are compared within scenes. What it does not tell is which of
//! the two was shown first.

use super::choices::{Asked, gather};
use super::preferences::{Choice, Observer, Preferences, check_items};
use crate::error::InputError;
use shutterlab_data_schema::item_table::plain;
use shutterlab_data_schema::response::Side;
use shutterlab_data_schema::study::StudyKind;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The columns. `session_id` and `criterion` may be missing.
pub(crate) const COLUMNS: [&str; 7] =
    ["observer", "session_id", "scene", "condition_A", "condition_B", "is_A_selected", "criterion"];

/// The choices among the conditions of one scene by one criterion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// What was asked; empty if the table does not say it.
    pub criterion: String,
    /// Whether it is an export of simulated answers.
    pub simulated: bool,
    /// The choices, in the order of the table; at least one.
    pub choices: Vec<RawChoice>,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawChoice {
    /// Who chose.
    pub observer: String,
    /// In which session; empty if the table does not say it.
    pub session: String,
    /// Condition A.
    pub a: String,
    /// Condition B, another one.
    pub b: String,
    /// Whether A was chosen, not B.
    pub a_selected: bool,
    /// The line of the table, from 1.
    pub line: u64,
}

impl Scene {
    /// The choices as an analysis takes them. The k-th answer of an observer to a pair in one session
    /// belongs to the observer's k-th set of pairs.
    ///
    /// # Errors
    /// There are too many conditions.
    pub fn preferences(&self) -> Result<Preferences, InputError> {
        fn sorted<'a>(names: impl Iterator<Item = &'a String>) -> Vec<String> {
            names.collect::<BTreeSet<_>>().into_iter().cloned().collect()
        }
        // Every name is in the sorted list that it is looked for in.
        let place = |names: &[String], name: &String| names.partition_point(|other| other < name);
        let items = sorted(self.choices.iter().flat_map(|choice| [&choice.a, &choice.b]));
        check_items(items.len(), &self.name)?;
        let codes = sorted(self.choices.iter().map(|choice| &choice.observer));
        let sessions = sorted(self.choices.iter().map(|choice| &choice.session));
        let mut times: BTreeMap<[usize; 4], u32> = BTreeMap::new();
        let answers = self.choices.iter().map(|raw| {
            let (a, b) = (place(&items, &raw.a), place(&items, &raw.b));
            let observer = place(&codes, &raw.observer);
            let session = place(&sessions, &raw.session);
            let repetition = times.entry([observer, session, a.min(b), a.max(b)]).or_default();
            *repetition += 1;
            let chosen = Some(if raw.a_selected { Side::A } else { Side::B });
            Asked {
                session: session as u32 + 1,
                repetition: *repetition,
                choice: Choice { observer, a, b, chosen, first: None },
            }
        });
        let answers = answers.collect();
        let observers = codes.into_iter().map(|code| Observer { code, traits: BTreeMap::new() });
        let (mut preferences, _) = gather(items, observers.collect(), answers);
        preferences.simulated = self.simulated.then_some(true);
        Ok(preferences)
    }
}

/// Whether a CSV that begins as `text` is one of pwcmp.
pub fn is_pwcmp(text: &str) -> bool {
    let header = text.lines().next().unwrap_or_default();
    ["condition_A", "condition_B", "is_A_selected"].iter().all(|column| {
        header.split(',').any(|name| name.trim_matches(['"', ' ', '\u{feff}', '\r']) == *column)
    })
}

/// Reads the table at `path`.
///
/// # Errors
/// The file cannot be read, or as [`parse`].
pub fn read(path: &Path) -> Result<Vec<Scene>, InputError> {
    let file = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => parse(&text, &file),
        Err(source) => Err(InputError::Unreadable { file, source }),
    }
}

/// Parses a table; `file` is what an error calls it. Scenes come in alphabetical order.
///
/// # Errors
/// A column is missing; a cell that is needed is empty; a condition is compared with itself;
/// `is_A_selected` is neither 1 nor 0; there are no rows.
pub fn parse(text: &str, file: &str) -> Result<Vec<Scene>, InputError> {
    let malformed = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        InputError::line(file, line, "row", error, "a row of a CSV is needed")
    };
    let text = plain(text);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(malformed)?.clone();
    let place = |column: &str| header.iter().position(|name| name == column);
    let [observer, session, scene, a, b, selected, criterion] = COLUMNS.map(place);
    let needed = |place: Option<usize>, column: &str| {
        let found = header.iter().collect::<Vec<_>>().join(",");
        let allowed = format!("a column `{column}` is needed, as in `{}`", COLUMNS.join(","));
        place.ok_or_else(|| InputError::line(file, 1, "header", format!("`{found}`"), allowed))
    };
    let observer = needed(observer, "observer")?;
    let scene = needed(scene, "scene")?;
    let (a, b) = (needed(a, "condition_A")?, needed(b, "condition_B")?);
    let selected = needed(selected, "is_A_selected")?;

    let mut scenes: BTreeMap<(String, String), Vec<RawChoice>> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(malformed)?;
        let line = record.position().map_or(0, csv::Position::line);
        let optional = |place: Option<usize>| place.map_or("", |place| &record[place]).to_string();
        if let Some(place) = [observer, scene, a, b].into_iter().find(|at| record[*at].is_empty()) {
            return Err(InputError::line(file, line, &header[place], "empty", "a name is needed"));
        }
        if record[a] == record[b] {
            let value = format!("`{}`", &record[b]);
            let allowed = "another condition than condition_A is needed";
            return Err(InputError::line(file, line, "condition_B", value, allowed));
        }
        let a_selected = match &record[selected] {
            "1" => true,
            "0" => false,
            other => {
                let (value, allowed) = (format!("`{other}`"), "1 or 0 is needed");
                return Err(InputError::line(file, line, "is_A_selected", value, allowed));
            }
        };
        let choice = RawChoice {
            observer: record[observer].into(),
            session: optional(session),
            a: record[a].into(),
            b: record[b].into(),
            a_selected,
            line,
        };
        scenes.entry((record[scene].into(), optional(criterion))).or_default().push(choice);
    }
    if scenes.is_empty() {
        return Err(InputError::value(file, "rows", "none", "at least one choice is needed"));
    }
    let banner = StudyKind::Simulated.banner().unwrap_or_default();
    let scene = |((name, criterion), choices): ((String, String), Vec<RawChoice>)| Scene {
        name,
        simulated: criterion.starts_with(banner),
        criterion,
        choices,
    };
    Ok(scenes.into_iter().map(scene).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str =
        "observer,session_id,scene,condition_A,condition_B,is_A_selected,criterion\n";

    #[test]
    fn choices_are_parted_by_scene_and_criterion() {
        let rows = "P1,1,hall,x,y,1,noise\nP1,1,attic,x,z,0,noise\nP2,2,hall,y,x,0,noise\n\
                    P2,2,hall,y,x,0,blur\n";
        let scenes = parse(&format!("{HEADER}{rows}"), "p.csv").unwrap();
        let found: Vec<(&str, &str, usize)> = scenes
            .iter()
            .map(|scene| (&*scene.name, &*scene.criterion, scene.choices.len()))
            .collect();
        assert_eq!(found, [("attic", "noise", 1), ("hall", "blur", 1), ("hall", "noise", 2)]);
        let last = scenes[2].choices.last().unwrap();
        assert_eq!((&*last.observer, &*last.session, last.line), ("P2", "2", 4));
        assert!(!last.a_selected && scenes.iter().all(|scene| !scene.simulated));
    }

    #[test]
    fn columns_may_stand_in_any_order_and_two_may_be_missing() {
        let text = "is_A_selected, condition_B,condition_A,scene,observer\n1,y,x,hall,7\n";
        assert!(is_pwcmp(text) && !is_pwcmp("item,votes\n"));
        let scenes = parse(text, "p.csv").unwrap();
        let RawChoice { observer, session, a, b, a_selected, .. } = &scenes[0].choices[0];
        assert_eq!((&**observer, &**session, &**a, &**b, *a_selected), ("7", "", "x", "y", true));
    }

    #[test]
    fn bad_tables_are_refused_by_name() {
        for (rows, expect) in [
            ("P1,1,hall,x,y,2,q\n", "p.csv: line 2: is_A_selected: `2`: 1 or 0 is needed"),
            ("P1,1,hall,x,x,1,q\n", "p.csv: line 2: condition_B: `x`: another condition"),
            (",1,hall,x,y,1,q\n", "p.csv: line 2: observer: empty: a name is needed"),
            ("P1,1,hall,x,y,1\n", "p.csv: line 2: row: "),
            ("", "p.csv: rows: none: at least one choice is needed"),
        ] {
            let error = parse(&format!("{HEADER}{rows}"), "p.csv").unwrap_err().to_string();
            assert!(error.starts_with(expect), "{rows:?} gave {error}");
        }
        let error = parse("observer,scene\nP1,hall\n", "p.csv").unwrap_err().to_string();
        assert!(error.starts_with("p.csv: line 1: header: `observer,scene`: a column"), "{error}");
    }
}
