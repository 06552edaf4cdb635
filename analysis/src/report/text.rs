//! An analysis as text for the terminal.

use super::document::Document;
use super::terminal::paragraph;

/// The results in short, then every part in sentences, then what a reader has to know.
pub fn text(document: &Document) -> String {
    let simulated = if document.simulated { "Simulated observers. " } else { "" };
    let mut parts = vec![format!("{simulated}{}", document.lead)];
    if !document.summary.is_empty() {
        parts.push(document.summary.clone());
    }
    let said = document.sections.iter().filter(|section| !section.sentences.is_empty());
    let said = said.map(|section| list(&section.heading, &section.sentences));
    parts.push(said.collect::<Vec<_>>().join("\n\n"));
    if !document.notes.is_empty() {
        parts.push(list("Notes", &document.notes));
    }
    parts.join("\n\n")
}

fn list(heading: &str, lines: &[String]) -> String {
    let lines: String = lines.iter().map(|line| paragraph(line, "  ")).collect();
    format!("{heading}\n{}", lines.trim_end())
}
