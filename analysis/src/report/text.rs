//! The result as text for the terminal.

use super::labels::{common_levels, labels, letters};
use super::sentences::sentences;
use crate::analysis::Analysis;
use std::fmt::Write;

/// The ranking with votes, percentages and groups, then the tests, then what a reader has to know.
pub fn text(analysis: &Analysis) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_text(&mut out, analysis);
    out
}

fn write_text(out: &mut String, analysis: &Analysis) -> std::fmt::Result {
    let simulated = if analysis.simulated == Some(true) { "Simulated observers. " } else { "" };
    let common = common_levels(&analysis.items);
    let common = if common.is_empty() { common } else { format!(", all {common}") };
    writeln!(
        out,
        "{simulated}Paired comparison of t = {} stimuli{common} by n = {} observers: {} trials\n",
        analysis.items.len(),
        analysis.observers,
        analysis.trials
    )?;
    let labels = labels(&analysis.items);
    let width = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0).max(8);
    writeln!(out, "rank  {:width$}  votes  percent  95 % interval   groups", "stimulus")?;
    for (rank, (label, preference)) in labels.iter().zip(&analysis.preference).enumerate() {
        let groups = match &analysis.grouping {
            Some(grouping) => letters(&preference.item, &grouping.groups),
            None => "–".into(),
        };
        let share = &preference.proportion;
        let [low, high] = share.wilson_95.map(|bound| 100.0 * bound);
        writeln!(
            out,
            "{:>4}  {label:width$}  {:>5}  {:>7.1}  {low:>5.1} to {high:>5.1}  {groups}",
            rank + 1,
            share.chosen,
            share.percent,
        )?;
    }
    writeln!(out, "\nStimuli that share a letter are one group. Intervals are Wilson's.\n")?;
    for sentence in sentences(analysis) {
        writeln!(out, "{}", sentence.name)?;
        for result in sentence.results {
            writeln!(out, "  {result}")?;
        }
    }
    if !analysis.notes.is_empty() {
        writeln!(out, "\nNotes")?;
        for note in &analysis.notes {
            writeln!(out, "  {note}")?;
        }
    }
    Ok(())
}
