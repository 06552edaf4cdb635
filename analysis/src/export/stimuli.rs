//! The stimuli of a study: their ids, taken apart into the levels of the grid's axes.

use super::study::Study;
use super::table::{Table, column_of_levels};
use serde_json::{Value, json};
use std::collections::BTreeSet;

impl Study {
    /// The stimuli that were asked about, with a column for each axis: under its name where the
    /// protocol tells it, else as `axis_1`, `axis_2`, …, by its place in the id. There is none if the ids
    /// do not have equally many parts.
    pub(super) fn stimuli(&self) -> Table {
        let ids: BTreeSet<&str> = self
            .rows()
            .flat_map(|row| [row.stimulus_a.as_str(), row.stimulus_b.as_str()])
            .collect();
        let parts: Vec<Vec<&str>> = ids.iter().map(|id| id.split('-').collect()).collect();
        let mut fields = vec![json!({
            "name": "stimulus", "type": "string", "constraints": { "required": true },
            "description": "Id of the stimulus, as in the columns of the answers: its levels, joined in the order of the axes.",
        })];
        let width = parts[..].first().map_or(0, Vec::len);
        let alike = parts.iter().all(|parts| parts.len() == width);
        if alike {
            fields.extend((0..width).map(|place| self.axis(place, &parts)));
        }
        let row = |(id, parts): (&&str, &Vec<&str>)| {
            let levels = parts.iter().filter(|_| alike);
            std::iter::once(id).chain(levels).map(ToString::to_string).collect()
        };
        let rows = ids.iter().zip(&parts).map(row).collect();
        let schema = json!({ "fields": fields, "primaryKey": ["stimulus"], "missingValues": [""] });
        self.stamped(Table { schema, rows })
    }

    /// The column of the axis whose levels are at `place` in the ids that have these `parts`.
    fn axis(&self, place: usize, parts: &[Vec<&str>]) -> Value {
        let found: BTreeSet<&str> = parts.iter().map(|parts| parts[place]).collect();
        let shares = |levels: &[String]| levels.iter().any(|level| found.contains(&level[..]));
        let mut named = self.protocol.stimuli.iter().filter(|(_, levels)| shares(levels));
        match (named.next(), named.next()) {
            (Some((axis, order)), None) => {
                // Practice and catch stimuli may have levels that the protocol does not list.
                let others =
                    found.iter().filter(|level| !order.iter().any(|known| known == **level));
                let levels: Vec<&str> =
                    order.iter().map(String::as_str).chain(others.copied()).collect();
                column_of_levels(axis, &format!("Level of the axis {axis}."), &levels)
            }
            _ => {
                let name = format!("axis_{}", place + 1);
                let levels: Vec<&str> = found.into_iter().collect();
                column_of_levels(
                    &name,
                    "Level of an axis that the protocol does not name.",
                    &levels,
                )
            }
        }
    }
}
