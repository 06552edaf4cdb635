//! A replication for people.

use super::{Line, Replication, Value, Verdict};
use crate::report::section::{Cell, Column, Kind, Section, Table};
use crate::report::terminal::{paragraph, row};

const HOW: &str = "Ours are the printed votes and counts, computed anew. A number agrees if it rounds to what was \
     printed. A printed ζ is that of a whole number of circular triads, a printed u that of a whole Σ, a percentage \
     that of a whole count; each is looked for.";

/// The lines of `replication` as one table.
pub fn section(replication: &Replication) -> Section {
    let text = |name: &str, title: &str, description: &str| {
        Column::new(name, title, Kind::Text, description)
    };
    let columns = vec![
        text("section", "section", "Section of the publication"),
        text("what", "what", "The number or conclusion"),
        text("published", "published", "As it was printed"),
        text("ours", "ours", "What the printed votes and counts give"),
        text(
            "verdict",
            "agree?",
            "agrees, conflict, unknown (ours does not follow) or not printed",
        ),
        text("note", "note", "Tests in full, reasons, readings"),
    ];
    let cells = |line: &Line| {
        vec![
            line.section.into(),
            line.what.as_str().into(),
            line.published.as_ref().map(Value::to_string).into(),
            line.ours.as_ref().ok().map(Value::to_string).into(),
            word(line.verdict).into(),
            note(line).map_or(Cell::Missing, Cell::Text),
        ]
    };
    let table = Table {
        name: format!("replication-{}", replication.name),
        caption: "Published and ours, line by line.".into(),
        columns,
        rows: replication.lines.iter().map(cells).collect(),
    };
    Section {
        heading: format!("{}: {}", replication.citation, replication.title),
        sentences: vec![tally(replication)],
        tables: vec![table],
        figures: Vec::new(),
        method: vec![HOW.into()],
        references: vec![
            "David, H. A. (1988). The Method of Paired Comparisons, 2nd edition. Griffin, London.",
            "Kendall, M. G. and Babington Smith, B. (1940). On the method of paired comparisons. \
             Biometrika 31, 324–345.",
        ],
    }
}

/// The lines of `replication` for the terminal.
pub fn text(replication: &Replication) -> String {
    const WIDTHS: [usize; 4] = [30, 24, 26, 8];
    let cells = |cells: [String; 4]| row(&cells, &WIDTHS, &[false; 4]);
    let mut out = format!("{}: {}\n", replication.citation, replication.title);
    out += &paragraph(&tally(replication), "");
    let mut before = "";
    for line in &replication.lines {
        if line.section != before {
            let head =
                [format!("§{}", line.section), "published".into(), "ours".into(), "agree?".into()];
            out += &format!("\n{}", cells(head));
            before = line.section;
        }
        out += &cells([
            line.what.clone(),
            line.published.as_ref().map_or("–".into(), Value::to_string),
            line.ours.as_ref().map_or("null".into(), Value::to_string),
            word(line.verdict).into(),
        ]);
        if let Some(note) = note(line) {
            out += &paragraph(&note, "      ");
        }
    }
    out.push('\n');
    out + &paragraph(HOW, "")
}

fn tally(replication: &Replication) -> String {
    let counts = replication.counts;
    format!(
        "{} lines: {} agree, {} conflict, {} do not follow from what was printed, {} were not printed",
        replication.lines.len(),
        counts.agrees,
        counts.conflict,
        counts.unknown,
        counts.not_printed
    )
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Agrees => "yes",
        Verdict::Conflict => "CONFLICT",
        Verdict::Unknown => "unknown",
        Verdict::NotPrinted => "–",
    }
}

/// The reason why ours is missing, and the note.
fn note(line: &Line) -> Option<String> {
    let reason = line.ours.as_ref().err().map(|reason| format!("null: {reason}."));
    match (reason, &line.note) {
        (Some(reason), Some(note)) => Some(format!("{reason} {note}")),
        (reason, note) => reason.or_else(|| note.clone()),
    }
}
