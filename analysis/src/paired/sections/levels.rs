//! The section on preferences per level.

use super::{BENJAMINI_HOCHBERG, HOLM, corrected_cells, corrected_columns, not_known, share};
use crate::maths::corrections::Corrected;
use crate::maths::proportion::Proportion;
use crate::outcome::Outcome;
use crate::paired::levels::Levels;
use crate::report::plot::{Axis, Dot, dots};
use crate::report::section::{
    Cell, Column, Figure, Kind, Section, Table, share_cells, share_columns,
};

/// Preferences per level of each axis.
pub fn levels(levels: &Outcome<Levels>) -> Section {
    let heading = "Preferences per level";
    let levels = match levels {
        Ok(levels) => levels,
        Err(reason) => return not_known(heading, reason),
    };
    let pairs = levels.alone.iter().map(|pair| {
        let what = format!("{} over {}", pair.level, pair.over);
        sentence(&what, "all else equal", &pair.proportion, &pair.corrected, levels.alone.len())
    });
    let shares = levels.shares.iter().map(|level| {
        let n = levels.shares.len();
        sentence(&level.level, "whatever else differs", &level.proportion, &level.corrected, n)
    });
    let never = levels
        .never_alone
        .iter()
        .map(|[level, over]| format!("{level} and {over} were never compared with all else equal"));
    Section {
        heading: heading.into(),
        sentences: pairs.chain(shares).chain(never).collect(),
        tables: vec![pair_table(levels), share_table(levels)],
        figures: vec![Figure {
            name: "levels".into(),
            caption: "How often each level was chosen, of all pairs that differ in its axis, with Wilson's \
                      95 % intervals. The line is at ½."
                .into(),
            svg: figure(levels),
        }],
        method: vec![
            "Levels of an axis are compared twice: in the pairs of stimuli that differ in this axis alone, \
             and in all pairs that differ in it, whatever else they differ in. p-values are exact and \
             two-sided, as they are and corrected for the number of tests in the table by Holm (1979) and \
             by Benjamini and Hochberg (1995). They count the answers of one observer as independent; the \
             model with observers as clusters does not."
                .into(),
        ],
        references: vec![BENJAMINI_HOCHBERG, HOLM],
    }
}

fn sentence(
    what: &str,
    how: &str,
    proportion: &Proportion,
    corrected: &Corrected,
    tests: usize,
) -> String {
    format!(
        "{what}, {how}: {}, {} (n = {} trials; two-sided, exact binomial; corrected for {tests} tests by \
         Holm: {})",
        share(proportion),
        proportion.p_binomial.equation(),
        proportion.trials,
        corrected.p_holm.equation()
    )
}

fn cells(first: &[&str], proportion: &Proportion, corrected: &Corrected) -> Vec<Cell> {
    let mut cells: Vec<Cell> = first.iter().map(|text| Cell::from(*text)).collect();
    cells.extend(share_cells(proportion));
    cells.extend(corrected_cells(corrected));
    cells
}

fn table(name: &str, caption: String, first: &[Column], rows: Vec<Vec<Cell>>) -> Table {
    let mut columns = first.to_vec();
    columns.extend(share_columns());
    columns.extend(corrected_columns());
    Table { name: name.into(), caption, columns, rows }
}

fn axis_column() -> Column {
    Column::new("axis", "axis", Kind::Text, "All levels of the axis.")
}

fn pair_table(levels: &Levels) -> Table {
    let columns = [
        axis_column(),
        Column::new("level", "level", Kind::Text, "The level chosen more often."),
        Column::new("over", "over", Kind::Text, "The other."),
    ];
    let caption = format!(
        "How often one level was chosen over another in pairs of stimuli that differ in this axis alone. \
         Intervals: 95 %. Tests against ½, corrected for {} tests.",
        levels.alone.len()
    );
    let rows = levels.alone.iter().map(|pair| {
        cells(&[&pair.axis, &pair.level, &pair.over], &pair.proportion, &pair.corrected)
    });
    table("levels-all-else-equal", caption, &columns, rows.collect())
}

fn share_table(levels: &Levels) -> Table {
    let columns = [axis_column(), Column::new("level", "level", Kind::Text, "The level.")];
    let caption = format!(
        "How often each level was chosen in all pairs of stimuli that differ in its axis. Intervals: \
         95 %. Tests against ½, corrected for {} tests.",
        levels.shares.len()
    );
    let rows = levels
        .shares
        .iter()
        .map(|level| cells(&[&level.axis, &level.level], &level.proportion, &level.corrected));
    table("levels", caption, &columns, rows.collect())
}

fn figure(levels: &Levels) -> String {
    let axis = Axis { title: "share".into(), range: [0.0, 1.0], logarithmic: false };
    let rows: Vec<Dot> = levels
        .shares
        .iter()
        .map(|level| Dot {
            label: level.level.clone(),
            value: Some(level.proportion.percent / 100.0),
            interval: Some(level.proportion.wilson_95),
        })
        .collect();
    dots("Preferences per level", &axis, &rows, &[0.5])
}
