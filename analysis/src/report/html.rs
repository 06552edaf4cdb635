//! An analysis as one HTML page: styles and figures inside, no script, nothing from outside.

use super::ReportContext;
use super::document::Document;
use super::picture;
use super::section::{Cell, Column, Kind, Section, Table};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::collections::BTreeSet;

/// Rows of a table that the page shows; the file has them all.
const MOST_ROWS: usize = 150;

/// The page of `document`.
pub fn html(document: &Document, context: &ReportContext) -> String {
    let title = match document.simulated {
        true => format!("Simulated observers: {}", context.title),
        false => context.title.to_string(),
    };
    let (quality, results): (Vec<&Section>, Vec<&Section>) =
        document.sections.iter().partition(|section| section.heading == "Data quality");
    let mut figures = 0;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                h1 { (title) }
                p.lead { (document.lead) }
                @if document.simulated {
                    p.simulated { "The observers are simulated. This report checks the tool; it is no "
                        "finding about people." }
                }
                h2 { "Question" }
                @match &document.questions {
                    Ok(questions) => @for question in questions { blockquote { (question) } },
                    Err(reason) => p { "Not known: " (reason) },
                }
                h2 { "Design" }
                dl { @for (what, which) in &document.design { dt { (what) } dd { (which) } } }
                @for section in quality {
                    h2 { (section.heading) }
                    (body(section, document.simulated, &mut figures))
                }
                h2 { "Results" }
                (stimuli(document, context, &mut figures))
                @for section in &results {
                    h3 { (section.heading) }
                    (body(section, document.simulated, &mut figures))
                }
                h2 { "Method" }
                @for text in methods(&document.sections) { p { (symbols(text)) } }
                @let references: BTreeSet<&str> =
                    document.sections.iter().flat_map(|s| &s.references).copied().collect();
                ul.references { @for reference in references { li { (reference) } } }
                h2 { "Notes" }
                ul { @for note in &document.notes { li { (symbols(note)) } } }
                h2 { "How this report was made" }
                dl {
                    dt { "Command" } dd { code { (context.command) } }
                    dt { "Version" } dd { (context.version) }
                }
            }
        }
    };
    page.into_string()
}

/// What the sections say of their methods, each text once.
fn methods(sections: &[Section]) -> Vec<&str> {
    let mut texts: Vec<&str> = Vec::new();
    for text in sections.iter().flat_map(|section| &section.method) {
        if !texts.contains(&text.as_str()) {
            texts.push(text);
        }
    }
    texts
}

fn body(section: &Section, simulated: bool, figures: &mut usize) -> Markup {
    html! {
        @for sentence in &section.sentences { p { (symbols(sentence)) } }
        @for figure in &section.figures {
            figure {
                (PreEscaped(picture::standalone(&figure.svg, simulated)))
                (caption(&figure.caption, simulated, figures))
            }
        }
        @for table in &section.tables { (of_table(table)) }
    }
}

fn caption(text: &str, simulated: bool, figures: &mut usize) -> Markup {
    *figures += 1;
    let prefix = if simulated { "Simulated observers. " } else { "" };
    html! { figcaption { b { "Figure " (figures) ". " } (prefix) (symbols(text)) } }
}

fn stimuli(document: &Document, context: &ReportContext, figures: &mut usize) -> Markup {
    if !document.stimuli.iter().any(|(id, _)| context.thumbnails.contains_key(id)) {
        return html! {};
    }
    html! {
        figure {
            div.stimuli {
                @for (id, label) in &document.stimuli {
                    div {
                        @if let Some(png) = context.thumbnails.get(id) {
                            img src=(format!("data:image/png;base64,{}", STANDARD.encode(png))) alt=(label);
                        }
                        span { (label) }
                    }
                }
            }
            (caption("The stimuli.", document.simulated, figures))
        }
    }
}

fn of_table(table: &Table) -> Markup {
    let word = |column: &Column| (column.kind == Kind::Text).then_some("word");
    html! {
        div.table { table {
            caption { (symbols(&table.caption)) }
            thead { tr {
                @for column in &table.columns { th class=[word(column)] { (symbols(&column.title)) } }
            } }
            tbody {
                @for row in table.rows.iter().take(MOST_ROWS) {
                    tr {
                        @for (column, cell) in table.columns.iter().zip(row) {
                            td class=[word(column)] { (shown(cell, column.kind)) }
                        }
                    }
                }
            }
        } }
        @if table.rows.len() > MOST_ROWS {
            p.lead { "The first " (MOST_ROWS) " of " (table.rows.len()) " rows; all are in "
                (table.name) ".csv." }
        }
    }
}

/// A value as people read it.
fn shown(cell: &Cell, kind: Kind) -> String {
    match (cell, kind) {
        (Cell::Text(text), _) => text.clone(),
        (Cell::Integer(value), _) => value.to_string(),
        (Cell::Number(value), Kind::Number(decimals)) => format!("{value:.decimals$}"),
        (Cell::Number(value), _) => value.to_string(),
        (Cell::P(p), _) => p.to_string(),
        (Cell::Flag(value), _) => if *value { "yes" } else { "no" }.into(),
        (Cell::Missing, _) => "–".into(),
    }
}

/// `text` with the symbols R_c and d_max set with their subscripts.
fn symbols(text: &str) -> Markup {
    let set = |symbol: &str, base: &str, subscript: &str, text: &str| {
        text.replace(symbol, &format!("{base}<sub>{subscript}</sub>"))
    };
    // Escaped first; neither symbol holds a character that escaping changes.
    let escaped = html! { (text) }.into_string();
    PreEscaped(set("d_max", "d", "max", &set("R_c", "R", "c", &escaped)))
}
